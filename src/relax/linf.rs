//! Relaxation with L∞ cells: their energies, minimizers and figures, and the objective's gradient.
//!
//! F(x_1 … x_n) = Σ_i ∫_{C_i} d∞(x_i, y)^p dy with L∞ cells is ∫ min_i d∞(x_i, y)^p dy. On a bisector both
//! distances agree, so that moving it costs nothing: ∂F/∂x_i is the gradient of the energy of cell i as it
//! stands, p ∫_{F_−k} d∞^(p−1) − p ∫_{F_+k} d∞^(p−1) along axis k, F_±k its fragments. There are no facet
//! terms as with L2 cells. F is never above the energy of the same sites with L2 cells, and Lloyd's
//! moves never raise it.
//!
//! The domain is convex and has no density. All integrals about the site are closed forms over the cell's
//! cones, and its center is found from its boundary.

use nalgebra::{Point3, Vector3};

use crate::domain::domain::Domain;
use crate::energy::center::{BOUNDARY_FRACTION, Center, CenterSearch};
use crate::energy::faceted::FacetedSolid;
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::moments::Moments;
use crate::geometry::shell::Shell;
use crate::relax::metrics::{ALIGNED, CellMetrics, FACET_SHARE};
use crate::relax::relaxation_space::{CellCrowding, CellResult, EnergySpec, ObjectiveValue};
use crate::voronoi::diagram::{Diagram, DiagramError, StopFlag};
use crate::voronoi::linf::cell::{LinfCell, Ties};

/// The L∞ cells of sites in a domain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinfCells<'a> {
    pub(crate) domain: &'a dyn Domain,
    pub(crate) sites: &'a [Point3<f64>],
    pub(crate) stop: &'a StopFlag,
}

/// Energy, p = 1 energy and gradient of one cell.
struct CellTerms {
    energy: f64,
    chebyshev: f64,
    gradient: Vector3<f64>,
}

impl LinfCells<'_> {
    fn map<Memory: Default, Answer: Send>(
        &self,
        of_cell: impl Fn(&mut Memory, &LinfCell<'_>) -> Answer + Sync,
    ) -> Result<Vec<Answer>, DiagramError> {
        let diagram = Diagram::borrowed(self.domain, self.sites)?.with_stop(self.stop);
        diagram.map_linf(Ties::ToSmallerIndex, |memory, cell| of_cell(memory, &cell))
    }

    fn terms(&self, order: u32) -> Result<Vec<CellTerms>, DiagramError> {
        self.map(|(): &mut (), cell| terms(cell, order))
    }

    /// The sum of the cells' energies of an order.
    pub(crate) fn energy(&self, order: u32) -> Result<f64, DiagramError> {
        Ok(self.terms(order)?.iter().map(|cell| cell.energy).sum())
    }

    /// Every cell's energy and center.
    pub(crate) fn assess(&self, spec: EnergySpec) -> Result<Vec<CellResult<3>>, DiagramError> {
        self.map(|boundary, cell| {
            let about_site = terms(cell, spec.order);
            let center = center(self.domain, boundary, cell, spec);
            CellResult {
                volume: cell.volume(),
                energy: about_site.energy,
                chebyshev: about_site.chebyshev,
                target: limited_step(self.domain, cell, &center.point),
                evaluations: center.evaluations,
            }
        })
    }

    /// The objective with its gradient.
    pub(crate) fn objective(&self, order: u32) -> Result<ObjectiveValue<3>, DiagramError> {
        let terms = self.terms(order)?;
        Ok(ObjectiveValue {
            energy: terms.iter().map(|cell| cell.energy).sum(),
            chebyshev: terms.iter().map(|cell| cell.chebyshev).sum(),
            energy_max: terms.iter().map(|cell| cell.energy).fold(0.0, f64::max),
            gradient: terms.iter().map(|cell| cell.gradient).collect(),
            energies: terms.iter().map(|cell| cell.energy).collect(),
        })
    }

    /// How crowded the cells are.
    pub(crate) fn crowding(&self) -> Result<Vec<CellCrowding<3>>, DiagramError> {
        self.map(|(): &mut (), cell| {
            let mut farthest = Vector3::zeros();
            cell.visit_fragments(|fragment| {
                let corners = fragment.corners.iter();
                farthest = corners.fold(farthest, |farthest, corner| {
                    if corner.amax() > farthest.amax() {
                        *corner
                    } else {
                        farthest
                    }
                });
            });
            CellCrowding {
                energy: terms(cell, 1).energy,
                vertex: self.domain.wrap(&(cell.position + farthest)),
                distance: farthest.amax(),
            }
        })
    }

    /// The figures of the cells.
    pub(crate) fn metrics(&self, spec: EnergySpec) -> Result<Vec<CellMetrics<3>>, DiagramError> {
        self.map(|boundary, cell| metrics(self.domain, boundary, cell, spec))
    }

    /// The share of the domain's volume that is equidistant, equal in `f64`, to several sites.
    pub(crate) fn tied_volume(&self) -> Result<f64, DiagramError> {
        let diagram = Diagram::borrowed(self.domain, self.sites)?.with_stop(self.stop);
        let untied = diagram.map_linf(Ties::Cut, |(): &mut (), cell| cell.volume())?;
        Ok((1.0 - untied.iter().sum::<f64>() / self.domain.volume()).max(0.0))
    }
}

/// Integrates over a cell about its site.
fn terms(cell: &LinfCell<'_>, order: u32) -> CellTerms {
    let fragments = cell
        .integrals(order - 1)
        .map(|part| part * f64::from(order));
    let energy = cell.integrals(order).iter().sum();
    let along = |axis: usize| fragments[2 * axis + 1] - fragments[2 * axis];
    CellTerms {
        energy,
        chebyshev: if order == 1 {
            energy
        } else {
            cell.integrals(1).iter().sum()
        },
        gradient: Vector3::new(along(0), along(1), along(2)),
    }
}

/// Finds the center of a cell of this volume (L³).
fn center(
    domain: &dyn Domain,
    boundary: &mut FacetedSolid,
    cell: &LinfCell<'_>,
    spec: EnergySpec,
) -> Center<3> {
    boundary.clear();
    cell.visit_boundary(|_, corners| boundary.push(corners));
    let volume = cell.volume();
    let search = CenterSearch {
        minimizer: spec.minimizer,
        order: spec.order,
        volume,
        mass: volume,
        bounds: site_bounds(domain, cell),
    };
    search.center(|center| boundary.energy(center, spec.order))
}

/// The box in which the center is sought, relative to the site: around its cell and within the domain's.
fn site_bounds(domain: &dyn Domain, cell: &LinfCell<'_>) -> Bounds<3> {
    let (mut within, periods) = (domain.bounds(), domain.periods());
    for axis in (0..3).filter(|&axis| periods[axis].is_some()) {
        (within.min[axis], within.max[axis]) = (f64::NEG_INFINITY, f64::INFINITY);
    }
    let within = within.translated(&-cell.position.coords);
    let mut bounds = cell.bounds().intersection(&within);
    // Rounding may put a wall on the wrong side of a site that touches it.
    bounds.include(&Point3::origin());
    bounds
}

/// The site after `step`, or after [`BOUNDARY_FRACTION`] of the way to where the straight line first
/// leaves the cell. Energy is convex, also if the cell is not, so it falls all along the line.
fn limited_step(domain: &dyn Domain, cell: &LinfCell<'_>, step: &Vector3<f64>) -> Point3<f64> {
    let share = cell.share_within(step);
    let share = if share < 1.0 {
        (BOUNDARY_FRACTION * share).max(0.0)
    } else {
        1.0
    };
    let place = domain.wrap(&(cell.position + step * share));
    if domain.contains(&place) {
        place
    } else {
        // By rounding.
        let inside = domain.wrap(&(cell.position + step * (BOUNDARY_FRACTION * share)));
        if domain.contains(&inside) {
            inside
        } else {
            cell.position
        }
    }
}

/// The figures of a cell.
fn metrics(
    domain: &dyn Domain,
    boundary: &mut FacetedSolid,
    cell: &LinfCell<'_>,
    spec: EnergySpec,
) -> CellMetrics<3> {
    let (about_site, moments) = (terms(cell, spec.order), moments(cell));
    let (volume, center) = (moments.mass, center(domain, boundary, cell, spec));
    let overlap = cell.volume_within(0.5 * volume.cbrt());
    let (mut aligned, mut area, mut facets) = (0.0, 0.0, 0);
    for vector in cell.facet_areas().into_values() {
        let of_facet = vector.norm();
        area += of_facet;
        aligned += if vector.amax() >= ALIGNED * of_facet {
            of_facet
        } else {
            0.0
        };
        facets += u32::from(of_facet > FACET_SHARE * volume.cbrt().powi(2));
    }
    CellMetrics {
        volume,
        centroid: domain.wrap(&(cell.position + moments.centroid().coords)),
        energy: about_site.energy,
        gradient: about_site.gradient,
        center: domain.wrap(&(cell.position + center.point)),
        center_energy: center.energy,
        facets,
        chebyshev: about_site.chebyshev,
        relative_density: 1.0,
        cubeness: overlap / (2.0 * volume - overlap),
        axis_aligned: if area > 0.0 { aligned / area } else { 0.0 },
    }
}

/// Volume and its moments about the site.
fn moments(cell: &LinfCell<'_>) -> Moments {
    let mut moments = Moments::default();
    cell.visit_fragments(|fragment| {
        for pair in fragment.corners[1..].windows(2) {
            moments.add_cone([fragment.corners[0], pair[0], pair[1]]);
        }
    });
    moments
}

/// The surface of a cell, in the domain's coordinates, for files and pictures: its merged facets, or where
/// rounding keeps those from closing, the fragments that they are made of.
pub(crate) fn linf_shell(cell: &LinfCell<'_>) -> Shell {
    let shell = match cell.outline() {
        Some(outline) => Shell::from(Piece::Brep(&outline)),
        None => loose_shell(cell),
    };
    shell.translated(&cell.position.coords)
}

fn loose_shell(cell: &LinfCell<'_>) -> Shell {
    let (mut vertices, mut facets) = (Vec::new(), Vec::new());
    cell.visit_boundary(|_, corners| {
        let first = vertices.len() as u32;
        vertices.extend(corners.iter().map(|&corner| Point3::from(corner)));
        facets.push(first..vertices.len() as u32);
    });
    // The facets name these vertices only.
    Shell::new(&vertices, facets).unwrap_or_default()
}
