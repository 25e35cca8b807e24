//! Convergence curves: movement of the sites and energy of their cells per iteration.
//!
//! The two panels of \[BL\] Fig. 13 side by side, for one or several runs: on the left the mean
//! movement of an iteration in percent of the optimal cell's diagonal, on the right the mean
//! p = 1 Chebyshev energy in percent of the optimal cell's, for runs with a density in percent of the
//! asymptotic optimum.
//!
//! Movement spans decades and is drawn on a logarithmic scale as soon as it spans more than
//! 20 times; \[BL\] draw it linearly. Movements of zero, such as that of line 0, have
//! no place on such a scale and are left out.

use nalgebra::Point2;

use crate::plot::axis::Axis;
use crate::plot::color::Color;
use crate::plot::figure::{Anchor, Figure, Shape, Stroke};
use crate::plot::font;
use crate::plot::panel::{LABEL_SIZE, Panel};
use crate::relax::optimum::EnergyReference;
use crate::relax::record::Record;

/// A run to draw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run<'a> {
    /// Its name in the legend; shortened where it is too long.
    pub name: &'a str,
    /// Its log.
    pub records: &'a [Record],
}

/// The ratio of largest to least movement from which the scale is logarithmic.
const LOGARITHMIC_FROM: f64 = 20.0;

/// Movements below this (%) are rounding noise: the logarithmic axis ends here.
const LEAST_MOVEMENT: f64 = 1e-12;

/// Colors that differ to the color-blind too (Okabe & Ito 2008, without black and yellow).
pub(crate) const COLORS: [Color; 6] = [
    Color::hex(0x00_72_b2),
    Color::hex(0xd5_5e_00),
    Color::hex(0x00_9e_73),
    Color::hex(0xcc_79_a7),
    Color::hex(0xe6_9f_00),
    Color::hex(0x56_b4_e9),
];

/// Dashes that distinguish the second and third round of colors from the first.
const DASHES: [Option<[f64; 2]>; 3] = [None, Some([6.0, 3.0]), Some([1.5, 2.5])];

/// The optimum's line.
const OPTIMUM: Stroke = Stroke {
    color: Color::GRAY,
    width: 1.0,
    dash: Some([4.0, 3.0]),
};

const WIDTH: f64 = 960.0;
/// Frame of the first panel; the second one lies `PANEL_STEP` to the right.
const FRAME: [Point2<f64>; 2] = [Point2::new(82.0, 36.0), Point2::new(460.0, 330.0)];
const PANEL_STEP: f64 = 482.0;
/// Baseline of the legend's first row.
const LEGEND_TOP: f64 = 396.0;
const LEGEND_ROW: f64 = 20.0;
/// The space of a legend entry: so long a sample line, a gap, a name no longer than this.
const SAMPLE: f64 = 26.0;
const LONGEST_NAME: f64 = 250.0;
const ENTRY_GAP: f64 = 24.0;

/// The curves of all `runs`; what is not finite is left out, and runs without records only
/// appear in the legend.
#[must_use]
pub(crate) fn convergence(runs: &[Run<'_>]) -> Figure {
    let rows = legend_rows(runs);
    let height = LEGEND_TOP + LEGEND_ROW * rows.len().saturating_sub(1) as f64 + 18.0;
    let mut figure = Figure::new(WIDTH, height);
    let movement: Vec<_> = runs.iter().map(|run| moves(run.records)).collect();
    let energy: Vec<_> = runs.iter().map(|run| energies(run.records)).collect();
    let iterations = iteration_axis(runs);
    let left = Panel {
        frame: FRAME,
        x: iterations.clone(),
        y: movement_axis(&movement),
    };
    let right = Panel {
        frame: FRAME.map(|corner| Point2::new(corner.x + PANEL_STEP, corner.y)),
        x: iterations,
        y: energy_axis(&energy),
    };
    left.draw_grid(&mut figure);
    right.draw_grid(&mut figure);
    let reference = common_reference(runs);
    draw_optimum(&mut figure, &right, reference);
    for (k, (movements, energies)) in movement.iter().zip(&energy).enumerate() {
        draw_curve(&mut figure, &left, movements, stroke_of(k));
        draw_curve(&mut figure, &right, energies, stroke_of(k));
    }
    let y_name = "mean movement (% of the optimal diagonal)";
    left.draw_frame(&mut figure, "Movement", "iteration", y_name);
    let y_name = match reference {
        Some(EnergyReference::AsymptoticOptimum) => "mean energy (% of the asymptotic optimum)",
        Some(_) => "mean energy (% of the optimal cell’s energy)",
        None => "mean energy (% of each run’s own optimum)",
    };
    right.draw_frame(&mut figure, "Energy", "iteration", y_name);
    draw_legend(&mut figure, &rows);
    figure
}

/// What all runs are relative to; none where they differ.
fn common_reference(runs: &[Run<'_>]) -> Option<EnergyReference> {
    let mut all = runs.iter().map(|run| reference_of(run));
    let first = all.next().unwrap_or_default();
    all.all(|other| other == first).then_some(first)
}

fn reference_of(run: &Run<'_>) -> EnergyReference {
    let first = run.records.first();
    first
        .and_then(|record| record.energy_reference)
        .unwrap_or_default()
}

/// The line of the optimum, named under its right end where mostly no curve runs. No tessellation lies
/// below that of equal cubes; few sites in a density may lie below the asymptotic one.
fn draw_optimum(figure: &mut Figure, panel: &Panel, reference: Option<EnergyReference>) {
    let [start, end] = [panel.x.min, panel.x.max].map(|x| panel.place(x, 100.0));
    figure.line(start, end, OPTIMUM);
    let below = Point2::new(end.x - 5.0, end.y + 10.0);
    let name = match reference {
        Some(EnergyReference::EqualCubes) => "optimum",
        Some(_) => "asymptotic optimum",
        None => "optimum of each run",
    };
    figure.text(below, name, 0.8 * LABEL_SIZE, Anchor::End);
}

/// `(iteration, value)` in order.
type CurvePoints = Vec<(f64, f64)>;

fn moves(records: &[Record]) -> CurvePoints {
    let positive = |value: &f64| value.is_finite() && *value >= LEAST_MOVEMENT;
    curve(records, |record| record.movement_percent, positive)
}

fn energies(records: &[Record]) -> CurvePoints {
    curve(
        records,
        |record| record.energy_percent,
        |value| value.is_finite(),
    )
}

fn curve(records: &[Record], read: fn(&Record) -> f64, keep: impl Fn(&f64) -> bool) -> CurvePoints {
    records
        .iter()
        .map(|record| (record.iteration as f64, read(record)))
        .filter(|(_, value)| keep(value))
        .collect()
}

fn iteration_axis(runs: &[Run<'_>]) -> Axis {
    let iterations = runs
        .iter()
        .flat_map(|run| run.records)
        .map(|r| r.iteration as f64);
    Axis::counts(0.0, iterations.fold(0.0, f64::max))
}

fn movement_axis(curves: &[CurvePoints]) -> Axis {
    let Some((low, high)) = range(curves) else {
        return Axis::linear(0.0, 1.0);
    };
    if high > LOGARITHMIC_FROM * low {
        Axis::logarithmic(low, high)
    } else {
        Axis::linear(0.0, high)
    }
}

fn energy_axis(curves: &[CurvePoints]) -> Axis {
    let (low, high) = range(curves).unwrap_or((100.0, 130.0));
    let (low, high) = (low.min(100.0), high.max(100.0));
    // Space for the optimum's name under its line.
    Axis::linear(low - 0.05 * (high - low), high)
}

/// The least and the greatest value of all curves, if any.
fn range(curves: &[CurvePoints]) -> Option<(f64, f64)> {
    let values = || curves.iter().flatten().map(|(_, value)| *value);
    Some((values().reduce(f64::min)?, values().reduce(f64::max)?))
}

/// The style of a run's curve.
fn stroke_of(run: usize) -> Stroke {
    Stroke {
        color: COLORS[run % COLORS.len()],
        width: 1.8,
        dash: DASHES[run / COLORS.len() % DASHES.len()],
    }
}

/// The line through a curve's points, or a dot where it has one only.
fn draw_curve(figure: &mut Figure, panel: &Panel, curve: &CurvePoints, stroke: Stroke) {
    let mut points: Vec<Point2<f64>> = Vec::new();
    for (k, (x, y)) in curve.iter().enumerate() {
        let point = panel.place(*x, *y);
        // A log of a million lines has a thousand pixels: steps below a quarter unit are invisible.
        let is_visible = points
            .last()
            .is_none_or(|last| (point - last).amax() > 0.25);
        if is_visible || k + 1 == curve.len() {
            points.push(point);
        }
    }
    match points[..] {
        [] => {}
        [center] => figure.shapes.push(Shape::Disc {
            center,
            radius: 3.0,
            fill: stroke.color,
        }),
        _ => figure.polyline(points, stroke),
    }
}

/// An entry of the legend: the run's name, its style and the entry's left end.
struct LegendEntry {
    name: String,
    stroke: Stroke,
    x: f64,
}

/// The legend's entries, filled into rows from left to right, each row centered.
fn legend_rows(runs: &[Run<'_>]) -> Vec<Vec<LegendEntry>> {
    let mut rows: Vec<Vec<LegendEntry>> = Vec::new();
    let mut x = f64::INFINITY;
    for (k, run) in runs.iter().enumerate() {
        let name = match reference_of(run) {
            EnergyReference::EqualCubes => run.name.to_owned(),
            EnergyReference::AsymptoticOptimum => format!("{} (asymptotic optimum)", run.name),
        };
        let name = font::elided(&name, LABEL_SIZE, LONGEST_NAME);
        let length = SAMPLE + 8.0 + font::width(&name, LABEL_SIZE);
        if x + length > WIDTH - 2.0 * ENTRY_GAP {
            rows.push(Vec::new());
            x = 0.0;
        }
        let stroke = stroke_of(k);
        if let Some(row) = rows.last_mut() {
            row.push(LegendEntry { name, stroke, x });
        }
        x += length + ENTRY_GAP;
    }
    for row in &mut rows {
        let shift = 0.5 * (WIDTH - row.last().map_or(0.0, LegendEntry::end));
        row.iter_mut().for_each(|entry| entry.x += shift);
    }
    rows
}

impl LegendEntry {
    fn end(&self) -> f64 {
        self.x + SAMPLE + 8.0 + font::width(&self.name, LABEL_SIZE)
    }
}

fn draw_legend(figure: &mut Figure, rows: &[Vec<LegendEntry>]) {
    for (k, row) in rows.iter().enumerate() {
        let baseline = LEGEND_TOP + LEGEND_ROW * k as f64;
        for entry in row {
            let start = Point2::new(entry.x, baseline - 0.36 * LABEL_SIZE);
            let end = Point2::new(start.x + SAMPLE, start.y);
            figure.line(start, end, entry.stroke);
            let beside = Point2::new(end.x + 8.0, baseline);
            figure.text(beside, &entry.name, LABEL_SIZE, Anchor::Start);
        }
    }
}
