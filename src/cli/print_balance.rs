//! `chebloyd print --stand` and `--spin`: multipliers of the print's own pieces, walls and skins included.

use std::cell::RefCell;

use nalgebra::Point3;
use serde_json::{Map, Value, json};

use crate::balance::conditions::Condition;
use crate::balance::contrast::{RangeGrowth, least_growth};
use crate::balance::dual::DensityRange;
use crate::balance::elements::Elements;
use crate::balance::solve::{LeastVariance, SolveEnd, least_variance};
use crate::balance::support::Support;
use crate::cli::failure::Failure;
use crate::cli::print_options::Goal;
use crate::cli::print_task::Task;
use crate::cli::print_weights::Weights;
use crate::cli::print_wish::{Wish, WishState};
use crate::gcode::flow::{Flow, Piece};
use crate::geometry::moments::Moments;

/// Without --range the least range that suffices times this.
const AMPLE: f64 = 1.5;

/// Without --range no multiplier is below this: less does not hold together.
const THINNEST: f64 = 0.1;

/// … and for the greatest tilt none is above this.
const WIDEST: f64 = 2.0;

/// The greatest tilt that is tried, and how closely it is found (degrees).
const STEEPEST: f64 = 89.0;
const TILT_STEP: f64 = 0.01;

/// Half-spaces of --stable that are tried.
const MOST_CUTS: usize = 40;

/// Takes down every piece of infill.
struct Recorder {
    near: Point3<f64>,
    pieces: RefCell<Vec<Moments>>,
}

impl Flow for Recorder {
    fn multiplier(&self, piece: &Piece) -> f64 {
        let moments = piece.bead.moments(piece.height, &self.near);
        self.pieces.borrow_mut().push(moments);
        1.0
    }

    fn wanted(&self, piece: &Piece, near: &Point3<f64>) -> Moments {
        piece.bead.moments(piece.height, near)
    }
}

/// What was found.
#[derive(Debug)]
pub(crate) struct Balanced {
    pub(crate) multipliers: Vec<f64>,
    pub(crate) limits: [f64; 2],
    pub(crate) notes: Vec<String>,
    /// Why there are none.
    pub(crate) refusal: Option<String>,
    wish: Wish,
    already: bool,
    iterations: usize,
    needs: Needs,
}

/// What the wish takes at least.
#[derive(Clone, Copy, Debug)]
struct Needs {
    /// Multipliers from 1 − s to 1 + s.
    growth: f64,
    /// Greatest to least multiplier, the least being that of the limits.
    contrast: f64,
}

/// The print's pieces, and what does not vary, measured from `near`.
struct Pieces {
    near: Point3<f64>,
    moments: Vec<Moments>,
    fixed: Moments,
}

impl Pieces {
    fn of(task: &mut Task<'_>) -> Result<Self, Failure> {
        let recorder = Recorder {
            near: task.near(),
            pieces: RefCell::new(Vec::new()),
        };
        let sliced = task.tried(&recorder, [1.0, 1.0])?;
        Ok(Self {
            near: task.near(),
            moments: recorder.pieces.into_inner(),
            fixed: sliced.fixed,
        })
    }

    fn under(&self, conditions: &[Condition]) -> Elements {
        Elements::of_moments(conditions, &self.moments, &self.fixed, &self.near)
    }

    /// The part at multipliers.
    fn weights(&self, multipliers: &[f64]) -> Weights {
        let mut infill = Moments::default();
        for (piece, multiplier) in self.moments.iter().zip(multipliers) {
            infill += *piece * *multiplier;
        }
        Weights::of(&self.fixed, &infill, &self.near)
    }

    fn needs(&self, conditions: &[Condition], low: f64) -> Needs {
        let elements = self.under(conditions);
        let growth = |middle: f64, down: f64| {
            let up = 1.0;
            least_growth(&elements, &RangeGrowth { middle, down, up }).growth
        };
        Needs {
            growth: growth(1.0, 1.0),
            contrast: if low > 0.0 {
                1.0 + growth(low, 0.0) / low
            } else {
                f64::INFINITY
            },
        }
    }
}

/// A solution under the conditions so far.
struct Trial {
    conditions: Vec<Condition>,
    solution: LeastVariance,
    multipliers: Vec<f64>,
    /// Of all solutions so far.
    iterations: usize,
}

impl Trial {
    fn of(pieces: &Pieces, conditions: Vec<Condition>, range: &DensityRange) -> Self {
        let elements = pieces.under(&conditions);
        let solution = least_variance(&elements, range);
        Self {
            multipliers: elements.densities(range, &solution.multipliers),
            iterations: solution.iterations(),
            conditions,
            solution,
        }
    }

    /// Adds the half-space of --stable that is violated most, and solves again; `false` if none is.
    fn cut(&mut self, pieces: &Pieces, wish: &Wish, share: f64, range: &DensityRange) -> bool {
        if self.solution.end != SolveEnd::Met {
            return false;
        }
        let Some(cut) = wish.cut(&pieces.weights(&self.multipliers), share) else {
            return false;
        };
        let mut conditions = std::mem::take(&mut self.conditions);
        conditions.push(cut);
        let before = self.iterations;
        *self = Self::of(pieces, conditions, range);
        self.iterations += before;
        true
    }
}

impl Needs {
    /// What it takes, in words.
    fn text(&self, low: f64) -> String {
        let least = self.growth;
        let about_one = if least < 1.0 {
            format!("it takes multipliers of 1 ± {least:.4}")
        } else if least.is_finite() {
            format!("even 0 to 2 would be too little (1 ± {least:.4} is needed)")
        } else {
            "no range about 1 suffices".to_owned()
        };
        if !self.contrast.is_finite() {
            return about_one;
        }
        let (greatest, contrast) = (low * self.contrast, self.contrast);
        format!(
            "{about_one}; with {low} as the least, {greatest:.4} as the greatest (a contrast of \
             {contrast:.4})"
        )
    }
}

impl Balanced {
    /// Solves for the pieces of a print.
    pub(crate) fn solve(task: &mut Task<'_>) -> Result<Self, Failure> {
        let (options, most) = (&task.options.balance, task.filling.limit());
        let mut wish = Wish::of(task)?;
        let pieces = Pieces::of(task)?;
        let ones = vec![1.0; pieces.moments.len()];
        let sliced = wish.state(&pieces.weights(&ones));
        let growth = pieces.needs(&wish.conditions(), 0.0).growth;
        let (range, mut notes) = chosen_range(task, growth, most)?;
        if options.goal == Some(Goal::MostStable) {
            steepen(&mut wish, &pieces, &range)?;
        }
        notes.extend(wish.note());
        let mut trial = Trial::of(&pieces, wish.conditions(), &range);
        for _ in 0..options.stable.map_or(0, |_| MOST_CUTS) {
            if !trial.cut(&pieces, &wish, options.stable.unwrap_or_default(), &range) {
                break;
            }
        }
        let needs = pieces.needs(&trial.conditions, range.low);
        Ok(Self {
            refusal: refusal(&trial.solution, &range, &needs, &pieces, most),
            multipliers: trial.multipliers,
            limits: [range.low, range.high],
            notes,
            already: sliced.is_some_and(|state| state.holds),
            wish,
            iterations: trial.iterations,
            needs,
        })
    }

    /// Rows of the table, of the part that was obtained.
    pub(crate) fn lines(&self, obtained: &Weights) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        let figures = self
            .state(obtained)
            .map_or(Vec::new(), |state| state.figures);
        for (name, value) in figures {
            lines.push((name, format!("{value:.6}")));
        }
        let least = self.needs.growth;
        lines.push(("least range", format!("1 ± {least:.6}")));
        lines.push(("iterations", self.iterations.to_string()));
        lines
    }

    fn state(&self, obtained: &Weights) -> Option<WishState> {
        self.wish.state(obtained)
    }

    pub(crate) fn json(&self, obtained: &Weights) -> Map<String, Value> {
        let mut map = Map::new();
        let number = |value: f64| value.is_finite().then_some(value);
        map.insert("feasible".into(), json!(self.refusal.is_none()));
        map.insert("stands".into(), json!(self.already));
        if let Some(state) = self.state(obtained) {
            for (name, value) in state.figures {
                map.insert(name.replace(' ', "_"), json!(value));
            }
            map.insert("holds".into(), json!(state.holds));
        }
        map.insert("least_range".into(), json!(number(self.needs.growth)));
        map.insert("least_contrast".into(), json!(number(self.needs.contrast)));
        map.insert("iterations".into(), json!(self.iterations));
        map
    }
}

/// Raises the tilt to the greatest within `range`, by bisection.
fn steepen(wish: &mut Wish, pieces: &Pieces, range: &DensityRange) -> Result<(), Failure> {
    let Wish::Stand {
        support: Support::Polygon(_),
        tilt: least,
        ..
    } = wish
    else {
        return Err(Failure::input(
            "--goal most-stable is for what stands on a contact, not over a --point or at a --target",
        ));
    };
    let (mut low, mut high) = (*least, STEEPEST);
    let stands = |degrees: f64| {
        let elements = pieces.under(&wish.tilted(degrees).conditions());
        least_variance(&elements, range).end == SolveEnd::Met
    };
    while stands(low) && high - low > TILT_STEP {
        let middle = (low + high) / 2.0;
        if stands(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    *wish = wish.tilted(low);
    Ok(())
}

/// The range that is asked for, or an ample one.
fn chosen_range(
    task: &Task<'_>,
    growth: f64,
    most: f64,
) -> Result<(DensityRange, Vec<String>), Failure> {
    let options = &task.options.balance;
    let mut notes = Vec::new();
    let [low, high] = match task.options.range {
        Some([low, high]) => [low, high.min(most)],
        None if options.goal == Some(Goal::MostStable) => [THINNEST, most.min(WIDEST)],
        None => {
            let is_least = options.goal == Some(Goal::LeastContrast);
            let reach = growth * if is_least { 1.0 + 1e-6 } else { AMPLE };
            let [low, high] = [(1.0 - reach).max(THINNEST), (1.0 + reach).min(most)];
            notes.push(format!(
                "multipliers run from {low:.4} to {high:.4}: the least range that suffices is 1 ± {growth:.4}"
            ));
            [low, high]
        }
    };
    let prefer = options
        .prefer
        .unwrap_or_else(|| 1.0_f64.clamp(low.min(high), high));
    if low > high || !(low..=high).contains(&prefer) {
        return Err(Failure::input(format!(
            "--range {low},{high} (full filling ends it at {most:.4}) does not hold --prefer {prefer}"
        )));
    }
    Ok((DensityRange { low, high, prefer }, notes))
}

/// Why nothing is written: what it would take, and what decides.
fn refusal(
    solution: &LeastVariance,
    range: &DensityRange,
    needs: &Needs,
    pieces: &Pieces,
    most: f64,
) -> Option<String> {
    if solution.end == SolveEnd::Met {
        return None;
    }
    let DensityRange { low, high, .. } = *range;
    let varying: f64 = pieces.moments.iter().map(|piece| piece.mass).sum();
    let fixed = 100.0 * pieces.fixed.mass / (pieces.fixed.mass + varying);
    let takes = needs.text(low);
    let found = none_found(solution.end);
    Some(format!(
        "{found} between {low} and {high:.4} do this: {takes}; full filling ends them at \
         {most:.4}; {fixed:.1} % of the part is walls and skins, which stay. Nothing is written. Widen \
         --range, or slice with fewer walls and solid layers, or with more infill so that low multipliers \
         have room"
    ))
}

fn none_found(end: SolveEnd) -> &'static str {
    match end {
        SolveEnd::Refuted => "no multipliers",
        _ => "no multipliers were found that",
    }
}
