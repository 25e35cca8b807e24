//! Which edges of a shell are worth a line.
//!
//! A cell's part of a solid's surface consists of the surface's triangles, and a facet with a hole
//! may be one loop that runs along a bridge twice. Lines between such parts of one wall would hide
//! the cells. So an edge gets a line where the surface bends, and where it turns away from the
//! viewer.

use nalgebra::{Point3, Vector3};

use crate::geometry::shell::Shell;
use crate::plot::camera::TOWARD;

/// The cosine below which two facets meet in a crease: 25°, more than a well-made surface bends
/// between its triangles, less than a corner that anyone would cut.
const CREASE: f64 = 0.9;

/// A side of a facet: the edge's lower and higher vertex, the facet, the side's place.
type Side = ([u32; 2], u32, usize);

/// For every corner of every facet, one facet after the other, whether the edge from it to the next
/// is a crease.
pub(crate) fn creases(shell: &Shell) -> Vec<bool> {
    let mut normals: Vec<Vector3<f64>> = Vec::with_capacity(shell.facet_count());
    let mut sides: Vec<Side> = Vec::new();
    for (facet, corners) in (0..).zip(shell.facets()) {
        normals.push(normal(corners, shell.vertices()));
        for (k, &from) in corners.iter().enumerate() {
            let to = corners[(k + 1) % corners.len()];
            sides.push(([from.min(to), from.max(to)], facet, sides.len()));
        }
    }
    let mut creases = vec![true; sides.len()];
    sides.sort_unstable();
    for edge in sides.chunk_by(|one, other| one.0 == other.0) {
        let bends = |one: &Side| edge.iter().any(|other| bend(&normals, one.1, other.1));
        let is_crease = edge.len() < 2 || edge.iter().any(bends);
        for &(_, _, place) in edge {
            creases[place] = is_crease;
        }
    }
    creases
}

fn bend(normals: &[Vector3<f64>], one: u32, other: u32) -> bool {
    let [one, other] = [one, other].map(|facet| normals[facet as usize]);
    let faces = |normal: &Vector3<f64>| normal.dot(&TOWARD) > 0.0;
    one.dot(&other) < CREASE || faces(&one) != faces(&other)
}

/// The unit normal by Newell's sum; zero for a facet without area.
fn normal(corners: &[u32], vertices: &[Point3<f64>]) -> Vector3<f64> {
    let place = |corner: &u32| vertices[*corner as usize];
    let Some(anchor) = corners.first().map(place) else {
        return Vector3::zeros();
    };
    let pairs = corners.iter().zip(corners.iter().skip(1));
    let sum: Vector3<f64> = pairs
        .map(|(a, b)| (place(a) - anchor).cross(&(place(b) - anchor)))
        .sum();
    sum.try_normalize(0.0).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A prism over a square whose top is cut in two along a diagonal, the middle raised.
    fn creases_of_top(raised: f64) -> usize {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut vertices: Vec<Point3<f64>> = square
            .iter()
            .map(|[x, y]| Point3::new(*x, *y, 0.0))
            .collect();
        let lift = |k: usize| if k.is_multiple_of(2) { raised } else { 0.0 };
        let top = square.iter().enumerate();
        vertices.extend(top.map(|(k, [x, y])| Point3::new(*x, *y, 1.0 + lift(k))));
        let facets: Vec<Vec<u32>> = vec![
            vec![0, 3, 2, 1],
            vec![4, 5, 6],
            vec![4, 6, 7],
            vec![0, 1, 5, 4],
            vec![1, 2, 6, 5],
            vec![2, 3, 7, 6],
            vec![3, 0, 4, 7],
        ];
        let shell = Shell::new(&vertices, facets).expect("corners are there");
        creases(&shell).into_iter().filter(|&is| is).count()
    }

    #[test]
    fn a_wall_of_two_triangles_has_no_line_between_them() {
        assert_eq!(creases_of_top(0.0), 24);
        assert_eq!(creases_of_top(0.6), 26);
    }
}
