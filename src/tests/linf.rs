//! L∞ cells: they fill the domain whatever the sites, and hold the points nearest to their site.

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::domain::shape::DomainShape;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::random::Random;
use crate::tests::sites::{grid_sites, random_sites};
use crate::voronoi::diagram::{Diagram, DiagramError};
use crate::voronoi::linf::cell::{Fragment, LinfCell, Ties};
use nalgebra::{Point3, Vector3};

fn cuboid(max: [f64; 3], periodic: [bool; 3]) -> Cuboid {
    Cuboid::new(Bounds::from_corners([0.0; 3], max), periodic).expect("a box")
}

fn volumes(domain: &dyn Domain, sites: &[Point3<f64>]) -> Vec<f64> {
    let diagram = Diagram::new(domain, sites).expect("a diagram");
    let cells = diagram.map_linf(Ties::ToSmallerIndex, |(): &mut (), cell| cell.volume());
    cells.expect("no duplicates")
}

fn assert_filled(name: &str, domain: &dyn Domain, sites: &[Point3<f64>]) {
    let sum: f64 = volumes(domain, sites).iter().sum();
    let error = sum / domain.volume() - 1.0;
    assert!(error.abs() < 1e-12, "{name}: {error:e}");
}

fn jittered(count: usize, noise: f64) -> Vec<Point3<f64>> {
    let mut random = Random::new(3);
    let mut moved = |x: f64| (x + noise * (2.0 * random.uniform() - 1.0)).clamp(0.0, 1.0);
    let sites = grid_sites(count).into_iter();
    sites
        .map(|site| Point3::from(site.coords.map(&mut moved)))
        .collect()
}

#[test]
fn random_cells_fill_the_cube() {
    assert_filled("one", &Cuboid::unit(), &random_sites(1, 1));
    for (count, seed) in [(2, 1), (7, 2), (100, 3), (500, 4)] {
        assert_filled("random", &Cuboid::unit(), &random_sites(count, seed));
    }
}
