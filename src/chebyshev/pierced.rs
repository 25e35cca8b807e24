//! Where diagonals pierce facets, and where they pass from one to the next.

use std::ops::{Add, Mul, Neg, Sub};

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::chunks::{Bits, CHUNK};
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::interface::diagonal_ray;
use crate::chebyshev::passing::Passing;
use crate::chebyshev::planes::Planes;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::small_polyhedron::BLOCK;

/// For each diagonal the facets, as a set of bits, the planes of which it pierces before that of its
/// tip as seen from `center`, if that is inside the piece.
pub(crate) fn nearer_facets(
    piece: &Integrand,
    center: &Vector3<f64>,
    tips: &[u32; 8],
) -> Option<[u64; 8]> {
    let center = [center.x, center.y, center.z].map(f64x4::splat);
    let alongs = by_diagonal(&piece.facets, *tips, |_, along| along);
    let heights = by_diagonal(&piece.facets, *tips, |plane, _| height_below(plane, center));
    let tips =
        [0, 1, 2, 3, 4, 5, 6, 7].map(|tip: usize| [alongs[tip], heights[tip]].map(f64x4::splat));
    let mut inside = f64x4::splat(f64::from_bits(u64::MAX));
    let mut nearer = [0; 8];
    for (block, planes) in piece.facets.blocks().enumerate() {
        let heights = height_below(planes, center);
        inside &= heights.simd_gt(f64x4::ZERO);
        let [x, y, z, _] = planes;
        let rays = along_rays([x, y, z]);
        for ((nearer, [along, height]), ray) in nearer.iter_mut().zip(tips).zip(rays) {
            let are_nearer = (along * heights).simd_lt(height * ray);
            *nearer |= u64::from(are_nearer.to_bitmask()) << (block * BLOCK % CHUNK);
        }
    }
    let is_known = inside.to_bitmask() == 0b1111 && piece.facets.len() <= CHUNK;
    is_known.then_some(nearer)
}

/// Adds the passages of a diagonal from one facet to the next, all of them among those that are nearer
/// in the end, and returns the last one.
pub(crate) fn add_diagonal(
    piece: &Integrand,
    (diagonal, facet): (usize, u32),
    nearer: u64,
    centers: &[Vector3<f64>; 2],
    all: &mut Vec<Passing>,
) -> u32 {
    let pierced = |facet| Pierced::new(piece.facets.get(facet), diagonal, centers);
    let (mut last, mut now) = (facet, pierced(facet as usize));
    // What is pierced first is the least of functions linear along the way.
    loop {
        let ahead = Bits::of(nearer).filter(|&facet| facet < piece.facets.len());
        let ahead = ahead.map(|facet| (facet as u32, pierced(facet)));
        let nearer = ahead.filter(|(_, next)| next.is_nearer(&now));
        let first = nearer.min_by(|(_, a), (_, b)| now.meets(a).total_cmp(&now.meets(b)));
        let Some((facet, next)) = first else {
            return last;
        };
        all.push(Passing::of_diagonal(diagonal, &now, &next));
        (last, now) = (facet, next);
    }
}

/// A facet as a diagonal pierces its plane.
#[derive(Clone, Copy)]
pub(crate) struct Pierced {
    pub(crate) plane: HalfSpace,
    /// The normal times the diagonal's ray.
    pub(crate) along: f64,
    /// The heights of the step's start and end below the facet.
    heights: [f64; 2],
}

impl Pierced {
    #[inline]
    fn new(plane: HalfSpace, diagonal: usize, centers: &[Vector3<f64>; 2]) -> Self {
        let along: [f64; 3] = plane.normal.into();
        let [x, y, z] = along;
        Self {
            plane,
            along: along_rays(along)[diagonal % 8],
            heights: centers
                .each_ref()
                .map(|center| height_below([x, y, z, plane.offset], (*center).into())),
        }
    }

    /// Whether it is pierced before another in the end.
    #[inline]
    fn is_nearer(&self, other: &Self) -> bool {
        other.along * self.heights[1] < other.heights[1] * self.along
    }

    /// How far along the diagonal it is pierced, from the step's start or end.
    fn reach(&self, end: usize) -> f64 {
        self.heights[end] / self.along
    }

    /// At which share of the step the diagonal passes to another facet, which ends nearer.
    fn meets(&self, next: &Self) -> f64 {
        let [start, end] = [0, 1].map(|end| next.reach(end) - self.reach(end));
        start / (start - end)
    }
}

/// What `of` makes, four at a time, of a facet for each diagonal: of the coordinates of the normals, the
/// offsets, and the normals times the rays, rounded as by [`along_rays`].
#[inline(always)]
pub(crate) fn by_diagonal(
    planes: &Planes,
    facets: [u32; 8],
    of: impl Fn([f64x4; 4], f64x4) -> f64x4,
) -> [f64; 8] {
    let [[a, b, c, d], [e, f, g, h]] = [0, 4].map(|first| {
        let four = [0, 1, 2, 3].map(|lane| first + lane);
        let lanes = planes.four(four.map(|diagonal: usize| facets[diagonal]));
        let rays = four.map(|diagonal| diagonal_ray(diagonal as u8));
        let ray = |axis: usize| f64x4::new(rays.map(|ray| ray[axis]));
        let along = lanes[0] * ray(0) + lanes[1] * ray(1) + lanes[2] * ray(2);
        of(lanes, along).to_array()
    });
    [a, b, c, d, e, f, g, h]
}

/// The height of `center` below a plane, in one lane or in four.
#[inline(always)]
pub(crate) fn height_below<T>([x, y, z, offset]: [T; 4], center: [T; 3]) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
{
    offset - (x * center[0] + y * center[1] + z * center[2])
}

/// A normal times the rays of all diagonals.
#[inline]
fn along_rays<T>([x, y, z]: [T; 3]) -> [T; 8]
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Neg<Output = T>,
{
    let [a, b, c, d] = [x + y + z, -x + y + z, x - y + z, -x - y + z];
    [a, b, c, d, -d, -c, -b, -a]
}
