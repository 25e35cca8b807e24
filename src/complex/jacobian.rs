//! Lower bounds of the Jacobian determinant over whole elements.
//!
//! The determinant of an element's map is a polynomial; its coefficients in Bernstein's basis bound it from
//! below, and it is positive everywhere where they are. Hexahedra: degree 2 in each of three
//! parameters, 27 coefficients; prisms: degree 1 over the triangle, 2 along the axis, 9 coefficients;
//! pyramids: the determinant over (1 − w)² is bilinear in the base's parameters, so its least value is at a
//! corner. Source: Johnen, Remacle & Geuzaine, *Geometrical validity of curvilinear finite elements*, 2013.

use nalgebra::{Point3, Vector3};

use crate::complex::element::CellElement;

/// The least coefficient of an element's Jacobian determinant (L³): six times the volume for a
/// tetrahedron, the volume for a box; NaN for polyhedra.
#[must_use]
pub(crate) fn least_jacobian(points: &[Point3<f64>], element: &CellElement) -> f64 {
    let at = |point: u32| points[point as usize];
    match element {
        CellElement::Tetrahedron(corners) => tetrahedron(corners.map(at)),
        CellElement::Pyramid(corners) => pyramid(corners.map(at)),
        CellElement::Prism(corners) => prism(corners.map(at)),
        CellElement::Hexahedron(corners) => hexahedron(corners.map(at)),
        CellElement::Polyhedron => f64::NAN,
    }
}

fn determinant(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> f64 {
    a.cross(b).dot(c)
}

fn tetrahedron([a, b, c, d]: [Point3<f64>; 4]) -> f64 {
    determinant(&(b - a), &(c - a), &(d - a))
}

fn pyramid([a, b, c, d, apex]: [Point3<f64>; 5]) -> f64 {
    let corners = [(a, b, d), (b, c, a), (c, d, b), (d, a, c)];
    let of = |(here, next, before)| tetrahedron([here, next, before, apex]);
    corners.map(of).into_iter().fold(f64::INFINITY, f64::min)
}

fn prism(corners: [Point3<f64>; 6]) -> f64 {
    let [bottom, top] =
        [[0, 1, 2], [3, 4, 5]].map(|base| base.map(|corner: usize| corners[corner]));
    let along = [bottom, top].map(|[a, b, c]| [b - a, c - a]);
    // Degree 2 in the axis: the mean over the ways to write an index as a sum of two.
    let pairs: [&[(usize, usize)]; 3] = [&[(0, 0)], &[(0, 1), (1, 0)], &[(1, 1)]];
    let mut least = f64::INFINITY;
    for corner in 0..3 {
        let axis = top[corner] - bottom[corner];
        for ways in pairs {
            let of = |&(one, other): &(usize, usize)| {
                determinant(&along[one][0], &along[other][1], &axis)
            };
            least = least.min(ways.iter().map(of).sum::<f64>() / ways.len() as f64);
        }
    }
    least
}

fn hexahedron(corners: [Point3<f64>; 8]) -> f64 {
    // The corner at parameters (u, v, w) of 0 or 1.
    const AT: [[[usize; 2]; 2]; 2] = [[[0, 4], [3, 7]], [[1, 5], [2, 6]]];
    let corner = |u: usize, v: usize, w: usize| corners[AT[u][v][w]];
    let bits = [(0, 0), (0, 1), (1, 0), (1, 1)];
    let (mut sums, mut counts) = ([0.0; 27], [0.0; 27]);
    for (v1, w1) in bits {
        let along_u = corner(1, v1, w1) - corner(0, v1, w1);
        for (u2, w2) in bits {
            let along_v = corner(u2, 1, w2) - corner(u2, 0, w2);
            for (u3, v3) in bits {
                let along_w = corner(u3, v3, 1) - corner(u3, v3, 0);
                let place = 9 * (u2 + u3) + 3 * (v1 + v3) + w1 + w2;
                sums[place] += determinant(&along_u, &along_v, &along_w);
                counts[place] += 1.0;
            }
        }
    }
    let means = sums.iter().zip(counts).map(|(sum, count)| sum / count);
    means.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: [[f64; 3]; 8] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [0.0, 1.0, 1.0],
    ];

    /// The Jacobian determinant of a hexahedron at parameters, from its trilinear map.
    fn sampled(corners: &[Point3<f64>; 8], place: [f64; 3]) -> f64 {
        let column = |axis: usize| -> Vector3<f64> {
            let term = |(corner, at): (&Point3<f64>, &[f64; 3])| {
                let factor = |k: usize| match (k == axis, at[k] > 0.5) {
                    (true, true) => 1.0,
                    (true, false) => -1.0,
                    (false, true) => place[k],
                    (false, false) => 1.0 - place[k],
                };
                corner.coords * (factor(0) * factor(1) * factor(2))
            };
            corners.iter().zip(&CUBE).map(term).sum()
        };
        determinant(&column(0), &column(1), &column(2))
    }

    #[test]
    fn coefficients_bound_the_determinant_from_below_and_closely() {
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for _ in 0..200 {
            let corners = CUBE.map(|place| Point3::from(place.map(|x| x + 0.7 * random())));
            let bound = hexahedron(corners);
            let grid =
                (0..=8).flat_map(|i| (0..=8).flat_map(move |j| (0..=8).map(move |k| [i, j, k])));
            let values = grid.map(|at: [i32; 3]| sampled(&corners, at.map(|k| f64::from(k) / 8.0)));
            let least = values.fold(f64::INFINITY, f64::min);
            assert!(bound <= least + 1e-12, "{bound} {least}");
            assert!(bound > least - 0.5, "{bound} {least}");
        }
        assert!((hexahedron(CUBE.map(Point3::from)) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn prisms_and_pyramids_of_a_cube_are_positive_and_turn_negative_when_inverted() {
        let points: Vec<Point3<f64>> = CUBE.map(Point3::from).into();
        let least = |element| least_jacobian(&points, &element);
        assert!((least(CellElement::Prism([0, 1, 2, 4, 5, 6])) - 1.0).abs() < 1e-15);
        assert!(least(CellElement::Prism([0, 2, 1, 4, 6, 5])) < 0.0);
        assert!(
            least(CellElement::Prism([0, 1, 2, 4, 6, 5])) < 0.0,
            "twisted"
        );
        assert!((least(CellElement::Pyramid([0, 1, 2, 3, 6])) - 1.0).abs() < 1e-15);
        assert!(least(CellElement::Pyramid([0, 3, 2, 1, 6])) < 0.0);
        assert!((least(CellElement::Tetrahedron([0, 1, 3, 4])) - 1.0).abs() < 1e-15);
    }
}
