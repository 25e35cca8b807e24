//! Triangulation of polygons.
//!
//! Convex polygons become fans from their first vertex, others are cut by ear clipping in the
//! plane of their Newell normal. The triangles keep the polygon's winding and use its vertices
//! only, so that neighbors that share an edge still do.

use nalgebra::{Point2, Point3, Vector3};

/// Appends the n − 2 triangles of the polygon with the given vertices to `triangles`. Fewer
/// than three vertices give none; crossing outlines give triangles that still close the
/// surface, with signed areas that sum to the polygon's.
pub fn triangulate(points: &[Point3<f64>], polygon: &[u32], triangles: &mut Vec<[u32; 3]>) {
    match *polygon {
        [a, b, c] => triangles.push([a, b, c]),
        [] | [_] | [_, _] => {}
        _ => cut(&flatten(points, polygon), polygon, triangles),
    }
}

fn cut(outline: &[Point2<f64>], polygon: &[u32], triangles: &mut Vec<[u32; 3]>) {
    if is_convex(outline) {
        let fan = polygon[1..]
            .windows(2)
            .map(|pair| [polygon[0], pair[0], pair[1]]);
        triangles.extend(fan);
        return;
    }
    let mut ring: Vec<usize> = (0..polygon.len()).collect();
    while ring.len() > 3 {
        let ear = find_ear(outline, &ring);
        triangles.push(around(&ring, ear).map(|corner| polygon[corner]));
        ring.remove(ear);
    }
    triangles.push([polygon[ring[0]], polygon[ring[1]], polygon[ring[2]]]);
}

/// The polygon in the coordinate plane that its Newell normal is most nearly perpendicular to,
/// counter-clockwise.
fn flatten(points: &[Point3<f64>], polygon: &[u32]) -> Vec<Point2<f64>> {
    let corner = |at: usize| points[polygon[at % polygon.len()] as usize];
    let origin = corner(0);
    let mut normal = Vector3::zeros();
    for at in 1..polygon.len() - 1 {
        normal += (corner(at) - origin).cross(&(corner(at + 1) - origin));
    }
    let axis = normal.iamax();
    let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        std::mem::swap(&mut u, &mut v);
    }
    let flat = |at| {
        let offset = corner(at) - origin;
        Point2::new(offset[u], offset[v])
    };
    (0..polygon.len()).map(flat).collect()
}

/// Whether the outline turns left everywhere and the fan from its first vertex lies inside
/// (which excludes star polygons that wind twice).
fn is_convex(outline: &[Point2<f64>]) -> bool {
    let count = outline.len();
    let left =
        |a: usize, b: usize, c: usize| turn(&outline[a], &outline[b % count], &outline[c % count]);
    (0..count).all(|at| left(at, at + 1, at + 2) >= 0.0)
        && (1..count - 1).all(|at| left(0, at, at + 1) > 0.0)
}

/// The first vertex of `ring` that can be cut off; if none can (a crossing outline), the one
/// with the greatest turn.
fn find_ear(outline: &[Point2<f64>], ring: &[usize]) -> usize {
    let turn_at = |at: usize| {
        let [a, b, c] = around(ring, at);
        turn(&outline[a], &outline[b], &outline[c])
    };
    (0..ring.len())
        .find(|&at| turn_at(at) > 0.0 && is_free(outline, ring, at))
        .or_else(|| (0..ring.len()).max_by(|&one, &other| turn_at(one).total_cmp(&turn_at(other))))
        .unwrap_or(0)
}

/// Whether no other vertex of `ring` lies in the closed triangle at `at`. A vertex that
/// coincides with a corner (a slit to a hole) is no obstacle.
fn is_free(outline: &[Point2<f64>], ring: &[usize], at: usize) -> bool {
    let [a, b, c] = around(ring, at).map(|corner| outline[corner]);
    ring.iter().map(|&corner| outline[corner]).all(|point| {
        point == a
            || point == b
            || point == c
            || turn(&a, &b, &point) < 0.0
            || turn(&b, &c, &point) < 0.0
            || turn(&c, &a, &point) < 0.0
    })
}

fn around(ring: &[usize], at: usize) -> [usize; 3] {
    let count = ring.len();
    [
        ring[(at + count - 1) % count],
        ring[at],
        ring[(at + 1) % count],
    ]
}

/// Twice the signed area of (a, b, c).
fn turn(a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>) -> f64 {
    (b - a).perp(&(c - a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::surface::SurfaceMesh;

    fn area_of(points: &[[f64; 2]]) -> (usize, f64) {
        let vertices = points
            .iter()
            .map(|p| Point3::new(p[0], p[1], 0.3 * p[0]))
            .collect();
        let polygon: Vec<u32> = (0..points.len() as u32).collect();
        let mut mesh = SurfaceMesh {
            vertices,
            triangles: vec![],
        };
        triangulate(&mesh.vertices, &polygon, &mut mesh.triangles);
        // Areas in the x-y plane, by their sign: an overlap or a fold would show.
        let flat = |c: [Point3<f64>; 3]| turn(&c[0].xy(), &c[1].xy(), &c[2].xy()) / 2.0;
        assert!(mesh.all_corners().all(|corners| flat(corners) >= 0.0));
        (mesh.triangles.len(), mesh.all_corners().map(flat).sum())
    }

    #[test]
    fn non_convex_polygons_are_covered_once() {
        let arrow = [[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]];
        assert_eq!(area_of(&arrow), (2, 4.0));
        let comb = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 3.0],
            [4.0, 3.0],
            [4.0, 1.0],
            [3.0, 1.0],
            [3.0, 3.0],
            [2.0, 3.0],
            [2.0, 1.0],
            [0.0, 1.0],
        ];
        assert_eq!(area_of(&comb), (8, 9.0));
    }

    #[test]
    fn a_slit_to_a_hole_is_no_obstacle() {
        let ring = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ];
        assert_eq!(area_of(&ring), (8, 15.0));
    }

    #[test]
    fn a_crossing_outline_ends() {
        let star: Vec<[f64; 2]> = (0..5)
            .map(|k| f64::from(k) * 0.8 * std::f64::consts::PI)
            .map(|a| [a.cos(), a.sin()])
            .collect();
        let vertices: Vec<_> = star.iter().map(|p| Point3::new(p[0], p[1], 0.0)).collect();
        let mut triangles = vec![];
        triangulate(&vertices, &[0, 1, 2, 3, 4], &mut triangles);
        assert_eq!(triangles.len(), 3);
    }
}
