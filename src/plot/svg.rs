//! Metrics as SVG, coordinates rounded to 0.01 figure units.

use std::fmt::Write;

use nalgebra::Point2;

use crate::plot::color::Color;
use crate::plot::figure::{Anchor, Figure, Shape, Stroke, Text};
use crate::plot::font::FAMILY;

/// The figure as an SVG 1.1 document.
#[must_use]
pub(crate) fn svg(figure: &Figure) -> String {
    let (width, height) = (Number(figure.width), Number(figure.height));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"{FAMILY}\" stroke-linejoin=\"round\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    );
    for shape in &figure.shapes {
        push_shape(&mut out, shape);
    }
    out.push_str("</svg>\n");
    out
}

fn push_shape(out: &mut String, shape: &Shape) {
    match shape {
        Shape::Path {
            contours,
            closed,
            fill,
            stroke,
        } => {
            out.push_str("<path d=\"");
            for contour in contours {
                push_path(out, contour);
                out.push_str(if *closed { "Z" } else { "" });
            }
            out.push('"');
            push_fill(out, *fill);
            if contours.len() > 1 {
                out.push_str(" fill-rule=\"evenodd\"");
            }
            push_stroke(out, stroke.as_ref());
            out.push_str("/>\n");
        }
        Shape::Disc {
            center,
            radius,
            fill,
        } => {
            let (x, y, r) = (Number(center.x), Number(center.y), Number(*radius));
            push(out, format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\""));
            push_fill(out, Some(*fill));
            out.push_str("/>\n");
        }
        Shape::Text(text) => push_text(out, text),
    }
}

fn push_text(out: &mut String, text: &Text) {
    let [x, y, size] = [text.position.x, text.position.y, text.size].map(Number);
    push(out, format_args!("<text font-size=\"{size}\""));
    if text.upward {
        push(
            out,
            format_args!(" transform=\"translate({x} {y}) rotate(-90)\""),
        );
    } else {
        push(out, format_args!(" x=\"{x}\" y=\"{y}\""));
    }
    match text.anchor {
        Anchor::Start => {}
        Anchor::Middle => out.push_str(" text-anchor=\"middle\""),
        Anchor::End => out.push_str(" text-anchor=\"end\""),
    }
    push_fill(out, Some(text.color));
    push(out, format_args!(">{}</text>\n", Escaped(&text.content)));
}

fn push_path(out: &mut String, points: &[Point2<f64>]) {
    for (k, point) in points.iter().enumerate() {
        // After M, further pairs are lines (SVG 1.1, section 8.3.2).
        let command = if k == 0 { "M" } else { " " };
        let (x, y) = (Number(point.x), Number(point.y));
        push(out, format_args!("{command}{x} {y}"));
    }
}

fn push_fill(out: &mut String, fill: Option<Color>) {
    match fill {
        Some(color) => push(out, format_args!(" fill=\"{}\"", Hex(color))),
        None => out.push_str(" fill=\"none\""),
    }
}

fn push_stroke(out: &mut String, stroke: Option<&Stroke>) {
    let Some(stroke) = stroke else { return };
    let (color, width) = (Hex(stroke.color), Number(stroke.width));
    push(
        out,
        format_args!(" stroke=\"{color}\" stroke-width=\"{width}\""),
    );
    if let Some([dash, gap]) = stroke.dash {
        let (dash, gap) = (Number(dash), Number(gap));
        push(out, format_args!(" stroke-dasharray=\"{dash} {gap}\""));
    }
}

/// Writing to a `String` cannot fail.
fn push(out: &mut String, arguments: std::fmt::Arguments<'_>) {
    let _always_ok = out.write_fmt(arguments);
}

/// A length rounded to 0.01, without trailing zeros; what is not finite becomes 0.
struct Number(f64);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let hundredths = (self.0 * 100.0).round();
        let value = if hundredths.is_finite() {
            hundredths / 100.0
        } else {
            0.0
        };
        // Adding zero turns −0 into 0.
        write!(f, "{}", value + 0.0)
    }
}

struct Hex(Color);

impl std::fmt::Display for Hex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b] = self.0.rgb;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

/// Text with XML's special characters named and control characters, which XML forbids, replaced.
struct Escaped<'a>(&'a str);

impl std::fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for letter in self.0.chars() {
            match letter {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '\u{fffe}' | '\u{ffff}' => f.write_char('\u{fffd}')?,
                _ if letter.is_control() => f.write_char('\u{fffd}')?,
                _ => f.write_char(letter)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_finite() {
        let show = |x| Number(x).to_string();
        assert_eq!(show(12.3456), "12.35");
        assert_eq!(show(-0.001), "0");
        assert_eq!(show(7.0), "7");
        assert_eq!(show(f64::NAN), "0");
    }

    #[test]
    fn names_cannot_break_the_document() {
        assert_eq!(
            Escaped("a<b>&\u{1}c").to_string(),
            "a&lt;b&gt;&amp;\u{fffd}c"
        );
    }
}
