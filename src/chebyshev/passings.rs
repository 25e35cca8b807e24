//! What passes on the way of a center from where a piece was last walked.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::chunks::{Bits, CHUNK};
use crate::chebyshev::crossing::Passage;
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::interface::Endpoint;
use crate::chebyshev::panorama::{Panorama, VertexSight, codes_from};
use crate::chebyshev::passing::{Passing, Sum};
use crate::chebyshev::pierced::{add_diagonal, nearer_facets};
use crate::chebyshev::sector::Sector;
use crate::geometry::compact::BLOCK;
use crate::minimize::problem::Evaluation;

/// What has passed on the way of a center from where a convex piece was last walked.
#[derive(Clone, Debug, Default)]
pub(crate) struct Passings {
    /// Where the way has come to.
    center: Vector3<f64>,
    /// The sectors of the vertices there, see [`Sector::of_code`].
    codes: Vec<f64x4>,
    /// The same before the last step, in memory to be reused.
    last_codes: Vec<f64x4>,
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
        std::mem::swap(&mut self.codes, &mut self.last_codes);
        let Self {
            codes,
            last_codes,
            all,
            ..
        } = self;
        codes.clear();
        codes.extend(
            piece
                .vertices
                .blocks()
                .iter()
                .map(|block| codes_from(block, center)),
        );
        for vertex in changed(codes, last_codes).take_while(|&vertex| vertex < piece.vertices.len())
        {
            let sectors = [&*last_codes, codes]
                .map(|codes| Sector::of_code(codes[vertex / BLOCK].to_array()[vertex % BLOCK]));
            add_vertex(piece, vertex, &centers, sectors, all)?;
        }
        let nearer = nearer_facets(piece, center, &self.tips)?;
        for (diagonal, (tip, &nearer)) in self.tips.iter_mut().zip(&nearer).enumerate() {
            if nearer != 0 {
                *tip = add_diagonal(piece, (diagonal, *tip), nearer, &centers, &mut self.all);
            }
        }
        Some(())
    }
}

/// The lanes in which two lists differ.
#[inline]
fn changed<'a>(one: &'a [f64x4], other: &'a [f64x4]) -> impl Iterator<Item = usize> + 'a {
    const BLOCKS: usize = CHUNK / BLOCK;
    let chunks = one.chunks(BLOCKS).zip(other.chunks(BLOCKS)).enumerate();
    chunks.flat_map(|(chunk, (one, other))| {
        let blocks = one.iter().zip(other).enumerate();
        let bits = blocks.fold(0, |bits, (block, (one, other))| {
            bits | u64::from(one.simd_ne(*other).to_bitmask()) << (block * BLOCK)
        });
        Bits::of(bits).map(move |bit| chunk * CHUNK + bit)
    })
}

/// Adds the passages of a vertex from one sector to another, where the center goes from the first of
/// `centers` to the second.
#[inline]
fn add_vertex(
    piece: &Integrand,
    vertex: usize,
    centers: &[Vector3<f64>; 2],
    sectors: [Sector; 2],
    all: &mut Vec<Passing>,
) -> Option<()> {
    let point = piece.vertices.get(vertex);
    let facets = piece.corners.facets(vertex)?;
    let normals = facets.map(|facet| &piece.facets[facet].normal);
    let ends = centers.each_ref().map(|center| point - center);
    if let Some(endpoint) = only_passage(&ends, sectors) {
        all.push(Passing::of_vertex(endpoint, &point, normals));
    } else if sectors[0].axis() == sectors[1].axis() {
        return None;
    } else {
        let [from, to] = ends.map(|away| VertexSight::of(&away));
        for passage in Passage::all(&from, &to) {
            all.push(Passing::of_vertex(passage.endpoint, &point, normals));
        }
    }
    Some(())
}

/// The passage between two sectors on the way from one point to another, if it is the only one.
#[inline]
fn only_passage([a, b]: &[Vector3<f64>; 2], [from, to]: [Sector; 2]) -> Option<Endpoint> {
    let fall = from.distance(a) - to.distance(a);
    let rise = to.distance(b) - from.distance(b);
    let there = a * rise + b * fall;
    let third = (3 - from.axis()).checked_sub(to.axis())? % 3;
    let is_only = from.axis() != to.axis() && there[third].abs() <= from.distance(&there);
    is_only.then(|| Endpoint::passing(from, to))
}
