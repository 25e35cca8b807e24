//! The sums of a walk for the energy of order 1, made side by side.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::bend::{bend, symmetric};
use crate::chebyshev::detours::Detours;
use crate::chebyshev::endpoints::{Endpoints, Found};
use crate::chebyshev::family::Family;
use crate::chebyshev::four::{FourEdges, FourPassages};
use crate::chebyshev::interface::{Interface, PAIRS};
use crate::chebyshev::sector::{FourSectors, Sector};
use crate::chebyshev::seen::Seen;
use crate::chebyshev::visit::{Corner, FacetView, Side, Visit};
use crate::geometry::simd::sum;
use crate::geometry::small_polyhedron::BLOCK;
use crate::minimize::problem::{Evaluation, Jet};

/// The sums, kept apart by lane or by interface, so that additions need not wait for each other.
#[derive(Default)]
pub(crate) struct Linear {
    /// Of the shares that are told side by side, and of the others.
    together: Shares<f64x4>,
    alone: Shares<f64>,
    /// Of the segments on an interface: 24 E, 6 V for the first sector and against the second, and what
    /// `quartic` makes of how crossings slide.
    segments: [f64x4; Interface::SLOTS],
    /// And three components of 1/(2√2) of the loss of the interface's area A by the center's motion:
    /// −∂A/∂c = Σ |v−u|/|n∥| n, n∥ the part of the facet's normal n along the interface; and √2 A.
    losses: [f64x4; Interface::SLOTS],
}

/// The sums of shares.
#[derive(Default)]
struct Shares<T> {
    /// 24 E.
    value: T,
    /// 6 V.
    volume: T,
    /// By axis six times the volume that there is more of in the positive sector than in the negative
    /// one.
    volumes: [T; 3],
}

impl Visit for Linear {
    #[inline]
    fn share(&mut self, sides: &[Side; 2], sector: Sector, part: f64, ends: [&Corner; 2]) {
        let [left, right] = sides.map(|side| part * side.doubled_area * side.facet.height);
        let [on_left, on_right] = sides.map(|side| side.facet.distance(sector));
        let both = left + right;
        let around = left * on_left + right * on_right;
        self.alone.value += both * (ends[0].distance + ends[1].distance) + around;
        self.alone.volume += both;
        self.alone.volumes[sector.axis() % 3] += both * sector.sign();
    }

    #[inline]
    fn segment(&mut self, facet: &FacetView, interface: Interface, u: &Found, v: &Found) {
        let (left, right) = interface.sectors();
        let determinant = interface.determinant(&u.mark, &v.mark);
        let slide = interface.determinant(&u.drift, &v.drift);
        let difference = facet.distance(left) - facet.distance(right);
        let volume = determinant * difference;
        self.segments[interface.number()] += f64x4::new([volume * difference, volume, slide, 0.0]);
        let [x, y, z] = (facet.normal * (determinant / facet.height)).into();
        self.losses[interface.number()] += f64x4::new([x, y, z, determinant]);
    }

    #[inline(always)]
    fn edges(&mut self, seen: &Seen<'_>, four: &FourEdges<'_>) {
        let [from, to] = &four.sectors;
        // A whole edge passes at its end.
        let far = to.own_distance();
        let between = four.are_told.select(four.passages.found[0], far);
        let behind = four.are_told.select(four.passages.shares, f64x4::ONE);
        let tetrahedra = Tetrahedra::new(seen, four, four.are_known());
        let sums = &mut self.together;
        sums.volume += tetrahedra.both;
        sums.add(&tetrahedra, from, behind, from.own_distance() + between);
        sums.add(&tetrahedra, to, f64x4::ONE - behind, between + far);
    }

    #[inline(always)]
    fn detours(&mut self, seen: &Seen<'_>, four: &FourEdges<'_>, detours: &Detours) {
        let Detours {
            between,
            passages: [into, out],
            are_told,
        } = detours;
        let [from, to] = &four.sectors;
        let tetrahedra = Tetrahedra::new(seen, four, *are_told);
        let told = |passages: &FourPassages| {
            [passages.found[0], passages.shares].map(|numbers| numbers & *are_told)
        };
        let ([one, start], [other, end]) = (told(into), told(out));
        let sums = &mut self.together;
        sums.volume += tetrahedra.both;
        sums.add(&tetrahedra, from, start, from.own_distance() + one);
        sums.add(&tetrahedra, between, end - start, one + other);
        sums.add(&tetrahedra, to, f64x4::ONE - end, other + to.own_distance());
    }

    #[inline(always)]
    fn segments(
        &mut self,
        seen: &Seen<'_>,
        endpoints: &Endpoints,
        four: [(usize, Interface); BLOCK],
    ) {
        let ends = four.map(|(facet, interface)| endpoints.ends(facet, interface));
        let [u, v] = [0, 1].map(|end: usize| f64x4::transpose(ends.map(|ends| ends[end])));
        let [left_sign, right_sign, turns, pairs] = Interface::lanes(four.map(|(_, one)| one));
        let determinant = turns * (u[0] * v[1] - u[1] * v[0]);
        let slide = turns * (u[2] * v[3] - u[3] * v[2]);
        let ([x, y, z], height) = seen.four_facets(four.map(|(facet, _)| facet as u32));
        // The pairs of axes are xy, xz and yz.
        let left = pairs.simd_gt(f64x4::ONE).select(y, x) * left_sign;
        let right = pairs.simd_gt(f64x4::ZERO).select(z, y) * right_sign;
        // In the energy, both distances at u and v agree and cancel.
        let difference = (left - right) * height;
        let volume = determinant * difference;
        let sums = f64x4::transpose([volume * difference, volume, slide, f64x4::ZERO]);
        let loss = determinant / height;
        let losses = f64x4::transpose([x * loss, y * loss, z * loss, determinant]);
        for lane in 0..BLOCK {
            let interface = four[lane].1.number();
            self.segments[interface] += sums[lane];
            self.losses[interface] += losses[lane];
        }
    }
}

/// The tetrahedra of the center, the anchors and four edges.
struct Tetrahedra {
    /// Six times their volumes left and right of the edges together.
    both: f64x4,
    /// The corners at the anchors, by axis, times six times the volumes.
    anchors: [f64x4; 3],
}

impl Tetrahedra {
    /// Those of some of the edges; the others are without volume.
    #[inline(always)]
    fn new(seen: &Seen<'_>, four: &FourEdges<'_>, are_wanted: f64x4) -> Self {
        let [left, right] = &four.sides(seen);
        let volumes = [left, right].map(|side| side.six_volumes() & are_wanted);
        let weights = [volumes[0] * left.heights, volumes[1] * right.heights];
        let anchor =
            |axis: usize| weights[0] * left.normals[axis] + weights[1] * right.normals[axis];
        Self {
            both: volumes[0] + volumes[1],
            anchors: [0, 1, 2].map(anchor),
        }
    }
}

impl Shares<f64x4> {
    /// Adds parts of tetrahedra in `sectors` between points of the edges with distances whose sums are
    /// `distances`.
    #[inline(always)]
    fn add(
        &mut self,
        tetrahedra: &Tetrahedra,
        sectors: &FourSectors,
        parts: f64x4,
        distances: f64x4,
    ) {
        let Tetrahedra { both, anchors } = tetrahedra;
        self.value += parts * (*both * distances + sectors.distance(anchors));
        let signed = sectors.by_axis(sectors.signed(parts * *both));
        for (sum, more) in self.volumes.iter_mut().zip(signed) {
            *sum += more;
        }
    }
}

impl Linear {
    /// What `quartic` makes of how crossings slide.
    pub(crate) fn slides(&self) -> [f64; Interface::SLOTS] {
        self.segments.map(|sums| sums.to_array()[2])
    }

    /// The volume (L³).
    pub(crate) fn volume(&self) -> f64 {
        (sum(self.together.volume) + self.alone.volume) / 6.0
    }

    pub(crate) fn jet(&self) -> Jet<3> {
        let segments = self.segments[..Interface::COUNT].iter();
        let [on_segments, ..] = segments
            .fold(f64x4::ZERO, |all, sums| all + *sums)
            .to_array();
        let Self {
            together, alone, ..
        } = self;
        let mut volumes =
            [0, 1, 2].map(|axis: usize| sum(together.volumes[axis]) + alone.volumes[axis]);
        for (family, (i, j)) in PAIRS.into_iter().enumerate() {
            let sums = |place: usize| self.segments[Family::SIZE * family + place];
            let [_, same, ..] = (sums(0) - sums(3)).to_array();
            let [_, opposite, ..] = (sums(1) - sums(2)).to_array();
            volumes[i] += opposite + same;
            volumes[j] += opposite - same;
        }
        let bends = bend(&self.losses).map(f64x4::to_array);
        let third = [0, 1, 2].map(|axis: usize| symmetric(bends.map(|all| -all[axis])));
        Jet {
            evaluation: Evaluation {
                value: (sum(together.value) + alone.value + on_segments) / 24.0,
                gradient: Vector3::from(volumes) / -6.0,
                hessian: symmetric(bends.map(|all| 0.5 * all[3])),
            },
            third: Some(third),
        }
    }
}
