//! Shaded facets in space as pixels: a depth buffer.
//!
//! Every facet is filled row by row between the crossings of its loop with the row's middle, so
//! neighboring facets leave no gap and loops need not be convex. Where a pixel is nearer to a
//! crease of the facet's own rim than half a line's width it gets the line's color: lines are
//! exactly as visible as their facets. The buffer is finer than the picture and averaged at the
//! end, which smooths all edges.
//!
//! An edge gets a line where the facets' normals differ, and where the surface turns away from the viewer: a cell's
//! part of a solid's surface consists of the surface's triangles, and a facet with a hole may be
//! one loop that runs along a bridge twice. Lines between such parts of one wall would hide the
//! cells.

use std::ops::Range;

use nalgebra::{Point2, Point3, Vector2, Vector3};
use tiny_skia::{Pixmap, PremultipliedColorU8};

use crate::geometry::bounds::Bounds;
use crate::geometry::shell::Shell;
use crate::plot::camera::{Camera, TOWARD};
use crate::plot::color::Color;
use crate::plot::figure::Figure;
use crate::plot::png::{self, PngError};

/// Buffer pixels along a side of a picture pixel.
const FINENESS: usize = 2;

/// Toward the light: from above, then from the front, so that the three visible walls of a box
/// differ.
const LIGHT: Vector3<f64> = Vector3::new(0.30, -0.55, 0.78);

/// Brightness of a facet that the light does not reach, and how much it adds when it falls
/// straight on it (Lambert's cosine law): together 1, which is the color of the color bar.
const AMBIENT: f64 = 0.54;
const DIRECT: f64 = 0.46;

/// The brightness of a facet with this unit normal, 0 to 1.
pub(crate) fn shade(normal: &Vector3<f64>) -> f64 {
    AMBIENT + DIRECT * normal.dot(&LIGHT.normalize()).max(0.0)
}

/// The width of facet rims in picture pixels.
const LINE: f64 = 1.7;

/// A picture under construction, with the depth of every pixel.
#[derive(Debug)]
pub(crate) struct ZBuffer {
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

/// A facet in the camera's projection.
struct ProjectedFacet<'a> {
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

impl ZBuffer {
    /// An empty white buffer of so many picture pixels, to be [aimed](ZBuffer::aim) next.
    ///
    /// # Errors
    /// [`PngError::Size`] as [`png::png`].
    pub(crate) fn new(width: usize, height: usize) -> Result<Self, PngError> {
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
    pub(crate) fn aim(
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

    /// Draws the facets of a shell that face the viewer, `paint` giving the color at a point.
    pub(crate) fn draw(&mut self, shell: &Shell, paint: impl Fn(&Point3<f64>) -> Color) {
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

    /// Where a point appears, in picture pixels.
    pub(crate) fn image(&self, point: &Point3<f64>) -> Point2<f64> {
        self.camera.project(point).xy() / FINENESS as f64
    }

    /// The picture under the shapes of `figure`, its upper left corner at `corner` of the figure,
    /// as the bytes of a PNG file of `scale` pixels per figure unit.
    ///
    /// # Errors
    /// [`PngError`] as [`png::png`].
    pub(crate) fn to_png(
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
        let facet = ProjectedFacet {
            rim: &rim,
            lines: &lines,
            slopes,
            depths: [bounds.min.z, bounds.max.z],
            shade: shade(&normal),
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
        facet: &ProjectedFacet<'_>,
        row: usize,
        columns: Range<usize>,
        paint: &impl Fn(&Point3<f64>) -> Color,
    ) {
        let anchor = facet.rim[0];
        let [least, greatest] = facet.depths;
        let mut last = (Color::WHITE, Color::WHITE.lit(facet.shade));
        for column in columns {
            let pixel = Point2::new(column as f64 + 0.5, row as f64 + 0.5);
            let arm = pixel - anchor.xy();
            let depth = anchor.z + facet.slopes[0] * arm.x + facet.slopes[1] * arm.y;
            // A facet viewed nearly edge-on has steep slopes, but its corners bound its depth.
            let depth = depth.max(least).min(greatest);
            let place = row * self.width + column;
            if depth as f32 <= self.depths[place] {
                continue;
            }
            self.depths[place] = depth as f32;
            let color = if is_near(facet.lines, &pixel) {
                Color::INK
            } else {
                let image = Point3::new(pixel.x, pixel.y, depth);
                let color = paint(&self.camera.unproject(&image));
                if color != last.0 {
                    last = (color, color.lit(facet.shade));
                }
                last.1
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

/// The cosine below which two facets meet in a crease: 25°, more than between
/// triangles of a smooth surface, less than at the corners of a polyhedron.
const CREASE: f64 = 0.9;

/// A side of a facet: the edge's lower and higher vertex, the facet, the side's place.
type FacetSide = ([u32; 2], u32, usize);

/// For every corner of every facet, one facet after the other, whether the edge from it to the next
/// is a crease.
fn creases(shell: &Shell) -> Vec<bool> {
    let mut normals: Vec<Vector3<f64>> = Vec::with_capacity(shell.facet_count());
    let mut sides: Vec<FacetSide> = Vec::new();
    for (facet, corners) in (0..).zip(shell.facets()) {
        let rim: Vec<_> = corners
            .iter()
            .map(|&k| shell.vertices()[k as usize])
            .collect();
        normals.push(normal(&rim).unwrap_or_default());
        for (k, &from) in corners.iter().enumerate() {
            let to = corners[(k + 1) % corners.len()];
            sides.push(([from.min(to), from.max(to)], facet, sides.len()));
        }
    }
    let mut creases = vec![true; sides.len()];
    sides.sort_unstable();
    for edge in sides.chunk_by(|one, other| one.0 == other.0) {
        let creased = |one: &FacetSide| {
            edge.iter()
                .any(|other| meet_in_crease(&normals, one.1, other.1))
        };
        let is_crease = edge.len() < 2 || edge.iter().any(creased);
        for &(_, _, place) in edge {
            creases[place] = is_crease;
        }
    }
    creases
}

/// Whether two facets form an angle above the limit, or one faces the viewer and the other not.
fn meet_in_crease(normals: &[Vector3<f64>], one: u32, other: u32) -> bool {
    let [one, other] = [one, other].map(|facet| normals[facet as usize]);
    let faces = |normal: &Vector3<f64>| normal.dot(&TOWARD) > 0.0;
    one.dot(&other) < CREASE || faces(&one) != faces(&other)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A prism over a square whose top is cut in two along a diagonal, the middle raised.
    fn creases_of_top(raised: f64) -> usize {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut vertices: Vec<Point3<f64>> = square
            .iter()
            .map(|[x, y]| Point3::new(*x, *y, 0.0))
            .collect();
        let lift = |k: usize| if k.is_multiple_of(2) { raised } else { 0.0 };
        let top = square.iter().enumerate();
        vertices.extend(top.map(|(k, [x, y])| Point3::new(*x, *y, 1.0 + lift(k))));
        let facets: Vec<Vec<u32>> = vec![
            vec![0, 3, 2, 1],
            vec![4, 5, 6],
            vec![4, 6, 7],
            vec![0, 1, 5, 4],
            vec![1, 2, 6, 5],
            vec![2, 3, 7, 6],
            vec![3, 0, 4, 7],
        ];
        let shell = Shell::new(&vertices, facets).expect("corners are there");
        creases(&shell).into_iter().filter(|&is| is).count()
    }

    #[test]
    fn a_wall_of_two_triangles_has_no_line_between_them() {
        assert_eq!(creases_of_top(0.0), 24);
        assert_eq!(creases_of_top(0.6), 26);
    }
}
