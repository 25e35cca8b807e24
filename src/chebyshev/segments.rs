//! Segments: the parts of interfaces on a facet.
//!
//! A facet's boundary crosses interfaces, and diagonals pierce its inside. Both are endpoints of
//! segments; paired up interface by interface they make the subdivision of the facet into sectors.

use nalgebra::Vector3;

use crate::chebyshev::chunks::{Bits, CHUNK, chosen};
use crate::chebyshev::interface::{Drift, Endpoint, Interface, Mark, diagonal_ray, pierced};
use crate::chebyshev::visit::{FacetView, Visit};

/// The endpoints that are starts.
const STARTS: u32 = (1 << Interface::SLOTS) - 1;

/// Where segments begin and end on a facet: at most one point per endpoint.
#[derive(Clone, Debug, Default)]
pub(crate) struct Endpoints {
    /// The endpoints there are, as a set of bits.
    seen: u32,
    /// Those of them at diagonals.
    at_diagonals: u32,
    /// Whether there are spare ones elsewhere.
    has_spare: bool,
    /// Meaningless where nothing was seen.
    marks: [Mark; Endpoint::SLOTS],
    /// Meaningless but where a crossing was seen.
    drifts: [Drift; Endpoint::SLOTS],
}

/// Which segments there are: per facet a set of interfaces, those of some facets in one word.
#[derive(Clone, Debug, Default)]
pub(crate) struct Segments {
    words: Vec<u64>,
    /// Whether rounding alone has added endpoints.
    pub(crate) are_rounded: bool,
}

impl Segments {
    /// Facets that share a word.
    const FACETS: usize = CHUNK / Interface::SLOTS;

    /// Takes up the segments between endpoints, by facet.
    #[inline]
    fn take(&mut self, endpoints: &[Endpoints]) {
        self.words.clear();
        self.words
            .extend(endpoints.chunks(Self::FACETS).map(|chunk| {
                let sets = chunk.iter().enumerate();
                sets.fold(0, |word, (place, one)| {
                    word | u64::from(one.both()) << (place * Interface::SLOTS)
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

/// A second start or end on an interface of a facet. A convex facet has none but by rounding.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spare {
    /// The facet's number.
    pub(crate) facet: usize,
    /// What the point is.
    pub(crate) endpoint: Endpoint,
    /// Where it is.
    pub(crate) mark: Mark,
}

impl Endpoints {
    /// Forgets all endpoints.
    #[inline]
    pub(crate) fn clear(&mut self) {
        self.seen = 0;
        self.at_diagonals = 0;
        self.has_spare = false;
    }

    /// The mark of an endpoint that was seen.
    #[inline]
    pub(crate) fn mark(&self, endpoint: Endpoint) -> &Mark {
        &self.marks[endpoint.number()]
    }

    /// Whether an endpoint that was seen is at a diagonal.
    #[inline]
    pub(crate) fn is_at_diagonal(&self, endpoint: Endpoint) -> bool {
        self.at_diagonals & endpoint.bit() != 0
    }

    /// How an endpoint that was seen slides along its edge; meaningless at a diagonal.
    #[inline]
    pub(crate) fn drift(&self, endpoint: Endpoint) -> &Drift {
        &self.drifts[endpoint.number()]
    }

    /// Notes how a crossing slides along its edge.
    #[inline]
    pub(crate) fn note_drift(&mut self, endpoint: Endpoint, drift: Drift) {
        self.drifts[endpoint.number()] = drift;
    }

    /// The interfaces that the facet's boundary crosses an odd number of times.
    #[inline]
    fn odd(&self, facet: usize, spare: &[Spare]) -> u32 {
        let odd = (self.seen ^ self.seen >> Interface::SLOTS) & STARTS;
        if !self.has_spare {
            return odd;
        }
        let own = spare.iter().filter(|one| one.facet == facet);
        own.fold(odd, |set, one| set ^ 1 << one.endpoint.interface().number())
    }

    /// Adds an endpoint, or says that its place is taken and it has to be a spare one.
    #[inline]
    fn add(&mut self, endpoint: Endpoint, mark: Mark) -> bool {
        let is_free = self.seen & endpoint.bit() == 0;
        if is_free {
            self.seen |= endpoint.bit();
            self.marks[endpoint.number()] = mark;
        } else {
            self.has_spare = true;
        }
        is_free
    }

    /// The interfaces with a start and an end, one of each.
    #[inline]
    fn both(&self) -> u32 {
        self.seen & self.seen >> Interface::SLOTS & STARTS
    }

    /// One of the points, if there are any.
    fn any_point(&self) -> Option<Vector3<f64>> {
        let endpoint = (self.seen != 0).then(|| Endpoint::lowest(self.seen))?;
        Some(endpoint.interface().point(&self.marks[endpoint.number()]))
    }
}

/// Reports the segments of all facets, the numbers of which `view` shows. Their boundaries cross
/// interfaces at `endpoints`, by facet, and at the `spare` ones. They are used up.
///
/// Which facets have diagonals, or segments at all, is what a processor cannot foresee: so sets of
/// them are made without a branch first.
#[inline]
pub(crate) fn report_segments<'a>(
    view: impl Fn(usize) -> FacetView<'a>,
    endpoints: &mut [Endpoints],
    (segments, spare): (&mut Segments, &mut Vec<Spare>),
    visitor: &mut impl Visit,
) {
    let mut has_flat = false;
    for (chunk, endpoints) in endpoints.chunks_mut(CHUNK).enumerate() {
        let first = chunk * CHUNK;
        let crossed = |number: usize, all: &Endpoints| all.odd(first + number, spare) != 0;
        for number in chosen(endpoints, crossed) {
            let view = view(first + number);
            has_flat |= add_diagonals(&view, &mut endpoints[number], spare);
        }
    }
    segments.take(endpoints);
    segments.are_rounded = has_flat | !spare.is_empty();
    for (facet, interface) in segments.all() {
        let view = view(facet);
        let Endpoints { marks, .. } = &endpoints[facet];
        let [u, v] = [false, true].map(|ends| Endpoint::of(interface, ends).number());
        visitor.segment(&view, interface, &marks[u], &marks[v]);
    }
    if !spare.is_empty() {
        for facet in 0..endpoints.len() {
            report_spare(&view(facet), spare, visitor);
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
        visitor.segment(view, one.endpoint.interface(), &start.mark, &end.mark);
    }
}

/// Adds the points in which diagonals pierce the facet, each an endpoint of three interfaces; returns
/// whether rounding alone makes one do so.
#[inline]
fn add_diagonals(view: &FacetView<'_>, endpoints: &mut Endpoints, spare: &mut Vec<Spare>) -> bool {
    let mut has_flat = false;
    let inside = pierced(endpoints.odd(view.number, spare));
    let mut left = if inside.count_ones() == 4 {
        likelier(inside, view)
    } else {
        inside
    };
    while left != 0 {
        let diagonal = left.trailing_zeros() as u8;
        left &= left - 1;
        // Both change sign where the center lies beyond the facet.
        let reach = view.height / view.normal().dot(diagonal_ray(diagonal));
        let is_sound = (0.0..f64::INFINITY).contains(&reach);
        if !is_sound {
            add_flat_diagonal(diagonal, view, endpoints, spare);
            has_flat = true;
            continue;
        }
        for &(endpoint, sign) in Endpoint::at_diagonal(diagonal, view.height >= 0.0) {
            let mark = Mark {
                distance: reach,
                third: sign * reach,
            };
            endpoints.at_diagonals |= endpoint.bit();
            enter(view.number, endpoint, mark, endpoints, spare);
        }
    }
    has_flat
}

/// Adds a diagonal that pierces the facet by rounding alone, so that its triangle has no area.
#[cold]
fn add_flat_diagonal(
    diagonal: u8,
    view: &FacetView<'_>,
    endpoints: &mut Endpoints,
    spare: &mut Vec<Spare>,
) {
    let point = endpoints.any_point();
    let point = point.unwrap_or_else(|| view.anchor.point());
    for &(endpoint, _) in Endpoint::at_diagonal(diagonal, view.height >= 0.0) {
        let mark = endpoint.interface().mark(&point);
        enter(view.number, endpoint, mark, endpoints, spare);
    }
}

/// Adds an endpoint to a facet's, or to the spare ones where its place is taken.
#[inline]
pub(crate) fn enter(
    facet: usize,
    endpoint: Endpoint,
    mark: Mark,
    endpoints: &mut Endpoints,
    spare: &mut Vec<Spare>,
) {
    if !endpoints.add(endpoint, mark) {
        spare.push(Spare {
            facet,
            endpoint,
            mark,
        });
    }
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
