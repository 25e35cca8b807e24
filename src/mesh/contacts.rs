//! Contacts: the triangles of a surface that meet other than at their common corners and edges.
//!
//! Two triangles meet along the part of the line common to their planes that lies in both (Möller,
//! *A fast triangle-triangle intersection test*, 1997), or in an area of a common plane. What is
//! nearer than a few roundings of the coordinates counts as touching.

use nalgebra::{Point3, Vector3};

use crate::mesh::surface::SurfaceMesh;
use crate::mesh::triangle_tree::TriangleTree;

/// Two triangles that meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// The lower number first.
    pub(crate) triangles: [u32; 2],
    /// Where they meet.
    pub(crate) place: Meeting,
}

/// Where two triangles meet.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Meeting {
    /// Along a segment.
    Segment([Point3<f64>; 2]),
    /// In a common plane.
    Plane,
}

/// The triangles' unit normals, zero for those without area.
#[derive(Debug)]
pub(crate) struct Normals(Vec<Vector3<f64>>);

/// A triangle whose height is below this share of its longest edge has no usable normal.
const FLAT: f64 = 1e-14;

impl Normals {
    /// Of all triangles.
    #[must_use]
    pub(crate) fn of(mesh: &SurfaceMesh) -> Self {
        let normal = |[a, b, c]: [Point3<f64>; 3]| {
            let sides = [b - a, c - b, a - c];
            let longest = sides.iter().map(Vector3::norm_squared).fold(0.0, f64::max);
            let area = sides[0].cross(&sides[1]);
            let length = area.norm();
            if length > FLAT * longest {
                area / length
            } else {
                Vector3::zeros()
            }
        };
        Self(mesh.all_corners().map(normal).collect())
    }

    /// The unit normal of a triangle, outward; `None` without area.
    #[must_use]
    pub(crate) fn get(&self, triangle: u32) -> Option<&Vector3<f64>> {
        let normal = &self.0[triangle as usize];
        (normal.norm_squared() > 0.0).then_some(normal)
    }
}

/// All contacts, with `touch` the distance (L) up to which triangles touch; sorted.
#[must_use]
pub(crate) fn contacts(mesh: &SurfaceMesh, normals: &Normals, touch: f64) -> Vec<Contact> {
    let count = mesh.triangles.len() as u32;
    let mut solid: Vec<u32> = (0..count).filter(|&t| normals.get(t).is_some()).collect();
    if solid.is_empty() {
        return Vec::new();
    }
    let tree = TriangleTree::new(mesh, &mut solid);
    let mut found = tree.pairs(touch, &|one, other| {
        let triangles = [one.min(other), one.max(other)];
        let place = Pair::new(mesh, normals, triangles, touch)?.meeting()?;
        Some(Contact { triangles, place })
    });
    found.sort_unstable_by_key(|contact| contact.triangles);
    found
}

/// Two triangles, and the distances of the corners of each from the plane of the other.
struct Pair {
    corners: [[Point3<f64>; 3]; 2],
    normals: [Vector3<f64>; 2],
    heights: [[f64; 3]; 2],
    touch: f64,
}

impl Pair {
    /// The pair, unless a plane of one of them parts it, or all but its common corners.
    fn new(mesh: &SurfaceMesh, normals: &Normals, triangles: [u32; 2], touch: f64) -> Option<Self> {
        let numbers = triangles.map(|triangle| mesh.triangles[triangle as usize]);
        let normals = [*normals.get(triangles[0])?, *normals.get(triangles[1])?];
        let corners = triangles.map(|triangle| mesh.corners(triangle as usize));
        let mut heights = [[0.0; 3]; 2];
        for one in 0..2 {
            let other = 1 - one;
            let base = corners[other][0];
            let (mut above, mut below, mut apart) = (0, 0, 0);
            for k in 0..3 {
                if !numbers[other].contains(&numbers[one][k]) {
                    let height = (corners[one][k] - base).dot(&normals[other]);
                    heights[one][k] = height;
                    apart += 1;
                    above += usize::from(height > touch);
                    below += usize::from(height < -touch);
                }
            }
            if apart > 0 && (above == apart || below == apart) {
                return None;
            }
        }
        Some(Self {
            corners,
            normals,
            heights,
            touch,
        })
    }

    fn meeting(&self) -> Option<Meeting> {
        let in_plane = |heights: &[f64; 3]| heights.iter().all(|h| h.abs() <= self.touch);
        if self.heights.iter().any(in_plane) {
            return self.overlap_in_plane().then_some(Meeting::Plane);
        }
        let line = self.normals[0].cross(&self.normals[1]).try_normalize(0.0)?;
        let [one, other] = [self.chord(0, &line)?, self.chord(1, &line)?];
        let from = one[0].0.max(other[0].0);
        let to = one[1].0.min(other[1].0);
        if to - from <= 4.0 * self.touch {
            return None;
        }
        let [(low, start), (high, end)] = one;
        let at = |along: f64| start + (end - start) * ((along - low) / (high - low));
        Some(Meeting::Segment([at(from), at(to)]))
    }

    /// The ends of the part of a triangle in the plane of the other, with their places along `line`.
    fn chord(&self, one: usize, line: &Vector3<f64>) -> Option<[(f64, Point3<f64>); 2]> {
        let (corners, heights) = (&self.corners[one], &self.heights[one]);
        let origin = self.corners[0][0];
        let mut ends: Option<[(f64, Point3<f64>); 2]> = None;
        let mut add = |point: Point3<f64>| {
            let along = (point - origin).dot(line);
            let [low, high] = ends.get_or_insert([(along, point); 2]);
            if along < low.0 {
                *low = (along, point);
            }
            if along > high.0 {
                *high = (along, point);
            }
        };
        for k in 0..3 {
            let next = (k + 1) % 3;
            let [here, there] = [heights[k], heights[next]];
            if here.abs() <= self.touch {
                add(corners[k]);
            }
            if here * there < 0.0 {
                add(corners[k] + (corners[next] - corners[k]) * (here / (here - there)));
            }
        }
        ends
    }

    /// Whether triangles in one plane have more in common than sides: no side of either parts them.
    fn overlap_in_plane(&self) -> bool {
        let parts = |one: usize, k: usize| {
            let corners = &self.corners[one];
            let side = corners[(k + 1) % 3] - corners[k];
            let Some(outward) = side.cross(&self.normals[one]).try_normalize(0.0) else {
                return false;
            };
            let beyond = |corner: &Point3<f64>| (corner - corners[k]).dot(&outward) > -self.touch;
            self.corners[1 - one].iter().all(beyond)
        };
        !(0..6).any(|side| parts(side / 3, side % 3))
    }
}
