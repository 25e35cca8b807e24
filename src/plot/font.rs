//! The typeface of all pictures: widths and outlines of its glyphs.
//!
//! A subset of DejaVu Sans (Latin, Greek, a few mathematical signs; license beside it) is part of
//! the crate, so that a PNG has the same pixels on every machine. SVG files name the typeface and leave
//! the choice of a substitute to the viewer.

use std::sync::LazyLock;

use nalgebra::Point2;
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// The font families named in SVG files; Verdana has DejaVu's widths.
pub(crate) const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// The typeface; never `None`, as a test checks (pictures would lack their texts).
static FACE: LazyLock<Option<Face<'static>>> =
    LazyLock::new(|| Face::parse(include_bytes!("font/DejaVuSans-subset.ttf"), 0).ok());

/// The width of `text` set in `size`, both in figure units.
#[must_use]
pub(crate) fn width(text: &str, size: f64) -> f64 {
    let Some(face) = FACE.as_ref() else {
        return 0.0;
    };
    let advances: f64 = text
        .chars()
        .map(|letter| advance(face, glyph(face, letter)))
        .sum();
    advances * size / f64::from(face.units_per_em())
}

/// Draws `text` set in `size` from the origin along +x, its baseline on y = 0 and y downward.
pub(crate) fn outline(text: &str, size: f64, pen: &mut impl Pen) {
    let Some(face) = FACE.as_ref() else { return };
    let scale = size / f64::from(face.units_per_em());
    let mut start = 0.0;
    for letter in text.chars() {
        let id = glyph(face, letter);
        let mut scaled = ScaledPen { pen, scale, start };
        // A blank has no outline and needs none.
        let _bounding_box = face.outline_glyph(id, &mut scaled);
        start += advance(face, id) * scale;
    }
}

/// `text` shortened in its middle by "…" until it is no wider than `limit` in `size`: both the
/// folder where a name begins and the variant where it ends stay readable.
#[must_use]
pub(crate) fn elided(text: &str, size: f64, limit: f64) -> String {
    let letters: Vec<char> = text.chars().collect();
    if width(text, size) <= limit {
        return text.to_owned();
    }
    for kept in (0..letters.len()).rev() {
        let (head, tail) = (kept.div_ceil(2), kept / 2);
        let short: String = letters[..head]
            .iter()
            .chain(&['…'])
            .chain(&letters[letters.len() - tail..])
            .collect();
        if width(&short, size) <= limit {
            return short;
        }
    }
    "…".to_owned()
}

/// `text` in as few lines as it takes, broken at blanks, so that none is wider than `limit`; a word that is
/// wider itself is shortened.
#[must_use]
pub(crate) fn lines(text: &str, size: f64, limit: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match (longer, lines.last_mut()) {
            (Some(longer), Some(last)) if width(&longer, size) <= limit => *last = longer,
            _ => lines.push(elided(word, size, limit)),
        }
    }
    lines
}

/// A receiver of the outlines of glyphs, in figure units.
pub(crate) trait Pen {
    /// Begins a contour.
    fn move_to(&mut self, to: Point2<f64>);
    /// Continues it straight.
    fn line_to(&mut self, to: Point2<f64>);
    /// Continues it by a quadratic Bézier curve.
    fn quadratic_to(&mut self, control: Point2<f64>, to: Point2<f64>);
    /// Ends the contour.
    fn close(&mut self);
}

fn glyph(face: &Face<'_>, letter: char) -> GlyphId {
    face.glyph_index(letter).unwrap_or_default()
}

fn advance(face: &Face<'_>, id: GlyphId) -> f64 {
    f64::from(face.glyph_hor_advance(id).unwrap_or(0))
}

struct ScaledPen<'a, P> {
    pen: &'a mut P,
    scale: f64,
    start: f64,
}

impl<P> ScaledPen<'_, P> {
    fn place(&self, x: f32, y: f32) -> Point2<f64> {
        Point2::new(
            self.start + self.scale * f64::from(x),
            -self.scale * f64::from(y),
        )
    }
}

impl<P: Pen> OutlineBuilder for ScaledPen<'_, P> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.pen.move_to(self.place(x, y));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.pen.line_to(self.place(x, y));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.pen.quadratic_to(self.place(x1, y1), self.place(x, y));
    }

    /// Never called: TrueType outlines are quadratic.
    fn curve_to(&mut self, _: f32, _: f32, _: f32, _: f32, x: f32, y: f32) {
        self.pen.line_to(self.place(x, y));
    }

    fn close(&mut self) {
        self.pen.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sign_we_write_has_a_glyph() {
        let face = FACE.as_ref().expect("the bundled font parses");
        for letter in ('!'..='~').chain("∞∣−·×…⁰¹²³⁴⁵⁶⁷⁸⁹⁻äéßøλρ°–".chars())
        {
            assert!(face.glyph_index(letter).is_some(), "{letter}");
        }
    }

    #[test]
    fn long_names_keep_both_ends() {
        let name = "experiments/cube-1000-linf-with-a-very-long-name/seed-7";
        let short = elided(name, 12.0, 150.0);
        assert!(width(&short, 12.0) <= 150.0);
        assert!(short.starts_with("exp") && short.ends_with("-7") && short.contains('…'));
        assert_eq!(elided("short", 12.0, 150.0), "short");
    }

    #[test]
    fn long_labels_are_broken_at_blanks() {
        let label = "energy (% of a square of the cell’s area)";
        let broken = lines(label, 12.0, 160.0);
        assert_eq!(broken.len(), 2, "{broken:?}");
        assert_eq!(broken.join(" "), label);
        assert!(broken.iter().all(|line| width(line, 12.0) <= 160.0));
        assert_eq!(lines(label, 12.0, 1e3), [label]);
    }
}
