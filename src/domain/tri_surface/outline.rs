//! A cell's part of a solid as one closed boundary, for files and pictures.
//!
//! Where the solid's walls, edges or vertices lie on the cell's, rounding decides what crosses what
//! inconsistently. Energies are then computed from signed pieces; but a file needs one closed
//! surface. A small displacement of the solid against the cell removes such a coincidence. So growing
//! displacements in several directions are tried, up to 1e-10 of the cell's size.

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::domain::tri_surface::clip_cell::{ClipStatus, ClippedCell};
use crate::domain::tri_surface::indexed::IndexedSurface;
use crate::geometry::brep::{Brep, Piece};
use crate::geometry::clip::{ClipScratch, clip};
use crate::geometry::polyhedron::Polyhedron;

/// How far the solid is displaced, in shares of the cell's size: above rounding, below the precision of
/// files of cells.
const DISPLACEMENTS: [f64; 4] = [1e-13, 1e-12, 1e-11, 1e-10];

/// The directions of the displacements: parallel to no plane or edge of a typical model.
const DIRECTIONS: [[f64; 3]; 4] = [
    [0.412, -0.731, 0.544],
    [-0.655, 0.237, 0.718],
    [0.307, 0.861, -0.405],
    [-0.789, -0.388, -0.476],
];

/// Facets below this share of the cell's size squared are slivers: leaving them out moves the border
/// by less than the precision of files of cells.
const SLIVER: f64 = 1e-11;

/// Parts of less than this share of their cell are strips along its border, where rounding took
/// the wrong side for the inner one.
const NEGLIGIBLE: f64 = 1e-9;

/// Visits what `cell`, in coordinates relative to `site`, and the solid within `surface` have in
/// common.
pub(crate) fn outline(
    surface: &IndexedSurface,
    site: &Point3<f64>,
    cell: &Polyhedron,
    scratch: &mut PieceScratch,
    visit: &mut dyn FnMut(Piece<'_>),
) {
    if visit_clipped(surface, site, cell, &mut scratch.clipped, visit) {
        return;
    }
    let PieceScratch {
        piece,
        clip,
        clipped,
        ..
    } = scratch;
    drop_slivers(cell, piece, clip);
    if visit_clipped(surface, site, piece, clipped, visit) {
        return;
    }
    let size = cell.radius_squared().sqrt();
    for share in DISPLACEMENTS {
        for direction in DIRECTIONS {
            let displaced = site + Vector3::from(direction) * (share * size);
            if visit_clipped(surface, &displaced, piece, clipped, visit) {
                return;
            }
        }
    }
}

/// Visits what the cell and the solid have in common, unless that is inconsistent.
fn visit_clipped(
    surface: &IndexedSurface,
    site: &Point3<f64>,
    cell: &Polyhedron,
    clipped: &mut ClippedCell,
    visit: &mut dyn FnMut(Piece<'_>),
) -> bool {
    match clipped.clip(surface, site, cell) {
        ClipStatus::Disjoint => visit(Piece::Convex(cell)),
        // A site lies within its cell and within the solid, so something must be left.
        ClipStatus::Clipped if is_significant(&clipped.part, cell) => {
            visit(Piece::Brep(&clipped.part));
        }
        ClipStatus::Clipped | ClipStatus::Inconsistent => return false,
    }
    true
}

/// Whether the part is more than what rounding leaves of a cell along its border.
fn is_significant(part: &Brep, cell: &Polyhedron) -> bool {
    let [part, cell] = [Piece::Brep(part), Piece::Convex(cell)].map_each(|piece| piece.extent());
    part.volume > NEGLIGIBLE * cell.volume
}

/// Makes `into` the cell without facets of no area. Cells of exact lattices have such facets, strips
/// along their edges, and rounding decides which triangles these cut.
fn drop_slivers(cell: &Polyhedron, into: &mut Polyhedron, scratch: &mut ClipScratch) {
    let around = cell.bounds();
    let around = around.grown(&around.extent());
    let least = SLIVER * cell.radius_squared();
    into.assign_cuboid(&around, [FacetKind::Inner.label(); 6]);
    for facet in cell
        .facets()
        .filter(|facet| facet.area_vector().norm() > least)
    {
        clip(into, &facet.half_space(), facet.label(), scratch);
    }
}
