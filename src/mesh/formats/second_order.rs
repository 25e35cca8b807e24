//! Second-order elements by their corners, where all middle nodes lie on straight edges.
//!
//! Formats number the middle nodes in different orders (Gmsh and VTK exchange the last two of a
//! tetrahedron), so every middle node is asked which edge it lies on, and every edge must have one.
//! An element whose middle nodes lie on its edges, wherever there, is as straight as its corners say.

use nalgebra::Point3;

use crate::mesh::formats::error::ErrorKind;

/// How far a middle node may lie off its edge, in lengths of the edge.
const OFF_EDGE: f64 = 1e-9;

/// The edges of a tetrahedron by its corners.
pub(crate) const TET_EDGES: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// The edges of a triangle.
pub(crate) const TRIANGLE_EDGES: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 0]];

/// The edges of a quadrangle.
pub(crate) const QUAD_EDGES: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 3], [3, 0]];

/// Refuses an element with corners `nodes[..corners]` and middle nodes behind them unless each of
/// these lies on one of `edges`, every edge with its own.
pub(crate) fn check_straight(
    vertices: &[Point3<f64>],
    nodes: &[u32],
    corners: usize,
    edges: &[[usize; 2]],
) -> Result<(), ErrorKind> {
    let mut taken = vec![false; edges.len()];
    for &middle in &nodes[corners..] {
        let point = vertices[middle as usize];
        let nearest = nearest_edge(&point, vertices, nodes, edges);
        let Some((share, edge)) = nearest else { break };
        if share > OFF_EDGE {
            let place = [point.x, point.y, point.z];
            return Err(ErrorKind::Curved { place, share });
        }
        if std::mem::replace(&mut taken[edge], true) {
            let found = format!("two at {point}");
            return Err(ErrorKind::expected("one middle node on every edge", found));
        }
    }
    Ok(())
}

/// The edge of an element to which a point is nearest, after its share off it.
fn nearest_edge(
    point: &Point3<f64>,
    vertices: &[Point3<f64>],
    nodes: &[u32],
    edges: &[[usize; 2]],
) -> Option<(f64, usize)> {
    let at = |place: usize| vertices[nodes[place] as usize];
    (edges.iter().enumerate())
        .map(|(edge, &[a, b])| (share_off(point, &at(a), &at(b)), edge))
        .min_by(|one, other| one.0.total_cmp(&other.0))
}

/// The distance of a point from the segment between a and b, in lengths of the segment.
fn share_off(point: &Point3<f64>, a: &Point3<f64>, b: &Point3<f64>) -> f64 {
    let edge = b - a;
    let length = edge.norm();
    if length == 0.0 {
        return if point == a { 0.0 } else { f64::INFINITY };
    }
    let along = ((point - a).dot(&edge) / (length * length)).clamp(0.0, 1.0);
    (point - (a + edge * along)).norm() / length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn middle_nodes_lie_on_edges_in_any_order() {
        let mut vertices = vec![
            Point3::new(0.1, 0.2, 0.3),
            Point3::new(1.0, 0.0, 0.1),
            Point3::new(0.0, 2.0, 0.0),
            Point3::new(0.3, 0.4, 3.0),
        ];
        for &[a, b] in TET_EDGES {
            vertices.push(vertices[a] + (vertices[b] - vertices[a]) * 0.5);
        }
        for order in [[4, 5, 6, 7, 8, 9], [4, 5, 6, 7, 9, 8], [9, 8, 7, 6, 5, 4]] {
            let nodes = [&[0, 1, 2, 3], &order[..]].concat();
            check_straight(&vertices, &nodes, 4, TET_EDGES).unwrap();
        }
        let twice = [0, 1, 2, 3, 4, 4, 6, 7, 8, 9];
        assert!(check_straight(&vertices, &twice, 4, TET_EDGES).is_err());
        let nodes: Vec<u32> = (0..10).collect();
        let straight = vertices[6];
        for (shift, is_straight) in [(0.9e-9, true), (1.1e-9, false), (0.1, false)] {
            let [a, b] = [vertices[0], vertices[2]];
            let across = (b - a).cross(&nalgebra::Vector3::x()).normalize();
            vertices[6] = straight + across * (shift * (b - a).norm());
            let checked = check_straight(&vertices, &nodes, 4, TET_EDGES);
            assert_eq!(checked.is_ok(), is_straight, "{shift}");
        }
        // Elsewhere on the edge is straight all the same, beyond its end is not.
        for (place, is_straight) in [(0.25, true), (-0.1, false)] {
            vertices[6] = vertices[0] + (vertices[2] - vertices[0]) * place;
            let checked = check_straight(&vertices, &nodes, 4, TET_EDGES);
            assert_eq!(checked.is_ok(), is_straight, "{place}");
        }
    }
}
