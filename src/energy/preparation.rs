//! Conversion of convex polyhedra and boundary representations into prepared pieces.

use nalgebra::{Point3, Rotation3, Vector3};

use crate::arrays::MapEach;
use crate::energy::prepared::{Bits, CHUNK, EdgeWords, PreparedPiece};
use crate::geometry::brep::{Brep, Edge, Piece};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::small_polyhedron::Lists;
use crate::geometry::small_polyhedron::{EDGES, ROW, SLOTS, SmallPolyhedron};
use crate::integrals::polynomial::Polynomial;

/// Vertices, of three edges each, whose edges share one set of bits.
const VERTICES: usize = CHUNK / 3;

impl PreparedPiece {
    /// Prepares `piece`, for tests.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn new(piece: &Polyhedron) -> Self {
        let mut prepared = Self::default();
        prepared.assign(Piece::Convex(piece));
        prepared
    }

    /// Prepares `piece` of density 1, keeping the memory of the piece before.
    pub(crate) fn assign(&mut self, piece: Piece<'_>) {
        self.density = None;
        match piece {
            Piece::Convex(piece) => self.assign_convex(piece),
            Piece::Brep(piece) => self.assign_brep(piece),
        }
    }

    /// Prepares a convex piece of density 1 straight from the fixed slots in which it was cut, keeping
    /// the memory of the piece before. The result is, to the bit, the same as that for a polyhedron.
    pub(crate) fn assign_compact(&mut self, piece: &SmallPolyhedron) {
        self.density = None;
        if piece.is_dense() {
            self.assign_dense(piece);
        } else {
            self.assign_sparse(piece);
        }
    }

    /// Gives the piece a density, a polynomial in its coordinates; none is density 1.
    pub(crate) fn set_density(&mut self, density: Option<&Polynomial>) {
        self.density = density.cloned();
    }

    /// Turns the piece about the origin. A density would have to be turned too, and is not.
    pub(crate) fn rotate(&mut self, rotation: &Rotation3<f64>) {
        self.vertices.rotate(rotation);
        self.facets.rotate(rotation);
    }

    /// The positions of the vertices.
    pub(crate) fn vertices(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        let rows = self.vertices.iter();
        rows.map(|&[x, y, z, _]| Vector3::new(x, y, z).into())
    }

    fn assign_convex(&mut self, piece: &Polyhedron) {
        let points = piece.x.iter().zip(&piece.y).zip(&piece.z);
        (self.vertices).assign(points.map(|((x, y), z)| [*x, *y, *z, *x]));
        self.assign_facets(piece.planes.iter(), piece.labels.iter());
        let rows = (piece.facets.chunks(VERTICES)).zip(piece.next.chunks(VERTICES));
        let edges = rows.enumerate().flat_map(|(chunk, (facets, next))| {
            let first = (chunk * VERTICES) as u32;
            let (facets, ends) = (facets.as_flattened(), next.as_flattened());
            upward(next, first).map(move |number| {
                // The facet on the right is the one before, in turn.
                let (row, slot) = (number / 3, number % 3);
                let right = if slot == 0 { number + 2 } else { number - 1 };
                Edge::new(
                    [first + row as u32, ends[number]],
                    [facets[number], facets[right]],
                )
            })
        });
        self.edges.assign(edges, piece.facets.len() * 3 / 2);
    }

    /// A facet that is not convex or not connected is the signed sum of the triangles on its edges
    /// no less than a convex one, and so are its integrals.
    fn assign_brep(&mut self, piece: &Brep) {
        let vertices = piece.vertices.iter();
        (self.vertices).assign(vertices.map(|vertex| [vertex.x, vertex.y, vertex.z, vertex.x]));
        let (planes, labels) = (
            piece.facets.iter().map(|(plane, _)| plane),
            piece.facets.iter().map(|(_, label)| label),
        );
        self.assign_facets(planes, labels);
        (self.edges).assign(piece.edges.iter().copied(), piece.edges.len());
    }

    fn assign_sparse(&mut self, piece: &SmallPolyhedron) {
        let lists = Lists::of(piece);
        self.vertices.assign(lists.slots.numbers().map(|slot| {
            let [x, y, z] = [&piece.x, &piece.y, &piece.z].map_each(|axis| axis[slot % SLOTS]);
            [x, y, z, x]
        }));
        let planes = lists.planes.numbers();
        self.assign_facets(
            planes.clone().map(|plane| &piece.planes[plane]),
            planes.map(|plane| &piece.labels[plane]),
        );
        self.assign_edges(piece, |[ends, sides]| {
            [
                ends.map_each(|slot| u32::from(lists.vertices[usize::from(slot) % SLOTS])),
                sides.map_each(|plane| u32::from(lists.facets[usize::from(plane)])),
            ]
        });
    }

    /// As [`PreparedPiece::assign_sparse`] where slots are vertices, and planes are facets.
    fn assign_dense(&mut self, piece: &SmallPolyhedron) {
        let count = piece.alive.count_ones() as usize;
        (self.vertices).assign_axes([&piece.x, &piece.y, &piece.z], count);
        self.assign_facets(piece.planes.iter(), piece.labels.iter());
        self.assign_edges(piece, |pairs| {
            pairs.map_each(|pair| pair.map_each(u32::from))
        });
    }

    /// Copies the facets, with normals scaled to unit length except where they are zero.
    fn assign_facets<'a>(
        &mut self,
        planes: impl Iterator<Item = &'a HalfSpace>,
        labels: impl Iterator<Item = &'a Label>,
    ) {
        let row =
            |HalfSpace { normal, offset }: &HalfSpace| [normal.x, normal.y, normal.z, *offset];
        self.facets.assign(planes.map(row));
        self.facets.map(HalfSpace::units);
        self.labels.clear();
        self.labels.extend(labels);
    }

    /// Copies the edges of `piece`; `numbered` gives the vertices and facets for slots and planes.
    #[inline(always)]
    fn assign_edges(
        &mut self,
        piece: &SmallPolyhedron,
        numbered: impl Fn([[u8; 2]; 2]) -> [[u32; 2]; 2],
    ) {
        let EdgeWords(words) = &mut self.edge_words;
        fill_words(words, piece);
        let edges = piece.upward().map(|edge| {
            let [from, to, left, right] = words[edge % EDGES].to_le_bytes();
            let [ends, facets] = numbered([[from, to], [left, right]]);
            Edge::new(ends, facets)
        });
        self.edges.assign(edges, SLOTS * 3 / 2);
    }
}

/// Of the edges that leave [`VERTICES`] vertices from number `first` on, the numbers of those that lead
/// to a vertex of higher number.
#[inline]
fn upward(next: &[[u32; 3]], first: u32) -> Bits {
    let mut bits = 0;
    for (row, ends) in next.iter().take(VERTICES).enumerate() {
        let from = first + row as u32;
        let [a, b, c] = ends.map_each(|end| u64::from(from < end));
        bits |= (a | b << 1 | c << 2) << (3 * row);
    }
    Bits(bits)
}

/// Makes words, per edge, of the slots at its ends and the planes left and right of it.
#[inline(always)]
fn fill_words(words: &mut [u32; EDGES], piece: &SmallPolyhedron) {
    let used = 4 * (SLOTS - piece.alive.leading_zeros() as usize).next_multiple_of(ROW);
    let edges = (piece.twins.iter().zip(&piece.facets)).zip(&piece.facets[1..]);
    for (edge, (word, ((twin, right), left))) in words[..used].iter_mut().zip(edges).enumerate() {
        *word = u32::from_le_bytes([(edge / 4) as u8, twin / 4, *left, *right]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bounds::Bounds;
    use crate::geometry::small_polyhedron_clip::SmallClipScratch;

    #[test]
    fn slots_give_the_prepared_piece_of_the_polyhedron() {
        let corner = Point3::new(1.0, 1.0, 1.0);
        let bounds = Bounds {
            min: -corner,
            max: corner,
        };
        let mut compact = SmallPolyhedron::default();
        assert!(compact.assign(&Polyhedron::cuboid(&bounds, [1, 2, 3, 4, 5, 6])));
        let (mut prepared, mut polyhedron) = (PreparedPiece::default(), Polyhedron::default());
        for number in 0..40 {
            let turn = f64::from(number);
            let away = Vector3::new((2.3 * turn).sin(), (3.7 * turn).cos(), (1.9 * turn).sin());
            let bisector = HalfSpace::bisector(away.normalize() * (1.8 - 0.02 * turn));
            let scratch = &mut SmallClipScratch::default();
            compact
                .clip(&bisector, || 7 + number as u64, scratch)
                .unwrap();
            prepared.assign_compact(&compact);
            compact.write(&mut polyhedron);
            let expected = PreparedPiece::new(&polyhedron);
            assert_eq!(format!("{prepared:?}"), format!("{expected:?}"));
        }
        assert!(polyhedron.planes.len() < 46 && prepared.volume() > 0.0);
    }
}
