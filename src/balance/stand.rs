//! Make it stand: a density with which a body's center lies where its support asks (\[BL\] section 3.2).
//!
//! The least contrast says whether the range suffices; then Newton's method finds the least-variance density
//! in it, or the plane of the proof and the nearest reachable center are what there is to say.

use nalgebra::{DVector, Point3, Vector3};

use crate::balance::conditions::Condition;
use crate::balance::contrast::{LeastGrowth, RangeGrowth, least_contrast, least_growth, refute};
use crate::balance::dual::{Balance, DensityRange, Relation};
use crate::balance::nearest::{NearestCenter, Reach};
use crate::balance::solid::{AffineForm, SolidBalance};
use crate::balance::solve::{LeastVariance, SolveEnd, least_variance};
use crate::balance::support::{Ground, Support, SupportError};

/// Which of the densities that stand is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StandGoal {
    /// The one nearest to the preferred constant.
    LeastVariance,
    /// The one of the least ratio of densities.
    LeastContrast,
    /// The one that stands the largest tilt.
    MostStable,
}

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StandPlan {
    /// The ground.
    pub(crate) ground: Ground,
    /// Where the center must be.
    pub(crate) support: Support,
    /// How far inside its edges (L).
    pub(crate) margin: f64,
    /// The tangent of the tilt to stand.
    pub(crate) tilt: f64,
    /// The densities that may be used; none takes what is needed, with room.
    pub(crate) range: Option<[f64; 2]>,
    /// The density to stay near to; none is the low end.
    pub(crate) prefer: Option<f64>,
    /// The mass that is wanted.
    pub(crate) mass: Option<f64>,
    /// Which density.
    pub(crate) goal: StandGoal,
}

/// A density found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StandField {
    /// The range that it keeps.
    pub(crate) range: DensityRange,
    /// clamp(low, high, form), the form measured from the body's middle.
    pub(crate) form: AffineForm,
    /// How it was found.
    pub(crate) solution: LeastVariance,
    /// The tangent of the tilt that was asked, or found by the goal of most stability.
    pub(crate) tilt: f64,
}

/// Why there is none.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StandRefusal {
    /// The range within which there is none.
    pub(crate) range: [f64; 2],
    /// A form whose positive part is too light even at the high end: its plane is the proof.
    pub(crate) proof: AffineForm,
    /// The reachable center that is nearest; none where the mass alone is out of reach.
    pub(crate) nearest: Option<NearestCenter>,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Standing {
    /// Whether the body does it with a constant density.
    pub(crate) stands: bool,
    /// The least contrast that any density needs, less one.
    pub(crate) contrast: LeastGrowth,
    /// Where its proof has its plane.
    pub(crate) contrast_form: AffineForm,
    /// The least high end, given the low end and the mass.
    pub(crate) least_high: Option<f64>,
    /// The density, or why there is none.
    pub(crate) field: Result<StandField, StandRefusal>,
}

/// Why nothing is known.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum StandError {
    /// The support cannot be stood on.
    #[error(transparent)]
    Support(#[from] SupportError),
    /// Most stability of a center that is to be at one place.
    #[error(
        "the most stable density needs a support polygon; a point, a line or a target has none"
    )]
    NoPolygon,
    /// The range is too near to the least one.
    #[error(
        "the range {low} to {high} is so near to the least contrast {contrast} that rounding decides; \
         widen it by a millionth"
    )]
    Undecided {
        /// The low end.
        low: f64,
        /// The high end.
        high: f64,
        /// κ*.
        contrast: f64,
    },
}

impl StandError {
    /// Whether another input is needed, not another range.
    pub(crate) fn is_of_input(&self) -> bool {
        !matches!(self, Self::Undecided { .. })
    }
}

/// Room of a range that nobody gave, above the least contrast.
pub(crate) const RANGE_ROOM: f64 = 1.5;

/// Room of the least contrast, so that its step has a slope that can be found and written down.
const STEP_ROOM: f64 = 1e-6;

/// A constant density stands if conditions are missed by this share of ∫|φ| at most.
const STANDS: f64 = 1e-12;

/// Ranges may fall short of the least one by this share.
const ROUNDING: f64 = 1e-12;

/// Conditions, and the directions along which they are missed.
type Demands = Vec<(Condition, Vector3<f64>)>;

/// Finds the density that `plan` asks for of a body.
pub(crate) fn stand(body: &SolidBalance<'_>, plan: &StandPlan) -> Result<Standing, StandError> {
    let demands = plan.demands(plan.tilt)?;
    if plan.goal == StandGoal::MostStable && !matches!(plan.support, Support::Polygon(_)) {
        return Err(StandError::NoPolygon);
    }
    let balance = body.under(&conditions(&demands));
    let contrast = least_contrast(&balance);
    let contrast_form = balance.combined(&contrast.multipliers);
    let [low, high] = plan.range_for(contrast.growth);
    let search = StandSearch {
        body,
        plan,
        low,
        high,
    };
    let least_high = search
        .wanted_mass()
        .map(|_| low + search.growth(&demands).growth);
    let is_reachable = if search.wanted_mass().is_some() {
        search.refuted(&demands).is_none()
    } else {
        (1.0 + contrast.growth) * low <= high * (1.0 + ROUNDING) && contrast.growth.is_finite()
    };
    let field = if is_reachable {
        Ok(search.field(&demands, contrast.growth)?)
    } else {
        Err(search.refusal(&demands, &contrast.multipliers))
    };
    Ok(Standing {
        stands: stands(&balance),
        contrast,
        contrast_form,
        least_high,
        field,
    })
}

/// Whether a constant density meets the conditions.
fn stands(balance: &SolidBalance<'_>) -> bool {
    let totals = balance.totals();
    (0..totals.len()).all(|k| {
        let mut only = DVector::zeros(totals.len());
        only[k] = 1.0;
        let size = 2.0 * balance.positive_part(&only).0 - totals[k];
        match balance.relations()[k] {
            Relation::AtLeast => totals[k] >= -STANDS * size,
            Relation::Equal => totals[k].abs() <= STANDS * size,
        }
    })
}

fn conditions(demands: &Demands) -> Vec<Condition> {
    demands
        .iter()
        .map(|(condition, _)| condition.clone())
        .collect()
}

impl StandPlan {
    fn demands(&self, tilt: f64) -> Result<Demands, SupportError> {
        self.support.demands(&self.ground, self.margin, tilt)
    }

    /// The range, where none is given the least one with room.
    fn range_for(&self, growth: f64) -> [f64; 2] {
        self.range.unwrap_or_else(|| {
            let low = self.prefer.unwrap_or(1.0);
            [low, low * (1.0 + growth) * RANGE_ROOM]
        })
    }
}

/// A plan with a range.
struct StandSearch<'a> {
    body: &'a SolidBalance<'a>,
    plan: &'a StandPlan,
    low: f64,
    high: f64,
}

impl StandSearch<'_> {
    /// The mass that is a condition: without a given range densities are scaled to it instead.
    fn wanted_mass(&self) -> Option<f64> {
        self.plan.mass.filter(|_| self.plan.range.is_some())
    }

    /// The body under the demands, and under the mass.
    fn balance(&self, demands: &Demands) -> SolidBalance<'_> {
        let mut conditions = conditions(demands);
        conditions.extend(self.wanted_mass().map(Condition::mass));
        self.body.under(&conditions)
    }

    fn range(&self) -> DensityRange {
        DensityRange {
            low: self.low,
            high: self.high,
            prefer: self.plan.prefer.unwrap_or(self.low),
        }
    }

    /// The least growth of the range from its low end.
    fn growth(&self, demands: &Demands) -> LeastGrowth {
        let growth = RangeGrowth {
            middle: self.low,
            down: 0.0,
            up: 1.0,
        };
        least_growth(&self.balance(demands), &growth)
    }

    /// The proof that the range does not suffice.
    fn refuted(&self, demands: &Demands) -> Option<DVector<f64>> {
        refute(&self.balance(demands), &self.range(), ROUNDING)
    }

    /// The density of the goal.
    fn field(&self, demands: &Demands, growth: f64) -> Result<StandField, StandError> {
        let (mut range, mut tilt) = (self.range(), self.plan.tilt);
        let mut chosen = demands.clone();
        match self.plan.goal {
            StandGoal::LeastVariance => {}
            StandGoal::LeastContrast => {
                range.high = self.least_high(demands);
                range.prefer = range.prefer.clamp(range.low, range.high);
            }
            StandGoal::MostStable => {
                tilt = self.steepest(tilt);
                chosen = self.plan.demands(tilt)?;
            }
        }
        let balance = self.balance(&chosen);
        let mut solution = least_variance(&balance, &range);
        if range.low >= range.high || (stands(&balance) && self.wanted_mass().is_none()) {
            // The constant density itself, which may miss by rounding.
            solution.multipliers.fill(0.0);
            solution.end = SolveEnd::Met;
        }
        if solution.end != SolveEnd::Met {
            return Err(StandError::Undecided {
                low: range.low,
                high: range.high,
                contrast: 1.0 + growth,
            });
        }
        let form = balance.combined(&solution.multipliers).less(-range.prefer);
        let field = StandField {
            range,
            form,
            solution,
            tilt,
        };
        Ok(match self.plan.mass {
            Some(mass) if self.wanted_mass().is_none() => {
                let found = self.body.clamped(&field.form, &field.range).mass;
                field.scaled(mass / found)
            }
            _ => field,
        })
    }

    /// The least high end that suffices, with the least room.
    fn least_high(&self, demands: &Demands) -> f64 {
        let least = self.low + self.growth(demands).growth * (1.0 + STEP_ROOM);
        least.max(self.low * (1.0 + 1e-15)).min(self.high)
    }

    /// The largest tangent of a tilt that some density within the range stands, by bisection.
    fn steepest(&self, tilt: f64) -> f64 {
        let is_stood = |tilt: f64| {
            let demands = self.plan.demands(tilt);
            demands.is_ok_and(|demands| self.refuted(&demands).is_none())
        };
        let (mut low, mut high) = (tilt, tilt.max(0.05));
        while is_stood(high) && high < 1e6 {
            low = high;
            high *= 2.0;
        }
        for _ in 0..45 {
            let middle = 0.5 * (low + high);
            *(if is_stood(middle) {
                &mut low
            } else {
                &mut high
            }) = middle;
        }
        tilt.max(low * (1.0 - STEP_ROOM))
    }

    /// The proof and the nearest center.
    fn refusal(&self, demands: &Demands, multipliers: &DVector<f64>) -> StandRefusal {
        let balance = self.balance(demands);
        let multipliers = match self.wanted_mass() {
            Some(_) => self.growth(demands).multipliers,
            None => multipliers.clone(),
        };
        let centers = self.body.under(&conditions(demands));
        let directions: Vec<_> = demands.iter().map(|(_, direction)| *direction).collect();
        let reach = Reach {
            balance: &centers,
            directions: &directions,
            range: &self.range(),
            mass: self.wanted_mass(),
        };
        let start = multipliers.rows(0, demands.len()).into_owned();
        StandRefusal {
            range: [self.low, self.high],
            proof: balance.combined(&multipliers),
            nearest: (self.can_have_mass() && start.amax() > 0.0).then(|| reach.nearest(&start)),
        }
    }

    /// Whether densities of the range can have the mass that is wanted.
    fn can_have_mass(&self) -> bool {
        self.wanted_mass().is_none_or(|mass| {
            let volume = self.body.whole.mass;
            (self.low * volume..=self.high * volume).contains(&mass)
        })
    }
}

impl StandField {
    /// All densities times a factor.
    fn scaled(mut self, factor: f64) -> Self {
        self.range.low *= factor;
        self.range.high *= factor;
        self.range.prefer *= factor;
        self.form.value *= factor;
        self.form.gradient *= factor;
        self
    }
}

impl AffineForm {
    /// The point where the form is zero next to `middle`, from which it is measured, and the unit normal
    /// towards where it is positive; none of a constant.
    pub(crate) fn plane_at(&self, middle: &Point3<f64>) -> Option<(Point3<f64>, Vector3<f64>)> {
        let normal = self.gradient.try_normalize(0.0)?;
        let slope = self.gradient.norm();
        Some((middle - normal * (self.value / slope), normal))
    }
}
