//! One L∞ cell in its domain: energies about any center, the minimizer, how its site may move, its figures.
//!
//! A cell that lies in the domain as a whole has closed forms over its cones. About its site these are sums
//! over blocks; about other centers sums over the ways of corners ([`SweptSolid`]), or for other orders and
//! at oblique walls over its boundary ([`FacetedSolid`]). Any other cell, or one with a density, is made of
//! the domain's pieces in the tetrahedra that the fragments of its boundary span with the site.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::domain::domain::Domain;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::energy::center::{BOUNDARY_FRACTION, Center, CenterSearch};
use crate::energy::faceted::FacetedSolid;
use crate::energy::swept::{CornerPath, SweptSolid};
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::label::Label;
use crate::geometry::moments::Moments;
use crate::geometry::polyhedron::Polyhedron;
use crate::minimize::problem::Evaluation;
use crate::relax::evaluate_cell::CellMemory;
use crate::relax::metrics::{ALIGNED, CellMetrics, FACET_SHARE, within_cube};
use crate::relax::relaxation_space::{CellCrowding, CellResult, EnergySpec};
use crate::voronoi::linf::cell::{Fragment, LinfCell};
use crate::voronoi::linf::cone::Cone;

/// A tetrahedron flatter than this share of the cube of its longest edge is rounding.
const FLAT: f64 = 1e-15;

/// Energy, p = 1 energy per mean density, and gradient of one cell about its site, and its volume.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinfTerms {
    pub(crate) volume: f64,
    pub(crate) energy: f64,
    pub(crate) chebyshev: f64,
    pub(crate) gradient: Vector3<f64>,
}

/// The memory in which cells are evaluated, one after the other.
#[derive(Debug, Default)]
pub(crate) struct LinfCellMemory {
    swept: SweptSolid,
    boundary: FacetedSolid,
    pieces: CellMemory,
    part: Polyhedron,
    scratch: PieceScratch,
}

/// Where the integrals of a cell come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CellForm {
    /// The cell lies in the domain, which has no density.
    Whole,
    /// It is a sum of pieces.
    Pieces,
}

/// A cell in its domain, with the memory to evaluate it.
#[derive(Debug)]
pub(crate) struct LinfCellInDomain<'a, 'b> {
    domain: &'a dyn Domain,
    cell: &'a LinfCell<'b>,
    memory: &'a mut LinfCellMemory,
    form: CellForm,
}

impl<'a, 'b> LinfCellInDomain<'a, 'b> {
    /// The cell, its pieces prepared where it has such.
    pub(crate) fn new(
        domain: &'a dyn Domain,
        cell: &'a LinfCell<'b>,
        memory: &'a mut LinfCellMemory,
    ) -> Self {
        let is_whole = !domain.has_density() && memory.holds(domain, cell);
        let form = if is_whole {
            CellForm::Whole
        } else {
            memory.load_pieces(domain, cell);
            CellForm::Pieces
        };
        Self {
            domain,
            cell,
            memory,
            form,
        }
    }

    /// The volume (L³).
    pub(crate) fn volume(&self) -> f64 {
        match self.form {
            CellForm::Whole => self.cell.volume(),
            CellForm::Pieces => self.memory.pieces.volume(),
        }
    }

    /// The integrals about the site.
    pub(crate) fn terms(&mut self, order: u32) -> LinfTerms {
        if self.form == CellForm::Whole {
            return terms_of_whole(self.cell, order);
        }
        let pieces = &mut self.memory.pieces;
        let about_site = pieces.evaluate(&Vector3::zeros(), order);
        let chebyshev = match order {
            1 => about_site.value,
            _ => pieces.evaluate(&Vector3::zeros(), 1).value,
        };
        LinfTerms {
            volume: pieces.volume(),
            energy: about_site.value,
            chebyshev: chebyshev / self.domain.mean_density(),
            gradient: about_site.gradient,
        }
    }

    /// Energies about the site, and where that should move.
    pub(crate) fn assess(&mut self, spec: EnergySpec) -> CellResult<3> {
        let terms = self.terms(spec.order);
        let center = self.center(spec, terms.volume);
        CellResult {
            volume: terms.volume,
            energy: terms.energy,
            chebyshev: terms.chebyshev,
            target: limited_step(self.domain, self.cell, &center.point),
            evaluations: center.evaluations,
        }
    }

    /// The center of the cell, of this volume (L³).
    fn center(&mut self, spec: EnergySpec, volume: f64) -> Center<3> {
        let mass = match self.form {
            CellForm::Whole => volume,
            CellForm::Pieces => self.memory.pieces.measured().1,
        };
        let search = CenterSearch {
            minimizer: spec.minimizer,
            order: spec.order,
            volume,
            mass,
            bounds: site_bounds(self.domain, self.cell),
        };
        let memory = &mut *self.memory;
        if self.form == CellForm::Pieces {
            return search.center(|center| memory.pieces.evaluate(center, spec.order));
        }
        if spec.order == 1 && self.cell.is_along_axes() {
            memory.sweep(self.cell);
            return search.center(|center| memory.swept.energy(center));
        }
        memory.boundary.clear();
        (self.cell).visit_boundary(|_, corners| memory.boundary.push(corners));
        search.center(|center| -> Evaluation<3> { memory.boundary.energy(center, spec.order) })
    }

    /// How crowded the cell is.
    pub(crate) fn crowding(&mut self) -> CellCrowding<3> {
        let place = |to: &Vector3<f64>| self.domain.wrap(&(self.cell.position + to));
        let mut farthest: Vector3<f64> = Vector3::zeros();
        self.cell.visit_fragments(|fragment| {
            for corner in &fragment.corners {
                if corner.amax() > farthest.amax()
                    && (self.form == CellForm::Whole || self.domain.contains(&place(corner)))
                {
                    farthest = *corner;
                }
            }
        });
        CellCrowding {
            energy: self.terms(1).energy,
            vertex: place(&farthest),
            distance: farthest.amax(),
        }
    }

    /// The figures of the cell.
    pub(crate) fn metrics(&mut self, spec: EnergySpec) -> CellMetrics<3> {
        let terms = self.terms(spec.order);
        let center = self.center(spec, terms.volume);
        let (masses, relative_density) = match self.form {
            CellForm::Whole => (moments(self.cell), 1.0),
            CellForm::Pieces => {
                let pieces = &self.memory.pieces;
                (pieces.masses(), pieces.relative_density(self.domain))
            }
        };
        let (domain, position) = (self.domain, self.cell.position);
        let overlap = self.volume_within_cube(terms.volume);
        let figures = AreaFigures::of(&self.facet_areas(), terms.volume);
        CellMetrics {
            volume: terms.volume,
            centroid: domain.wrap(&(position + masses.centroid().coords)),
            energy: terms.energy,
            gradient: terms.gradient,
            center: domain.wrap(&(position + center.point)),
            center_energy: center.energy,
            facets: figures.facets,
            chebyshev: terms.chebyshev,
            relative_density,
            cubeness: overlap / (2.0 * terms.volume - overlap),
            axis_aligned: figures.axis_aligned,
        }
    }

    /// The volume in common with the cube of this volume about the site (L³).
    fn volume_within_cube(&mut self, volume: f64) -> f64 {
        if self.form == CellForm::Whole {
            return self.cell.volume_within(0.5 * volume.cbrt());
        }
        let (domain, site) = (self.domain, &self.cell.position);
        let LinfCellMemory { part, scratch, .. } = &mut *self.memory;
        let mut overlap = 0.0;
        visit_tetrahedra(self.cell, part, |tetrahedron| {
            let common = within_cube(tetrahedron, volume, None, &mut scratch.clip);
            if !common.is_empty() {
                domain.pieces(site, &common, scratch, &mut |sign, piece| {
                    overlap += sign * piece.extent().volume;
                });
            }
        });
        overlap
    }

    /// The area vectors of the facets (L²), by what is beyond and by the normal.
    fn facet_areas(&mut self) -> BTreeMap<(Label, usize), Vector3<f64>> {
        let mut areas: BTreeMap<_, Vector3<f64>> = BTreeMap::new();
        if self.form == CellForm::Whole {
            for ((label, number, form), area) in self.cell.facet_areas() {
                areas.insert((label, 4 * number + usize::from(form)), area);
            }
            return areas;
        }
        let (domain, site) = (self.domain, &self.cell.position);
        let LinfCellMemory { part, scratch, .. } = &mut *self.memory;
        visit_tetrahedra(self.cell, part, |tetrahedron| {
            domain.pieces(site, tetrahedron, scratch, &mut |sign, piece| {
                add_areas(&mut areas, sign, piece);
            });
        });
        areas
    }
}

/// Adds the areas of the facets of a piece, those towards neighbors apart by their normals.
fn add_areas(areas: &mut BTreeMap<(Label, usize), Vector3<f64>>, sign: f64, piece: Piece<'_>) {
    piece.visit_facets(|label, _, area| {
        let number = match FacetKind::of(label) {
            FacetKind::Inner => return,
            FacetKind::Wall(_) => 0,
            FacetKind::Neighbor { .. } => normal_number(&area),
        };
        *areas.entry((label, number)).or_default() += area * sign;
    });
}

/// Numbers the directions of an L∞ bisector: (±1, 0, 0), (±1, ±1, 0) and their like.
fn normal_number(normal: &Vector3<f64>) -> usize {
    let size = normal.amax();
    normal.iter().fold(0, |number, &along| {
        let step = if along.abs() < 0.5 * size {
            0
        } else if along > 0.0 {
            1
        } else {
            2
        };
        3 * number + step
    })
}

/// What the areas of facets tell.
struct AreaFigures {
    /// How many facets are large.
    facets: u32,
    axis_aligned: f64,
}

impl AreaFigures {
    fn of<Key>(areas: &BTreeMap<Key, Vector3<f64>>, volume: f64) -> Self {
        let least = FACET_SHARE * volume.max(0.0).cbrt().powi(2);
        let (mut aligned, mut area, mut facets) = (0.0, 0.0, 0);
        for vector in areas.values() {
            let of_facet = vector.norm();
            area += of_facet;
            if vector.amax() >= ALIGNED * of_facet {
                aligned += of_facet;
            }
            facets += u32::from(of_facet > least);
        }
        Self {
            facets,
            axis_aligned: if area > 0.0 { aligned / area } else { 0.0 },
        }
    }
}

impl LinfCellMemory {
    /// Whether a domain holds all of a cell, told by the box around it.
    fn holds(&mut self, domain: &dyn Domain, cell: &LinfCell<'_>) -> bool {
        if domain.is_convex() {
            return true;
        }
        let inner = FacetKind::Inner.label();
        let Self { part, scratch, .. } = self;
        part.assign_cuboid(&cell.bounds(), [inner; 6]);
        let (mut pieces, mut is_box) = (0, false);
        let position = &cell.position;
        domain.pieces(position, part, scratch, &mut |sign, piece| {
            pieces += 1;
            is_box =
                sign > 0.0 && matches!(piece, Piece::Convex(piece) if std::ptr::eq(piece, part));
        });
        pieces == 1 && is_box
    }

    /// Prepares the pieces of a cell in a domain.
    fn load_pieces(&mut self, domain: &dyn Domain, cell: &LinfCell<'_>) {
        let Self { part, pieces, .. } = self;
        pieces.begin_parts(None);
        visit_tetrahedra(cell, part, |tetrahedron| {
            pieces.add_part(domain, &cell.position, tetrahedron);
        });
    }

    /// Collects the ways of the corners of a cell's sections.
    fn sweep(&mut self, cell: &LinfCell<'_>) {
        let swept = &mut self.swept;
        swept.clear();
        for (number, cone) in Cone::all().into_iter().enumerate() {
            cell.visit_corner_paths(number, |ends, is_added| {
                swept.push(CornerPath { ends, is_added });
            });
            let [u, v] = cone.transverse();
            swept.finish_part([cone.axis, u, v], cone.is_negative);
        }
    }
}

/// Passes on the tetrahedra that the fragments of a cell's facets span with the site, one after the other
/// in `tetrahedron`.
pub(crate) fn visit_tetrahedra(
    cell: &LinfCell<'_>,
    tetrahedron: &mut Polyhedron,
    mut visit: impl FnMut(&Polyhedron),
) {
    cell.visit_fragments(|fragment| visit_fan(fragment, tetrahedron, &mut visit));
}

/// Passes on the tetrahedra that a fragment spans with the site.
pub(crate) fn visit_fan(
    fragment: &Fragment,
    tetrahedron: &mut Polyhedron,
    visit: &mut impl FnMut(&Polyhedron),
) {
    let inner = FacetKind::Inner.label();
    for pair in fragment.corners[1..].windows(2) {
        let corners = [&fragment.corners[0], &pair[0], &pair[1]];
        let [a, b, c] = corners;
        let longest = corners
            .iter()
            .map(|corner| corner.norm())
            .fold(0.0, f64::max);
        if a.dot(&b.cross(c)) > FLAT * longest.powi(3) {
            tetrahedron.assign_tetrahedron(corners, [fragment.label, inner]);
            visit(tetrahedron);
        }
    }
}

/// Integrates over a cell that lies in its domain about its site.
fn terms_of_whole(cell: &LinfCell<'_>, order: u32) -> LinfTerms {
    let volumes = cell.integrals(0);
    let fragments = match order {
        1 => volumes,
        _ => cell
            .integrals(order - 1)
            .map(|part| part * f64::from(order)),
    };
    let energy = cell.integrals(order).iter().sum();
    let along = |axis: usize| fragments[2 * axis + 1] - fragments[2 * axis];
    LinfTerms {
        volume: volumes.iter().sum(),
        energy,
        chebyshev: match order {
            1 => energy,
            _ => cell.integrals(1).iter().sum(),
        },
        gradient: Vector3::new(along(0), along(1), along(2)),
    }
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
/// leaves the cell or the domain. Energy is convex, also if the cell is not, so it falls all along the line.
fn limited_step(domain: &dyn Domain, cell: &LinfCell<'_>, step: &Vector3<f64>) -> Point3<f64> {
    let share = cell.share_within(step);
    let mut share = if share < 1.0 {
        (BOUNDARY_FRACTION * share).max(0.0)
    } else {
        1.0
    };
    if !domain.is_convex() {
        let exit = domain.first_exit(&cell.position, &(step * share));
        if exit.is_finite() {
            share *= BOUNDARY_FRACTION * exit;
        }
    }
    let place = |share: f64| domain.wrap(&(cell.position + step * share));
    if domain.contains(&place(share)) {
        return place(share);
    }
    // By rounding.
    share *= BOUNDARY_FRACTION;
    while share > f64::EPSILON && !domain.contains(&place(share)) {
        share *= 0.5;
    }
    if share > f64::EPSILON {
        place(share)
    } else {
        cell.position
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
