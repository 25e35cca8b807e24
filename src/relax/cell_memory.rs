//! One cell, prepared for integrals, and what a relaxation asks of it.

use std::borrow::Cow;

use nalgebra::{Point3, Rotation3, Vector3};

use crate::domain::domain::Domain;
use crate::domain::shape::PieceScratch;
use crate::energy::center::{Search, center};
use crate::energy::energy::EnergyScratch;
use crate::energy::energy::{SignedPiece, energy, energy_jet};
use crate::geometry::brep::Piece;
use crate::geometry::clip::ClipScratch;
use crate::geometry::moments::Moments;
use crate::geometry::small_polyhedron::SmallPolyhedron;
use crate::integrals::mesh_moments::of_piece;
use crate::integrals::polynomial::Polynomial;
use crate::minimize::problem::Evaluation;
use crate::relax::figures::CellFigures;
use crate::relax::reach::{around, reach, target};
use crate::relax::shape::{Shape, within_cube};
use crate::relax::tessellation::{Assessment, Norm, Question};
use crate::voronoi::cell::Cell;

/// A cell's signed pieces, prepared, and the memory to work on them.
#[derive(Debug, Default)]
pub struct CellMemory {
    pieces: Vec<SignedPiece>,
    used: usize,
    /// The cell's volume (L³), and its mass, which is the volume where there is no density; none for a
    /// cell that is its own only piece, and has not been asked.
    measured: Option<(f64, f64)>,
    /// Mass and its moments of the pieces with a density.
    weighted: Moments,
    walk: EnergyScratch,
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
        if let Some(compact) = cell.compact()
            && domain.is_convex()
            && !domain.has_density()
        {
            return self.load_whole(compact);
        }
        let Self {
            pieces,
            used,
            measured,
            weighted,
            piece,
            ..
        } = self;
        let (mut volume, mut mass) = (0.0, 0.0);
        (*used, *weighted) = (0, Moments::default());
        let mut prepare = |sign: f64, part: Piece<'_>, density: Option<&Polynomial>| {
            let prepared = SignedPiece::place(pieces, *used, sign);
            prepared.assign(part);
            let turned = density.map(|density| match frame {
                Some(frame) => Cow::Owned(density.rotated(frame)),
                None => Cow::Borrowed(density),
            });
            prepared.set_density(turned.as_deref());
            let part_volume = prepared.volume();
            volume += sign * part_volume;
            let part_mass = density.map_or(part_volume, |density| {
                let moments = of_piece(part, density);
                *weighted += moments * sign;
                moments.mass
            });
            mass += sign * part_mass;
            if let Some(frame) = frame {
                prepared.rotate(&frame.inverse());
            }
            *used += 1;
        };
        domain.weighted_pieces(&cell.position, cell.polyhedron(), piece, &mut prepare);
        *measured = Some((volume, mass));
    }

    /// Prepares a cell that is its own only piece.
    fn load_whole(&mut self, cell: &SmallPolyhedron) {
        let piece = SignedPiece::place(&mut self.pieces, 0, 1.0);
        piece.assign_compact(cell);
        self.measured = None;
        self.weighted = Moments::default();
        if let Some(frame) = &self.frame {
            piece.rotate(&frame.inverse());
        }
        self.used = 1;
    }

    /// The volume of the loaded cell (L³).
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.measured().0
    }

    /// Volume and mass.
    fn measured(&self) -> (f64, f64) {
        self.measured.unwrap_or_else(|| {
            let pieces = self.pieces[..self.used].iter();
            let volume = pieces.map(|piece| piece.sign * piece.piece.volume()).sum();
            (volume, volume)
        })
    }

    /// Mass and its moments of the loaded cell about its site; volume and its moments where there
    /// is no density.
    #[must_use]
    pub fn masses(&self) -> Moments {
        let mut masses = self.weighted;
        for SignedPiece { sign, piece } in &self.pieces[..self.used] {
            if piece.density.is_none() {
                let mut moments = piece.moments();
                if let Some(frame) = &self.frame {
                    moments = moments.rotated(frame);
                }
                masses += moments * *sign;
            }
        }
        masses
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

    /// The loaded cell's energy about its site.
    pub(crate) fn energy_at_site(&mut self, asked: Question) -> f64 {
        match asked.norm {
            Norm::Linf => self.evaluate(&Vector3::zeros(), asked.order).value,
            Norm::L2 => self.masses().second.trace(),
        }
    }

    /// A vector of the cell's frame as it points in space.
    pub(crate) fn in_space(&self, vector: Vector3<f64>) -> Vector3<f64> {
        self.frame.map_or(vector, |frame| frame * vector)
    }

    /// The prepared pieces, and the memory to walk them.
    pub(crate) fn pieces(&mut self) -> (&[SignedPiece], &mut EnergyScratch) {
        (&self.pieces[..self.used], &mut self.walk)
    }

    /// The figures of `cell`, which is loaded.
    pub(crate) fn figures(
        &mut self,
        domain: &dyn Domain,
        cell: &Cell<'_>,
        asked: Question,
    ) -> CellFigures<3> {
        let volume = self.volume();
        let Self {
            piece, clip, frame, ..
        } = self;
        let mut shape = Shape::default();
        domain.pieces(
            &cell.position,
            cell.polyhedron(),
            piece,
            &mut |sign, part| {
                shape.add(sign, part);
            },
        );
        let common = within_cube(cell.polyhedron(), volume, frame.as_ref(), clip);
        if !common.is_empty() {
            domain.pieces(&cell.position, &common, piece, &mut |sign, part| {
                shape.add_overlap(sign * part.extent().volume);
            });
        }
        let found = self.find(domain, cell, asked);
        let masses = self.masses();
        let centroid = masses.centroid();
        let center_energy = match asked.norm {
            Norm::Linf => self.evaluate(&found.way, asked.order).value,
            Norm::L2 => masses.second_about(&Point3::from(found.way)),
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

    pub(crate) fn assess(
        &mut self,
        domain: &dyn Domain,
        cell: &Cell<'_>,
        asked: Question,
    ) -> Assessment<3> {
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
        let first = energy_jet(pieces, &Vector3::zeros(), asked.order, &mut self.walk);
        let (volume, mass) = match self.walk.volume() {
            Some(volume) if self.measured.is_none() => (volume, volume),
            _ => self.measured(),
        };
        let search = Search {
            minimizer: asked.minimizer,
            order: asked.order,
            volume,
            mass,
            bounds: match self.frame {
                None => reach(domain, cell),
                Some(_) => around(pieces),
            },
        };
        let center = center(pieces, &search, &first, &mut self.walk);
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
        let masses = self.masses();
        let pieces = &self.pieces[..self.used];
        let chebyshev = energy(pieces, &Vector3::zeros(), 1, &mut self.walk).value;
        Found {
            energy: masses.second.trace(),
            gradient: -2.0 * masses.first,
            chebyshev: chebyshev / domain.mean_density(),
            way: reach(domain, cell).clamp(&masses.centroid()).coords,
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
