//! Convex polygons in the square of a cone's directions, and their division by linear functions.

/// The most corners of a ring.
pub(crate) const CORNERS: usize = 16;

/// A convex polygon, counter-clockwise, whose corners have N numbers each, linear over it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ring<const N: usize> {
    count: usize,
    corners: [[f64; N]; CORNERS],
}

/// A ring divided by the sign of a linear function.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Split<const N: usize> {
    /// It is not negative on the ring.
    Positive,
    /// It is not positive on the ring.
    Negative,
    /// The parts where it is positive and negative.
    Both(Ring<N>, Ring<N>),
}

impl<const N: usize> Ring<N> {
    /// The polygon without corners.
    pub(crate) const EMPTY: Self = Self {
        count: 0,
        corners: [[0.0; N]; CORNERS],
    };

    /// The polygon of these corners, at most [`CORNERS`].
    pub(crate) fn new(corners: &[[f64; N]]) -> Self {
        let mut ring = Self::EMPTY;
        corners.iter().for_each(|corner| ring.push(*corner));
        ring
    }

    #[inline]
    fn push(&mut self, corner: [f64; N]) {
        if let Some(place) = self.corners.get_mut(self.count) {
            *place = corner;
            self.count += 1;
        }
    }

    /// The corners.
    #[inline]
    pub(crate) fn corners(&self) -> &[[f64; N]] {
        &self.corners[..self.count.min(CORNERS)]
    }

    /// The same polygon with other numbers at its corners.
    #[inline]
    pub(crate) fn map<const M: usize>(&self, of: impl Fn(&[f64; N]) -> [f64; M]) -> Ring<M> {
        let mut ring = Ring::EMPTY;
        for corner in self.corners() {
            ring.push(of(corner));
        }
        ring
    }

    /// The parts where a function with these values at corners is positive and negative.
    ///
    /// The function must be linear but for rounding; what is within it should be given as zero.
    pub(crate) fn split(&self, value: impl Fn(&[f64; N]) -> f64) -> Split<N> {
        let mut values = [0.0; CORNERS];
        let (mut least, mut greatest) = (0.0, 0.0);
        for (place, corner) in values.iter_mut().zip(self.corners()) {
            let found = value(corner);
            least = if found < least { found } else { least };
            greatest = if found > greatest { found } else { greatest };
            *place = found;
        }
        if greatest <= 0.0 {
            return Split::Negative;
        }
        if least >= 0.0 {
            return Split::Positive;
        }
        let (mut positive, mut negative) = (Self::EMPTY, Self::EMPTY);
        for (number, corner) in self.corners().iter().enumerate() {
            let next = if number + 1 == self.count {
                0
            } else {
                number + 1
            };
            let (here, there) = (values[number], values[next]);
            if here >= 0.0 {
                positive.push(*corner);
            }
            if here <= 0.0 {
                negative.push(*corner);
            }
            let ends = [corner, &self.corners[next]];
            let crossing = match (here > 0.0, there > 0.0) {
                (true, false) if there < 0.0 => between(ends, [here, there]),
                (false, true) if here < 0.0 => between([ends[1], ends[0]], [there, here]),
                _ => continue,
            };
            positive.push(crossing);
            negative.push(crossing);
        }
        Split::Both(positive, negative)
    }

    /// How far a point lies within the ring, measured from its sides; negative outside.
    pub(crate) fn depth(&self, at: [f64; 2]) -> f64 {
        let corners = self.corners();
        let next = corners.iter().cycle().skip(1);
        let depths = corners.iter().zip(next).filter_map(|(a, b)| {
            let (along, to) = ([b[0] - a[0], b[1] - a[1]], [at[0] - a[0], at[1] - a[1]]);
            let length = along[0].hypot(along[1]);
            (length > 0.0).then(|| (along[0] * to[1] - along[1] * to[0]) / length)
        });
        let least = depths.fold(f64::INFINITY, f64::min);
        if least.is_finite() {
            least
        } else {
            f64::NEG_INFINITY
        }
    }

    /// Two halves of a polygon of many corners.
    pub(crate) fn halves(&self) -> [Self; 2] {
        let (corners, middle) = (self.corners(), self.count / 2);
        let mut other = Self::new(&corners[middle..]);
        other.push(corners[0]);
        [Self::new(&corners[..=middle]), other]
    }
}

/// Where a linear function with the values `values`, the first positive and the second negative,
/// vanishes between two corners: measured from the nearer one, so that numbers of different size
/// keep their digits there.
fn between<const N: usize>(ends: [&[f64; N]; 2], values: [f64; 2]) -> [f64; N] {
    let total = values[0] - values[1];
    let shares = [values[0] / total, -values[1] / total];
    let (near, far, share) = if shares[0] < shares[1] {
        (ends[0], ends[1], shares[0])
    } else {
        (ends[1], ends[0], shares[1])
    };
    std::array::from_fn(|k| near[k] + share * (far[k] - near[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(ring: &Ring<2>) -> f64 {
        let corners = ring.corners();
        let next = corners.iter().cycle().skip(1);
        let cross = corners
            .iter()
            .zip(next)
            .map(|(a, b)| a[0] * b[1] - a[1] * b[0]);
        0.5 * cross.sum::<f64>()
    }

    #[test]
    fn parts_add_up_and_lie_on_their_sides() {
        let square = Ring::new(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]);
        for turn in 0..100 {
            let (sin, cos) = (f64::from(turn) * 0.1).sin_cos();
            let value =
                |corner: &[f64; 2]| cos * corner[0] + sin * corner[1] - 0.013 * f64::from(turn);
            match square.split(value) {
                Split::Both(one, other) => {
                    assert!((area(&one) + area(&other) - 4.0).abs() < 1e-14);
                    assert!(one.corners().iter().all(|corner| value(corner) > -1e-15));
                    assert!(other.corners().iter().all(|corner| value(corner) < 1e-15));
                }
                Split::Positive => {
                    assert!(square.corners().iter().all(|corner| value(corner) >= 0.0))
                }
                Split::Negative => {
                    assert!(square.corners().iter().all(|corner| value(corner) <= 0.0))
                }
            }
        }
    }

    #[test]
    fn corners_on_the_line_go_to_both_parts() {
        let square = Ring::new(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]);
        let Split::Both(one, other) = square.split(|corner| corner[0] - corner[1]) else {
            panic!("a diagonal divides");
        };
        assert_eq!((one.corners().len(), other.corners().len()), (3, 3));
    }
}
