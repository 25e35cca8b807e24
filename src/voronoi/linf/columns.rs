//! The columns of a section: from the left end to the right one, from front to front.

use crate::arrays::MapEach;
use crate::voronoi::linf::block::{CONE_SIDE, Column, Line};
use crate::voronoi::linf::quadrant::{ConeWalls, front_line};

/// A front along u of quadrants from one side, and what they and the fronts before it leave along v.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Front {
    pub(crate) at: f64,
    pub(crate) source: u32,
    pub(crate) caps: [Cap; 2],
}

/// The nearest quadrant from one end along v: its distance and who it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cap {
    pub(crate) at: f64,
    pub(crate) source: u32,
}

pub(crate) const NO_CAP: Cap = Cap {
    at: f64::INFINITY,
    source: CONE_SIDE,
};

/// What is at the right end of a column.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Boundary<'a> {
    /// A front from the right begins.
    Begins(&'a Front),
    /// A front from the left ends.
    Ends(&'a Front),
    Wall,
}

/// The way from the left end of a section to its right one.
pub(crate) struct ColumnWalk<'a> {
    walls: &'a ConeWalls,
    /// From the right and from the left.
    fronts: [&'a [Front]; 2],
    height: f64,
    /// How many fronts from the right have begun, and from the left not yet ended.
    counts: [usize; 2],
    /// How many fronts from either side are beyond the other end.
    hidden: [usize; 2],
    /// The left end of the next column.
    start: Line,
}

impl<'a> ColumnWalk<'a> {
    pub(crate) fn new(walls: &'a ConeWalls, fronts: &'a [Vec<Front>; 2], height: f64) -> Self {
        let hidden = [0, 1].map_each(|side| {
            let wall = walls.across[0][side].0;
            hidden(&fronts[side], wall, height)
        });
        Self {
            walls,
            fronts: [&fronts[0], &fronts[1]],
            height,
            counts: [hidden[0], fronts[1].len()],
            hidden,
            start: walls.end(0, false, height),
        }
    }

    /// The height at which the next front reaches the wall at the other end.
    pub(crate) fn next_hiding(&self) -> f64 {
        let of_side = |side: usize| {
            let wall = self.walls.across[0][side].0;
            let front = self.fronts[side].get(self.hidden[side]);
            let front = front.filter(|_| wall <= self.height);
            front.map_or(f64::INFINITY, |front| front.at + wall)
        };
        of_side(0).min(of_side(1))
    }

    #[inline]
    pub(crate) fn boundary(&self) -> Boundary<'a> {
        let [begun, left] = self.counts;
        let begins = self.fronts[0].get(begun);
        let ends = if left > self.hidden[1] {
            self.fronts[1].get(left - 1)
        } else {
            None
        };
        match (begins, ends) {
            (Some(begins), Some(ends)) if begins.at + ends.at > 2.0 * self.height => {
                Boundary::Ends(ends)
            }
            (Some(begins), _) => Boundary::Begins(begins),
            (None, Some(ends)) => Boundary::Ends(ends),
            (None, None) => Boundary::Wall,
        }
    }

    /// The column up to a boundary.
    #[inline]
    pub(crate) fn column(&mut self, boundary: Boundary<'_>) -> Column {
        let end = match boundary {
            Boundary::Begins(front) => front_line(front.at, false, front.source),
            Boundary::Ends(front) => front_line(front.at, true, front.source),
            Boundary::Wall => self.walls.end(0, true, self.height),
        };
        let start = std::mem::replace(&mut self.start, end);
        let v = lines(self.walls, self.height, caps(self.fronts, self.counts));
        Column { u: [start, end], v }
    }

    #[inline]
    pub(crate) fn pass(&mut self, boundary: Boundary<'_>) {
        match boundary {
            Boundary::Begins(_) => self.counts[0] += 1,
            Boundary::Ends(_) => self.counts[1] -= 1,
            Boundary::Wall => {}
        }
    }
}

/// How many fronts have reached the other end of the section, a wall at this distance or the cone's side.
#[inline]
fn hidden(fronts: &[Front], wall: f64, height: f64) -> usize {
    let is_hidden = |front: &&Front| front.at <= 0.0 || wall <= height && front.at + wall <= height;
    fronts.iter().take_while(is_hidden).count()
}

/// The nearer caps of the first fronts from the right and from the left, so many of each.
#[inline]
fn caps(fronts: [&[Front]; 2], counts: [usize; 2]) -> [Cap; 2] {
    let of = |side: usize| match counts[side].checked_sub(1) {
        Some(last) => fronts[side][last].caps,
        None => [NO_CAP; 2],
    };
    let (right, left) = (of(0), of(1));
    [0, 1].map_each(|end| {
        if left[end].at < right[end].at {
            left[end]
        } else {
            right[end]
        }
    })
}

/// The low and the high line along v that caps leave.
#[inline]
fn lines(walls: &ConeWalls, height: f64, caps: [Cap; 2]) -> [Line; 2] {
    [0, 1].map_each(|end| {
        let Cap { at, source } = caps[end];
        if at < f64::INFINITY {
            front_line(at, end == 0, source)
        } else {
            walls.end(1, end == 1, height)
        }
    })
}
