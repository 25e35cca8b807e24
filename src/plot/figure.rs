//! A figure as a list of shapes, before it becomes a file.
//!
//! Every picture of this crate is first a plain list of polygons, lines, discs and texts in
//! figure units, the origin in the upper left corner and y downward; [`crate::plot::svg`] and
//! [`crate::plot::png`] turn the same list into their formats. Shapes later in the list cover
//! earlier ones.

use nalgebra::Point2;

use crate::plot::color::Color;

/// The style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stroke {
    /// The line's color.
    pub color: Color,
    /// Its width in figure units.
    pub width: f64,
    /// Lengths of dash and gap in figure units; `None` is a solid line.
    pub dash: Option<[f64; 2]>,
}

impl Stroke {
    /// A solid line.
    #[must_use]
    pub(crate) const fn solid(color: Color, width: f64) -> Self {
        Self {
            color,
            width,
            dash: None,
        }
    }
}

/// The point of a text that lies at its position, along the direction of reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    /// The text's beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// A line of text whose baseline starts, is centered or ends at `position`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Text {
    /// The position of the anchor, on the baseline.
    pub position: Point2<f64>,
    /// What is written.
    pub content: String,
    /// The font size in figure units.
    pub size: f64,
    /// The part of the text at the position.
    pub anchor: Anchor,
    /// Whether the text reads from bottom to top instead of left to right.
    pub upward: bool,
    /// The color of the letters.
    pub color: Color,
}

/// One shape of a figure.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Shape {
    /// Contours, filled by the even-odd rule and drawn as lines.
    Path {
        /// The contours' corners in order.
        contours: Vec<Vec<Point2<f64>>>,
        /// Whether every contour ends where it begins.
        closed: bool,
        /// The filling, if any.
        fill: Option<Color>,
        /// The style of the line, if any.
        stroke: Option<Stroke>,
    },
    /// A filled circle.
    Disc {
        /// The middle.
        center: Point2<f64>,
        /// The radius in figure units.
        radius: f64,
        /// The filling.
        fill: Color,
    },
    /// A line of text.
    Text(Text),
}

/// A white sheet with shapes on it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Figure {
    /// Width in figure units (SVG pixels).
    pub width: f64,
    /// Height in figure units.
    pub height: f64,
    /// What is drawn, from the back to the front.
    pub shapes: Vec<Shape>,
}

impl Figure {
    /// An empty sheet.
    #[must_use]
    pub(crate) fn new(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            shapes: Vec::new(),
        }
    }

    /// Adds a straight line.
    pub(crate) fn line(&mut self, from: Point2<f64>, to: Point2<f64>, stroke: Stroke) {
        self.polyline(vec![from, to], stroke);
    }

    /// Adds an open line through points.
    pub(crate) fn polyline(&mut self, points: Vec<Point2<f64>>, stroke: Stroke) {
        self.shapes.push(Shape::Path {
            contours: vec![points],
            closed: false,
            fill: None,
            stroke: Some(stroke),
        });
    }

    /// Adds a rectangle given by two opposite corners.
    pub(crate) fn rectangle(
        &mut self,
        [min, max]: [Point2<f64>; 2],
        fill: Option<Color>,
        stroke: Option<Stroke>,
    ) {
        let corners = vec![
            min,
            Point2::new(max.x, min.y),
            max,
            Point2::new(min.x, max.y),
        ];
        self.shapes.push(Shape::Path {
            contours: vec![corners],
            closed: true,
            fill,
            stroke,
        });
    }

    /// Adds a horizontal line of text.
    pub(crate) fn text(&mut self, position: Point2<f64>, content: &str, size: f64, anchor: Anchor) {
        self.shapes.push(Shape::Text(Text {
            position,
            content: content.to_owned(),
            size,
            anchor,
            upward: false,
            color: Color::INK,
        }));
    }

    /// Adds a line of text that reads upward, centered at `position`.
    pub(crate) fn upward_text(&mut self, position: Point2<f64>, content: &str, size: f64) {
        self.shapes.push(Shape::Text(Text {
            position,
            content: content.to_owned(),
            size,
            anchor: Anchor::Middle,
            upward: true,
            color: Color::INK,
        }));
    }
}
