//! Octrees side by side as in \[BL\] Fig. 15, and their errors over their sizes as in Fig. 14.

use nalgebra::{Point2, Point3};

use crate::geometry::bounds::Bounds;
use crate::mesh::octree::Octree;
use crate::plot::axis::Axis;
use crate::plot::color::{Color, ColorScale};
use crate::plot::figure::{Anchor, Figure, Shape, Stroke};
use crate::plot::panel::{LABEL_SIZE, Panel, TITLE_SIZE};
use crate::plot::png::PngError;
use crate::plot::z_buffer::ZBuffer;

/// Sides of a tree's part of the picture in pixels, and pixels per figure unit.
const SIDE: usize = 620;
const SCALE: f64 = 2.0;

const MARGIN: f64 = 16.0;
const CAPTION_SPACE: f64 = 30.0;

/// Boxes of deeper levels are too small for lines about them.
const DEEPEST_WITH_LINES: u32 = 6;

/// A tree, and what is written below it.
pub(crate) struct CaptionedTree<'a> {
    pub(crate) tree: &'a Octree,
    pub(crate) caption: String,
}

/// The solid leaves of trees side by side, colored by level, `up` the axis that points upward, as the
/// bytes of a PNG file.
///
/// # Errors
/// [`PngError`] as [`crate::plot::png::png`], also without trees.
pub(crate) fn octrees(trees: &[CaptionedTree<'_>], up: usize) -> Result<Vec<u8>, PngError> {
    let side = SIDE as f64 / SCALE;
    let width = side * trees.len() as f64;
    let mut figure = Figure::new(width + 2.0 * MARGIN, side + 2.0 * MARGIN + CAPTION_SPACE);
    let mut buffer = ZBuffer::new(SIDE * trees.len(), SIDE)?;
    for (number, CaptionedTree { tree, caption }) in trees.iter().enumerate() {
        draw_tree(&mut buffer, tree, up, number);
        let x = MARGIN + (number as f64 + 0.5) * side;
        let below = Point2::new(x, MARGIN + side + CAPTION_SPACE);
        figure.text(below, caption, TITLE_SIZE, Anchor::Middle);
    }
    buffer.to_png(&figure, Point2::new(MARGIN, MARGIN), SCALE)
}

/// Draws a tree in part `number` of the buffer.
fn draw_tree(buffer: &mut ZBuffer, tree: &Octree, up: usize, number: usize) {
    let corners = box_corners(&tree.bounds, up);
    // Some room between neighbors.
    let room = SIDE / 40;
    buffer.aim(corners, number * SIDE + room, SIDE - 2 * room);
    let scale = ColorScale {
        label: String::new(),
        min: 0.0,
        max: f64::from(tree.depth.max(1)),
    };
    for leaf in tree.leaves.iter().filter(|leaf| leaf.is_solid) {
        let quads = quads(&box_corners(&tree.node_box(leaf.place, leaf.level), up));
        let has_lines = leaf.level <= DEEPEST_WITH_LINES;
        buffer.draw_quads(
            &quads,
            has_lines,
            scale.color(f64::from(tree.depth - leaf.level)),
        );
    }
}

/// The corners of a box by bits of the axes, turned so that `up` points upward.
fn box_corners(bounds: &Bounds<3>, up: usize) -> [Point3<f64>; 8] {
    [0, 1, 2, 3, 4, 5, 6, 7].map(|bits: usize| {
        let pick = |axis: usize| [bounds.min, bounds.max][bits >> axis & 1][(axis + up + 1) % 3];
        Point3::new(pick(0), pick(1), pick(2))
    })
}

/// The three sides of a box that the viewer sees: toward larger x, smaller y and larger z.
fn quads(corners: &[Point3<f64>; 8]) -> [[Point3<f64>; 4]; 3] {
    [[1, 3, 7, 5], [0, 1, 5, 4], [4, 5, 7, 6]].map(|side| side.map(|corner| corners[corner]))
}

/// The sizes and errors of the trees of one model.
pub(crate) struct ErrorCurves {
    pub(crate) name: String,
    /// The nodes of every tree.
    pub(crate) nodes: Vec<f64>,
    /// Per tree ε_C, ε_M and ε_Θ, in percent.
    pub(crate) errors: Vec<[f64; 3]>,
    /// Seconds that each tree and its integrals took, and the exact integrals.
    pub(crate) seconds: Vec<f64>,
    pub(crate) exact_seconds: f64,
}

const WIDTH: f64 = 960.0;
const ROW: f64 = 360.0;
const FRAME: [Point2<f64>; 2] = [Point2::new(82.0, 36.0), Point2::new(460.0, 290.0)];
const PANEL_STEP: f64 = 482.0;
const LEGEND_SPACE: f64 = 30.0;

/// The curves' colors and names (Okabe & Ito).
const CURVES: [(Color, &str); 3] = [
    (Color::hex(0x00_72_b2), "center of mass ε_C"),
    (Color::hex(0xd5_5e_00), "mass ε_M"),
    (Color::hex(0x00_9e_73), "inertia tensor ε_Θ"),
];

/// Errors, and times, over the numbers of nodes: a row of two panels for each model.
#[must_use]
pub(crate) fn error_curves(models: &[ErrorCurves]) -> Figure {
    let mut figure = Figure::new(WIDTH, ROW * models.len() as f64 + LEGEND_SPACE);
    for (row, model) in models.iter().enumerate() {
        let errors = (0..3).map(|k| model.errors.iter().map(|error| error[k]).collect());
        let errors: Vec<Vec<f64>> = errors.collect();
        let left = panel(row, 0.0, &model.nodes, &errors.concat());
        let times = [&model.seconds[..], &[model.exact_seconds]].concat();
        let right = panel(row, PANEL_STEP, &model.nodes, &times);
        left.draw_grid(&mut figure);
        right.draw_grid(&mut figure);
        for (curve, (color, _)) in errors.iter().zip(CURVES) {
            draw_curve(&mut figure, &left, &model.nodes, curve, color);
        }
        draw_curve(
            &mut figure,
            &right,
            &model.nodes,
            &model.seconds,
            Color::INK,
        );
        draw_exact(&mut figure, &right, model.exact_seconds);
        left.draw_frame(&mut figure, &model.name, "nodes of the octree", "error (%)");
        let title = format!("{}: time (dashed: exact)", model.name);
        right.draw_frame(&mut figure, &title, "nodes of the octree", "seconds");
    }
    let baseline = ROW * models.len() as f64 + 0.5 * LEGEND_SPACE;
    for (number, (color, name)) in CURVES.iter().enumerate() {
        let start = Point2::new(60.0 + 190.0 * number as f64, baseline - 0.36 * LABEL_SIZE);
        let end = Point2::new(start.x + 26.0, start.y);
        figure.line(start, end, Stroke::solid(*color, 1.8));
        figure.text(
            Point2::new(end.x + 8.0, baseline),
            name,
            LABEL_SIZE,
            Anchor::Start,
        );
    }
    figure
}

/// A panel in a row, both axes of equal ratios around what is positive.
fn panel(row: usize, shift: f64, nodes: &[f64], values: &[f64]) -> Panel {
    let axis = |values: &[f64]| {
        let positive = values.iter().copied().filter(|value| *value > 0.0);
        let (low, high) = positive.fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        if low.is_finite() {
            Axis::logarithmic(low, high)
        } else {
            Axis::logarithmic(0.1, 1.0)
        }
    };
    let down = ROW * row as f64;
    Panel {
        frame: FRAME.map(|corner| Point2::new(corner.x + shift, corner.y + down)),
        x: axis(nodes),
        y: axis(values),
    }
}

/// Lines between the positive values, with a dot at each.
fn draw_curve(figure: &mut Figure, panel: &Panel, nodes: &[f64], values: &[f64], color: Color) {
    let pairs = nodes.iter().zip(values);
    let positive = pairs.filter(|(_, value)| **value > 0.0 && value.is_finite());
    let points: Vec<_> = positive.map(|(x, y)| panel.place(*x, *y)).collect();
    for center in &points {
        figure.shapes.push(Shape::Disc {
            center: *center,
            radius: 2.6,
            fill: color,
        });
    }
    if points.len() > 1 {
        figure.polyline(points, Stroke::solid(color, 1.8));
    }
}

/// The dashed line at the time of the exact integrals.
fn draw_exact(figure: &mut Figure, panel: &Panel, seconds: f64) {
    let ends = [panel.x.min, panel.x.max].map(|x| panel.place(x, seconds));
    let dashed = Stroke {
        color: Color::GRAY,
        width: 1.2,
        dash: Some([4.0, 3.0]),
    };
    figure.line(ends[0], ends[1], dashed);
}
