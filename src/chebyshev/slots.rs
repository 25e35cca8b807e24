//! Preparing a piece straight from the fixed slots in which it was cut.
//!
//! What it comes to is the same, to the bit, as by way of a polyhedron.

use crate::chebyshev::integrand::{EdgeConstants, Integrand};
use crate::geometry::compact::{Compact, EDGES, SLOTS};
use crate::geometry::compact_lists::Lists;
use crate::geometry::half_space::HalfSpace;

impl Integrand {
    /// Prepares a convex piece of density 1, keeping the memory of the piece before.
    pub fn assign_compact(&mut self, piece: &Compact) {
        self.density = None;
        if piece.is_dense() {
            self.assign_dense(piece);
        } else {
            self.assign_sparse(piece);
        }
    }

    fn assign_sparse(&mut self, piece: &Compact) {
        let lists = Lists::of(piece);
        let axes = [&piece.x, &piece.y, &piece.z];
        self.vertices.gather(axes, lists.slots.listed());
        let planes = lists.planes.listed().iter();
        let planes = planes.map(|&plane| usize::from(plane));
        self.assign_facets(
            planes.clone().map(|plane| &piece.planes[plane]),
            planes.map(|plane| &piece.labels[plane]),
        );
        self.at_vertices.assign_sparse(piece, &lists);
        self.assign_edges(piece, |[ends, sides]| {
            [
                ends.map(|slot| u32::from(lists.vertices[slot])),
                sides.map(|plane| u32::from(lists.facets[plane])),
            ]
        });
    }

    /// Slots are vertices, and planes are facets.
    fn assign_dense(&mut self, piece: &Compact) {
        let count = piece.alive.count_ones() as usize;
        let axes = [&piece.x, &piece.y, &piece.z].map(<[f64; SLOTS]>::as_slice);
        self.vertices.assign(axes, count);
        self.copy_facets(piece.planes.iter(), piece.labels.iter());
        if !piece.are_units() {
            HalfSpace::normalize(&mut self.facets);
        }
        self.at_vertices.assign_dense(piece, count);
        self.assign_edges(piece, |pairs| {
            pairs.map(|pair| pair.map(|number| number as u32))
        });
    }

    /// Takes up the edges of `piece`; `numbered` gives the vertices and facets for slots and planes.
    #[inline(always)]
    fn assign_edges(
        &mut self,
        piece: &Compact,
        numbered: impl Fn([[usize; 2]; 2]) -> [[u32; 2]; 2],
    ) {
        let mut six_volumes = 0.0;
        piece.upward().for_each(|edge| {
            let [ends, sides] = neighborhood(piece, edge);
            let points = ends.map(|slot| piece.vertex(slot));
            let [vertices, facets] = numbered([ends, sides]);
            let (edge, volumes) = EdgeConstants::new(vertices, facets, points, &self.facets);
            self.edges.push(edge);
            six_volumes += volumes;
        });
        self.volume = six_volumes / 6.0;
    }
}

/// The slots at the ends of an edge, and the planes left and right of it.
#[inline(always)]
fn neighborhood(piece: &Compact, edge: usize) -> [[usize; 2]; 2] {
    let ends = [edge / 4, usize::from(piece.twins[edge % EDGES] / 4)];
    let sides = [edge + 1, edge].map(|side| usize::from(piece.facets[side % EDGES]));
    [ends.map(|slot| slot % SLOTS), sides]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bounds::Bounds;
    use crate::geometry::compact_clip::CompactScratch;
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
