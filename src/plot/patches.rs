//! Flat pictures of cells: polygons colored by a value, with thin outlines and a color bar.
//!
//! The cells of a diagram in the plane, or the polygons in which a plane cuts those in space
//! ([`PlaneCut`]).

use nalgebra::{Point2, Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::section::section;
use crate::geometry::shell::Shell;
use crate::plot::color::{Color, ColorScale};
use crate::plot::figure::{Anchor, Figure, Shape, Stroke};
use crate::plot::panel::{BAR_SPACE, TITLE_SIZE, draw_color_bar};

/// The part of one cell in a flat picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Patch {
    /// The contours of its area, filled by the even-odd rule (L).
    pub contours: Vec<Vec<Point2<f64>>>,
    /// The value that colors it.
    pub value: f64,
    /// The site, if it is to be shown as a dot.
    pub site: Option<Point2<f64>>,
}

/// The longer side of the picture proper, in figure units.
const LONGER_SIDE: f64 = 600.0;
/// The least of the shorter side: flat domains leave space for the color bar's name.
const LEAST_SIDE: f64 = 160.0;
const MARGIN: f64 = 20.0;
const TITLE_SPACE: f64 = 26.0;
/// From the picture to the color bar.
const BAR_GAP: f64 = 18.0;

/// Outlines and dots as shares of the mean cell's diameter, within limits in figure units.
const OUTLINE: (f64, [f64; 2]) = (0.02, [0.08, 0.9]);
const DOT: (f64, [f64; 2]) = (0.06, [0.3, 2.6]);

/// The luma above which dots are dark.
const BRIGHT: f64 = 110.0;

/// The picture of all `patches`.
#[must_use]
pub(crate) fn picture(patches: &[Patch], scale: &ColorScale, title: &str) -> Figure {
    let frame = Frame::around(patches);
    let mut figure = Figure::new(
        frame.size[0] + 2.0 * MARGIN + BAR_GAP + BAR_SPACE,
        frame.size[1] + 2.0 * MARGIN + TITLE_SPACE,
    );
    let diameter = (frame.size[0] * frame.size[1] / patches.len().max(1) as f64).sqrt();
    let sized = |(share, [least, most]): (f64, [f64; 2])| (share * diameter).clamp(least, most);
    let outline = Stroke::solid(Color::INK, sized(OUTLINE));
    for patch in patches {
        let place = |contour: &Vec<_>| contour.iter().map(|point| frame.place(point)).collect();
        figure.shapes.push(Shape::Path {
            contours: patch.contours.iter().map(place).collect(),
            closed: true,
            fill: Some(scale.color(patch.value)),
            stroke: Some(outline),
        });
    }
    for (site, value) in patches
        .iter()
        .filter_map(|patch| Some((patch.site?, patch.value)))
    {
        let bright = scale.color(value).luma() > BRIGHT;
        figure.shapes.push(Shape::Disc {
            center: frame.place(&site),
            radius: sized(DOT),
            fill: if bright { Color::INK } else { Color::WHITE },
        });
    }
    let above = Point2::new(MARGIN + 0.5 * frame.size[0], MARGIN + 0.8 * TITLE_SIZE);
    figure.text(above, title, TITLE_SIZE, Anchor::Middle);
    let corner = Point2::new(MARGIN + frame.size[0] + BAR_GAP, MARGIN + TITLE_SPACE);
    draw_color_bar(&mut figure, corner, frame.size[1], scale);
    figure
}

/// The map from lengths of the domain, y upward, to the figure's, y downward.
struct Frame {
    middle: Point2<f64>,
    factor: f64,
    size: [f64; 2],
}

impl Frame {
    fn around(patches: &[Patch]) -> Self {
        let corners = patches
            .iter()
            .flat_map(|patch| patch.contours.iter().flatten());
        let bounds = Bounds::of(corners);
        let extent = bounds.extent();
        if patches.is_empty() || !extent.iter().all(|length| length.is_finite()) {
            return Self {
                middle: Point2::origin(),
                factor: 1.0,
                size: [LONGER_SIDE; 2],
            };
        }
        let factor = LONGER_SIDE / extent.max().max(f64::MIN_POSITIVE);
        Self {
            middle: bounds.center(),
            factor,
            size: [extent.x, extent.y].map(|length| (factor * length).max(LEAST_SIDE)),
        }
    }

    fn place(&self, point: &Point2<f64>) -> Point2<f64> {
        let arm = self.factor * (point - self.middle);
        Point2::new(
            MARGIN + 0.5 * self.size[0] + arm.x,
            MARGIN + TITLE_SPACE + 0.5 * self.size[1] - arm.y,
        )
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
            let is_opposite = |axis: &usize| direction[*axis] < 1e-12 - 1.0;
            match ((0..3).find(is_axis), (0..3).find(is_opposite)) {
                (Some(axis), _) => ["x", "y", "z"][axis].to_owned(),
                (None, Some(axis)) => ["−x", "−y", "−z"][axis].to_owned(),
                (None, None) => {
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
            value,
            site: None,
        })
    }
}
