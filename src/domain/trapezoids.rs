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

use crate::arrays::MapEach;
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

/// A side of the polygon as it was given.
#[derive(Clone, Copy, Debug)]
struct Side {
    lower: Point2<f64>,
    upper: Point2<f64>,
    /// Counted through all loops.
    number: usize,
}

impl Side {
    /// The side run upward, or to the right, or the other way.
    fn directed(&self, is_forward: bool) -> PolygonEdge {
        let (start, end) = match is_forward {
            true => (self.lower, self.upper),
            false => (self.upper, self.lower),
        };
        let label = self.label();
        PolygonEdge { start, end, label }
    }

    fn label(&self) -> Label {
        FacetKind::Wall(self.number as u32).label()
    }

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
            number,
        }
    };
    numbered.map(side).collect()
}

/// The heights of all corners, upward.
fn heights(loops: &[Vec<Point2<f64>>]) -> Vec<f64> {
    let mut heights: Vec<f64> = loops.iter().flatten().map(|corner| corner.y).collect();
    heights.sort_by(f64::total_cmp);
    heights.dedup();
    heights
}

/// The points that an odd number of `loops` go around, which must not cross.
pub(crate) fn trapezoids(loops: &[Vec<Point2<f64>>]) -> Trapezoids {
    let sides = sides(loops);
    let heights = heights(loops);
    let mut sweep = Sweep {
        sides: &sides,
        open: Vec::new(),
        pieces: Vec::new(),
        faces: BTreeSet::new(),
    };
    for slab in heights.windows(2) {
        let pairs = sweep.pairs(slab[0], slab[1]);
        sweep.go_on(&pairs, slab[0]);
    }
    sweep.go_on(&[], heights.last().copied().unwrap_or_default());
    let faces = sweep.faces.iter();
    Trapezoids {
        sides: faces
            .map(|(side, is_forward)| sides[*side].directed(*is_forward))
            .collect(),
        pieces: sweep.pieces,
    }
}

/// Where a side of a trapezoid begins and ends, and its label.
type LabelledSide = (Point2<f64>, Point2<f64>, Label);

/// Trapezoids in the making.
struct Sweep<'a> {
    sides: &'a [Side],
    /// The left and the right side of trapezoids that are not closed yet, and where they begin.
    open: Vec<(usize, usize, f64)>,
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

    /// Closes the trapezoids whose sides are not among `pairs`, at a height, and opens those that are new.
    fn go_on(&mut self, pairs: &[(usize, usize)], height: f64) {
        let goes_on = |(left, right, _): &(usize, usize, f64)| pairs.contains(&(*left, *right));
        let open = std::mem::take(&mut self.open).into_iter();
        let (mut kept, closed): (Vec<_>, Vec<_>) = open.partition(goes_on);
        for (left, right, from) in closed {
            self.close(left, right, [from, height]);
        }
        for &(left, right) in pairs {
            if !kept.iter().any(|(l, r, _)| (*l, *r) == (left, right)) {
                kept.push((left, right, height));
            }
        }
        self.open = kept;
    }

    /// Adds the trapezoid between two sides and two heights.
    fn close(&mut self, left: usize, right: usize, [from, to]: [f64; 2]) {
        let [l, r] = [left, right].map_each(|side| self.sides[side]);
        let mut around = self.level(l.at(from), r.at(from), true);
        around.push((r.at(from), r.at(to), r.label()));
        let top = self.level(l.at(to), r.at(to), false).into_iter().rev();
        around.extend(top.map(|(start, end, label)| (end, start, label)));
        around.push((l.at(to), l.at(from), l.label()));
        around.retain(|(start, end, _)| start != end);
        self.faces.insert((left, false));
        self.faces.insert((right, true));
        if around.len() > 2 {
            let corners = around.iter().map(|(start, ..)| *start);
            let labels = around.iter().map(|(.., label)| *label);
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
    ) -> Vec<LabelledSide> {
        let inner = FacetKind::Inner.label();
        let walls = self.sides.iter().enumerate();
        let part = |(number, side): (usize, &Side)| {
            let is_here = side.is_level() && side.lower.y.total_cmp(&left.y).is_eq();
            let (from, to) = (side.lower.x.max(left.x), side.upper.x.min(right.x));
            (is_here && from < to).then_some((from, to, number))
        };
        let mut walls: Vec<(f64, f64, usize)> = walls.filter_map(part).collect();
        walls.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut parts, mut at) = (Vec::new(), left);
        for (from, to, number) in walls {
            let [from, to] = [from, to].map_each(|x| Point2::new(x, left.y));
            self.faces.insert((number, is_bottom));
            parts.push((at, from, inner));
            parts.push((from, to, self.sides[number].label()));
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
                return Err(PlaneDomainError::Crossing {
                    first: sides[first].number,
                    second: sides[second].number,
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
        [other.lower, other.upper].map_each(|point| turn(&side.lower, &side.upper, &point))
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
    let [a, b, c] = [a, b, c].map_each(|point| Coord {
        x: point.x,
        y: point.y,
    });
    orient2d(a, b, c).signum() * f64::from(u8::from(orient2d(a, b, c).abs() > 0.0))
}
