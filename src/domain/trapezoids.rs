//! Polygons of any shape, with holes, parted into trapezoids with horizontal sides.
//!
//! Between two heights next to each other at which there are corners no two sides meet, so that the
//! sides that pass there have an order, and the polygon lies between the first and the second, the third
//! and the fourth, … (Chazelle & Incerpi, *Triangulation and shape-complexity*, 1984). A pair of sides
//! that bounds the polygon through several heights makes one trapezoid. All corners of trapezoids are
//! corners of the polygon or points of its sides.

use std::collections::BTreeSet;

use nalgebra::Point2;
use robust::{Coord, orient2d};

use crate::domain::facet_kind::FacetKind;
use crate::domain::planar_error::PlaneDomainError;
use crate::geometry::bounds::Bounds;
use crate::geometry::label::Label;
use crate::geometry::polygon::{ConvexPolygon, PolygonEdge};

/// A polygon in convex parts.
#[derive(Debug)]
pub(crate) struct Trapezoids {
    /// Counter-clockwise; their sides are labelled as walls or as inner borders.
    pub(crate) pieces: Vec<ConvexPolygon>,
    /// The polygon's sides, the polygon on their left.
    pub(crate) sides: Vec<PolygonEdge>,
}

/// A side of the polygon as it was given; its label counts all sides of all loops.
#[derive(Clone, Copy, Debug)]
struct Side {
    lower: Point2<f64>,
    upper: Point2<f64>,
    label: Label,
}

impl Side {
    fn is_level(&self) -> bool {
        self.lower.y >= self.upper.y
    }

    /// The side's point at a height within its own.
    fn at(&self, y: f64) -> Point2<f64> {
        if y <= self.lower.y {
            return self.lower;
        }
        if y >= self.upper.y {
            return self.upper;
        }
        let share = (y - self.lower.y) / (self.upper.y - self.lower.y);
        Point2::new(self.lower.x + share * (self.upper.x - self.lower.x), y)
    }
}

/// The sides of `loops` that have a length, by height and, where they are level, from left to right.
fn sides(loops: &[Vec<Point2<f64>>]) -> Vec<Side> {
    let ends = loops.iter().flat_map(|corners| {
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next)
    });
    let numbered = ends.enumerate().filter(|(_, (start, end))| start != end);
    let side = |(number, (start, end)): (usize, (&Point2<f64>, &Point2<f64>))| {
        let is_up = (start.y, start.x) < (end.y, end.x);
        let (lower, upper) = if is_up { (start, end) } else { (end, start) };
        Side {
            lower: *lower,
            upper: *upper,
            label: FacetKind::Wall(number as u32).label(),
        }
    };
    numbered.map(side).collect()
}

/// The points that an odd number of `loops` go around, which must not cross.
pub(crate) fn trapezoids(loops: &[Vec<Point2<f64>>]) -> Trapezoids {
    let sides = sides(loops);
    let mut heights: Vec<f64> = loops.iter().flatten().map(|corner| corner.y).collect();
    heights.sort_by(f64::total_cmp);
    heights.dedup();
    let mut sweep = Sweep {
        sides: &sides,
        pieces: Vec::new(),
        faces: BTreeSet::new(),
    };
    // The left and the right side of trapezoids, and where they begin.
    let mut open: Vec<(usize, usize, f64)> = Vec::new();
    for slab in heights.windows(2) {
        let pairs = sweep.pairs(slab[0], slab[1]);
        let goes_on = |(left, right, _): &(usize, usize, f64)| pairs.contains(&(*left, *right));
        let (mut kept, closed): (Vec<_>, Vec<_>) = open.into_iter().partition(goes_on);
        for (left, right, from) in closed {
            sweep.close(left, right, [from, slab[0]]);
        }
        for (left, right) in pairs {
            if !kept.iter().any(|(l, r, _)| (*l, *r) == (left, right)) {
                kept.push((left, right, slab[0]));
            }
        }
        open = kept;
    }
    let top = heights.last().copied().unwrap_or_default();
    for (left, right, from) in open {
        sweep.close(left, right, [from, top]);
    }
    let faces = sweep.faces;
    let directed = |(side, is_forward): (usize, bool)| {
        let Side {
            lower,
            upper,
            label,
        } = sides[side];
        let (start, end) = if is_forward {
            (lower, upper)
        } else {
            (upper, lower)
        };
        PolygonEdge { start, end, label }
    };
    Trapezoids {
        pieces: sweep.pieces,
        sides: faces.into_iter().map(directed).collect(),
    }
}

/// Trapezoids in the making.
struct Sweep<'a> {
    sides: &'a [Side],
    pieces: Vec<ConvexPolygon>,
    /// Sides with the polygon on their left when run upward, or to the right (true), or the other way.
    faces: BTreeSet<(usize, bool)>,
}

impl Sweep<'_> {
    /// The sides between which the polygon lies between two heights.
    fn pairs(&self, from: f64, to: f64) -> Vec<(usize, usize)> {
        let middle = 0.5 * (from + to);
        let passing = self.sides.iter().enumerate();
        let mut passing: Vec<(f64, usize)> = passing
            .filter(|(_, side)| !side.is_level() && side.lower.y <= from && side.upper.y >= to)
            .map(|(number, side)| (side.at(middle).x, number))
            .collect();
        passing.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let pairs = passing.chunks_exact(2);
        pairs.map(|pair| (pair[0].1, pair[1].1)).collect()
    }

    /// Adds the trapezoid between two sides and two heights.
    fn close(&mut self, left: usize, right: usize, [from, to]: [f64; 2]) {
        let [l, r] = [left, right].map(|side| self.sides[side]);
        let mut corners = Vec::new();
        let mut labels = Vec::new();
        let mut run = |start: Point2<f64>, end: Point2<f64>, label: Label| {
            if start != end {
                corners.push(start);
                labels.push(label);
            }
        };
        for (start, end, label) in self.level(l.at(from), r.at(from), true) {
            run(start, end, label);
        }
        run(r.at(from), r.at(to), r.label);
        for (start, end, label) in self.level(l.at(to), r.at(to), false).into_iter().rev() {
            run(end, start, label);
        }
        run(l.at(to), l.at(from), l.label);
        self.faces.insert((left, false));
        self.faces.insert((right, true));
        if corners.len() > 2 {
            self.pieces
                .push(ConvexPolygon::from_corners(corners, labels));
        }
    }

    /// A level side of a trapezoid from left to right, parted where level sides of the polygon begin
    /// and end. `is_bottom` says whether the trapezoid lies above it.
    fn level(
        &mut self,
        left: Point2<f64>,
        right: Point2<f64>,
        is_bottom: bool,
    ) -> Vec<(Point2<f64>, Point2<f64>, Label)> {
        let inner = FacetKind::Inner.label();
        let walls = self.sides.iter().enumerate();
        let mut walls: Vec<(f64, f64, usize)> = walls
            .filter(|(_, side)| side.is_level() && side.lower.y.total_cmp(&left.y).is_eq())
            .map(|(number, side)| (side.lower.x.max(left.x), side.upper.x.min(right.x), number))
            .filter(|(from, to, _)| from < to)
            .collect();
        walls.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut parts = Vec::new();
        let mut at = left;
        for (from, to, number) in walls {
            let [from, to] = [from, to].map(|x| Point2::new(x, left.y));
            self.faces.insert((number, is_bottom));
            parts.push((at, from, inner));
            parts.push((from, to, self.sides[number].label));
            at = to;
        }
        parts.push((at, right, inner));
        parts
    }
}

/// Refuses loops of which two sides cross, or cover each other along a length.
///
/// # Errors
/// [`PlaneDomainError::Crossing`].
pub(crate) fn refuse_crossings(loops: &[Vec<Point2<f64>>]) -> Result<(), PlaneDomainError> {
    let sides = sides(loops);
    let bounds: Vec<Bounds<2>> = sides
        .iter()
        .map(|side| Bounds::of([&side.lower, &side.upper]))
        .collect();
    for second in 1..sides.len() {
        for first in 0..second {
            if bounds[first].overlaps(&bounds[second]) && cross(&sides[first], &sides[second]) {
                let near = bounds[first].intersection(&bounds[second]).center();
                let number = |side: usize| match FacetKind::of(sides[side].label) {
                    FacetKind::Wall(number) => number as usize,
                    _ => side,
                };
                return Err(PlaneDomainError::Crossing {
                    first: number(first),
                    second: number(second),
                    x: near.x,
                    y: near.y,
                });
            }
        }
    }
    Ok(())
}

/// Whether two sides cross, or have a length in common.
fn cross(a: &Side, b: &Side) -> bool {
    let turns = |side: &Side, other: &Side| {
        [other.lower, other.upper].map(|point| turn(&side.lower, &side.upper, &point))
    };
    let (of_b, of_a) = (turns(a, b), turns(b, a));
    if of_b.iter().all(|turn| turn.abs() <= 0.0) {
        let from = a.lower.coords.dot(&(a.upper - a.lower));
        let along = |point: &Point2<f64>| point.coords.dot(&(a.upper - a.lower)) - from;
        let (low, high) = (along(&b.lower), along(&b.upper));
        return low.min(high) < along(&a.upper) && low.max(high) > 0.0;
    }
    of_b[0] * of_b[1] < 0.0 && of_a[0] * of_a[1] < 0.0
}

/// Twice the signed area of a triangle, its sign exact.
fn turn(a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>) -> f64 {
    let [a, b, c] = [a, b, c].map(|point| Coord {
        x: point.x,
        y: point.y,
    });
    orient2d(a, b, c).signum() * f64::from(u8::from(orient2d(a, b, c).abs() > 0.0))
}
