//! Densities with which a solid spins: its center of mass on an axis, the axis a principal one, and on
//! request the one of the largest moment (\[BL\] section 3.2).
//!
//! Center and products of inertia are linear in the density, the largest moment is a second-order cone:
//! √(((J_uu − J_vv)/2)² + J_uv²) ≤ (J_uu + J_vv)/2 − J_zz, J the second moments about the center, u and v across
//! the axis: the half-spaces of all directions across it. The one that is violated most is added until none
//! is: two that are δ apart miss the cone by δ²/8 between them, so that the last ones are the tangent at the
//! optimum to rounding. J_zz is taken about a fixed height, the center's in the field before, until the two agree.

use nalgebra::{DVector, Matrix2, Point3, SymmetricEigen, Vector3};

use crate::arrays::MapEach;
use crate::balance::conditions::{Condition, SpinAxis};
use crate::balance::contrast::{RangeGrowth, least_growth};
use crate::balance::dual::DensityRange;
use crate::balance::elements::Elements;
use crate::balance::solve::{LeastVariance, SolveEnd, least_variance};
use crate::geometry::moments::Moments;
use crate::integrals::pairwise::sum_by_halves;
use crate::mass::body::Body;

/// A violation of the cone below this share of the moments is rounding.
const CONE_ROUNDING: f64 = 1e-12;

/// Heights of the center that agree to this share of the radius of gyration are the same.
const SAME_HEIGHT: f64 = 1e-10;

/// More half-spaces of the cone than any case needs.
const MOST_CUTS: usize = 60;

/// A half-space of the cone nearer than this (radians) to a new one gives way to it.
const SAME_CUT: f64 = 1e-7;

/// What is wanted of a body that spins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpinWish {
    /// The axis; heights are measured from its point.
    pub(crate) axis: SpinAxis,
    /// Whether the axis is to be a principal one.
    pub(crate) principal: bool,
    /// The height of the center.
    pub(crate) center_at: Option<f64>,
    /// The axis's moment exceeds all others by this share of them.
    pub(crate) stable: Option<f64>,
    /// The moment of inertia about the axis.
    pub(crate) moment: Option<f64>,
    /// The mass.
    pub(crate) mass: Option<f64>,
    /// The ratio of that moment to the mass.
    pub(crate) gyration_squared: Option<f64>,
}

/// A body of elements, whose moments are measured from the axis's point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpinBody<'a> {
    /// Of each element at density 1.
    pub(crate) moments: &'a [Moments],
    /// The axis.
    pub(crate) axis: SpinAxis,
}

/// How a body of some density spins about an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpinState {
    /// Its mass properties.
    pub(crate) body: Body,
    /// The center's distance from the axis.
    pub(crate) distance: f64,
    /// The center's height along the axis, from its point.
    pub(crate) height: f64,
    /// The angle between the axis and the nearest principal axis, in degrees.
    pub(crate) angle_degrees: f64,
    /// That principal axis, turned the way of the axis.
    pub(crate) nearest_axis: Vector3<f64>,
    /// The place of its moment among the principal ones: 0 the least, 2 the largest.
    pub(crate) moment_rank: usize,
}

/// A field that was asked for, or why there is none.
#[derive(Clone, Debug)]
pub(crate) struct SpinSolution {
    /// The conditions that the field meets.
    pub(crate) conditions: Vec<Condition>,
    /// Their multipliers, or the proof.
    pub(crate) variance: LeastVariance,
    /// One for each element.
    pub(crate) densities: Vec<f64>,
    /// Iterations of all solutions on the way.
    pub(crate) iterations: usize,
    /// Evaluations of the dual of all solutions on the way.
    pub(crate) evaluations: usize,
}

/// The least contrast, and what proves it.
#[derive(Clone, Debug)]
pub(crate) struct SpinContrast {
    /// κ*: that of the range that begins at `low`.
    pub(crate) contrast: f64,
    /// φ_λ: no density of a lower contrast has ∫ d φ_λ ≥ 0.
    pub(crate) certificate: Condition,
    /// Evaluations.
    pub(crate) evaluations: usize,
}

impl SpinWish {
    /// The conditions without those of the cone.
    pub(crate) fn conditions(&self) -> Vec<Condition> {
        let axis = &self.axis;
        let mut all = axis.center_on().to_vec();
        if self.principal {
            all.extend(axis.principal());
        }
        all.extend(self.center_at.map(|height| axis.center_at(height)));
        all.extend(self.moment.map(|moment| axis.moment(moment)));
        all.extend(self.mass.map(Condition::mass));
        all.extend(self.gyration_squared.map(|ratio| Condition {
            constant: -ratio,
            ..axis.moment(0.0)
        }));
        all
    }

    /// A half-space of the cone, seen from a height of the center.
    fn cut(&self, height: f64, angle: f64) -> Condition {
        let share = self.stable.unwrap_or(0.0);
        self.axis.moved_to(height).stable_against(angle, share)
    }
}

impl SpinState {
    /// Of a body whose `moments` are measured from the axis's point.
    pub(crate) fn of(moments: &Moments, volume: f64, area: f64, axis: &SpinAxis) -> Self {
        let body = Body::from_moments(volume, area, moments, &axis.through);
        Self::seen(body, moments.center(), axis)
    }

    /// Of a body.
    pub(crate) fn about(body: Body, axis: &SpinAxis) -> Self {
        Self::seen(body, body.center_of_mass() - axis.through, axis)
    }

    /// Of a body whose center lies at `center` from the axis's point.
    fn seen(body: Body, center: Vector3<f64>, axis: &SpinAxis) -> Self {
        let principal = body.principal();
        let along = axis.along.as_ref();
        let alignment = |place: &usize| principal.axes[*place].dot(along).abs();
        let nearest = (0..3).max_by(|a, b| alignment(a).total_cmp(&alignment(b)));
        let place = nearest.unwrap_or_default();
        let found = principal.axes[place];
        let nearest_axis = found * found.dot(along).signum();
        let [u, v] = axis.across.map_each(|across| across.dot(&center));
        let angle = nearest_axis
            .cross(along)
            .norm()
            .atan2(nearest_axis.dot(along));
        Self {
            body,
            distance: u.hypot(v),
            height: along.dot(&center),
            angle_degrees: angle.to_degrees(),
            nearest_axis,
            moment_rank: place,
        }
    }

    /// By how much the largest moment about lines across the axis through the center, times 1 + `share`,
    /// exceeds that about the axis, as a share of the latter, and that line's angle.
    pub(crate) fn instability(&self, axis: &SpinAxis, share: f64) -> (f64, f64) {
        let inertia = self.body.inertia_center();
        let along = axis.along.as_ref();
        let about = along.dot(&(inertia * along));
        let [u, v] = axis.across;
        let entry = |a: &Vector3<f64>, b: &Vector3<f64>| a.dot(&(inertia * b));
        let across = Matrix2::new(entry(&u, &u), entry(&u, &v), entry(&v, &u), entry(&v, &v));
        let eigen = SymmetricEigen::new(across);
        let largest = eigen.eigenvalues.imax();
        let direction = eigen.eigenvectors.column(largest);
        let excess = (1.0 + share) * eigen.eigenvalues[largest] - about;
        (excess / about, direction[1].atan2(direction[0]))
    }
}

impl SpinBody<'_> {
    /// The moments at one density for each element.
    pub(crate) fn weigh(&self, density: impl Fn(usize) -> f64 + Sync) -> Moments {
        sum_by_halves(self.moments.len(), &|range| {
            range.fold(Moments::default(), |sum, element| {
                sum + self.moments[element] * density(element)
            })
        })
    }

    /// The elements under conditions.
    fn under(&self, conditions: &[Condition]) -> Elements {
        let nothing = Moments::default();
        Elements::of_moments(conditions, self.moments, &nothing, &self.axis.through)
    }

    /// The field of the least variance within `range` that meets a wish.
    pub(crate) fn spin(&self, wish: &SpinWish, range: &DensityRange) -> SpinSolution {
        let (mut height, mut cuts) = (0.0, Vec::new());
        let (mut iterations, mut evaluations) = (0, 0);
        loop {
            let mut conditions = wish.conditions();
            conditions.extend(cuts.iter().map(|&angle| wish.cut(height, angle)));
            let elements = self.under(&conditions);
            let variance = least_variance(&elements, range);
            iterations += variance.iterations();
            evaluations += variance.evaluations;
            let densities = elements.densities(range, &variance.multipliers);
            let is_last = variance.end != SolveEnd::Met
                || wish.stable.is_none()
                || iterations > MOST_CUTS * 10
                || self.exchange(wish, &densities, &mut height, &mut cuts);
            if is_last {
                return SpinSolution {
                    conditions,
                    variance,
                    densities,
                    iterations,
                    evaluations,
                };
            }
        }
    }

    /// Adds the half-space of the cone that a field violates most; whether it violates none.
    fn exchange(
        &self,
        wish: &SpinWish,
        densities: &[f64],
        height: &mut f64,
        cuts: &mut Vec<f64>,
    ) -> bool {
        let moments = self.weigh(|element| densities[element]);
        let state = SpinState::of(&moments, 0.0, 0.0, &self.axis);
        let gyration = (moments.second.trace() / moments.mass).sqrt();
        let is_level = cuts.is_empty() || (state.height - *height).abs() <= SAME_HEIGHT * gyration;
        let (excess, angle) = state.instability(&self.axis, wish.stable.unwrap_or(0.0));
        if excess <= CONE_ROUNDING && is_level {
            return true;
        }
        *height = state.height;
        if excess > CONE_ROUNDING {
            // A line has two directions.
            let is_other = |cut: &f64| (cut - angle).sin().abs() > SAME_CUT;
            cuts.retain(is_other);
            cuts.push(angle);
        }
        false
    }

    /// The least contrast with which a wish can be met by a range that begins at `low`; with the half-spaces
    /// of the cone that `solution` met.
    pub(crate) fn least_contrast(&self, conditions: &[Condition], low: f64) -> SpinContrast {
        let growth = RangeGrowth {
            middle: low,
            down: 0.0,
            up: 1.0,
        };
        let least = least_growth(&self.under(conditions), &growth);
        SpinContrast {
            contrast: 1.0 + least.growth / low,
            certificate: combined(conditions, &least.multipliers, &self.axis.through),
            evaluations: least.evaluations,
        }
    }
}

/// Σ λ_k φ_k, measured from `about`.
pub(crate) fn combined(
    conditions: &[Condition],
    multipliers: &DVector<f64>,
    about: &Point3<f64>,
) -> Condition {
    let mut sum = Condition::affine(about, 0.0, Vector3::zeros());
    for (condition, &factor) in conditions.iter().zip(multipliers) {
        let seen = condition.seen_from(about);
        sum.constant += factor * seen.constant;
        sum.gradient += seen.gradient * factor;
        sum.quadratic += seen.quadratic * factor;
        sum.wanted += factor * seen.wanted;
    }
    sum
}
