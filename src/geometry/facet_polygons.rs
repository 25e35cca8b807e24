//! The polygons that make up a plane facet of any shape, from its directed edges.
//!
//! A facet given by directed edges may be non-convex, have holes and several parts. Its edges are
//! chained to loops, and every hole is joined to the loop around it by a bridge run in both
//! directions. Each step keeps the sum of the directed edges, so the area vector, and with it the
//! volume under a closed surface, stays exact even where rounding misleads a choice.

use crate::arrays::MapEach;
use nalgebra::{Point2, Vector3};

/// The polygons, loops of vertex numbers counter-clockwise about `normal`, that make up the facet
/// with these directed `edges`.
#[must_use]
pub(crate) fn polygons(
    edges: &[[u32; 2]],
    vertices: &[Vector3<f64>],
    normal: &Vector3<f64>,
) -> Vec<Vec<u32>> {
    let plane = PlaneProjection::new(vertices, normal);
    let (mut outer, holes): (Vec<_>, Vec<_>) = chain(edges)
        .into_iter()
        .partition(|ring| plane.area(ring) >= 0.0);
    for hole in holes {
        let around = outer.iter().position(|ring| plane.contains(ring, hole[0]));
        match around.or((!outer.is_empty()).then_some(0)) {
            Some(around) => bridge(&mut outer[around], &hole, &plane),
            None => outer.push(hole),
        }
    }
    outer
}

/// Coordinates in the facet's plane, counter-clockwise about its normal.
struct PlaneProjection<'a> {
    vertices: &'a [Vector3<f64>],
    across: Vector3<f64>,
    up: Vector3<f64>,
}

impl<'a> PlaneProjection<'a> {
    fn new(vertices: &'a [Vector3<f64>], normal: &Vector3<f64>) -> Self {
        let unit = normal.try_normalize(0.0).unwrap_or_else(Vector3::z);
        let mut least = Vector3::zeros();
        least[unit.iamin()] = 1.0;
        let across = unit.cross(&least).normalize();
        Self {
            vertices,
            up: unit.cross(&across),
            across,
        }
    }

    fn at(&self, vertex: u32) -> Point2<f64> {
        let position = &self.vertices[vertex as usize];
        Point2::new(self.across.dot(position), self.up.dot(position))
    }

    /// Twice the signed area of the triangle.
    fn turn(&self, a: u32, b: u32, c: u32) -> f64 {
        let [a, b, c] = [a, b, c].map_each(|vertex| self.at(vertex));
        (b - a).perp(&(c - a))
    }

    fn area(&self, ring: &[u32]) -> f64 {
        let fans = ring.windows(2).skip(1);
        fans.map(|pair| self.turn(ring[0], pair[0], pair[1])).sum()
    }

    fn contains(&self, ring: &[u32], vertex: u32) -> bool {
        let point = self.at(vertex);
        let mut inside = false;
        for (k, &from) in ring.iter().enumerate() {
            let (a, b) = (self.at(from), self.at(ring[(k + 1) % ring.len()]));
            if (a.y > point.y) != (b.y > point.y) {
                let x = a.x + (b.x - a.x) * (point.y - a.y) / (b.y - a.y);
                inside ^= point.x < x;
            }
        }
        inside
    }

    /// Whether the open segments cross.
    fn cross(&self, a: u32, b: u32, c: u32, d: u32) -> bool {
        self.turn(a, b, c) * self.turn(a, b, d) < 0.0
            && self.turn(c, d, a) * self.turn(c, d, b) < 0.0
    }
}

/// The closed loops that the edges form.
fn chain(edges: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut rest: Vec<[u32; 2]> = edges.to_vec();
    let mut loops = Vec::new();
    while let Some([first, mut here]) = rest.pop() {
        let mut ring = vec![first];
        while here != first {
            ring.push(here);
            match rest.iter().position(|edge| edge[0] == here) {
                Some(following) => here = rest.swap_remove(following)[1],
                None => break,
            }
        }
        if ring.len() >= 3 {
            loops.push(ring);
        }
    }
    loops
}

/// Joins a hole to the loop around it by two opposite edges between its first vertex and the
/// nearest vertex of the loop that no edge separates from it.
fn bridge(outer: &mut Vec<u32>, hole: &[u32], plane: &PlaneProjection<'_>) {
    let edges_of = |ring: &[u32]| -> Vec<[u32; 2]> {
        (0..ring.len())
            .map(|k| [ring[k], ring[(k + 1) % ring.len()]])
            .collect()
    };
    let sides = [edges_of(outer), edges_of(hole)].concat();
    let start = plane.at(hole[0]);
    let distance = |&place: &usize| (plane.at(outer[place]) - start).norm_squared();
    let mut places: Vec<usize> = (0..outer.len()).collect();
    places.sort_by(|one, other| distance(one).total_cmp(&distance(other)));
    let is_visible = |place: &&usize| {
        let clear = |side: &[u32; 2]| !plane.cross(hole[0], outer[**place], side[0], side[1]);
        sides.iter().all(clear)
    };
    let place = *places.iter().find(is_visible).unwrap_or(&places[0]);
    let back = [hole[0], outer[place]];
    outer.splice(place + 1..place + 1, hole.iter().copied().chain(back));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loop_edges(points: &[[f64; 2]], vertices: &mut Vec<Vector3<f64>>) -> Vec<[u32; 2]> {
        let first = vertices.len() as u32;
        let count = points.len() as u32;
        vertices.extend(points.iter().map(|p| Vector3::new(p[0], p[1], 0.0)));
        (0..count)
            .map(|k| [first + k, first + (k + 1) % count])
            .collect()
    }

    fn areas(polygons: &[Vec<u32>], vertices: &[Vector3<f64>]) -> Vec<f64> {
        let plane = PlaneProjection::new(vertices, &Vector3::z());
        polygons.iter().map(|ring| 0.5 * plane.area(ring)).collect()
    }

    #[test]
    fn a_square_with_two_square_holes_becomes_one_polygon_of_the_same_area() {
        let mut vertices = Vec::new();
        let outer = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]];
        let mut edges = loop_edges(&outer, &mut vertices);
        for x in [0.5, 2.5] {
            let hole = [[x, 0.5], [x, 1.5], [x + 1.0, 1.5], [x + 1.0, 0.5]];
            edges.extend(loop_edges(&hole, &mut vertices));
        }
        let polygons = polygons(&edges, &vertices, &Vector3::z());
        assert_eq!(polygons.len(), 1);
        assert_eq!(polygons[0].len(), 4 + 2 * (4 + 2));
        assert!((areas(&polygons, &vertices)[0] - 6.0).abs() < 1e-14);
    }

    #[test]
    fn parts_stay_apart() {
        let mut vertices = Vec::new();
        let mut edges = loop_edges(
            &[[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]],
            &mut vertices,
        );
        edges.extend(loop_edges(
            &[[2.0, 0.0], [3.0, 0.0], [3.0, 1.0]],
            &mut vertices,
        ));
        let polygons = polygons(&edges, &vertices, &Vector3::z());
        let mut areas = areas(&polygons, &vertices);
        areas.sort_by(f64::total_cmp);
        assert!((areas[0] - 0.2).abs() < 1e-15 && (areas[1] - 0.5).abs() < 1e-15);
    }
}
