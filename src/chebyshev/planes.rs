//! Planes in rows of four numbers, so that a processor loads one at once and measures four together.

use nalgebra::{Rotation3, Vector3};
use wide::f64x4;

use crate::geometry::half_space::HalfSpace;
use crate::geometry::small_polyhedron::BLOCK;

/// A list of half-spaces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Planes {
    /// Whole blocks of normals and offsets. Rows beyond the last repeat the first.
    rows: Vec<[f64; 4]>,
    count: usize,
}

impl Planes {
    /// Becomes a list of half-spaces.
    #[inline]
    pub(crate) fn assign<'a>(&mut self, planes: impl Iterator<Item = &'a HalfSpace>) {
        self.rows.clear();
        self.rows.extend(
            planes.map(|HalfSpace { normal, offset }| [normal.x, normal.y, normal.z, *offset]),
        );
        self.count = self.rows.len();
        if let Some(&first) = self.rows.first() {
            let whole = self.count.next_multiple_of(BLOCK);
            self.rows.resize(whole, first);
        }
    }

    /// Makes all normals units, but for those that are zero.
    #[inline]
    pub(crate) fn normalize(&mut self) {
        for rows in self.rows.as_chunks_mut::<BLOCK>().0 {
            let units = HalfSpace::units(f64x4::transpose(rows.map(f64x4::new)));
            *rows = f64x4::transpose(units).map(f64x4::to_array);
        }
    }

    /// How many there are.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// One of them.
    #[inline]
    pub(crate) fn get(&self, number: usize) -> HalfSpace {
        let [x, y, z, offset] = self.rows[number];
        HalfSpace {
            normal: Vector3::new(x, y, z),
            offset,
        }
    }

    /// The normal of one.
    #[inline]
    pub(crate) fn normal(&self, number: usize) -> Vector3<f64> {
        self.get(number).normal
    }

    /// All of them.
    pub(crate) fn iter(&self) -> impl Iterator<Item = HalfSpace> + '_ {
        (0..self.count).map(|number| self.get(number))
    }

    /// The coordinates of four normals, and the offsets.
    #[inline(always)]
    pub(crate) fn four(&self, numbers: [u32; BLOCK]) -> [f64x4; 4] {
        f64x4::transpose(numbers.map(|number| f64x4::new(self.rows[number as usize])))
    }

    /// As [`Planes::four`] for all of them. Lanes beyond the last repeat the first.
    #[inline]
    pub(crate) fn blocks(&self) -> impl ExactSizeIterator<Item = [f64x4; 4]> + '_ {
        let blocks = self.rows.as_chunks::<BLOCK>().0.iter();
        blocks.map(|rows| f64x4::transpose(rows.map(f64x4::new)))
    }

    /// Turns all of them about the origin.
    pub(crate) fn rotate(&mut self, rotation: &Rotation3<f64>) {
        for [x, y, z, _] in &mut self.rows {
            [*x, *y, *z] = (rotation * Vector3::new(*x, *y, *z)).into();
        }
    }
}
