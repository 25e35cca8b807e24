//! Integrals by quadrature, as a second opinion.

use nalgebra::Point3;

/// Five Gauss-Legendre points on [0, 1], exact to degree 9, with weights.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668_004, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// Integral over a tetrahedron by collapsed coordinates, signed as its corners turn: about a center
/// outside a piece some tetrahedra count backwards.
pub(crate) fn gauss(corners: &[Point3<f64>; 4], integrand: impl Fn(&Point3<f64>) -> f64) -> f64 {
    let [a, b, d] = [1, 2, 3].map(|k| corners[k] - corners[0]);
    let mut sum = 0.0;
    for (u, wu) in GAUSS {
        for (v, wv) in GAUSS {
            for (w, ww) in GAUSS {
                let weight = wu * wv * ww * (1.0 - u).powi(2) * (1.0 - v);
                let (second, third) = (v * (1.0 - u), w * (1.0 - u) * (1.0 - v));
                sum += weight * integrand(&(corners[0] + a * u + b * second + d * third));
            }
        }
    }
    sum * a.dot(&b.cross(&d))
}
