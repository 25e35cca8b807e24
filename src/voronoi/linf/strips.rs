//! The boundary of a cone's blocks: strips of moving sides, and what is covered at once.

use crate::arrays::MapEach;
use crate::voronoi::linf::block::{Column, Lasting, Line};
use crate::voronoi::linf::quadrant::Quadrant;
use crate::voronoi::linf::sweep::SweepVisitor;

/// Lines that are no farther apart than this share of their coordinates meet.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A convex polygon of a cone's boundary.
#[derive(Clone, Debug, Default)]
pub(crate) struct Strip {
    /// Who is beyond.
    pub(crate) source: u32,
    /// The coordinate that tells the plane: 0 ahead, 1 along u, 2 along v.
    pub(crate) form: u8,
    /// Whether it bounds the cone from below along that coordinate.
    pub(crate) is_low: bool,
    /// Corners (h, u, v), counter-clockwise from outside where h, u, v are right-handed.
    pub(crate) corners: Vec<[f64; 3]>,
}

/// A part of a moving side: the line across which it lies, and between which lines along the other axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MovingSide {
    along: usize,
    is_high: bool,
    at: Line,
    between: [Line; 2],
}

/// Passes the strips of a sweep to a function.
#[derive(Debug)]
pub(crate) struct StripMaker<Visit> {
    lasting: Lasting<MovingSide>,
    sides: Vec<MovingSide>,
    strip: Strip,
    visit: Visit,
}

impl<Visit: FnMut(&Strip)> StripMaker<Visit> {
    pub(crate) fn new(visit: Visit) -> Self {
        Self {
            lasting: Lasting::default(),
            sides: Vec::new(),
            strip: Strip::default(),
            visit,
        }
    }
}

/// Passes on a polygon of which corners that follow each other may be equal.
fn emit(
    strip: &mut Strip,
    visit: &mut impl FnMut(&Strip),
    (source, form, is_low): (u32, u8, bool),
    corners: [[f64; 3]; 4],
) {
    (strip.source, strip.form, strip.is_low) = (source, form, is_low);
    strip.corners.clear();
    for (number, corner) in corners.iter().enumerate() {
        let next = corners[(number + 1) % 4];
        if corner.iter().zip(next).any(|(a, b)| (a - b).abs() > 0.0) {
            strip.corners.push(*corner);
        }
    }
    if strip.corners.len() > 2 {
        visit(strip);
    }
}

impl<Visit: FnMut(&Strip)> SweepVisitor for StripMaker<Visit> {
    const WANTS_COVERED: bool = true;

    fn columns(&mut self, columns: &[Column], height: f64) {
        self.sides.clear();
        let is_open = |column: &&Column| column.closing() > height;
        let open = |number: usize| columns.get(number).filter(is_open);
        for number in 0..=columns.len() {
            let left = number.checked_sub(1).and_then(open);
            push_between(&mut self.sides, [left, open(number)]);
            if let Some(column) = open(number) {
                let ends = [(false, column.v[0]), (true, column.v[1])];
                (self.sides).extend(
                    ends.map_each(|(is_high, at)| MovingSide::along_v(is_high, at, column)),
                );
            }
        }
        let Self { strip, visit, .. } = self;
        (self.lasting).turn(self.sides.iter().copied(), height, |side, heights| {
            let corners = side.corners(heights);
            emit(strip, visit, side.identity(), corners);
        });
    }

    fn covered(&mut self, columns: &[Column], height: f64, by: &Quadrant) {
        for column in columns.iter().filter(|column| column.closing() > height) {
            let [[left, right], [low, high]] = covered_part(column, height, by);
            if left < right && low < high {
                let corners = [[left, low], [right, low], [right, high], [left, high]];
                let corners = corners.map_each(|[u, v]| [height, u, v]);
                emit(
                    &mut self.strip,
                    &mut self.visit,
                    (by.source, 0, false),
                    corners,
                );
            }
        }
    }
}

/// The part of a column that a quadrant covers, from low to high along u and along v.
fn covered_part(column: &Column, height: f64, by: &Quadrant) -> [[f64; 2]; 2] {
    let mut ends = [column.u, column.v].map_each(|lines| lines.map(|line| line.at(height)));
    for along in [0, 1] {
        let (side, [low, high]) = (by.side(along).at(height), &mut ends[along]);
        if by.is_low[along] {
            *high = high.min(side);
        } else {
            *low = low.max(side);
        }
    }
    ends
}

/// Adds the sides between two columns, or an end and a column: parts of the wider one's side.
fn push_between(sides: &mut Vec<MovingSide>, [left, right]: [Option<&Column>; 2]) {
    let (outer, inner, is_high) = match (left, right) {
        (None, None) => return,
        (Some(left), None) => (left, None, true),
        (None, Some(right)) => (right, None, false),
        // The front that begins here leaves the column before it.
        (Some(left), Some(right)) if left.u[1].slope < 0.0 => (left, Some(right), true),
        (Some(left), Some(right)) => (right, Some(left), false),
    };
    let parts = match inner {
        None => vec![outer.v],
        Some(inner) => vec![[outer.v[0], inner.v[0]], [inner.v[1], outer.v[1]]],
    };
    let parts = parts.into_iter().filter(|part| part[0] != part[1]);
    sides.extend(parts.map(|between| MovingSide {
        along: 0,
        is_high,
        at: outer.u[usize::from(is_high)],
        between,
    }));
}

impl MovingSide {
    /// The low or high side along v of a column.
    fn along_v(is_high: bool, at: Line, column: &Column) -> Self {
        Self {
            along: 1,
            is_high,
            at,
            between: column.u,
        }
    }

    /// Who is beyond, the form of its plane, and whether it is low.
    fn identity(&self) -> (u32, u8, bool) {
        (self.at.source, self.along as u8 + 1, !self.is_high)
    }

    /// Its corners (h, u, v), counter-clockwise from outside.
    fn corners(&self, heights: [f64; 2]) -> [[f64; 3]; 4] {
        let [from, to] = heights.map_each(|height| {
            let at = self.at.at(height);
            let low = self.between[0].at(height);
            let high = self.between[1].at(height);
            let is_apart = high - low > ROUNDING * (height + low.abs());
            let high = if is_apart { high } else { low };
            [low, high].map_each(|other| match self.along {
                0 => [height, at, other],
                _ => [height, other, at],
            })
        });
        if (self.along == 0) == self.is_high {
            [from[0], from[1], to[1], to[0]]
        } else {
            [from[0], to[0], to[1], from[1]]
        }
    }
}
