//! The energy of a cell of the plane that consists of convex pieces, perhaps with a density, and what its
//! moving edges add to the gradient of the global objective.
//!
//! The objective Σ_i ∫_{C_i} ρ d∞(x_i, y)^p dy changes with a site also because bisectors move, as in
//! [`crate::energy::facet_terms`]: an edge e of the cell of x_i with the neighbor at r (relative to x_i) adds
//! (1/|r|) ∫_e ρ d∞^p (y − x_i) ds for its own site and −(1/|r|) ∫_e ρ d∞^p (y − x_i − r) ds for the neighbor.

use nalgebra::{Point2, Vector2};

use crate::energy::planar::{FragmentTriangle, energy, energy_with_derivatives, visit_edge};
use crate::energy::planar_density::WeightedSums;
use crate::geometry::label::Label;
use crate::geometry::polygon::ConvexPolygon;
use crate::integrals::planar::over_polygon;
use crate::integrals::polynomial::Polynomial;
use crate::minimize::problem::Evaluation;

/// The energies of one cell, in coordinates relative to its site.
#[derive(Clone, Debug)]
pub(crate) struct PlaneCellEnergy<'a> {
    pieces: &'a [ConvexPolygon],
    density: Option<WeightedSums>,
    order: u32,
}

/// The mass of a cell, its first moment and ∫ ρ |y|₂² about the site.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PlaneMoments {
    pub(crate) mass: f64,
    pub(crate) first: Vector2<f64>,
    pub(crate) second: f64,
}

impl PlaneMoments {
    /// The mass center, relative to the site; the site where there is no mass.
    pub(crate) fn centroid(&self) -> Vector2<f64> {
        if self.mass > 0.0 {
            self.first / self.mass
        } else {
            Vector2::zeros()
        }
    }
}

/// ∫ ρ d∞^p and ∫ ρ d∞^p y over an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeIntegrals {
    pub(crate) label: Label,
    pub(crate) weight: f64,
    pub(crate) first: Vector2<f64>,
}

impl<'a> PlaneCellEnergy<'a> {
    /// The energy of order p = `order` ≥ 1; no density is density 1.
    pub(crate) fn new(
        pieces: &'a [ConvexPolygon],
        order: u32,
        density: Option<Polynomial>,
    ) -> Self {
        Self {
            pieces,
            density: density.map(|density| WeightedSums::new(density, order)),
            order,
        }
    }

    /// The energy about a center with gradient and Hessian.
    pub(crate) fn evaluate(&mut self, center: &Point2<f64>) -> Evaluation<2> {
        let mut total = Evaluation::default();
        let order = self.order;
        let mut add = |part: Evaluation<2>| {
            total.value += part.value;
            total.gradient += part.gradient;
            total.hessian += part.hessian;
        };
        match &mut self.density {
            Some(sums) => {
                let terms = sums.terms(center);
                let of_piece = |piece| sums.energy(piece, (center, &terms), order);
                self.pieces.iter().map(of_piece).for_each(add);
            }
            None => {
                let of_piece = |piece| energy_with_derivatives(piece, center, order);
                self.pieces.iter().map(of_piece).for_each(&mut add);
            }
        }
        total
    }

    /// The energy about the site.
    pub(crate) fn at_site(&mut self) -> f64 {
        if self.density.is_some() {
            return self.evaluate(&Point2::origin()).value;
        }
        let of_piece = |piece| energy(piece, &Point2::origin(), self.order);
        self.pieces.iter().map(of_piece).sum()
    }

    /// The mass alone.
    pub(crate) fn mass(&self) -> f64 {
        match &self.density {
            Some(_) => self.moments().mass,
            None => self.pieces.iter().map(ConvexPolygon::area).sum(),
        }
    }

    /// Mass and its moments.
    pub(crate) fn moments(&self) -> PlaneMoments {
        let terms = match &self.density {
            Some(sums) => sums.terms(&Point2::origin()),
            None => vec![([0, 0], 1.0)],
        };
        let mut moments = PlaneMoments::default();
        for piece in self.pieces {
            let powers = [[0, 0], [1, 0], [0, 1], [2, 0], [0, 2]];
            let [mass, x, y, xx, yy] = over_polygon(piece, &terms, powers);
            moments.mass += mass;
            moments.first += Vector2::new(x, y);
            moments.second += xx + yy;
        }
        moments
    }

    /// Visits the integrals over all edges for whose labels `is_wanted` holds.
    pub(crate) fn visit_edges(
        &mut self,
        is_wanted: impl Fn(Label) -> bool,
        mut visit: impl FnMut(EdgeIntegrals),
    ) {
        let terms = self
            .density
            .as_ref()
            .map(|sums| sums.terms(&Point2::origin()));
        let edges = self.pieces.iter().flat_map(ConvexPolygon::edges);
        for edge in edges.filter(|edge| is_wanted(edge.label)) {
            let (mut weight, mut first) = (0.0, Vector2::zeros());
            visit_edge(&edge.start.coords, &edge.end.coords, &mut |side| {
                let part = match (&mut self.density, &terms) {
                    (Some(sums), Some(terms)) => sums.over_side(&side, terms, self.order),
                    _ => over_side(&side, self.order),
                };
                weight += part.0;
                first += part.1;
            });
            visit(EdgeIntegrals {
                label: edge.label,
                weight,
                first,
            });
        }
    }
}

/// ∫ l^p and ∫ l^p y over the outer side of a triangle, on which l is linear: with the values α, β at its
/// ends, Σ_k α^(p−k) β^k / (p+1) and Σ_k ((p−k+1) a + (k+1) b) α^(p−k) β^k / ((p+1)(p+2)), per length.
fn over_side(side: &FragmentTriangle, order: u32) -> (f64, Vector2<f64>) {
    let length = (side.end - side.start).norm();
    let (from, to) = side.distances();
    let (mut weight, mut first) = (0.0, Vector2::zeros());
    for k in 0..=order {
        let product = from.powi((order - k) as i32) * to.powi(k as i32);
        weight += product;
        first += (side.start * f64::from(order - k + 1) + side.end * f64::from(k + 1)) * product;
    }
    let p = f64::from(order);
    let scale = length / (p + 1.0);
    (weight * scale, first * (scale / (p + 2.0)))
}
