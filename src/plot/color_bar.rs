//! The bar beside a picture that tells what its colors mean.

use nalgebra::Point2;

use crate::plot::axis::Axis;
use crate::plot::color::{Color, ColorScale};
use crate::plot::figure::{Anchor, Figure, Stroke};
use crate::plot::font;
use crate::plot::panel::{LABEL_SIZE, TICK_SIZE};

/// The bar's width; ticks, their labels and the scale's name need [`ROOM`] in all.
const WIDTH: f64 = 14.0;

/// The space that a bar takes to the right of its left edge.
pub const ROOM: f64 = 92.0;

/// Steps of color along the bar: more than the eye can tell apart.
const STEPS: usize = 128;

/// Draws the bar of `scale` downward from its upper left corner.
pub fn draw(figure: &mut Figure, corner: Point2<f64>, height: f64, scale: &ColorScale) {
    let end = Point2::new(corner.x + WIDTH, corner.y + height);
    for step in 0..STEPS {
        // Every step reaches up to the top, so that no seam shows between two.
        let share = step as f64 / STEPS as f64;
        let floor = Point2::new(end.x, end.y - share * height);
        let value = scale.min + (share + 0.5 / STEPS as f64) * (scale.max - scale.min);
        figure.rectangle([corner, floor], Some(scale.color(value)), None);
    }
    figure.rectangle([corner, end], None, Some(Stroke::solid(Color::INK, 0.8)));
    let axis = Axis::within(scale.min, scale.max);
    let mut widest = 0.0_f64;
    for tick in &axis.ticks {
        let y = end.y - axis.share(tick.value) * height;
        let ink = Stroke::solid(Color::INK, 0.8);
        figure.line(Point2::new(end.x, y), Point2::new(end.x + 4.0, y), ink);
        let beside = Point2::new(end.x + 8.0, y + 0.36 * TICK_SIZE);
        figure.text(beside, &tick.label, TICK_SIZE, Anchor::Start);
        widest = widest.max(font::width(&tick.label, TICK_SIZE));
    }
    let name = Point2::new(
        end.x + 8.0 + widest + 8.0 + LABEL_SIZE,
        0.5 * (corner.y + end.y),
    );
    let label = font::elided(&scale.label, LABEL_SIZE, height);
    figure.upward_text(name, &label, LABEL_SIZE);
}
