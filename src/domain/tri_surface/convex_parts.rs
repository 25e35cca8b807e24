//! The part of a convex polyhedron within a surface, as convex polyhedra that do not overlap.
//!
//! A binary space partition: the polyhedron is split by the plane of a triangle that crosses its interior,
//! and each side again by those that cross it, until none does. What is left lies within the surface or
//! outside as its middle does. Both sides of a split come from one plane, so nothing is lost or counted
//! twice; every triangle splits a part once at most, so the splits end.

use nalgebra::{Point3, Vector3};

use crate::domain::facet_kind::FacetKind;
use crate::domain::tri_surface::indexed::IndexedSurface;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;

/// A triangle that reaches less deep into a part than this share of the largest coordinate lies on its
/// border: a few roundings of a plane's offset.
const DEPTH: f64 = 32.0 * f64::EPSILON;

/// Visits convex polyhedra that fill what `part`, in coordinates relative to `site`, has within the surface.
pub(crate) fn convex_parts(
    surface: &IndexedSurface,
    site: &Point3<f64>,
    part: &Polyhedron,
    scratch: &mut ClipScratch,
    visit: &mut dyn FnMut(&Polyhedron),
) {
    let (bounds, mut near) = (&surface.bounds, Vec::new());
    let depth = DEPTH * bounds.min.coords.amax().max(bounds.max.coords.amax());
    surface.candidates(site, part, &mut near);
    let mut rest = vec![(part.clone(), near)];
    while let Some((part, mut triangles)) = rest.pop() {
        let planes: Vec<HalfSpace> = part.facets().map(|f| f.half_space().normalized()).collect();
        triangles
            .retain(|&triangle| reaches_into(&corners(surface, triangle, site), &planes, depth));
        if triangles.is_empty() {
            if surface.contains(&(site + middle(&part))) {
                visit(&part);
            }
            continue;
        }
        let splitting = triangles.swap_remove(triangles.len() / 2);
        let [a, b, c] = corners(surface, splitting, site);
        let normal = (b - a).cross(&(c - a));
        let behind = HalfSpace {
            normal,
            offset: normal.dot(&a),
        };
        let before = HalfSpace {
            normal: -normal,
            offset: -behind.offset,
        };
        for side in [behind, before] {
            let mut half = part.clone();
            if clip(&mut half, &side, FacetKind::Inner.label(), scratch) != Clip::Emptied {
                rest.push((half, triangles.clone()));
            }
        }
    }
}

/// A triangle's corners relative to `site`.
fn corners(surface: &IndexedSurface, triangle: u32, site: &Point3<f64>) -> [Vector3<f64>; 3] {
    surface
        .mesh
        .corners(triangle as usize)
        .map(|corner| corner - site)
}

/// The mean of the vertices.
fn middle(part: &Polyhedron) -> Vector3<f64> {
    let sum: Vector3<f64> = part.vertices().map(|vertex| vertex.coords).sum();
    sum / part.vertex_count().max(1) as f64
}

/// Whether a point of the triangle lies deeper than `depth` behind every plane: the triangle is cut by each
/// of them in turn (Sutherland & Hodgman, *Reentrant polygon clipping*, 1974).
fn reaches_into(corners: &[Vector3<f64>; 3], planes: &[HalfSpace], depth: f64) -> bool {
    let mut polygon = corners.to_vec();
    for plane in planes {
        let excess = |point: &Vector3<f64>| plane.normal.dot(point) - plane.offset + depth;
        let mut cut = Vec::with_capacity(polygon.len() + 1);
        for (k, from) in polygon.iter().enumerate() {
            let to = &polygon[(k + 1) % polygon.len()];
            let (before, after) = (excess(from), excess(to));
            if before < 0.0 {
                cut.push(*from);
            }
            if (before < 0.0) != (after < 0.0) {
                cut.push(from.lerp(to, before / (before - after)));
            }
        }
        polygon = cut;
    }
    !polygon.is_empty()
}
