//! Points in blocks of four, so that a processor moves four of them at once.

use nalgebra::{Rotation3, Vector3};

use crate::geometry::compact::BLOCK;

/// A list of points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    /// By block and axis. What the last block has beyond the last point is zero.
    blocks: Vec<[[f64; BLOCK]; 3]>,
    count: usize,
}

impl Points {
    /// Forgets all points.
    pub(crate) fn clear(&mut self) {
        self.blocks.clear();
        self.count = 0;
    }

    /// Adds a point.
    #[inline]
    pub(crate) fn push(&mut self, point: &Vector3<f64>) {
        let lane = self.count % BLOCK;
        if lane == 0 {
            self.blocks.push([[0.0; BLOCK]; 3]);
        }
        self.count += 1;
        if let Some(block) = self.blocks.last_mut() {
            for (axis, &along) in block.iter_mut().zip(point.iter()) {
                axis[lane] = along;
            }
        }
    }

    /// Becomes the first `count` points of those that have these coordinates.
    #[inline]
    pub(crate) fn assign(&mut self, axes: [&[f64]; 3], count: usize) {
        self.blocks.clear();
        self.count = count;
        let [x, y, z] = axes.map(|axis| axis[..count].as_chunks::<BLOCK>());
        let whole = x.0.iter().zip(y.0).zip(z.0);
        self.blocks.extend(whole.map(|((x, y), z)| [*x, *y, *z]));
        if !count.is_multiple_of(BLOCK) {
            let mut last = [[0.0; BLOCK]; 3];
            for (axis, rest) in last.iter_mut().zip([x.1, y.1, z.1]) {
                axis[..rest.len()].copy_from_slice(rest);
            }
            self.blocks.push(last);
        }
    }

    /// Becomes the points of the given numbers out of those that have these coordinates.
    #[inline]
    pub(crate) fn gather<const N: usize>(&mut self, axes: [&[f64; N]; 3], numbers: &[u8]) {
        self.blocks.clear();
        self.count = numbers.len();
        let at = |axis: &[f64; N], number: u8| axis[usize::from(number) % N];
        let (whole, rest) = numbers.as_chunks::<BLOCK>();
        let blocks = whole.iter();
        self.blocks
            .extend(blocks.map(|block| axes.map(|axis| block.map(|number| at(axis, number)))));
        if !rest.is_empty() {
            self.blocks.push(axes.map(|axis| {
                [0, 1, 2, 3].map(|lane| rest.get(lane).map_or(0.0, |&number| at(axis, number)))
            }));
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
        let [x, y, z] = &self.blocks[number / BLOCK];
        let lane = number % BLOCK;
        Vector3::new(x[lane], y[lane], z[lane])
    }

    /// All of them.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        (0..self.count).map(|number| self.get(number))
    }

    /// The blocks, by axis.
    #[inline]
    pub(crate) fn blocks(&self) -> &[[[f64; BLOCK]; 3]] {
        &self.blocks
    }

    /// Turns all of them about the origin.
    pub(crate) fn rotate(&mut self, rotation: &Rotation3<f64>) {
        for [x, y, z] in &mut self.blocks {
            for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
                [*x, *y, *z] = (rotation * Vector3::new(*x, *y, *z)).into();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_pushed_assigned_or_gathered_are_the_same() {
        let axes = [1.0, 10.0, 100.0].map(|scale| [0, 1, 2, 3, 4, 5].map(|i| f64::from(i) * scale));
        for count in 0..=6 {
            let (mut pushed, mut assigned) = (Points::default(), Points::default());
            assigned.push(&Vector3::new(7.0, 7.0, 7.0));
            assigned.assign(axes.each_ref().map(|axis| &axis[..]), count);
            for number in 0..count {
                pushed.push(&Vector3::from(axes.map(|axis| axis[number])));
            }
            assert_eq!(format!("{pushed:?}"), format!("{assigned:?}"));
            let numbers: Vec<u8> = (0..count as u8).collect();
            let mut gathered = Points::default();
            gathered.gather(axes.each_ref(), &numbers);
            assert_eq!(format!("{pushed:?}"), format!("{gathered:?}"));
            assert_eq!((pushed.len(), pushed.iter().count()), (count, count));
            let rotation = Rotation3::from_euler_angles(0.1, 0.2, 0.3);
            pushed.rotate(&rotation);
            for (turned, point) in pushed.iter().zip(assigned.iter()) {
                assert_eq!(turned, rotation * point);
            }
            assert_eq!(pushed.iter().count(), count);
        }
    }
}
