//! A cell taken apart into its fragments as a figure of polygons, for SVG: what [`crate::plot::exploded`]
//! draws in pixels.
//!
//! Facets that face the viewer are drawn from the farthest to the nearest, the fragments one after the
//! other: moved apart they hide each other in that order. A facet is drawn in bands of equal distance.

use nalgebra::{Point2, Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::plot::camera::Camera;
use crate::plot::color::Color;
use crate::plot::exploded::{
    AXES, CAPTION_SPACE, EXPLOSION, Fragment, FragmentedCell, MARGIN, PALE, draw_legend, outward,
};
use crate::plot::figure::{Anchor, Figure, Shape, Stroke};
use crate::plot::panel::TITLE_SIZE;
use crate::plot::z_buffer::shade;

/// The side of the picture proper, in figure units.
const SIDE: f64 = 450.0;
/// Bands from the center to the farthest point.
const BANDS: u32 = 24;
const RIM: Stroke = Stroke::solid(Color::INK, 0.8);

/// A facet, where it is drawn.
struct DrawnFacet {
    corners: Vec<Point3<f64>>,
    /// How far it is moved.
    shift: Vector3<f64>,
    axis: usize,
    shade: f64,
    /// Of its fragment, then its own, toward the viewer.
    depth: [f64; 2],
}

/// The picture of a cell.
#[must_use]
pub(crate) fn exploded_figure(cell: &FragmentedCell) -> Figure {
    let mut figure = Figure::new(SIDE + 2.0 * MARGIN, SIDE + 2.0 * MARGIN + CAPTION_SPACE);
    let vertices = || cell.fragments.iter().flat_map(|it| it.shell.vertices());
    let extent = Bounds::of(vertices()).extent().max();
    let shift = |fragment: &Fragment| outward(fragment) * EXPLOSION * extent;
    let moved = cell.fragments.iter().flat_map(|fragment| {
        let shift = shift(fragment);
        fragment
            .shell
            .vertices()
            .iter()
            .map(move |vertex| vertex + shift)
    });
    let corner = Point2::new(MARGIN, MARGIN);
    let far = corner + nalgebra::Vector2::repeat(SIDE);
    let camera = Camera::fitting(moved, [corner, far]);
    let facets = cell.fragments.iter();
    let facets = facets.flat_map(|fragment| facets_toward(fragment, shift(fragment), &camera));
    let mut facets: Vec<DrawnFacet> = facets.collect();
    facets.sort_by(|a, b| {
        let [one, other] = [a.depth, b.depth];
        one[0]
            .total_cmp(&other[0])
            .then(one[1].total_cmp(&other[1]))
    });
    let distances = vertices().map(|vertex| (vertex - cell.center).amax());
    let farthest = distances.fold(0.0, f64::max);
    for facet in &facets {
        draw_facet(&mut figure, &camera, facet, (&cell.center, farthest));
    }
    let below = Point2::new(0.5 * figure.width, MARGIN + SIDE + CAPTION_SPACE);
    figure.text(below, &cell.caption, TITLE_SIZE, Anchor::Middle);
    draw_legend(&mut figure);
    figure
}

/// The facets of a fragment that face the viewer.
fn facets_toward(fragment: &Fragment, shift: Vector3<f64>, camera: &Camera) -> Vec<DrawnFacet> {
    let depth = |points: &[Point3<f64>]| {
        let depths = points
            .iter()
            .map(|point| camera.project(&(point + shift)).z);
        depths.sum::<f64>() / points.len().max(1) as f64
    };
    let of_fragment = depth(fragment.shell.vertices());
    let drawn = fragment.shell.loops().filter_map(|corners| {
        let corners: Vec<_> = corners.collect();
        let normal = normal(&corners)?;
        camera.slopes(&normal)?;
        Some(DrawnFacet {
            depth: [of_fragment, depth(&corners)],
            shade: shade(&normal),
            axis: fragment.axis.min(2),
            corners,
            shift,
        })
    });
    drawn.collect()
}

/// The unit normal of a polygon (Newell), none of one without area.
fn normal(corners: &[Point3<f64>]) -> Option<Vector3<f64>> {
    let origin = corners.first()?;
    let next = corners.iter().cycle().skip(1);
    let terms = corners.iter().zip(next);
    let sum: Vector3<f64> = terms.map(|(a, b)| (a - origin).cross(&(b - origin))).sum();
    sum.try_normalize(0.0)
}

/// Draws a facet from its farthest band to the nearest, each upon the last, and its rim.
fn draw_facet(
    figure: &mut Figure,
    camera: &Camera,
    facet: &DrawnFacet,
    (center, farthest): (&Point3<f64>, f64),
) {
    let place = |point: &Point3<f64>| camera.project(&(point + facet.shift)).xy();
    let distance = |point: &Point3<f64>| (point - center)[facet.axis].abs();
    for band in (1..=BANDS).rev() {
        let share = f64::from(band) / f64::from(BANDS);
        let part = nearer(&facet.corners, distance, share * farthest);
        if part.len() > 2 {
            let middle = share - 0.5 / f64::from(BANDS);
            let color = PALE.mix(AXES[facet.axis], middle).lit(facet.shade);
            fill(figure, part.iter().map(place).collect(), Some(color), None);
        }
    }
    let rim = facet.corners.iter().map(place).collect();
    fill(figure, rim, None, Some(RIM));
}

fn fill(
    figure: &mut Figure,
    contour: Vec<Point2<f64>>,
    fill: Option<Color>,
    stroke: Option<Stroke>,
) {
    figure.shapes.push(Shape::Path {
        contours: vec![contour],
        closed: true,
        fill,
        stroke,
    });
}

/// The part of a polygon no farther than `limit`, by a distance that is linear on it.
fn nearer(
    corners: &[Point3<f64>],
    distance: impl Fn(&Point3<f64>) -> f64,
    limit: f64,
) -> Vec<Point3<f64>> {
    let mut part = Vec::new();
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (from, to) = (distance(a) - limit, distance(b) - limit);
        if from <= 0.0 {
            part.push(*a);
        }
        if (from <= 0.0) != (to <= 0.0) {
            part.push(a + (b - a) * (from / (from - to)));
        }
    }
    part
}
