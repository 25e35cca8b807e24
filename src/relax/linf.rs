//! Relaxation with L∞ cells: their energies, minimizers and figures, and the objective's gradient.
//!
//! F(x_1 … x_n) = Σ_i ∫_{C_i} ρ d∞(x_i, y)^p dy with L∞ cells is ∫ ρ min_i d∞(x_i, y)^p dy. On a bisector both
//! distances agree, so that moving it costs nothing: ∂F/∂x_i is the gradient of the energy of cell i as it
//! stands, p ∫_{F_−k} ρ d∞^(p−1) − p ∫_{F_+k} ρ d∞^(p−1) along axis k, F_±k its fragments. There are no facet
//! terms as with L2 cells. F is never above the energy of the same sites with L2 cells, and Lloyd's
//! moves never raise it.

use std::borrow::Cow;

use nalgebra::{Point3, Rotation3, Vector3};

use crate::arrays::MapEach;
use crate::domain::convex::ConvexPolyhedron;
use crate::domain::domain::Domain;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::geometry::brep::Piece;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::shell::Shell;
use crate::relax::linf_cell::{LinfCellInDomain, LinfCellMemory, LinfTerms, visit_tetrahedra};
use crate::relax::metrics::CellMetrics;
use crate::relax::relaxation_space::{CellCrowding, CellResult, EnergySpec, ObjectiveValue};
use crate::voronoi::diagram::{Diagram, DiagramError, StopFlag};
use crate::voronoi::linf::cell::{LinfCell, Ties};

/// The L∞ cells of sites in a domain, both in a frame's coordinates.
#[derive(Clone, Debug)]
pub(crate) struct LinfCells<'a> {
    domain: &'a dyn Domain,
    sites: Cow<'a, [Point3<f64>]>,
    /// The frame; none for the axes of space.
    frame: Option<Rotation3<f64>>,
    stop: StopFlag,
}

impl<'a> LinfCells<'a> {
    /// Cells along the axes of space.
    pub(crate) fn new(domain: &'a dyn Domain, sites: &'a [Point3<f64>]) -> Self {
        Self {
            domain,
            sites: Cow::Borrowed(sites),
            frame: None,
            stop: None,
        }
    }

    /// Cells along the axes of a frame, where the domain is `turned`.
    pub(crate) fn in_frame(
        turned: &'a dyn Domain,
        sites: &[Point3<f64>],
        frame: Rotation3<f64>,
    ) -> Self {
        let back = frame.inverse();
        Self {
            domain: turned,
            sites: Cow::Owned(sites.iter().map(|site| back * site).collect()),
            frame: Some(frame),
            stop: None,
        }
    }

    /// The same cells, whose work ends when a flag is raised.
    pub(crate) fn with_stop(self, stop: &StopFlag) -> Self {
        let stop = stop.clone();
        Self { stop, ..self }
    }

    /// The domain and the sites in the frame's coordinates, and the frame; none for the axes of space.
    pub(crate) fn placed(&self) -> (&dyn Domain, &[Point3<f64>], Option<&Rotation3<f64>>) {
        (self.domain, &self.sites, self.frame.as_ref())
    }

    fn diagram(&self) -> Result<Diagram<'_>, DiagramError> {
        Ok(Diagram::borrowed(self.domain, &self.sites)?.with_stop(&self.stop))
    }

    fn map<Answer: Copy + Send + Sync + 'static>(
        &self,
        ties: Ties,
        of_cell: impl Fn(&mut LinfCellInDomain<'_, '_>) -> Answer + Sync,
    ) -> Result<Vec<Answer>, DiagramError> {
        let diagram = self.diagram()?;
        diagram.map_linf_copied(ties, |memory: &mut LinfCellMemory, cell| {
            of_cell(&mut LinfCellInDomain::new(self.domain, &cell, memory))
        })
    }

    /// A place and a vector as they are in space.
    fn in_space(&self, place: Point3<f64>) -> Point3<f64> {
        self.frame.map_or(place, |frame| frame * place)
    }

    fn vector_in_space(&self, vector: Vector3<f64>) -> Vector3<f64> {
        self.frame.map_or(vector, |frame| frame * vector)
    }

    /// Passes what is `kept` of the surface of every cell, and of its facets for whose labels `is_seen` holds,
    /// to `take`, in site order.
    pub(crate) fn stream_shells<T: Send, Failure: From<DiagramError>>(
        &self,
        is_seen: impl Fn(u32, Label) -> bool + Sync,
        kept: impl Fn([Shell; 2]) -> T + Sync,
        take: impl FnMut(usize, T) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let diagram = self.diagram()?;
        let in_space = |shell: Shell| match &self.frame {
            Some(frame) => shell.rotated(frame),
            None => shell,
        };
        let of_cell = |cell: LinfCell<'_>| {
            let shells = linf_shells(self.domain, &cell, |label| is_seen(cell.site, label));
            kept(shells.map_each(in_space))
        };
        diagram.stream_linf(of_cell, take)
    }

    fn terms(&self, order: u32) -> Result<Vec<LinfTerms>, DiagramError> {
        self.map(Ties::ToSmallerIndex, |cell| cell.terms(order))
    }

    /// The sum of the cells' energies of an order.
    pub(crate) fn energy(&self, order: u32) -> Result<f64, DiagramError> {
        Ok(self.terms(order)?.iter().map(|cell| cell.energy).sum())
    }

    /// Every cell's energy and center.
    pub(crate) fn assess(&self, spec: EnergySpec) -> Result<Vec<CellResult<3>>, DiagramError> {
        self.map(Ties::ToSmallerIndex, |cell| {
            let mut result = cell.assess(spec);
            result.target = self.in_space(result.target);
            result
        })
    }

    /// The objective with its gradient, and the volumes of the cells (L³).
    pub(crate) fn objective(
        &self,
        order: u32,
    ) -> Result<(ObjectiveValue<3>, Vec<f64>), DiagramError> {
        let terms = self.terms(order)?;
        let value = ObjectiveValue {
            energy: terms.iter().map(|cell| cell.energy).sum(),
            chebyshev: terms.iter().map(|cell| cell.chebyshev).sum(),
            energy_max: terms.iter().map(|cell| cell.energy).fold(0.0, f64::max),
            gradient: terms
                .iter()
                .map(|cell| self.vector_in_space(cell.gradient))
                .collect(),
            energies: terms.iter().map(|cell| cell.energy).collect(),
        };
        Ok((value, terms.iter().map(|cell| cell.volume).collect()))
    }

    /// How crowded the cells are.
    pub(crate) fn crowding(&self) -> Result<Vec<CellCrowding<3>>, DiagramError> {
        self.map(Ties::ToSmallerIndex, |cell| {
            let mut crowding = cell.crowding();
            crowding.vertex = self.in_space(crowding.vertex);
            crowding
        })
    }

    /// The figures of the cells.
    pub(crate) fn metrics(&self, spec: EnergySpec) -> Result<Vec<CellMetrics<3>>, DiagramError> {
        self.map(Ties::ToSmallerIndex, |cell| {
            let mut figures = cell.metrics(spec);
            figures.centroid = self.in_space(figures.centroid);
            figures.center = self.in_space(figures.center);
            figures.gradient = self.vector_in_space(figures.gradient);
            figures
        })
    }

    /// The share of the domain's volume that is equidistant, equal in `f64`, to several sites.
    pub(crate) fn tied_volume(&self) -> Result<f64, DiagramError> {
        let untied = self.map(Ties::Cut, |cell| cell.volume())?;
        Ok((1.0 - untied.iter().sum::<f64>() / self.domain.volume()).max(0.0))
    }
}

/// A convex domain without periods and density in the coordinates of a frame; none of any other.
pub(crate) fn turned(domain: &dyn Domain, frame: &Rotation3<f64>) -> Option<ConvexPolyhedron> {
    let is_periodic = domain.periods().iter().any(Option::is_some);
    if is_periodic || !domain.is_convex() || domain.has_density() {
        return None;
    }
    let (mut solid, back) = (Polyhedron::default(), frame.inverse());
    domain.start(&Point3::origin(), 0, &mut solid);
    let walls = solid.facets().map(|facet| {
        let HalfSpace { normal, offset } = facet.half_space();
        let normal = back * normal;
        HalfSpace { normal, offset }
    });
    ConvexPolyhedron::new(&walls.collect::<Vec<_>>()).ok()
}

/// The surface of a cell, in the domain's coordinates, for files, and what is seen of it, for pictures: its merged facets, or where
/// rounding keeps those from closing, the fragments that they are made of.
fn linf_shells(
    domain: &dyn Domain,
    cell: &LinfCell<'_>,
    is_seen: impl Fn(Label) -> bool,
) -> [Shell; 2] {
    let outline = domain.is_convex().then(|| cell.outline()).flatten();
    let shells = match &outline {
        Some(outline) => {
            let piece = Piece::Brep(outline);
            [Shell::from(piece), Shell::of_facets(piece, &is_seen)]
        }
        None => {
            let shell = loose_shell(domain, cell);
            [shell.clone(), shell]
        }
    };
    shells.map_each(|shell| shell.translated(&cell.position.coords))
}

fn loose_shell(domain: &dyn Domain, cell: &LinfCell<'_>) -> Shell {
    let (mut vertices, mut facets) = (Vec::new(), Vec::new());
    let mut push = |corners: &mut dyn Iterator<Item = Point3<f64>>| {
        let first = vertices.len() as u32;
        vertices.extend(corners);
        facets.push(first..vertices.len() as u32);
    };
    if domain.is_convex() {
        cell.visit_boundary(|_, corners| push(&mut corners.iter().map(|&at| at.into())));
    } else {
        let (mut part, mut scratch) = (Polyhedron::default(), PieceScratch::default());
        visit_tetrahedra(cell, &mut part, |tetrahedron| {
            domain.outline(&cell.position, tetrahedron, &mut scratch, &mut |piece| {
                let places = piece.vertices();
                piece.visit_polygons(|label, _, corners| {
                    if FacetKind::of(label) != FacetKind::Inner {
                        push(&mut corners.iter().map(|&corner| places[corner as usize]));
                    }
                });
            });
        });
    }
    // The facets name these vertices only.
    Shell::new(&vertices, facets).unwrap_or_default()
}
