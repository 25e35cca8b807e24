//! Clipping a triangle of the surface to a convex cell.
//!
//! Every corner and every border of the result is named by what made it, so that neighboring
//! triangles agree on what they share. They do so to the last bit: a side is cut by the same planes
//! in the same order in both triangles, and the point where a plane cuts it is interpolated from
//! the kept end to the cut one in both.

use nalgebra::Vector3;

use crate::arrays::MapEach;
use crate::geometry::half_space::HalfSpace;

/// Planes that miss a triangle by this share of the numbers involved are left out without clipping.
/// Far above rounding, so that no plane is left out for one triangle that cuts a side of another.
const CLEAR: f64 = 1e-12;

/// What made a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Origin {
    /// It is this vertex of the surface.
    Vertex(u32),
    /// The plane cuts this edge of the surface.
    Side { edge: u32, plane: u32 },
    /// Two planes meet within the triangle.
    Within,
}

/// What made a border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Border {
    /// It lies on this edge of the surface.
    Side(u32),
    /// It lies on this plane of the cell.
    Plane(u32),
}

/// A corner and the border that leaves it, counter-clockwise from outside the solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    pub(crate) position: Vector3<f64>,
    pub(crate) origin: Origin,
    pub(crate) border: Border,
}

/// A plane of a cell, by its number there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetPlane {
    pub(crate) number: u32,
    pub(crate) half_space: HalfSpace,
    /// Bounds how fast the excess grows with the largest coordinate.
    steepness: f64,
}

impl FacetPlane {
    pub(crate) fn new(number: u32, half_space: HalfSpace) -> Self {
        let steepness = 3.0 * half_space.normal.amax();
        Self {
            number,
            half_space,
            steepness,
        }
    }
}

/// The memory of [`TriangleClip::clip`].
#[derive(Clone, Debug, Default)]
pub(crate) struct TriangleClip {
    corners: Vec<Corner>,
    spare: Vec<Corner>,
    /// The planes that may cut the triangle.
    cutting: Vec<u32>,
}

impl TriangleClip {
    /// The part of a triangle within all `planes`, as a convex polygon; empty if there is none.
    pub(crate) fn clip(&mut self, triangle: &[Corner; 3], planes: &[FacetPlane]) -> &[Corner] {
        self.corners.clear();
        self.cutting.clear();
        let size = triangle
            .iter()
            .fold(0.0, |size: f64, corner| size.max(corner.position.amax()));
        for (place, plane) in planes.iter().enumerate() {
            match side(triangle, size, plane) {
                Some(TriangleSide::Beyond) => return &[],
                Some(TriangleSide::Within) => {}
                None => self.cutting.push(place as u32),
            }
        }
        self.corners.extend(triangle);
        for place in 0..self.cutting.len() {
            self.cut(&planes[self.cutting[place] as usize]);
        }
        &self.corners
    }

    fn cut(&mut self, plane: &FacetPlane) {
        let Self { corners, spare, .. } = self;
        spare.clear();
        for (place, corner) in corners.iter().enumerate() {
            let following = &corners[(place + 1) % corners.len()];
            let [here, there] =
                [corner, following].map_each(|c| excess(&plane.half_space, &c.position));
            if here <= 0.0 {
                spare.push(*corner);
            }
            if (here <= 0.0) == (there <= 0.0) {
                continue;
            }
            spare.push(crossing([corner, following], [here, there], plane.number));
        }
        std::mem::swap(corners, spare);
    }
}

/// The corner in which the border between two corners of these excesses crosses a plane.
fn crossing([corner, following]: [&Corner; 2], [here, there]: [f64; 2], plane: u32) -> Corner {
    let [from, to] = [&corner.position, &following.position];
    let origin = match corner.border {
        Border::Side(edge) => Origin::Side { edge, plane },
        Border::Plane(_) => Origin::Within,
    };
    let (position, border) = if here <= 0.0 {
        (between(from, to, here, there), Border::Plane(plane))
    } else {
        (between(to, from, there, here), corner.border)
    };
    Corner {
        position,
        origin,
        border,
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TriangleSide {
    Within,
    Beyond,
}

/// On which side of the plane the whole triangle lies, if that is clear. `size` is its largest
/// coordinate.
fn side(triangle: &[Corner; 3], size: f64, plane: &FacetPlane) -> Option<TriangleSide> {
    let [a, b, c] = triangle
        .each_ref()
        .map_each(|corner| excess(&plane.half_space, &corner.position));
    let clear = CLEAR * (plane.steepness * size + plane.half_space.offset.abs());
    if a > clear && b > clear && c > clear {
        Some(TriangleSide::Beyond)
    } else if a < -clear && b < -clear && c < -clear {
        Some(TriangleSide::Within)
    } else {
        None
    }
}

fn excess(plane: &HalfSpace, position: &Vector3<f64>) -> f64 {
    plane.normal.dot(position) - plane.offset
}

/// The point between a kept and a cut one in which the excess is zero.
fn between(
    kept: &Vector3<f64>,
    cut: &Vector3<f64>,
    kept_excess: f64,
    cut_excess: f64,
) -> Vector3<f64> {
    kept + (cut - kept) * (kept_excess / (kept_excess - cut_excess))
}
