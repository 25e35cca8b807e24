//! Sites in the unit cube, and their Voronoi cells by brute force.

use crate::geometry::bounds::Bounds;
use crate::geometry::clip::{ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::random::Random;
use nalgebra::Point3;

pub(crate) fn random_sites(count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut random = Random::new(seed);
    let mut uniform = || random.uniform();
    (0..count)
        .map(|_| Point3::new(uniform(), uniform(), uniform()))
        .collect()
}

/// The centers of n³ equal cubes.
pub(crate) fn grid_sites(n: usize) -> Vec<Point3<f64>> {
    let middle = |k: usize| (k as f64 + 0.5) / n as f64;
    (0..n * n * n)
        .map(|k| Point3::new(middle(k % n), middle(k / n % n), middle(k / n / n)))
        .collect()
}

/// The cell of one of the sites in the unit cube.
pub(crate) fn cell(sites: &[Point3<f64>], site: usize) -> Polyhedron {
    let bounds = Bounds {
        min: Point3::origin(),
        max: Point3::new(1.0, 1.0, 1.0),
    };
    let mut cell = Polyhedron::cuboid(&bounds, [0; 6]);
    let mut scratch = ClipScratch::default();
    let here = sites[site].coords;
    for (other, place) in sites.iter().enumerate().filter(|(other, _)| *other != site) {
        let bisector = HalfSpace::bisector(place.coords - here).translated(&here);
        clip(&mut cell, &bisector, other as u64, &mut scratch);
    }
    cell
}
