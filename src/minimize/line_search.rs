//! A step along a descent direction that satisfies the strong Wolfe conditions.
//!
//! Nocedal & Wright, *Numerical Optimization*, 2nd ed., Algorithms 3.5 (bracket) and 3.6 (zoom)
//! in one loop: `low` is the best fraction so far, `high` the other end once there is one.
//!
//! # Safeguards
//!
//! * A trial that is not finite counts as too high.
//! * Interpolated trials keep off both ends, and an interval that shrinks slowly is bisected.
//! * Where the change of the value drowns in rounding, the slope decides (Hager & Zhang, SIAM J.
//!   Optim. 16, 2005, eq. 4.1), and the secant of slopes gives the next trial.
//! * At the longest fraction allowed, sufficient decrease is enough; so it is when the
//!   trials run out.

use crate::minimize::problem::Termination;

/// Sufficient decrease (Nocedal & Wright, section 3.1).
const DECREASE: f64 = 1e-4;
/// Curvature: the slope must shrink to this share; loose, as quasi-Newton methods like it.
const CURVATURE: f64 = 0.9;
/// Trials of one search; halving 30 times leaves 1e-9 of the first step.
const MAX_TRIALS: u32 = 30;
/// Up to this many times the rounding of values, a gain that does not come is put down to it.
const SMALL_GAIN: f64 = 1e3;
/// How much farther the next trial goes while the function still falls steeply.
const STRETCH: (f64, f64) = (1.5, 4.0);
/// Interpolated trials keep this share of the interval away from its ends.
const MARGIN: f64 = 0.1;
/// The interval is bisected unless two trials shrank it to this share (Moré & Thuente).
const SHRINKAGE: f64 = 0.66;
/// Where the next trial is put after one that is not finite.
const RETREAT: f64 = 0.2;

/// The function on the line at one fraction of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Trial {
    /// The fraction of the step.
    pub(crate) fraction: f64,
    /// `φ(fraction)`.
    pub(crate) value: f64,
    /// `φ′(fraction)`.
    pub(crate) slope: f64,
}

/// A function along a line.
pub(crate) trait Line {
    /// Evaluates at a fraction; `None` once no evaluation is left.
    fn evaluate(&mut self, fraction: f64) -> Option<Trial>;

    /// Keeps the trial last evaluated as the best so far.
    fn keep(&mut self);
}

/// What is known before the search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineSearch {
    /// The trial at fraction 0; its slope is negative.
    pub(crate) start: Trial,
    /// The first fraction to try.
    pub(crate) first: f64,
    /// The longest fraction allowed.
    pub(crate) longest: f64,
    /// Changes of the value up to this are rounding.
    pub(crate) rounding: f64,
}

/// Searches along the line and returns the trial kept last.
///
/// # Errors
///
/// Why there is none: rounding, no descent, or no evaluation left.
pub(crate) fn line_search(search: &LineSearch, line: &mut impl Line) -> Result<Trial, Termination> {
    let mut low = search.start;
    let mut high: Option<Trial> = None;
    let mut fraction = search.first.min(search.longest);
    let mut widths = [f64::INFINITY; 2];
    for _ in 0..MAX_TRIALS {
        let Some(trial) = line.evaluate(fraction) else {
            return kept(search, low, Termination::EvaluationLimit);
        };
        if search.is_high(&trial, &low) {
            if search.promises_at_most(search.rounding, fraction) && !search.is_past(&trial) {
                return kept(search, low, search.failure());
            }
            high = Some(trial);
        } else {
            line.keep();
            if search.is_flat(&trial) || (high.is_none() && fraction >= search.longest) {
                return Ok(trial);
            }
            let before = low;
            low = trial;
            if trial.slope * (high.map_or(1.0, |high| high.fraction - fraction)) >= 0.0 {
                high = Some(before);
            } else if high.is_none() {
                fraction = stretched(&before, &trial).min(search.longest);
                continue;
            }
        }
        let Some(high) = high else { continue };
        let width = (high.fraction - low.fraction).abs();
        fraction = match search.is_past(&high) && low.slope * width < 0.0 {
            true => root_of_slopes(&low, &high),
            false => between(&low, &high, width > SHRINKAGE * widths[0]),
        };
        widths = [widths[1], width];
    }
    kept(search, low, search.failure())
}

/// The best trial if it is lower than the start, else why there is none.
fn kept(search: &LineSearch, low: Trial, ended: Termination) -> Result<Trial, Termination> {
    if low.value < search.start.value {
        Ok(low)
    } else {
        Err(ended)
    }
}

impl LineSearch {
    /// Whether the trial does not lower the function enough, or not below the best.
    fn is_high(&self, trial: &Trial, low: &Trial) -> bool {
        if !(trial.value.is_finite() && trial.slope.is_finite()) {
            return true;
        }
        let change = trial.value - self.start.value;
        let enough = change <= DECREASE * trial.fraction * self.start.slope
            || (change.abs() <= self.rounding
                && trial.slope <= (2.0 * DECREASE - 1.0) * self.start.slope);
        !enough || trial.value > low.value + self.rounding
    }

    /// Whether the slope has shrunk enough.
    fn is_flat(&self, trial: &Trial) -> bool {
        trial.slope.abs() <= -CURVATURE * self.start.slope
    }

    /// Whether a trial's value differs from the start's by rounding alone while its slope says that it lies
    /// beyond the minimum: then slopes tell where that is.
    fn is_past(&self, trial: &Trial) -> bool {
        (trial.value - self.start.value).abs() <= self.rounding && trial.slope > 0.0
    }

    /// Whether the slope promises no more than `change` at `fraction`.
    fn promises_at_most(&self, change: f64, fraction: f64) -> bool {
        -fraction * self.start.slope <= change
    }

    /// Why a search found nothing lower: it never had much to gain, or the slope is wrong.
    fn failure(&self) -> Termination {
        if self.promises_at_most(SMALL_GAIN * self.rounding, self.first) {
            Termination::AtRounding
        } else {
            Termination::NoDescent
        }
    }
}

/// The next trial beyond `last`: where the secant of the slopes vanishes, within [`STRETCH`].
fn stretched(before: &Trial, last: &Trial) -> f64 {
    let rise = (last.slope - before.slope) / (last.fraction - before.fraction);
    let zero = last.fraction - last.slope / rise;
    let (least, most) = (STRETCH.0 * last.fraction, STRETCH.1 * last.fraction);
    if rise > 0.0 {
        zero.clamp(least, most)
    } else {
        most
    }
}

/// The next trial between both ends.
fn between(low: &Trial, high: &Trial, bisect: bool) -> f64 {
    let width = high.fraction - low.fraction;
    let share = if !(high.value.is_finite() && high.slope.is_finite()) {
        RETREAT
    } else if bisect {
        0.5
    } else {
        cubic_minimum(low, high).clamp(MARGIN, 1.0 - MARGIN)
    };
    low.fraction + share * width
}

/// Where the secant of the slopes vanishes between two trials.
fn root_of_slopes(low: &Trial, high: &Trial) -> f64 {
    let share = low.slope / (low.slope - high.slope);
    low.fraction + share.clamp(MARGIN, 1.0 - MARGIN) * (high.fraction - low.fraction)
}

/// Where between `low` (0) and `high` (1) the cubic through values and slopes is least (Nocedal
/// & Wright, eq. 3.59); the middle if that is undefined.
fn cubic_minimum(low: &Trial, high: &Trial) -> f64 {
    let width = high.fraction - low.fraction;
    let (slope_low, slope_high) = (low.slope * width, high.slope * width);
    let first = slope_low + slope_high - 3.0 * (high.value - low.value);
    let second = (first * first - slope_low * slope_high).sqrt();
    let share = 1.0 - (slope_high + second - first) / (slope_high - slope_low + 2.0 * second);
    if share.is_finite() { share } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Curve<F: Fn(f64) -> (f64, f64)> {
        curve: F,
        trials: u32,
    }

    impl<F: Fn(f64) -> (f64, f64)> Line for Curve<F> {
        fn evaluate(&mut self, fraction: f64) -> Option<Trial> {
            self.trials += 1;
            let (value, slope) = (self.curve)(fraction);
            Some(Trial {
                fraction,
                value,
                slope,
            })
        }

        fn keep(&mut self) {}
    }

    /// Checks the strong Wolfe conditions and returns how many trials it took.
    fn trials_of(curve: impl Fn(f64) -> (f64, f64), first: f64) -> u32 {
        let (value, slope) = curve(0.0);
        let start = Trial {
            fraction: 0.0,
            value,
            slope,
        };
        let search = LineSearch {
            start,
            first,
            longest: 1e10,
            rounding: 1e-15,
        };
        let mut line = Curve { curve, trials: 0 };
        let found = line_search(&search, &mut line).unwrap();
        assert!(found.value <= value + DECREASE * found.fraction * slope);
        assert!(found.slope.abs() <= CURVATURE * slope.abs());
        line.trials
    }

    #[test]
    fn wolfe_conditions_hold_on_the_curves_of_more_and_thuente() {
        // Moré & Thuente, ACM TOMS 20, 1994, section 5, functions 1 and 2.
        let one = |a: f64| {
            let b = 2.0;
            (-a / (a * a + b), (a * a - b) / ((a * a + b) * (a * a + b)))
        };
        let two = |a: f64| {
            let c = a + 0.004;
            (
                c.powi(5) - 2.0 * c.powi(4),
                5.0 * c.powi(4) - 8.0 * c.powi(3),
            )
        };
        for first in [1e-3, 0.1, 10.0, 1e3] {
            assert!(trials_of(one, first) <= 12);
            assert!(trials_of(two, first) <= 16);
        }
    }

    #[test]
    fn a_wall_of_nan_is_backed_off_from() {
        let wall = |a: f64| (-a - (1e-3 - a).ln() * 5e-4, -1.0 + 5e-4 / (1e-3 - a));
        assert!(trials_of(|a| if a < 1e-3 { wall(a) } else { (f64::NAN, 0.0) }, 1.0) <= 12);
    }

    #[test]
    fn the_cubic_is_exact_for_cubics() {
        let at = |x: f64| Trial {
            fraction: x,
            value: x * x * x - 3.0 * x,
            slope: 3.0 * x * x - 3.0,
        };
        assert!((cubic_minimum(&at(0.0), &at(2.0)) - 0.5).abs() < 1e-14);
        assert!((cubic_minimum(&at(1.5), &at(-0.5)) - 0.25).abs() < 1e-14);
    }
}
