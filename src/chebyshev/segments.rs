//! Segments: the parts of interfaces on a facet.
//!
//! A facet's boundary crosses interfaces, and diagonals pierce its inside. Both are endpoints of
//! segments; paired up interface by interface they make the subdivision of the facet into sectors.

use wide::{f64x4, u32x8};

use crate::chebyshev::chunks::{Bits, CHUNK, fours};
use crate::chebyshev::endpoint::Endpoint;
use crate::chebyshev::endpoints::{Endpoints, Found, STARTS, Spare, Tips};
use crate::chebyshev::interface::{Interface, diagonal_ray, pierced};
use crate::chebyshev::pierced::{by_diagonal, height_below};
use crate::chebyshev::seen::Seen;
use crate::chebyshev::visit::{FacetView, Visit};

/// Which segments there are: per facet a set of interfaces, those of some facets in one word.
#[derive(Clone, Debug, Default)]
pub(crate) struct Segments {
    words: Vec<u64>,
}

impl Segments {
    /// Facets that share a word.
    const FACETS: usize = CHUNK / Interface::SLOTS;

    /// Takes up the segments between endpoints, by facet as sets of bits: those of the interfaces
    /// with a start and an end, one of each.
    #[inline]
    fn take(&mut self, seen: &[u32]) {
        self.words.clear();
        self.words.extend(seen.chunks(Self::FACETS).map(|chunk| {
            let sets = chunk.iter().enumerate();
            sets.fold(0, |word, (place, one)| {
                let both = one & one >> Interface::SLOTS & STARTS;
                word | u64::from(both) << (place * Interface::SLOTS)
            })
        }));
    }

    /// The numbers of the facets, and the interfaces.
    #[inline]
    pub(crate) fn all(&self) -> impl Iterator<Item = (usize, Interface)> + '_ {
        let words = self.words.iter().enumerate();
        words.flat_map(|(chunk, &word)| {
            Bits::of(word).map(move |bit| {
                let facet = chunk * Self::FACETS + bit / Interface::SLOTS;
                (facet, Interface::of_number(bit % Interface::SLOTS))
            })
        })
    }
}

/// Reports the segments of all facets, the boundaries of which cross interfaces at `endpoints`. The
/// spare ones are used up.
///
/// Which facets have diagonals, or segments at all, is what a processor cannot foresee: so all are looked
/// at without a branch first.
#[inline]
pub(crate) fn report_segments(
    seen: &Seen<'_>,
    endpoints: &mut Endpoints,
    segments: &mut Segments,
    visitor: &mut impl Visit,
) {
    add_diagonals(seen, endpoints);
    segments.take(endpoints.seen());
    for four in fours(segments.all(), (0, Interface::NONE)) {
        visitor.segments(seen, endpoints, four);
    }
    if !endpoints.spare.is_empty() {
        for facet in 0..endpoints.seen().len() {
            report_spare(&seen.facet(facet), &mut endpoints.spare, visitor);
        }
    }
}

/// Pairs the facet's spare starts with spare ends of the same interface. Which of several go
/// together makes no difference: they lie on one line, on which signed segments of the same ends
/// add up to the same.
#[cold]
fn report_spare(view: &FacetView, spare: &mut Vec<Spare>, visitor: &mut impl Visit) {
    while let Some(place) = spare.iter().position(|one| one.facet == view.number) {
        let one = spare.swap_remove(place);
        let is_partner =
            |other: &Spare| other.facet == one.facet && other.endpoint == one.endpoint.opposite();
        let Some(place) = spare.iter().position(is_partner) else {
            continue;
        };
        let other = spare.swap_remove(place);
        let (start, end) = if one.endpoint.is_start() {
            (&one, &other)
        } else {
            (&other, &one)
        };
        let [u, v] = [start, end].map(|end| Found::off_edges(end.mark));
        visitor.segment(view, one.endpoint.interface(), &u, &v);
    }
}

/// The bits of the diagonals.
const DIAGONALS: u32x8 = u32x8::new([1, 2, 4, 8, 16, 32, 64, 128]);

/// The diagonals that pierce a facet, as a set of bits.
#[inline(always)]
fn diagonals_through(seen: &Seen<'_>, endpoints: &Endpoints, facet: usize) -> u8 {
    let inside = pierced(endpoints.odd(facet, endpoints.seen()[facet]));
    if inside.count_ones() == 4 {
        likelier(inside, &seen.facet(facet))
    } else {
        inside
    }
}

/// Adds the points in which diagonals pierce facets, each an endpoint of three interfaces.
#[inline]
fn add_diagonals(seen: &Seen<'_>, endpoints: &mut Endpoints) {
    let (mut facets, mut all, mut is_once) = (u32x8::ZERO, 0, true);
    for facet in 0..endpoints.seen().len() {
        let inside = diagonals_through(seen, endpoints, facet);
        is_once &= all & inside == 0;
        all |= inside;
        let are_pierced = (u32x8::splat(u32::from(inside)) & DIAGONALS).simd_eq(DIAGONALS);
        facets |= are_pierced & u32x8::splat(facet as u32);
    }
    let facets = facets.to_array();
    let is_plain = is_once && all == u8::MAX;
    let reaches = is_plain.then(|| reaches(seen, facets)).flatten();
    match reaches {
        Some(reaches) => endpoints.enter_tips(Tips { facets, reaches }),
        None => add_any_diagonals(seen, endpoints),
    }
}

/// How far along the diagonals a facet for each is pierced, if all are from inside.
#[inline]
fn reaches(seen: &Seen<'_>, facets: [u32; 8]) -> Option<[f64; 8]> {
    let Seen { piece, center } = seen;
    let center = [center.x, center.y, center.z].map(f64x4::splat);
    let reaches = by_diagonal(&piece.facets, facets, |plane, along| {
        let height = height_below(plane, center);
        let outside = f64x4::splat(-1.0);
        height.simd_ge(f64x4::ZERO).select(height / along, outside)
    });
    let are_inside = reaches.iter().all(|reach| (0.0..=f64::MAX).contains(reach));
    are_inside.then_some(reaches)
}

/// As [`add_diagonals`], where diagonals may pierce several facets, none, or one from outside.
#[inline(never)]
fn add_any_diagonals(seen: &Seen<'_>, endpoints: &mut Endpoints) {
    let count = endpoints.seen().len();
    let through = |facet| (facet, diagonals_through(seen, endpoints, facet));
    let all: Vec<_> = (0..count).map(through).collect();
    for (facet, inside) in all {
        let view = seen.facet(facet);
        for diagonal in Bits::of(u64::from(inside)) {
            let diagonal = diagonal as u8;
            // Both change sign where the center lies beyond the facet.
            let reach = view.height / view.normal.dot(diagonal_ray(diagonal));
            if (0.0..=f64::MAX).contains(&reach) {
                let there = Endpoint::at_diagonal(diagonal, view.height >= 0.0);
                endpoints.enter_diagonal(facet, there, reach);
            } else {
                add_flat_diagonal(diagonal, &view, endpoints);
            }
        }
    }
}

/// Adds a diagonal that pierces the facet by rounding alone, so that its triangle has no area.
#[cold]
fn add_flat_diagonal(diagonal: u8, view: &FacetView, endpoints: &mut Endpoints) {
    let point = endpoints.any_point(view.number);
    let point = point.unwrap_or_else(|| view.anchor());
    for &(endpoint, _) in &Endpoint::at_diagonal(diagonal, view.height >= 0.0).endpoints {
        let found = Found::off_edges(endpoint.interface().mark(&point));
        endpoints.enter(view.number, endpoint, found.lanes());
    }
    endpoints.are_rounded = true;
}

/// The facet spans a whole sector: the one in the middle of the four diagonals, or the opposite.
#[cold]
fn likelier(inside: u8, view: &FacetView) -> u8 {
    let balance = |set: u8| -> f64 {
        let members = (0..8).filter(|diagonal| set >> diagonal & 1 == 1);
        let slopes = members.map(|diagonal| view.normal.dot(diagonal_ray(diagonal)));
        slopes.sum()
    };
    let is_opposite = (balance(!inside) > balance(inside)) == (view.height >= 0.0);
    if is_opposite { !inside } else { inside }
}
