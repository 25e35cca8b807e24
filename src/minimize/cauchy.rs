//! The generalized Cauchy point: the first local minimizer of the quadratic model along the
//! projected steepest descent path.
//!
//! \[B\] (see `compact`), section 4, Algorithm CP. The path `P(x − t g)` is piecewise
//! linear with a corner wherever a variable meets its bound; the model is a parabola on each
//! piece. Corners come from a heap, so that only those up to the minimizer are sorted.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::DVector;

use crate::minimize::compact::Compact;

/// A point in a box and the gradient there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<'a> {
    /// `x`.
    pub(crate) point: &'a [f64],
    /// `g = ∇f(x)`.
    pub(crate) gradient: &'a [f64],
    /// `l`.
    pub(crate) lower: &'a [f64],
    /// `u`.
    pub(crate) upper: &'a [f64],
}

/// The generalized Cauchy point.
#[derive(Debug)]
pub(crate) struct CauchyPoint {
    /// `xᶜ`.
    pub(crate) point: Vec<f64>,
    /// `c = Wᵀ (xᶜ − x)`.
    pub(crate) compressed: DVector<f64>,
}

/// When the path meets a bound.
#[derive(Debug, PartialEq)]
struct Corner {
    time: f64,
    variable: usize,
}

impl Eq for Corner {}

impl Ord for Corner {
    /// The earliest is the greatest, ties by the smaller variable: heaps pop the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        let by_time = other.time.total_cmp(&self.time);
        by_time.then(other.variable.cmp(&self.variable))
    }
}

impl PartialOrd for Corner {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The model along the current piece of the path.
struct Piece {
    /// `t` where the piece begins.
    start: f64,
    /// `p = Wᵀ d`.
    direction: DVector<f64>,
    /// `c = Wᵀ (x(t) − x)`.
    compressed: DVector<f64>,
    /// `f′` at the beginning.
    slope: f64,
    /// `f″`.
    bend: f64,
    /// The least `f″` that rounding leaves, as in the authors' code.
    least_bend: f64,
}

/// The generalized Cauchy point; `None` if the model is singular.
pub(crate) fn cauchy_point(place: &Place, model: &Compact) -> Option<CauchyPoint> {
    let (mut corners, mut direction) = corners(place);
    let mut point = place.point.to_vec();
    let mut piece = first_piece(&direction, model)?;
    let mut moving = direction.iter().filter(|d| **d != 0.0).count();
    while piece.slope < 0.0 && moving > 0 {
        let to_minimum = -piece.slope / piece.bend;
        let Some(corner) = corners.pop() else {
            piece.advance(to_minimum);
            break;
        };
        if to_minimum < corner.time - piece.start {
            piece.advance(to_minimum);
            break;
        }
        let variable = corner.variable;
        point[variable] = if direction[variable] > 0.0 {
            place.upper[variable]
        } else {
            place.lower[variable]
        };
        direction[variable] = 0.0;
        moving -= 1;
        piece.turn(place, &corner, point[variable], model)?;
    }
    for (variable, x) in point.iter_mut().enumerate() {
        *x += piece.start * direction[variable];
        *x = x.max(place.lower[variable]).min(place.upper[variable]);
    }
    Some(CauchyPoint {
        point,
        compressed: piece.compressed,
    })
}

/// The corners of the path (eq. 4.1) and its first direction.
fn corners(place: &Place) -> (BinaryHeap<Corner>, Vec<f64>) {
    let mut corners = Vec::new();
    let mut direction = vec![0.0; place.point.len()];
    for (variable, (&x, &slope)) in place.point.iter().zip(place.gradient).enumerate() {
        let bound = if slope < 0.0 {
            place.upper[variable]
        } else {
            place.lower[variable]
        };
        let time = (x - bound) / slope;
        if slope == 0.0 || time <= 0.0 {
            continue;
        }
        direction[variable] = -slope;
        if time.is_finite() {
            corners.push(Corner { time, variable });
        }
    }
    (BinaryHeap::from(corners), direction)
}

/// The model on the first piece.
fn first_piece(direction: &[f64], model: &Compact) -> Option<Piece> {
    let compressed = model.transposed_times(direction);
    let length_squared: f64 = direction.iter().map(|d| d * d).sum();
    let bend = model.theta * length_squared - compressed.dot(&model.middle_times(&compressed)?);
    let least_bend = f64::EPSILON * model.theta * length_squared;
    Some(Piece {
        start: 0.0,
        compressed: DVector::zeros(model.width()),
        direction: compressed,
        slope: -length_squared,
        bend: bend.max(least_bend),
        least_bend,
    })
}

impl Piece {
    /// Goes on by `time` without a corner.
    fn advance(&mut self, time: f64) {
        self.start += time;
        self.compressed += &self.direction * time;
    }

    /// Goes to the corner, where a variable stops at `bound`.
    fn turn(&mut self, place: &Place, corner: &Corner, bound: f64, model: &Compact) -> Option<()> {
        let time = corner.time - self.start;
        let gradient = place.gradient[corner.variable];
        let moved = bound - place.point[corner.variable];
        let row = model.row(corner.variable);
        let weighted = model.middle_times(&row)?;
        self.advance(time);
        self.slope += time * self.bend + gradient * gradient + model.theta * gradient * moved
            - gradient * weighted.dot(&self.compressed);
        self.bend -= model.theta * gradient * gradient
            + 2.0 * gradient * weighted.dot(&self.direction)
            + gradient * gradient * weighted.dot(&row);
        self.bend = self.bend.max(self.least_bend);
        self.direction += row * gradient;
        Some(())
    }
}
