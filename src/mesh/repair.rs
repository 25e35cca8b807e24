//! Repairs of a surface: collapsed, duplicate and wall triangles dropped, equal vertices merged.

use std::collections::HashMap;

use nalgebra::Point3;

use crate::mesh::edges::EdgeTable;
use crate::mesh::orient::is_closed;
use crate::mesh::report::Tally;

/// Triangles under repair, each with its number in the mesh as read.
#[derive(Clone, Debug)]
pub(crate) struct Triangles {
    /// Zero-based vertex indices.
    pub(crate) corners: Vec<[u32; 3]>,
    /// The numbers in the mesh as read.
    pub(crate) numbers: Vec<u32>,
}

impl Triangles {
    pub(crate) fn of(corners: &[[u32; 3]]) -> Self {
        Self {
            numbers: (0..corners.len() as u32).collect(),
            corners: corners.to_vec(),
        }
    }

    /// Drops the marked triangles and returns their numbers as read.
    fn drop_marked(&mut self, marked: &[bool]) -> Tally<u32> {
        let dropped = self
            .numbers
            .iter()
            .zip(marked)
            .filter(|&(_, &marked)| marked);
        let tally = dropped.map(|(&number, _)| number).collect();
        let mut marks = marked.iter();
        self.corners
            .retain(|_| !marks.next().is_some_and(|&marked| marked));
        let mut marks = marked.iter();
        self.numbers
            .retain(|_| !marks.next().is_some_and(|&marked| marked));
        tally
    }
}

/// Drops triangles with a repeated vertex. Their two remaining sides run along one edge in
/// opposite directions, so a closed surface stays closed.
pub(crate) fn drop_collapsed(triangles: &mut Triangles) -> Tally<u32> {
    let collapsed = |&[a, b, c]: &[u32; 3]| a == b || b == c || c == a;
    let marked: Vec<bool> = triangles.corners.iter().map(collapsed).collect();
    triangles.drop_marked(&marked)
}

/// Drops duplicates: of triangles on the same three vertices one is kept, or none where the one
/// would be part of a wall between two parts of the solid, see [`spread_walls`].
pub(crate) fn drop_duplicates(triangles: &mut Triangles, vertices: usize) -> Tally<u32> {
    let groups = coincident_groups(&triangles.corners);
    if groups.is_empty() {
        return Tally::default();
    }
    let mut marked = vec![false; triangles.corners.len()];
    let mut doubled = vec![false; triangles.corners.len()];
    for group in &groups {
        doubled[group[0] as usize] = true;
        for &extra in &group[1..] {
            marked[extra as usize] = true;
        }
    }
    spread_walls(
        &EdgeTable::of(&triangles.corners, vertices),
        &doubled,
        &mut marked,
    );
    triangles.drop_marked(&marked)
}

/// Marks the `doubled` triangles that form walls. A wall starts at an edge where three triangles,
/// or a greater odd number, are left (the two outer sides of the solid and the wall), and goes
/// on across edges of doubled triangles only.
fn spread_walls(edges: &EdgeTable, doubled: &[bool], marked: &mut [bool]) {
    let mut walls = Vec::new();
    let mut inner = Vec::new();
    for edge in edges.iter() {
        let triangles = edge.sides.iter().map(|&side| side as usize / 3);
        let left: Vec<usize> = triangles.filter(|&triangle| !marked[triangle]).collect();
        match left[..] {
            [one, other] if doubled[one] && doubled[other] => inner.push([one, other]),
            _ if left.len() >= 3 && left.len() % 2 == 1 => walls.extend(left),
            _ => {}
        }
    }
    for wall in walls.into_iter().filter(|&wall| doubled[wall]) {
        marked[wall] = true;
    }
    spread(&inner, marked);
}

/// Marks both of a pair if one is marked, until nothing changes.
fn spread(pairs: &[[usize; 2]], marked: &mut [bool]) {
    let mut spreads = true;
    while spreads {
        spreads = false;
        for &[one, other] in pairs {
            if marked[one] != marked[other] {
                (marked[one], marked[other]) = (true, true);
                spreads = true;
            }
        }
    }
}

/// Of a surface whose every edge is balanced, drops twins: triangles on the same vertices, in pairs
/// of opposite winding, which cancel; then those that repeat others, unless that opens the surface.
/// Returns the former and the latter.
pub(crate) fn drop_twins(triangles: &mut Triangles, vertices: usize) -> (Tally<u32>, Tally<u32>) {
    let groups = coincident_groups(&triangles.corners);
    let mut marked = vec![false; triangles.corners.len()];
    let mut repeats = vec![false; triangles.corners.len()];
    for group in &groups {
        let is_even = |&at: &u32| {
            let [a, b, c] = triangles.corners[at as usize];
            (a < b) ^ (b < c) ^ (c < a)
        };
        let (one, other): (Vec<u32>, Vec<u32>) = group.iter().copied().partition(is_even);
        let pairs = one.len().min(other.len());
        for &at in one[..pairs].iter().chain(&other[..pairs]) {
            marked[at as usize] = true;
        }
        for &at in one[pairs..].iter().chain(&other[pairs..]).skip(1) {
            repeats[at as usize] = true;
        }
    }
    let kept = repeats.iter().zip(&marked).filter(|&(_, &marked)| !marked);
    let repeats: Vec<bool> = kept.map(|(&repeat, _)| repeat).collect();
    let cancelled = triangles.drop_marked(&marked);
    let mut once = triangles.clone();
    let dropped = once.drop_marked(&repeats);
    let edges = EdgeTable::of(&once.corners, vertices);
    if dropped.count == 0 || !is_closed(&once.corners, &edges) {
        return (cancelled, Tally::default());
    }
    *triangles = once;
    (cancelled, dropped)
}

/// Merges vertices nearer than `distance` (L) in every coordinate, 0 for equal ones, into the first of
/// them; returns how many were merged away, and the greatest distance between two merged.
pub(crate) fn weld(
    vertices: &mut Vec<Point3<f64>>,
    triangles: &mut Triangles,
    distance: f64,
) -> (usize, f64) {
    let mut welder = Welder::with_capacity(vertices.len());
    let equal: Vec<u32> = vertices.iter().map(|vertex| welder.index(vertex)).collect();
    let (mut welded, mut apart) = (welder.into_points(), 0.0);
    let new_index = if distance > 0.0 {
        let near: Vec<u32>;
        (welded, near, apart) = merge_near(&welded, distance);
        equal.iter().map(|&vertex| near[vertex as usize]).collect()
    } else {
        equal
    };
    let merged = vertices.len() - welded.len();
    if merged > 0 {
        *vertices = welded;
        renumber(triangles, &new_index);
    }
    (merged, apart)
}

fn renumber(triangles: &mut Triangles, new_index: &[u32]) {
    for vertex in triangles.corners.iter_mut().flatten() {
        *vertex = new_index[*vertex as usize];
    }
}

/// The points without those within `distance` of an earlier one, the new number of each, and the
/// greatest distance between two merged. A grid of cells four distances wide holds the kept ones.
pub(crate) fn merge_near(
    points: &[Point3<f64>],
    distance: f64,
) -> (Vec<Point3<f64>>, Vec<u32>, f64) {
    let cell = |x: f64| (x / (4.0 * distance)).floor() as i64;
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let (mut kept, mut farthest) = (Vec::<Point3<f64>>::new(), 0.0_f64);
    let mut new_index = Vec::with_capacity(points.len());
    for point in points {
        let low = [0, 1, 2].map(|k| cell(point[k] - distance));
        let high = [0, 1, 2].map(|k| cell(point[k] + distance));
        let near = (0..8).find_map(|corner: usize| {
            let key = [0, 1, 2].map(|k| {
                if corner >> k & 1 == 0 {
                    low[k]
                } else {
                    high[k]
                }
            });
            let is_near = |&&at: &&u32| (kept[at as usize] - point).amax() <= distance;
            grid.get(&key)?.iter().find(is_near).copied()
        });
        if let Some(at) = near {
            farthest = farthest.max((kept[at as usize] - point).norm());
            new_index.push(at);
            continue;
        }
        let at = kept.len() as u32;
        kept.push(*point);
        new_index.push(at);
        let key = [0, 1, 2].map(|k| cell(point[k]));
        grid.entry(key).or_default().push(at);
    }
    (kept, new_index, farthest)
}

/// The groups of two or more triangles on the same three vertices, ascending in each.
fn coincident_groups(corners: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let sorted = |mut corners: [u32; 3]| {
        corners.sort_unstable();
        corners
    };
    let mut keys: Vec<([u32; 3], u32)> = corners.iter().map(|&c| sorted(c)).zip(0..).collect();
    keys.sort_unstable();
    let groups = keys.chunk_by(|one, other| one.0 == other.0);
    let several = groups.filter(|group| group.len() > 1);
    several
        .map(|group| group.iter().map(|&(_, at)| at).collect())
        .collect()
}

/// The share of filled slots at which the table grows: above it, linear probing slows down.
const FULL: f64 = 0.5;

/// Gives equal points equal indices, in order of first appearance. Equality is by bits, except
/// that −0 equals 0: nothing is merged that merely lies close. An open-addressing table of
/// 32-bit slots, several times lighter than a `HashMap` of coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Welder {
    points: Vec<Point3<f64>>,
    slots: Vec<u32>,
}

const VACANT: u32 = u32::MAX;

impl Welder {
    /// A welder that expects about `points` distinct points.
    #[must_use]
    pub(crate) fn with_capacity(points: usize) -> Self {
        let slots = ((points as f64 / FULL) as usize).next_power_of_two();
        Self {
            points: Vec::with_capacity(points),
            slots: vec![VACANT; slots.max(16)],
        }
    }

    /// The index of `point`, a new one at its first occurrence.
    pub(crate) fn index(&mut self, point: &Point3<f64>) -> u32 {
        // Adding zero turns −0 into 0.
        let point = point.map(|coordinate| coordinate + 0.0);
        let slot = self.slot(&point);
        if self.slots[slot] != VACANT {
            return self.slots[slot];
        }
        let index = self.points.len() as u32;
        self.slots[slot] = index;
        self.points.push(point);
        if self.points.len() as f64 > FULL * self.slots.len() as f64 {
            self.grow();
        }
        index
    }

    /// The distinct points in order of first appearance.
    #[must_use]
    pub(crate) fn into_points(self) -> Vec<Point3<f64>> {
        self.points
    }

    /// The slot that holds `point` or should.
    fn slot(&self, point: &Point3<f64>) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash(point) as usize & mask;
        loop {
            let index = self.slots[slot];
            if index == VACANT || same_bits(&self.points[index as usize], point) {
                return slot;
            }
            slot = (slot + 1) & mask;
        }
    }

    fn grow(&mut self) {
        self.slots = vec![VACANT; self.slots.len() * 2];
        for index in 0..self.points.len() {
            let slot = self.slot(&self.points[index]);
            self.slots[slot] = index as u32;
        }
    }
}

fn same_bits(one: &Point3<f64>, other: &Point3<f64>) -> bool {
    (0..3).all(|axis| one[axis].to_bits() == other[axis].to_bits())
}

/// Multiply-and-fold over the three bit patterns; the constants are odd 64-bit digits of π
/// and e. Points of a lattice differ in few high bits, hence the folding of the high half.
fn hash(point: &Point3<f64>) -> u64 {
    let mut hash = 0x243f_6a88_85a3_08d3_u64;
    for coordinate in point.iter() {
        hash = (hash ^ coordinate.to_bits()).wrapping_mul(0xb7e1_5162_8aed_2a6b);
        hash ^= hash >> 32;
    }
    hash
}
