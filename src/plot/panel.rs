//! Framed areas with axes, color bars, and the sizes of texts in all pictures.

use nalgebra::{Point2, Vector2};

use crate::plot::axis::Axis;
use crate::plot::color::{Color, ColorScale};
use crate::plot::figure::{Anchor, Figure, Shape, Stroke};
use crate::plot::font;

/// A framed area with a horizontal and a vertical axis.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    /// The frame's upper left and lower right corner.
    pub frame: [Point2<f64>; 2],
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis, upward.
    pub y: Axis,
}

/// The font size of tick labels; other texts are larger.
pub(crate) const TICK_SIZE: f64 = 11.0;
/// The font size of axis labels.
pub(crate) const LABEL_SIZE: f64 = 12.0;
/// The font size of titles.
pub(crate) const TITLE_SIZE: f64 = 14.0;
/// The distance of tick labels from the frame.
const STANDOFF: f64 = 7.0;
/// How long ticks are.
const TICK_LENGTH: f64 = 4.0;
/// Lines of the grid and of ticks.
const GRID_LINE: Stroke = Stroke::solid(Color::GRID, 0.8);
const TICK_LINE: Stroke = Stroke::solid(Color::INK, 0.8);

impl Panel {
    /// The position of the data point `(x, y)` in the figure.
    #[must_use]
    pub(crate) fn place(&self, x: f64, y: f64) -> Point2<f64> {
        let [min, max] = self.frame;
        Point2::new(
            min.x + self.x.share(x) * (max.x - min.x),
            max.y + self.y.share(y) * (min.y - max.y),
        )
    }

    /// Draws grid, ticks and tick labels.
    pub(crate) fn draw_grid(&self, figure: &mut Figure) {
        self.draw_x_ticks(figure);
        self.draw_y_ticks(figure);
    }

    /// Draws ticks and tick labels without a grid, upon what is there.
    pub(crate) fn draw_ticks(&self, figure: &mut Figure) {
        let mut drawn = Figure::new(figure.width, figure.height);
        self.draw_grid(&mut drawn);
        let is_grid = |shape: &Shape| matches!(shape, Shape::Path { stroke: Some(stroke), .. } if *stroke == GRID_LINE);
        let ticks = drawn.shapes.into_iter().filter(|shape| !is_grid(shape));
        figure.shapes.extend(ticks);
    }

    fn draw_x_ticks(&self, figure: &mut Figure) {
        let [min, max] = self.frame;
        for tick in &self.x.ticks {
            let x = self.place(tick.value, self.y.min).x;
            let [top, bottom] = [min.y, max.y].map(|y| Point2::new(x, y));
            figure.line(top, bottom, GRID_LINE);
            figure.line(Point2::new(x, max.y - TICK_LENGTH), bottom, TICK_LINE);
            let below = Point2::new(x, max.y + STANDOFF + 0.8 * TICK_SIZE);
            figure.text(below, &tick.label, TICK_SIZE, Anchor::Middle);
        }
    }

    fn draw_y_ticks(&self, figure: &mut Figure) {
        let [min, max] = self.frame;
        for tick in &self.y.ticks {
            let y = self.place(self.x.min, tick.value).y;
            let [left, right] = [min.x, max.x].map(|x| Point2::new(x, y));
            figure.line(left, right, GRID_LINE);
            figure.line(left, Point2::new(min.x + TICK_LENGTH, y), TICK_LINE);
            let beside = Point2::new(min.x - STANDOFF, y + 0.36 * TICK_SIZE);
            figure.text(beside, &tick.label, TICK_SIZE, Anchor::End);
        }
        for value in &self.y.minor {
            let y = self.place(self.x.min, *value).y;
            let end = Point2::new(min.x + 0.6 * TICK_LENGTH, y);
            figure.line(Point2::new(min.x, y), end, TICK_LINE);
        }
    }

    /// Draws the frame, the title above it and the axes' names.
    pub(crate) fn draw_frame(&self, figure: &mut Figure, title: &str, x_name: &str, y_name: &str) {
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
        let lines = font::lines(y_name, LABEL_SIZE, (max.y - min.y).max(LEAST_NAME));
        let mut left = min.x - STANDOFF - widest.fold(0.0, f64::max) - 9.0;
        for line in lines.iter().rev() {
            figure.upward_text(Point2::new(left, middle.y), line, LABEL_SIZE);
            left -= LINE_STEP;
        }
    }
}

/// The bar's width; ticks, their labels and the scale's name need [`BAR_SPACE`] in all.
const BAR_WIDTH: f64 = 14.0;

/// The space that a bar takes to the right of its left edge, with a name of two lines.
pub(crate) const BAR_SPACE: f64 = 108.0;

/// The space that a level bar takes below its upper edge.
pub(crate) const LEVEL_BAR_SPACE: f64 = 58.0;

/// How far the arrow reaches beyond an end of a bar that values lie beyond.
const ARROW: f64 = 11.0;

/// From one line of a name to the next.
const LINE_STEP: f64 = 1.25 * LABEL_SIZE;

/// Names of axes may be as long as this where the axis is shorter.
const LEAST_NAME: f64 = 120.0;

/// Steps of color along the bar: finer than visible steps.
const BAR_STEPS: usize = 128;

/// Draws the bar of `scale` downward from its upper left corner.
pub(crate) fn draw_color_bar(
    figure: &mut Figure,
    corner: Point2<f64>,
    height: f64,
    scale: &ColorScale,
) {
    draw_clipped_color_bar(figure, corner, height, (scale, [false; 2]));
}

/// The same with an arrow at each end beyond which there are values: below `scale.min`, above
/// `scale.max`. The arrows lie within `height`.
pub(crate) fn draw_clipped_color_bar(
    figure: &mut Figure,
    corner: Point2<f64>,
    height: f64,
    (scale, clipped): (&ColorScale, [bool; 2]),
) {
    let [below, above] = clipped.map(|is_clipped| if is_clipped { ARROW } else { 0.0 });
    let start = Point2::new(corner.x, corner.y + above);
    let end = Point2::new(corner.x + BAR_WIDTH, corner.y + height - below);
    let axis = draw_bar(figure, [start, end], scale, true);
    draw_arrows(figure, [start, end], (scale, clipped), true);
    let mut widest = 0.0_f64;
    for tick in &axis.ticks {
        let y = end.y - axis.share(tick.value) * (end.y - start.y);
        figure.line(
            Point2::new(end.x, y),
            Point2::new(end.x + 4.0, y),
            TICK_LINE,
        );
        let beside = Point2::new(end.x + 8.0, y + 0.36 * TICK_SIZE);
        figure.text(beside, &tick.label, TICK_SIZE, Anchor::Start);
        widest = widest.max(font::width(&tick.label, TICK_SIZE));
    }
    let mut x = end.x + 8.0 + widest + 8.0 + LABEL_SIZE;
    for line in font::lines(&scale.label, LABEL_SIZE, height) {
        figure.upward_text(Point2::new(x, corner.y + 0.5 * height), &line, LABEL_SIZE);
        x += LINE_STEP;
    }
}

/// The same from left to right, its ticks and name below: for pictures that are not high.
pub(crate) fn draw_level_color_bar(
    figure: &mut Figure,
    corner: Point2<f64>,
    width: f64,
    (scale, clipped): (&ColorScale, [bool; 2]),
) {
    let [below, above] = clipped.map(|is_clipped| if is_clipped { ARROW } else { 0.0 });
    let start = Point2::new(corner.x + below, corner.y);
    let end = Point2::new(corner.x + width - above, corner.y + BAR_WIDTH);
    let axis = draw_bar(figure, [start, end], scale, false);
    draw_arrows(figure, [start, end], (scale, clipped), false);
    for tick in &axis.ticks {
        let x = start.x + axis.share(tick.value) * (end.x - start.x);
        let foot = Point2::new(x, end.y + 4.0);
        figure.line(Point2::new(x, end.y), foot, TICK_LINE);
        let under = Point2::new(x, end.y + 8.0 + 0.8 * TICK_SIZE);
        figure.text(under, &tick.label, TICK_SIZE, Anchor::Middle);
    }
    let name = Point2::new(corner.x + 0.5 * width, end.y + 36.0);
    let label = font::elided(&scale.label, LABEL_SIZE, width);
    figure.text(name, &label, LABEL_SIZE, Anchor::Middle);
}

/// The colors of a bar in a frame, and the frame; returns the axis of the values.
fn draw_bar(
    figure: &mut Figure,
    [start, end]: [Point2<f64>; 2],
    scale: &ColorScale,
    is_upright: bool,
) -> Axis {
    let size = end - start;
    for step in 0..BAR_STEPS {
        // Every step reaches up to the far end, so that no seam shows between two.
        let share = step as f64 / BAR_STEPS as f64;
        let rest = match is_upright {
            true => [start, Point2::new(end.x, end.y - share * size.y)],
            false => [Point2::new(start.x + share * size.x, start.y), end],
        };
        let value = scale.min + (share + 0.5 / BAR_STEPS as f64) * (scale.max - scale.min);
        figure.rectangle(rest, Some(scale.color(value)), None);
    }
    figure.rectangle([start, end], None, Some(TICK_LINE));
    Axis::within(scale.min, scale.max)
}

/// The arrows at the ends of a bar beyond which there are values.
fn draw_arrows(
    figure: &mut Figure,
    [start, end]: [Point2<f64>; 2],
    (scale, clipped): (&ColorScale, [bool; 2]),
    is_upright: bool,
) {
    let [low, high] = if is_upright {
        let up = [start, Point2::new(end.x, start.y)];
        let down = [end, Point2::new(start.x, end.y)];
        [(down, Vector2::y()), (up, -Vector2::y())]
    } else {
        let left = [start, Point2::new(start.x, end.y)];
        let right = [end, Point2::new(end.x, start.y)];
        [(left, -Vector2::x()), (right, Vector2::x())]
    };
    let ends = [(low, scale.min), (high, scale.max)].into_iter();
    for (((base, outward), value), _) in ends.zip(clipped).filter(|(_, is)| *is) {
        draw_arrow(figure, base, outward * ARROW, scale.color(value));
    }
}

fn draw_arrow(figure: &mut Figure, base: [Point2<f64>; 2], to_tip: Vector2<f64>, color: Color) {
    let tip = nalgebra::center(&base[0], &base[1]) + to_tip;
    figure.shapes.push(Shape::Path {
        contours: vec![vec![base[0], base[1], tip]],
        closed: true,
        fill: Some(color),
        stroke: Some(TICK_LINE),
    });
}
