//! A framed area with axes, and the sizes of texts in all pictures.

use nalgebra::Point2;

use crate::plot::axis::Axis;
use crate::plot::color::Color;
use crate::plot::figure::{Anchor, Figure, Stroke};
use crate::plot::font;

/// A framed area with a horizontal and a vertical axis.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The frame's upper left and lower right corner.
    pub frame: [Point2<f64>; 2],
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis, upward.
    pub y: Axis,
}

/// The font size of tick labels; other texts are larger.
pub const TICK_SIZE: f64 = 11.0;
/// The font size of axis labels.
pub const LABEL_SIZE: f64 = 12.0;
/// The font size of titles.
pub const TITLE_SIZE: f64 = 14.0;
/// How far tick labels stand off the frame.
const STANDOFF: f64 = 7.0;
/// How long ticks are.
const TICK_LENGTH: f64 = 4.0;

impl Panel {
    /// Where the data point `(x, y)` stands in the figure.
    #[must_use]
    pub fn place(&self, x: f64, y: f64) -> Point2<f64> {
        let [min, max] = self.frame;
        Point2::new(
            min.x + self.x.share(x) * (max.x - min.x),
            max.y + self.y.share(y) * (min.y - max.y),
        )
    }

    /// Draws grid, ticks and tick labels.
    pub fn draw_grid(&self, figure: &mut Figure) {
        let [min, max] = self.frame;
        let grid = Stroke::solid(Color::GRID, 0.8);
        let ink = Stroke::solid(Color::INK, 0.8);
        for tick in &self.x.ticks {
            let x = self.place(tick.value, self.y.min).x;
            figure.line(Point2::new(x, min.y), Point2::new(x, max.y), grid);
            figure.line(
                Point2::new(x, max.y - TICK_LENGTH),
                Point2::new(x, max.y),
                ink,
            );
            let below = Point2::new(x, max.y + STANDOFF + 0.8 * TICK_SIZE);
            figure.text(below, &tick.label, TICK_SIZE, Anchor::Middle);
        }
        for tick in &self.y.ticks {
            let y = self.place(self.x.min, tick.value).y;
            figure.line(Point2::new(min.x, y), Point2::new(max.x, y), grid);
            figure.line(
                Point2::new(min.x, y),
                Point2::new(min.x + TICK_LENGTH, y),
                ink,
            );
            let beside = Point2::new(min.x - STANDOFF, y + 0.36 * TICK_SIZE);
            figure.text(beside, &tick.label, TICK_SIZE, Anchor::End);
        }
        for value in &self.y.minor {
            let y = self.place(self.x.min, *value).y;
            let end = Point2::new(min.x + 0.6 * TICK_LENGTH, y);
            figure.line(Point2::new(min.x, y), end, ink);
        }
    }

    /// Draws the frame, the title above it and the axes' names.
    pub fn draw_frame(&self, figure: &mut Figure, title: &str, x_name: &str, y_name: &str) {
        let [min, max] = self.frame;
        let middle = nalgebra::center(&min, &max);
        figure.rectangle(self.frame, None, Some(Stroke::solid(Color::INK, 1.0)));
        let above = Point2::new(middle.x, min.y - 10.0);
        figure.text(above, title, TITLE_SIZE, Anchor::Middle);
        let below = Point2::new(middle.x, max.y + 38.0);
        figure.text(below, x_name, LABEL_SIZE, Anchor::Middle);
        let widest = self
            .y
            .ticks
            .iter()
            .map(|tick| font::width(&tick.label, TICK_SIZE));
        let left = min.x - STANDOFF - widest.fold(0.0, f64::max) - 9.0;
        figure.upward_text(Point2::new(left, middle.y), y_name, LABEL_SIZE);
    }
}
