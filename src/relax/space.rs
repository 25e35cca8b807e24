//! Diagrams in space: how cells in a domain answer the loops.

use nalgebra::{Point3, Rotation3, Vector3};

use crate::chebyshev::center::{Search, center};
use crate::chebyshev::energy::{SignedPiece, energy};
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::mass_moments::mass_moments;
use crate::chebyshev::walk::WalkScratch;
use crate::domain::space::{Domain, PieceScratch, displacement};
use crate::geometry::bounds::Bounds;
use crate::geometry::clip::ClipScratch;
use crate::geometry::faceted::Piece;
use crate::geometry::moments::Moments;
use crate::integrals::polynomial::Polynomial;
use crate::minimize::problem::Evaluation;
use crate::relax::figures::CellFigures;
use crate::relax::frames::Frames;
use crate::relax::reach::{around, reach, target};
use crate::relax::shape::{Shape, within_cube};
use crate::relax::tessellation::{Assessment, Norm, Question, Tessellation};
use crate::voronoi::cell::Cell;
use crate::voronoi::diagram::{Diagram, DiagramError};

/// A domain in which sites have cells.
#[derive(Debug)]
pub struct Space {
    domain: Box<dyn Domain>,
    frames: Frames,
}

impl Space {
    /// The space of `domain`.
    #[must_use]
    pub fn new(domain: Box<dyn Domain>) -> Self {
        Self::with_frames(domain, Frames::Axes)
    }

    /// The space of `domain` whose cells measure the Chebyshev distance in these frames.
    #[must_use]
    pub fn with_frames(domain: Box<dyn Domain>, frames: Frames) -> Self {
        Self { domain, frames }
    }

    /// The frames in which cells measure the Chebyshev distance.
    #[must_use]
    pub fn frames(&self) -> &Frames {
        &self.frames
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
        diagram.map(|memory: &mut CellMemory, cell| {
            memory.load_in_frame(self.domain(), &cell, self.frames.of(cell.site));
            memory.figures(self.domain(), &cell, question)
        })
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
            memory.load_in_frame(self.domain(), &cell, self.frames.of(cell.site));
            memory.assess(self.domain(), &cell, question)
        })
    }
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
    frame: Option<Rotation3<f64>>,
}

impl CellMemory {
    /// Prepares the pieces of `cell`.
    pub fn load(&mut self, domain: &dyn Domain, cell: &Cell<'_>) {
        self.load_in_frame(domain, cell, None);
    }

    /// Prepares the pieces of `cell`, whose distances are measured in `frame`.
    pub fn load_in_frame(
        &mut self,
        domain: &dyn Domain,
        cell: &Cell<'_>,
        frame: Option<&Rotation3<f64>>,
    ) {
        self.frame = frame.copied();
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
            let volumes = pieces[*used].integrand.moments();
            if let Some(frame) = frame {
                pieces[*used].integrand.rotate(&frame.inverse());
            }
            *used += 1;
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
        let pieces = &self.pieces[..self.used];
        let Some(frame) = &self.frame else {
            return energy(pieces, center, order, &mut self.walk);
        };
        let turned = energy(pieces, &(frame.inverse() * center), order, &mut self.walk);
        Evaluation {
            value: turned.value,
            gradient: frame * turned.gradient,
            hessian: frame * turned.hessian * frame.inverse(),
        }
    }

    /// A vector of the cell's frame as it points in space.
    pub(crate) fn in_space(&self, vector: Vector3<f64>) -> Vector3<f64> {
        self.frame.map_or(vector, |frame| frame * vector)
    }

    /// The prepared pieces, and the memory to walk them.
    pub(crate) fn pieces(&mut self) -> (&[SignedPiece], &mut WalkScratch) {
        (&self.pieces[..self.used], &mut self.walk)
    }

    /// The figures of `cell`, which is loaded.
    fn figures(&mut self, domain: &dyn Domain, cell: &Cell<'_>, asked: Question) -> CellFigures<3> {
        let volume = self.moments.volume;
        let Self {
            piece, clip, frame, ..
        } = self;
        let mut shape = Shape::default();
        domain.pieces(&cell.position, cell.polyhedron, piece, &mut |sign, part| {
            shape.add(sign, part);
        });
        let common = within_cube(cell.polyhedron, volume, frame.as_ref(), clip);
        if !common.is_empty() {
            domain.pieces(&cell.position, &common, piece, &mut |sign, part| {
                shape.add_overlap(sign * part.moments().volume);
            });
        }
        let found = self.find(domain, cell, asked);
        let centroid = self.masses.centroid();
        let center_energy = match asked.norm {
            Norm::Linf => self.evaluate(&found.way, asked.order).value,
            Norm::L2 => self.masses.second_about(&Point3::from(found.way)),
        };
        CellFigures {
            volume,
            centroid: domain.wrap(&(cell.position + centroid.coords)),
            energy: found.energy,
            gradient: found.gradient,
            center: domain.wrap(&(cell.position + found.way)),
            center_energy,
            facets: shape.facets(volume),
            chebyshev: found.chebyshev,
            cubeness: shape.cubeness(volume),
            axis_aligned: shape.axis_aligned(self.frame.as_ref()),
        }
    }

    fn assess(&mut self, domain: &dyn Domain, cell: &Cell<'_>, asked: Question) -> Assessment<3> {
        let found = self.find(domain, cell, asked);
        Assessment {
            energy: found.energy,
            chebyshev: found.chebyshev,
            target: target(domain, cell, &found.way),
            evaluations: found.evaluations,
        }
    }

    fn find(&mut self, domain: &dyn Domain, cell: &Cell<'_>, asked: Question) -> Found {
        match asked.norm {
            Norm::Linf => self.find_center(domain, cell, asked),
            Norm::L2 => self.find_centroid(domain, cell),
        }
    }

    fn find_center(&mut self, domain: &dyn Domain, cell: &Cell<'_>, asked: Question) -> Found {
        let pieces = &self.pieces[..self.used];
        let search = Search {
            minimizer: asked.minimizer,
            order: asked.order,
            volume: self.moments.volume,
            mass: self.masses.volume,
            bounds: match self.frame {
                None => reach(domain, cell),
                Some(_) => around(pieces),
            },
        };
        let center = center(pieces, &search, &mut self.walk);
        let chebyshev = if asked.order == 1 {
            center.energy_at_site
        } else {
            energy(pieces, &Vector3::zeros(), 1, &mut self.walk).value
        };
        Found {
            energy: center.energy_at_site,
            gradient: self.in_space(center.gradient_at_site),
            chebyshev: chebyshev / domain.mean_density(),
            way: self.in_space(center.point),
            evaluations: center.evaluations,
        }
    }

    fn find_centroid(&mut self, domain: &dyn Domain, cell: &Cell<'_>) -> Found {
        let pieces = &self.pieces[..self.used];
        let chebyshev = energy(pieces, &Vector3::zeros(), 1, &mut self.walk).value;
        Found {
            energy: self.masses.second,
            gradient: -2.0 * self.masses.first,
            chebyshev: chebyshev / domain.mean_density(),
            way: reach(domain, cell).clamp(&self.masses.centroid()).coords,
            evaluations: 1,
        }
    }
}

/// What a site finds in its cell, in the asked norm.
struct Found {
    energy: f64,
    /// The energy's gradient at the site.
    gradient: Vector3<f64>,
    /// The p = 1 Chebyshev energy at the site, per mean density.
    chebyshev: f64,
    /// From the site to the minimizer.
    way: Vector3<f64>,
    evaluations: u32,
}
