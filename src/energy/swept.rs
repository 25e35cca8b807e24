//! The Chebyshev energy of order 1 of a solid swept by rectangles whose sides move evenly, about any center.
//!
//! At the height h along an axis the solid's section is a union of rectangles along the two other axes, and
//! ∫∫ d∞ over it is the signed sum over its corners of G(h − c_h, u, v), (u, v) the corner relative to the
//! center c:
//!
//! G(h, u, v) = ∫_0^u ∫_0^v max(|h|, |s|, |t|) ds dt, homogeneous of degree three, so 3 G = h G_h + u G_u + v G_v:
//! G_h = sgn(h u v) min(|h|, |u|) min(|h|, |v|), G_u = sgn(v) ∫_0^|v| max(|h|, |u|, t) dt, and likewise G_v.
//!
//! A corner moves along a straight line. Between the heights at which |h|, |u| and |v| change their order or
//! a sign, G is a cubic polynomial of h, its first derivatives are quadratic, and the second ones linear:
//! Simpson's rule and, for the last, the midpoint rule are exact. Corners that two rectangles share cancel.

use nalgebra::{Matrix3, Vector3};

use crate::arrays::MapEach;
use crate::minimize::problem::Evaluation;

/// The way of a section's corner from one height to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CornerPath {
    /// Where it begins and ends: (h, u, v), relative to the site (L).
    pub(crate) ends: [[f64; 3]; 2],
    /// Whether the corner is the highest or lowest of its rectangle along both axes: it counts with +1,
    /// the two others with −1.
    pub(crate) is_added: bool,
}

/// A solid made of parts that are swept along axes of their own.
#[derive(Clone, Debug, Default)]
pub(crate) struct SweptSolid {
    paths: Vec<CornerPath>,
    /// The axes of h, u and v of every part, whether h is counted downwards, and where its paths end.
    parts: Vec<([usize; 3], bool, usize)>,
}

/// Value, derivatives by the center's coordinates (h, u, v), and second derivatives hh, uu, vv, hu, hv, uv.
#[derive(Clone, Copy, Debug, Default)]
struct PathSums {
    value: f64,
    gradient: [f64; 3],
    hessian: [f64; 6],
}

/// A point of a corner's way, with the first derivatives of G.
#[derive(Clone, Copy, Debug)]
struct PathPoint {
    at: [f64; 3],
    slopes: [f64; 3],
}

impl PathPoint {
    #[inline]
    fn of(at: [f64; 3]) -> Self {
        let slopes = slopes(&at);
        Self { at, slopes }
    }

    /// G.
    #[inline]
    fn value(&self) -> f64 {
        let [h, u, v] = self.at;
        (h * self.slopes[0] + u * self.slopes[1] + v * self.slopes[2]) / 3.0
    }
}

impl SweptSolid {
    /// Becomes the empty set, keeping its memory.
    pub(crate) fn clear(&mut self) {
        self.paths.clear();
        self.parts.clear();
    }

    /// Adds a corner's path to the part that is to be finished next.
    pub(crate) fn push(&mut self, path: CornerPath) {
        self.paths.push(path);
    }

    /// Ends a part, with the axes of h, u and v and whether h is counted downwards.
    pub(crate) fn finish_part(&mut self, axes: [usize; 3], is_negative: bool) {
        self.parts.push((axes, is_negative, self.paths.len()));
    }

    /// Energy (L⁴), gradient (L³) and Hessian (L²) about `center`.
    pub(crate) fn energy(&self, center: &Vector3<f64>) -> Evaluation<3> {
        let mut total = Evaluation {
            value: 0.0,
            gradient: Vector3::zeros(),
            hessian: Matrix3::zeros(),
        };
        let mut first = 0;
        for &(axes, is_negative, end) in &self.parts {
            let sign = if is_negative { -1.0 } else { 1.0 };
            let about = [sign * center[axes[0]], center[axes[1]], center[axes[2]]];
            let mut sums = PathSums::default();
            for path in &self.paths[first..end] {
                sums.add(path, about);
            }
            first = end;
            sums.add_to(&mut total, axes, sign);
        }
        total
    }
}

impl PathSums {
    fn add(&mut self, path: &CornerPath, about: [f64; 3]) {
        let ends = (path.ends).map(|end| [0, 1, 2].map_each(|axis| end[axis] - about[axis]));
        let weight = if path.is_added { 1.0 } else { -1.0 };
        let length = weight * (ends[1][0] - ends[0][0]);
        if is_ahead(&ends) {
            return self.add_ahead(&ends, length);
        }
        let (shares, count) = turns(&ends);
        let at = |share: f64| {
            let [from, to] = &ends;
            [0, 1, 2].map_each(|axis: usize| from[axis] + (to[axis] - from[axis]) * share)
        };
        let (mut share, mut from) = (0.0, PathPoint::of(ends[0]));
        for &next in &shares[..count] {
            let to = PathPoint::of(at(next));
            self.add_interval([&from, &to], length * (next - share));
            (share, from) = (next, to);
        }
        self.add_interval([&from, &PathPoint::of(ends[1])], length * (1.0 - share));
    }

    /// Adds the integral over a way on which G = |h| u v.
    #[inline]
    fn add_ahead(&mut self, [[h, u, v], [i, w, x]]: &[[f64; 3]; 2], length: f64) {
        let length = length.copysign(length * h);
        let (half, sixth) = (0.5 * length, length / 6.0);
        let [sum_h, sum_u, sum_v] = [h + i, u + w, v + x];
        let [ahead, low, high] = [
            u * v + sum_u * sum_v + w * x,
            h * v + sum_h * sum_v + i * x,
            h * u + sum_h * sum_u + i * w,
        ];
        self.value += sixth * (h * u * v + 0.5 * (sum_h * sum_u * sum_v) + i * w * x);
        for (sum, product) in self.gradient.iter_mut().zip([ahead, low, high]) {
            *sum -= sixth * product;
        }
        for (sum, along) in self.hessian[3..].iter_mut().zip([sum_v, sum_u, sum_h]) {
            *sum += half * along;
        }
    }

    /// Adds the integral over an interval in which all are polynomials.
    #[inline]
    fn add_interval(&mut self, ends: [&PathPoint; 2], weight: f64) {
        let at = [0, 1, 2].map_each(|axis: usize| 0.5 * (ends[0].at[axis] + ends[1].at[axis]));
        let middle = PathPoint::of(at);
        let outer = weight / 6.0;
        for axis in 0..3 {
            let sum = ends[0].slopes[axis] + 4.0 * middle.slopes[axis] + ends[1].slopes[axis];
            self.gradient[axis] -= outer * sum;
        }
        self.value += outer * (ends[0].value() + 4.0 * middle.value() + ends[1].value());
        for (sum, entry) in self.hessian.iter_mut().zip(curvatures(&at)) {
            *sum += weight * entry;
        }
    }

    /// Adds them, in the axes of their part.
    fn add_to(&self, total: &mut Evaluation<3>, axes: [usize; 3], sign: f64) {
        let signs = [sign, 1.0, 1.0];
        total.value += self.value;
        for (along, (axis, sign)) in axes.into_iter().zip(signs).enumerate() {
            total.gradient[axis] += sign * self.gradient[along];
            total.hessian[(axis, axis)] += self.hessian[along];
        }
        for (entry, (i, j)) in [(3, (0, 1)), (4, (0, 2)), (5, (1, 2))] {
            let value = signs[i] * signs[j] * self.hessian[entry];
            total.hessian[(axes[i], axes[j])] += value;
            total.hessian[(axes[j], axes[i])] += value;
        }
    }
}

/// Whether |h| is the largest all along a way, and of one sign: then G = |h| u v.
#[inline]
fn is_ahead([from, to]: &[[f64; 3]; 2]) -> bool {
    let is_largest = |[h, u, v]: &[f64; 3]| u.abs() <= h.abs() && v.abs() <= h.abs();
    from[0] * to[0] > 0.0 && is_largest(from) && is_largest(to)
}

/// The shares of a way at which a coordinate changes its sign, or two of them the order of their sizes.
fn turns([from, to]: &[[f64; 3]; 2]) -> ([f64; 9], usize) {
    let functions = |[h, u, v]: &[f64; 3]| [*h, *u, *v, u - h, u + h, v - h, v + h, u - v, u + v];
    let (mut shares, mut count) = ([0.0; 9], 0);
    for (here, there) in functions(from).into_iter().zip(functions(to)) {
        if here * there < 0.0 {
            shares[count] = here / (here - there);
            count += 1;
        }
    }
    shares[..count].sort_unstable_by(f64::total_cmp);
    (shares, count)
}

/// G_h, G_u and G_v.
#[inline]
fn slopes([h, u, v]: &[f64; 3]) -> [f64; 3] {
    let [a, x, y] = [h.abs(), u.abs(), v.abs()];
    // ∫_0^y max(m, t) dt.
    let along = |m: f64, y: f64| if y <= m { m * y } else { 0.5 * (m * m + y * y) };
    // The sign of a product is the product of signs.
    [
        (a.min(x) * a.min(y)).copysign(h * u * v),
        along(a.max(x), y).copysign(*v),
        along(a.max(y), x).copysign(*u),
    ]
}

/// The second derivatives of G: hh, uu, vv, hu, hv, uv.
#[inline]
fn curvatures([h, u, v]: &[f64; 3]) -> [f64; 6] {
    let [a, x, y] = [h.abs(), u.abs(), v.abs()];
    let if_less = |one: f64, other: f64, value: f64| if one < other { value } else { 0.0 };
    let [ax, ay, xy] = [a.min(x), a.min(y), x.min(y)];
    [
        (if_less(a, x, ay) + if_less(a, y, ax)).copysign(u * v),
        if_less(a, x, xy).copysign(u * v),
        if_less(a, y, xy).copysign(u * v),
        if_less(x, a, ay).copysign(h * v),
        if_less(y, a, ax).copysign(h * u),
        a.max(x).max(y),
    ]
}
