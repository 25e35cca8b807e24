//! The generalized Cauchy point: the first local minimizer of the quadratic model along the
//! projected steepest descent path.
//!
//! \[B\] (see `compact_bfgs`), section 4, Algorithm CP. The path `P(x − t g)` is piecewise
//! linear with a breakpoint wherever a variable meets its bound; the model is a parabola on each
//! segment. Breakpoints come from a heap, so that only those up to the minimizer are sorted.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::DVector;

use crate::minimize::compact_bfgs::CompactBfgs;
use crate::minimize::variable_bounds::{VariableBounds, facing};

/// A point in a box and the gradient there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxedPoint<'a> {
    /// `x`.
    pub(crate) point: &'a [f64],
    /// `g = ∇f(x)`.
    pub(crate) gradient: &'a [f64],
    /// The box.
    pub(crate) bounds: VariableBounds<'a>,
}

/// The generalized Cauchy point.
#[derive(Debug)]
pub(crate) struct CauchyPoint {
    /// `xᶜ`.
    pub(crate) point: Vec<f64>,
    /// `c = Wᵀ (xᶜ − x)`.
    pub(crate) compressed: DVector<f64>,
}

/// A breakpoint of the path (eq. 4.1): when a variable meets its bound.
#[derive(Debug, PartialEq)]
struct Breakpoint {
    time: f64,
    variable: usize,
}

impl Eq for Breakpoint {}

impl Ord for Breakpoint {
    /// The earliest is the greatest, ties by the smaller variable: heaps pop the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        let by_time = other.time.total_cmp(&self.time);
        by_time.then(other.variable.cmp(&self.variable))
    }
}

impl PartialOrd for Breakpoint {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The model along the current piece of the path.
struct PathSegment {
    /// `t` where the piece begins.
    start: f64,
    /// `p = Wᵀ d`.
    direction: DVector<f64>,
    /// `c = Wᵀ (x(t) − x)`.
    compressed: DVector<f64>,
    /// `f′` at the beginning.
    slope: f64,
    /// `f″`.
    curvature: f64,
    /// The least `f″` that rounding leaves, as in the authors' code.
    least_curvature: f64,
}

/// The generalized Cauchy point; `None` if the model is singular.
pub(crate) fn cauchy_point(place: &BoxedPoint, model: &CompactBfgs) -> Option<CauchyPoint> {
    let (mut breakpoints, mut direction) = breakpoints(place);
    let mut point = place.point.to_vec();
    let mut segment = first_segment(&direction, model)?;
    let mut moving = direction.iter().filter(|d| **d != 0.0).count();
    while segment.slope < 0.0 && moving > 0 {
        let to_minimum = -segment.slope / segment.curvature;
        let Some(breakpoint) = breakpoints.pop() else {
            segment.advance(to_minimum);
            break;
        };
        if to_minimum < breakpoint.time - segment.start {
            segment.advance(to_minimum);
            break;
        }
        let variable = breakpoint.variable;
        point[variable] = place.bounds.ahead(variable, direction[variable]);
        direction[variable] = 0.0;
        moving -= 1;
        segment.pass(place, &breakpoint, point[variable], model)?;
    }
    let bounded = direction.iter().zip(place.bounds.iter());
    for (x, (way, (lower, upper))) in point.iter_mut().zip(bounded) {
        *x += segment.start * way;
        *x = x.max(lower).min(upper);
    }
    Some(CauchyPoint {
        point,
        compressed: segment.compressed,
    })
}

/// The breakpoints of the path (eq. 4.1) and its first direction.
fn breakpoints(place: &BoxedPoint) -> (BinaryHeap<Breakpoint>, Vec<f64>) {
    let mut breakpoints = Vec::new();
    let mut direction = vec![0.0; place.point.len()];
    let variables = place.point.iter().zip(place.gradient);
    for (variable, ((&x, &slope), bounds)) in variables.zip(place.bounds.iter()).enumerate() {
        let bound = facing(bounds, -slope);
        let time = (x - bound) / slope;
        if slope == 0.0 || time <= 0.0 {
            continue;
        }
        direction[variable] = -slope;
        if time.is_finite() {
            breakpoints.push(Breakpoint { time, variable });
        }
    }
    (BinaryHeap::from(breakpoints), direction)
}

/// The model on the first segment.
fn first_segment(direction: &[f64], model: &CompactBfgs) -> Option<PathSegment> {
    let compressed = model.transposed_times(direction);
    let length_squared: f64 = direction.iter().map(|d| d * d).sum();
    let curvature =
        model.theta * length_squared - compressed.dot(&model.middle_times(&compressed)?);
    let least_curvature = f64::EPSILON * model.theta * length_squared;
    Some(PathSegment {
        start: 0.0,
        compressed: DVector::zeros(model.width()),
        direction: compressed,
        slope: -length_squared,
        curvature: curvature.max(least_curvature),
        least_curvature,
    })
}

impl PathSegment {
    /// Goes on by `time` without a breakpoint.
    fn advance(&mut self, time: f64) {
        self.start += time;
        self.compressed += &self.direction * time;
    }

    /// Goes to the breakpoint, where a variable stops at `bound`.
    fn pass(
        &mut self,
        place: &BoxedPoint,
        breakpoint: &Breakpoint,
        bound: f64,
        model: &CompactBfgs,
    ) -> Option<()> {
        let time = breakpoint.time - self.start;
        let gradient = place.gradient[breakpoint.variable];
        let moved = bound - place.point[breakpoint.variable];
        let row = model.row(breakpoint.variable);
        let weighted = model.middle_times(&row)?;
        self.advance(time);
        self.slope += time * self.curvature + gradient * gradient + model.theta * gradient * moved
            - gradient * weighted.dot(&self.compressed);
        self.curvature -= model.theta * gradient * gradient
            + 2.0 * gradient * weighted.dot(&self.direction)
            + gradient * gradient * weighted.dot(&row);
        self.curvature = self.curvature.max(self.least_curvature);
        self.direction += row * gradient;
        Some(())
    }
}
