//! `chebloyd print --stand` and `--spin`: multipliers of the print's own pieces, walls and skins included.

use std::cell::RefCell;

use nalgebra::Point3;
use serde_json::{Map, Value, json};

use crate::balance::conditions::Condition;
use crate::balance::contrast::{RangeGrowth, least_growth};
use crate::balance::dual::DensityRange;
use crate::balance::elements::Elements;
use crate::balance::solve::{LeastVariance, SolveEnd, least_variance};
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

impl Balanced {
    /// Solves for the pieces of a print.
    pub(crate) fn solve(task: &mut Task<'_>) -> Result<Self, Failure> {
        let (options, most) = (&task.options.balance, task.filling.limit());
        let wish = Wish::of(task)?;
        let pieces = Pieces::of(task)?;
        let mut conditions = wish.conditions();
        let ones = vec![1.0; pieces.moments.len()];
        let sliced = wish.state(&pieces.weights(&ones));
        let growth = pieces.needs(&conditions, 0.0).growth;
        let (range, mut notes) = chosen_range(task, growth, most)?;
        notes.extend(wish.note());
        let mut solution = least_variance(&pieces.under(&conditions), &range);
        let mut iterations = solution.iterations();
        let mut multipliers = pieces
            .under(&conditions)
            .densities(&range, &solution.multipliers);
        for _ in 0..MOST_CUTS {
            let Some(cut) = options.stable.and_then(|share| {
                wish.cut(&pieces.weights(&multipliers), share)
                    .filter(|_| solution.end == SolveEnd::Met)
            }) else {
                break;
            };
            conditions.push(cut);
            solution = least_variance(&pieces.under(&conditions), &range);
            iterations += solution.iterations();
            multipliers = pieces
                .under(&conditions)
                .densities(&range, &solution.multipliers);
        }
        let needs = pieces.needs(&conditions, range.low);
        let refusal = refusal(&solution, &range, &needs, &pieces, most);
        Ok(Self {
            multipliers,
            limits: [range.low, range.high],
            notes,
            refusal,
            already: sliced.is_some_and(|state| state.holds),
            wish,
            iterations,
            needs,
        })
    }

    /// Rows of the table, of the part that was obtained.
    pub(crate) fn lines(&self, obtained: &Weights) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        if let Some(state) = self.state(obtained) {
            lines.extend(
                state
                    .figures
                    .iter()
                    .map(|&(name, value)| (name, format!("{value:.6}"))),
            );
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
        map.insert("stands_as_sliced".into(), json!(self.already));
        if let Some(state) = self.state(obtained) {
            for (name, value) in state.figures {
                map.insert(name.replace(' ', "_"), json!(value));
            }
            map.insert("stands".into(), json!(state.holds));
        }
        map.insert("least_range".into(), json!(number(self.needs.growth)));
        map.insert("least_contrast".into(), json!(number(self.needs.contrast)));
        map.insert("iterations".into(), json!(self.iterations));
        map
    }
}

/// The range that is asked for, or an ample one.
fn chosen_range(
    task: &Task<'_>,
    growth: f64,
    most: f64,
) -> Result<(DensityRange, Vec<String>), Failure> {
    let mut notes = Vec::new();
    let options = &task.options.balance;
    let [low, high] = match task.options.range {
        Some([low, high]) => [low, high.min(most)],
        None => {
            let reach = if options.goal == Goal::LeastContrast {
                growth * (1.0 + 1e-6)
            } else {
                growth * AMPLE
            };
            let low = (1.0 - reach).max(THINNEST);
            let high = (1.0 + reach).min(most);
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
    let takes = if needs.growth.is_finite() {
        format!("it takes multipliers of 1 ± {:.4}", needs.growth)
    } else {
        "no range about 1 suffices".to_owned()
    };
    let contrast = if needs.contrast.is_finite() {
        let greatest = low * needs.contrast;
        format!(
            ", or from {low} up to {greatest:.4} (a contrast of {:.4})",
            needs.contrast
        )
    } else {
        String::new()
    };
    let found = match solution.end {
        SolveEnd::Refuted => "no multipliers",
        _ => "no multipliers were found that",
    };
    Some(format!(
        "{found} between {low} and {high:.4} do this: {takes}{contrast}; full filling ends them at \
         {most:.4}; {fixed:.1} % of the part is walls and skins, which stay. Nothing is written. Widen \
         --range, or slice with fewer walls and solid layers, or with more infill so that low multipliers \
         have room"
    ))
}
