//! Moments of the part of a solid above a plane, up to degree three, from the solid's surface alone.
//!
//! H = Ω ∩ {n·y > o}. The triangles of the surface are clipped to the half-space, and the apex of the signed
//! cones is put *into the plane*: the cap that closes H lies in a plane through the apex, so its cones have
//! no volume and the cap is never built. With q_i the corners of a clipped triangle from the apex,
//! D = det(q₁, q₂, q₃), s = q₁ + q₂ + q₃ and P = Σ q_i q_iᵀ,
//!
//! ```text
//! m0 = Σ D/6      m1 = Σ D/24 s      m2 = Σ D/120 (s sᵀ + P)
//! m3 = Σ D/720 (s⊗s⊗s + s⊗P in its three placements + 2 Σ q_i⊗q_i⊗q_i)
//! ```
//!
//! A vertex in the plane counts as not above it. The section S of the plane has its moments from the edges
//! that the clipping leaves in it: with e → f such an edge, triangles (apex, e, f) sum to S.
//!
//! Triangles wholly above run four at a time ([`lanes`](crate::integrals::lanes)); those that the plane cuts
//! are few. The normal need not be a unit vector. Sums run by halves: their bits do not depend on threads.

use std::ops::{Add, Range};

use nalgebra::{Matrix3, Point3, Vector3};

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::geometry::double_double::six_volume;
use crate::geometry::moments::Moments;
use crate::geometry::simd::dot;
use crate::integrals::clip::ClippedPolygon;
use crate::integrals::lanes::{CONSTANT, Lanes, Sums, WIDTH, gathered, named, splat};
use crate::integrals::mesh_moments::{Precision, constant};
use crate::integrals::pairwise::sum_by_halves;

/// A plane: normal·y = offset; above it is where normal·y is greater.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPlane {
    /// Across the plane, of any length.
    pub normal: Vector3<f64>,
    /// normal·y on it.
    pub offset: f64,
}

/// A solid within a closed surface, ready to be cut by planes; all moments are measured from `middle`.
#[derive(Clone, Debug)]
pub struct CuttableSolid<'a> {
    vertices: &'a [Point3<f64>],
    triangles: &'a [[u32; 3]],
    /// The middle of the bounding box.
    pub middle: Point3<f64>,
    /// Half of the box's edges.
    reach: Vector3<f64>,
    precision: Precision,
    /// The moments of the whole solid.
    pub whole: Moments,
}

/// ∫ y⊗y⊗y of a body (L⁶ at density 1), the ten entries that differ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ThirdMoments([f64; 10]);

/// The moments of a body up to degree three, about one origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ThreeMoments {
    /// Up to degree two.
    pub(crate) low: Moments,
    /// Of degree three.
    pub(crate) third: ThirdMoments,
}

/// The entries of a symmetric tensor of degree three, in the order of [`ThirdMoments`].
const TRIPLES: [[usize; 3]; 10] = [
    [0, 0, 0],
    [0, 0, 1],
    [0, 0, 2],
    [0, 1, 1],
    [0, 1, 2],
    [0, 2, 2],
    [1, 1, 1],
    [1, 1, 2],
    [1, 2, 2],
    [2, 2, 2],
];

impl ThirdMoments {
    /// ∫ (n·y) y yᵀ.
    pub(crate) fn along(&self, normal: &Vector3<f64>) -> Matrix3<f64> {
        Matrix3::from_fn(|row, column| (0..3).map(|k| normal[k] * self.at(k, row, column)).sum())
    }

    /// An entry.
    pub(crate) fn at(&self, i: usize, j: usize, k: usize) -> f64 {
        let mut triple = [i, j, k];
        triple.sort_unstable();
        let place = TRIPLES.iter().position(|entry| *entry == triple);
        place.map_or(0.0, |place| self.0[place])
    }

    fn add_cone(&mut self, six: f64, corners: &[Vector3<f64>; 3]) {
        let [a, b, c] = corners;
        let s = a + b + c;
        let squares = a * a.transpose() + b * b.transpose() + c * c.transpose();
        for (sum, [i, j, k]) in self.0.iter_mut().zip(TRIPLES) {
            let cubes = a[i] * a[j] * a[k] + b[i] * b[j] * b[k] + c[i] * c[j] * c[k];
            let mixed = s[i] * squares[(j, k)] + s[j] * squares[(i, k)] + s[k] * squares[(i, j)];
            *sum += six / 720.0 * (s[i] * s[j] * s[k] + mixed + 2.0 * cubes);
        }
    }
}

impl Add for ThreeMoments {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self.low += other.low;
        for (sum, entry) in self.third.0.iter_mut().zip(other.third.0) {
            *sum += entry;
        }
        self
    }
}

impl ThreeMoments {
    /// The same body measured from an origin moved by −`offset`.
    pub(crate) fn translated(&self, offset: &Vector3<f64>) -> Self {
        let (t, low) = (offset, &self.low);
        let mut third = self.third;
        for (entry, [i, j, k]) in third.0.iter_mut().zip(TRIPLES) {
            let second = |a: usize, b: usize, c: usize| t[a] * low.second[(b, c)];
            let first = |a: usize, b: usize, c: usize| t[a] * t[b] * low.first[c];
            *entry += second(i, j, k) + second(j, i, k) + second(k, i, j);
            *entry += first(i, j, k) + first(j, k, i) + first(i, k, j);
            *entry += t[i] * t[j] * t[k] * low.mass;
        }
        Self {
            low: low.translated(offset),
            third,
        }
    }
}

/// How a plane lies to a solid's box.
enum Passage {
    Below,
    Above,
    Through(Point3<f64>),
}

impl<'a> CuttableSolid<'a> {
    /// A solid by its closed surface, oriented outward.
    ///
    /// # Panics
    ///
    /// If a triangle names a vertex that is not there.
    #[must_use]
    pub fn new(vertices: &'a [Point3<f64>], triangles: &'a [[u32; 3]]) -> Self {
        let used = triangles.iter().flatten().map(|&v| &vertices[v as usize]);
        let bounds = Bounds::of(used);
        let middle = if triangles.is_empty() {
            Point3::origin()
        } else {
            bounds.center()
        };
        Self {
            vertices,
            triangles,
            middle,
            reach: bounds.extent() * 0.5,
            precision: Precision::for_solid(vertices, triangles, &middle),
            whole: constant(vertices, triangles, &middle),
        }
    }

    /// The moments of the part above a plane.
    #[must_use]
    pub fn above(&self, plane: &CutPlane) -> Moments {
        let apex = match self.passage(plane) {
            Passage::Below => return self.whole,
            Passage::Above => return Moments::default(),
            Passage::Through(apex) => apex,
        };
        let sum = sum_by_halves(self.triangles.len(), &|range| {
            self.leaf(range, &apex, &plane.normal)
        });
        sum.translated(&(apex - self.middle))
    }

    /// The moments of the part above a plane, up to degree three.
    pub(crate) fn above_to_third(&self, plane: &CutPlane) -> ThreeMoments {
        let (apex, clips) = match self.passage(plane) {
            Passage::Below => (self.middle, false),
            Passage::Above => return ThreeMoments::default(),
            Passage::Through(apex) => (apex, true),
        };
        let sum = sum_by_halves(self.triangles.len(), &|range| {
            let mut sum = ThreeMoments::default();
            for triangle in range {
                let corners = self.corners(triangle, &apex);
                let heights = corners.map_each(|corner| {
                    if clips {
                        plane.normal.dot(&corner)
                    } else {
                        1.0
                    }
                });
                for part in ClippedPolygon::of(&corners, &heights).triangles() {
                    let six = self.six_volume(&part);
                    add_cone(&mut sum.low, six, &part);
                    sum.third.add_cone(six, &part);
                }
            }
            sum
        });
        sum.translated(&(apex - self.middle))
    }

    /// The moments ∫ 1, y, y yᵀ dA of the section by a plane.
    #[must_use]
    pub fn section(&self, plane: &CutPlane) -> Moments {
        let Passage::Through(apex) = self.passage(plane) else {
            return Moments::default();
        };
        let unit = plane.normal.normalize();
        let sum = sum_by_halves(self.triangles.len(), &|range| {
            let mut sum = Moments::default();
            for triangle in range {
                let corners = self.corners(triangle, &apex);
                let heights = corners.map_each(|corner| plane.normal.dot(&corner));
                if let Some([e, f]) = ClippedPolygon::of(&corners, &heights).edge {
                    add_section(&mut sum, &unit, &e, &f);
                }
            }
            sum
        });
        sum.translated(&(apex - self.middle))
    }

    /// Whether a plane misses the box, and otherwise the point of the plane next to the middle.
    fn passage(&self, plane: &CutPlane) -> Passage {
        let height = plane.normal.dot(&self.middle.coords) - plane.offset;
        let reach = plane.normal.abs().dot(&self.reach);
        if height > reach {
            Passage::Below
        } else if height < -reach || reach == 0.0 {
            Passage::Above
        } else {
            let down = plane.normal * (height / plane.normal.norm_squared());
            Passage::Through(self.middle - down)
        }
    }

    fn corners(&self, triangle: usize, apex: &Point3<f64>) -> [Vector3<f64>; 3] {
        self.triangles[triangle].map_each(|vertex| self.vertices[vertex as usize] - apex)
    }

    /// The sums over some triangles, from the apex.
    fn leaf(&self, range: Range<usize>, apex: &Point3<f64>, normal: &Vector3<f64>) -> Moments {
        let (from, across) = (
            splat(apex),
            [normal.x, normal.y, normal.z].map_each(Lanes::splat),
        );
        let (mut sums, mut clipped) = (Sums::default(), Moments::default());
        for block in self.triangles[range].chunks(WIDTH) {
            let named = named(block);
            let corners = named.map_each(|named| gathered(self.vertices, named, &from));
            let heights = corners.each_ref().map_each(|corner| dot(corner, &across));
            let low = heights[0].fast_min(heights[1]).fast_min(heights[2]);
            let high = heights[0].fast_max(heights[1]).fast_max(heights[2]);
            if !high.simd_gt(Lanes::ZERO).any() {
                continue;
            }
            let six = self
                .precision
                .six_volumes(self.vertices, apex, &named, &corners);
            let is_above = low.simd_gt(Lanes::ZERO);
            if is_above.all() {
                sums.add_constant(six, &corners);
                continue;
            }
            sums.add_constant(is_above.select(six, Lanes::ZERO), &corners);
            let (low, high) = (low.to_array(), high.to_array());
            for lane in (0..WIDTH).filter(|&lane| low[lane] <= 0.0 && high[lane] > 0.0) {
                let corner =
                    |k: usize| Vector3::from_fn(|axis, _| corners[k][axis].as_array()[lane]);
                let corners = [corner(0), corner(1), corner(2)];
                let heights = heights.map_each(|height| height.as_array()[lane]);
                for part in ClippedPolygon::of(&corners, &heights).triangles() {
                    add_cone(&mut clipped, self.six_volume(&part), &part);
                }
            }
        }
        sums.moments(CONSTANT) + clipped
    }

    /// Six times the volume of the cone over a triangle from the origin of its corners.
    fn six_volume(&self, [a, b, c]: &[Vector3<f64>; 3]) -> f64 {
        match self.precision {
            Precision::Single => a.dot(&b.cross(c)),
            Precision::Double => {
                let [a, b, c] = [a, b, c].map_each(|corner| Point3::from(*corner));
                six_volume(&Point3::origin(), [&a, &b, &c])
            }
        }
    }
}

/// Adds the cone over a triangle, given six times its volume.
fn add_cone(sum: &mut Moments, six: f64, corners: &[Vector3<f64>; 3]) {
    let [a, b, c] = corners;
    let total = a + b + c;
    sum.mass += six / 6.0;
    sum.first += total * (six / 24.0);
    for corner in [*a, *b, *c, total] {
        sum.second += corner * corner.transpose() * (six / 120.0);
    }
}

/// Adds the triangle of the apex and an edge of a section.
fn add_section(sum: &mut Moments, unit: &Vector3<f64>, e: &Vector3<f64>, f: &Vector3<f64>) {
    let area = 0.5 * unit.dot(&e.cross(f));
    let total = e + f;
    sum.mass += area;
    sum.first += total * (area / 3.0);
    for corner in [*e, *f, total] {
        sum.second += corner * corner.transpose() * (area / 12.0);
    }
}
