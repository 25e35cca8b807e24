//! Bounds of a polynomial in a box, by its Bernstein form.
//!
//! Over the unit cube Σ a_{ijk} x^i y^j z^k = Σ b_{ijk} B_i(x) B_j(y) B_k(z) with Bernstein's
//! polynomials, which are positive and sum to one: the value lies between the least and the
//! greatest b, everywhere. The coefficients at the corners are the values there. De Casteljau's
//! averages give those over the two halves of the box; bounds close in with the square of the
//! box's size.

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::integrals::polynomial::Polynomial;

/// A polynomial over a box.
#[derive(Clone, Debug)]
pub struct Bernstein {
    bounds: Bounds<3>,
    /// Per axis the degree and one more.
    counts: [usize; 3],
    /// In the order of i, j, k, the last fastest.
    coefficients: Vec<f64>,
}

impl Bernstein {
    /// `polynomial` over `bounds`.
    #[must_use]
    pub fn new(polynomial: &Polynomial, bounds: &Bounds<3>) -> Self {
        let shifted = polynomial.relative_to(&bounds.min);
        let extent = bounds.extent();
        let degree = |axis: usize| shifted.terms().map(|(powers, _)| powers[axis]).max();
        let counts = [0, 1, 2].map_each(|axis| degree(axis).unwrap_or(0) as usize + 1);
        let mut coefficients = vec![0.0; counts.iter().product()];
        for (powers, value) in shifted.terms() {
            let place = powers.iter().zip(&counts);
            let place = place.fold(0, |place, (&power, count)| place * count + power as usize);
            let [x, y, z] = [0, 1, 2].map_each(|axis| extent[axis].powi(powers[axis] as i32));
            coefficients[place] = value * (x * y * z);
        }
        let mut bernstein = Self {
            bounds: *bounds,
            counts,
            coefficients,
        };
        for axis in 0..3 {
            bernstein.along(axis, from_powers);
        }
        bernstein
    }

    /// The box.
    #[must_use]
    pub fn bounds(&self) -> &Bounds<3> {
        &self.bounds
    }

    /// A lower and an upper bound of the values in the box.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        let all = self.coefficients.iter();
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| {
            [low.min(value), high.max(value)]
        })
    }

    /// The box's corners and the values there.
    pub fn corners(&self) -> impl Iterator<Item = (Point3<f64>, f64)> + '_ {
        let Bounds { min, max } = self.bounds;
        (0..8).map(move |corner: usize| {
            let is_far = [0, 1, 2].map_each(|axis| corner >> axis & 1 == 1);
            let place = (0..3).fold(0, |place, axis| {
                let last = self.counts[axis] - 1;
                place * self.counts[axis] + if is_far[axis] { last } else { 0 }
            });
            let point = [0, 1, 2].map_each(|axis| (if is_far[axis] { max } else { min })[axis]);
            (Point3::from(point), self.coefficients[place])
        })
    }

    /// The axis along which the coefficients change most.
    #[must_use]
    pub fn steepest_axis(&self) -> usize {
        let rise = |axis: usize| {
            let step = self.counts[axis + 1..].iter().product::<usize>();
            let count = self.counts[axis];
            let starts = (0..self.coefficients.len()).filter(|place| place / step % count == 0);
            starts.fold(0.0, |most: f64, start| {
                let values = (0..count).map(|k| self.coefficients[start + k * step]);
                let [low, high] = values
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                        [low.min(value), high.max(value)]
                    });
                most.max(high - low)
            })
        };
        let rises = Vector3::from([0, 1, 2].map_each(rise));
        rises.imax()
    }

    /// The same polynomial over the lower and the upper half of the box along `axis`.
    #[must_use]
    pub fn halves(&self, axis: usize) -> [Self; 2] {
        let middle = self.bounds.center()[axis];
        let mut halves = [self.clone(), self.clone()];
        halves[0].bounds.max[axis] = middle;
        halves[1].bounds.min[axis] = middle;
        halves[0].along(axis, lower_half);
        halves[1].along(axis, |line| {
            line.reverse();
            lower_half(line);
            line.reverse();
        });
        halves
    }

    /// Changes every line of coefficients along `axis`.
    fn along(&mut self, axis: usize, change: impl Fn(&mut [f64])) {
        let step = self.counts[axis + 1..].iter().product::<usize>();
        let count = self.counts[axis];
        let mut line = vec![0.0; count];
        for start in 0..self.coefficients.len() {
            if start / step % count != 0 {
                continue;
            }
            for (k, value) in line.iter_mut().enumerate() {
                *value = self.coefficients[start + k * step];
            }
            change(&mut line);
            for (k, value) in line.iter().enumerate() {
                self.coefficients[start + k * step] = *value;
            }
        }
    }
}

/// From coefficients of the powers 1, t, … tⁿ to b_i = Σ_{k≤i} (i over k) / (n over k) a_k.
fn from_powers(line: &mut [f64]) {
    let degree = line.len() - 1;
    let powers = line.to_vec();
    for (i, value) in line.iter_mut().enumerate() {
        let mut ratio = 1.0;
        *value = 0.0;
        for (k, power) in powers.iter().enumerate().take(i + 1) {
            *value += ratio * power;
            if k < degree {
                ratio *= (i - k) as f64 / (degree - k) as f64;
            }
        }
    }
}

/// De Casteljau at the middle: the coefficients over the first half.
fn lower_half(line: &mut [f64]) {
    for round in 1..line.len() {
        for k in (round..line.len()).rev() {
            line[k] = 0.5 * (line[k - 1] + line[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block() -> Bounds<3> {
        Bounds {
            min: Point3::new(-1.0, 0.5, 2.0),
            max: Point3::new(2.0, 0.75, 4.0),
        }
    }

    #[test]
    fn corners_have_the_values_there_in_every_part() {
        let polynomial: Polynomial = "1 + x^3*y - 2*z^2 + x*y*z".parse().expect("a polynomial");
        let whole = Bernstein::new(&polynomial, &block());
        let mut parts = vec![whole];
        for axis in [0, 2, 1, 0] {
            parts = parts.iter().flat_map(|part| part.halves(axis)).collect();
        }
        assert_eq!(parts.len(), 16);
        for part in &parts {
            let [low, high] = part.range();
            for (corner, value) in part.corners() {
                assert!((value - polynomial.at(&corner)).abs() < 1e-12 * 40.0);
                assert!(low <= value && value <= high);
            }
            let middle = polynomial.at(&part.bounds().center());
            assert!(low <= middle && middle <= high);
        }
    }

    #[test]
    fn bounds_close_in_on_the_values() {
        let polynomial: Polynomial = "(x - 0.3)^2".parse().expect("a polynomial");
        let mut part = Bernstein::new(&polynomial, &block());
        assert_eq!(part.steepest_axis(), 0);
        let mut below = part.range()[0];
        assert!(below < -0.5);
        for _ in 0..8 {
            let [low, high] = part.halves(0);
            let is_low = low.bounds().contains(&Point3::new(0.3, 0.6, 3.0));
            part = if is_low { low } else { high };
            assert!(part.range()[0] >= below);
            below = part.range()[0];
        }
        assert!(below > -1e-3);
    }
}
