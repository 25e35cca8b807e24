//! Where the segments of a piece's facets begin and end.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::endpoint::{AtDiagonal, Endpoint};
use crate::chebyshev::interface::Interface;
use crate::chebyshev::mark::Mark;

/// The endpoints that are starts.
pub(crate) const STARTS: u32 = (1 << Interface::SLOTS) - 1;

/// An endpoint's place.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Found {
    /// Where it is.
    pub(crate) mark: Mark,
    /// How it slides along its edge; zero at a diagonal. A center that moves by δ, of which δ_l
    /// and δ_r are the parts along the interface's two sectors and δ_t that along the third axis,
    /// takes the interface with it, and the mark changes by −(δ_l, δ_t) − (δ_l − δ_r) drift.
    pub(crate) drift: Mark,
}

impl Found {
    /// The mark's two numbers and those of its drift.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> f64x4 {
        let Self { mark, drift } = self;
        f64x4::new([mark.distance, mark.third, drift.distance, drift.third])
    }

    /// The one of these numbers.
    #[inline(always)]
    pub(crate) fn of_lanes(lanes: f64x4) -> Self {
        let [distance, third, slide, slide_third] = lanes.to_array();
        Self {
            mark: Mark { distance, third },
            drift: Mark {
                distance: slide,
                third: slide_third,
            },
        }
    }

    /// What does not lie on an edge.
    #[inline]
    pub(crate) fn off_edges(mark: Mark) -> Self {
        Self {
            mark,
            drift: Mark::default(),
        }
    }
}

/// Where diagonals pierce facets.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tips {
    /// The facets.
    pub(crate) facets: [u32; 8],
    /// The coordinates along all axes, but for their signs.
    pub(crate) reaches: [f64; 8],
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

/// Where segments begin and end, by facet: at most one point per endpoint, and the spare ones.
#[derive(Clone, Debug, Default)]
pub(crate) struct Endpoints {
    /// The endpoints there are, as sets of bits.
    seen: Vec<u32>,
    /// See [`Found::lanes`]; meaningless where nothing was seen.
    found: Vec<[f64x4; Endpoint::SLOTS]>,
    /// Those elsewhere.
    pub(crate) spare: Vec<Spare>,
    /// Where diagonals pierce facets, each one facet and from inside; meaningless without `has_tips`.
    tips: Tips,
    has_tips: bool,
    /// Whether rounding alone has added some, or nobody can tell how one slides.
    pub(crate) are_rounded: bool,
}

impl Endpoints {
    /// Forgets all endpoints and makes room for those of `count` facets.
    pub(crate) fn reset(&mut self, count: usize) {
        self.seen.clear();
        self.seen.resize(count, 0);
        if self.found.len() < count {
            self.found.resize(count, [f64x4::ZERO; Endpoint::SLOTS]);
        }
        self.spare.clear();
        self.has_tips = false;
        self.are_rounded = false;
    }

    /// Adds an endpoint to a facet's, or to the spare ones where its place is taken.
    #[inline]
    pub(crate) fn enter(&mut self, facet: usize, endpoint: Endpoint, found: f64x4) {
        let seen = &mut self.seen[facet];
        if *seen & endpoint.bit() == 0 {
            *seen |= endpoint.bit();
            self.found[facet][endpoint.number()] = found;
        } else {
            let Found { mark, .. } = Found::of_lanes(found);
            self.spare.push(Spare {
                facet,
                endpoint,
                mark,
            });
            self.are_rounded = true;
        }
    }

    /// Adds those at all diagonals, which pierce one facet each and from inside.
    #[inline]
    pub(crate) fn enter_tips(&mut self, tips: Tips) {
        for (diagonal, (facet, reach)) in (0..).zip(tips.facets.iter().zip(tips.reaches)) {
            self.enter_diagonal(
                *facet as usize,
                Endpoint::at_diagonal(diagonal, true),
                reach,
            );
        }
        (self.tips, self.has_tips) = (tips, true);
    }

    /// Adds those at a diagonal that pierces the facet `reach` along every axis.
    #[inline(always)]
    pub(crate) fn enter_diagonal(&mut self, facet: usize, there: &AtDiagonal, reach: f64) {
        let found = |sign: f64| f64x4::new([reach, sign * reach, 0.0, 0.0]);
        let seen = &mut self.seen[facet];
        if *seen & there.bits != 0 {
            for (endpoint, sign) in &there.endpoints {
                self.enter(facet, *endpoint, found(*sign));
            }
            return;
        }
        *seen |= there.bits;
        let places = &mut self.found[facet];
        for (endpoint, sign) in &there.endpoints {
            places[endpoint.number()] = found(*sign);
        }
    }

    /// Where diagonals pierce facets, if each pierces one and from inside, all segments have two ends,
    /// and all ends are known to slide.
    #[inline]
    pub(crate) fn tips(&self) -> Option<&Tips> {
        let unpaired = self
            .seen
            .iter()
            .fold(0, |all, one| all | one ^ one >> Interface::SLOTS);
        let is_sound = self.has_tips && unpaired & STARTS == 0 && !self.are_rounded;
        is_sound.then_some(&self.tips)
    }

    /// An endpoint that was seen.
    #[inline]
    pub(crate) fn found(&self, facet: usize, endpoint: Endpoint) -> f64x4 {
        self.found[facet][endpoint.number()]
    }

    /// Start and end of an interface's segment on a facet.
    #[inline(always)]
    pub(crate) fn ends(&self, facet: usize, interface: Interface) -> [f64x4; 2] {
        let found = &self.found[facet];
        [false, true].map(|ends| found[Endpoint::of(interface, ends).number()])
    }

    /// The endpoints there are, by facet, as sets of bits.
    #[inline]
    pub(crate) fn seen(&self) -> &[u32] {
        &self.seen
    }

    /// The interfaces that the boundary of a facet that has seen `seen` crosses an odd number of
    /// times.
    #[inline]
    pub(crate) fn odd(&self, facet: usize, seen: u32) -> u32 {
        let odd = (seen ^ seen >> Interface::SLOTS) & STARTS;
        if self.spare.is_empty() {
            return odd;
        }
        let own = self.spare.iter().filter(|one| one.facet == facet);
        own.fold(odd, |set, one| set ^ 1 << one.endpoint.interface().number())
    }

    /// One of a facet's points, if there are any.
    pub(crate) fn any_point(&self, facet: usize) -> Option<Vector3<f64>> {
        let seen = self.seen[facet];
        let endpoint = (seen != 0).then(|| Endpoint::lowest(seen))?;
        let Found { mark, .. } = Found::of_lanes(self.found(facet, endpoint));
        Some(endpoint.interface().point(&mark))
    }
}
