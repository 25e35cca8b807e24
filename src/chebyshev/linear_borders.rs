//! The integrals of `borders` for p = 1, as one sum of four lanes per facet.
//!
//! On a triangle of area A with corners y_v and distances δ_v, ∫ d y dA = (A/12) Σ_v (δ_v + Σ δ) y_v.
//! With 1 as the fourth coordinate of every point this is ∫ d dA as well.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::borders::FacetSums;
use crate::chebyshev::endpoints::Found;
use crate::chebyshev::interface::Interface;
use crate::chebyshev::mark::Mark;
use crate::chebyshev::sector::Sector;
use crate::chebyshev::visit::{Corner, FacetView, Side, Visit};

/// The sums of a walk about the origin: per sector its volume, and per facet its own.
pub(crate) struct LinearSums<'a> {
    pub(crate) volumes: [f64; Sector::SLOTS],
    facets: &'a mut [FacetSums],
}

impl<'a> LinearSums<'a> {
    pub(crate) fn new(facets: &'a mut [FacetSums]) -> Self {
        Self {
            volumes: [0.0; Sector::SLOTS],
            facets,
        }
    }
}

/// A point with its fourth coordinate.
#[inline]
fn four(point: &Vector3<f64>) -> f64x4 {
    f64x4::new([point.x, point.y, point.z, 1.0])
}

impl Visit for LinearSums<'_> {
    #[inline]
    fn share(&mut self, sides: &[Side<'_>; 2], sector: Sector, part: f64, ends: [&Corner; 2]) {
        // What both sides share comes first.
        let [a, b] = ends.map(|end| four(&end.point));
        let far = ends[0].distance + ends[1].distance;
        let middle = a + b;
        let moment = a * f64x4::splat(ends[0].distance) + b * f64x4::splat(ends[1].distance);
        let part = part / 6.0;
        let mut volume = 0.0;
        for side in sides {
            let (facet, share) = (&side.facet, part * side.doubled_area);
            let near = facet.anchor.distance(sector);
            let sum = near + far;
            let anchor = four(&facet.anchor.point()) * f64x4::splat(sum + near);
            let all = anchor + middle * f64x4::splat(sum) + moment;
            self.facets[facet.number].0 += all * f64x4::splat(0.25 * share);
            volume += share * facet.height;
        }
        self.volumes[sector.number()] += volume;
    }

    #[inline]
    fn segment(&mut self, facet: &FacetView<'_>, interface: Interface, u: &Found, v: &Found) {
        let [u, v] = [&u.mark, &v.mark];
        let (left, right) = interface.sectors();
        let lean = left.distance(facet.normal()) - right.distance(facet.normal());
        // The anchor stands on the normal through the origin: so this is twice the area of its
        // triangle with u and v.
        let share = interface.determinant(u, v) * lean / 6.0;
        let sum = Mark {
            distance: u.distance + v.distance,
            third: u.third + v.third,
        };
        let anchor = four(&facet.anchor.point());
        let all = anchor + anchor + four(&interface.point(&sum)) + f64x4::new([0.0, 0.0, 0.0, 1.0]);
        // At u and v both distances agree and cancel.
        let difference = facet.anchor.distance(left) - facet.anchor.distance(right);
        self.facets[facet.number].0 += all * f64x4::splat(0.25 * difference * share);
        let volume = share * facet.height;
        self.volumes[left.number()] += volume;
        self.volumes[right.number()] -= volume;
    }
}
