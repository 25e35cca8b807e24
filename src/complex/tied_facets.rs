//! The neighbors beyond facets of L∞ cells where more than two sites are equally far.
//!
//! Where sites share a coordinate, whole regions are tied and belong to the smaller index. Such a cell may end where
//! its site's distance changes its axis, and does not know who is beyond; and of several sites that claim what is
//! beyond a facet, a cell names one. Facets toward which their neighbors have no such facet are parted by what
//! lies on them from the other side.

use std::collections::HashMap;

use crate::complex::facet_overlap::overlap;
use crate::complex::grid_facets::{Coverage, GridCell, GridFacet, PlaneKey, moved_plane};
use crate::complex::grid_lines::Place;
use crate::domain::facet_kind::FacetKind;
use crate::parallel::map;

/// An image of a cell: its site and whole periods.
type CellImage = (u32, [i8; 3]);

/// A facet as the image of a cell has it.
#[derive(Debug)]
struct FacetImage {
    cell: CellImage,
    edges: Vec<[Place; 2]>,
    /// The lowest and the highest coordinates.
    bounds: [Place; 2],
}

/// Facets by their planes.
type FacetsInPlanes = HashMap<PlaneKey, Vec<FacetImage>>;

/// Parts all facets by who is beyond; none where what lies on a facet does not cover it. `periods` are those of
/// the box, zero along axes without.
pub(crate) fn name_tied(cells: &mut [GridCell], periods: &Place) -> Option<()> {
    if !cells.iter().any(|cell| cell.is_tied) {
        return Some(());
    }
    let doubtful = map(cells.len(), &|site| {
        let is_agreed = |facet: &GridFacet| is_agreed(cells, site as u32, facet, periods);
        let facets = cells[site].facets();
        facets.filter(|facet| !is_agreed(facet)).collect::<Vec<_>>()
    });
    let around = images(&doubtful, periods);
    let parted = map(cells.len(), &|site| {
        let parts = doubtful[site].iter();
        let parts = parts.map(|facet| parts_of(site as u32, facet, &around));
        let parts = parts.collect::<Option<Vec<_>>>()?;
        Some(parts.into_iter().flatten().collect::<Vec<GridFacet>>())
    });
    for (site, parts) in parted.into_iter().enumerate() {
        let (doubtful, parts) = (&doubtful[site], parts?);
        if doubtful.is_empty() {
            continue;
        }
        let key = |facet: &GridFacet| (facet.label, facet.plane);
        let facets = cells[site].facets();
        let mut facets: Vec<GridFacet> = facets
            .filter(|facet| !doubtful.iter().any(|other| key(other) == key(facet)))
            .collect();
        facets.extend(parts);
        cells[site] = GridCell::new(&facets, cells[site].is_tied);
    }
    Some(())
}

/// Whether the neighbor beyond a facet has the same one.
fn is_agreed(cells: &[GridCell], site: u32, facet: &GridFacet, periods: &Place) -> bool {
    let (other, image) = match FacetKind::of(facet.label) {
        FacetKind::Neighbor { site, image } => (site, image),
        FacetKind::Wall(_) => return true,
        FacetKind::Inner => return false,
    };
    let back = image.map(|periods| -periods);
    let label = FacetKind::Neighbor { site, image: back }.label();
    let plane = moved_plane(facet.plane, &moved([0; 3], back, periods));
    let same = cells[other as usize].facet_of(label, plane);
    // Edges are as long as they can be on both sides.
    let back = |&[from, to]: &[Place; 2]| [to, from].map(|at| moved(at, image, periods));
    same.is_some_and(|same| {
        let mut edges: Vec<_> = same.edges.iter().map(back).collect();
        let mut own = facet.edges.clone();
        edges.sort_unstable();
        own.sort_unstable();
        edges == own
    })
}

fn moved(at: Place, image: [i8; 3], periods: &Place) -> Place {
    [0, 1, 2].map(|axis| at[axis] + i64::from(image[axis]) * periods[axis])
}

/// The facets and their nearest images, by their planes.
fn images(facets: &[Vec<GridFacet>], periods: &Place) -> FacetsInPlanes {
    let is_there = |image: &[i8; 3]| (0..3).all(|axis| image[axis] == 0 || periods[axis] > 0);
    let around = (0..27).map(|number| [number % 3, number / 3 % 3, number / 9]);
    let around = around.map(|image| image.map(|part| part as i8 - 1));
    let shifts: Vec<[i8; 3]> = around.filter(is_there).collect();
    let mut images = FacetsInPlanes::new();
    let facets = (0..).zip(facets);
    let facets = facets.flat_map(|(site, facets)| facets.iter().map(move |facet| (site, facet)));
    for (site, facet) in facets {
        for &image in &shifts {
            let by = moved([0; 3], image, periods);
            let edges = facet.edges.iter();
            let edges: Vec<_> = edges
                .map(|edge| edge.map(|at| moved(at, image, periods)))
                .collect();
            let plane = images.entry(moved_plane(facet.plane, &by)).or_default();
            plane.push(FacetImage {
                cell: (site, image),
                bounds: bounds_of(&edges),
                edges,
            });
        }
    }
    images
}

fn bounds_of(edges: &[[Place; 2]]) -> [Place; 2] {
    let starts = || edges.iter().map(|edge| edge[0]);
    let low = |one: Place, other: Place| [0, 1, 2].map(|axis| one[axis].min(other[axis]));
    let high = |one: Place, other: Place| [0, 1, 2].map(|axis| one[axis].max(other[axis]));
    [starts().reduce(low), starts().reduce(high)].map(Option::unwrap_or_default)
}

/// The parts of a facet by the cells beyond it; none if something is left.
fn parts_of(site: u32, facet: &GridFacet, around: &FacetsInPlanes) -> Option<Vec<GridFacet>> {
    let mut parts = Vec::new();
    let mut rest = Coverage::default();
    facet.edges.iter().try_for_each(|edge| rest.add(edge, 1))?;
    let [low, high] = bounds_of(&facet.edges);
    let near = around.get(&facet.plane)?.iter().filter(|beyond| {
        let [other_low, other_high] = beyond.bounds;
        beyond.cell != (site, [0; 3])
            && (0..3).all(|axis| low[axis] <= other_high[axis] && other_low[axis] <= high[axis])
    });
    for beyond in near {
        let (other, image) = beyond.cell;
        let label = FacetKind::Neighbor { site: other, image }.label();
        for edges in overlap(facet.plane, [&facet.edges, &beyond.edges])? {
            if !edges.is_empty() {
                edges.iter().try_for_each(|edge| rest.add(edge, -1))?;
                parts.push(GridFacet::new(label, facet.plane, edges));
            }
        }
    }
    rest.edges()?.is_empty().then_some(parts)
}
