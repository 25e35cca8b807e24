//! L∞ Voronoi cells of the plane as convex parts, the lower dimension of [`crate::voronoi::linf`].
//!
//! The quarter of a cell in which the largest coordinate difference from its site is along one axis is swept
//! from the site outward. At the height h its section is the interval \[−h, h\], of which a neighbor at
//! (D, a) takes, from h = D/2 on, what lies beyond a − h if a > 0, below a + h if a < 0, and all of it for
//! a = 0. Between the heights at which an end of the interval changes its line, the quarter is a trapezoid.
//! Ties go to the smaller index, as in space.

use nalgebra::{Point2, Vector2};

use crate::arrays::MapEach;
use crate::domain::facet_kind::FacetKind;
use crate::domain::planar::PlaneDomain;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::label::Label;
use crate::geometry::polygon::{ConvexPolygon, PolygonEdge};

/// The axes h and u of the four quarters, from +x counter-clockwise.
const QUARTERS: [[[f64; 2]; 2]; 4] = [
    [[1.0, 0.0], [0.0, 1.0]],
    [[0.0, 1.0], [-1.0, 0.0]],
    [[-1.0, 0.0], [0.0, -1.0]],
    [[0.0, -1.0], [1.0, 0.0]],
];

/// What is nearer to a neighbor in one quarter.
#[derive(Clone, Copy, Debug)]
struct Front {
    /// The height from which on (L).
    start: f64,
    /// The neighbor's coordinate across (L).
    across: f64,
    label: Label,
}

/// An end of a section: the coordinate offset + slope · h (L).
#[derive(Clone, Copy, Debug, PartialEq)]
struct EndLine {
    offset: f64,
    slope: f64,
    label: Label,
}

/// A part of a quarter, with what is beyond its top: from the low end inward, and from the high end inward.
#[derive(Clone, Debug)]
struct Trapezoid {
    ends: [EndLine; 2],
    heights: [f64; 2],
    /// Up to which coordinate, from the end inward, and what is there.
    tops: [Vec<(f64, Label)>; 2],
}

/// One quarter of a cell: its walls low, high and ahead, and its fronts.
#[derive(Clone, Debug)]
struct Quarter {
    axes: [Vector2<f64>; 2],
    walls: [(f64, Label); 3],
    fronts: Vec<Front>,
}

/// A cell while neighbors are added.
#[derive(Clone, Debug)]
pub(crate) struct PlaneLinfCell {
    quarters: [Quarter; 4],
}

impl EndLine {
    fn at(&self, height: f64) -> f64 {
        self.offset + self.slope * height
    }
}

impl PlaneLinfCell {
    /// The whole of a box, relative to the site, with labels bottom, right, top, left.
    pub(crate) fn new(bounds: &Bounds<2>, labels: [Label; 4]) -> Self {
        let [bottom, right, top, left] = [-bounds.min.y, bounds.max.x, bounds.max.y, -bounds.min.x]
            .map(|distance| distance.max(0.0));
        let walls = [
            (right, labels[1]),
            (top, labels[2]),
            (left, labels[3]),
            (bottom, labels[0]),
        ];
        Self {
            quarters: std::array::from_fn(|number| Quarter {
                axes: QUARTERS[number].map_each(Vector2::from),
                // Low is clockwise, high counter-clockwise.
                walls: [
                    walls[(number + 3) % 4],
                    walls[(number + 1) % 4],
                    walls[number],
                ],
                fronts: Vec::new(),
            }),
        }
    }

    /// Adds a neighbor at an exact displacement.
    pub(crate) fn add(&mut self, displacement: &Vector2<f64>, label: Label, wins_ties: bool) {
        for quarter in &mut self.quarters {
            quarter.add(displacement, label, wins_ties);
        }
    }

    /// How far the cell reaches in the Chebyshev distance (L).
    pub(crate) fn reach(&mut self) -> f64 {
        let reaches = self.quarters.iter_mut().map(|quarter| {
            let parts = quarter.sweep();
            parts.last().map_or(0.0, |part| part.heights[1])
        });
        reaches.fold(0.0, f64::max)
    }

    /// The outline, counter-clockwise, and convex parts that fill it.
    pub(crate) fn finish(mut self) -> (ConvexPolygon, Vec<ConvexPolygon>) {
        let (mut outline, mut parts) = (Vec::new(), Vec::new());
        for quarter in &mut self.quarters {
            let trapezoids = quarter.sweep();
            let polygons = trapezoids.iter().map(|part| quarter.polygon(part));
            parts.extend(polygons.filter(|polygon| !polygon.is_empty()));
            quarter.add_outline(&trapezoids, &mut outline);
        }
        (closed(&outline), parts)
    }
}

impl Quarter {
    fn add(&mut self, displacement: &Vector2<f64>, label: Label, wins_ties: bool) {
        let [ahead, across] = self.axes.map_each(|axis| axis.dot(displacement));
        if ahead < 0.0 || ahead == 0.0 && !wins_ties {
            return;
        }
        let wall = self.walls[usize::from(across > 0.0)].0;
        let entry = (0.5 * across.abs()).max(across.abs() - wall);
        self.fronts.push(Front {
            start: (0.5 * ahead).max(entry),
            across,
            label,
        });
    }

    /// The quarter's parts, from the site outward.
    fn sweep(&mut self) -> Vec<Trapezoid> {
        self.fronts.sort_by(|a, b| a.start.total_cmp(&b.start));
        let mut sweep = QuarterSweep::new(self);
        let (mut fronts, ahead) = (self.fronts.iter().peekable(), self.walls[2].0);
        loop {
            let next = fronts.peek().map_or(f64::INFINITY, |front| front.start);
            let height = sweep.next_wall().min(next).min(ahead);
            if !sweep.advance(height) {
                break;
            }
            while let Some(front) = fronts.next_if(|front| front.start <= height) {
                sweep.cut(front);
            }
            if height >= ahead {
                sweep.cover(self.walls[2].1);
            }
            if !sweep.turn() {
                break;
            }
        }
        sweep.parts
    }

    fn place(&self, height: f64, across: f64) -> Point2<f64> {
        (self.axes[0] * height + self.axes[1] * across).into()
    }

    /// The edges of a part: its low end, its top, its high end.
    fn edges(&self, part: &Trapezoid) -> [Vec<PolygonEdge>; 3] {
        let [from, to] = part.heights;
        let [low, high] = &part.ends;
        let inner = FacetKind::Inner.label();
        let edge = |start: [f64; 2], end: [f64; 2], label: Label| PolygonEdge {
            start: self.place(start[0], start[1]),
            end: self.place(end[0], end[1]),
            label,
        };
        let mut top = Vec::new();
        let mut place = low.at(to);
        for &(end, label) in &part.tops[0] {
            top.push(edge([to, place], [to, end], label));
            place = end;
        }
        let mut beyond = Vec::new();
        let mut last = high.at(to);
        for &(end, label) in &part.tops[1] {
            beyond.push(edge([to, end], [to, last], label));
            last = end;
        }
        if place < last {
            top.push(edge([to, place], [to, last], inner));
        }
        top.extend(beyond.into_iter().rev());
        [
            vec![edge([from, low.at(from)], [to, low.at(to)], low.label)],
            top,
            vec![edge([to, high.at(to)], [from, high.at(from)], high.label)],
        ]
    }

    fn polygon(&self, part: &Trapezoid) -> ConvexPolygon {
        let [from, _] = part.heights;
        let [low, high] = part.ends.map_each(|line| self.place(from, line.at(from)));
        let bottom = PolygonEdge {
            start: high,
            end: low,
            label: FacetKind::Inner.label(),
        };
        let edges = self.edges(part).into_iter().flatten().chain([bottom]);
        let edges = edges.filter(|edge| edge.start != edge.end);
        let (corners, labels): (Vec<_>, Vec<_>) =
            edges.map(|edge| (edge.start, edge.label)).unzip();
        ConvexPolygon::from_corners(corners, labels)
    }

    /// Adds the edges at which the quarter ends, counter-clockwise about the site.
    fn add_outline(&self, parts: &[Trapezoid], outline: &mut Vec<PolygonEdge>) {
        let inner = FacetKind::Inner.label();
        let mut back = Vec::new();
        for part in parts {
            let [low, top, high] = self.edges(part);
            let middle = top.iter().position(|edge| edge.label == inner);
            let lows = middle.unwrap_or(top.len());
            let ends = |edge: &PolygonEdge| edge.label != inner && edge.start != edge.end;
            outline.extend(low.into_iter().filter(ends));
            outline.extend(top[..lows].iter().copied().filter(ends));
            let highs = top[lows..].iter().copied().chain(high);
            back.extend(highs.filter(ends).collect::<Vec<_>>().into_iter().rev());
        }
        outline.extend(back.into_iter().rev());
    }
}

/// The box around the domain, relative to a site, or one period about it, with labels bottom, right,
/// top, left: walls of the domain that lie along them, images of the site.
pub(crate) fn box_about(
    domain: &PlaneDomain,
    site: &Point2<f64>,
    index: u32,
) -> (Bounds<2>, [Label; 4]) {
    let start = domain.start(site, index);
    let bounds = start.bounds();
    let labels = std::array::from_fn(|side| {
        let (axis, end) = (
            [1, 0][side % 2],
            [bounds.min, bounds.max][usize::from((1..3).contains(&side))],
        );
        let along = |edge: &PolygonEdge| {
            let is_on = |corner: &Point2<f64>| (corner[axis] - end[axis]).abs() <= 0.0;
            is_on(&edge.start) && is_on(&edge.end) && edge.start != edge.end
        };
        let edge = start.edges().find(along);
        edge.map_or(FacetKind::Inner.label(), |edge| edge.label)
    });
    (bounds, labels)
}

/// The parts of convex polygons, given relative to `site`, that lie in the domain.
pub(crate) fn within(
    domain: &PlaneDomain,
    site: &Point2<f64>,
    polygons: Vec<ConvexPolygon>,
) -> Vec<ConvexPolygon> {
    if domain.is_periodic() || domain.is_box() {
        return polygons;
    }
    let mut kept = Vec::new();
    for piece in domain.pieces() {
        let piece = piece.translated(&-site.coords);
        let around = piece.bounds();
        for polygon in polygons.iter().filter(|it| it.bounds().overlaps(&around)) {
            let mut part = polygon.clone();
            for edge in piece.edges().filter(|edge| edge.length() > 0.0) {
                part.clip(&HalfPlane::left_of(&edge.start, &edge.end), edge.label);
            }
            kept.extend((!part.is_empty()).then_some(part));
        }
    }
    kept
}

/// The polygon of edges that follow each other, perhaps with gaps.
fn closed(edges: &[PolygonEdge]) -> ConvexPolygon {
    let (mut corners, mut labels) = (Vec::new(), Vec::new());
    for (edge, next) in edges.iter().zip(edges.iter().cycle().skip(1)) {
        corners.push(edge.start);
        labels.push(edge.label);
        if edge.end != next.start {
            corners.push(edge.end);
            labels.push(FacetKind::Inner.label());
        }
    }
    ConvexPolygon::from_corners(corners, labels)
}

/// The sweep of a quarter at its height.
struct QuarterSweep<'a> {
    quarter: &'a Quarter,
    parts: Vec<Trapezoid>,
    /// The ends of the section, and of the next one.
    ends: [EndLine; 2],
    next: [EndLine; 2],
    since: f64,
    height: f64,
    tops: [Vec<(f64, Label)>; 2],
    /// How far the section at this height has been taken from either end.
    left: [f64; 2],
    is_covered: bool,
}

impl<'a> QuarterSweep<'a> {
    fn new(quarter: &'a Quarter) -> Self {
        let side = |slope: f64| EndLine {
            offset: 0.0,
            slope,
            label: FacetKind::Inner.label(),
        };
        let ends = [side(-1.0), side(1.0)];
        Self {
            quarter,
            parts: Vec::new(),
            ends,
            next: ends,
            since: 0.0,
            height: -1.0,
            tops: Default::default(),
            left: [0.0; 2],
            is_covered: false,
        }
    }

    /// The next height at which an end that is still the quarter's side reaches a wall (L).
    fn next_wall(&self) -> f64 {
        let is_side = |end: &usize| self.ends[*end].slope * [-1.0, 1.0][*end] > 0.0;
        let walls = [0, 1].into_iter().filter(is_side);
        let walls = walls.map(|end| self.quarter.walls[end].0);
        walls.fold(f64::INFINITY, f64::min)
    }

    /// Goes to a height; says whether anything is left there.
    fn advance(&mut self, height: f64) -> bool {
        let [low, high] = &self.ends;
        let (gap, rate) = (high.offset - low.offset, high.slope - low.slope);
        let closing = if rate < -1.5 {
            0.5 * gap
        } else if rate < -0.5 {
            gap
        } else {
            f64::INFINITY
        };
        if closing <= height {
            self.finish(closing);
            return false;
        }
        self.height = height;
        self.left = [low.at(height), high.at(height)];
        for (end, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let (wall, label) = self.quarter.walls[end];
            if self.ends[end].slope * sign > 0.0 && wall <= height {
                self.next[end] = EndLine {
                    offset: sign * wall,
                    slope: 0.0,
                    label,
                };
            }
        }
        true
    }

    /// Takes what a front covers at its start, and goes on along it.
    fn cut(&mut self, front: &Front) {
        if front.across == 0.0 {
            return self.cover(front.label);
        }
        let end = usize::from(front.across > 0.0);
        let line = EndLine {
            offset: front.across,
            slope: if end == 1 { -1.0 } else { 1.0 },
            label: front.label,
        };
        let (at, [low, high]) = (line.at(self.height), self.left);
        let is_inside = if end == 1 { at < high } else { at > low };
        let old = &self.next[end];
        let is_nearer = old.slope * line.slope <= 0.0 || old.offset.abs() > line.offset.abs();
        if is_nearer {
            self.next[end] = line;
        }
        if is_inside && !self.is_covered {
            let at = at.clamp(low, high);
            self.left[end] = at;
            self.tops[end].push((at, front.label));
            self.is_covered = self.left[0] >= self.left[1];
        }
    }

    /// Takes all that is left.
    fn cover(&mut self, label: Label) {
        if !self.is_covered {
            self.tops[0].push((self.left[1], label));
            self.is_covered = true;
        }
    }

    /// Ends the part below if the next one differs; says whether there is a next one.
    fn turn(&mut self) -> bool {
        let is_open = !self.is_covered && (self.left[0] < self.left[1] || self.height <= 0.0);
        if !is_open || self.next != self.ends {
            self.finish(self.height);
            self.ends = self.next;
        }
        is_open
    }

    fn finish(&mut self, height: f64) {
        let tops = std::mem::take(&mut self.tops);
        if height > self.since {
            self.parts.push(Trapezoid {
                ends: self.ends,
                heights: [self.since, height],
                tops,
            });
        }
        self.since = height;
    }
}
