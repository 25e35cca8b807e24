//! The cells of a run as numbers for a page: points that cells share, faces, and values of every cell.
//!
//! Positions are quantized to 24 bits of the box around all cells, which welds the points that cells
//! share. A face that two cells show from both sides is stored once. Cells that do not fit together to the
//! bit (L∞ cells) keep a face each: the page then draws both.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};

use crate::geometry::bounds::Bounds;
use crate::geometry::shell::Shell;
use crate::plot::color::ColorScale;
use crate::report::packing::{COORDINATE_BITS, NumberPacker};

/// Which end of a column's range is the good one, and bright.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BrightEnd {
    /// The low one.
    Low,
    /// The high one.
    High,
}

/// A value of every cell.
#[derive(Clone, Debug)]
pub(crate) struct ValueColumn {
    /// Its short name.
    pub(crate) name: &'static str,
    /// Its name with its unit, for the color bar.
    pub(crate) label: &'static str,
    /// Which end of its range is bright.
    pub(crate) bright: BrightEnd,
    /// Whether the values are whole numbers.
    pub(crate) is_whole: bool,
    /// A value for each cell.
    pub(crate) values: Vec<f64>,
}

/// A cell that a page shows.
#[derive(Clone, Debug)]
pub(crate) struct ShownCell {
    /// The number of its site.
    pub(crate) site: u32,
    /// The site's place.
    pub(crate) position: Point3<f64>,
    /// The cell's surface, in the plane the polygons that fill it.
    pub(crate) shell: Shell,
    /// Edges between these polygons, which get no lines.
    pub(crate) seams: Vec<[Point3<f64>; 2]>,
}

/// The cells of a run that a page shows, in site order.
#[derive(Clone, Debug)]
pub(crate) struct ShownCells {
    /// The dimension of space.
    pub(crate) dimension: usize,
    /// The box around the domain; z is 0 in the plane.
    pub(crate) bounds: Bounds<3>,
    /// How many cells the run has.
    pub(crate) total: usize,
    /// Which of them are shown, if not all: "those that touch …".
    pub(crate) selection: Option<String>,
    /// The cells.
    pub(crate) cells: Vec<ShownCell>,
    /// Their values.
    pub(crate) columns: Vec<ValueColumn>,
}

/// Cells in packed form.
#[derive(Clone, Debug)]
pub(crate) struct PackedCells {
    /// What a reader of the numbers needs, and what the page says about them.
    pub(crate) header: Value,
    /// The numbers.
    pub(crate) numbers: String,
}

/// The largest quantized coordinate.
const LARGEST: f64 = ((1_u32 << COORDINATE_BITS) - 1) as f64;

/// The cosine above which facets of one cell that meet in an edge are one wall, and the edge gets no line:
/// 25°, as in `plot::z_buffer`.
const SMOOTH: f64 = 0.9;

/// Places nearer than this share of an edge are one.
const SAME_PLACE: f64 = 1e-6;

impl ShownCells {
    /// The cells as text for a page.
    #[must_use]
    pub(crate) fn pack(&self) -> PackedCells {
        let order = self.spatial_order();
        let grid = QuantizedBox::around(self);
        let mut faces = SharedFaces::default();
        for &cell in &order {
            faces.push_cell(&self.cells[cell], &grid);
        }
        let mut packer = NumberPacker::default();
        faces.pack(&mut packer);
        self.pack_values(&order, &grid, &mut packer);
        PackedCells {
            header: self.header(&faces, &grid, packer.len()),
            numbers: packer.finish(),
        }
    }

    /// Adds the sites' places and numbers and the values of the cells, in this order.
    fn pack_values(&self, order: &[usize], grid: &QuantizedBox, packer: &mut NumberPacker) {
        let cells = || order.iter().map(|&cell| &self.cells[cell]);
        let sites: Vec<[u32; 3]> = cells().map(|cell| grid.place(&cell.position)).collect();
        push_places(packer, &sites);
        packer.push(&cells().map(|cell| cell.site).collect::<Vec<_>>());
        for column in &self.columns {
            let values = order.iter().map(|&cell| column.values[cell]);
            packer.push_reals(&values.collect::<Vec<_>>());
        }
    }

    fn header(&self, faces: &SharedFaces, grid: &QuantizedBox, bytes: usize) -> Value {
        json!({
            "dimension": self.dimension,
            "bounds": [self.bounds.min.coords.as_slice(), self.bounds.max.coords.as_slice()],
            "total": self.total,
            "selection": self.selection,
            "cells": self.cells.len(),
            "points": faces.points.len(),
            "faces": faces.sizes.len(),
            "corners": faces.corners.len(),
            "bytes": bytes,
            "origin": grid.min.coords.as_slice(),
            "step": grid.step.as_slice(),
            "columns": self.columns.iter().map(ValueColumn::header).collect::<Vec<_>>(),
        })
    }

    /// The cells along a curve that keeps neighbors together, which makes the numbers deflate better: by
    /// the interleaved bits of their sites' coordinates (Morton order).
    fn spatial_order(&self) -> Vec<usize> {
        const BITS: u32 = 10;
        let corner = self.bounds.min;
        let step = self.bounds.extent().map(|length| cells_per(length, BITS));
        let key = |cell: &usize| {
            let arm = (self.cells[*cell].position - corner).component_mul(&step);
            let places = arm.map(|place| place.clamp(0.0, f64::from((1 << BITS) - 1)) as u32);
            (0..BITS).rev().fold(0_u32, |key, bit| {
                (0..3).fold(key, |key, axis| key << 1 | places[axis] >> bit & 1)
            })
        };
        let mut order: Vec<usize> = (0..self.cells.len()).collect();
        order.sort_by_cached_key(key);
        order
    }
}

fn cells_per(length: f64, bits: u32) -> f64 {
    let count = f64::from(1_u32 << bits);
    if length > 0.0 { count / length } else { 0.0 }
}

impl ValueColumn {
    fn header(&self) -> Value {
        let scale = ColorScale::fitting(self.label, self.values.iter().copied());
        json!({
            "name": self.name,
            "label": self.label,
            "bright": match self.bright { BrightEnd::Low => "low", BrightEnd::High => "high" },
            "whole": self.is_whole,
            "range": [scale.min, scale.max],
        })
    }
}

/// The box that quantized coordinates fill.
#[derive(Clone, Copy, Debug)]
struct QuantizedBox {
    min: Point3<f64>,
    /// The length of one step along each axis (L).
    step: Vector3<f64>,
}

impl QuantizedBox {
    fn around(cells: &ShownCells) -> Self {
        let shells = cells.cells.iter().flat_map(|cell| cell.shell.vertices());
        let places = cells.cells.iter().map(|cell| &cell.position);
        let bounds = Bounds::of(shells.chain(places));
        let is_finite = bounds.extent().iter().all(|length| length.is_finite());
        let bounds = if is_finite { bounds } else { cells.bounds };
        Self {
            min: bounds.min,
            step: bounds.extent() / LARGEST,
        }
    }

    fn place(&self, point: &Point3<f64>) -> [u32; 3] {
        let arm = point - self.min;
        let place = |axis: usize| {
            let steps = arm[axis] / self.step[axis];
            if steps.is_finite() {
                steps.round().clamp(0.0, LARGEST) as u32
            } else {
                0
            }
        };
        [place(0), place(1), place(2)]
    }
}

fn push_places(packer: &mut NumberPacker, places: &[[u32; 3]]) {
    for axis in 0..3 {
        let along: Vec<u32> = places.iter().map(|place| place[axis]).collect();
        packer.push_coordinates(&along);
    }
}

/// Faces of cells by the points that they share.
#[derive(Debug, Default)]
struct SharedFaces {
    points: Vec<[u32; 3]>,
    numbers: HashMap<[u32; 3], u32>,
    /// Faces that had one cell so far, by their corners as seen from there, the least first.
    open: HashMap<Vec<u32>, usize>,
    /// How many faces each cell owns; a face belongs to the first of its cells.
    owned: Vec<u32>,
    owners: Vec<u32>,
    sizes: Vec<u32>,
    /// The cell on the other side of a face, by how many cells it comes later; 0 for none.
    neighbors: Vec<u32>,
    corners: Vec<u32>,
    /// For every corner whether the edge to the next one lies within a wall.
    smooth: Vec<bool>,
}

/// A corner of a face and whether the edge to the next lies within a wall.
type FaceCorner = (u32, bool);

impl SharedFaces {
    /// Adds the next cell.
    fn push_cell(&mut self, shown: &ShownCell, grid: &QuantizedBox) {
        let (cell, shell) = (self.owned.len() as u32, &shown.shell);
        let numbers: Vec<u32> = shell
            .vertices()
            .iter()
            .map(|vertex| self.number(grid.place(vertex)))
            .collect();
        let (mut smooth, mut count) = (smooth_edges(shown).into_iter(), 0);
        for facet in shell.facets() {
            let corners = facet.iter().map(|&corner| numbers[corner as usize]);
            let corners: Vec<FaceCorner> = corners.zip(&mut smooth).collect();
            let face = without_repetitions(&corners);
            if face.len() >= 3 && !self.closes(cell, &face) {
                self.push_face(cell, &face);
                count += 1;
            }
        }
        self.owned.push(count);
    }

    fn number(&mut self, place: [u32; 3]) -> u32 {
        let next = self.points.len() as u32;
        let number = *self.numbers.entry(place).or_insert(next);
        if number == next {
            self.points.push(place);
        }
        number
    }

    /// Whether a face is the other side of one that is there.
    fn closes(&mut self, cell: u32, face: &[FaceCorner]) -> bool {
        let reversed = face.iter().rev().map(|&(corner, _)| corner).collect();
        match self.open.remove(&least_first(reversed)) {
            Some(other) if self.owners[other] != cell => {
                self.neighbors[other] = cell - self.owners[other];
                true
            }
            _ => false,
        }
    }

    fn push_face(&mut self, cell: u32, face: &[FaceCorner]) {
        let corners: Vec<u32> = face.iter().map(|&(corner, _)| corner).collect();
        self.corners.extend_from_slice(&corners);
        self.smooth.extend(face.iter().map(|&(_, smooth)| smooth));
        self.open.insert(least_first(corners), self.sizes.len());
        self.sizes.push(face.len() as u32);
        self.owners.push(cell);
        self.neighbors.push(0);
    }

    /// Adds all faces and points.
    fn pack(&self, packer: &mut NumberPacker) {
        let (ways, points) = self.ways();
        let points: Vec<[u32; 3]> = points.iter().map(|&k| self.points[k as usize]).collect();
        push_places(packer, &points);
        packer.push(&self.owned);
        packer.push(&self.sizes);
        packer.push(&self.neighbors);
        packer.push(&ways);
        packer.push_flags(&self.smooth);
    }

    /// The corners, each by how many numbers before the next new one it lies, 0 for that itself, and the
    /// points in the order in which faces first name them. Those of facets too small to be there come last.
    fn ways(&self) -> (Vec<u32>, Vec<u32>) {
        let (mut renumbered, mut order) = (vec![u32::MAX; self.points.len()], Vec::new());
        let ways = self.corners.iter().map(|&corner| {
            let next = order.len() as u32;
            let number = &mut renumbered[corner as usize];
            if *number == u32::MAX {
                *number = next;
                order.push(corner);
            }
            next - *number
        });
        let ways = ways.collect();
        let left = (0..)
            .zip(&renumbered)
            .filter(|(_, number)| **number == u32::MAX);
        order.extend(left.map(|(point, _)| point));
        (ways, order)
    }
}

/// A loop from its least number on.
fn least_first(mut corners: Vec<u32>) -> Vec<u32> {
    let least = (0..corners.len()).min_by_key(|&k| corners[k]).unwrap_or(0);
    corners.rotate_left(least);
    corners
}

/// A loop without edges of no length.
fn without_repetitions(face: &[FaceCorner]) -> Vec<FaceCorner> {
    let next = face.iter().cycle().skip(1);
    let kept = face
        .iter()
        .zip(next)
        .filter(|(here, next)| here.0 != next.0);
    kept.map(|(&here, _)| here).collect()
}

/// An edge of a facet: its lower and higher vertex, the facet's normal, the place among all edges.
type FacetSide = ([u32; 2], Vector3<f64>, usize);

/// For every corner of every facet whether the edge from it to the next lies within a wall: between two
/// facets that form no crease, run through twice by one facet, or a seam.
fn smooth_edges(cell: &ShownCell) -> Vec<bool> {
    let shell = &cell.shell;
    let mut sides: Vec<FacetSide> = Vec::new();
    for facet in shell.facets() {
        let normal = unit_normal(shell, facet);
        let following = facet.iter().cycle().skip(1);
        for (&from, &to) in facet.iter().zip(following) {
            sides.push(([from.min(to), from.max(to)], normal, sides.len()));
        }
    }
    let mut smooth = vec![false; sides.len()];
    sides.sort_unstable_by_key(|(edge, _, place)| (*edge, *place));
    for edge in sides.chunk_by(|one, other| one.0 == other.0) {
        let first = edge[0].1;
        let is_smooth = edge.len() > 1 && edge.iter().all(|side| side.1.dot(&first) > SMOOTH);
        let ends = edge[0].0.map(|corner| shell.vertices()[corner as usize]);
        for (_, _, place) in edge {
            smooth[*place] = is_smooth || cell.has_seam(ends);
        }
    }
    smooth
}

impl ShownCell {
    /// Whether there is a seam between these places, to what vertices of a shell are welded.
    fn has_seam(&self, [one, other]: [Point3<f64>; 2]) -> bool {
        let reach = SAME_PLACE * (other - one).amax();
        let near = |a: &Point3<f64>, b: &Point3<f64>| (a - b).amax() <= reach;
        let mut seams = self.seams.iter();
        seams.any(|[a, b]| near(a, &one) && near(b, &other) || near(a, &other) && near(b, &one))
    }
}

fn unit_normal(shell: &Shell, facet: &[u32]) -> Vector3<f64> {
    let place = |corner: u32| shell.vertices()[corner as usize];
    let arms = facet.windows(2).skip(1).map(|pair| {
        let [one, other] = [pair[0], pair[1]].map(|corner| place(corner) - place(facet[0]));
        one.cross(&other)
    });
    let area: Vector3<f64> = arms.sum();
    area.try_normalize(0.0).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit cube at `x`, its top cut in two along a diagonal.
    fn cube(x: f64) -> ShownCell {
        let corners: Vec<Point3<f64>> = (0..8)
            .map(|k: u32| {
                Point3::new(
                    x + f64::from(k & 1),
                    f64::from(k >> 1 & 1),
                    f64::from(k >> 2),
                )
            })
            .collect();
        let facets: [&[u32]; 7] = [
            &[0, 2, 3, 1],
            &[4, 5, 7],
            &[4, 7, 6],
            &[0, 1, 5, 4],
            &[1, 3, 7, 5],
            &[3, 2, 6, 7],
            &[2, 0, 4, 6],
        ];
        let facets = facets.map(|facet| facet.iter().copied());
        ShownCell {
            site: 0,
            position: Point3::origin(),
            shell: Shell::new(&corners, facets).expect("corners are there"),
            seams: Vec::new(),
        }
    }

    #[test]
    fn seams_get_no_lines_where_parts_meet_along_a_piece_of_an_edge_too() {
        let corners = [
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [0.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        let corners = corners.map(|[x, y]| Point3::new(x, y, 0.0));
        let facets = [vec![0, 1, 2, 3], vec![3, 4, 5, 6]];
        let cell = ShownCell {
            site: 0,
            position: corners[0],
            shell: Shell::new(&corners, facets).expect("corners are there"),
            seams: vec![[corners[2], corners[3]], [corners[3], corners[4]]],
        };
        let smooth = [false, false, true, false, true, false, false, false];
        assert_eq!(smooth_edges(&cell), smooth);
    }

    #[test]
    fn two_cubes_share_a_face_and_a_wall_of_triangles_has_no_line_inside() {
        let grid = QuantizedBox {
            min: Point3::origin(),
            step: Vector3::new(2.0, 1.0, 1.0) / LARGEST,
        };
        let mut faces = SharedFaces::default();
        // The second cube's points are off by rounding.
        faces.push_cell(&cube(0.0), &grid);
        faces.push_cell(&cube(1.0 + 1e-15), &grid);
        assert_eq!(faces.points.len(), 12);
        assert_eq!(faces.owned, [7, 6]);
        assert_eq!(
            faces.neighbors.iter().filter(|&&later| later == 1).count(),
            1
        );
        // One diagonal each, seen from both of its triangles.
        assert_eq!(faces.smooth.iter().filter(|&&smooth| smooth).count(), 4);
        let (ways, order) = faces.ways();
        assert_eq!(ways.iter().filter(|&&way| way == 0).count(), 12);
        assert_eq!(order.len(), 12);
    }

    #[test]
    fn edges_shorter_than_a_step_vanish() {
        let face = [(1, false), (1, true), (2, false), (3, true), (3, true)];
        assert_eq!(
            without_repetitions(&face),
            [(1, true), (2, false), (3, true)]
        );
        let loop_of_one = [(4, false), (4, false)];
        assert!(without_repetitions(&loop_of_one).is_empty());
    }
}
