//! The invariants of a tessellation: Σ volume, facets from both sides, Euler's formula.
//!
//! Σ volumes alone certifies little: a facet that one cell has and its neighbor lacks moves volume
//! from one to the other. So every facet between two cells is compared from both sides as well.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::Vector3;
use thiserror::Error;

use crate::arrays::MapEach;
use crate::domain::domain::Domain;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::integrals::pairwise::sum_by_halves;
use crate::voronoi::cell::Cell;
use crate::voronoi::diagram::{Diagram, DiagramError};

/// How closely volumes must add up, relative to the domain's.
const VOLUME_AGREES: f64 = 1e-12;

/// The areas of a facet from both sides may differ by this share of the square of the mean cell's
/// side: each cell computes its vertices anew, from planes that may be nearly parallel.
const AREA_AGREES: f64 = 1e-7;

/// Why cells do not form a tessellation of their domain. Indices count from zero.
///
/// # Examples
/// ```
/// use chebloyd::{CheckError, Cuboid, Diagram};
///
/// let cube = Cuboid::unit();
/// let twice = Diagram::new(&cube, &[[0.5; 3]; 2])?.check();
/// assert!(matches!(twice, Err(CheckError::Diagram(_))));
/// # Ok::<(), chebloyd::DiagramError>(())
/// ```
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CheckError {
    /// The sites have no diagram.
    #[error(transparent)]
    Diagram(#[from] DiagramError),
    /// The cells' volumes do not add up to the domain's.
    #[error("the cells' volumes sum to {sum}, the domain's is {domain}")]
    Volume {
        /// The sum over all cells (L³).
        sum: f64,
        /// The domain's volume (L³).
        domain: f64,
    },
    /// A cell's volume is negative or not a number.
    #[error("the cell of site {site} has the volume {volume}")]
    Cell {
        /// The cell's site.
        site: usize,
        /// Its volume (L³).
        volume: f64,
    },
    /// The facet between two cells is not the same from both sides.
    #[error(
        "the facet between the cells of sites {site} and {neighbor} has the area {area}, and {area_back} from the other side"
    )]
    Facet {
        /// A site.
        site: usize,
        /// Its neighbor.
        neighbor: usize,
        /// The area of the facet of the site's cell (L²); zero if there is none.
        area: f64,
        /// The area of the facet of the neighbor's cell (L²).
        area_back: f64,
    },
    /// The vertices V, edges E and facets F of a cell's polyhedron break V − E + F = 2.
    #[error(
        "the cell of site {site} has {vertices} vertices, {edges} edges and {facets} facets, against Euler's formula"
    )]
    Euler {
        /// The cell's site.
        site: usize,
        /// V.
        vertices: usize,
        /// E.
        edges: usize,
        /// F.
        facets: usize,
    },
}

/// The counts and measures of one cell that the invariants compare.
struct CellSummary {
    volume: f64,
    /// V, E and F of the polyhedron.
    counts: [usize; 3],
    /// Neighbor, its periodic image, and the area of the facet towards it (L²).
    facets: Vec<(u32, [i8; 3], f64)>,
}

impl Diagram<'_> {
    /// Builds every cell and tests the invariants of a tessellation: no volume is negative, the
    /// volumes add up to the domain's to 1e-12, every facet between two cells has the same area from
    /// both sides (to 1e-7 of the square of the mean cell's side), and every cell's polyhedron obeys
    /// V − E + F = 2.
    ///
    /// # Errors
    /// [`CheckError`] for the first invariant that does not hold, by site.
    ///
    /// # Examples
    /// ```
    /// use chebloyd::{Cuboid, Diagram};
    ///
    /// let sites = [[0.2, 0.3, 0.4], [0.7, 0.6, 0.5]];
    /// let cube = Cuboid::unit();
    /// Diagram::new(&cube, &sites)?.check()?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn check(&self) -> Result<(), CheckError> {
        let domain = self.domain();
        let cells =
            self.map(|scratch: &mut PieceScratch, cell| summarize(domain, &cell, scratch))?;
        check_cells(&cells)?;
        let volumes =
            |range: Range<usize>| cells[range].iter().map(|cell| cell.volume).sum::<f64>();
        let sum = sum_by_halves(cells.len(), &volumes);
        if (sum - domain.volume()).abs() > VOLUME_AGREES * domain.volume() {
            let domain = domain.volume();
            return Err(CheckError::Volume { sum, domain });
        }
        let side_squared = (domain.volume() / cells.len() as f64).powf(2.0 / 3.0);
        check_facets(&cells, AREA_AGREES * side_squared)
    }
}

/// Measures a cell, its part in the domain by signed pieces.
fn summarize(domain: &dyn Domain, cell: &Cell<'_>, scratch: &mut PieceScratch) -> CellSummary {
    let polyhedron = cell.polyhedron();
    let corners = polyhedron.facets().map(|f| f.vertex_numbers().count());
    let (facet_count, sides) =
        corners.fold((0, 0), |(count, sides), more| (count + 1, sides + more));
    let mut volume = 0.0;
    let mut areas: BTreeMap<u64, Vector3<f64>> = BTreeMap::new();
    domain.pieces(&cell.position, polyhedron, scratch, &mut |sign, part| {
        volume += sign * part.extent().volume;
        part.visit_facets(|label, _, area| *areas.entry(label).or_default() += area * sign);
    });
    let neighbor = |(label, area): (u64, Vector3<f64>)| match FacetKind::of(label) {
        FacetKind::Neighbor { site, image } => Some((site, image, area.norm())),
        FacetKind::Wall(_) | FacetKind::Inner => None,
    };
    CellSummary {
        volume,
        counts: [polyhedron.vertex_count(), sides / 2, facet_count],
        facets: areas.into_iter().filter_map(neighbor).collect(),
    }
}

/// Tests volumes and Euler's formula, cell by cell.
fn check_cells(cells: &[CellSummary]) -> Result<(), CheckError> {
    for (site, cell) in cells.iter().enumerate() {
        let [vertices, edges, facets] = cell.counts;
        if vertices + facets != edges + 2 {
            return Err(CheckError::Euler {
                site,
                vertices,
                edges,
                facets,
            });
        }
        let volume = cell.volume;
        if !(volume >= 0.0 && volume.is_finite()) {
            return Err(CheckError::Cell { site, volume });
        }
    }
    Ok(())
}

/// Compares the facets between cells from both sides.
fn check_facets(cells: &[CellSummary], tolerance: f64) -> Result<(), CheckError> {
    for (site, cell) in cells.iter().enumerate() {
        for &(neighbor, image, area) in &cell.facets {
            let opposite = (site as u32, image.map_each(|periods| -periods));
            let facets = cells[neighbor as usize].facets.iter();
            let back = facets
                .filter(|(other, image, _)| (*other, *image) == opposite)
                .map(|(.., area)| area);
            let area_back: f64 = back.sum();
            if (area - area_back).abs() > tolerance {
                return Err(CheckError::Facet {
                    site,
                    neighbor: neighbor as usize,
                    area,
                    area_back,
                });
            }
        }
    }
    Ok(())
}
