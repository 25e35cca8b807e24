//! What passes on the way of a center from where a piece was last walked.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::chunks::{Bits, CHUNK};
use crate::chebyshev::crossing::Passage;
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::passing::{Passing, Sum};
use crate::chebyshev::pierced::{add_diagonal, nearer_facets};
use crate::chebyshev::seen::Seen;
use crate::chebyshev::sight::VertexSight;
use crate::geometry::small_polyhedron::BLOCK;
use crate::minimize::problem::Evaluation;

/// Blocks of vertices the passages of which are told by one set of bits.
const BLOCKS: usize = CHUNK / BLOCK;

/// What has passed on the way of a center from where a convex piece was last walked.
#[derive(Clone, Debug, Default)]
pub(crate) struct Passings {
    /// Where the way has come to.
    center: Vector3<f64>,
    /// The sectors of the vertices there, see [`Seen::codes`].
    codes: Vec<f64x4>,
    /// The facets that diagonals pierce there.
    tips: [u32; 8],
    all: Vec<Passing>,
    is_begun: bool,
}

impl Passings {
    /// Forgets the way.
    #[inline]
    pub(crate) fn reset(&mut self) {
        self.is_begun = false;
    }

    /// Whether nothing has passed yet.
    #[inline]
    pub(crate) fn are_none(&self) -> bool {
        !self.is_begun
    }

    /// Goes on to `end`, where diagonals pierced `tips` at first, from where the piece was seen.
    pub(crate) fn follow(&mut self, seen: &Seen<'_>, tips: &[u32; 8], end: &Vector3<f64>) -> &Self {
        if !self.is_begun {
            self.center = *seen.center;
            self.codes.clear();
            let blocks = seen.piece.vertices.blocks();
            self.codes.extend(blocks.map(|block| seen.codes(&block)));
            self.tips = *tips;
            self.all.clear();
        }
        self.is_begun = self.advance(seen.piece, end).is_some();
        self
    }

    /// What is to be added at the way's end to the polynomial of its beginning, for a piece of some
    /// volume, unless rounding would be felt.
    pub(crate) fn evaluation(&self, end: &Vector3<f64>, volume: f64) -> Option<Evaluation<3>> {
        let sum = Sum::of(&self.all, end, volume).evaluation();
        sum.filter(|_| self.is_begun)
    }

    fn advance(&mut self, piece: &Integrand, center: &Vector3<f64>) -> Option<()> {
        let centers = [std::mem::replace(&mut self.center, *center), *center];
        let Self {
            codes, tips, all, ..
        } = self;
        for (chunk, codes) in codes.chunks_mut(BLOCKS).enumerate() {
            let mut moved = 0;
            let seen = Seen { piece, center };
            let blocks = piece.vertices.blocks().skip(chunk * BLOCKS);
            for (number, (block, code)) in blocks.zip(codes).enumerate() {
                let now = seen.codes(&block);
                moved |= u64::from(now.simd_ne(*code).to_bitmask()) << (number * BLOCK);
                *code = now;
            }
            let moved = Bits::of(moved).map(|bit| chunk * CHUNK + bit);
            for vertex in moved.take_while(|&vertex| vertex < piece.vertices.len()) {
                add_vertex(piece, vertex, &centers, all)?;
            }
        }
        let nearer = nearer_facets(piece, center, tips)?;
        for (diagonal, (tip, &nearer)) in tips.iter_mut().zip(&nearer).enumerate() {
            if nearer != 0 {
                *tip = add_diagonal(piece, (diagonal, *tip), nearer, &centers, all);
            }
        }
        Some(())
    }
}

/// Adds the passages of a vertex from one sector to another, where the center goes from the first of
/// `centers` to the second; as seen from it the vertex goes along a line.
#[inline]
fn add_vertex(
    piece: &Integrand,
    vertex: usize,
    centers: &[Vector3<f64>; 2],
    all: &mut Vec<Passing>,
) -> Option<()> {
    let point = piece.vertices.get(vertex);
    let normals = (piece.at_vertices.facets(vertex)).map(|facet| piece.facets.normal(facet));
    let [from, to] = centers
        .each_ref()
        .map(|center| VertexSight::of(&(point - center)));
    if from.sector().axis() == to.sector().axis() {
        return None;
    }
    let mut add = |passage: Passage| {
        all.push(Passing::of_vertex(
            passage.endpoint,
            &point,
            normals.each_ref(),
        ));
    };
    match Passage::only(&from, &to) {
        Some(passage) => add(passage),
        None => Passage::all(&from, &to).for_each(add),
    }
    Some(())
}
