//! The boundary of an L∞ cell with its fragments merged: one facet per neighbor and plane.
//!
//! Corners are welded and put on all edges that they lie on. In each plane the edges between two
//! fragments then run both ways and cancel, and what is left bounds the facet: of any shape, perhaps in
//! several components. Where regions are tied a cell may also end between two cones; such facets lie in
//! the planes of their common sides, which cancel elsewhere.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::arrays::MapEach;
use crate::geometry::brep::{Brep, Edge};
use crate::geometry::half_space::HalfSpace;
use crate::voronoi::linf::cell::LinfCell;
use crate::voronoi::linf::facet_key::FacetKey;

/// Corners nearer to each other or to an edge than this share of the cell's size are on it: far above
/// the rounding of coordinates.
const WELD: f64 = 1e-12;

/// What a facet is made of: all fragments of one label in one plane.
#[derive(Clone, Debug, Default)]
struct Group {
    /// Twice the sum of area vectors (L²), and of their lengths' greatest term.
    doubled_area: Vector3<f64>,
    largest: Vector3<f64>,
    point: Vector3<f64>,
    /// How often a directed edge runs that way more than the other.
    edges: BTreeMap<[u32; 2], u32>,
}

impl Group {
    /// Adds a directed edge, or cancels the one that runs back.
    fn add_edge(&mut self, [from, to]: [u32; 2]) {
        match self.edges.get_mut(&[to, from]) {
            Some(count) if *count > 1 => *count -= 1,
            Some(_) => drop(self.edges.remove(&[to, from])),
            None => *self.edges.entry([from, to]).or_insert(0) += 1,
        }
    }

    fn plane(&self) -> HalfSpace {
        let normal = self.largest.try_normalize(0.0).unwrap_or_default();
        // Sides of cones may face either way.
        let normal = if self.doubled_area.dot(&normal) < 0.0 {
            -normal
        } else {
            normal
        };
        HalfSpace {
            offset: normal.dot(&self.point),
            normal,
        }
    }
}

/// The corners of all polygons, welded.
#[derive(Debug, Default)]
struct WeldedCorners {
    /// Sorted along x.
    places: Vec<Vector3<f64>>,
    reach: f64,
}

impl WeldedCorners {
    fn new(mut corners: Vec<Vector3<f64>>) -> Self {
        let extent = corners.iter().map(Vector3::amax).fold(0.0, f64::max);
        let mut welded = Self {
            places: Vec::new(),
            reach: WELD * extent,
        };
        corners.sort_by(|a, b| {
            (a.x, a.y, a.z)
                .partial_cmp(&(b.x, b.y, b.z))
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        for corner in corners {
            if welded.number(&corner).is_none() {
                welded.places.push(corner);
            }
        }
        welded
    }

    /// The numbers of the places with x in a range.
    fn between(&self, low: f64, high: f64) -> std::ops::Range<usize> {
        let first = self
            .places
            .partition_point(|place| place.x < low - self.reach);
        let end = self
            .places
            .partition_point(|place| place.x <= high + self.reach);
        first..end.max(first)
    }

    fn number(&self, corner: &Vector3<f64>) -> Option<u32> {
        let mut near = self.between(corner.x, corner.x);
        near.find(|&n| (self.places[n] - corner).amax() <= self.reach)
            .map(|n| n as u32)
    }

    /// The places along an edge, its ends among them, in order. Between two that follow each other lies
    /// none, measured from their own edge, so that all edges through both have the same ones there.
    fn along(&self, [from, to]: [u32; 2]) -> Vec<u32> {
        let (mut places, mut stack) = (vec![from.min(to)], vec![from.max(to)]);
        while let (Some(&here), Some(&end)) = (places.last(), stack.last()) {
            let mut inner = self.strictly_between([here, end]);
            // Places nearly as near to each other as the reach might follow each other for ever.
            inner.retain(|place| !places.contains(place) && !stack.contains(place));
            if inner.is_empty() {
                places.push(end);
                stack.pop();
            } else {
                stack.extend(inner.iter().rev());
            }
        }
        if from > to {
            places.reverse();
        }
        places
    }

    /// The places on the edge between two others, in order.
    fn strictly_between(&self, [from, to]: [u32; 2]) -> Vec<u32> {
        let [a, b] = [from, to].map_each(|n| self.places[n as usize]);
        let (way, square) = (b - a, (b - a).norm_squared());
        let share = |n: &usize| (self.places[*n] - a).dot(&way) / square;
        let is_on = |n: &usize| {
            let share = share(n);
            let off = self.places[*n] - a - way * share;
            share > 0.0 && share < 1.0 && off.amax() <= self.reach
        };
        let is_other = |n: &usize| *n != from as usize && *n != to as usize;
        let range = self.between(a.x.min(b.x), a.x.max(b.x));
        let mut inner: Vec<usize> = range.filter(is_other).filter(is_on).collect();
        inner.sort_by(|one, other| share(one).total_cmp(&share(other)));
        inner.into_iter().map(|n| n as u32).collect()
    }
}

impl LinfCell<'_> {
    /// The boundary, relative to the site; `None` where its edges do not run once each way.
    pub(crate) fn outline(&self) -> Option<Brep> {
        let mut polygons = Vec::new();
        self.visit_boundary(|key, corners| polygons.push((key, corners.to_vec())));
        merged(&polygons)
    }

    /// The boundary of the part in a cone, in the same way.
    pub(crate) fn cone_outline(&self, number: usize) -> Option<Brep> {
        let mut polygons = Vec::new();
        self.visit_cone(number, |key, fragment, _| {
            polygons.push((key, fragment.corners.clone()));
        });
        merged(&polygons)
    }
}

/// The solid with this boundary, the polygons of each facet merged.
fn merged(polygons: &[(FacetKey, Vec<Vector3<f64>>)]) -> Option<Brep> {
    let corners = polygons
        .iter()
        .flat_map(|(_, corners)| corners.iter().copied());
    let welded = WeldedCorners::new(corners.collect());
    let mut groups: BTreeMap<FacetKey, Group> = BTreeMap::new();
    for (key, corners) in polygons {
        let group = groups.entry(*key).or_default();
        let arm = |n: usize| corners[n] - corners[0];
        let doubled: Vector3<f64> = (2..corners.len()).map(|n| arm(n - 1).cross(&arm(n))).sum();
        if doubled.norm_squared() > group.largest.norm_squared() {
            (group.largest, group.point) = (doubled, corners[0]);
        }
        group.doubled_area += doubled;
        let numbers: Vec<u32> = corners.iter().filter_map(|at| welded.number(at)).collect();
        let next = numbers.iter().cycle().skip(1);
        for (from, to) in numbers.iter().zip(next).filter(|(from, to)| from != to) {
            for pair in welded.along([*from, *to]).windows(2) {
                group.add_edge([pair[0], pair[1]]);
            }
        }
    }
    assemble(welded.places, groups)
}

/// The solid whose facets are the groups.
fn assemble(places: Vec<Vector3<f64>>, groups: BTreeMap<FacetKey, Group>) -> Option<Brep> {
    let mut brep = Brep::default();
    let mut facets: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for ((label, ..), group) in &groups {
        if group.edges.is_empty() {
            continue;
        }
        let facet = brep.facets.len() as u32;
        brep.facets.push((group.plane(), *label));
        for (edge, count) in &group.edges {
            let left = facets.entry(*edge).or_default();
            left.extend((0..*count).map(|_| facet));
        }
    }
    for (&[from, to], left) in &facets {
        let right = facets.get(&[to, from])?;
        if left.len() != right.len() {
            return None;
        }
        if from < to {
            let pairs = left.iter().zip(right);
            (brep.edges).extend(pairs.map(|(left, right)| Edge::new([from, to], [*left, *right])));
        }
    }
    brep.vertices = places;
    Some(brep)
}
