//! The picture of a density in a plane cut through a solid, with centers, support and axes.
//!
//! The density is drawn as rows of rectangles, wider than the section; what lies outside the section
//! is then painted white by one path. So the section's outline stays sharp at any size.

use nalgebra::{Point2, Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::shell::Shell;
use crate::mesh::surface::SurfaceMesh;
use crate::parallel::map;
use crate::plot::axis::Axis;
use crate::plot::color::{Color, ColorScale};
use crate::plot::figure::{Anchor, Figure, Shape, Stroke};
use crate::plot::font;
use crate::plot::panel::{BAR_SPACE, LABEL_SIZE, Panel, draw_color_bar};
use crate::plot::patches::PlaneCut;

/// A density in a plane cut of a solid, and what is marked there.
pub(crate) struct DensityCut<'a> {
    /// The solid's boundary.
    pub surface: &'a SurfaceMesh,
    /// The plane.
    pub cut: PlaneCut,
    /// The density at a point; NaN where there is none.
    pub density: &'a (dyn Fn(&Point3<f64>) -> f64 + Sync),
    /// The picture's title.
    pub title: &'a str,
    /// Drawn upon the density, later ones upon earlier ones; the legend names them.
    pub marks: &'a [Mark],
}

/// Something drawn upon a cut, projected to its plane.
#[derive(Clone, Debug)]
pub(crate) struct Mark {
    /// Its name in the legend; without one it is not listed.
    pub name: String,
    /// Its color.
    pub color: Color,
    /// What is drawn.
    pub shape: MarkShape,
}

/// The shapes of marks.
#[derive(Clone, Debug)]
pub(crate) enum MarkShape {
    /// A disc, as of a center of mass.
    Point(Point3<f64>),
    /// A closed polygon, as of a support; from the side it is a thick line.
    Polygon(Vec<Point3<f64>>),
    /// A line through a point along a direction, over the whole picture.
    Line {
        /// The point.
        through: Point3<f64>,
        /// The direction.
        along: Vector3<f64>,
        /// Whether it is dashed.
        dashed: bool,
    },
}

/// The color of what is native: the center of the constant density.
pub(crate) const NATIVE: Color = Color::WHITE;
/// The color of what is obtained.
pub(crate) const OBTAINED: Color = Color::hex(0xe4_1a_1c);
/// The color of what is wanted: a support, an axis.
pub(crate) const WANTED: Color = Color::hex(0xff_7f_00);

/// The longer side of the picture proper, in figure units.
const LONGER_SIDE: f64 = 560.0;
/// The least of the shorter side.
const LEAST_SIDE: f64 = 220.0;
/// Spaces left, above and below of the frame: tick labels, title, axis name and legend.
const SPACES: [f64; 3] = [78.0, 40.0, 52.0];
const BAR_GAP: f64 = 18.0;
const LEGEND_LINE: f64 = 19.0;
/// Rectangles along the longer side.
const STEPS: f64 = 240.0;
/// Colors told apart: neighbors of one color are one rectangle.
const COLORS: f64 = 64.0;
/// The margin around section and marks, as a share of their extent.
const MARGIN: f64 = 0.05;
const OUTLINE: Stroke = Stroke::solid(Color::INK, 1.2);

/// The picture of a cut.
#[must_use]
pub(crate) fn density_cut(input: &DensityCut<'_>) -> Figure {
    let contours = contours(input);
    let panel = panel(input, &contours);
    let [min, max] = panel.frame;
    let named = input.marks.iter().filter(|mark| !mark.name.is_empty());
    let names = named.clone();
    let widest = names.map(|mark| min.x + 50.0 + font::width(&mark.name, LABEL_SIZE));
    let mut figure = Figure::new(
        widest.fold(max.x + BAR_GAP + BAR_SPACE, f64::max),
        max.y + SPACES[2] + LEGEND_LINE * named.clone().count() as f64,
    );
    let values = Raster::of(input, &panel, &contours);
    let scale = values.scale();
    values.draw(&mut figure, &panel, &scale);
    let place =
        |contour: &Vec<Point2<f64>>| contour.iter().map(|p| panel.place(p.x, p.y)).collect();
    let placed: Vec<Vec<Point2<f64>>> = contours.iter().map(place).collect();
    mask(&mut figure, &panel, &placed);
    for mark in input.marks {
        draw_mark(&mut figure, &panel, &input.cut, mark);
    }
    let [x, y] = input.cut.axis_names();
    panel.draw_ticks(&mut figure);
    panel.draw_frame(&mut figure, input.title, &x, &y);
    for (line, mark) in named.enumerate() {
        let y = max.y + SPACES[2] + LEGEND_LINE * (line as f64 + 0.1);
        draw_legend(&mut figure, Point2::new(min.x, y), mark);
    }
    let corner = Point2::new(max.x + BAR_GAP, min.y);
    draw_color_bar(&mut figure, corner, max.y - min.y, &scale);
    figure
}

/// The section's contours in the plane.
fn contours(input: &DensityCut<'_>) -> Vec<Vec<Point2<f64>>> {
    let surface = input.surface;
    let facets = surface.triangles.iter().copied();
    let shell = Shell::new(&surface.vertices, facets).unwrap_or_default();
    let patch = input.cut.patch(&shell, 0.0);
    patch.map_or(Vec::new(), |patch| patch.contours)
}

/// Frame and axes around the section and the marks, lines apart.
fn panel(input: &DensityCut<'_>, contours: &[Vec<Point2<f64>>]) -> Panel {
    let marked = input.marks.iter().flat_map(points_of);
    let marked: Vec<_> = marked.map(|point| input.cut.flat(&point)).collect();
    let mut bounds = Bounds::of(contours.iter().flatten().chain(&marked));
    if !bounds.extent().iter().all(|length| length.is_finite()) {
        bounds = Bounds::of(&[Point2::origin(), Point2::new(1.0, 1.0)]);
    }
    let longest = bounds.extent().max().max(f64::MIN_POSITIVE);
    let factor = LONGER_SIDE / (longest * (1.0 + 2.0 * MARGIN));
    let size = bounds.extent().map(|length| {
        let side = factor * (length + 2.0 * MARGIN * longest);
        side.max(LEAST_SIDE)
    });
    let (middle, half) = (bounds.center(), size / (2.0 * factor));
    let corner = Point2::new(SPACES[0], SPACES[1]);
    Panel {
        frame: [corner, corner + size],
        x: Axis::within(middle.x - half.x, middle.x + half.x),
        y: Axis::within(middle.y - half.y, middle.y + half.y),
    }
}

/// The points that a mark shows; none of a line without ends.
fn points_of(mark: &Mark) -> Vec<Point3<f64>> {
    match &mark.shape {
        MarkShape::Point(point) => vec![*point],
        MarkShape::Polygon(corners) => corners.clone(),
        MarkShape::Line { .. } => Vec::new(),
    }
}

/// Values at the middles of equal squares over a panel.
struct Raster {
    columns: usize,
    /// Row by row from above; where one is NaN, a neighbor's.
    values: Vec<f64>,
    /// Whether the middles lie within the section.
    inside: Vec<bool>,
}

impl Raster {
    fn of(input: &DensityCut<'_>, panel: &Panel, contours: &[Vec<Point2<f64>>]) -> Self {
        let (width, height) = (panel.x.max - panel.x.min, panel.y.max - panel.y.min);
        let side = width.max(height) / STEPS;
        let [columns, rows] = [width, height].map(|length| (length / side).ceil() as usize);
        let place = |number: usize| {
            let (row, column) = (number / columns, number % columns);
            let share = |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
            Point2::new(
                panel.x.min + share(column, columns) * width,
                panel.y.max - share(row, rows) * height,
            )
        };
        let places: Vec<_> = (0..rows * columns).map(place).collect();
        let value = |place: usize| (input.density)(&input.cut.lifted(&places[place]));
        let known: Vec<f64> = map(places.len(), &value);
        let values = (0..known.len()).map(|k| with_neighbors(&known, columns, k));
        Self {
            columns,
            values: values.collect(),
            inside: map(places.len(), &|place| holds(contours, &places[place])),
        }
    }

    /// The scale over the values within the section.
    fn scale(&self) -> ColorScale {
        let pairs = self.inside.iter().zip(&self.values);
        let inside = pairs.filter(|(is_inside, value)| **is_inside && value.is_finite());
        let ends = inside.fold(None, |ends: Option<[f64; 2]>, (_, &value)| {
            let [low, high] = ends.unwrap_or([value; 2]);
            Some([low.min(value), high.max(value)])
        });
        let [min, max] = ends.unwrap_or([0.0, 1.0]);
        let least = 1e-3 * max.abs().max(min.abs()).max(f64::MIN_POSITIVE);
        ColorScale {
            label: "density".to_owned(),
            min,
            max: max.max(min + least),
        }
    }

    /// Whether a square or one of its neighbors has its middle in the section; others are not seen.
    fn is_near(&self, row: usize, column: usize) -> bool {
        let rows = row.saturating_sub(1)..(row + 2).min(self.inside.len() / self.columns);
        let columns = column.saturating_sub(1)..(column + 2).min(self.columns);
        rows.into_iter().any(|row| {
            let line = &self.inside[row * self.columns..][..self.columns];
            line[columns.clone()].contains(&true)
        })
    }

    /// Every run of one color reaches a square into the next, every row a little downward: so no seam shows.
    fn draw(&self, figure: &mut Figure, panel: &Panel, scale: &ColorScale) {
        let [min, max] = panel.frame;
        let width = (max.x - min.x) / self.columns as f64;
        let height = (max.y - min.y) / (self.values.len() / self.columns) as f64;
        for row in 0..self.values.len() / self.columns {
            let top = min.y + row as f64 * height;
            let runs = self.runs(row, scale);
            let ends = runs.iter().skip(1).map(|(column, _)| column + 1);
            let ends = ends.chain([self.columns]);
            for ((column, color), end) in runs.iter().zip(ends) {
                let start = Point2::new(min.x + *column as f64 * width, top);
                let right = (min.x + end as f64 * width).min(max.x);
                let end = Point2::new(right, (top + 1.5 * height).min(max.y));
                let value = scale.min + color / COLORS * (scale.max - scale.min);
                figure.rectangle([start, end], Some(scale.color(value)), None);
            }
        }
    }

    /// Where a row's colors begin, and which they are (0 to `COLORS`).
    fn runs(&self, row: usize, scale: &ColorScale) -> Vec<(usize, f64)> {
        let values = &self.values[row * self.columns..][..self.columns];
        let step = |value: f64| ((value - scale.min) / (scale.max - scale.min) * COLORS).round();
        let near = (0..self.columns).filter(|&column| self.is_near(row, column));
        let mut runs: Vec<_> = near
            .map(|column| (column, step(values[column]).clamp(0.0, COLORS)))
            .collect();
        runs.dedup_by(|one, last| one.1.total_cmp(&last.1).is_eq());
        runs
    }
}

/// The value at place `k`, or the mean of those beside it that are numbers.
fn with_neighbors(values: &[f64], columns: usize, k: usize) -> f64 {
    if values[k].is_finite() {
        return values[k];
    }
    let column = k % columns;
    let beside = [
        (column > 0).then(|| k - 1),
        (column + 1 < columns).then_some(k + 1),
        k.checked_sub(columns),
        (k + columns < values.len()).then_some(k + columns),
    ];
    let known = beside.into_iter().flatten().map(|n| values[n]);
    let known: Vec<f64> = known.filter(|value| value.is_finite()).collect();
    known.iter().sum::<f64>() / known.len() as f64
}

/// Whether a point lies within contours, by the even-odd rule.
fn holds(contours: &[Vec<Point2<f64>>], point: &Point2<f64>) -> bool {
    let sides = contours.iter().flat_map(|contour| {
        let following = contour.iter().cycle().skip(1);
        contour.iter().zip(following)
    });
    let crossed = sides.filter(|(a, b)| {
        let passes = (a.y > point.y) != (b.y > point.y);
        passes && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossed.count() % 2 == 1
}

/// Paints what lies in the frame but not in the contours white, and draws those.
fn mask(figure: &mut Figure, panel: &Panel, contours: &[Vec<Point2<f64>>]) {
    let path = |contours, fill, stroke| Shape::Path {
        contours,
        closed: true,
        fill,
        stroke,
    };
    let outside = std::iter::once(corners(panel.frame))
        .chain(contours.iter().cloned())
        .collect();
    figure.shapes.push(path(outside, Some(Color::WHITE), None));
    if !contours.is_empty() {
        figure
            .shapes
            .push(path(contours.to_vec(), None, Some(OUTLINE)));
    }
}

/// The corners of a rectangle, one after the other.
fn corners([min, max]: [Point2<f64>; 2]) -> Vec<Point2<f64>> {
    vec![
        min,
        Point2::new(max.x, min.y),
        max,
        Point2::new(min.x, max.y),
    ]
}

fn draw_mark(figure: &mut Figure, panel: &Panel, cut: &PlaneCut, mark: &Mark) {
    let at = |flat: Point2<f64>| panel.place(flat.x, flat.y);
    let placed = |point: &Point3<f64>| at(cut.flat(point));
    match &mark.shape {
        MarkShape::Point(point) => disc(figure, placed(point), mark.color),
        MarkShape::Polygon(corners) => {
            let contour = corners.iter().map(placed).collect();
            figure.shapes.push(outline(contour, mark.color));
        }
        MarkShape::Line {
            through,
            along,
            dashed,
        } => {
            let [start, end] = [placed(through), placed(&(through + along.normalize()))];
            if let Some([from, to]) = across(panel.frame, start, end - start) {
                draw_line(figure, [from, to], mark.color, *dashed);
            }
        }
    }
}

fn outline(contour: Vec<Point2<f64>>, color: Color) -> Shape {
    Shape::Path {
        contours: vec![contour],
        closed: true,
        fill: None,
        stroke: Some(Stroke::solid(color, 3.0)),
    }
}

/// A line with dark edges, so that bright ones are seen on white.
fn draw_line(figure: &mut Figure, [from, to]: [Point2<f64>; 2], color: Color, dashed: bool) {
    let dash = dashed.then_some([7.0, 4.0]);
    for (width, color) in [(3.2, Color::INK), (1.8, color)] {
        figure.line(from, to, Stroke { color, width, dash });
    }
}

fn disc(figure: &mut Figure, center: Point2<f64>, color: Color) {
    for (radius, fill) in [(6.5, Color::INK), (5.0, color)] {
        figure.shapes.push(Shape::Disc {
            center,
            radius,
            fill,
        });
    }
}

/// The part of a line in a frame; none where it passes by, or is a point.
fn across(
    [min, max]: [Point2<f64>; 2],
    through: Point2<f64>,
    along: nalgebra::Vector2<f64>,
) -> Option<[Point2<f64>; 2]> {
    if along.norm() < 1e-9 * (max - min).norm() {
        return None;
    }
    let mut range = [f64::NEG_INFINITY, f64::INFINITY];
    for axis in 0..2 {
        let ends = [min[axis], max[axis]].map(|side| (side - through[axis]) / along[axis]);
        if ends.iter().all(|end| !end.is_nan()) {
            range[0] = range[0].max(ends[0].min(ends[1]));
            range[1] = range[1].min(ends[0].max(ends[1]));
        }
    }
    let is_inside = range[0] < range[1] && range.iter().all(|end| end.is_finite());
    is_inside.then(|| range.map(|share| through + along * share))
}

/// A line of the legend: the mark's sign and name.
fn draw_legend(figure: &mut Figure, corner: Point2<f64>, mark: &Mark) {
    let sign = Point2::new(corner.x + 12.0, corner.y);
    let (left, right) = (
        Point2::new(corner.x, corner.y),
        Point2::new(corner.x + 24.0, corner.y),
    );
    match &mark.shape {
        MarkShape::Point(_) => disc(figure, sign, mark.color),
        MarkShape::Polygon(_) => figure.line(left, right, Stroke::solid(mark.color, 3.0)),
        MarkShape::Line { dashed, .. } => draw_line(figure, [left, right], mark.color, *dashed),
    }
    let beside = Point2::new(corner.x + 34.0, corner.y + 0.36 * LABEL_SIZE);
    figure.text(beside, &mark.name, LABEL_SIZE, Anchor::Start);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::half_space::HalfSpace;
    use crate::mesh::shapes::unit_cube;

    #[test]
    fn a_cut_shows_its_values_its_outline_and_what_is_marked() {
        let cut = PlaneCut::new(HalfSpace {
            normal: Vector3::z(),
            offset: 0.25,
        });
        let mark = |name: &str, shape| Mark {
            name: name.to_owned(),
            color: NATIVE,
            shape,
        };
        let axis = MarkShape::Line {
            through: Point3::new(0.5, 0.5, 0.0),
            along: Vector3::x(),
            dashed: true,
        };
        let figure = density_cut(&DensityCut {
            surface: &unit_cube(),
            cut,
            density: &|place| if place.x < 0.5 { 1.0 } else { 10.0 * place.z },
            title: "Halves",
            marks: &[
                mark("center", MarkShape::Point(Point3::new(0.25, 0.5, 0.9))),
                mark("axis", axis),
            ],
        });
        let texts: Vec<&str> = (figure.shapes.iter())
            .filter_map(|shape| match shape {
                Shape::Text(text) => Some(&text.content[..]),
                _ => None,
            })
            .collect();
        for name in [
            "Halves", "x", "y", "center", "axis", "density", "1.0", "2.5",
        ] {
            assert!(texts.contains(&name), "{name} in {texts:?}");
        }
        let discs = figure.shapes.iter().filter_map(|shape| match shape {
            Shape::Disc { center, .. } => Some(center.x),
            _ => None,
        });
        // In the frame from −0.05 to 1.05, and in the legend.
        let along = SPACES[0] + LONGER_SIDE * 0.3 / 1.1;
        let mut first = discs.take(1);
        assert!((first.next().expect("the center is drawn") - along).abs() < 1e-9);
    }

    #[test]
    fn lines_reach_from_side_to_side_and_points_are_none() {
        let frame = [Point2::new(0.0, 0.0), Point2::new(10.0, 4.0)];
        let through = Point2::new(5.0, 1.0);
        let line = across(frame, through, nalgebra::Vector2::new(1.0, 1.0));
        let expected = [Point2::new(4.0, 0.0), Point2::new(8.0, 4.0)];
        assert_eq!(line, Some(expected));
        assert_eq!(across(frame, through, nalgebra::Vector2::zeros()), None);
        let outside = Point2::new(5.0, 9.0);
        assert_eq!(across(frame, outside, nalgebra::Vector2::x()), None);
    }
}
