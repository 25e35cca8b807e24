//! The shape of a domain: a solid whose part in a convex polyhedron is a signed sum of pieces.
//!
//! All integrals over a cell are additive over a partition of C ∩ Ω into pieces and linear in signs.
//! So a shape only gives the convex polyhedron from which a cell is cut, and then the signed pieces of
//! its part in the cell. A piece is convex or given by its boundary.

use std::fmt::Debug;

use nalgebra::{Point, Point3, SVector, Vector3};

use crate::domain::tri_surface::clip_cell::ClippedCell;
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::clip::ClipScratch;
use crate::geometry::polyhedron::Polyhedron;
use crate::mesh::surface::SurfaceMesh;

/// A bounded solid Ω in space, possibly periodic along some axes.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, DomainShape};
///
/// let cube = Cuboid::unit();
/// assert!(cube.contains(&[0.0, 0.5, 1.0].into()) && !cube.contains(&[0.0, 0.5, 1.1].into()));
/// ```
pub trait DomainShape: Debug + Send + Sync + 'static {
    /// The least axis-aligned box around Ω.
    fn bounds(&self) -> Bounds<3>;

    /// |Ω| (L³).
    fn volume(&self) -> f64;

    /// Whether `point` lies in the closed set Ω.
    fn contains(&self, point: &Point3<f64>) -> bool;

    /// The triangles of the boundary, where Ω may fill next to nothing of its bounds; none where it
    /// does not.
    fn boundary(&self) -> Vec<[Point3<f64>; 3]> {
        Vec::new()
    }

    /// The period along each axis (L), `None` where the axis ends in walls.
    fn periods(&self) -> [Option<f64>; 3] {
        [None; 3]
    }

    /// The same place with periodic coordinates brought into the bounds.
    fn wrap(&self, point: &Point3<f64>) -> Point3<f64> {
        let (bounds, periods) = (self.bounds(), self.periods());
        let mut wrapped = *point;
        for axis in 0..3 {
            let Some(period) = periods[axis] else {
                continue;
            };
            if bounds.min[axis] <= point[axis] && point[axis] < bounds.max[axis] {
                continue;
            }
            let inside = bounds.min[axis] + (point[axis] - bounds.min[axis]).rem_euclid(period);
            let past_end = inside >= bounds.max[axis];
            wrapped[axis] = if past_end { bounds.min[axis] } else { inside };
        }
        wrapped
    }

    /// Sets `cell` to a convex polyhedron, in coordinates relative to `site` (number `index`),
    /// from which the site's cell is cut: all of Ω that the cell may hold lies in it.
    fn start(&self, site: &Point3<f64>, index: u32, cell: &mut Polyhedron);

    /// Whether every cell is its own only piece, with sign +1.
    fn is_convex(&self) -> bool {
        true
    }

    /// Visits the signed pieces of `part` ∩ Ω for a convex part of a cell, all in coordinates
    /// relative to `site`. If the part `holds_site`, a point of Ω, and Ω's boundary does not touch
    /// the part, then it lies in Ω; otherwise that is computed.
    fn signed_pieces(
        &self,
        _site: &Point3<f64>,
        part: &Polyhedron,
        _holds_site: bool,
        _scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        visit(1.0, Piece::Convex(part));
    }

    /// Visits the signed pieces of `cell` ∩ Ω, the site's whole cell.
    fn pieces(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        self.signed_pieces(site, cell, true, scratch, visit);
    }

    /// Visits `cell` ∩ Ω in one piece for files and pictures: exact to 1e-9 of the cell's size, and
    /// not at all where no consistent boundary is found.
    fn outline(
        &self,
        _site: &Point3<f64>,
        cell: &Polyhedron,
        _scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(Piece<'_>),
    ) {
        visit(Piece::Convex(cell));
    }

    /// Visits convex polyhedra that fill `part` ∩ Ω and do not overlap, in coordinates relative to
    /// `site`: exact, but more of them than [`signed_pieces`](Self::signed_pieces) has pieces.
    fn convex_parts(
        &self,
        _site: &Point3<f64>,
        part: &Polyhedron,
        _scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(&Polyhedron),
    ) {
        visit(part);
    }

    /// The triangles that bound Ω, where it is given by triangles; walls are numbered by them.
    fn surface_mesh(&self) -> Option<&SurfaceMesh> {
        None
    }

    /// The share of `step` after which the way from `site` first leaves Ω otherwise than by
    /// leaving the cell's start; infinity where it does not.
    fn first_exit(&self, _site: &Point3<f64>, _step: &Vector3<f64>) -> f64 {
        f64::INFINITY
    }

    /// Whether the walls are those of [`bounds`](Self::bounds).
    fn is_box(&self) -> bool {
        false
    }

    /// The share of `step` after which the way from `site` first leaves Ω through a wall, and that
    /// wall's outward unit normal; none where it stays in Ω.
    fn wall_ahead(&self, site: &Point3<f64>, step: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let exit = self.first_exit(site, step);
        exit.is_finite().then(|| (exit, step.normalize()))
    }
}

/// The memory of [`DomainShape::pieces`], to be reused from one cell to the next.
#[derive(Clone, Debug, Default)]
pub struct PieceScratch {
    /// A part of a cell, to be cut into pieces.
    pub part: Polyhedron,
    /// The convex piece under construction.
    pub piece: Polyhedron,
    /// The memory of its clips.
    pub clip: ClipScratch,
    /// The part within a surface.
    pub clipped: ClippedCell,
    /// Elements that may touch a cell.
    pub candidates: Vec<u32>,
}

/// The displacement from `from` to `to`, the shortest one along periodic axes.
#[must_use]
pub(crate) fn displacement<const D: usize>(
    periods: &[Option<f64>; D],
    from: &Point<f64, D>,
    to: &Point<f64, D>,
) -> SVector<f64, D> {
    let mut displacement = to - from;
    for axis in 0..D {
        if let Some(period) = periods[axis] {
            displacement[axis] -= period * (displacement[axis] / period).round();
        }
    }
    displacement
}
