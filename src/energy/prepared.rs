//! A piece prepared for integrals about any center: struct of arrays of its vertices, facets and edges.
//!
//! Vertices and facets are rows of four numbers, so that a processor loads one at once and measures
//! four together; edges come in blocks of four.

use std::fmt;

use nalgebra::{Rotation3, Vector3};
use wide::f64x4;

use crate::arrays::MapEach;
use crate::geometry::brep::Edge;
use crate::geometry::label::Label;
use crate::geometry::small_polyhedron::{BLOCK, EDGES};
use crate::integrals::polynomial::Polynomial;

/// Members of a list that share one set of bits.
pub(crate) const CHUNK: usize = u64::BITS as usize;

/// Fills the last block of edges. Between a vertex and itself there is no area.
pub(crate) const NO_EDGE: Edge = Edge {
    from: 0,
    to: 0,
    left: 0,
    right: 0,
};

/// A piece prepared for integrals about any center, in the piece's coordinates.
#[derive(Clone, Debug, Default)]
pub(crate) struct PreparedPiece {
    /// Coordinates; the fourth number is meaningless.
    pub(crate) vertices: Rows,
    /// Unit normals and offsets.
    pub(crate) facets: Rows,
    pub(crate) edges: Edges,
    pub(crate) labels: Vec<Label>,
    /// In the piece's coordinates; none is density 1.
    pub(crate) density: Option<Polynomial>,
    pub(crate) edge_words: EdgeWords,
}

/// A list of rows of four numbers, in whole blocks. Rows beyond the last repeat the first.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    rows: Vec<[f64; 4]>,
    count: usize,
}

impl Rows {
    /// Replaces all rows.
    #[inline]
    pub(crate) fn assign(&mut self, rows: impl Iterator<Item = [f64; 4]>) {
        self.rows.clear();
        self.rows.extend(rows);
        self.pad();
    }

    /// Replaces all rows by those of the first `count` points of which these are the coordinates.
    #[inline]
    pub(crate) fn assign_axes<const N: usize>(&mut self, axes: [&[f64; N]; 3], count: usize) {
        self.rows.clear();
        let [x, y, z] = axes.map(|axis| axis.as_chunks::<BLOCK>().0.iter());
        for ((x, y), z) in x.zip(y).zip(z).take(count.div_ceil(BLOCK)) {
            let [x, y, z] = [x, y, z].map_each(|along| f64x4::new(*along));
            let rows = f64x4::transpose([x, y, z, x]);
            self.rows.extend(rows.map_each(f64x4::to_array));
        }
        self.rows.truncate(count);
        self.pad();
    }

    /// Fills the last block.
    #[inline]
    fn pad(&mut self) {
        self.count = self.rows.len();
        if let Some(&first) = self.rows.first() {
            self.rows.resize(self.count.next_multiple_of(BLOCK), first);
        }
    }

    /// How many there are.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// The first three numbers of a row.
    #[inline]
    pub(crate) fn vector(&self, number: usize) -> Vector3<f64> {
        let [x, y, z, _] = self.rows[number];
        Vector3::new(x, y, z)
    }

    /// All rows.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[f64; 4]> {
        self.rows[..self.count].iter()
    }

    /// Four rows, transposed.
    #[inline(always)]
    pub(crate) fn quad(&self, numbers: [u32; BLOCK]) -> [f64x4; 4] {
        f64x4::transpose(numbers.map_each(|number| f64x4::new(self.rows[number as usize])))
    }

    /// All rows, four at a time and transposed.
    #[inline]
    pub(crate) fn blocks(&self) -> impl ExactSizeIterator<Item = [f64x4; 4]> + '_ {
        let blocks = self.rows.as_chunks::<BLOCK>().0.iter();
        blocks.map(|rows| f64x4::transpose(rows.map(f64x4::new)))
    }

    /// Applies `change` to all rows, four at a time and transposed.
    #[inline]
    pub(crate) fn map(&mut self, change: impl Fn([f64x4; 4]) -> [f64x4; 4]) {
        for rows in self.rows.as_chunks_mut::<BLOCK>().0 {
            let changed = change(f64x4::transpose(rows.map_each(f64x4::new)));
            *rows = f64x4::transpose(changed).map_each(f64x4::to_array);
        }
    }

    /// Turns the vectors of all rows about the origin.
    pub(crate) fn rotate(&mut self, rotation: &Rotation3<f64>) {
        for [x, y, z, _] in &mut self.rows {
            [*x, *y, *z] = (rotation * Vector3::new(*x, *y, *z)).into();
        }
    }
}

/// A list of edges, in whole blocks.
#[derive(Clone, Default)]
pub(crate) struct Edges {
    list: Vec<Edge>,
    /// How much of the list is used.
    used: usize,
}

impl Edges {
    /// Replaces all edges by at most `most` others.
    #[inline(always)]
    pub(crate) fn assign(&mut self, edges: impl Iterator<Item = Edge>, most: usize) {
        let most = most.next_multiple_of(BLOCK);
        if self.list.len() < most {
            self.list.resize(most, NO_EDGE);
        }
        let (list, mut count) = (self.list.as_mut_slice(), 0);
        edges.for_each(|edge| {
            list[count] = edge;
            count += 1;
        });
        self.used = count.next_multiple_of(BLOCK);
        list[count..self.used].fill(NO_EDGE);
    }

    /// All of them in blocks, the last one filled up with [`NO_EDGE`].
    #[inline]
    pub(crate) fn blocks(&self) -> &[[Edge; BLOCK]] {
        self.list[..self.used].as_chunks().0
    }
}

impl fmt::Debug for Edges {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_list().entries(self.blocks()).finish()
    }
}

/// Memory to list the edges of a small polyhedron: per edge the slots at its ends and the planes left and
/// right of it.
#[derive(Clone)]
pub(crate) struct EdgeWords(pub(crate) [u32; EDGES]);

impl Default for EdgeWords {
    fn default() -> Self {
        Self([0; EDGES])
    }
}

impl fmt::Debug for EdgeWords {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("EdgeWords")
    }
}

/// A piece and the center about which it is integrated. Displacements are from the center.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CenteredPiece<'a> {
    pub(crate) piece: &'a PreparedPiece,
    pub(crate) center: &'a Vector3<f64>,
}

/// A facet about a center. It is fanned from its *anchor*, the foot of the perpendicular from the center.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetView {
    /// The facet's number in its piece.
    pub(crate) number: usize,
    /// The unit normal.
    pub(crate) normal: Vector3<f64>,
    /// The center's signed height below the facet's plane (L).
    pub(crate) height: f64,
}

impl CenteredPiece<'_> {
    /// The displacement of a vertex.
    #[inline]
    pub(crate) fn vertex(&self, number: u32) -> Vector3<f64> {
        self.piece.vertices.vector(number as usize) - self.center
    }

    /// A facet.
    #[inline]
    pub(crate) fn facet(&self, number: usize) -> FacetView {
        let [x, y, z, offset] = self.piece.facets.rows[number];
        let normal = Vector3::new(x, y, z);
        FacetView {
            number,
            height: offset - normal.dot(self.center),
            normal,
        }
    }

    /// The displacements of four vertices, by axis.
    #[inline(always)]
    pub(crate) fn quad_vertices(&self, numbers: [u32; BLOCK]) -> [f64x4; 3] {
        self.displacements(&self.piece.vertices.quad(numbers))
    }

    /// The displacements of four points, by axis.
    #[inline(always)]
    pub(crate) fn displacements(&self, [x, y, z, _]: &[f64x4; 4]) -> [f64x4; 3] {
        let center = self.center;
        [
            x - f64x4::splat(center.x),
            y - f64x4::splat(center.y),
            z - f64x4::splat(center.z),
        ]
    }

    /// The normals of four facets, by axis, and the heights of the center below them.
    #[inline(always)]
    pub(crate) fn quad_facets(&self, numbers: [u32; BLOCK]) -> ([f64x4; 3], f64x4) {
        let [x, y, z, offset] = self.piece.facets.quad(numbers);
        let center = self.center;
        let along =
            x * f64x4::splat(center.x) + y * f64x4::splat(center.y) + z * f64x4::splat(center.z);
        ([x, y, z], offset - along)
    }
}

impl FacetView {
    /// The anchor's displacement.
    #[inline]
    pub(crate) fn anchor(&self) -> Vector3<f64> {
        self.normal * self.height
    }
}

/// The members of a set of bits, in ascending order.
///
/// Branches on geometric conditions are mispredicted every other time, which costs more than the work
/// they avoid. So conditions are computed for a chunk of a list without a branch,
/// and those chosen are taken from a set of bits, one by one or four at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bits(pub(crate) u64);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let number = self.0.trailing_zeros() as usize;
        (self.0 != 0).then(|| {
            self.0 &= self.0 - 1;
            number % CHUNK
        })
    }
}

/// Items four at a time; a last group of less is filled up with `none`.
#[inline(always)]
pub(crate) fn array_chunks<Item: Copy>(
    mut items: impl Iterator<Item = Item>,
    none: Item,
) -> impl Iterator<Item = [Item; BLOCK]> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let first = items.next()?;
            let mut next = || items.next().unwrap_or(none);
            Some([first, next(), next(), next()])
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_a_list_and_of_axes_are_the_same() {
        let axes =
            [1.0, 10.0, 100.0].map(|scale| [0, 1, 2, 3, 4, 5, 6, 7].map(|i| f64::from(i) * scale));
        for count in 0..=8 {
            let (mut listed, mut assigned) = (Rows::default(), Rows::default());
            assigned.assign([[7.0; 4]].into_iter());
            assigned.assign_axes(axes.each_ref(), count);
            let row = |number: usize| [0, 1, 2, 0].map(|axis: usize| axes[axis][number]);
            listed.assign((0..count).map(row));
            assert_eq!(format!("{listed:?}"), format!("{assigned:?}"));
            assert_eq!((listed.len(), listed.iter().count()), (count, count));
            let rotation = Rotation3::from_euler_angles(0.1, 0.2, 0.3);
            listed.rotate(&rotation);
            for number in 0..count {
                let expected = rotation * assigned.vector(number);
                assert_eq!(listed.vector(number), expected);
            }
        }
    }
}
