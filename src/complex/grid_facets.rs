//! Facets of L∞ cells on their grid: polygons of one neighbor in one plane, whose edges add up.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::complex::grid_lines::{
    DIRECTIONS, LineKey, Place, direction_of, line_through, place_on,
};
use crate::geometry::label::Label;

/// The normals of planes, up to their sign: the directions with a component that is zero.
const NORMALS: &[Place] = DIRECTIONS.split_at(9).0;

/// A plane: its normal's number, and its offset in half steps.
pub(crate) type PlaneKey = (u8, i64);

/// A facet: what is beyond, its plane and outward normal, and its directed edges.
#[derive(Clone, Debug)]
pub(crate) struct GridFacet {
    pub(crate) label: Label,
    pub(crate) plane: PlaneKey,
    pub(crate) normal: Place,
    pub(crate) edges: Vec<[Place; 2]>,
}

/// The facets of a cell, packed: edges by the numbers of its vertices.
#[derive(Clone, Debug)]
pub(crate) struct GridCell {
    places: Box<[Place]>,
    facets: Box<[PackedFacet]>,
    edges: Box<[[u32; 2]]>,
    /// Whether its site has the coordinate of another one nearby.
    pub(crate) is_tied: bool,
}

/// A facet, whose edges end where those of the next one begin.
#[derive(Clone, Copy, Debug)]
struct PackedFacet {
    label: Label,
    plane: PlaneKey,
    is_turned: bool,
    end: u32,
}

/// Signed edges in a plane: on each of its lines where they begin and end, and how many.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coverage(BTreeMap<LineKey, BTreeMap<i64, i32>>);

/// Polygons by what is beyond and by plane.
#[derive(Clone, Debug, Default)]
pub(crate) struct Polygons(BTreeMap<(Label, PlaneKey), Coverage>);

impl Coverage {
    /// Adds an edge `times`; none if it is along none of the grid's directions.
    pub(crate) fn add(&mut self, [from, to]: &[Place; 2], times: i32) -> Option<()> {
        if from == to {
            return Some(());
        }
        let (number, sign) = direction_of(from, to)?;
        let [(key, start), (_, end)] =
            [from, to].map(|at| line_through(at, number, &DIRECTIONS[usize::from(number)]));
        let line = self.0.entry(key).or_default();
        *line.entry(start.min(end)).or_default() += sign * times;
        *line.entry(start.max(end)).or_default() -= sign * times;
        Some(())
    }

    /// What is left of the edges; none if some lie on each other.
    pub(crate) fn edges(&self) -> Option<Vec<[Place; 2]>> {
        let mut edges = Vec::new();
        for (key, line) in &self.0 {
            let (mut sign, mut since) = (0, 0);
            for (&along, change) in line.iter().filter(|(_, change)| **change != 0) {
                match sign {
                    0 => {}
                    1 => edges.push([since, along].map(|along| place_on(key, along))),
                    -1 => edges.push([along, since].map(|along| place_on(key, along))),
                    _ => return None,
                }
                (sign, since) = (sign + change, along);
            }
        }
        Some(edges)
    }
}

impl Polygons {
    /// Adds a polygon; none if it is not in a plane of the grid.
    pub(crate) fn add(&mut self, label: Label, places: &[Place]) -> Option<()> {
        let mut through = (0..).zip(NORMALS).filter(|(_, normal)| {
            let offset = offset(normal, &places[0]);
            places.iter().all(|at| self::offset(normal, at) == offset)
        });
        let (number, normal) = through.next()?;
        if through.next().is_some() {
            // All corners are on a line.
            return Some(());
        }
        let plane = (number, offset(normal, &places[0]));
        let coverage = self.0.entry((label, plane)).or_default();
        let mut edges = places.iter().zip(places.iter().cycle().skip(1));
        edges.try_for_each(|(from, to)| coverage.add(&[*from, *to], 1))
    }

    /// The facets that are left; none if polygons overlap.
    pub(crate) fn facets(&self) -> Option<Vec<GridFacet>> {
        let facets = self.0.iter().map(|(&(label, plane), coverage)| {
            let edges = coverage.edges()?;
            Some(GridFacet::new(label, plane, edges))
        });
        let facets =
            facets.filter(|facet| facet.as_ref().is_none_or(|facet| !facet.edges.is_empty()));
        facets.collect()
    }
}

impl GridFacet {
    /// The facet with these edges, its normal such that its area is positive.
    pub(crate) fn new(label: Label, plane: PlaneKey, edges: Vec<[Place; 2]>) -> Self {
        let mut normal = NORMALS[usize::from(plane.0)];
        if doubled_area(&edges, &normal) < 0.0 {
            normal = normal.map(|along| -along);
        }
        Self {
            label,
            plane,
            normal,
            edges,
        }
    }
}

impl GridCell {
    /// A cell with these facets.
    pub(crate) fn new(facets: &[GridFacet], is_tied: bool) -> Self {
        let edges = || facets.iter().flat_map(|facet| &facet.edges);
        let mut places: Vec<Place> = edges().map(|edge| edge[0]).collect();
        places.sort_unstable();
        places.dedup();
        // Edges of a facet are closed: all their ends are starts.
        let number = |at: &Place| places.binary_search(at).unwrap_or_default() as u32;
        let mut end = 0;
        let packed = facets.iter().map(|facet| {
            end += facet.edges.len() as u32;
            PackedFacet {
                label: facet.label,
                plane: facet.plane,
                is_turned: facet.normal != normal_of(facet.plane),
                end,
            }
        });
        Self {
            facets: packed.collect(),
            edges: edges().map(|edge| edge.each_ref().map(number)).collect(),
            places: places.into(),
            is_tied,
        }
    }

    /// The places of its vertices, in their order.
    pub(crate) fn places(&self) -> &[Place] {
        &self.places
    }

    /// All edges, once for every facet.
    pub(crate) fn edges(&self) -> impl Iterator<Item = [Place; 2]> {
        let place = |number: u32| self.places[number as usize];
        self.edges.iter().map(move |edge| edge.map(place))
    }

    /// The facets in their order.
    pub(crate) fn facets(&self) -> impl Iterator<Item = GridFacet> {
        (0..self.facets.len()).map(|number| self.facet(number))
    }

    /// The facet of a label in a plane.
    pub(crate) fn facet_of(&self, label: Label, plane: PlaneKey) -> Option<GridFacet> {
        let mut facets = self.facets.iter();
        let number = facets.position(|facet| (facet.label, facet.plane) == (label, plane))?;
        Some(self.facet(number))
    }

    fn facet(&self, number: usize) -> GridFacet {
        let PackedFacet {
            label,
            plane,
            is_turned,
            end,
        } = self.facets[number];
        let start = number
            .checked_sub(1)
            .map_or(0, |before| self.facets[before].end);
        let place = |number: u32| self.places[number as usize];
        let edges = self.edges[start as usize..end as usize].iter();
        let normal = normal_of(plane);
        GridFacet {
            label,
            plane,
            normal: if is_turned {
                normal.map(|along| -along)
            } else {
                normal
            },
            edges: edges.map(|edge| edge.map(place)).collect(),
        }
    }
}

/// The normal of a plane, up to its sign.
pub(crate) fn normal_of((number, _): PlaneKey) -> Place {
    NORMALS[usize::from(number)]
}

/// The offset of a place along a normal.
fn offset(normal: &Place, at: &Place) -> i64 {
    (0..3).map(|axis| normal[axis] * at[axis]).sum()
}

/// How far a plane is moved by a displacement.
pub(crate) fn moved_plane(plane: PlaneKey, by: &Place) -> PlaneKey {
    (plane.0, plane.1 + offset(&normal_of(plane), by))
}

/// The area within edges along a normal, up to a positive factor.
fn doubled_area(edges: &[[Place; 2]], normal: &Place) -> f64 {
    let Some([origin, _]) = edges.first() else {
        return 0.0;
    };
    let arm = |at: &Place| Vector3::from([0, 1, 2].map(|k| (at[k] - origin[k]) as f64));
    let normal = Vector3::from(normal.map(|along| along as f64));
    let areas = edges
        .iter()
        .map(|[from, to]| normal.dot(&arm(from).cross(&arm(to))));
    areas.sum()
}
