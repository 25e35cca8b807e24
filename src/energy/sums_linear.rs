//! Sums for the energy of order 1, four parts at a time: \[BL\] eq. 1 and its derivatives.
//!
//! Over a tetrahedron of volume V with the center as one corner and Chebyshev distances δ at the others
//! ∫ d∞ = V/4 · Σ δ, the mass of \[BL\] eq. 1. Over a triangle of area A with corners y_v and distances δ_v
//! ∫ d∞ y dA = (A/12) Σ_v (δ_v + Σ δ) y_v; with 1 as the fourth coordinate of every point this is
//! ∫ d∞ dA as well.

use std::ops::{Add, Sub};

use nalgebra::{Matrix3, Vector3};
use wide::f64x4;

use crate::arrays::MapEach;
use crate::energy::edge_crossings_simd::{PartQuad, SideQuad};
use crate::energy::prepared::CenteredPiece;
use crate::energy::sector::{Interface, InterfacePoint, PAIRS, SegmentEnd};
use crate::energy::segments::Segment;
use crate::energy::surface::{FacetIntegrals, SurfaceSums};
use crate::geometry::simd::sum;
use crate::geometry::small_polyhedron::BLOCK;
use crate::minimize::problem::{Evaluation, Jet};

/// How many interfaces a pair of axes has.
const OF_PAIR: usize = 4;

/// The sums of the energy and its derivatives, kept apart by lane or by interface, so that additions
/// do not depend on each other.
#[derive(Default)]
pub(crate) struct LinearSums {
    /// Of parts of edges: 24 E.
    value: f64x4,
    /// 6 V.
    volume: f64x4,
    /// By axis six times the volume in the positive sector minus that in the negative one.
    volumes: [f64x4; 3],
    /// Of the segments of an interface: 24 E, 6 V for the first sector and against the second, and the
    /// determinants of edge velocities (see `prediction`).
    segments: [f64x4; Interface::SLOTS],
    /// Three components of −1/(2√2) ∂A/∂c, A the interface's area:
    /// −∂A/∂c = Σ |v−u|/|n∥| n, n∥ the part of the facet's normal n along the interface; and √2 A.
    area_derivatives: [f64x4; Interface::SLOTS],
}

impl SurfaceSums for LinearSums {
    #[inline(always)]
    fn add_parts<const N: usize>(&mut self, sides: &[SideQuad; 2], parts: &[PartQuad; N]) {
        let [left, right] = sides;
        let volumes = [left, right].map_each(SideQuad::six_volumes);
        let weights = [volumes[0] * left.heights, volumes[1] * right.heights];
        let both = volumes[0] + volumes[1];
        // The corners at the anchors times six times the volumes.
        let anchors = [0, 1, 2].map_each(|axis: usize| {
            weights[0] * left.normals[axis] + weights[1] * right.normals[axis]
        });
        for part in parts {
            let distances = part.ends[0].distances + part.ends[1].distances;
            let volume = part.shares * both;
            self.value += volume * distances + part.shares * part.sectors.distance(&anchors);
            self.volume += volume;
            add_by_axis(&mut self.volumes, part, volume);
        }
    }

    #[inline(always)]
    fn add_segments(&mut self, view: &CenteredPiece<'_>, segments: &[Segment; BLOCK]) {
        let [u, v] =
            [0, 1].map_each(|end: usize| f64x4::transpose(segments.map(|one| one.ends[end].0)));
        let [left_sign, right_sign, orientation, pairs] =
            Interface::lanes(segments.map_each(|one| one.interface));
        let determinant = orientation * (u[0] * v[1] - u[1] * v[0]);
        let velocities = orientation * (u[2] * v[3] - u[3] * v[2]);
        let ([x, y, z], height) = view.quad_facets(segments.map_each(|one| one.facet));
        // The pairs of axes are xy, xz and yz.
        let left = pairs.simd_gt(f64x4::ONE).select(y, x) * left_sign;
        let right = pairs.simd_gt(f64x4::ZERO).select(z, y) * right_sign;
        // In the energy, both distances at u and v agree and cancel.
        let difference = (left - right) * height;
        let volume = determinant * difference;
        let sums = f64x4::transpose([volume * difference, volume, velocities, f64x4::ZERO]);
        let slope = determinant / height;
        let derivatives = f64x4::transpose([x * slope, y * slope, z * slope, determinant]);
        for lane in 0..BLOCK {
            let interface = segments[lane].interface.number();
            self.segments[interface] += sums[lane];
            self.area_derivatives[interface] += derivatives[lane];
        }
    }
}

/// Adds volumes of parts to the differences between the positive and the negative sector of each axis.
#[inline(always)]
fn add_by_axis(volumes: &mut [f64x4; 3], part: &PartQuad, volume: f64x4) {
    let signed = part.sectors.by_axis(part.sectors.signed(volume));
    for (sum, more) in volumes.iter_mut().zip(signed) {
        *sum += more;
    }
}

/// By axis the volume in the positive sector minus that in the negative one, from the sums over parts and
/// those over the segments of an interface, for its first sector and against its second.
#[inline(always)]
fn by_axis(parts: &[f64x4; 3], on_interface: impl Fn(usize) -> f64) -> Vector3<f64> {
    let mut volumes = parts.map_each(sum);
    for (pair, (i, j)) in PAIRS.into_iter().enumerate() {
        let sums = |place: usize| on_interface(OF_PAIR * pair + place);
        let (same, opposite) = (sums(0) - sums(3), sums(1) - sums(2));
        volumes[i] += opposite + same;
        volumes[j] += opposite - same;
    }
    volumes.into()
}

impl LinearSums {
    /// The determinants of edge velocities by interface (see `prediction`).
    pub(crate) fn velocity_determinants(&self) -> [f64; Interface::SLOTS] {
        self.segments.map(|sums| sums.to_array()[2])
    }

    /// The volume (L³).
    pub(crate) fn volume(&self) -> f64 {
        sum(self.volume) / 6.0
    }

    /// Energy (L⁴), gradient, Hessian and third derivatives: \[BL\] eq. 1, 6 and 7 for p = 1.
    pub(crate) fn jet(&self) -> Jet<3> {
        let segments = self.segments[..Interface::COUNT].iter();
        let on_segments = segments.fold(f64x4::ZERO, |all, sums| all + *sums);
        let volumes = by_axis(&self.volumes, |interface| {
            self.segments[interface].to_array()[1]
        });
        let entries = hessian_entries(&self.area_derivatives).map_each(f64x4::to_array);
        let third = [0, 1, 2].map_each(|axis: usize| symmetric(entries.map(|all| -all[axis])));
        Jet {
            evaluation: Evaluation {
                value: (sum(self.value) + on_segments.to_array()[0]) / 24.0,
                gradient: volumes / -6.0,
                hessian: symmetric(entries.map_each(|all| 0.5 * all[3])),
            },
            third: Some(third),
        }
    }
}

/// Σ A w wᵀ over the interfaces, A their areas and w = s_i e_i − s_j e_j: the entries xx, yy, zz, xy,
/// xz and yz.
#[inline(always)]
fn hessian_entries<T>(areas: &[T; Interface::SLOTS]) -> [T; 6]
where
    T: Copy + Add<Output = T> + Sub<Output = T>,
{
    let pair = |number: usize| {
        let area = |place: usize| areas[OF_PAIR * number + place];
        // On + + and − − the directions of w differ, on + − and − + they agree.
        let (same, opposite) = (area(0) + area(3), area(1) + area(2));
        (same + opposite, opposite - same)
    };
    let [(xy, beside_xy), (xz, beside_xz), (yz, beside_yz)] = [0, 1, 2].map_each(pair);
    [xy + xz, xy + yz, xz + yz, beside_xy, beside_xz, beside_yz]
}

/// The symmetric matrix of these entries.
#[inline(always)]
fn symmetric([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(
        xx, xy, xz, //
        xy, yy, yz, //
        xz, yz, zz,
    )
}

/// Σ (A/√2) w wᵀ over the interfaces, from 4/√2 times their areas.
pub(crate) fn hessian_from_areas(areas: &[f64; Interface::SLOTS]) -> Matrix3<f64> {
    symmetric(hessian_entries(areas).map_each(|entry| 0.25 * entry))
}

/// The sums for the gradient of the global objective of order 1: volumes by sector and, per facet, its
/// own integrals.
pub(crate) struct LinearFacetSums<'a> {
    /// As in [`LinearSums`], but for the factor six.
    volumes: [f64x4; 3],
    segments: [f64; Interface::SLOTS],
    facets: &'a mut [FacetIntegrals],
}

impl<'a> LinearFacetSums<'a> {
    pub(crate) fn new(facets: &'a mut [FacetIntegrals]) -> Self {
        Self {
            volumes: [f64x4::ZERO; 3],
            segments: [0.0; Interface::SLOTS],
            facets,
        }
    }

    /// The energy's gradient with the piece held fixed (L³).
    pub(crate) fn gradient(&self) -> Vector3<f64> {
        -by_axis(&self.volumes, |interface| self.segments[interface])
    }
}

impl SurfaceSums for LinearFacetSums<'_> {
    #[inline(always)]
    fn add_parts<const N: usize>(&mut self, sides: &[SideQuad; 2], parts: &[PartQuad; N]) {
        let mut volumes = [f64x4::ZERO; N];
        for side in sides {
            let mut sums = [f64x4::ZERO; 4];
            for (part, volume) in parts.iter().zip(&mut volumes) {
                let [start, end] = &part.ends;
                let near = side.heights * part.sectors.distance(&side.normals);
                let all = near + (start.distances + end.distances);
                let share = part.shares * side.doubled_areas * f64x4::splat(1.0 / 6.0);
                let (weight, anchor) = (share * f64x4::splat(0.25), side.heights * (all + near));
                for axis in 0..3 {
                    let ends = [start, end].map_each(|end| end.at[axis] * (all + end.distances));
                    sums[axis] += weight * (side.normals[axis] * anchor + (ends[0] + ends[1]));
                }
                sums[3] += weight * (all * f64x4::splat(4.0));
                *volume += share * side.heights;
            }
            for (facet, row) in side.facets.into_iter().zip(f64x4::transpose(sums)) {
                self.facets[facet as usize].0 += row;
            }
        }
        for (part, volume) in parts.iter().zip(volumes) {
            add_by_axis(&mut self.volumes, part, volume);
        }
    }

    #[inline]
    fn add_segments(&mut self, view: &CenteredPiece<'_>, segments: &[Segment; BLOCK]) {
        /// A point with its fourth coordinate.
        fn row(point: &Vector3<f64>) -> f64x4 {
            f64x4::new([point.x, point.y, point.z, 1.0])
        }
        for segment in segments
            .iter()
            .filter(|one| one.interface != Interface::NONE)
        {
            let (facet, interface) = (view.facet(segment.facet as usize), segment.interface);
            let [u, v] = segment.ends.map_each(SegmentEnd::point);
            let (left, right) = interface.sectors();
            let slope = left.distance(&facet.normal) - right.distance(&facet.normal);
            // The anchor lies on the normal through the center: so this is a third of the area of its
            // triangle with u and v.
            let share = interface.determinant(&u, &v) * slope / 6.0;
            let ends = InterfacePoint {
                distance: u.distance + v.distance,
                third: u.third + v.third,
            };
            let anchor = row(&facet.anchor());
            let all = anchor
                + anchor
                + row(&interface.displacement(&ends))
                + f64x4::new([0.0, 0.0, 0.0, 1.0]);
            // At u and v both distances agree and cancel.
            let difference = slope * facet.height;
            self.facets[facet.number].0 += all * f64x4::splat(0.25 * difference * share);
            self.segments[interface.number()] += share * facet.height;
        }
    }
}
