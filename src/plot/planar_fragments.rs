//! A cell of the plane shaded by its Chebyshev distance, beside its four fragments as triangles: \[BL\]
//! Fig. 10.

use nalgebra::{Point2, Vector2};

use crate::geometry::bounds::Bounds;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::label::Label;
use crate::geometry::polygon::ConvexPolygon;
use crate::plot::color::{Color, ColorScale};
use crate::plot::exploded::{AXES, EXPLOSION, PALE};
use crate::plot::figure::{Anchor, Figure, Shape, Stroke};
use crate::plot::panel::{BAR_SPACE, LABEL_SIZE, TITLE_SIZE, draw_color_bar};

/// A triangle between the site and a part of an edge, within one fragment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FlatTriangle {
    /// The axis of its distances, 0 or 1.
    pub axis: usize,
    /// Their direction, −1 or 1.
    pub sign: f64,
    /// Its corners beside the site, relative to it.
    pub ends: [Vector2<f64>; 2],
}

/// A cell to take apart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FlatCell {
    /// What is written below it.
    pub caption: String,
    /// What is written below the triangles.
    pub sum: String,
    /// Convex polygons that fill it, relative to the site.
    pub pieces: Vec<ConvexPolygon>,
    /// Its area (L²).
    pub area: f64,
    /// Its triangles.
    pub triangles: Vec<FlatTriangle>,
}

/// The longer side of either part, in figure units.
const SIDE: f64 = 320.0;
const MARGIN: f64 = 24.0;
const ABOVE: f64 = 44.0;
const BELOW: f64 = 56.0;
const GAP: f64 = 14.0;
/// The width of the legend below the triangles.
const LEGEND: f64 = 300.0;
/// Bands from the site to the farthest point.
const BANDS: u32 = 48;
const OUTLINE: Stroke = Stroke::solid(Color::INK, 1.6);
const THIN: Stroke = Stroke::solid(Color::INK, 0.8);
/// The square of the cell's area, to which its energy is compared.
const SQUARE: Stroke = Stroke {
    color: Color::INK,
    width: 1.2,
    dash: Some([5.0, 4.0]),
};

/// The picture of a cell.
#[must_use]
pub(crate) fn fragments_figure(cell: &FlatCell) -> Figure {
    let half = 0.5 * cell.area.max(0.0).sqrt();
    let bounds = bounds(cell, half);
    let extent = bounds.extent().max();
    // Both parts have one scale, with room for the fragments that move apart.
    let factor = SIDE / (extent * (1.0 + 2.0 * EXPLOSION));
    let size = bounds.extent().add_scalar(2.0 * EXPLOSION * extent) * factor;
    let bar = Point2::new(MARGIN + size.x + GAP, ABOVE);
    let view = |left: f64| View::new(left, (&bounds, size, factor));
    let (left, right) = (view(MARGIN), view(bar.x + BAR_SPACE + GAP));
    let width = right.corner.x + size.x.max(LEGEND) + MARGIN;
    let mut figure = Figure::new(width, ABOVE + size.y + BELOW);
    let scale = ColorScale {
        label: "Chebyshev distance from the site".to_owned(),
        min: 0.0,
        max: farthest(cell),
    };
    draw_distances(&mut figure, &left, cell, &scale);
    draw_square(&mut figure, &left, half);
    draw_color_bar(&mut figure, bar, size.y, &scale);
    draw_triangles(&mut figure, &right, (cell, EXPLOSION * extent), scale.max);
    left.name(&mut figure, "The cell and its distances", &cell.caption);
    right.name(&mut figure, "Its four fragments, as triangles", &cell.sum);
    let start = Point2::new(MARGIN, ABOVE + size.y + 38.0);
    figure.line(start, start + Vector2::new(26.0, 0.0), SQUARE);
    let beside = Point2::new(start.x + 34.0, start.y + 0.36 * LABEL_SIZE);
    figure.text(beside, "the square of its area", LABEL_SIZE, Anchor::Start);
    for (axis, name) in ["distances along x", "distances along y"]
        .into_iter()
        .enumerate()
    {
        let x = right.corner.x + 150.0 * axis as f64;
        let min = Point2::new(x, start.y - 5.5);
        figure.rectangle([min, min.map(|c| c + 11.0)], Some(AXES[axis]), None);
        let beside = Point2::new(x + 17.0, start.y + 0.36 * LABEL_SIZE);
        figure.text(beside, name, LABEL_SIZE, Anchor::Start);
    }
    figure
}

/// The box around the cell, its site and the square of half side `half` about that.
fn bounds(cell: &FlatCell, half: f64) -> Bounds<2> {
    let mut bounds = Bounds::of(cell.pieces.iter().flat_map(ConvexPolygon::vertices));
    bounds.include(&Point2::new(half, half));
    bounds.include(&Point2::new(-half, -half));
    bounds
}

/// The greatest distance of the cell's points from the site (L).
fn farthest(cell: &FlatCell) -> f64 {
    let vertices = cell.pieces.iter().flat_map(ConvexPolygon::vertices);
    let distances = vertices.map(|vertex| vertex.coords.amax());
    distances.fold(f64::MIN_POSITIVE, f64::max)
}

/// Where a part of the picture lies.
struct View {
    corner: Point2<f64>,
    size: Vector2<f64>,
    middle: Point2<f64>,
    /// The domain's point there.
    center: Point2<f64>,
    factor: f64,
}

impl View {
    fn new(left: f64, (bounds, size, factor): (&Bounds<2>, Vector2<f64>, f64)) -> Self {
        let corner = Point2::new(left, ABOVE);
        Self {
            corner,
            size,
            middle: corner + size * 0.5,
            center: bounds.center(),
            factor,
        }
    }

    fn place(&self, point: &Point2<f64>) -> Point2<f64> {
        let arm = (point - self.center) * self.factor;
        Point2::new(self.middle.x + arm.x, self.middle.y - arm.y)
    }

    /// Writes a title above and a caption below.
    fn name(&self, figure: &mut Figure, title: &str, caption: &str) {
        let middle = self.corner.x + 0.5 * self.size.x;
        let above = Point2::new(middle, ABOVE - 18.0);
        figure.text(above, title, TITLE_SIZE, Anchor::Middle);
        let below = Point2::new(middle, ABOVE + self.size.y + 18.0);
        figure.text(below, caption, LABEL_SIZE, Anchor::Middle);
    }

    fn draw(
        &self,
        figure: &mut Figure,
        polygon: &ConvexPolygon,
        fill: Option<Color>,
        stroke: Option<Stroke>,
    ) {
        if polygon.is_empty() {
            return;
        }
        let corners = polygon.vertices().iter();
        figure.shapes.push(Shape::Path {
            contours: vec![corners.map(|corner| self.place(corner)).collect()],
            closed: true,
            fill,
            stroke,
        });
    }
}

/// The cell in bands of equal distance, each drawn upon the farther ones.
fn draw_distances(figure: &mut Figure, view: &View, cell: &FlatCell, scale: &ColorScale) {
    for band in (1..=BANDS).rev() {
        let share = f64::from(band) / f64::from(BANDS);
        let color = scale.color((share - 0.5 / f64::from(BANDS)) * scale.max);
        for piece in &cell.pieces {
            let mut near = piece.clone();
            for normal in [Vector2::x(), Vector2::y(), -Vector2::x(), -Vector2::y()] {
                let offset = share * scale.max;
                near.clip(&HalfPlane { normal, offset }, Label::MAX);
            }
            view.draw(figure, &near, Some(color), None);
        }
    }
    for piece in &cell.pieces {
        view.draw(figure, piece, None, Some(OUTLINE));
    }
    figure.shapes.push(Shape::Disc {
        center: view.place(&Point2::origin()),
        radius: 3.2,
        fill: Color::INK,
    });
}

fn draw_square(figure: &mut Figure, view: &View, half: f64) {
    let corners = [
        [1.0, 1.0],
        [-1.0, 1.0],
        [-1.0, -1.0],
        [1.0, -1.0],
        [1.0, 1.0],
    ];
    let corners = corners.map(|corner| Point2::from(corner) * half);
    let outline = corners.iter().map(|corner| view.place(corner));
    figure.polyline(outline.collect(), SQUARE);
}

/// The triangles, each in bands of its own distance and moved outward with its fragment.
fn draw_triangles(
    figure: &mut Figure,
    view: &View,
    (cell, explosion): (&FlatCell, f64),
    farthest: f64,
) {
    for triangle in &cell.triangles {
        let axis = triangle.axis.min(1);
        let mut outward = Vector2::zeros();
        outward[axis] = triangle.sign;
        let ends = triangle.ends.map(Point2::from);
        let corners = [Point2::origin(), ends[0], ends[1]];
        let whole = ConvexPolygon::from_corners(corners, [Label::MAX; 3]);
        let moved = |polygon: &ConvexPolygon| polygon.translated(&(outward * explosion));
        for band in (1..=BANDS).rev() {
            let share = f64::from(band) / f64::from(BANDS);
            let mut near = whole.clone();
            let (normal, offset) = (outward, share * farthest);
            near.clip(&HalfPlane { normal, offset }, Label::MAX);
            let color = PALE.mix(AXES[axis], share - 0.5 / f64::from(BANDS));
            view.draw(figure, &moved(&near), Some(color), None);
        }
        view.draw(figure, &moved(&whole), None, Some(THIN));
    }
}
