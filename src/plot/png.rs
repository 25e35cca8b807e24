//! Metrics as PNG, anti-aliased.

use nalgebra::Point2;
use tiny_skia::{FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, StrokeDash, Transform};

use crate::plot::color::Color;
use crate::plot::figure::{Anchor, Figure, Shape, Stroke, Text};
use crate::plot::font::{self, Pen};

/// The reason why no PNG is made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum PngError {
    /// The picture has no pixels or more than fit in memory.
    #[error("a picture of {width} × {height} pixels cannot be made")]
    Size {
        /// Width in pixels.
        width: f64,
        /// Height in pixels.
        height: f64,
    },
    /// The encoder failed.
    #[error("the PNG encoder failed: {0}")]
    Encode(String),
}

/// The most pixels along a side.
const LONGEST_SIDE: f64 = 16_384.0;

/// The figure as the bytes of a PNG file, `scale` pixels per figure unit.
///
/// # Errors
/// [`PngError::Size`] if a side has no pixels or more than 16 384.
pub(crate) fn png(figure: &Figure, scale: f64) -> Result<Vec<u8>, PngError> {
    let mut sheet = blank(figure.width * scale, figure.height * scale)?;
    draw(figure, scale, &mut sheet);
    encode(&sheet)
}

/// A white sheet of so many pixels, fractions rounded up.
pub(crate) fn blank(width: f64, height: f64) -> Result<Pixmap, PngError> {
    check_size(width, height)?;
    let mut sheet = Pixmap::new(width.ceil() as u32, height.ceil() as u32)
        .ok_or(PngError::Size { width, height })?;
    sheet.fill(tiny_skia::Color::WHITE);
    Ok(sheet)
}

/// Refuses pictures without pixels and such that would not fit in memory.
pub(crate) fn check_size(width: f64, height: f64) -> Result<(), PngError> {
    let sides = 0.5..=LONGEST_SIDE;
    if sides.contains(&width) && sides.contains(&height) {
        Ok(())
    } else {
        Err(PngError::Size { width, height })
    }
}

/// The sheet as the bytes of a PNG file.
pub(crate) fn encode(sheet: &Pixmap) -> Result<Vec<u8>, PngError> {
    sheet
        .encode_png()
        .map_err(|error| PngError::Encode(error.to_string()))
}

/// Draws the figure's shapes on the sheet, `scale` pixels per figure unit.
pub(crate) fn draw(figure: &Figure, scale: f64, sheet: &mut Pixmap) {
    let to_pixels = Transform::from_scale(scale as f32, scale as f32);
    for shape in &figure.shapes {
        draw_shape(sheet, shape, to_pixels);
    }
}

fn draw_shape(sheet: &mut Pixmap, shape: &Shape, to_pixels: Transform) {
    let mut path = PathBuilder::new();
    match shape {
        Shape::Path {
            contours,
            closed,
            fill,
            stroke,
        } => {
            for contour in contours {
                add_points(&mut path, contour);
                if *closed {
                    path.close();
                }
            }
            paint(sheet, path, *fill, stroke.as_ref(), to_pixels);
        }
        Shape::Disc {
            center,
            radius,
            fill,
        } => {
            path.push_circle(center.x as f32, center.y as f32, *radius as f32);
            paint(sheet, path, Some(*fill), None, to_pixels);
        }
        Shape::Text(text) => draw_text(sheet, path, text, to_pixels),
    }
}

fn draw_text(sheet: &mut Pixmap, mut path: PathBuilder, text: &Text, to_pixels: Transform) {
    let length = font::width(&text.content, text.size) as f32;
    let shift = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -0.5 * length,
        Anchor::End => -length,
    };
    let angle = if text.upward { -90.0 } else { 0.0 };
    font::outline(&text.content, text.size, &mut path);
    let place = to_pixels
        .pre_translate(text.position.x as f32, text.position.y as f32)
        .pre_rotate(angle)
        .pre_translate(shift, 0.0);
    let Some(path) = path.finish() else { return };
    sheet.fill_path(&path, &ink(text.color), FillRule::Winding, place, None);
}

fn paint(
    sheet: &mut Pixmap,
    path: PathBuilder,
    fill: Option<Color>,
    stroke: Option<&Stroke>,
    to_pixels: Transform,
) {
    // A path without points paints nothing.
    let Some(path) = path.finish() else { return };
    if let Some(color) = fill {
        sheet.fill_path(&path, &ink(color), FillRule::EvenOdd, to_pixels, None);
    }
    if let Some(stroke) = stroke {
        let style = style(stroke);
        sheet.stroke_path(&path, &ink(stroke.color), &style, to_pixels, None);
    }
}

fn style(stroke: &Stroke) -> tiny_skia::Stroke {
    tiny_skia::Stroke {
        width: stroke.width as f32,
        line_cap: LineCap::Butt,
        line_join: LineJoin::Round,
        dash: stroke
            .dash
            .and_then(|lengths| StrokeDash::new(lengths.map(|l| l as f32).to_vec(), 0.0)),
        ..tiny_skia::Stroke::default()
    }
}

fn ink(color: Color) -> Paint<'static> {
    let [r, g, b] = color.rgb;
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, 255);
    paint
}

fn add_points(path: &mut PathBuilder, points: &[Point2<f64>]) {
    for (k, point) in points.iter().enumerate() {
        if k == 0 {
            Pen::move_to(path, *point);
        } else {
            Pen::line_to(path, *point);
        }
    }
}

impl Pen for PathBuilder {
    fn move_to(&mut self, to: Point2<f64>) {
        self.move_to(to.x as f32, to.y as f32);
    }

    fn line_to(&mut self, to: Point2<f64>) {
        self.line_to(to.x as f32, to.y as f32);
    }

    fn quadratic_to(&mut self, control: Point2<f64>, to: Point2<f64>) {
        self.quad_to(control.x as f32, control.y as f32, to.x as f32, to.y as f32);
    }

    fn close(&mut self) {
        self.close();
    }
}
