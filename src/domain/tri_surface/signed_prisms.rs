//! The part of a convex cell within a closed surface as a signed sum of half-infinite prisms, used
//! where rounding makes its boundary inconsistent.
//!
//! From every point of the solid a ray in a fixed direction leaves the solid once more often than
//! it enters. So the solid's indicator is the sum over the triangles of ± that of the triangle's
//! *prism*, the half-infinite one of the points from which the ray hits the triangle; plus where
//! the ray leaves. A cell's part of a prism is the cell clipped by four half-spaces: convex, and
//! nothing has to be decided. Only triangles ahead of the cell count.
//!
//! This is section 6 of the method (\[BL\] section 3.3 by signed cones) with the apex at infinity,
//! so that few cones reach a cell.

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::domain::tri_surface::indexed::IndexedSurface;
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;

/// The rays' direction: all components positive, parallel to no plane of a typical model.
const RAY: [f64; 3] = [
    0.348_155_311_911_395_6,
    0.568_143_226_540_279_4,
    0.745_615_920_126_583_1,
];

/// Visits the signed parts of the triangles' prisms in `cell`, in coordinates relative to `site`.
pub(crate) fn signed_prisms(
    surface: &IndexedSurface,
    site: &Point3<f64>,
    cell: &Polyhedron,
    scratch: &mut PieceScratch,
    visit: &mut dyn FnMut(f64, Piece<'_>),
) {
    let around = cell.bounds().translated(&site.coords);
    let PieceScratch {
        piece,
        clip,
        candidates,
        ..
    } = scratch;
    candidates.clear();
    let ahead = |bounds: &Bounds<3>| is_ahead(bounds, &around);
    surface
        .bvh
        .visit(ahead, |triangle| candidates.push(triangle));
    for &triangle in candidates.iter() {
        piece.assign_translated(cell, &Vector3::zeros());
        let sign = clip_to_prism(surface, triangle, site, piece, clip);
        if sign != 0.0 && !piece.is_empty() {
            visit(sign, Piece::Convex(piece));
        }
    }
}

/// Whether a ray from somewhere in `around` may hit `bounds`.
fn is_ahead(bounds: &Bounds<3>, around: &Bounds<3>) -> bool {
    let (mut first, mut last) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        first = first.max((bounds.min[axis] - around.max[axis]) / RAY[axis]);
        last = last.min((bounds.max[axis] - around.min[axis]) / RAY[axis]);
    }
    let slack = 1e-9 * (around.extent().max() + first.abs());
    first <= last + slack
}

/// Clips `part` to the triangle's prism; returns the sign with which it counts.
fn clip_to_prism(
    surface: &IndexedSurface,
    triangle: u32,
    site: &Point3<f64>,
    part: &mut Polyhedron,
    scratch: &mut ClipScratch,
) -> f64 {
    let ray = Vector3::from(RAY);
    let numbers = surface.mesh.triangles[triangle as usize];
    let corners = surface.mesh.corners(triangle as usize);
    let corners = corners.map_each(|corner| corner - site);
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let climb = normal.dot(&ray);
    if climb == 0.0 || !climb.is_finite() {
        return 0.0;
    }
    let sign = climb.signum();
    for from in 0..3 {
        let to = (from + 1) % 3;
        // From the lower vertex to the higher, so that neighbors use the same plane.
        let turned = numbers[from] > numbers[to];
        let (a, b) = if turned { (to, from) } else { (from, to) };
        let outward = if turned { -sign } else { sign };
        let side = (corners[b] - corners[a]).cross(&ray);
        let half_space = HalfSpace {
            normal: side * outward,
            offset: side.dot(&corners[a]) * outward,
        };
        if clip(part, &half_space, FacetKind::Inner.label(), scratch) == Clip::Emptied {
            return 0.0;
        }
    }
    let cap = HalfSpace {
        normal: normal * sign,
        offset: normal.dot(&corners[0]) * sign,
    };
    clip(part, &cap, surface.label(triangle), scratch);
    sign
}
