//! Beads of plastic and their moments.
//!
//! A bead is a line or an arc of evenly spread volume V half its height h below the nozzle's path.
//! Its cross-section is a rectangle: h vertically and w = V/(L h) across, which adds V w²/12 and
//! V h²/12. Of a line from p to q with middle c and d = q − p, ∫ y yᵀ = V (c cᵀ + d dᵀ/12); of an
//! arc, the means of its points in the frame at its middle ([`ArcMeans`]).

use nalgebra::{Matrix3, Point3, Vector3};

use crate::gcode::arc::{Arc, ArcMeans};
use crate::geometry::moments::Moments;

/// A bead wider than so many heights is a blob on a short way, whose width is not that of a bead.
const WIDEST: f64 = 16.0;

/// The nozzle's way while plastic comes out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Path {
    /// A straight line; without length, the place of a blob.
    Line {
        /// mm.
        from: Point3<f64>,
        /// mm.
        to: Point3<f64>,
    },
    /// An arc.
    Arc(Arc),
}

/// Plastic that one command deposits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bead {
    pub(crate) path: Path,
    /// mm³.
    pub(crate) volume: f64,
}

impl Path {
    /// mm.
    pub(crate) fn length(&self) -> f64 {
        match self {
            Self::Line { from, to } => (to - from).norm(),
            Self::Arc(arc) => arc.length(),
        }
    }

    /// A point in its middle (mm).
    pub(crate) fn middle(&self) -> Point3<f64> {
        match self {
            Self::Line { from, to } => from + (to - from) / 2.0,
            Self::Arc(arc) => arc.crest(),
        }
    }

    /// The point at `share` of its length (mm).
    pub(crate) fn at(&self, share: f64) -> Point3<f64> {
        match self {
            Self::Line { from, to } => from + (to - from) * share,
            Self::Arc(arc) => arc.part(share, share).crest(),
        }
    }

    /// The part between two shares of its length.
    pub(crate) fn part(&self, from: f64, to: f64) -> Self {
        match self {
            Self::Line { .. } => Self::Line {
                from: self.at(from),
                to: self.at(to),
            },
            Self::Arc(arc) => Self::Arc(arc.part(from, to)),
        }
    }

    /// The nozzle's height at its end (mm).
    pub(crate) fn last_z(&self) -> f64 {
        match self {
            Self::Line { to, .. } => to.z,
            Self::Arc(arc) => arc.z + arc.rise / 2.0,
        }
    }
}

impl Bead {
    /// Its width (mm) if its cross-section is a rectangle of `height`; 0 without length or height.
    pub(crate) fn width(&self, height: f64) -> f64 {
        let length = self.path.length();
        if height > 0.0 && length > 0.0 {
            (self.volume / (length * height)).min(WIDEST * height)
        } else {
            0.0
        }
    }

    /// The part between two shares of its length.
    pub(crate) fn part(&self, from: f64, to: f64) -> Self {
        Self {
            path: self.path.part(from, to),
            volume: self.volume * (to - from),
        }
    }

    /// The moments, of density 1, of a bead of `height`, measured from `near`.
    pub(crate) fn moments(&self, height: f64, near: &Point3<f64>) -> Moments {
        let width = self.width(height);
        let (middle, mut spread, across) = match &self.path {
            Path::Line { from, to } => line(from, to),
            Path::Arc(arc) => arc_means(arc),
        };
        spread += across * (width * width / 12.0);
        spread.m33 += height * height / 12.0;
        let mut offset = middle - near;
        offset.z -= height / 2.0;
        Moments {
            mass: self.volume,
            first: offset * self.volume,
            second: (offset * offset.transpose() + spread) * self.volume,
        }
    }
}

/// Mean position, second moments about it, and the mean of n nᵀ, n the unit vector across.
fn line(from: &Point3<f64>, to: &Point3<f64>) -> (Point3<f64>, Matrix3<f64>, Matrix3<f64>) {
    let along = to - from;
    let across = Vector3::new(-along.y, along.x, 0.0);
    let squared = across.norm_squared();
    let across = if squared > 0.0 {
        across * across.transpose() / squared
    } else {
        Matrix3::zeros()
    };
    let spread = along * along.transpose() / 12.0;
    (from + along / 2.0, spread, across)
}

/// The same of an arc, in the frame of e (outward at its middle), f (onward) and z.
fn arc_means(arc: &Arc) -> (Point3<f64>, Matrix3<f64>, Matrix3<f64>) {
    let (sine, cosine) = arc.middle.sin_cos();
    let (e, f) = (
        Vector3::new(cosine, sine, 0.0),
        Vector3::new(-sine, cosine, 0.0),
    );
    let means = ArcMeans::of(arc.sweep / 2.0);
    let (ee, ff) = (e * e.transpose(), f * f.transpose());
    let squared = arc.radius * arc.radius;
    let mut spread = ee * (squared * (means.sag_squared - means.sag * means.sag))
        + ff * (squared * means.sine_squared);
    let climb = f * (arc.radius * means.along * arc.rise);
    spread.m13 += climb.x;
    spread.m31 += climb.x;
    spread.m23 += climb.y;
    spread.m32 += climb.y;
    spread.m33 += arc.rise * arc.rise / 12.0;
    let across = ee * (1.0 - means.sine_squared) + ff * means.sine_squared;
    (arc.crest() - e * (arc.radius * means.sag), spread, across)
}
