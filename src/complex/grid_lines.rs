//! Places, directions and lines of the grid on which L∞ cells are computed without rounding: all edges run
//! along vectors of components −1, 0 and 1.

use std::collections::HashMap;

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

/// The parts of an edge between vertices on its line.
pub(crate) fn parts_of(edge: &[Place; 2], lines: &HashMap<LineKey, Vec<i64>>) -> Vec<[Place; 2]> {
    let key = line_of(edge);
    let direction = &DIRECTIONS[usize::from(key.0)];
    let [from, to] = edge.map(|at| line_through(&at, key.0, direction).1);
    let (low, high) = (from.min(to), from.max(to));
    let on_line = lines.get(&key).map_or(&[][..], Vec::as_slice);
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
