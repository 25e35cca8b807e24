//! Preparing a piece straight from the fixed slots in which it was cut.
//!
//! What it comes to is the same, to the bit, as by way of a polyhedron.

use std::fmt;

use crate::chebyshev::integrand::Integrand;
use crate::geometry::brep::Edge;
use crate::geometry::small_polyhedron::Lists;
use crate::geometry::small_polyhedron::{EDGES, ROW, SLOTS, SmallPolyhedron};

impl Integrand {
    /// Prepares a convex piece of density 1, keeping the memory of the piece before.
    pub fn assign_compact(&mut self, piece: &SmallPolyhedron) {
        self.density = None;
        if piece.is_dense() {
            self.assign_dense(piece);
        } else {
            self.assign_sparse(piece);
        }
    }

    fn assign_sparse(&mut self, piece: &SmallPolyhedron) {
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
                ends.map(|slot| u32::from(lists.vertices[usize::from(slot) % SLOTS])),
                sides.map(|plane| u32::from(lists.facets[usize::from(plane)])),
            ]
        });
    }

    /// Slots are vertices, and planes are facets.
    fn assign_dense(&mut self, piece: &SmallPolyhedron) {
        let count = piece.alive.count_ones() as usize;
        let axes = [&piece.x, &piece.y, &piece.z];
        self.vertices.assign_axes(axes, count);
        self.copy_facets(piece.planes.iter(), piece.labels.iter());
        self.facets.normalize();
        self.at_vertices.assign_dense(piece, count);
        self.assign_edges(piece, |pairs| pairs.map(|pair| pair.map(u32::from)));
    }

    /// Takes up the edges of `piece`; `numbered` gives the vertices and facets for slots and planes.
    #[inline(always)]
    fn assign_edges(
        &mut self,
        piece: &SmallPolyhedron,
        numbered: impl Fn([[u8; 2]; 2]) -> [[u32; 2]; 2],
    ) {
        let Words(words) = &mut self.words;
        fill_words(words, piece);
        let edges = piece.upward().map(|edge| {
            let [from, to, left, right] = words[edge % EDGES].to_le_bytes();
            let [[from, to], [left, right]] = numbered([[from, to], [left, right]]);
            Edge {
                from,
                to,
                left,
                right,
            }
        });
        self.edges.assign(edges, SLOTS * 3 / 2);
    }
}

/// Memory to list edges.
#[derive(Clone)]
pub(crate) struct Words([u32; EDGES]);

impl Default for Words {
    fn default() -> Self {
        Self([0; EDGES])
    }
}

impl fmt::Debug for Words {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Words")
    }
}

/// Makes words, per edge, of the slots at its ends and the planes left and right of it.
#[inline(always)]
fn fill_words(words: &mut [u32; EDGES], piece: &SmallPolyhedron) {
    let used = 4 * (SLOTS - piece.alive.leading_zeros() as usize).next_multiple_of(ROW);
    let edges = piece
        .twins
        .iter()
        .zip(&piece.facets)
        .zip(&piece.facets[1..]);
    for (edge, (word, ((twin, right), left))) in words[..used].iter_mut().zip(edges).enumerate() {
        *word = u32::from_le_bytes([(edge / 4) as u8, twin / 4, *left, *right]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bounds::Bounds;
    use crate::geometry::half_space::HalfSpace;
    use crate::geometry::polyhedron::Polyhedron;
    use crate::geometry::small_polyhedron_clip::SmallClipScratch;
    use nalgebra::{Point3, Vector3};

    #[test]
    fn slots_give_the_integrand_of_the_polyhedron() {
        let corner = Point3::new(1.0, 1.0, 1.0);
        let bounds = Bounds {
            min: -corner,
            max: corner,
        };
        let mut compact = SmallPolyhedron::default();
        assert!(compact.assign(&Polyhedron::cuboid(&bounds, [1, 2, 3, 4, 5, 6])));
        let (mut straight, mut polyhedron) = (Integrand::default(), Polyhedron::default());
        for number in 0..40 {
            let turn = f64::from(number);
            let away = Vector3::new((2.3 * turn).sin(), (3.7 * turn).cos(), (1.9 * turn).sin());
            let bisector = HalfSpace::bisector(away.normalize() * (1.8 - 0.02 * turn));
            let scratch = &mut SmallClipScratch::default();
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
