//! The ten moments of tetrahedra with one constant density each.

use nalgebra::Point3;

use crate::arrays::MapEach;
use crate::geometry::moments::Moments;
use crate::integrals::lanes::{CONSTANT, Lanes, Sums, WIDTH, gathered, named, six_volumes, splat};
use crate::integrals::pairwise::sum_by_halves;

/// The moments, measured from `origin`; `densities` has one value per tetrahedron.
///
/// # Panics
///
/// If a tetrahedron names a vertex, or lacks a density, that is not there.
#[must_use]
pub(crate) fn of_cells(
    vertices: &[Point3<f64>],
    tets: &[[u32; 4]],
    densities: &[f64],
    origin: &Point3<f64>,
) -> Moments {
    let apex = splat(origin);
    sum_by_halves(tets.len(), &|range| {
        let mut sums = Sums::default();
        let blocks = tets[range.clone()].chunks(WIDTH);
        for (block, densities) in blocks.zip(densities[range].chunks(WIDTH)) {
            let corners = named(block).map_each(|named| gathered(vertices, named, &apex));
            let mut lanes = [0.0; WIDTH];
            lanes[..densities.len()].copy_from_slice(densities);
            sums.add_constant(six_volumes(&corners) * Lanes::from(lanes), &corners);
        }
        sums.moments(CONSTANT)
    })
}
