//! What passes on the way of a center from where a piece was last walked.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::chunks::{Bits, CHUNK};
use crate::chebyshev::crossing::Passage;
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::panorama::{Panorama, VertexSight, codes_from};
use crate::chebyshev::passing::{Passing, Sum};
use crate::chebyshev::pierced::{add_diagonal, nearer_facets};
use crate::geometry::compact::BLOCK;
use crate::minimize::problem::Evaluation;

/// Blocks of vertices the passages of which are told by one set of bits.
const BLOCKS: usize = CHUNK / BLOCK;

/// What has passed on the way of a center from where a convex piece was last walked.
#[derive(Clone, Debug, Default)]
pub(crate) struct Passings {
    /// Where the way has come to.
    center: Vector3<f64>,
    /// The sectors of the vertices there, see [`Panorama::codes`].
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

    /// Goes on to `center`, where diagonals pierced `tips` at first, and returns what is to be added
    /// there to the polynomial of the way's beginning, unless rounding would be felt.
    pub(crate) fn follow(
        &mut self,
        piece: &Integrand,
        (panorama, tips): (&Panorama, &[u32; 8]),
        center: &Vector3<f64>,
    ) -> Option<Evaluation<3>> {
        if !self.is_begun {
            self.center = *panorama.center();
            self.codes.clear();
            self.codes.extend_from_slice(panorama.codes(piece));
            self.tips = *tips;
            self.all.clear();
        }
        self.is_begun = self.advance(piece, center).is_some();
        let sum = Sum::of(&self.all, center, piece.volume).evaluation();
        sum.filter(|_| self.is_begun)
    }

    fn advance(&mut self, piece: &Integrand, center: &Vector3<f64>) -> Option<()> {
        let centers = [std::mem::replace(&mut self.center, *center), *center];
        let Self {
            codes, tips, all, ..
        } = self;
        let blocks = piece.vertices.blocks().chunks(BLOCKS);
        for (chunk, (blocks, codes)) in blocks.zip(codes.chunks_mut(BLOCKS)).enumerate() {
            let mut moved = 0;
            for (number, (block, code)) in blocks.iter().zip(codes).enumerate() {
                let now = codes_from(block, center);
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
    let normals = (piece.at_vertices.facets(vertex)).map(|facet| &piece.facets[facet].normal);
    let [from, to] = centers
        .each_ref()
        .map(|center| VertexSight::of(&(point - center)));
    if from.sector().axis() == to.sector().axis() {
        return None;
    }
    let mut add = |passage: Passage| {
        all.push(Passing::of_vertex(passage.endpoint, &point, normals));
    };
    match Passage::only(&from, &to) {
        Some(passage) => add(passage),
        None => Passage::all(&from, &to).for_each(add),
    }
    Some(())
}
