//! Flat pictures of cells: polygons colored by a value, with thin outlines and a color bar.
//!
//! The cells of a diagram in the plane, or the polygons in which a plane cuts those in space
//! ([`PlaneCut`]).

use nalgebra::{Point2, Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::section::section;
use crate::geometry::shell::Shell;
use crate::plot::axis::Axis;
use crate::plot::color::{Color, ColorScale};
use crate::plot::figure::{Figure, Shape, Stroke};
use crate::plot::font;
use crate::plot::panel::{
    BAR_SPACE, LEVEL_BAR_SPACE, Panel, TITLE_SIZE, draw_clipped_color_bar, draw_level_color_bar,
};

/// The part of one cell in a flat picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Patch {
    /// The contours of its area, filled by the even-odd rule (L).
    pub contours: Vec<Vec<Point2<f64>>>,
    /// Its outline, where that is not all contours.
    pub rims: Option<Vec<[Point2<f64>; 2]>>,
    /// The value that colors it.
    pub value: f64,
    /// The site, if it is to be shown as a dot.
    pub site: Option<Point2<f64>>,
}

/// The longer side of the picture proper, in figure units.
const LONGER_SIDE: f64 = 600.0;
/// The least of the shorter side: enough for the ticks of an axis.
const LEAST_SIDE: f64 = 48.0;
/// Up to this height the color bar lies below the picture, where its name has room.
const LOW: f64 = 230.0;
/// Left of the picture, above, below and right of it: the axes' labels, the title.
const LEFT: f64 = 66.0;
const ABOVE: f64 = 38.0;
const BELOW: f64 = 50.0;
const RIGHT: f64 = 20.0;
/// From the picture to the color bar.
const BAR_GAP: f64 = 18.0;
/// So far from each other are ticks.
const TICK_STEP: f64 = 60.0;

/// Outlines and dots as shares of the mean cell's diameter, within limits in figure units.
const OUTLINE: (f64, [f64; 2]) = (0.02, [0.08, 0.9]);
const DOT: (f64, [f64; 2]) = (0.06, [0.3, 2.6]);

/// The lines that close the gaps between parts of a patch.
const SEAM: f64 = 0.4;

/// The luma above which dots are dark.
const BRIGHT: f64 = 110.0;

/// The picture of all `patches`, with axes of these names.
#[must_use]
pub(crate) fn picture(
    patches: &[Patch],
    scale: &ColorScale,
    title: &str,
    names: &[String; 2],
) -> Figure {
    let panel = panel(patches);
    let [min, max] = panel.frame;
    let size = max - min;
    let is_low = size.y < LOW;
    let (right, below) = if is_low {
        (RIGHT, BELOW + LEVEL_BAR_SPACE)
    } else {
        (BAR_GAP + BAR_SPACE, BELOW)
    };
    let title_end = min.x + 0.5 * size.x + 0.5 * font::width(title, TITLE_SIZE);
    let width = (max.x + right).max(title_end + RIGHT);
    let mut figure = Figure::new(width, max.y + below);
    draw_patches(&mut figure, &panel, patches, scale);
    panel.draw_ticks(&mut figure);
    panel.draw_frame(&mut figure, title, &names[0], &names[1]);
    let clipped = scale.clipped(patches.iter().map(|patch| patch.value));
    if is_low {
        let corner = Point2::new(min.x, max.y + BELOW);
        draw_level_color_bar(&mut figure, corner, size.x, (scale, clipped));
    } else {
        let corner = Point2::new(max.x + BAR_GAP, min.y);
        draw_clipped_color_bar(&mut figure, corner, size.y, (scale, clipped));
    }
    figure
}

fn draw_patches(figure: &mut Figure, panel: &Panel, patches: &[Patch], scale: &ColorScale) {
    let size = panel.frame[1] - panel.frame[0];
    let diameter = (size.x * size.y / patches.len().max(1) as f64).sqrt();
    let sized = |(share, [least, most]): (f64, [f64; 2])| (share * diameter).clamp(least, most);
    let outline = Stroke::solid(Color::INK, sized(OUTLINE));
    let place = |point: &Point2<f64>| panel.place(point.x, point.y);
    for patch in patches {
        let contour = |contour: &Vec<Point2<f64>>| contour.iter().map(place).collect();
        let fill = scale.color(patch.value);
        figure.shapes.push(Shape::Path {
            contours: patch.contours.iter().map(contour).collect(),
            closed: true,
            fill: Some(fill),
            // Between parts of one patch no line shall be seen, nor a gap.
            stroke: Some(match patch.rims {
                Some(_) => Stroke::solid(fill, SEAM),
                None => outline,
            }),
        });
    }
    for [start, end] in patches.iter().flat_map(|patch| patch.rims.iter().flatten()) {
        figure.line(place(start), place(end), outline);
    }
    let dots = patches.iter();
    for (site, value) in dots.filter_map(|patch| Some((patch.site?, patch.value))) {
        let bright = scale.color(value).luma() > BRIGHT;
        figure.shapes.push(Shape::Disc {
            center: place(&site),
            radius: sized(DOT),
            fill: if bright { Color::INK } else { Color::WHITE },
        });
    }
}

/// The frame around all patches, with axes of one scale.
fn panel(patches: &[Patch]) -> Panel {
    let corners = patches
        .iter()
        .flat_map(|patch| patch.contours.iter().flatten());
    let mut bounds = Bounds::of(corners);
    if patches.is_empty() || !bounds.extent().iter().all(|length| length.is_finite()) {
        bounds = Bounds::from_corners([0.0; 2], [1.0; 2]);
    }
    let (extent, middle) = (bounds.extent(), bounds.center());
    // A point, which is no cell of any domain, gets a frame of its coordinates' last digits.
    let least = 1e-9 * middle.coords.amax().max(f64::MIN_POSITIVE.sqrt());
    let factor = LONGER_SIDE / extent.max().max(least);
    let size = extent.map(|length| (factor * length).max(LEAST_SIDE));
    let corner = Point2::new(LEFT, ABOVE);
    let axis = |k: usize| {
        let half = 0.5 * size[k] / factor;
        Axis::within_about(middle[k] - half, middle[k] + half, size[k] / TICK_STEP)
    };
    Panel {
        frame: [corner, corner + size],
        x: axis(0),
        y: axis(1),
    }
}

/// A plane with the right and the upward direction of its picture, viewed against its normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneCut {
    plane: HalfSpace,
    right: Vector3<f64>,
    up: Vector3<f64>,
}

impl PlaneCut {
    /// The cut along the border of `plane`, viewed against its normal. Up is the direction
    /// nearest to +z; for a horizontal plane it is +y and right is +x.
    ///
    /// A plane without a normal cuts nothing.
    #[must_use]
    pub(crate) fn new(plane: HalfSpace) -> Self {
        let normal = plane.normal;
        let horizontal = normal.x.hypot(normal.y) < 1e-9 * normal.z.abs();
        let upward = if horizontal {
            Vector3::y()
        } else {
            Vector3::z()
        };
        Self::with_up(plane, upward)
    }

    /// The cut along the border of `plane`, viewed against its normal; `upward`, not along the normal, is
    /// upward.
    #[must_use]
    pub(crate) fn with_up(plane: HalfSpace, upward: Vector3<f64>) -> Self {
        let plane = plane.normalized();
        let normal = plane.normal;
        let up = upward - upward.dot(&normal) * normal;
        let up = up.try_normalize(0.0).unwrap_or(upward);
        Self {
            plane,
            right: up.cross(&normal),
            up,
        }
    }

    /// The horizontal cut at height `z`, viewed from above.
    #[must_use]
    pub(crate) fn horizontal(z: f64) -> Self {
        Self::new(HalfSpace {
            normal: Vector3::z(),
            offset: z,
        })
    }

    /// A point's place in the picture, projected along the normal.
    #[must_use]
    pub(crate) fn flat(&self, point: &Point3<f64>) -> Point2<f64> {
        Point2::new(self.right.dot(&point.coords), self.up.dot(&point.coords))
    }

    /// The point of the plane at a place in the picture.
    #[must_use]
    pub(crate) fn lifted(&self, place: &Point2<f64>) -> Point3<f64> {
        let depth = self.plane.normal * self.plane.offset;
        Point3::from(self.right * place.x + self.up * place.y + depth)
    }

    /// The names of the directions to the right and upward: a coordinate's, or its vector.
    #[must_use]
    pub(crate) fn axis_names(&self) -> [String; 2] {
        [self.right, self.up].map(|direction| {
            let is_axis = |axis: &usize| direction[*axis] > 1.0 - 1e-12;
            match (0..3).find(is_axis) {
                Some(axis) => ["x", "y", "z"][axis].to_owned(),
                None => {
                    let [x, y, z] = <[f64; 3]>::from(direction);
                    format!("along ({x:.3}, {y:.3}, {z:.3})")
                }
            }
        })
    }

    /// The section of a cell by the plane; `None` where they do not meet.
    #[must_use]
    pub(crate) fn patch(&self, shell: &Shell, value: f64) -> Option<Patch> {
        let flat = |point: &Point3<f64>| self.flat(point);
        let contours: Vec<Vec<Point2<f64>>> = section(shell, &self.plane)
            .iter()
            .map(|contour| contour.iter().map(flat).collect())
            .collect();
        (!contours.is_empty()).then_some(Patch {
            contours,
            rims: None,
            value,
            site: None,
        })
    }
}
