//! Cylindrical holes of a surface: axis, radius, how well they fit.
//!
//! From a seed triangle its smooth neighborhood is taken (edges bent by less than [`SMOOTH`]); its normals lie
//! nearly in a plane, whose normal is a first axis, and its vertices on a circle about it. The triangles that
//! hang together and fit that cylinder, turned towards its axis as the wall of a hole is, are grown from the
//! seed, the cylinder is fitted to their vertices by least squares of the distances (Gauss-Newton in five
//! unknowns), and so again until the patch no longer changes much.

use std::collections::BTreeSet;

use nalgebra::{Matrix2, Matrix3, Matrix5, Point3, SymmetricEigen, Vector2, Vector3, Vector5};

use crate::mesh::edges::{EdgeTable, NO_PARTNER};
use crate::mesh::surface::SurfaceMesh;

/// The cosine of the largest angle (40°) between neighbors of one smooth patch.
const SMOOTH: f64 = 0.766;

/// Triangles from which a first cylinder is made.
const NEIGHBORHOOD: usize = 40;

/// So many of them are as good as their seed.
const ALIKE: usize = 12;

/// The second smallest spread of a neighborhood's normals, as a share of the largest: less is flat.
const LEAST_CURVED: f64 = 2e-3;

/// Triangles fit a cylinder where vertices lie within this share of the radius, and the normal within 15°.
const FIT_DISTANCE: f64 = 0.03;
const FIT_NORMAL: f64 = 0.966;

/// Rounds of growing and fitting.
const ROUNDS: usize = 6;

/// A hole's wall covers this share of the circle at least.
const LEAST_COVERED: f64 = 0.75;

/// Sectors in which the covered share is counted.
const SECTORS: usize = 72;

/// A hole's wall has so many triangles at least.
const LEAST_TRIANGLES: usize = 12;

/// A cylindrical hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bore {
    /// The point of its axis in the middle of its length.
    pub(crate) point: Point3<f64>,
    /// The unit direction of its axis, the largest coordinate positive.
    pub(crate) direction: Vector3<f64>,
    /// Its radius (L).
    pub(crate) radius: f64,
    /// The root mean square of the wall's vertices' distances from the cylinder (L).
    pub(crate) rms: f64,
    /// Its wall's length along the axis (L).
    pub(crate) length: f64,
    /// The share of the circle that its wall covers.
    pub(crate) covered: f64,
    /// How many triangles its wall has.
    pub(crate) triangles: usize,
}

/// The cylindrical holes of a surface, the widest first.
pub(crate) fn bores(mesh: &SurfaceMesh) -> Vec<Bore> {
    let mut found = BoreSearch::new(mesh).holes();
    found.sort_by(|one: &Bore, other| other.radius.total_cmp(&one.radius));
    found
}

/// An infinite cylinder.
#[derive(Clone, Copy, Debug)]
struct Cylinder {
    point: Point3<f64>,
    direction: Vector3<f64>,
    radius: f64,
}

/// A surface with its neighbors and normals.
struct BoreSearch<'a> {
    mesh: &'a SurfaceMesh,
    partners: Vec<u32>,
    normals: Vec<Vector3<f64>>,
}

impl Cylinder {
    /// The way from the axis to a place.
    fn arm(&self, place: &Point3<f64>) -> Vector3<f64> {
        let way = place - self.point;
        way - self.direction * way.dot(&self.direction)
    }

    /// One step of Gauss-Newton on the vertices' distances from the cylinder.
    fn refined(&self, vertices: &[Point3<f64>]) -> Option<Self> {
        let [u, v] = across(&self.direction);
        let (mut matrix, mut right) = (Matrix5::zeros(), Vector5::zeros());
        for place in vertices {
            let arm = self.arm(place);
            let distance = arm.norm();
            let outward = arm / distance;
            let height = (place - self.point).dot(&self.direction) / self.radius;
            let (a, b) = (outward.dot(&u), outward.dot(&v));
            let row = Vector5::new(-a, -b, -height * a, -height * b, -1.0);
            matrix += row * row.transpose();
            right -= row * (distance - self.radius);
        }
        let step = matrix.cholesky()?.solve(&right);
        let turned = self.direction + (u * step[2] + v * step[3]) / self.radius;
        Some(Self {
            point: self.point + u * step[0] + v * step[1],
            direction: turned.normalize(),
            radius: self.radius + step[4],
        })
    }

    /// Fitted to vertices.
    fn fitted(mut self, vertices: &[Point3<f64>]) -> Option<Self> {
        for _ in 0..20 {
            let next = self.refined(vertices)?;
            let moved = (next.point - self.point).norm() + (next.radius - self.radius).abs();
            let is_sound = next.radius > 0.2 * self.radius && next.radius < 5.0 * self.radius;
            if !is_sound {
                return None;
            }
            self = next;
            if moved < 1e-13 * self.radius {
                break;
            }
        }
        Some(self)
    }
}

impl<'a> BoreSearch<'a> {
    fn new(mesh: &'a SurfaceMesh) -> Self {
        let normal = |[a, b, c]: [Point3<f64>; 3]| {
            let area = (b - a).cross(&(c - a));
            area.try_normalize(0.0).unwrap_or_default()
        };
        Self {
            mesh,
            partners: EdgeTable::of(&mesh.triangles, mesh.vertices.len()).partners(),
            normals: mesh.all_corners().map(normal).collect(),
        }
    }

    /// The hole to whose wall the first of these neighbors belongs, with its triangles.
    fn hole_at(&self, near: &[usize]) -> Option<(Bore, Vec<usize>)> {
        let seed = near[0];
        let mut cylinder = self.first_cylinder(near)?;
        let mut wall = Vec::new();
        for _ in 0..ROUNDS {
            let grown = self.grown(seed, usize::MAX, |triangle| self.fits(&cylinder, triangle));
            if grown.len() < LEAST_TRIANGLES {
                return None;
            }
            let is_settled = grown.len() == wall.len();
            wall = grown;
            cylinder = cylinder.fitted(&self.vertices(&wall))?;
            if is_settled {
                break;
            }
        }
        let bore = self.bore(&cylinder, &wall);
        (bore.covered >= LEAST_COVERED).then_some((bore, wall))
    }

    /// The holes in the order of their first triangles.
    fn holes(&self) -> Vec<Bore> {
        let mut is_free = vec![true; self.mesh.triangles.len()];
        let mut found = Vec::new();
        for seed in 0..self.mesh.triangles.len() {
            if !is_free[seed] {
                continue;
            }
            let near = self.grown(seed, NEIGHBORHOOD, |_| true);
            let hole = self.hole_at(&near);
            // Where a seed fails, those next to it would too.
            let failed = near.into_iter().take(ALIKE).collect();
            let done = hole.map_or(failed, |(bore, wall)| {
                found.push(bore);
                wall
            });
            for triangle in done {
                is_free[triangle] = false;
            }
        }
        found
    }

    /// Up to `most` triangles that hang together with `seed` smoothly and are wanted.
    fn grown(&self, seed: usize, most: usize, is_wanted: impl Fn(usize) -> bool) -> Vec<usize> {
        if !is_wanted(seed) {
            return Vec::new();
        }
        let (mut list, mut seen) = (vec![seed], BTreeSet::from([seed]));
        let mut next = 0;
        while next < list.len() && list.len() < most {
            let triangle = list[next];
            next += 1;
            for other in self.continued(triangle) {
                if !seen.contains(&other) && is_wanted(other) {
                    seen.insert(other);
                    list.push(other);
                }
            }
        }
        list
    }

    /// The triangles that continue one smoothly.
    fn continued(&self, triangle: usize) -> impl Iterator<Item = usize> {
        let partners = self.partners[3 * triangle..3 * triangle + 3].iter();
        let partners = partners.filter(|&&partner| partner != NO_PARTNER);
        let others = partners.map(|&partner| partner as usize / 3);
        others.filter(move |&other| self.normals[triangle].dot(&self.normals[other]) > SMOOTH)
    }

    /// The vertices of triangles, each once.
    fn vertices(&self, triangles: &[usize]) -> Vec<Point3<f64>> {
        let corners = triangles.iter().flat_map(|&t| self.mesh.triangles[t]);
        let distinct: BTreeSet<u32> = corners.collect();
        let vertices = distinct.into_iter();
        vertices.map(|v| self.mesh.vertices[v as usize]).collect()
    }

    /// The cylinder of a neighborhood, if it is curved in one direction and the wall of a hole.
    fn first_cylinder(&self, triangles: &[usize]) -> Option<Cylinder> {
        let spread: Matrix3<f64> = triangles
            .iter()
            .map(|&t| self.normals[t] * self.normals[t].transpose())
            .sum();
        let eigen = SymmetricEigen::new(spread);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let [least, middle, largest] = order.map(|place| eigen.eigenvalues[place]);
        if middle < LEAST_CURVED * largest || least > 0.2 * middle {
            return None;
        }
        let direction: Vector3<f64> = eigen.eigenvectors.column(order[0]).into();
        let cylinder = circle(&self.vertices(triangles), direction)?;
        self.fits(&cylinder, triangles[0]).then_some(cylinder)
    }

    /// Whether a triangle lies on a cylinder, turned towards its axis.
    fn fits(&self, cylinder: &Cylinder, triangle: usize) -> bool {
        let corners = self.mesh.corners(triangle);
        let is_near = |corner: &Point3<f64>| {
            let off = cylinder.arm(corner).norm() - cylinder.radius;
            off.abs() <= FIT_DISTANCE * cylinder.radius
        };
        let middle: Vector3<f64> = corners.iter().map(|c| c.coords).sum();
        let arm = cylinder.arm(&Point3::from(middle / 3.0));
        let inward = -arm.dot(&self.normals[triangle]);
        inward >= FIT_NORMAL * arm.norm() && corners.iter().all(is_near)
    }

    /// The figures of a wall.
    fn bore(&self, cylinder: &Cylinder, wall: &[usize]) -> Bore {
        let vertices = self.vertices(wall);
        let sum: f64 = vertices
            .iter()
            .map(|place| (cylinder.arm(place).norm() - cylinder.radius).powi(2))
            .sum();
        let height = |place: &Point3<f64>| (place - cylinder.point).dot(&cylinder.direction);
        let heights = vertices.iter().map(height);
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        let direction = cylinder.direction;
        Bore {
            point: cylinder.point + direction * (0.5 * (low + high)),
            direction: direction * direction[direction.iamax()].signum(),
            radius: cylinder.radius,
            rms: (sum / vertices.len() as f64).sqrt(),
            length: high - low,
            covered: self.covered(cylinder, wall),
            triangles: wall.len(),
        }
    }

    /// The share of the circle that a wall's triangles cover.
    fn covered(&self, cylinder: &Cylinder, wall: &[usize]) -> f64 {
        let [u, v] = across(&cylinder.direction);
        let mut sectors = [false; SECTORS];
        let turn = std::f64::consts::TAU;
        for &triangle in wall {
            let angles = self.mesh.corners(triangle).map(|corner| {
                let arm = cylinder.arm(&corner);
                arm.dot(&v).atan2(arm.dot(&u))
            });
            let from = angles[0];
            let off = angles.map(|angle| (angle - from + 1.5 * turn).rem_euclid(turn) - 0.5 * turn);
            let (low, high) = off.iter().fold((0.0_f64, 0.0_f64), |(low, high), &at| {
                (low.min(at), high.max(at))
            });
            let sector = |angle: f64| ((from + angle) / turn * SECTORS as f64).floor() as i64;
            for at in sector(low)..=sector(high) {
                sectors[at.rem_euclid(SECTORS as i64) as usize] = true;
            }
        }
        sectors.iter().filter(|&&is_met| is_met).count() as f64 / SECTORS as f64
    }
}

/// The circle nearest to vertices seen along a direction (least squares of x² + y² − 2ax − 2by − c).
fn circle(vertices: &[Point3<f64>], direction: Vector3<f64>) -> Option<Cylinder> {
    let [u, v] = across(&direction);
    let count = vertices.len() as f64;
    let mean = vertices.iter().map(|p| p.coords).sum::<Vector3<f64>>() / count;
    let ways = vertices.iter().map(|place| place.coords - mean);
    let flat = ways.map(|way| Vector2::new(way.dot(&u), way.dot(&v)));
    let flat: Vec<_> = flat.collect();
    let squares = flat.iter().map(Vector2::norm_squared).sum::<f64>() / count;
    let (mut matrix, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for at in &flat {
        matrix += at * at.transpose();
        right += at * (0.5 * (at.norm_squared() - squares));
    }
    let center = matrix.try_inverse()? * right;
    let radius = (center.norm_squared() + squares).sqrt();
    let extent = flat.iter().map(Vector2::norm).fold(0.0, f64::max);
    (radius < 100.0 * extent).then(|| Cylinder {
        point: Point3::from(mean + u * center.x + v * center.y),
        direction,
        radius,
    })
}

/// Two unit vectors perpendicular to a direction and to each other.
fn across(direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let helper = Vector3::ith(direction.iamin(), 1.0);
    let u = helper.cross(direction).normalize();
    [u, direction.cross(&u)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A prism over a ring between an outer and an inner polygon of as many corners, from z = 0 to 1.
    fn tube(corners: u32, outer: f64, inner: f64, middle: [f64; 2]) -> SurfaceMesh {
        let mut mesh = SurfaceMesh::default();
        for (radius, z) in [(outer, 0.0), (outer, 1.0), (inner, 0.0), (inner, 1.0)] {
            for corner in 0..corners {
                let angle = std::f64::consts::TAU * f64::from(corner) / f64::from(corners);
                let [x, y] = [angle.cos(), angle.sin()].map(|share| share * radius);
                mesh.vertices
                    .push(Point3::new(middle[0] + x, middle[1] + y, z));
            }
        }
        for corner in 0..corners {
            let next = (corner + 1) % corners;
            let ring = |ring: u32| [ring * corners + corner, ring * corners + next];
            for [one, other] in
                [[0, 1], [3, 2], [1, 3], [2, 0]].map(|pair: [u32; 2]| pair.map(ring))
            {
                mesh.triangles.push([one[0], one[1], other[1]]);
                mesh.triangles.push([one[0], other[1], other[0]]);
            }
        }
        mesh
    }

    fn append(mesh: &mut SurfaceMesh, part: &SurfaceMesh) {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(&part.vertices);
        let triangles = part.triangles.iter();
        mesh.triangles
            .extend(triangles.map(|t| t.map(|v| v + first)));
    }

    #[test]
    fn a_plate_with_two_holes_has_two_bores() {
        // Two tubes whose outer sides stand for the plate's: outside, curved the other way, are no bores.
        let mut mesh = tube(32, 2.0, 0.5, [0.0, 0.0]);
        append(&mut mesh, &tube(24, 1.5, 0.8, [6.0, 1.0]));
        let rotation = nalgebra::Rotation3::from_euler_angles(0.3, -0.7, 1.9);
        let shift = Vector3::new(4.0, -3.0, 8.0);
        for vertex in &mut mesh.vertices {
            *vertex = rotation * *vertex + shift;
        }
        let found = bores(&mesh);
        assert_eq!(found.len(), 2, "{found:?}");
        for (bore, (radius, x, y, triangles)) in
            found.iter().zip([(0.8, 6.0, 1.0, 48), (0.5, 0.0, 0.0, 64)])
        {
            assert!((bore.radius - radius).abs() < 1e-12, "{bore:?}");
            assert!(bore.rms < 1e-12 && (bore.length - 1.0).abs() < 1e-12);
            assert_eq!((bore.triangles, bore.covered), (triangles, 1.0));
            let wanted = rotation * Point3::new(x, y, 0.5) + shift;
            assert!((bore.point - wanted).norm() < 1e-12, "{bore:?}");
            let along = rotation * Vector3::z();
            assert!(bore.direction.cross(&along).norm() < 1e-12);
        }
    }

    #[test]
    fn solids_without_holes_have_none() {
        let ball = crate::mesh::shapes::icosphere(3);
        assert!(bores(&ball).is_empty());
    }

    #[test]
    #[ignore = "needs ../shared/models"]
    fn the_rocker_arm_has_the_bore_of_the_reference() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../shared/models/rocker-arm.obj");
        let mesh = crate::mesh::formats::read::read_surface(&path).expect("the model");
        let found = bores(&mesh);
        let axis = Vector3::new(0.999_972_85, -0.007_270_18, 0.001_201_18);
        let through = Point3::new(0.0, 0.067_179_41, 0.084_916_92);
        let near = found
            .iter()
            .filter(|bore| bore.direction.cross(&axis).norm() < 0.01);
        let bore = near.max_by_key(|bore| bore.triangles).expect("a bore");
        let off = (bore.point - through).cross(&axis).norm();
        assert!(
            off < 1e-3 && (bore.radius - 0.124_07).abs() < 5e-4,
            "{bore:?} {off}"
        );
    }
}
