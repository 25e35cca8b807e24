//! Points in rows of four numbers, so that a processor loads one at once and moves four together.

use nalgebra::{Rotation3, Vector3};
use wide::f64x4;

use crate::geometry::small_polyhedron::BLOCK;

/// A list of points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    /// Whole blocks of coordinates, with x once more. Rows beyond the last point repeat the first.
    rows: Vec<[f64; 4]>,
    count: usize,
}

impl Points {
    /// Becomes the points of a list.
    pub(crate) fn assign(&mut self, points: impl Iterator<Item = [f64; 3]>) {
        self.rows.clear();
        self.rows.extend(points.map(|[x, y, z]| [x, y, z, x]));
        self.close();
    }

    /// Becomes the first `count` points of those that have these coordinates.
    #[inline]
    pub(crate) fn assign_axes<const N: usize>(&mut self, axes: [&[f64; N]; 3], count: usize) {
        self.rows.clear();
        let [x, y, z] = axes.map(|axis| axis.as_chunks::<BLOCK>().0.iter());
        let blocks = x.zip(y).zip(z).take(count.div_ceil(BLOCK));
        for ((x, y), z) in blocks {
            let [x, y, z] = [x, y, z].map(|along| f64x4::new(*along));
            let rows = f64x4::transpose([x, y, z, x]);
            self.rows.extend(rows.map(f64x4::to_array));
        }
        self.rows.truncate(count);
        self.close();
    }

    /// Becomes the points of the given numbers out of those that have these coordinates.
    #[inline]
    pub(crate) fn gather<const N: usize>(&mut self, axes: [&[f64; N]; 3], numbers: &[u8]) {
        self.rows.clear();
        self.rows.extend(numbers.iter().map(|&number| {
            let [x, y, z] = axes.map(|axis| axis[usize::from(number) % N]);
            [x, y, z, x]
        }));
        self.close();
    }

    /// Fills the last block.
    #[inline]
    fn close(&mut self) {
        self.count = self.rows.len();
        if let Some(&first) = self.rows.first() {
            self.rows.resize(self.count.next_multiple_of(BLOCK), first);
        }
    }

    /// How many there are.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// A point.
    #[inline]
    pub(crate) fn get(&self, number: usize) -> Vector3<f64> {
        let [x, y, z, _] = self.rows[number];
        Vector3::new(x, y, z)
    }

    /// The coordinates of four points, by axis.
    #[inline(always)]
    pub(crate) fn four(&self, numbers: [u32; 4]) -> [f64x4; 3] {
        by_axis(&numbers.map(|number| self.rows[number as usize]))
    }

    /// All of them.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        (0..self.count).map(|number| self.get(number))
    }

    /// All of them, four at a time and by axis. Lanes beyond the last repeat the first.
    #[inline]
    pub(crate) fn blocks(&self) -> impl ExactSizeIterator<Item = [f64x4; 3]> + '_ {
        self.rows.as_chunks::<BLOCK>().0.iter().map(by_axis)
    }

    /// Turns all of them about the origin.
    pub(crate) fn rotate(&mut self, rotation: &Rotation3<f64>) {
        for [x, y, z, _] in &mut self.rows {
            [*x, *y, *z] = (rotation * Vector3::new(*x, *y, *z)).into();
        }
    }
}

/// The coordinates of four rows, by axis.
#[inline(always)]
fn by_axis(rows: &[[f64; 4]; BLOCK]) -> [f64x4; 3] {
    let [x, y, z, _] = f64x4::transpose(rows.map(f64x4::new));
    [x, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_list_of_axes_or_gathered_are_the_same() {
        let axes =
            [1.0, 10.0, 100.0].map(|scale| [0, 1, 2, 3, 4, 5, 6, 7].map(|i| f64::from(i) * scale));
        for count in 0..=8 {
            let (mut listed, mut assigned) = (Points::default(), Points::default());
            assigned.assign([[7.0; 3]].into_iter());
            assigned.assign_axes(axes.each_ref(), count);
            listed.assign((0..count).map(|number| axes.map(|axis| axis[number])));
            assert_eq!(format!("{listed:?}"), format!("{assigned:?}"));
            let numbers: Vec<u8> = (0..count as u8).collect();
            let mut gathered = Points::default();
            gathered.gather(axes.each_ref(), &numbers);
            assert_eq!(format!("{listed:?}"), format!("{gathered:?}"));
            assert_eq!((listed.len(), listed.iter().count()), (count, count));
            let rotation = Rotation3::from_euler_angles(0.1, 0.2, 0.3);
            listed.rotate(&rotation);
            for (turned, point) in listed.iter().zip(assigned.iter()) {
                assert_eq!(turned, rotation * point);
            }
            assert_eq!(listed.iter().count(), count);
        }
    }
}
