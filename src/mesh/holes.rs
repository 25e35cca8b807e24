//! Triangulation of planar polygons with holes.
//!
//! Every hole is joined to the outer loop by a bridge, a segment run along twice, to a corner that it
//! sees; what comes of it is one loop, cut like any other polygon. The triangles use the loops'
//! vertices only, so that neighbors that share an edge still do.

use nalgebra::{Point2, Point3, Vector3};

use crate::mesh::polygon::triangulate;

/// A face bounded by loops that are no polygon with holes: the number of the first hole at fault,
/// counted from one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct HoleOutside(pub(crate) usize);

/// Appends the triangles of the polygon with this outer loop and these holes, which may run either
/// way; the outer loop's winding is kept.
///
/// # Errors
/// If a hole is not inside the outer loop, or crosses it or another hole.
pub(crate) fn triangulate_with_holes(
    points: &[Point3<f64>],
    loops: &[Vec<u32>],
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), HoleOutside> {
    let [outer, holes @ ..] = loops else {
        return Ok(());
    };
    let plane = Plane::of(points, outer);
    let mut ring = Ring::of(&plane, outer, points, false);
    let holes = holes
        .iter()
        .map(|hole| Ring::of(&plane, hole, points, true));
    let mut holes: Vec<(usize, Ring)> = (1..).zip(holes).collect();
    // From the side to which the outer loop is nearest, so that bridges need not pass other holes.
    holes.sort_by(|(_, one), (_, other)| other.reach().total_cmp(&one.reach()));
    let wanted = ring.area() + holes.iter().map(|(_, hole)| hole.area()).sum::<f64>();
    while !holes.is_empty() {
        let (number, hole) = holes.remove(0);
        let bridge = bridge(&ring, &hole, &holes).ok_or(HoleOutside(number))?;
        ring.join(&hole, bridge);
    }
    let first = triangles.len();
    triangulate(points, &ring.vertices, triangles);
    let areas = triangles[first..].iter().map(|triangle| {
        let corners = triangle.map(|vertex| plane.flat(&points[vertex as usize]));
        turn(&corners[0], &corners[1], &corners[2]) / 2.0
    });
    let (mut sum, mut negative) = (0.0, 0.0);
    for area in areas {
        sum += area;
        negative += area.min(0.0);
    }
    let is_covered = (sum - wanted).abs() <= ROUNDING * wanted && -negative <= ROUNDING * wanted;
    if loops.len() > 1 && !is_covered {
        return Err(HoleOutside(1));
    }
    Ok(())
}

/// The share of a face's area that rounding may turn.
const ROUNDING: f64 = 1e-9;

/// A coordinate plane, seen from the side to which a polygon shows.
struct Plane {
    origin: Point3<f64>,
    u: usize,
    v: usize,
}

impl Plane {
    /// The plane most nearly parallel to the polygon's own.
    fn of(points: &[Point3<f64>], polygon: &[u32]) -> Self {
        let corner = |at: usize| points[polygon[at % polygon.len()] as usize];
        let origin = corner(0);
        let mut normal = Vector3::zeros();
        for at in 1..polygon.len() {
            normal += (corner(at) - origin).cross(&(corner(at + 1) - origin));
        }
        let axis = normal.iamax();
        let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
        if normal[axis] < 0.0 {
            std::mem::swap(&mut u, &mut v);
        }
        Self { origin, u, v }
    }

    fn flat(&self, point: &Point3<f64>) -> Point2<f64> {
        let offset = point - self.origin;
        Point2::new(offset[self.u], offset[self.v])
    }
}

/// A closed loop in the plane.
struct Ring {
    vertices: Vec<u32>,
    places: Vec<Point2<f64>>,
}

impl Ring {
    /// The loop, run clockwise if it is a hole.
    fn of(plane: &Plane, vertices: &[u32], points: &[Point3<f64>], is_hole: bool) -> Self {
        let mut vertices = vertices.to_vec();
        let flat = |vertex: &u32| plane.flat(&points[*vertex as usize]);
        let mut places: Vec<_> = vertices.iter().map(flat).collect();
        if is_hole && signed_area(&places) > 0.0 {
            vertices.reverse();
            places.reverse();
        }
        Self { vertices, places }
    }

    fn area(&self) -> f64 {
        signed_area(&self.places)
    }

    /// The corner farthest along the first axis.
    fn farthest(&self) -> usize {
        let count = self.places.len();
        let at = (0..count).max_by(|&a, &b| self.places[a].x.total_cmp(&self.places[b].x));
        at.unwrap_or(0)
    }

    fn reach(&self) -> f64 {
        self.places[self.farthest()].x
    }

    fn edges(&self) -> impl Iterator<Item = [Point2<f64>; 2]> + '_ {
        let next = self.places.iter().cycle().skip(1);
        self.places.iter().zip(next).map(|(a, b)| [*a, *b])
    }

    /// Whether a point lies within the angle at a corner.
    fn sees(&self, corner: usize, point: &Point2<f64>) -> bool {
        let count = self.places.len();
        let here = &self.places[corner];
        let (before, after) = (
            &self.places[(corner + count - 1) % count],
            &self.places[(corner + 1) % count],
        );
        let (left, right) = (
            turn(here, after, point) > 0.0,
            turn(before, here, point) > 0.0,
        );
        if turn(before, here, after) > 0.0 {
            left && right
        } else {
            left || right
        }
    }

    /// Joins a hole from its farthest corner to the ring's corner `at`.
    fn join(&mut self, hole: &Self, at: usize) {
        let (from, count) = (hole.farthest(), hole.vertices.len());
        let around = (0..=count).map(|step| (from + step) % count);
        let mut vertices: Vec<_> = around.clone().map(|k| hole.vertices[k]).collect();
        let mut places: Vec<_> = around.map(|k| hole.places[k]).collect();
        vertices.push(self.vertices[at]);
        places.push(self.places[at]);
        self.vertices.splice(at + 1..at + 1, vertices);
        self.places.splice(at + 1..at + 1, places);
    }
}

/// The nearest corner of the ring that a hole's farthest corner sees past all edges.
fn bridge(ring: &Ring, hole: &Ring, others: &[(usize, Ring)]) -> Option<usize> {
    let from = hole.places[hole.farthest()];
    let mut corners: Vec<usize> = (0..ring.places.len()).collect();
    let distance = |corner: usize| (ring.places[corner] - from).norm_squared();
    corners.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let is_free = |&corner: &usize| {
        let to = ring.places[corner];
        let others = others.iter().flat_map(|(_, other)| other.edges());
        let mut edges = ring.edges().chain(hole.edges()).chain(others);
        ring.sees(corner, &from) && !edges.any(|edge| blocks(&edge, &from, &to))
    };
    corners.into_iter().find(is_free)
}

/// Whether an edge meets the segment elsewhere than in a common end.
fn blocks([a, b]: &[Point2<f64>; 2], from: &Point2<f64>, to: &Point2<f64>) -> bool {
    let is_end = |point: &Point2<f64>| point == from || point == to;
    if is_end(a) || is_end(b) {
        let other = if is_end(a) { b } else { a };
        return !is_end(other) && is_between(from, other, to);
    }
    let opposite = |p: f64, q: f64| p <= 0.0 && q >= 0.0 || p >= 0.0 && q <= 0.0;
    let (at_a, at_b) = (turn(from, to, a), turn(from, to, b));
    let (at_from, at_to) = (turn(a, b, from), turn(a, b, to));
    if at_a == 0.0 && at_b == 0.0 {
        return is_between(from, a, to) || is_between(from, b, to);
    }
    opposite(at_a, at_b) && opposite(at_from, at_to)
}

/// Whether a point lies on the segment.
fn is_between(from: &Point2<f64>, point: &Point2<f64>, to: &Point2<f64>) -> bool {
    turn(from, to, point) == 0.0 && (point - from).dot(&(point - to)) <= 0.0
}

fn signed_area(places: &[Point2<f64>]) -> f64 {
    let origin = places[0];
    let corners = places.windows(2);
    corners
        .map(|edge| turn(&origin, &edge[0], &edge[1]))
        .sum::<f64>()
        / 2.0
}

/// Twice the signed area of (a, b, c).
fn turn(a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>) -> f64 {
    (b - a).perp(&(c - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> [[f64; 2]; 4] {
        [[low, low], [high, low], [high, high], [low, high]]
    }

    /// The triangles of square loops, and their area in the plane x = z.
    fn cut(loops: &[[[f64; 2]; 4]]) -> Result<(usize, f64), HoleOutside> {
        let points: Vec<_> = loops
            .iter()
            .flatten()
            .map(|&[x, y]| Point3::new(x, y, x))
            .collect();
        let numbers: Vec<Vec<u32>> = (0..loops.len() as u32)
            .map(|k| (4 * k..4 * k + 4).collect())
            .collect();
        let mut triangles = Vec::new();
        triangulate_with_holes(&points, &numbers, &mut triangles)?;
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| points[vertex as usize].xy());
            turn(&a, &b, &c) / 2.0
        };
        assert!(triangles.iter().all(|triangle| area(triangle) >= 0.0));
        Ok((triangles.len(), triangles.iter().map(area).sum()))
    }

    #[test]
    fn holes_are_left_out_whichever_way_they_run() {
        let mut backward = square(1.0, 2.0);
        backward.reverse();
        for hole in [square(1.0, 2.0), backward] {
            assert_eq!(cut(&[square(0.0, 4.0), hole]), Ok((8, 15.0)));
        }
        let row = [square(1.0, 2.0), square(3.0, 4.0), square(5.0, 6.0)];
        let [a, b, c] = row;
        assert_eq!(cut(&[square(0.0, 7.0), a, b, c]), Ok((20, 46.0)));
        let shifted = b.map(|[x, y]| [x - 2.0, y]);
        assert_eq!(cut(&[square(0.0, 7.0), shifted, a, b]), Ok((20, 46.0)));
    }

    #[test]
    fn holes_outside_or_across_are_refused() {
        assert!(cut(&[square(0.0, 4.0), square(5.0, 6.0)]).is_err());
        assert!(cut(&[square(0.0, 4.0), square(3.0, 6.0)]).is_err());
        assert!(cut(&[square(0.0, 9.0), square(1.0, 4.0), square(3.0, 6.0)]).is_err());
    }
}
