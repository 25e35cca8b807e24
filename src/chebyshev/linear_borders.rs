//! The integrals of `borders` for p = 1, as one sum of four lanes per facet.
//!
//! On a triangle of area A with corners y_v and distances δ_v, ∫ d y dA = (A/12) Σ_v (δ_v + Σ δ) y_v.
//! With 1 as the fourth coordinate of every point this is ∫ d dA as well.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::borders::{FacetSums, slopes};
use crate::chebyshev::detours::Detours;
use crate::chebyshev::endpoints::Found;
use crate::chebyshev::four::{FourEdges, FourPassages};
use crate::chebyshev::interface::Interface;
use crate::chebyshev::mark::Mark;
use crate::chebyshev::sector::{FourSectors, Sector};
use crate::chebyshev::seen::Seen;
use crate::chebyshev::visit::{Corner, FacetView, Side, Visit};
use crate::geometry::simd::sum;

/// The sums of a walk about the origin.
pub(crate) struct LinearSums<'a> {
    /// By sector the volume of what was reported alone.
    volumes: [f64; Sector::SLOTS],
    /// Of what was reported side by side, by axis: by how much more volume the positive sector has than
    /// the negative one.
    differences: [f64x4; 3],
    facets: &'a mut [FacetSums],
}

/// Points of four edges.
#[derive(Clone, Copy)]
struct FourPoints {
    /// Their displacements, by axis.
    at: [f64x4; 3],
    /// Their Chebyshev distances.
    distances: f64x4,
}

/// Parts of four edges between points, each within one sector.
struct Stretch<'a> {
    sectors: &'a FourSectors,
    /// The shares of the edges.
    parts: f64x4,
    ends: [FourPoints; 2],
}

impl<'a> LinearSums<'a> {
    pub(crate) fn new(facets: &'a mut [FacetSums]) -> Self {
        Self {
            volumes: [0.0; Sector::SLOTS],
            differences: [f64x4::ZERO; 3],
            facets,
        }
    }

    /// By axis: by how much more volume the negative sector has than the positive one.
    pub(crate) fn slopes(&self) -> [f64; 3] {
        let alone = slopes(&self.volumes);
        [0, 1, 2].map(|axis: usize| alone[axis] - sum(self.differences[axis]))
    }

    /// Adds all of four edges, stretch by stretch.
    #[inline(always)]
    fn add<const N: usize>(
        &mut self,
        seen: &Seen<'_>,
        four: &FourEdges<'_>,
        stretches: [Stretch<'_>; N],
    ) {
        let mut volumes = [f64x4::ZERO; N];
        for (side, facets) in four.sides(seen).iter().enumerate() {
            let mut sums = [f64x4::ZERO; 4];
            for (stretch, volume) in stretches.iter().zip(&mut volumes) {
                let [start, end] = &stretch.ends;
                let near = facets.heights * stretch.sectors.distance(&facets.normals);
                let far = start.distances + end.distances;
                let all = near + far;
                let share = stretch.parts * facets.areas * f64x4::splat(1.0 / 6.0);
                let (weight, anchor) = (share * f64x4::splat(0.25), facets.heights * (all + near));
                for axis in 0..3 {
                    let ends = [start, end].map(|end| end.at[axis] * (all + end.distances));
                    sums[axis] += weight * (facets.normals[axis] * anchor + (ends[0] + ends[1]));
                }
                sums[3] += weight * (all * f64x4::splat(4.0));
                *volume += share * facets.heights;
            }
            let rows = f64x4::transpose(sums);
            for (edge, row) in four.edges.iter().zip(rows) {
                let facet = [edge.left, edge.right][side];
                self.facets[facet as usize].0 += row;
            }
        }
        for (stretch, volume) in stretches.iter().zip(volumes) {
            let signed = stretch.sectors.by_axis(stretch.sectors.signed(volume));
            for (difference, more) in self.differences.iter_mut().zip(signed) {
                *difference += more;
            }
        }
    }
}

impl FourPoints {
    /// The starts and the ends of edges.
    #[inline(always)]
    fn of_ends(four: &FourEdges<'_>) -> [Self; 2] {
        [0, 1].map(|end: usize| Self {
            at: four.ends[end],
            distances: four.sectors[end].own_distance(),
        })
    }

    /// Where edges pass, if that is told, or else their ends.
    #[inline(always)]
    fn of_passages(
        [start, end]: &[Self; 2],
        passages: &FourPassages,
        are_told: f64x4,
    ) -> (Self, f64x4) {
        let shares = are_told.select(passages.shares, f64x4::ONE);
        let between = |axis: usize| start.at[axis] + shares * (end.at[axis] - start.at[axis]);
        let point = Self {
            at: [0, 1, 2].map(between),
            distances: are_told.select(passages.found[0], end.distances),
        };
        (point, shares)
    }
}

/// A point with its fourth coordinate.
#[inline]
fn four(point: &Vector3<f64>) -> f64x4 {
    f64x4::new([point.x, point.y, point.z, 1.0])
}

impl Visit for LinearSums<'_> {
    #[inline]
    fn share(&mut self, sides: &[Side; 2], sector: Sector, part: f64, ends: [&Corner; 2]) {
        // What both sides share comes first.
        let [a, b] = ends.map(|end| four(&end.point));
        let far = ends[0].distance + ends[1].distance;
        let middle = a + b;
        let moment = a * f64x4::splat(ends[0].distance) + b * f64x4::splat(ends[1].distance);
        let part = part / 6.0;
        let mut volume = 0.0;
        for side in sides {
            let (facet, share) = (&side.facet, part * side.doubled_area);
            let near = facet.distance(sector);
            let sum = near + far;
            let anchor = four(&facet.anchor()) * f64x4::splat(sum + near);
            let all = anchor + middle * f64x4::splat(sum) + moment;
            self.facets[facet.number].0 += all * f64x4::splat(0.25 * share);
            volume += share * facet.height;
        }
        self.volumes[sector.number()] += volume;
    }

    #[inline(always)]
    fn edges(&mut self, seen: &Seen<'_>, four: &FourEdges<'_>) {
        let (ends, are_known) = (FourPoints::of_ends(four), four.are_known());
        let (between, shares) = FourPoints::of_passages(&ends, &four.passages, four.are_told);
        let ([from, to], [start, end]) = (&four.sectors, ends);
        let stretch = |sectors, parts: f64x4, ends| Stretch {
            sectors,
            parts: parts & are_known,
            ends,
        };
        let rest = f64x4::ONE - shares;
        let stretches = [
            stretch(from, shares, [start, between]),
            stretch(to, rest, [between, end]),
        ];
        self.add(seen, four, stretches);
    }

    #[inline(always)]
    fn detours(&mut self, seen: &Seen<'_>, four: &FourEdges<'_>, detours: &Detours) {
        let (ends, are_told) = (FourPoints::of_ends(four), detours.are_told);
        let ([from, to], [start, end]) = (&four.sectors, ends);
        let [(into, first), (out, last)] = (detours.passages.each_ref())
            .map(|passages| FourPoints::of_passages(&ends, passages, are_told));
        let stretch = |sectors, parts: f64x4, ends| Stretch {
            sectors,
            parts: parts & are_told,
            ends,
        };
        let stretches = [
            stretch(from, first, [start, into]),
            stretch(&detours.between, last - first, [into, out]),
            stretch(to, f64x4::ONE - last, [out, end]),
        ];
        self.add(seen, four, stretches);
    }

    #[inline]
    fn segment(&mut self, facet: &FacetView, interface: Interface, u: &Found, v: &Found) {
        let [u, v] = [&u.mark, &v.mark];
        let (left, right) = interface.sectors();
        let lean = left.distance(&facet.normal) - right.distance(&facet.normal);
        // The anchor stands on the normal through the origin: so this is twice the area of its
        // triangle with u and v.
        let share = interface.determinant(u, v) * lean / 6.0;
        let sum = Mark {
            distance: u.distance + v.distance,
            third: u.third + v.third,
        };
        let anchor = four(&facet.anchor());
        let all = anchor + anchor + four(&interface.point(&sum)) + f64x4::new([0.0, 0.0, 0.0, 1.0]);
        // At u and v both distances agree and cancel.
        let difference = facet.distance(left) - facet.distance(right);
        self.facets[facet.number].0 += all * f64x4::splat(0.25 * difference * share);
        let volume = share * facet.height;
        self.volumes[left.number()] += volume;
        self.volumes[right.number()] -= volume;
    }
}
