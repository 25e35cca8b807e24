//! The polygons in which a plane cuts a shell, by the crossings of its edges.
//!
//! Every vertex is either above the plane or below it; one that lies on the plane counts as above.
//! So a plane through a facet, an edge or a vertex needs no special case: cells that share that
//! facet give its polygon exactly once, for the cell below. An edge with ends on different sides
//! crosses the plane in one point, a facet between its pairs of crossings, and the facets' segments
//! join to closed loops.

use nalgebra::Point3;

use crate::geometry::half_space::HalfSpace;
use crate::geometry::shell::Shell;

/// Vertices nearer to the plane than this share of the largest coordinate lie on it: neighboring
/// cells round their common vertices differently.
const ON_PLANE: f64 = 1e-12;

/// Loop points nearer than this share of the largest coordinate are one.
const SAME_POINT: f64 = 1e-13;

/// The polygons in which the border of `plane` cuts `shell`, counter-clockwise as seen from the
/// side to which the plane's normal points; holes run clockwise. Empty if they do not meet.
#[must_use]
pub(crate) fn section(shell: &Shell, plane: &HalfSpace) -> Vec<Vec<Point3<f64>>> {
    let plane = plane.normalized();
    let largest = shell
        .vertices()
        .iter()
        .fold(0.0, |far: f64, v| far.max(v.coords.amax()));
    let heights = heights(shell.vertices(), &plane, ON_PLANE * largest);
    let mut segments = Vec::new();
    for facet in shell.facets() {
        push_segments(&mut segments, facet, shell.vertices(), &heights, &plane);
    }
    let mut loops = join(segments);
    for points in &mut loops {
        remove_repeated(points, SAME_POINT * largest);
    }
    loops.retain(|points| points.len() >= 3);
    loops
}

/// The vertices' heights above the plane (L); 0 for those up to `tolerance`.
fn heights(vertices: &[Point3<f64>], plane: &HalfSpace, tolerance: f64) -> Vec<f64> {
    let snapped = |height: f64| {
        let is_on_plane = height.abs() <= tolerance;
        if is_on_plane { 0.0 } else { height }
    };
    let heights = vertices.iter().map(|vertex| plane.excess(vertex));
    heights.map(snapped).collect()
}

/// A directed piece of a loop, the inside on its left.
type LineSegment = [Point3<f64>; 2];

/// Adds the segments in which the plane cuts a facet.
fn push_segments(
    segments: &mut Vec<LineSegment>,
    facet: &[u32],
    vertices: &[Point3<f64>],
    heights: &[f64],
    plane: &HalfSpace,
) {
    let [mut rising, mut falling] = crossings(facet, vertices, heights);
    if rising.len() > 1 {
        // A facet that is not convex: along the cut the crossings of either kind alternate.
        let Some(normal) = area_normal(facet, vertices) else {
            return;
        };
        let along = plane.normal.cross(&normal);
        for crossings in [&mut rising, &mut falling] {
            crossings.sort_by(|p, q| along.dot(&p.coords).total_cmp(&along.dot(&q.coords)));
        }
    }
    let pairs = falling.into_iter().zip(rising);
    segments.extend(pairs.map(|(start, end)| [start, end]));
}

/// The points in which the facet's boundary rises above the plane, and those in which it falls.
fn crossings(facet: &[u32], vertices: &[Point3<f64>], heights: &[f64]) -> [Vec<Point3<f64>>; 2] {
    let (mut rising, mut falling) = (Vec::new(), Vec::new());
    let following = facet.iter().cycle().skip(1);
    for (&from, &to) in facet.iter().zip(following) {
        let [a, b] = [from as usize, to as usize];
        match (heights[a] >= 0.0, heights[b] >= 0.0) {
            (false, true) => rising.push(crossing(vertices, heights, a.min(b), a.max(b))),
            (true, false) => falling.push(crossing(vertices, heights, a.min(b), a.max(b))),
            _ => {}
        }
    }
    [rising, falling]
}

/// Where the edge between two vertices on different sides meets the plane; the same bits for both
/// facets at the edge, since the lower number always comes first.
fn crossing(vertices: &[Point3<f64>], heights: &[f64], a: usize, b: usize) -> Point3<f64> {
    let share = heights[a] / (heights[a] - heights[b]);
    vertices[a] + share * (vertices[b] - vertices[a])
}

fn area_normal(facet: &[u32], vertices: &[Point3<f64>]) -> Option<nalgebra::Vector3<f64>> {
    let place = |corner: &u32| vertices[*corner as usize];
    let anchor = place(facet.first()?);
    let pairs = facet.iter().zip(facet.iter().skip(1));
    Some(
        pairs
            .map(|(p, q)| (place(p) - anchor).cross(&(place(q) - anchor)))
            .sum(),
    )
}

/// Joins segments end to start; where no start lies exactly at an end, the nearest one is taken.
fn join(mut segments: Vec<LineSegment>) -> Vec<Vec<Point3<f64>>> {
    let mut loops = Vec::new();
    while let Some([first, mut end]) = segments.pop() {
        let mut points = vec![first];
        loop {
            let distance = |start: &Point3<f64>| (start - end).norm_squared();
            let distances = segments.iter().map(|[start, _]| distance(start));
            let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
            match nearest {
                Some((k, far)) if far < distance(&first) => {
                    let [start, next] = segments.swap_remove(k);
                    points.push(start);
                    end = next;
                }
                _ => break,
            }
        }
        loops.push(points);
    }
    loops
}

/// Removes points that lie within `reach` of their predecessor.
fn remove_repeated(points: &mut Vec<Point3<f64>>, reach: f64) {
    points.dedup_by(|next, last| (*next - *last).amax() <= reach);
    while points.len() > 1 && (points[0] - points[points.len() - 1]).amax() <= reach {
        points.pop();
    }
}
