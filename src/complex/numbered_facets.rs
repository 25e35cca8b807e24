//! Facets of cells as directed edges between numbered vertices, and the polygons that they make up.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::complex::loop_corner::LoopCorner;
use crate::complex::loops::CellLoops;
use crate::complex::vertex_key::Shift;
use crate::domain::facet_kind::FacetKind;
use crate::geometry::facet_polygons::polygons;
use crate::geometry::label::Label;
use crate::parallel::map;

/// A plane facet of any shape: what is beyond, its outward normal, and its directed edges, counter-clockwise
/// from outside.
#[derive(Clone, Debug)]
pub(crate) struct NumberedFacet {
    pub(crate) label: Label,
    pub(crate) normal: Vector3<f64>,
    pub(crate) edges: Vec<[LoopCorner; 2]>,
}

/// The polygons of a cell with these facets, of vertices at `positions`.
pub(crate) fn loops_of(
    facets: &[NumberedFacet],
    positions: &[Point3<f64>],
    periods: &Vector3<f64>,
) -> CellLoops {
    let mut loops = CellLoops::default();
    for facet in facets {
        let mut corners: Vec<LoopCorner> = facet.edges.iter().map(|edge| edge[0]).collect();
        corners.sort_unstable();
        corners.dedup();
        let number = |corner: &LoopCorner| corners.binary_search(corner).unwrap_or_default() as u32;
        let edges: Vec<_> = (facet.edges.iter())
            .map(|edge| edge.each_ref().map(number))
            .collect();
        let place = |corner: &LoopCorner| corner.position(positions, periods).coords;
        let vertices: Vec<_> = corners.iter().map(place).collect();
        for ring in polygons(&edges, &vertices, &facet.normal) {
            loops.push_as_is(
                facet.label,
                ring.iter().map(|&number| corners[number as usize]),
            );
        }
    }
    loops
}

/// Whether all faces have the same edges from both sides.
pub(crate) fn is_paired(cells: &[CellLoops]) -> bool {
    map(cells.len(), &|site| is_paired_at(cells, site as u32))
        .into_iter()
        .all(|is_paired| is_paired)
}

/// Whether the faces of a cell have the same edges from both sides: those that others have and it has not
/// are found by them.
fn is_paired_at(cells: &[CellLoops], site: u32) -> bool {
    let mut neighbors: BTreeMap<(u32, Shift), BTreeMap<[LoopCorner; 2], i32>> = BTreeMap::new();
    let mut add = |neighbor, corners: &[LoopCorner], by: Shift| {
        let edges = neighbors.entry(neighbor).or_default();
        for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let [from, to] = [from, to].map(|corner| corner.shifted(by));
            // From the other side an edge runs back.
            let turn = if from < to { 1 } else { -1 };
            *edges.entry([from.min(to), from.max(to)]).or_default() += turn;
        }
    };
    let own = |(label, corners)| match FacetKind::of(label) {
        FacetKind::Neighbor { site, image } => Some((site, image.map(i16::from), corners)),
        _ => None,
    };
    let facets = |site: u32| cells[site as usize].facets().filter_map(own);
    let mut seen: Vec<(u32, Shift)> = Vec::new();
    for (other, image, corners) in facets(site) {
        add((other, image), corners, [0; 3]);
        seen.push((other, image));
    }
    seen.sort_unstable();
    seen.dedup();
    for (other, image) in seen {
        let back = image.map(|periods| -periods);
        for (_, _, corners) in facets(other).filter(|facet| (facet.0, facet.1) == (site, back)) {
            add((other, image), corners, image);
        }
    }
    let mut sums = neighbors.values().flat_map(BTreeMap::values);
    sums.all(|sum| *sum == 0)
}
