//! Convergence curves: movement of the sites and energy of their cells per iteration.
//!
//! The two panels of \[BL\] Fig. 13 side by side, for one or several runs: on the left the mean
//! movement of an iteration in percent of the optimal cell's diagonal, on the right the mean
//! p = 1 Chebyshev energy in percent of the optimal cell's, for runs with a density in percent of the
//! asymptotic optimum. Several runs of one kind may be one curve, their mean, in a band from the least to
//! the greatest of them.
//!
//! Movement spans decades and is drawn on a logarithmic scale as soon as it spans more than
//! 20 times; \[BL\] draw it linearly. Movements of zero, such as that of line 0, have
//! no place on such a scale and are left out. Energies go by what they have above 100 %, on a logarithmic
//! scale, where that falls to a third or less; so does the axis show the curve and not the space below it.

use nalgebra::Point2;

use crate::plot::axis::Axis;
use crate::plot::color::Color;
use crate::plot::figure::{Anchor, Figure, Shape, Stroke};
use crate::plot::font;
use crate::plot::panel::{LABEL_SIZE, Panel};
use crate::plot::series::{Band, CurvePoints, Overlay, RunGroup};
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

/// How energies are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct EnergyAxis {
    /// The ends of the axis, if not those of the curves.
    pub range: Option<[f64; 2]>,
    /// Whether equal differences are equally long, whatever the curves are.
    pub is_linear: bool,
}

/// The ratio of largest to least movement from which the scale is logarithmic.
const LOGARITHMIC_FROM: f64 = 20.0;

/// The same of energies above 100 %.
const ENERGY_LOGARITHMIC_FROM: f64 = 3.0;

/// Energies above 100 % by less than this (%) have no place on a logarithmic axis.
const LEAST_EXCESS: f64 = 1e-6;

/// A linear energy axis reaches down to 100 % where that is no more than this share of it.
const TO_OPTIMUM: f64 = 0.35;

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
    let groups = runs.iter().map(|run| RunGroup {
        name: run.name.to_owned(),
        logs: vec![run.records],
    });
    let groups: Vec<_> = groups.collect();
    convergence_of(&groups, &[], EnergyAxis::default())
}

/// The curves of groups of runs with points upon them. One curve alone needs no legend.
#[must_use]
pub(crate) fn convergence_of(
    groups: &[RunGroup<'_>],
    overlays: &[Overlay],
    axis: EnergyAxis,
) -> Figure {
    let last = groups.iter().map(RunGroup::last_iteration);
    let last = last.fold(0.0, f64::max);
    let overlays: Vec<_> = overlays.iter().map(|overlay| overlay.up_to(last)).collect();
    let rows = if groups.len() == 1 && overlays.is_empty() {
        Vec::new()
    } else {
        legend_rows(groups, &overlays)
    };
    let height = match rows.len() {
        0 => LEGEND_TOP - 8.0,
        rows => LEGEND_TOP + LEGEND_ROW * (rows - 1) as f64 + 18.0,
    };
    let mut figure = Figure::new(WIDTH, height);
    draw_movement(&mut figure, (groups, &overlays), last);
    draw_energy(&mut figure, (groups, &overlays), last, axis);
    draw_legend(&mut figure, &rows);
    figure
}

/// What is drawn in both panels.
type Drawn<'a> = (&'a [RunGroup<'a>], &'a [Overlay]);

/// The left panel.
fn draw_movement(figure: &mut Figure, (groups, overlays): Drawn<'_>, last: f64) {
    let bands: Vec<_> = groups.iter().map(RunGroup::movement).collect();
    let panel = Panel {
        frame: FRAME,
        x: Axis::counts(0.0, last),
        y: movement_axis(&all(&bands, overlays, |overlay| &overlay.movement)),
    };
    panel.draw_grid(figure);
    draw_bands(figure, &panel, &bands);
    for (k, overlay) in overlays.iter().enumerate() {
        draw_points(figure, &panel, &overlay.movement, k);
    }
    let y_name = "mean movement (% of the optimal diagonal)";
    panel.draw_frame(figure, "Movement", "iteration", y_name);
}

/// The right panel.
fn draw_energy(figure: &mut Figure, (groups, overlays): Drawn<'_>, last: f64, axis: EnergyAxis) {
    let bands: Vec<_> = groups.iter().map(RunGroup::energy).collect();
    let reference = common_reference(groups);
    let energies = all(&bands, overlays, |overlay| &overlay.energy);
    let panel = Panel {
        frame: FRAME.map(|corner| Point2::new(corner.x + PANEL_STEP, corner.y)),
        x: Axis::counts(0.0, last),
        y: energy_axis(&energies, reference, axis),
    };
    panel.draw_grid(figure);
    if panel.y.min < 100.0 && panel.y.max > 100.0 {
        draw_optimum(figure, &panel, reference);
    }
    draw_bands(figure, &panel, &bands);
    for (k, overlay) in overlays.iter().enumerate() {
        draw_points(figure, &panel, &overlay.energy, k);
    }
    panel.draw_frame(figure, "Energy", "iteration", energy_name(reference));
}

/// The curves of all bands and overlays.
fn all<'a>(
    bands: &'a [Band],
    overlays: &'a [Overlay],
    of_overlay: fn(&Overlay) -> &CurvePoints,
) -> Vec<&'a CurvePoints> {
    let curves = bands.iter().flat_map(Band::curves);
    curves.chain(overlays.iter().map(of_overlay)).collect()
}

fn energy_name(reference: Option<EnergyReference>) -> &'static str {
    match reference {
        Some(EnergyReference::AsymptoticOptimum) => "mean energy (% of the asymptotic optimum)",
        Some(_) => "mean energy (% of the optimal cell’s energy)",
        None => "mean energy (% of each run’s own optimum)",
    }
}

/// What all groups are relative to; none where they differ.
fn common_reference(groups: &[RunGroup<'_>]) -> Option<EnergyReference> {
    let mut all = groups.iter().map(RunGroup::reference);
    let first = all.next().unwrap_or_default();
    all.all(|other| other == first).then_some(first)
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

fn movement_axis(curves: &[&CurvePoints]) -> Axis {
    let Some((low, high)) = range(curves) else {
        return Axis::linear(0.0, 1.0);
    };
    if high > LOGARITHMIC_FROM * low {
        Axis::logarithmic(low, high)
    } else {
        Axis::linear(0.0, high)
    }
}

fn energy_axis(
    curves: &[&CurvePoints],
    reference: Option<EnergyReference>,
    axis: EnergyAxis,
) -> Axis {
    if let Some([low, high]) = axis.range {
        return Axis::within(low, high);
    }
    let (low, high) = range(curves).unwrap_or((100.0, 130.0));
    let least = low.max(100.0 + LEAST_EXCESS);
    let is_squares = reference == Some(EnergyReference::EqualCubes);
    let falls = (high - 100.0) > ENERGY_LOGARITHMIC_FROM * (least - 100.0);
    if is_squares && falls && !axis.is_linear {
        return Axis::logarithmic_above(100.0, least, high);
    }
    let reaches_optimum = low > 100.0 && low - 100.0 < TO_OPTIMUM * (high - 100.0);
    let (low, high) = if reaches_optimum || axis.is_linear {
        (low.min(100.0), high.max(100.0))
    } else {
        (low, high)
    };
    // Space for the optimum's name under its line.
    Axis::linear(low - 0.05 * (high - low), high)
}

/// The least and the greatest value of all curves, if any.
fn range(curves: &[&CurvePoints]) -> Option<(f64, f64)> {
    let values = || {
        curves
            .iter()
            .flat_map(|curve| curve.iter())
            .map(|(_, value)| *value)
    };
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

/// Bands below all curves.
fn draw_bands(figure: &mut Figure, panel: &Panel, bands: &[Band]) {
    for (k, band) in bands.iter().enumerate() {
        if let Some([low, high]) = &band.extremes {
            let place = |&(x, y): &(f64, f64)| panel.place(x, y.clamp(panel.y.min, panel.y.max));
            let up = low.iter().map(place);
            let outline = up.chain(high.iter().rev().map(place)).collect();
            figure.shapes.push(Shape::Path {
                contours: vec![outline],
                closed: true,
                fill: Some(stroke_of(k).color.mix(Color::WHITE, PALE)),
                stroke: None,
            });
        }
    }
    for (k, band) in bands.iter().enumerate() {
        for part in within(&band.mean, panel) {
            draw_curve(figure, panel, &part, stroke_of(k));
        }
    }
}

/// How much of a band's color is white.
const PALE: f64 = 0.72;

/// The parts of a curve that the panel's axis holds, each up to the axis' ends.
fn within(curve: &CurvePoints, panel: &Panel) -> Vec<CurvePoints> {
    let (min, max) = (panel.y.min, panel.y.max);
    let mut parts = vec![CurvePoints::new()];
    let mut last: Option<(f64, f64)> = None;
    for &(x, y) in curve {
        let is_inside = (min..=max).contains(&y);
        if let Some((before, height)) = last
            && is_inside != (min..=max).contains(&height)
        {
            let outside = if is_inside { height } else { y };
            let end = outside.clamp(min, max);
            let share = (end - height) / (y - height);
            let crossing = (before + share * (x - before), end);
            if let Some(part) = parts.last_mut() {
                part.push(crossing);
            }
        }
        match parts.last_mut() {
            Some(part) if is_inside => part.push((x, y)),
            Some(part) if !part.is_empty() => parts.push(CurvePoints::new()),
            _ => {}
        }
        last = Some((x, y));
    }
    parts.retain(|part| !part.is_empty());
    parts
}

/// The circles of an overlay.
fn draw_points(figure: &mut Figure, panel: &Panel, points: &CurvePoints, overlay: usize) {
    for part in within(points, panel) {
        for (x, y) in part.iter().filter(|point| points.contains(point)) {
            draw_point(figure, panel.place(*x, *y), overlay);
        }
    }
}

/// A circle, or for every other overlay a square.
fn draw_point(figure: &mut Figure, center: Point2<f64>, overlay: usize) {
    let corners = |count: u32, radius: f64| {
        let angle = |k: u32| (f64::from(k) + 0.5) * std::f64::consts::TAU / f64::from(count);
        let corner = |k| center + nalgebra::Vector2::new(angle(k).cos(), angle(k).sin()) * radius;
        (0..count).map(corner).collect()
    };
    let contour = if overlay.is_multiple_of(2) {
        corners(24, 4.0)
    } else {
        corners(4, 5.0)
    };
    figure.shapes.push(Shape::Path {
        contours: vec![contour],
        closed: true,
        fill: Some(Color::WHITE),
        stroke: Some(Stroke::solid(Color::INK, 1.4)),
    });
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

/// An entry of the legend: the name, its sign and the entry's left end.
struct LegendEntry {
    name: String,
    sign: LegendSign,
    x: f64,
}

enum LegendSign {
    Line(Stroke),
    /// The points of an overlay, by its number.
    Points(usize),
}

/// The legend's entries, filled into rows from left to right, each row centered.
fn legend_rows(groups: &[RunGroup<'_>], overlays: &[Overlay]) -> Vec<Vec<LegendEntry>> {
    let of_groups = groups.iter().enumerate().map(|(k, group)| {
        let name = match group.reference() {
            EnergyReference::EqualCubes => group.name.clone(),
            EnergyReference::AsymptoticOptimum => format!("{} (asymptotic optimum)", group.name),
        };
        (name, LegendSign::Line(stroke_of(k)))
    });
    let of_overlays = overlays.iter().enumerate();
    let of_overlays = of_overlays.map(|(k, it)| (it.name.clone(), LegendSign::Points(k)));
    let mut rows: Vec<Vec<LegendEntry>> = Vec::new();
    let mut x = f64::INFINITY;
    for (name, sign) in of_groups.chain(of_overlays) {
        let name = font::elided(&name, LABEL_SIZE, LONGEST_NAME);
        let length = SAMPLE + 8.0 + font::width(&name, LABEL_SIZE);
        if x + length > WIDTH - 2.0 * ENTRY_GAP {
            rows.push(Vec::new());
            x = 0.0;
        }
        if let Some(row) = rows.last_mut() {
            row.push(LegendEntry { name, sign, x });
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
            match entry.sign {
                LegendSign::Line(stroke) => figure.line(start, end, stroke),
                LegendSign::Points(overlay) => {
                    draw_point(figure, nalgebra::center(&start, &end), overlay);
                }
            }
            let beside = Point2::new(end.x + 8.0, baseline);
            figure.text(beside, &entry.name, LABEL_SIZE, Anchor::Start);
        }
    }
}
