//! Preparing a piece straight from the fixed slots in which it was cut.
//!
//! What it comes to is the same, to the bit, as by way of a polyhedron.

use crate::chebyshev::integrand::{EdgeConstants, FacetConstants, Integrand};
use crate::chebyshev::sight::Sight;
use crate::geometry::compact::{Compact, EDGES, SLOTS};
use crate::geometry::compact_lists::Lists;

impl Integrand {
    /// Prepares a convex piece of density 1, keeping the memory of the piece before.
    pub fn assign_compact(&mut self, piece: &Compact) {
        self.density = None;
        let lists = Lists::of(piece);
        self.vertices.clear();
        let slots = lists.slots.listed().iter();
        self.vertices.extend(slots.map(|&slot| {
            let slot = usize::from(slot) % SLOTS;
            Sight::new(piece.x[slot], piece.y[slot], piece.z[slot])
        }));
        let planes = lists.planes.listed();
        self.facets.clear();
        let facets = planes
            .iter()
            .map(|&plane| &piece.planes[usize::from(plane)]);
        self.facets.extend(facets.map(FacetConstants::new));
        self.labels.clear();
        let labels = planes.iter().map(|&plane| piece.labels[usize::from(plane)]);
        self.labels.extend(labels);
        let (mut six_volumes, facets) = (0.0, &self.facets);
        self.edges.clear();
        self.edges.extend(lists.edges.listed().iter().map(|&edge| {
            let constants = edge_constants(piece, &lists, facets, usize::from(edge));
            six_volumes += constants.six_volumes(facets);
            constants
        }));
        self.volume = six_volumes / 6.0;
    }
}

/// The constants of an edge that leaves its slot.
#[inline(always)]
fn edge_constants(
    piece: &Compact,
    lists: &Lists,
    facets: &[FacetConstants],
    edge: usize,
) -> EdgeConstants {
    let ends = [edge / 4, usize::from(piece.twins[edge % EDGES] / 4)];
    let sides = [(edge + 1) % EDGES, edge % EDGES];
    let [left, right] = sides.map(|side| lists.facets[usize::from(piece.facets[side])]);
    let [a, b] = ends.map(|slot| piece.vertex(slot % SLOTS));
    let [from, to] = ends.map(|slot| lists.vertices[slot % SLOTS]);
    EdgeConstants::new(
        [from, to].map(u32::from),
        [left, right].map(u32::from),
        [a, b],
        facets,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bounds::Bounds;
    use crate::geometry::compact_clip::CompactScratch;
    use crate::geometry::half_space::HalfSpace;
    use crate::geometry::polyhedron::Polyhedron;
    use nalgebra::{Point3, Vector3};

    #[test]
    fn slots_give_the_integrand_of_the_polyhedron() {
        let corner = Point3::new(1.0, 1.0, 1.0);
        let bounds = Bounds {
            min: -corner,
            max: corner,
        };
        let mut compact = Compact::default();
        assert!(compact.assign(&Polyhedron::cuboid(&bounds, [1, 2, 3, 4, 5, 6])));
        let (mut straight, mut polyhedron) = (Integrand::default(), Polyhedron::default());
        for number in 0..40 {
            let turn = f64::from(number);
            let away = Vector3::new((2.3 * turn).sin(), (3.7 * turn).cos(), (1.9 * turn).sin());
            let bisector = HalfSpace::bisector(away.normalize() * (1.8 - 0.02 * turn));
            let scratch = &mut CompactScratch::default();
            compact
                .clip(&bisector, || 7 + number as u64, scratch)
                .unwrap();
            straight.assign_compact(&compact);
            compact.write(&mut polyhedron);
            let detour = Integrand::new(&polyhedron);
            assert_eq!(format!("{straight:?}"), format!("{detour:?}"));
        }
        assert!(polyhedron.planes.len() < 46 && straight.volume() > 0.0);
    }
}
