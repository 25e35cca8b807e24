//! Volumes that a closed surface encloses more than once, or less than nothing.
//!
//! A closed surface bounds a solid if its winding number w is 0 or 1 everywhere. Of any other, the
//! signed volume is ∫ w, and that of the union of its parts falls short of it by
//! E = ∫ max(w − 1, 0), the part counted more than once; N = ∫ max(−w, 0) is the part that is
//! subtracted where nothing is. By the divergence theorem ∫ f(w) is a sum of cones over the pieces
//! of the triangles on whose two sides w is constant,
//!
//! ∫ f(w) = Σ (f(w_in) − f(w_out)) / (w_in − w_out) · volume of the cone over the piece,
//!
//! the quotient sharing out among sheets that coincide. Triangles that meet no others form patches
//! of constant w, one sample for each; the others are cut where they meet (`contacts`), every piece
//! has its own sample. w is exact (`winding`), a few roundings to either side of the piece, so that
//! sheets which differ by rounding count as one.

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::geometry::double_double::six_volume;
use crate::mesh::contacts::{Contact, Meeting, Normals, contacts};
use crate::mesh::cut::{Cut, divide};
use crate::mesh::edges::{EdgeTable, NO_PARTNER};
use crate::mesh::report::Overlap;
use crate::mesh::surface::{SurfaceMesh, triangle_area};
use crate::mesh::winding::winding;
use crate::parallel::map;

/// Triangles nearer than this many roundings of the greatest coordinate touch.
const TOUCH: f64 = 8.0 * f64::EPSILON;

/// The distance of samples from a piece, in the greatest coordinate: beyond what touches.
const STEP: f64 = 64.0 * f64::EPSILON;

/// What a surface encloses that it should not.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Overlaps {
    /// E: enclosed more than once.
    pub(crate) repeated: Option<Overlap>,
    /// N: enclosed a negative number of times.
    pub(crate) negative: Option<Overlap>,
}

/// What the closed surface `mesh`, whose edges are `edges`, encloses wrongly.
#[must_use]
pub(crate) fn overlaps(mesh: &SurfaceMesh, edges: &EdgeTable) -> Overlaps {
    let size = size(mesh);
    if !size.is_normal() {
        return Overlaps::default();
    }
    // Scaled by a power of two, exactly, so that no product of coordinates overflows.
    let scale = size.log2().floor().exp2();
    let search = Search::new(mesh, scale);
    let parts = search.parts(edges);
    let found = |f: fn(i32) -> i32| {
        let overlap = search.overlap(&parts, f)?;
        Some(Overlap {
            volume: overlap.volume * scale.powi(3),
            place: overlap.place * scale,
            ..overlap
        })
    };
    Overlaps {
        repeated: found(|winding| (winding - 1).max(0)),
        negative: found(|winding| (-winding).max(0)),
    }
}

/// A place where walls lie on each other from both sides, as those of parts that touch do.
#[must_use]
pub(crate) fn touching_walls(mesh: &SurfaceMesh) -> Option<Point3<f64>> {
    let normals = Normals::of(mesh);
    let found = contacts(mesh, &normals, TOUCH * size(mesh));
    let contact = found.into_iter().find(|contact| {
        let [one, other] = contact.triangles.map(|triangle| normals.get(triangle));
        let is_opposite = one
            .zip(other)
            .is_some_and(|(one, other)| one.dot(other) < 0.0);
        is_opposite && matches!(contact.place, Meeting::Plane)
    })?;
    // The center of the smaller triangle is nearer to where they lie on each other.
    let [one, other] = contact
        .triangles
        .map(|triangle| mesh.corners(triangle as usize));
    let [a, b, c] = match triangle_area(&one) <= triangle_area(&other) {
        true => one,
        false => other,
    };
    Some(Point3::from((a.coords + b.coords + c.coords) / 3.0))
}

/// The greatest coordinate.
fn size(mesh: &SurfaceMesh) -> f64 {
    let Bounds { min, max } = mesh.bounds();
    min.coords.amax().max(max.coords.amax())
}

/// A piece of a triangle with other winding numbers than 1 within and 0 outside.
struct Part {
    triangle: u32,
    corners: Vec<Point3<f64>>,
    /// The winding numbers within and outside.
    sides: [i32; 2],
}

/// The surface with what samples need.
struct Search {
    mesh: SurfaceMesh,
    normals: Normals,
    tree: Bvh,
    touch: f64,
    step: f64,
}

impl Search {
    fn new(mesh: &SurfaceMesh, scale: f64) -> Self {
        let mut mesh = mesh.clone();
        for vertex in &mut mesh.vertices {
            *vertex /= scale;
        }
        let size = size(&mesh);
        Self {
            normals: Normals::of(&mesh),
            tree: Bvh::new(mesh.all_corners().map(|corners| Bounds::of(&corners))),
            touch: TOUCH * size,
            step: STEP * size,
            mesh,
        }
    }

    fn parts(&self, edges: &EdgeTable) -> Vec<Part> {
        let contacts = contacts(&self.mesh, &self.normals, self.touch);
        let mut cuts = vec![Vec::new(); self.mesh.triangles.len()];
        for contact in &contacts {
            let [one, other] = contact.triangles;
            for (cut, by) in [(one, other), (other, one)] {
                self.push_cuts(contact, cut, by, &mut cuts[cut as usize]);
            }
        }
        let mut parts = self.patches(edges, &cuts);
        let of_touched = map(cuts.len(), &|triangle| match &cuts[triangle][..] {
            [] => Vec::new(),
            cuts => self.pieces(triangle as u32, cuts),
        });
        parts.extend(of_touched.into_iter().flatten());
        parts
    }

    /// Appends the cuts of a triangle where it meets another.
    fn push_cuts(&self, contact: &Contact, triangle: u32, by: u32, cuts: &mut Vec<Cut>) {
        let Some(normal) = self.normals.get(triangle) else {
            return;
        };
        match contact.place {
            Meeting::Segment(ends) => cuts.extend(Cut::along(ends, normal)),
            Meeting::Plane => {
                let [a, b, c] = self.mesh.corners(by as usize);
                let sides = [[a, b], [b, c], [c, a]];
                cuts.extend(sides.iter().filter_map(|&side| Cut::along(side, normal)));
            }
        }
    }

    /// The triangles without cuts, patch by patch across edges of two: of each patch the greatest
    /// triangle is sampled.
    fn patches(&self, edges: &EdgeTable, cuts: &[Vec<Cut>]) -> Vec<Part> {
        let partners = edges.partners();
        let is_clear = |triangle: u32| {
            cuts[triangle as usize].is_empty() && self.normals.get(triangle).is_some()
        };
        let mut seen = vec![false; cuts.len()];
        let mut parts = Vec::new();
        for first in 0..cuts.len() as u32 {
            if seen[first as usize] || !is_clear(first) {
                continue;
            }
            seen[first as usize] = true;
            let mut patch = vec![first];
            let mut next = 0;
            while let Some(&triangle) = patch.get(next) {
                next += 1;
                let sides = 3 * triangle as usize..3 * triangle as usize + 3;
                for &partner in partners[sides].iter().filter(|&&side| side != NO_PARTNER) {
                    let neighbor = partner / 3;
                    if !seen[neighbor as usize] && is_clear(neighbor) {
                        seen[neighbor as usize] = true;
                        patch.push(neighbor);
                    }
                }
            }
            self.push_patch(&patch, &mut parts);
        }
        parts
    }

    fn push_patch(&self, patch: &[u32], parts: &mut Vec<Part>) {
        let area = |&triangle: &u32| triangle_area(&self.mesh.corners(triangle as usize));
        let greatest = patch
            .iter()
            .copied()
            .max_by(|a, b| area(a).total_cmp(&area(b)));
        let sides = greatest.and_then(|t| self.sides(t, &self.mesh.corners(t as usize)));
        if let Some(sides) = sides.filter(|&sides| sides != [1, 0]) {
            parts.extend(patch.iter().map(|&triangle| Part {
                triangle,
                corners: self.mesh.corners(triangle as usize).to_vec(),
                sides,
            }));
        }
    }

    fn pieces(&self, triangle: u32, cuts: &[Cut]) -> Vec<Part> {
        let whole = self.mesh.corners(triangle as usize).to_vec();
        let pieces = divide(whole, cuts, self.touch);
        let part = |corners: Vec<Point3<f64>>| {
            let sides = self.sides(triangle, &corners).filter(|&s| s != [1, 0])?;
            Some(Part {
                triangle,
                corners,
                sides,
            })
        };
        pieces.into_iter().filter_map(part).collect()
    }

    /// The winding numbers within and outside a convex piece of a triangle, beside its middle.
    fn sides(&self, triangle: u32, corners: &[Point3<f64>]) -> Option<[i32; 2]> {
        let step = self.normals.get(triangle)? * self.step;
        let sum: Vector3<f64> = corners.iter().map(|corner| corner.coords).sum();
        let middle = Point3::from(sum / corners.len() as f64);
        // A sample on another triangle moves toward a corner.
        let samples = corners
            .iter()
            .map(|corner| middle + (corner - middle) * 0.13);
        std::iter::once(middle).chain(samples).find_map(|sample| {
            let inside = self.winding(&(sample - step))?;
            let outside = self.winding(&(sample + step))?;
            Some([inside, outside])
        })
    }

    fn winding(&self, point: &Point3<f64>) -> Option<i32> {
        winding(&self.mesh, &self.tree, point)
    }

    /// ∫ f(w) with a place, if f is not 0 beside any piece that is more than a sliver.
    fn overlap(&self, parts: &[Part], f: fn(i32) -> i32) -> Option<Overlap> {
        let change = |part: &Part| f(part.sides[0]) - f(part.sides[1]);
        let wrong = || parts.iter().filter(|&part| change(part) != 0);
        let areas = wrong().filter(|part| !self.is_sliver(part));
        let greatest =
            areas.max_by(|a, b| fan_area(&a.corners).total_cmp(&fan_area(&b.corners)))?;
        let apex = greatest.corners[0];
        let six = wrong().map(|part| {
            let share = f64::from(change(part)) / f64::from(part.sides[0] - part.sides[1]);
            share
                * fan(&part.corners)
                    .map(|t| six_volume(&apex, t))
                    .sum::<f64>()
        });
        Some(Overlap {
            volume: six.sum::<f64>() / 6.0,
            place: self.place_beside(greatest, change(greatest) > 0, f),
            element: greatest.triangle,
        })
    }

    fn is_sliver(&self, part: &Part) -> bool {
        let ends = part.corners.iter().zip(part.corners.iter().cycle().skip(1));
        let around: f64 = ends.map(|(a, b)| (b - a).norm()).sum();
        fan_area(&part.corners) <= self.step * around
    }

    /// A point at which f(w) is not 0: halfway from the piece to the next triangle, inward or outward.
    fn place_beside(&self, part: &Part, inward: bool, f: fn(i32) -> i32) -> Point3<f64> {
        let sum: Vector3<f64> = part.corners.iter().map(|corner| corner.coords).sum();
        let middle = Point3::from(sum / part.corners.len() as f64);
        let normal = self.normals.get(part.triangle).copied().unwrap_or_default();
        let away = if inward { -normal } else { normal };
        let start = middle + away * self.step;
        let exits = self
            .mesh
            .all_corners()
            .filter_map(|corners| hit(&corners, &start, &away));
        let deep = start + away * (exits.fold(f64::INFINITY, f64::min) / 2.0);
        let is_right = |point: &Point3<f64>| self.winding(point).is_some_and(|w| f(w) > 0);
        if deep.coords.amax().is_finite() && is_right(&deep) {
            deep
        } else {
            start
        }
    }
}

/// The triangles from a convex polygon's first corner.
fn fan(corners: &[Point3<f64>]) -> impl Iterator<Item = [&Point3<f64>; 3]> {
    corners[1..]
        .windows(2)
        .map(|pair| [&corners[0], &pair[0], &pair[1]])
}

fn fan_area(corners: &[Point3<f64>]) -> f64 {
    fan(corners)
        .map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0)
        .sum()
}

/// How far along a ray a triangle lies: Möller & Trumbore, *Fast, minimum storage ray/triangle
/// intersection*, 1997.
fn hit([a, b, c]: &[Point3<f64>; 3], from: &Point3<f64>, along: &Vector3<f64>) -> Option<f64> {
    let [one, two, arm] = [b - a, c - a, from - a];
    let (across, turned) = (along.cross(&two), arm.cross(&one));
    let height = one.dot(&across);
    let (u, v) = (arm.dot(&across) / height, along.dot(&turned) / height);
    let distance = two.dot(&turned) / height;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
}
