//! Places, directions and lines of the grid on which L∞ cells are computed without rounding: all edges run
//! along vectors of components −1, 0 and 1.

use crate::parallel::{RUN, map_runs};

/// A place in half steps of the grid.
pub(crate) type Place = [i64; 3];

/// A line: its direction's number, and where it passes.
pub(crate) type LineKey = (u8, i64, i64);

/// The directions of lines, whose first component that is not zero is one.
pub(crate) const DIRECTIONS: [[i64; 3]; 13] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [1, -1, 0],
    [1, 0, 1],
    [1, 0, -1],
    [0, 1, 1],
    [0, 1, -1],
    [1, 1, 1],
    [1, 1, -1],
    [1, -1, 1],
    [1, -1, -1],
];

/// The number of the direction from one place to another, and whether it runs forward (1) or back (−1).
pub(crate) fn direction_of(from: &Place, to: &Place) -> Option<(u8, i32)> {
    let way = [0, 1, 2].map(|axis| to[axis] - from[axis]);
    let length = way.iter().map(|along| along.abs()).max()?;
    let sign = way.iter().find(|along| **along != 0)?.signum();
    let runs = |direction: &Place| (0..3).all(|axis| way[axis] == sign * length * direction[axis]);
    let number = DIRECTIONS.iter().position(runs)?;
    Some((number as u8, sign as i32))
}

/// The line through a place along a direction, and where on it the place is.
pub(crate) fn line_through(at: &Place, number: u8, direction: &Place) -> (LineKey, i64) {
    let axis = direction.iter().position(|along| *along != 0).unwrap_or(0);
    let along = at[axis];
    let [one, other] = [1, 2].map(|turn| {
        let axis = (axis + turn) % 3;
        at[axis] - direction[axis] * along
    });
    ((number, one, other), along)
}

/// The place on a line.
pub(crate) fn place_on(&(number, one, other): &LineKey, along: i64) -> Place {
    let direction = DIRECTIONS[usize::from(number)];
    let axis = direction.iter().position(|along| *along != 0).unwrap_or(0);
    let mut place = direction.map(|part| part * along);
    place[(axis + 1) % 3] += one;
    place[(axis + 2) % 3] += other;
    place
}

/// The line of an edge, which is along one of [`DIRECTIONS`].
pub(crate) fn line_of([from, to]: &[Place; 2]) -> LineKey {
    let (number, _) = direction_of(from, to).unwrap_or_default();
    line_through(from, number, &DIRECTIONS[usize::from(number)]).0
}

/// Lines, and where on each of them vertices lie.
#[derive(Debug)]
pub(crate) struct PlacesOnLines {
    lines: Vec<LineKey>,
    /// Where those of every line end.
    ends: Vec<u32>,
    along: Vec<i64>,
}

impl PlacesOnLines {
    /// The places at which the `copies` of `count` vertices lie on lines.
    pub(crate) fn new(
        mut lines: Vec<LineKey>,
        count: usize,
        copies: &(dyn Fn(usize) -> Vec<Place> + Sync),
    ) -> Self {
        lines.sort_unstable();
        lines.dedup();
        lines.shrink_to_fit();
        let runs = map_runs(count, RUN, |run| {
            let mut on_lines: Vec<(u32, i64)> = Vec::new();
            for vertex in run.flat_map(copies) {
                for (number, direction) in (0..).zip(&DIRECTIONS) {
                    let (key, along) = line_through(&vertex, number, direction);
                    if let Ok(line) = lines.binary_search(&key) {
                        on_lines.push((line as u32, along));
                    }
                }
            }
            on_lines
        });
        let mut on_lines: Vec<(u32, i64)> = Vec::with_capacity(runs.iter().map(Vec::len).sum());
        runs.into_iter().for_each(|run| on_lines.extend(run));
        on_lines.sort_unstable();
        let mut ends = vec![0; lines.len()];
        for (end, (line, _)) in (1..).zip(&on_lines) {
            ends[*line as usize] = end;
        }
        for line in 1..ends.len() {
            ends[line] = ends[line].max(ends[line - 1]);
        }
        Self {
            lines,
            ends,
            along: on_lines.into_iter().map(|(_, along)| along).collect(),
        }
    }

    /// Where on a line vertices lie, in their order.
    fn on(&self, key: &LineKey) -> &[i64] {
        let Ok(line) = self.lines.binary_search(key) else {
            return &[];
        };
        let start = line.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.along[start as usize..self.ends[line] as usize]
    }

    /// The parts of an edge between vertices on its line.
    pub(crate) fn parts_of(&self, edge: &[Place; 2]) -> Vec<[Place; 2]> {
        let key = line_of(edge);
        let direction = &DIRECTIONS[usize::from(key.0)];
        let [from, to] = edge.map(|at| line_through(&at, key.0, direction).1);
        let (low, high) = (from.min(to), from.max(to));
        let on_line = self.on(&key);
        let inner = on_line[on_line.partition_point(|along| *along <= low)..]
            .iter()
            .copied();
        let mut ends: Vec<i64> = vec![low];
        ends.extend(inner.take_while(|along| *along < high));
        ends.push(high);
        ends.dedup();
        let parts = ends
            .windows(2)
            .map(|pair| [pair[0], pair[1]].map(|along| place_on(&key, along)));
        match from < to {
            true => parts.collect(),
            false => parts.rev().map(|[low, high]| [high, low]).collect(),
        }
    }
}
