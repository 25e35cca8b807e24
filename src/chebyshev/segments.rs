//! Segments: the parts of interfaces on a facet.
//!
//! A facet's boundary crosses interfaces, and diagonals pierce its inside. Both are endpoints of
//! segments; paired up interface by interface they make the subdivision of the facet into sectors.

use crate::chebyshev::chunks::{Bits, CHUNK, chosen};
use crate::chebyshev::endpoints::{Endpoints, Found, STARTS, Spare, Tips};
use crate::chebyshev::interface::{Endpoint, Interface, diagonal_ray, pierced};
use crate::chebyshev::pierced::by_diagonal;
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

/// Reports the segments of all facets, the numbers of which `view` shows. Their boundaries cross
/// interfaces at `endpoints`. The spare ones are used up.
///
/// Which facets have diagonals, or segments at all, is what a processor cannot foresee: so sets of
/// them are made without a branch first.
#[inline]
pub(crate) fn report_segments<'a>(
    view: impl Fn(usize) -> FacetView<'a>,
    endpoints: &mut Endpoints,
    segments: &mut Segments,
    visitor: &mut impl Visit,
) {
    add_diagonals(&view, endpoints);
    segments.take(endpoints.seen());
    for (facet, interface) in segments.all() {
        let [u, v] = [false, true].map(|ends| {
            let endpoint = Endpoint::of(interface, ends);
            endpoints.found(facet, endpoint)
        });
        visitor.segment(&view(facet), interface, u, v);
    }
    if !endpoints.spare.is_empty() {
        for facet in 0..endpoints.seen().len() {
            report_spare(&view(facet), &mut endpoints.spare, visitor);
        }
    }
}

/// Pairs the facet's spare starts with spare ends of the same interface. Which of several go
/// together makes no difference: they lie on one line, on which signed segments of the same ends
/// add up to the same.
#[cold]
fn report_spare(view: &FacetView<'_>, spare: &mut Vec<Spare>, visitor: &mut impl Visit) {
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

/// The facets that diagonals pierce, and which.
#[inline]
fn pierced_facets<'a>(
    view: &impl Fn(usize) -> FacetView<'a>,
    endpoints: &Endpoints,
    mut visit: impl FnMut(usize, u8),
) {
    let count = endpoints.seen().len();
    for first in (0..count).step_by(CHUNK) {
        let seen = &endpoints.seen()[first..];
        let crossed = |number: usize, seen: &u32| endpoints.odd(first + number, *seen) != 0;
        for number in chosen(seen, crossed) {
            let facet = first + number;
            let inside = pierced(endpoints.odd(facet, endpoints.seen()[facet]));
            visit(
                facet,
                if inside.count_ones() == 4 {
                    likelier(inside, &view(facet))
                } else {
                    inside
                },
            );
        }
    }
}

/// Adds the points in which diagonals pierce facets, each an endpoint of three interfaces.
#[inline]
fn add_diagonals<'a>(view: &impl Fn(usize) -> FacetView<'a>, endpoints: &mut Endpoints) {
    let (mut facets, mut all, mut is_once) = ([0; 8], 0, true);
    pierced_facets(view, endpoints, |facet, inside| {
        is_once &= all & inside == 0;
        all |= inside;
        for diagonal in Bits::of(u64::from(inside)) {
            facets[diagonal % 8] = facet as u32;
        }
    });
    let is_plain = is_once && all == u8::MAX;
    let reaches = is_plain.then(|| reaches(facets.map(|facet| view(facet as usize))));
    match reaches.flatten() {
        Some(reaches) => endpoints.enter_tips(Tips { facets, reaches }),
        None => add_any_diagonals(view, endpoints),
    }
}

/// How far along the diagonals a facet for each is pierced, if all are from inside.
#[inline]
fn reaches(views: [FacetView<'_>; 8]) -> Option<[f64; 8]> {
    let alongs = by_diagonal(
        views.map(|view| &view.piece.facets[view.number]),
        |_, along| along,
    );
    let mut are_inside = true;
    let reaches = [0, 1, 2, 3, 4, 5, 6, 7].map(|diagonal: usize| {
        let height = views[diagonal].height;
        let reach = height / alongs[diagonal];
        are_inside &= (height >= 0.0) & (0.0..=f64::MAX).contains(&reach);
        reach
    });
    are_inside.then_some(reaches)
}

/// As [`add_diagonals`], where diagonals may pierce several facets, none, or one from outside.
#[inline(never)]
fn add_any_diagonals<'a>(view: &impl Fn(usize) -> FacetView<'a>, endpoints: &mut Endpoints) {
    let mut all = Vec::new();
    pierced_facets(view, endpoints, |facet, inside| all.push((facet, inside)));
    for (facet, inside) in all {
        let view = view(facet);
        for diagonal in Bits::of(u64::from(inside)) {
            let diagonal = diagonal as u8;
            // Both change sign where the center lies beyond the facet.
            let reach = view.height / view.normal().dot(diagonal_ray(diagonal));
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
fn add_flat_diagonal(diagonal: u8, view: &FacetView<'_>, endpoints: &mut Endpoints) {
    let point = endpoints.any_point(view.number);
    let point = point.unwrap_or_else(|| view.anchor.point());
    for &(endpoint, _) in &Endpoint::at_diagonal(diagonal, view.height >= 0.0).endpoints {
        let found = Found::off_edges(endpoint.interface().mark(&point));
        endpoints.enter(view.number, endpoint, found);
    }
    endpoints.are_rounded = true;
}

/// The facet spans a whole sector: the one in the middle of the four diagonals, or the opposite.
#[cold]
fn likelier(inside: u8, view: &FacetView<'_>) -> u8 {
    let balance = |set: u8| -> f64 {
        let members = (0..8).filter(|diagonal| set >> diagonal & 1 == 1);
        let slopes = members.map(|diagonal| view.normal().dot(diagonal_ray(diagonal)));
        slopes.sum()
    };
    let is_opposite = (balance(!inside) > balance(inside)) == (view.height >= 0.0);
    if is_opposite { !inside } else { inside }
}
