//! Diagrams in space: how cells in a domain answer the loops.

use nalgebra::{Point3, Vector3};

use crate::chebyshev::center::{SHY_OF_BORDER, Search, center};
use crate::chebyshev::energy::{SignedPiece, energy};
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::mass_moments::mass_moments;
use crate::chebyshev::walk::WalkScratch;
use crate::domain::space::{Domain, PieceScratch, displacement};
use crate::geometry::bounds::Bounds;
use crate::geometry::clip::ClipScratch;
use crate::geometry::faceted::Piece;
use crate::geometry::moments::Moments;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::shell::Shell;
use crate::integrals::polynomial::Polynomial;
use crate::minimize::problem::Evaluation;
use crate::relax::figures::CellFigures;
use crate::relax::shape::{Shape, within_cube};
use crate::relax::tessellation::{Assessment, Norm, Question, Tessellation};
use crate::voronoi::cell::Cell;
use crate::voronoi::diagram::{Diagram, DiagramError};

/// A domain in which sites have cells.
#[derive(Debug)]
pub struct Space {
    domain: Box<dyn Domain>,
}

impl Space {
    /// The space of `domain`.
    #[must_use]
    pub fn new(domain: Box<dyn Domain>) -> Self {
        Self { domain }
    }

    /// The domain.
    #[must_use]
    pub fn domain(&self) -> &dyn Domain {
        self.domain.as_ref()
    }
}

impl Space {
    /// The figures of the cells of all `sites`, in site order.
    ///
    /// # Errors
    /// When the sites have no diagram.
    pub fn figures(
        &self,
        sites: &[Point3<f64>],
        question: Question,
    ) -> Result<Vec<CellFigures<3>>, DiagramError> {
        let diagram = Diagram::new(self.domain(), sites)?;
        diagram.map(|memory: &mut CellMemory, cell| memory.figures(self.domain(), &cell, question))
    }
}

impl Tessellation<3> for Space {
    type Error = DiagramError;

    fn volume(&self) -> f64 {
        self.domain.volume()
    }

    fn bounds(&self) -> Bounds<3> {
        self.domain.bounds()
    }

    fn displacement(&self, from: &Point3<f64>, to: &Point3<f64>) -> Vector3<f64> {
        displacement(&self.domain.periods(), from, to)
    }

    fn assess(
        &self,
        sites: &[Point3<f64>],
        question: Question,
    ) -> Result<Vec<Assessment<3>>, DiagramError> {
        let diagram = Diagram::new(self.domain(), sites)?;
        diagram.map(|memory: &mut CellMemory, cell| {
            memory.load(self.domain(), &cell);
            memory.assess(self.domain(), &cell, question)
        })
    }
}

/// The surface of `cell` within the domain, in the domain's coordinates: what files and pictures
/// show.
pub fn shell(domain: &dyn Domain, cell: &Cell<'_>, scratch: &mut PieceScratch) -> Shell {
    let mut shell = Shell::default();
    domain.shape(&cell.position, cell.polyhedron, scratch, &mut |piece| {
        shell = Shell::from(piece).translated(&cell.position.coords);
    });
    shell
}

/// A cell's signed pieces, prepared, and the memory to work on them.
#[derive(Debug, Default)]
pub struct CellMemory {
    pieces: Vec<SignedPiece>,
    used: usize,
    moments: Moments,
    /// As the moments, with the density inside; the same where the density is 1.
    masses: Moments,
    walk: WalkScratch,
    piece: PieceScratch,
    clip: ClipScratch,
}

impl CellMemory {
    /// Prepares the pieces of `cell`.
    pub fn load(&mut self, domain: &dyn Domain, cell: &Cell<'_>) {
        let Self {
            pieces,
            used,
            moments,
            masses,
            piece,
            ..
        } = self;
        *used = 0;
        (*moments, *masses) = (Moments::default(), Moments::default());
        let mut prepare = |sign: f64, part: Piece<'_>, density: Option<&Polynomial>| {
            if *used == pieces.len() {
                let integrand = Integrand::default();
                pieces.push(SignedPiece { sign, integrand });
            }
            pieces[*used].sign = sign;
            pieces[*used].integrand.assign(part);
            pieces[*used].integrand.set_density(density);
            *used += 1;
            let volumes = part.moments();
            moments.add_signed(sign, &volumes);
            let weighted = density.map(|density| mass_moments(part, density));
            masses.add_signed(sign, &weighted.unwrap_or(volumes));
        };
        domain.weighted_pieces(&cell.position, cell.polyhedron, piece, &mut prepare);
    }

    /// Volume and moments of the cell about its site.
    #[must_use]
    pub fn moments(&self) -> &Moments {
        &self.moments
    }

    /// The order-p Chebyshev energy of the loaded cell about a displacement from its site, with
    /// gradient and Hessian.
    #[must_use]
    pub fn evaluate(&mut self, center: &Vector3<f64>, order: u32) -> Evaluation<3> {
        energy(&self.pieces[..self.used], center, order, &mut self.walk)
    }

    /// The prepared pieces, and the memory to walk them.
    pub(crate) fn pieces(&mut self) -> (&[SignedPiece], &mut WalkScratch) {
        (&self.pieces[..self.used], &mut self.walk)
    }

    /// The figures of `cell`.
    pub fn figures(
        &mut self,
        domain: &dyn Domain,
        cell: &Cell<'_>,
        asked: Question,
    ) -> CellFigures<3> {
        self.load(domain, cell);
        let volume = self.moments.volume;
        let Self { piece, clip, .. } = self;
        let mut shape = Shape::default();
        domain.pieces(&cell.position, cell.polyhedron, piece, &mut |sign, part| {
            shape.add(sign, part);
        });
        let common = within_cube(cell.polyhedron, volume, clip);
        if !common.is_empty() {
            domain.pieces(&cell.position, &common, piece, &mut |sign, part| {
                shape.add_overlap(sign * part.moments().volume);
            });
        }
        let assessment = self.assess(domain, cell, asked);
        let centroid = self.masses.centroid();
        let step = displacement(&domain.periods(), &cell.position, &assessment.target);
        let (gradient, center_energy) = match asked.norm {
            Norm::Linf => {
                let gradient = self.evaluate(&Vector3::zeros(), asked.order).gradient;
                (gradient, self.evaluate(&step, asked.order).value)
            }
            Norm::L2 => (
                -2.0 * self.masses.first,
                self.masses.second_about(&Point3::from(step)),
            ),
        };
        CellFigures {
            volume,
            centroid: domain.wrap(&(cell.position + centroid.coords)),
            energy: assessment.energy,
            gradient,
            center: assessment.target,
            center_energy,
            facets: shape.facets(volume),
            chebyshev: assessment.chebyshev,
            cubeness: shape.cubeness(volume),
            axis_aligned: shape.axis_aligned(),
        }
    }

    fn assess(&mut self, domain: &dyn Domain, cell: &Cell<'_>, asked: Question) -> Assessment<3> {
        match asked.norm {
            Norm::Linf => self.assess_linf(domain, cell, asked),
            Norm::L2 => self.assess_l2(domain, cell),
        }
    }

    fn assess_linf(
        &mut self,
        domain: &dyn Domain,
        cell: &Cell<'_>,
        asked: Question,
    ) -> Assessment<3> {
        let pieces = &self.pieces[..self.used];
        let search = Search {
            minimizer: asked.minimizer,
            order: asked.order,
            volume: self.moments.volume,
            mass: self.masses.volume,
            bounds: reach(domain, cell),
        };
        let center = center(pieces, &search, &mut self.walk);
        let chebyshev = if asked.order == 1 {
            center.energy_at_site
        } else {
            energy(pieces, &Vector3::zeros(), 1, &mut self.walk).value
        };
        Assessment {
            energy: center.energy_at_site,
            chebyshev: chebyshev / domain.mean_density(),
            target: target(domain, cell, &center.point),
            evaluations: center.evaluations,
        }
    }

    fn assess_l2(&mut self, domain: &dyn Domain, cell: &Cell<'_>) -> Assessment<3> {
        let pieces = &self.pieces[..self.used];
        let chebyshev = energy(pieces, &Vector3::zeros(), 1, &mut self.walk).value;
        let centroid = reach(domain, cell).clamp(&self.masses.centroid());
        Assessment {
            energy: self.masses.second,
            chebyshev: chebyshev / domain.mean_density(),
            target: target(domain, cell, &centroid.coords),
            evaluations: 1,
        }
    }
}

/// The box in which the site may move, relative to it: around its cell and within the domain's.
pub(crate) fn reach(domain: &dyn Domain, cell: &Cell<'_>) -> Bounds<3> {
    let around = cell.polyhedron.bounds();
    let mut within = domain.bounds();
    for (axis, period) in domain.periods().iter().enumerate() {
        if period.is_some() {
            within.min[axis] = f64::NEG_INFINITY;
            within.max[axis] = f64::INFINITY;
        }
    }
    within.min -= cell.position.coords;
    within.max -= cell.position.coords;
    around.intersection(&within)
}

/// Where the site goes that is drawn to `step`: there, or [`SHY_OF_BORDER`] of the way to where the
/// straight way first leaves the cell or the domain. The energy is convex, also if the cell is not,
/// so it falls all along the way.
fn target(domain: &dyn Domain, cell: &Cell<'_>, step: &Vector3<f64>) -> Point3<f64> {
    let mut share = share_within(cell.polyhedron, step);
    if !domain.is_convex() {
        let exit = domain.first_exit(&cell.position, &(step * share));
        if exit.is_finite() {
            share *= SHY_OF_BORDER * exit;
        }
        // Rounding may put a point that is nearly on the surface on its wrong side.
        while share > 0.0 && !domain.contains(&(cell.position + step * share)) {
            share *= 0.5;
        }
    }
    domain.wrap(&(cell.position + step * share))
}

/// The share of `step` that a site may make: all of it while that ends in the cell, else
/// [`SHY_OF_BORDER`] of the way to the border. Since the energy is convex it falls all the way.
fn share_within(cell: &Polyhedron, step: &Vector3<f64>) -> f64 {
    let mut share: f64 = 1.0;
    for facet in cell.facets() {
        let border = facet.half_space();
        let climb = border.normal.dot(step);
        if climb > border.offset {
            share = share.min(SHY_OF_BORDER * (border.offset / climb).max(0.0));
        }
    }
    share
}
