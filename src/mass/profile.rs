//! Densities that are piecewise linear along a direction (\[BL\] section 3.2 and Fig. 5: constant,
//! ramp, constant), among them those of an affine function clamped to a range.
//!
//! The density is linear in each layer between break planes, and layers have moments from the clipped
//! triangles of the surface (`mass::layers`); tetrahedra have their boundary.

use crate::geometry::moments::Moments;
use crate::integrals::polynomial::Polynomial;
use crate::mass::layers::{Layer, layered_moments};
use nalgebra::{Point3, Vector3};

/// A density that depends on s = direction · y only: linear between breaks, constant before the
/// first and after the last (or, of a clamp without an upper end, linear there too).
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    direction: Vector3<f64>,
    breaks: Vec<[f64; 2]>,
    /// The density's growth beyond the last break.
    tail_slope: f64,
}

/// Why breaks make no profile.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// There is none.
    #[error("a profile needs at least one break `position=density`")]
    Empty,
    /// A position or density that is not finite.
    #[error("break {number} of the profile is not finite")]
    NotFinite {
        /// One-based number of the break.
        number: usize,
    },
    /// Positions must ascend.
    #[error("break {number} of the profile is at {position}, not beyond the one before it")]
    Order {
        /// One-based number of the break.
        number: usize,
        /// Its position.
        position: f64,
    },
    /// The direction is zero or not finite.
    #[error("the profile's direction has no length")]
    Direction,
}

impl Profile {
    /// From a direction (any length; s is measured along it in units of L) and breaks
    /// (s, density) with s strictly ascending.
    ///
    /// # Errors
    ///
    /// What is wrong with the direction or with which break.
    pub fn new(direction: &Vector3<f64>, breaks: Vec<[f64; 2]>) -> Result<Self, ProfileError> {
        let unit = direction
            .try_normalize(0.0)
            .filter(|unit| unit.iter().all(|value| value.is_finite()));
        let direction = unit.ok_or(ProfileError::Direction)?;
        check_breaks(&breaks)?;
        Ok(Self {
            direction,
            breaks,
            tail_slope: 0.0,
        })
    }

    /// clamp(`low`, `high`, `value` + `gradient`·y); `high` may be infinite.
    ///
    /// # Errors
    ///
    /// If the gradient is zero or not finite, or if the planes where the density becomes `low` and
    /// `high` are one in rounding.
    pub fn clamp(
        low: f64,
        high: f64,
        value: f64,
        gradient: &Vector3<f64>,
    ) -> Result<Self, ProfileError> {
        let slope = gradient.norm();
        let place = |density: f64| (density - value) / slope;
        let mut breaks = vec![[place(low), low]];
        if high < f64::INFINITY {
            breaks.push([place(high), high]);
        }
        let profile = Self::new(gradient, breaks)?;
        Ok(Self {
            tail_slope: if high < f64::INFINITY { 0.0 } else { slope },
            ..profile
        })
    }

    /// The density at s = direction · y.
    #[must_use]
    pub fn at(&self, s: f64) -> f64 {
        let after = self.breaks.partition_point(|pair| pair[0] <= s);
        match (
            after.checked_sub(1).map(|before| self.breaks[before]),
            self.breaks.get(after),
        ) {
            (Some([s0, low]), Some([s1, high])) => low + (high - low) * ((s - s0) / (s1 - s0)),
            (Some([last, value]), None) => value + self.tail_slope * (s - last),
            (None, Some(&[_, value])) => value,
            (None, None) => 0.0,
        }
    }

    /// s at a point.
    pub(crate) fn along(&self, point: &Point3<f64>) -> f64 {
        self.direction.dot(&point.coords)
    }

    /// The unit vector along which s grows.
    pub(crate) fn direction(&self) -> &Vector3<f64> {
        &self.direction
    }

    /// The breaks (s, density), s ascending.
    pub(crate) fn breaks(&self) -> &[[f64; 2]] {
        &self.breaks
    }

    /// The density's growth beyond the break before layer `number`, up to the next.
    fn slope_in(&self, number: usize) -> f64 {
        match (
            number.checked_sub(1).map(|before| self.breaks[before]),
            self.breaks.get(number),
        ) {
            (Some([from, low]), Some([to, high])) => (high - low) / (to - from),
            (Some(_), None) => self.tail_slope,
            (None, _) => 0.0,
        }
    }

    /// The density of the layer before break `number`, or after the last, as a polynomial.
    pub(crate) fn linear_in(&self, number: usize) -> Polynomial {
        let [place, value] = self.breaks[number.saturating_sub(1)];
        let slope = self.slope_in(number);
        let gradient = self.direction * slope;
        Polynomial::linear(value - slope * place, &gradient)
    }

    /// The greatest density in that layer; infinite where it grows without end.
    pub(crate) fn greatest_in(&self, number: usize) -> f64 {
        let value = |number: usize| self.breaks[number][1];
        match number {
            0 => value(0),
            _ if number < self.breaks.len() => value(number - 1).max(value(number)),
            _ if self.tail_slope > 0.0 => f64::INFINITY,
            _ => value(number - 1),
        }
    }

    /// The density at a point.
    #[must_use]
    pub fn at_point(&self, point: &Point3<f64>) -> f64 {
        self.at(self.direction.dot(&point.coords))
    }

    /// The ten moments of the solid within a closed surface, measured from `origin`.
    ///
    /// # Panics
    ///
    /// If a triangle names a vertex that is not there.
    #[must_use]
    pub fn moments(
        &self,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
        origin: &Point3<f64>,
    ) -> Moments {
        layered_moments(vertices, triangles, &self.layers(), &self.direction, origin)
    }

    /// The layers between the breaks, those beyond them included.
    fn layers(&self) -> Vec<Layer> {
        let mut layers = Vec::with_capacity(self.breaks.len() + 1);
        let [first, value] = self.breaks[0];
        layers.push(Layer {
            from: f64::NEG_INFINITY,
            to: first,
            value,
            slope: 0.0,
        });
        for pair in self.breaks.windows(2) {
            let ([from, value], [to, next]) = (pair[0], pair[1]);
            let slope = (next - value) / (to - from);
            layers.push(Layer {
                from,
                to,
                value,
                slope,
            });
        }
        let [last, value] = self.breaks[self.breaks.len() - 1];
        layers.push(Layer {
            from: last,
            to: f64::INFINITY,
            value,
            slope: self.tail_slope,
        });
        layers
    }
}

/// Refuses breaks that are none, not finite or not in order.
fn check_breaks(breaks: &[[f64; 2]]) -> Result<(), ProfileError> {
    if breaks.is_empty() {
        return Err(ProfileError::Empty);
    }
    let is_finite = |pair: &[f64; 2]| pair.iter().all(|value| value.is_finite());
    if let Some(place) = breaks.iter().position(|pair| !is_finite(pair)) {
        return Err(ProfileError::NotFinite { number: place + 1 });
    }
    if let Some(place) = breaks.windows(2).position(|pair| pair[1][0] <= pair[0][0]) {
        return Err(ProfileError::Order {
            number: place + 2,
            position: breaks[place + 1][0],
        });
    }
    Ok(())
}
