//! Energies of polygons whose density is a polynomial, and integrals over their edges.
//!
//! In a fragment the distance is ± one coordinate difference from the center, so density times a power of it
//! is a polynomial in these differences, which [`crate::integrals::planar`] integrates. On an interface, a
//! ray of length l along (σ, τ), the density's term of x^i y^j is σ^i τ^j l^(i+j), and
//! (p/√2) ∫ ρ l^(p−1) ds = p Σ a_ij σ^i τ^j l^(i+j+p) / (i+j+p).

use nalgebra::{Point2, Point3, Vector2};

use crate::energy::planar::{FragmentTriangle, power_of, reach, visit, visit_interfaces};
use crate::geometry::polygon::ConvexPolygon;
use crate::integrals::planar::{PlaneMonomials, PlaneTerms, plane_terms};
use crate::integrals::polynomial::Polynomial;
use crate::minimize::problem::Evaluation;

/// A density relative to a site, and the memory of its integrals.
#[derive(Clone, Debug)]
pub(crate) struct WeightedSums {
    density: Polynomial,
    monomials: PlaneMonomials,
}

impl WeightedSums {
    /// For energies of order `order`.
    pub(crate) fn new(density: Polynomial, order: u32) -> Self {
        let monomials = PlaneMonomials::up_to(density.degree() + order + 1);
        Self { density, monomials }
    }

    /// The density's terms in y − `center`.
    pub(crate) fn terms(&self, center: &Point2<f64>) -> PlaneTerms {
        plane_terms(
            &self
                .density
                .relative_to(&Point3::new(center.x, center.y, 0.0)),
        )
    }

    /// The energy of a polygon with gradient and Hessian; `terms` are those about the center.
    pub(crate) fn energy(
        &mut self,
        polygon: &ConvexPolygon,
        (center, terms): (&Point2<f64>, &PlaneTerms),
        order: u32,
    ) -> Evaluation<2> {
        let mut energy = Evaluation::default();
        let p = f64::from(order);
        visit(polygon, center, |triangle| {
            self.monomials.fill([&triangle.start, &triangle.end]);
            let integral = |power| self.over_triangle(&triangle, terms, power);
            let axis = triangle.axis;
            energy.value += integral(order);
            energy.gradient[axis] -= triangle.sign * p * integral(order - 1);
            if order > 1 {
                energy.hessian[(axis, axis)] += p * (p - 1.0) * integral(order - 2);
            }
        });
        visit_interfaces(polygon, center, |cut, turn, w| {
            let weight = p * along_ray(terms, cut, order);
            energy.hessian += w * w.transpose() * (weight * turn.signum());
        });
        energy
    }

    /// ∫ ρ l^power over the triangle that the table is of.
    fn over_triangle(&self, triangle: &FragmentTriangle, terms: &PlaneTerms, power: u32) -> f64 {
        let mean = self
            .monomials
            .mean_of(2, terms, along(triangle.axis, power));
        triangle.signed_area() * sign(triangle, power) * mean
    }

    /// ∫ ρ l^order and ∫ ρ l^order y over the outer side of a triangle about the site.
    pub(crate) fn over_side(
        &mut self,
        triangle: &FragmentTriangle,
        terms: &PlaneTerms,
        order: u32,
    ) -> (f64, Vector2<f64>) {
        self.monomials.fill([&triangle.start, &triangle.end]);
        let scale = (triangle.end - triangle.start).norm() * sign(triangle, order);
        let mean = |more: [u32; 2]| {
            let [a, b] = along(triangle.axis, order);
            self.monomials.mean_of(1, terms, [a + more[0], b + more[1]])
        };
        let first = Vector2::new(mean([1, 0]), mean([0, 1]));
        (scale * mean([0, 0]), first * scale)
    }
}

/// The exponents of a power of one coordinate.
fn along(axis: usize, power: u32) -> [u32; 2] {
    if axis == 0 { [power, 0] } else { [0, power] }
}

/// The sign of a power of the fragment's coordinate where its distance is positive.
fn sign(triangle: &FragmentTriangle, power: u32) -> f64 {
    if power % 2 == 1 { triangle.sign } else { 1.0 }
}

/// Σ a_ij σ^i τ^j l^(i+j+p) / (i+j+p) up to the point `cut` of a ray.
fn along_ray(terms: &PlaneTerms, cut: &Vector2<f64>, order: u32) -> f64 {
    let length = reach(cut);
    let direction = |value: f64, power: u32| if power % 2 == 1 { value.signum() } else { 1.0 };
    let term = |&([i, j], value): &([u32; 2], f64)| {
        let power = i + j + order;
        let along = direction(cut.x, i) * direction(cut.y, j);
        value * along * power_of(length, power) / f64::from(power)
    };
    terms.iter().map(term).sum()
}
