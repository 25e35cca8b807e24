//! Ten moments by adaptive quadrature: the pieces of the largest errors are halved until their sum is
//! small.
//!
//! Every piece has two estimates, of a rule and of a lower one; their difference counts as the error of
//! the better one, or a share of what halving changed, if that is more. Errors add without regard to sign, or,
//! of densities with kinks, as [`Signs::Independent`] says. Pieces are halved in rounds, all that have to be
//! in parallel, and sums run in the pieces' order: the bits do not depend on the number of threads.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::arrays::MapEach;
use crate::geometry::moments::Moments;
use crate::parallel::{map, map_runs};

/// Bounds of the errors of moments measured from a point: of ∫ρ, of the length of ∫ρ y, and of any
/// entry of the inertia tensor's integral.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MomentErrors {
    pub(crate) mass: f64,
    pub(crate) first: f64,
    pub(crate) inertia: f64,
}

impl MomentErrors {
    /// The differences of two estimates.
    pub(crate) fn between(one: &Moments, other: &Moments) -> Self {
        let second = (one.second - other.second).abs();
        let off = second.m12.max(second.m13).max(second.m23);
        Self {
            mass: (one.mass - other.mass).abs(),
            first: (one.first - other.first).norm(),
            inertia: second.trace().max(off),
        }
    }

    /// Of moments measured from a point that lies `arm` from the other one.
    pub(crate) fn moved(&self, arm: f64) -> Self {
        let mass = self.mass;
        Self {
            mass,
            first: self.first + arm * mass,
            // |y + a|² = |y|² + 2 y·a + |a|², and no entry is larger than the trace.
            inertia: self.inertia + 2.0 * arm * self.first + arm * arm * mass,
        }
    }

    /// Of the sum.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first: self.first + other.first,
            inertia: self.inertia + other.inertia,
        }
    }

    /// The larger ones.
    fn or_more(&self, other: &Self) -> Self {
        Self {
            mass: self.mass.max(other.mass),
            first: self.first.max(other.first),
            inertia: self.inertia.max(other.inertia),
        }
    }

    /// The squares of each.
    fn squared(&self) -> Self {
        Self {
            mass: self.mass * self.mass,
            first: self.first * self.first,
            inertia: self.inertia * self.inertia,
        }
    }

    /// The square roots of each.
    fn rooted(&self) -> Self {
        Self {
            mass: self.mass.sqrt(),
            first: self.first.sqrt(),
            inertia: self.inertia.sqrt(),
        }
    }

    /// The smaller ones.
    fn or_less(&self, other: &Self) -> Self {
        Self {
            mass: self.mass.min(other.mass),
            first: self.first.min(other.first),
            inertia: self.inertia.min(other.inertia),
        }
    }

    /// Of a density multiplied by a number.
    pub(crate) fn times(&self, factor: f64) -> Self {
        Self {
            mass: self.mass * factor,
            first: self.first * factor,
            inertia: self.inertia * factor,
        }
    }
}

/// What the errors of moments are compared with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales {
    mass: f64,
    /// Mass times the body's extent.
    first: f64,
    /// The largest entry of the inertia tensor about the center of mass.
    inertia: f64,
    /// The center's distance from the moments' origin.
    arm: f64,
}

impl Scales {
    /// Of moments of a body whose box has a diagonal of `extent`.
    pub(crate) fn of(moments: &Moments, extent: f64) -> Self {
        let center = moments.center();
        let inertia = moments.translated(&-center).inertia();
        Self {
            mass: moments.mass.abs(),
            first: moments.mass.abs() * extent,
            inertia: inertia.amax(),
            arm: center.norm(),
        }
    }

    /// The largest of the relative errors of mass, center of mass (to the extent) and inertia about the
    /// center; errors measured from the moments' origin.
    pub(crate) fn relative(&self, errors: &MomentErrors) -> f64 {
        let about = errors.moved(self.arm);
        let shares = [
            share(about.mass, self.mass),
            share(about.first, self.first),
            share(about.inertia, self.inertia),
        ];
        shares.into_iter().fold(0.0, |most, share| {
            // A share that is no number is larger than any.
            if share <= most { most } else { share }
        })
    }
}

/// The relative error; nothing is nothing of nothing.
fn share(error: f64, size: f64) -> f64 {
    if error <= 0.0 { 0.0 } else { error / size }
}

/// Moments with bounds of their errors.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Estimate {
    pub(crate) moments: Moments,
    pub(crate) errors: MomentErrors,
    /// What the errors were taken from: one estimate less another, with signs.
    pub(crate) difference: Moments,
}

impl Estimate {
    /// The better of two estimates; their difference counts as its error.
    pub(crate) fn of_pair(better: Moments, lower: &Moments) -> Self {
        Self {
            moments: better,
            errors: MomentErrors::between(&better, lower),
            difference: better + *lower * -1.0,
        }
    }
}

/// How the errors of pieces add up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signs {
    /// As if all had one sign: Σ|η|, the bound for smooth densities.
    Unknown,
    /// |Σ η| + 6 √Σ η², or Σ|η| where that is less. A kink crosses every piece elsewhere, so errors that are
    /// not common to all pieces, which |Σ η| holds, have signs of their own, and the sum of N is about √N of
    /// them; six times that leaves room for neighbors whose errors go together.
    Independent,
}

/// How many standard deviations of a sum of errors are taken for its bound.
const DEVIATIONS: f64 = 6.0;

/// The result of [`integrate`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct AdaptiveIntegral {
    pub(crate) estimate: Estimate,
    /// The largest relative error.
    pub(crate) relative: f64,
}

/// A part of the region of integration.
pub(crate) trait AdaptivePiece: Sized + Send + Sync {
    /// The two halves.
    fn halves(&self) -> [Self; 2];
}

/// When [`integrate`] ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// The largest relative error ([`Scales::relative`]).
    pub(crate) tolerance: f64,
    /// The diagonal of the body's box (L).
    pub(crate) extent: f64,
    /// The most pieces.
    pub(crate) most: usize,
    /// How errors add up.
    pub(crate) signs: Signs,
}

/// The share of the tolerance that pieces which are not halved may have together.
const LEFT: f64 = 0.5;

/// So many pieces there are at least: what is small against a piece may escape both of its rules.
const LEAST: usize = 512;

/// Relative errors below this may be rounding, which halving does not lower: where twice as many pieces leave
/// more than half of them, they are.
const MAY_BE_ROUNDING: f64 = 1e-11;

/// The sum over `pieces`, halved until the goal is reached, nothing but rounding is left, or there are too many.
pub(crate) fn integrate<P: AdaptivePiece>(
    mut pieces: Vec<P>,
    goal: Goal,
    estimate: &(impl Fn(&P) -> Estimate + Sync),
) -> AdaptiveIntegral {
    while pieces.len() < LEAST.min(goal.most / 2) {
        pieces = pieces.iter().flat_map(P::halves).collect();
    }
    let mut estimates = map(pieces.len(), &|place| estimate(&pieces[place]));
    let mut before = (pieces.len(), f64::INFINITY);
    loop {
        let sum = total(&estimates, goal.signs);
        let scales = Scales::of(&sum.moments, goal.extent);
        let relative = scales.relative(&sum.errors);
        let is_number = sum.moments.ten().iter().all(|value| value.is_finite());
        let mut is_rounding = false;
        if relative < MAY_BE_ROUNDING && pieces.len() >= 2 * before.0 {
            is_rounding = relative > 0.5 * before.1;
            before = (pieces.len(), relative);
        }
        let is_done = relative <= goal.tolerance || pieces.len() >= goal.most || !is_number;
        if is_done || is_rounding {
            return AdaptiveIntegral {
                estimate: sum,
                relative,
            };
        }
        let worst = worst(&estimates, &scales, &goal);
        let halved = map(worst.len(), &|rank| {
            let place = worst[rank] as usize;
            let own = pieces[place].halves().map(|part| {
                let own = estimate(&part);
                (part, own)
            });
            with_change(own, &estimates[place])
        });
        for (place, [first, second]) in worst.into_iter().zip(halved) {
            (pieces[place as usize], estimates[place as usize]) = first;
            pieces.push(second.0);
            estimates.push(second.1);
        }
    }
}

/// The share of a change by halving that counts as error of either half, if that is more than its own:
/// where a density jumps or bends, both rules of a pair may miss the same.
const CHANGE: f64 = 0.5;

/// Halves whose errors are at least a share of how much halving changed their sum.
fn with_change<P>(halves: [(P, Estimate); 2], whole: &Estimate) -> [(P, Estimate); 2] {
    let sum = halves[0].1.moments + halves[1].1.moments;
    let change = Estimate::of_pair(sum, &whole.moments);
    let errors = change.errors.times(CHANGE);
    halves.map_each(|(part, own)| {
        let is_more = errors.mass > own.errors.mass;
        let difference = match is_more {
            true => change.difference * CHANGE,
            false => own.difference,
        };
        let errors = own.errors.or_more(&errors);
        let changed = Estimate {
            errors,
            difference,
            ..own
        };
        (part, changed)
    })
}

/// The places of the worst pieces, in ascending order: so many that the others' errors are a share of the
/// tolerance.
fn worst(estimates: &[Estimate], scales: &Scales, goal: &Goal) -> Vec<u32> {
    let mut ranked: Vec<(f64, u32)> = (estimates.par_iter().zip(0..estimates.len() as u32))
        .map(|(estimate, place)| (scales.relative(&estimate.errors), place))
        .collect();
    ranked.par_sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let allowed = LEFT * goal.tolerance;
    let (weight, allowed): (fn(f64) -> f64, f64) = match goal.signs {
        Signs::Unknown => (|error| error, allowed),
        Signs::Independent => (|error| error * error, (allowed / DEVIATIONS).powi(2)),
    };
    let mut rest: f64 = ranked.iter().map(|(error, _)| weight(*error)).sum();
    let room = goal.most - estimates.len();
    let taken = ranked.iter().take(room).take_while(|(error, _)| {
        let is_needed = rest > allowed;
        rest -= weight(*error);
        is_needed
    });
    let mut places: Vec<u32> = taken.map(|(_, place)| *place).collect();
    if places.is_empty() {
        places.extend(ranked.first().map(|(_, place)| *place));
    }
    places.sort_unstable();
    places
}

/// Pieces that are added one after the other before sums are added.
const RUN: usize = 256;

/// The sum of estimates, its errors as their signs allow.
fn total(estimates: &[Estimate], signs: Signs) -> Estimate {
    let add = |(sum, squares): (Estimate, MomentErrors), next: &Estimate| {
        let squares = squares.plus(&next.errors.squared());
        (joined(&sum, next), squares)
    };
    let mut sums: Vec<(Estimate, MomentErrors)> = map_runs(estimates.len(), RUN, |run| {
        estimates[run].iter().fold(Default::default(), add)
    });
    while sums.len() > 1 {
        let pairs = sums.chunks(2);
        sums = pairs
            .map(|pair| {
                let rest = pair[1..].iter();
                rest.fold(pair[0], |(sum, squares), (next, more)| {
                    (joined(&sum, next), squares.plus(more))
                })
            })
            .collect();
    }
    let (sum, squares) = sums.pop().unwrap_or_default();
    match signs {
        Signs::Unknown => sum,
        Signs::Independent => {
            let common = MomentErrors::between(&sum.difference, &Moments::default());
            let likely = common.plus(&squares.rooted().times(DEVIATIONS));
            let errors = sum.errors.or_less(&likely);
            Estimate { errors, ..sum }
        }
    }
}

fn joined(one: &Estimate, other: &Estimate) -> Estimate {
    Estimate {
        moments: one.moments + other.moments,
        errors: one.errors.plus(&other.errors),
        difference: one.difference + other.difference,
    }
}

/// Adds `weight` at `place` to moments.
pub(crate) fn add_mass(moments: &mut Moments, weight: f64, place: &Vector3<f64>) {
    moments.mass += weight;
    moments.first += place * weight;
    moments.second += place * place.transpose() * weight;
}

/// `count` Gauss-Legendre nodes and weights on [0, 1], by Newton's iteration on the Legendre polynomial.
pub(crate) fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let node = |k: usize| {
        let mut x = (std::f64::consts::PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut before, mut value) = (1.0, x);
            for degree in 2..=count {
                let d = degree as f64;
                (before, value) = (
                    value,
                    ((2.0 * d - 1.0) * x * value - (d - 1.0) * before) / d,
                );
            }
            slope = n * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

/// The longest of a triangle's edges, by the number of its first corner, and its square.
pub(crate) fn longest_edge(corners: &[Point3<f64>; 3]) -> (usize, f64) {
    let squared = |k: usize| (corners[(k + 1) % 3] - corners[k]).norm_squared();
    let longest = (1..3).fold(
        0,
        |best, k| if squared(k) > squared(best) { k } else { best },
    );
    (longest, squared(longest))
}

/// A triangle halved across its longest edge.
pub(crate) fn halved(corners: &[Point3<f64>; 3]) -> [[Point3<f64>; 3]; 2] {
    let (start, _) = longest_edge(corners);
    let end = (start + 1) % 3;
    let middle = nalgebra::center(&corners[start], &corners[end]);
    let (mut first, mut second) = (*corners, *corners);
    first[end] = middle;
    second[start] = middle;
    [first, second]
}
