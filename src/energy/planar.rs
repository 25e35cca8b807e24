//! The Chebyshev energy ∫ d∞(c, y)^p dy of a convex polygon about a center c, with its exact
//! gradient and Hessian in c. Section 3 of \[BL\], one dimension lower.
//!
//! The diagonals through c cut the plane into four quarters, on each of which the distance is one
//! linear function l = s (y_k − c_k): the fragment F of axis k and sign s is the polygon's part in
//! its quarter. Every edge, cut at the diagonals, spans a triangle with c that lies in one
//! fragment. On a triangle with the values 0, α, β at its corners
//!
//! ∫ l^p dA = A · 2! p! / (2 + p)! · h_p(0, α, β),
//!
//! h_p the complete homogeneous symmetric polynomial: the sum of α^i β^(p−i). Areas are signed, so
//! everything stays exact when c lies outside the polygon.
//!
//! Gradient: the fragments' boundaries move with c, but the integrand does not jump there, so
//! ∂E/∂c_k = −Σ_s s p ∫ l^(p−1) over the two fragments of axis k; for p = 1, the difference of
//! their areas.
//!
//! Hessian: p (p − 1) ∫ l^(p−2) over the fragments of axis k on the diagonal, and from the moving
//! interfaces (p/√2) ∫ l^(p−1) ds · w wᵀ with w = s_i e_i − s_j e_j. An interface is a ray from c
//! along (±1, ±1), on which ds = √2 dl: where it leaves the polygon at distance l it contributes
//! l^p, where it enters −l^p.

use nalgebra::{Point2, Vector2};

use crate::arrays::MapEach;
use crate::geometry::polygon::ConvexPolygon;
use crate::integrals::simplex::linear_power;
use crate::minimize::problem::Evaluation;

/// A triangle between the center and a part of an edge, wholly in one fragment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FragmentTriangle {
    /// The fragment's axis k: 0 or 1.
    pub axis: usize,
    /// The fragment's sign s: −1 or 1.
    pub sign: f64,
    /// Where the part of the edge begins, relative to the center.
    pub start: Vector2<f64>,
    /// Where it ends, relative to the center.
    pub end: Vector2<f64>,
}

impl FragmentTriangle {
    /// The area (L²), negative if the triangle counts from outside the polygon.
    #[must_use]
    pub(crate) fn signed_area(&self) -> f64 {
        0.5 * self.start.perp(&self.end)
    }

    /// The Chebyshev distances of the two outer corners from the center (L).
    #[must_use]
    pub(crate) fn distances(&self) -> (f64, f64) {
        (
            self.sign * self.start[self.axis],
            self.sign * self.end[self.axis],
        )
    }
}

/// ∫ d∞(center, y)^p dy over `polygon` (L^(2+p)), for p = `order` ≥ 1.
#[must_use]
pub(crate) fn energy(polygon: &ConvexPolygon, center: &Point2<f64>, order: u32) -> f64 {
    let mut value = 0.0;
    visit(polygon, center, |triangle| {
        value += power_integral(&triangle, order);
    });
    value
}

/// The energy of order p = `order` ≥ 1 with gradient and Hessian, in one loop over the edges.
#[must_use]
pub(crate) fn energy_with_derivatives(
    polygon: &ConvexPolygon,
    center: &Point2<f64>,
    order: u32,
) -> Evaluation<2> {
    let (mut energy, p) = (Evaluation::default(), f64::from(order));
    visit(polygon, center, |triangle| {
        let (axis, slope) = (triangle.axis, triangle.sign * p);
        energy.value += power_integral(&triangle, order);
        energy.gradient[axis] -= slope * power_integral(&triangle, order.saturating_sub(1));
        let second = order.checked_sub(2);
        let second = second.map_or(0.0, |power| power_integral(&triangle, power));
        energy.hessian[(axis, axis)] += p * (p - 1.0) * second;
    });
    visit_interfaces(polygon, center, |cut, turn, w| {
        let weight = power_of(reach(cut), order).copysign(turn);
        energy.hessian += w * w.transpose() * weight;
    });
    energy
}

/// Visits the triangles between the parts of the edges and the center, in the order of the edges.
pub(crate) fn visit(
    polygon: &ConvexPolygon,
    center: &Point2<f64>,
    mut take: impl FnMut(FragmentTriangle),
) {
    for edge in polygon.edges() {
        visit_edge(&(edge.start - center), &(edge.end - center), &mut take);
    }
}

/// Visits the triangles between the parts of one edge and the center, given relative to the center.
pub(crate) fn visit_edge(
    start: &Vector2<f64>,
    end: &Vector2<f64>,
    take: &mut impl FnMut(FragmentTriangle),
) {
    let mut from = *start;
    for cut in diagonal_crossings(start, end).into_iter().flatten() {
        take(triangle(from, cut));
        from = cut;
    }
    take(triangle(from, *end));
}

/// Where the segment crosses the diagonals, in the order in which it does.
fn diagonal_crossings(start: &Vector2<f64>, end: &Vector2<f64>) -> [Option<Vector2<f64>>; 2] {
    let rising = crossing_share(start.x - start.y, end.x - end.y);
    let falling = crossing_share(start.x + start.y, end.x + end.y);
    let (first, second) = match (rising, falling) {
        (Some(r), Some(f)) if f < r => (falling, rising),
        _ => (rising, falling),
    };
    [first, second].map_each(|share| share.map(|t| start + (end - start) * t))
}

/// Where a linear function with these values at the ends of a segment vanishes, if it changes
/// sign. Zero counts as negative, so a vertex on a diagonal is crossed by one of its two edges.
fn crossing_share(start: f64, end: f64) -> Option<f64> {
    ((start > 0.0) != (end > 0.0)).then(|| start / (start - end))
}

fn triangle(start: Vector2<f64>, end: Vector2<f64>) -> FragmentTriangle {
    let middle = start + end;
    let axis = usize::from(middle.y.abs() > middle.x.abs());
    FragmentTriangle {
        axis,
        sign: 1.0_f64.copysign(middle[axis]),
        start,
        end,
    }
}

/// ∫ l^power over the triangle.
fn power_integral(triangle: &FragmentTriangle, power: u32) -> f64 {
    let (start, end) = triangle.distances();
    linear_power(triangle.signed_area(), &[0.0, start, end], power)
}

/// Visits where the rays along the diagonals cross the edges: the point relative to the center, how the
/// edge turns about the center, and the ray's w. Counter-clockwise about the center (a turn above zero) the
/// ray leaves the polygon; clockwise, it enters.
pub(crate) fn visit_interfaces(
    polygon: &ConvexPolygon,
    center: &Point2<f64>,
    mut take: impl FnMut(&Vector2<f64>, f64, Vector2<f64>),
) {
    for edge in polygon.edges() {
        let (start, end) = (edge.start - center, edge.end - center);
        let turn = start.perp(&end);
        if turn == 0.0 {
            continue;
        }
        for cut in diagonal_crossings(&start, &end).into_iter().flatten() {
            let w = Vector2::new(1.0_f64.copysign(cut.x), -1.0_f64.copysign(cut.y));
            take(&cut, turn, w);
        }
    }
}

/// The Chebyshev distance of a point of a diagonal from the center (L).
pub(crate) fn reach(cut: &Vector2<f64>) -> f64 {
    0.5 * (cut.x.abs() + cut.y.abs())
}

pub(crate) fn power_of(base: f64, order: u32) -> f64 {
    (0..order).fold(1.0, |power, _| power * base)
}
