//! Integrals of polynomials in x and y over segments, triangles and convex polygons of the plane.
//!
//! They are those of [`crate::integrals::series`] with z = 0: a triangle with a corner at the origin has
//! the table of its other two, so that one table gives a triangle and its far side.

use nalgebra::{Point2, Vector2};

use crate::arrays::MapEach;
use crate::geometry::polygon::ConvexPolygon;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::{Monomials, weight};

/// The means of all monomials x^a y^b up to a degree over one simplex at a time.
#[derive(Clone, Debug)]
pub(crate) struct PlaneMonomials {
    monomials: Monomials,
    /// For segments and for triangles, in the table's order.
    weights: [Vec<f64>; 2],
    table: Vec<f64>,
}

impl PlaneMonomials {
    /// All monomials of total degree at most `highest`.
    #[must_use]
    pub(crate) fn up_to(highest: u32) -> Self {
        let monomials = Monomials::in_plane(highest);
        let weights = [1, 2].map_each(|dimension| {
            let exponents = monomials.exponents().iter();
            exponents.map(|&powers| weight(dimension, powers)).collect()
        });
        Self {
            monomials,
            weights,
            table: Vec::new(),
        }
    }

    /// Takes the simplex with these corners, or that of the origin and these.
    pub(crate) fn fill(&mut self, corners: [&Vector2<f64>; 2]) {
        let corners = corners.map_each(|corner| [corner.x, corner.y, 0.0]);
        self.monomials.coefficients(&corners, &mut self.table);
    }

    /// The mean of x^a y^b over the simplex, a segment or a triangle (`dimension` 1 or 2).
    #[must_use]
    pub(crate) fn mean(&self, dimension: usize, [a, b]: [u32; 2]) -> f64 {
        // By ascending degree, within a degree by falling powers of x.
        let total = (a + b) as usize;
        let place = total * (total + 1) / 2 + b as usize;
        self.weights[dimension - 1][place] * self.table[place]
    }

    /// The mean of a polynomial of these terms times x^a y^b.
    #[must_use]
    pub(crate) fn mean_of(&self, dimension: usize, terms: &PlaneTerms, [a, b]: [u32; 2]) -> f64 {
        let terms = terms.iter();
        terms
            .map(|([x, y], value)| value * self.mean(dimension, [x + a, y + b]))
            .sum()
    }
}

/// Exponents of x and y with coefficients.
pub(crate) type PlaneTerms = Vec<([u32; 2], f64)>;

/// The terms of a polynomial that does not depend on z.
#[must_use]
pub(crate) fn plane_terms(polynomial: &Polynomial) -> PlaneTerms {
    let terms = polynomial.terms();
    terms.map(|([x, y, _], value)| ([x, y], value)).collect()
}

/// ∫ density · x^a y^b over a polygon for each of the exponents asked for.
#[must_use]
pub(crate) fn over_polygon<const N: usize>(
    polygon: &ConvexPolygon,
    density: &PlaneTerms,
    exponents: [[u32; 2]; N],
) -> [f64; N] {
    let degree = |[a, b]: [u32; 2]| a + b;
    let of_density = density.iter().map(|(powers, _)| degree(*powers)).max();
    let of_factor = exponents.into_iter().map(degree).max();
    let highest = of_density.unwrap_or(0) + of_factor.unwrap_or(0);
    let mut monomials = PlaneMonomials::up_to(highest);
    let mut sums = [0.0; N];
    for edge in polygon.edges() {
        let (start, end) = (edge.start - Point2::origin(), edge.end - Point2::origin());
        let area = 0.5 * start.perp(&end);
        monomials.fill([&start, &end]);
        for (sum, factor) in sums.iter_mut().zip(exponents) {
            *sum += area * monomials.mean_of(2, density, factor);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bounds::Bounds;

    #[test]
    fn a_rectangle_has_the_products_of_powers() {
        // ∫ x^a y^b over [1, 3] × [−1, 2].
        let bounds = Bounds::from_corners([1.0, -1.0], [3.0, 2.0]);
        let rectangle = ConvexPolygon::rectangle(&bounds, [0; 4]);
        let primitive = |x: f64, a: u32| x.powi(a as i32 + 1) / f64::from(a + 1);
        for a in 0..6 {
            for b in 0..6 {
                let expected = (primitive(3.0, a) - primitive(1.0, a))
                    * (primitive(2.0, b) - primitive(-1.0, b));
                let [found] = over_polygon(&rectangle, &vec![([a, 0], 1.0)], [[0, b]]);
                assert!((found / expected - 1.0).abs() < 1e-12, "{a} {b}");
            }
        }
    }
}
