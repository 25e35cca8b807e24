//! Repairs of a surface: collapsed, duplicate and wall triangles dropped, equal vertices merged.

use nalgebra::Point3;

use crate::mesh::edges::EdgeTable;
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

/// Merges vertices with equal coordinates; returns how many were merged away.
pub(crate) fn weld(vertices: &mut Vec<Point3<f64>>, triangles: &mut Triangles) -> usize {
    let mut welder = Welder::with_capacity(vertices.len());
    let new_index: Vec<u32> = vertices.iter().map(|vertex| welder.index(vertex)).collect();
    let welded = welder.into_points();
    let merged = vertices.len() - welded.len();
    if merged > 0 {
        *vertices = welded;
        for vertex in triangles.corners.iter_mut().flatten() {
            *vertex = new_index[*vertex as usize];
        }
    }
    merged
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
