//! Circular and helical arcs of G2 and G3, and the means of their points.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector2};

use crate::gcode::error::ArcFault;

/// Ends closer than this (mm) are the same point, and the arc a full circle: files round to 0.001 mm.
const SAME: f64 = 1e-6;

/// The radii at both ends may differ so much (mm), and by this share: the limits of Grbl and LinuxCNC
/// are 0.5 mm and 0.1 %.
const UNEVEN: (f64, f64) = (0.05, 1e-3);

/// Below this half sweep, means are summed as series: their closed forms cancel.
const SMALL: f64 = 0.5;

/// An arc about a vertical axis, its z changing evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arc {
    /// The axis (mm).
    pub(crate) center: Vector2<f64>,
    /// mm.
    pub(crate) radius: f64,
    /// The angle at its middle (radians from x).
    pub(crate) middle: f64,
    /// The angle passed over, counterclockwise above zero (radians).
    pub(crate) sweep: f64,
    /// z at its middle (mm).
    pub(crate) z: f64,
    /// How much z rises over its length (mm).
    pub(crate) rise: f64,
}

/// How an arc is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Round {
    /// About this center (mm).
    Center(Vector2<f64>),
    /// Of this radius (mm): the shorter arc if it is above zero, else the longer.
    Radius(f64),
}

impl Arc {
    /// From `from` to `to`, with so many full circles before it.
    pub(crate) fn between(
        from: &Point3<f64>,
        to: &Point3<f64>,
        round: Round,
        clockwise: bool,
        circles: f64,
    ) -> Result<Self, ArcFault> {
        let (start, end) = (from.coords.xy(), to.coords.xy());
        let center = match round {
            Round::Center(center) => center,
            Round::Radius(radius) => center_of(start, end, radius, clockwise)?,
        };
        let (out, back) = (start - center, end - center);
        let (first, last) = (out.norm(), back.norm());
        if (first - last).abs() > UNEVEN.0 + UNEVEN.1 * first || first.max(last) < SAME {
            return Err(ArcFault::Uneven {
                start: first,
                end: last,
            });
        }
        let beginning = out.y.atan2(out.x);
        let full = (end - start).norm() < SAME;
        let turn = if full {
            0.0
        } else {
            (back.y.atan2(back.x) - beginning).rem_euclid(TAU)
        };
        let sweep = match (clockwise, full) {
            (false, true) => TAU * circles.max(1.0),
            (true, true) => -TAU * circles.max(1.0),
            (false, false) => turn + TAU * circles,
            (true, false) => turn - TAU * (1.0 + circles),
        };
        Ok(Self {
            center,
            radius: (first + last) / 2.0,
            middle: beginning + sweep / 2.0,
            sweep,
            z: (from.z + to.z) / 2.0,
            rise: to.z - from.z,
        })
    }

    /// The part between two shares of its length, about the same axis.
    pub(crate) fn part(&self, from: f64, to: f64) -> Self {
        let off = (from + to) / 2.0 - 0.5;
        Self {
            middle: self.middle + self.sweep * off,
            sweep: self.sweep * (to - from),
            z: self.z + self.rise * off,
            rise: self.rise * (to - from),
            ..*self
        }
    }

    /// The point in its middle (mm).
    pub(crate) fn crest(&self) -> Point3<f64> {
        let (sine, cosine) = self.middle.sin_cos();
        let [x, y] = [cosine, sine].map(|part| self.radius * part);
        Point3::new(self.center.x + x, self.center.y + y, self.z)
    }

    /// Its length (mm).
    pub(crate) fn length(&self) -> f64 {
        (self.radius * self.sweep).hypot(self.rise)
    }
}

/// The center of the arc of `radius`, Marlin's rule: to the left of the way from start to end for a
/// short arc counterclockwise or a long one clockwise. A radius shorter than half the chord by
/// rounding counts as half.
fn center_of(
    start: Vector2<f64>,
    end: Vector2<f64>,
    radius: f64,
    clockwise: bool,
) -> Result<Vector2<f64>, ArcFault> {
    let chord = end - start;
    let half = chord.norm() / 2.0;
    if half < SAME {
        return Err(ArcFault::FullByRadius);
    }
    if radius.abs() < half - UNEVEN.0 - UNEVEN.1 * half {
        return Err(ArcFault::Short { radius, half });
    }
    let height = ((radius.abs() - half) * (radius.abs() + half))
        .max(0.0)
        .sqrt();
    let side = if clockwise == (radius < 0.0) {
        1.0
    } else {
        -1.0
    };
    let left = Vector2::new(-chord.y, chord.x) / (2.0 * half);
    Ok((start + end) / 2.0 + left * (side * height))
}

/// Means over an arc of half sweep η, its angle s from the middle running evenly over −η…η and
/// t = s/2η over −½…½.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ArcMeans {
    /// ⟨1 − cos s⟩
    pub(crate) sag: f64,
    /// ⟨(1 − cos s)²⟩
    pub(crate) sag_squared: f64,
    /// ⟨sin² s⟩
    pub(crate) sine_squared: f64,
    /// ⟨t sin s⟩
    pub(crate) along: f64,
}

impl ArcMeans {
    pub(crate) fn of(eta: f64) -> Self {
        if eta.abs() < SMALL {
            return Self::series(eta);
        }
        let (one, two) = (eta.sin() / eta, (2.0 * eta).sin() / (2.0 * eta));
        Self {
            sag: 1.0 - one,
            sag_squared: 1.5 - 2.0 * one + two / 2.0,
            sine_squared: (1.0 - two) / 2.0,
            along: (one - eta.cos()) / (2.0 * eta),
        }
    }

    /// ⟨s²ᵏ⟩ = η²ᵏ/(2k + 1) in the series of the cosines of s and 2s; ten terms reach rounding for
    /// η < ½.
    fn series(eta: f64) -> Self {
        let mut means = Self::default();
        // (−1)ᵏ η²ᵏ/(2k)!, from k = 1 on, and 4ᵏ.
        let (mut term, mut four) = (1.0, 1.0);
        for k in 1..=10 {
            let k = f64::from(k);
            term *= -eta * eta / ((2.0 * k - 1.0) * (2.0 * k));
            four *= 4.0;
            let mean = term / (2.0 * k + 1.0);
            means.sag -= mean;
            means.sag_squared += (four / 2.0 - 2.0) * mean;
            means.sine_squared -= four / 2.0 * mean;
            if eta != 0.0 {
                means.along -= k * mean / eta;
            }
        }
        means
    }
}
