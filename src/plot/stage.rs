//! Shaded facets in space as pixels: a depth buffer.
//!
//! Every facet is filled row by row between the crossings of its loop with the row's middle, so
//! neighboring facets leave no gap and loops need not be convex. Where a pixel is nearer to a
//! crease of the facet's own rim than half a line's width it gets the line's color: lines are
//! exactly as visible as their facets. The buffer is finer than the picture and averaged at the
//! end, which smooths all edges.

use std::ops::Range;

use nalgebra::{Point2, Point3, Vector2, Vector3};
use tiny_skia::{Pixmap, PremultipliedColorU8};

use crate::geometry::bounds::Bounds;
use crate::geometry::shell::Shell;
use crate::plot::camera::Camera;
use crate::plot::color::Color;
use crate::plot::creases::creases;
use crate::plot::figure::Figure;
use crate::plot::png::{self, PngError};

/// Buffer pixels along a side of a picture pixel.
const FINENESS: usize = 2;

/// Toward the light: from above, then from the front, so that the three visible walls of a box
/// differ.
const LIGHT: Vector3<f64> = Vector3::new(0.30, -0.55, 0.78);

/// Brightness of a facet that the light does not reach, and how much it adds when it falls
/// straight on it (Lambert's cosine law).
const AMBIENT: f64 = 0.56;
const DIRECT: f64 = 0.50;

/// The width of facet rims in picture pixels.
const LINE: f64 = 1.7;

/// A picture of facets in the making.
#[derive(Debug)]
pub struct Stage {
    camera: Camera,
    width: usize,
    height: usize,
    depths: Vec<f32>,
    colors: Vec<[u8; 3]>,
    // Kept between facets for their memory.
    rim: Vec<Point3<f64>>,
    lines: Vec<[Point2<f64>; 2]>,
    crossings: Vec<f64>,
}

/// A facet as the camera sees it.
struct Seen<'a> {
    /// Its corners in buffer pixels, with their depths.
    rim: &'a [Point3<f64>],
    /// Its edges that get a line.
    lines: &'a [[Point2<f64>; 2]],
    /// How the depth grows per buffer pixel to the right and downward.
    slopes: [f64; 2],
    /// The least and the greatest depth.
    depths: [f64; 2],
    /// Its brightness.
    shade: f64,
}

impl Stage {
    /// An empty white stage of so many picture pixels, to be [aimed](Stage::aim) next.
    ///
    /// # Errors
    /// [`PngError::Size`] as [`png::png`].
    pub fn new(width: usize, height: usize) -> Result<Self, PngError> {
        png::check_size(width as f64, height as f64)?;
        let (width, height) = (width * FINENESS, height * FINENESS);
        Ok(Self {
            camera: Camera::fitting([], [Point2::origin(); 2]),
            width,
            height,
            depths: vec![f32::NEG_INFINITY; width * height],
            colors: vec![Color::WHITE.rgb; width * height],
            rim: Vec::new(),
            lines: Vec::new(),
            crossings: Vec::new(),
        })
    }

    /// Chooses the camera that shows all `points` in the picture's columns from `left` on, `width`
    /// of them.
    pub fn aim(
        &mut self,
        points: impl IntoIterator<Item = Point3<f64>>,
        left: usize,
        width: usize,
    ) {
        let right = (left + width) * FINENESS;
        let min = Point2::new((left * FINENESS) as f64, 0.0);
        let max = Point2::new(right as f64, self.height as f64);
        // Half of a rim's line lies beyond the facet.
        let margin = Vector2::repeat(LINE * FINENESS as f64);
        self.camera = Camera::fitting(points, [min + margin, max - margin]);
    }

    /// Draws the facets of a shell that face the viewer, `paint` telling the color at a point.
    pub fn draw(&mut self, shell: &Shell, paint: impl Fn(&Point3<f64>) -> Color) {
        let mut corners: Vec<Point3<f64>> = Vec::new();
        let creases = creases(shell);
        let mut first = 0;
        for facet in shell.loops() {
            corners.clear();
            corners.extend(facet);
            let following = first + corners.len();
            self.draw_facet(&corners, &creases[first..following], &paint);
            first = following;
        }
    }

    /// The picture under the shapes of `figure`, its upper left corner at `corner` of the figure,
    /// as the bytes of a PNG file of `scale` pixels per figure unit.
    ///
    /// # Errors
    /// [`PngError`] as [`png::png`].
    pub fn develop(
        &self,
        figure: &Figure,
        corner: Point2<f64>,
        scale: f64,
    ) -> Result<Vec<u8>, PngError> {
        let mut sheet = png::blank(figure.width * scale, figure.height * scale)?;
        self.average_onto(
            &mut sheet,
            (corner * scale).map(|length| length.round() as usize),
        );
        png::draw(figure, scale, &mut sheet);
        png::encode(&sheet)
    }

    /// Draws a facet, with lines from those of its corners that begin creases.
    fn draw_facet(
        &mut self,
        corners: &[Point3<f64>],
        creases: &[bool],
        paint: &impl Fn(&Point3<f64>) -> Color,
    ) {
        let Some(normal) = normal(corners) else {
            return;
        };
        let Some(slopes) = self.camera.slopes(&normal) else {
            return;
        };
        let mut rim = std::mem::take(&mut self.rim);
        rim.clear();
        rim.extend(corners.iter().map(|corner| self.camera.project(corner)));
        let mut lines = std::mem::take(&mut self.lines);
        lines.clear();
        let creased = edges(&rim).zip(creases).filter(|(_, is)| **is);
        lines.extend(creased.map(|((a, b), _)| [a.xy(), b.xy()]));
        let bounds = Bounds::of(&rim);
        let facet = Seen {
            rim: &rim,
            lines: &lines,
            slopes,
            depths: [bounds.min.z, bounds.max.z],
            shade: AMBIENT + DIRECT * normal.dot(&LIGHT.normalize()).max(0.0),
        };
        let mut crossings = std::mem::take(&mut self.crossings);
        for row in pixels(bounds.min.y, bounds.max.y, self.height) {
            find_crossings(&mut crossings, &rim, row as f64 + 0.5);
            for pair in crossings.chunks_exact(2) {
                self.fill(&facet, row, pixels(pair[0], pair[1], self.width), paint);
            }
        }
        self.rim = rim;
        self.lines = lines;
        self.crossings = crossings;
    }

    /// Fills a part of a row with a facet wherever nothing nearer is there yet.
    fn fill(
        &mut self,
        facet: &Seen<'_>,
        row: usize,
        columns: Range<usize>,
        paint: &impl Fn(&Point3<f64>) -> Color,
    ) {
        let anchor = facet.rim[0];
        let [least, greatest] = facet.depths;
        for column in columns {
            let pixel = Point2::new(column as f64 + 0.5, row as f64 + 0.5);
            let arm = pixel - anchor.xy();
            let depth = anchor.z + facet.slopes[0] * arm.x + facet.slopes[1] * arm.y;
            // A facet seen nearly edge-on has steep slopes, but its corners bound its depth.
            let depth = depth.max(least).min(greatest);
            let place = row * self.width + column;
            if depth as f32 <= self.depths[place] {
                continue;
            }
            self.depths[place] = depth as f32;
            let color = if is_near(facet.lines, &pixel) {
                Color::INK
            } else {
                let seen = Point3::new(pixel.x, pixel.y, depth);
                paint(&self.camera.unproject(&seen)).lit(facet.shade)
            };
            self.colors[place] = color.rgb;
        }
    }

    /// Averages the buffer onto `sheet`, beginning at its pixel `corner`.
    fn average_onto(&self, sheet: &mut Pixmap, corner: Point2<usize>) {
        let sheet_width = sheet.width() as usize;
        let pixels = sheet.pixels_mut();
        let columns = (self.width / FINENESS).min(sheet_width.saturating_sub(corner.x));
        for row in 0..self.height / FINENESS {
            let start = (row + corner.y) * sheet_width + corner.x;
            let Some(line) = pixels.get_mut(start..start + columns) else {
                return;
            };
            for (column, pixel) in line.iter_mut().enumerate() {
                let [r, g, b] = self.average(row, column);
                if let Some(color) = PremultipliedColorU8::from_rgba(r, g, b, 255) {
                    *pixel = color;
                }
            }
        }
    }

    fn average(&self, row: usize, column: usize) -> [u8; 3] {
        let mut sum = [0_usize; 3];
        for y in row * FINENESS..(row + 1) * FINENESS {
            for x in column * FINENESS..(column + 1) * FINENESS {
                for (total, part) in sum.iter_mut().zip(self.colors[y * self.width + x]) {
                    *total += usize::from(part);
                }
            }
        }
        sum.map(|total| ((total + FINENESS * FINENESS / 2) / (FINENESS * FINENESS)) as u8)
    }
}

/// The unit normal by Newell's sum; `None` for a facet without area.
fn normal(corners: &[Point3<f64>]) -> Option<Vector3<f64>> {
    let anchor = corners.first()?;
    let pairs = corners.iter().zip(corners.iter().skip(1));
    let sum: Vector3<f64> = pairs.map(|(a, b)| (a - anchor).cross(&(b - anchor))).sum();
    sum.try_normalize(0.0)
}

/// Where the rim crosses the height `y`, from left to right.
fn find_crossings(crossings: &mut Vec<f64>, rim: &[Point3<f64>], y: f64) {
    crossings.clear();
    for (a, b) in edges(rim) {
        if (a.y <= y) != (b.y <= y) {
            crossings.push(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
        }
    }
    crossings.sort_by(f64::total_cmp);
}

fn edges(rim: &[Point3<f64>]) -> impl Iterator<Item = (&Point3<f64>, &Point3<f64>)> {
    rim.iter().zip(rim.iter().cycle().skip(1))
}

/// The pixels of `0..count` whose middles lie in `from ≤ middle < to`.
fn pixels(from: f64, to: f64, count: usize) -> Range<usize> {
    // Casts saturate, so what lies outside the picture or is not a number costs nothing.
    let first = |edge: f64| ((edge - 0.5).ceil() as usize).min(count);
    first(from)..first(to)
}

fn is_near(lines: &[[Point2<f64>; 2]], pixel: &Point2<f64>) -> bool {
    let reach = 0.5 * LINE * FINENESS as f64;
    lines.iter().any(|[a, b]| {
        let (along, arm) = (b - a, pixel - a);
        let share = (arm.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (arm - share * along).norm_squared() < reach * reach
    })
}
