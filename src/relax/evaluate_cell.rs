//! The energy of one cell, its minimizer, and how far its site may move at once.

use std::borrow::Cow;

use nalgebra::{Point3, Rotation3, Vector3};

use crate::arrays::MapEach;
use crate::domain::{domain::Domain, shape::PieceScratch};
use crate::energy::center::{BOUNDARY_FRACTION, CenterSearch, center};
use crate::energy::evaluation::EnergyScratch;
use crate::energy::evaluation::{SignedPiece, energy, energy_jet};
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::clip::ClipScratch;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::moments::Moments;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::small_polyhedron::SmallPolyhedron;
use crate::integrals::mesh_moments::of_piece;
use crate::integrals::polynomial::Polynomial;
use crate::minimize::problem::Evaluation;
use crate::relax::metrics::{CellMetrics, ShapeSums, within_cube};
use crate::relax::relaxation_space::{CellCrowding, CellResult, EnergySpec, Norm};
use crate::voronoi::cell::Cell;

/// A cell's signed pieces, prepared, and the memory to work on them.
#[derive(Debug, Default)]
pub(crate) struct CellMemory {
    pieces: Vec<SignedPiece>,
    used: usize,
    /// The cell's volume (L³), and its mass, which is the volume where there is no density; none for a
    /// cell that is its own only piece before either is needed.
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
    pub(crate) fn load(&mut self, domain: &dyn Domain, cell: &Cell<'_>) {
        self.load_in_frame(domain, cell, None);
    }

    /// Prepares the pieces of `cell`, whose distances are measured in `frame`.
    pub(crate) fn load_in_frame(
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
        self.load_part(domain, &cell.position, cell.polyhedron(), frame);
    }

    /// Prepares the pieces of a convex part of the cell of `site`, in coordinates relative to it.
    pub(crate) fn load_part(
        &mut self,
        domain: &dyn Domain,
        site: &Point3<f64>,
        part: &Polyhedron,
        frame: Option<&Rotation3<f64>>,
    ) {
        self.begin_parts(frame);
        self.add_part(domain, site, part);
    }

    /// Starts with no pieces.
    pub(crate) fn begin_parts(&mut self, frame: Option<&Rotation3<f64>>) {
        self.frame = frame.copied();
        (self.used, self.weighted) = (0, Moments::default());
        self.measured = Some((0.0, 0.0));
    }

    /// Adds the pieces of a convex part, which holds the site, of its cell.
    pub(crate) fn add_part(&mut self, domain: &dyn Domain, site: &Point3<f64>, part: &Polyhedron) {
        let (mut volume, mut mass) = self.measured();
        let Self {
            pieces,
            used,
            measured,
            weighted,
            piece,
            frame,
            ..
        } = self;
        let frame = frame.as_ref();
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
        domain.weighted_pieces(site, part, piece, &mut prepare);
        *measured = Some((volume, mass));
    }

    /// Prepares a cell that is its own only piece.
    fn load_whole(&mut self, cell: &SmallPolyhedron) {
        let prepared = SignedPiece::place(&mut self.pieces, 0, 1.0);
        prepared.assign_compact(cell);
        self.measured = None;
        self.weighted = Moments::default();
        if let Some(frame) = &self.frame {
            prepared.rotate(&frame.inverse());
        }
        self.used = 1;
    }

    /// The volume of the loaded cell (L³).
    #[must_use]
    pub(crate) fn volume(&self) -> f64 {
        self.measured().0
    }

    /// Volume and mass.
    pub(crate) fn measured(&self) -> (f64, f64) {
        self.measured.unwrap_or_else(|| {
            let pieces = self.pieces[..self.used].iter();
            let volume = pieces.map(|piece| piece.sign * piece.piece.volume()).sum();
            (volume, volume)
        })
    }

    /// The mean density in the loaded cell, relative to the domain's.
    pub(crate) fn relative_density(&self, domain: &dyn Domain) -> f64 {
        let (volume, mass) = self.measured();
        if domain.has_density() && volume > 0.0 {
            mass / (volume * domain.mean_density())
        } else {
            1.0
        }
    }

    /// Mass and its moments of the loaded cell about its site; volume and its moments where there
    /// is no density.
    #[must_use]
    pub(crate) fn masses(&self) -> Moments {
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
    pub(crate) fn evaluate(&mut self, center: &Vector3<f64>, order: u32) -> Evaluation<3> {
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
    pub(crate) fn energy_at_site(&mut self, spec: EnergySpec) -> f64 {
        match spec.norm {
            Norm::Linf => self.evaluate(&Vector3::zeros(), spec.order).value,
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
    pub(crate) fn metrics(
        &mut self,
        domain: &dyn Domain,
        cell: &Cell<'_>,
        spec: EnergySpec,
    ) -> CellMetrics<3> {
        let volume = self.volume();
        let Self {
            piece, clip, frame, ..
        } = self;
        let mut shape = ShapeSums::default();
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
        let found = self.minimizer(domain, cell, spec);
        let masses = self.masses();
        let centroid = masses.centroid();
        let center_energy = match spec.norm {
            Norm::Linf => self.evaluate(&found.to_minimizer, spec.order).value,
            Norm::L2 => masses.second_about(&Point3::from(found.to_minimizer)),
        };
        CellMetrics {
            volume,
            centroid: domain.wrap(&(cell.position + centroid.coords)),
            energy: found.energy,
            gradient: found.gradient,
            center: domain.wrap(&(cell.position + found.to_minimizer)),
            center_energy,
            facets: shape.facets(volume),
            chebyshev: found.chebyshev,
            relative_density: self.relative_density(domain),
            cubeness: shape.cubeness(volume),
            axis_aligned: shape.axis_aligned(self.frame.as_ref()),
        }
    }

    /// How crowded the loaded `cell` is.
    pub(crate) fn crowding(&mut self, domain: &dyn Domain, cell: &Cell<'_>) -> CellCrowding<3> {
        let frame = self.frame;
        let distance =
            |to: &Vector3<f64>| frame.map_or(to.amax(), |frame| (frame.inverse() * to).amax());
        let place = |to: &Vector3<f64>| domain.wrap(&(cell.position + to));
        let mut farthest = Vector3::zeros();
        for vertex in cell.polyhedron().vertices() {
            let is_farther = distance(&vertex.coords) > distance(&farthest);
            if is_farther && domain.contains(&place(&vertex.coords)) {
                farthest = vertex.coords;
            }
        }
        CellCrowding {
            energy: self.evaluate(&Vector3::zeros(), 1).value,
            vertex: place(&farthest),
            distance: distance(&farthest),
        }
    }

    pub(crate) fn assess(
        &mut self,
        domain: &dyn Domain,
        cell: &Cell<'_>,
        spec: EnergySpec,
    ) -> CellResult<3> {
        let found = self.minimizer(domain, cell, spec);
        CellResult {
            volume: found.volume,
            energy: found.energy,
            chebyshev: found.chebyshev,
            target: limited_step(domain, cell, &found.to_minimizer),
            evaluations: found.evaluations,
        }
    }

    fn minimizer(&mut self, domain: &dyn Domain, cell: &Cell<'_>, spec: EnergySpec) -> CellMinimum {
        match spec.norm {
            Norm::Linf => self.center(domain, cell, spec),
            Norm::L2 => self.centroid(domain, cell),
        }
    }

    fn center(&mut self, domain: &dyn Domain, cell: &Cell<'_>, spec: EnergySpec) -> CellMinimum {
        let pieces = &self.pieces[..self.used];
        let first = energy_jet(pieces, &Vector3::zeros(), spec.order, &mut self.walk);
        let (volume, mass) = match self.walk.volume() {
            Some(volume) if self.measured.is_none() => (volume, volume),
            _ => self.measured(),
        };
        let search = CenterSearch {
            minimizer: spec.minimizer,
            order: spec.order,
            volume,
            mass,
            bounds: match self.frame {
                None => site_bounds(domain, cell),
                Some(_) => bounds_of(pieces),
            },
        };
        let center = center(pieces, &search, &first, &mut self.walk);
        let chebyshev = if spec.order == 1 {
            center.energy_at_site
        } else {
            energy(pieces, &Vector3::zeros(), 1, &mut self.walk).value
        };
        CellMinimum {
            volume,
            energy: center.energy_at_site,
            gradient: self.in_space(center.gradient_at_site),
            chebyshev: chebyshev / domain.mean_density(),
            to_minimizer: self.in_space(center.point),
            evaluations: center.evaluations,
        }
    }

    fn centroid(&mut self, domain: &dyn Domain, cell: &Cell<'_>) -> CellMinimum {
        let masses = self.masses();
        let pieces = &self.pieces[..self.used];
        let chebyshev = energy(pieces, &Vector3::zeros(), 1, &mut self.walk).value;
        CellMinimum {
            volume: self.volume(),
            energy: masses.second.trace(),
            gradient: -2.0 * masses.first,
            chebyshev: chebyshev / domain.mean_density(),
            to_minimizer: site_bounds(domain, cell).clamp(&masses.centroid()).coords,
            evaluations: 1,
        }
    }
}

/// The minimizer of a cell's energy, and the energy at the site.
struct CellMinimum {
    volume: f64,
    energy: f64,
    /// The energy's gradient at the site.
    gradient: Vector3<f64>,
    /// The p = 1 Chebyshev energy at the site, per mean density.
    chebyshev: f64,
    /// From the site to the minimizer.
    to_minimizer: Vector3<f64>,
    evaluations: u32,
}

/// The box in which the site may move, relative to it: around its cell and within the domain's.
fn site_bounds(domain: &dyn Domain, cell: &Cell<'_>) -> Bounds<3> {
    let cell_bounds = cell.bounds();
    let mut within = domain.bounds();
    for (axis, period) in domain.periods().iter().enumerate() {
        if period.is_some() {
            within.min[axis] = f64::NEG_INFINITY;
            within.max[axis] = f64::INFINITY;
        }
    }
    within.min -= cell.position.coords;
    within.max -= cell.position.coords;
    cell_bounds.intersection(&within)
}

/// The site after `step`, or after [`BOUNDARY_FRACTION`] of the way to where the straight line first
/// leaves the cell or the domain. The energy is convex, also if the cell is not, so it falls all
/// along the line.
fn limited_step(domain: &dyn Domain, cell: &Cell<'_>, step: &Vector3<f64>) -> Point3<f64> {
    let mut share = share_within(cell.half_spaces(), step);
    if !domain.is_convex() {
        let exit = domain.first_exit(&cell.position, &(step * share));
        if exit.is_finite() {
            share *= BOUNDARY_FRACTION * exit;
        }
        // Rounding may put a point that is nearly on the surface on its wrong side.
        while share > 0.0 && !domain.contains(&(cell.position + step * share)) {
            share *= 0.5;
        }
    }
    within_walls(domain, domain.wrap(&(cell.position + step * share)))
}

/// The place itself, or where rounding has put it beyond the box around the domain, that box's wall.
fn within_walls(domain: &dyn Domain, place: Point3<f64>) -> Point3<f64> {
    let inside = domain.bounds().clamp(&place);
    let periods = domain.periods();
    Point3::from([0, 1, 2].map_each(|axis| match periods[axis] {
        Some(_) => place[axis],
        None => inside[axis],
    }))
}

/// The share of `step` that a site may make: all of it while that ends in the cell, else
/// [`BOUNDARY_FRACTION`] of the way to the border. Since the energy is convex it falls all the way.
///
/// Planes that have no facet any more count too: the straight line leaves the cell before it meets them.
fn share_within(half_spaces: &[HalfSpace], step: &Vector3<f64>) -> f64 {
    let mut share: f64 = 1.0;
    for border in half_spaces {
        let climb = border.normal.dot(step);
        if climb > border.offset {
            share = share.min(BOUNDARY_FRACTION * (border.offset / climb).max(0.0));
        }
    }
    share
}

/// The box around the pieces, in their frame.
fn bounds_of(pieces: &[SignedPiece]) -> Bounds<3> {
    let mut bounds = Bounds::empty();
    for vertex in pieces.iter().flat_map(|piece| piece.piece.vertices()) {
        bounds.include(&vertex);
    }
    bounds
}
