//! The order of sites in the leaves of a balanced k-d tree.

use std::cmp::Ordering;

use nalgebra::Point3;

use crate::geometry::bounds::Bounds;

/// Halves larger than this are sorted by two threads.
const WORTH_SHARING: usize = 1 << 12;

/// A site before it has a place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) position: Point3<f64>,
    pub(crate) site: u32,
}

/// The first of `total` places that node `number` of a level with 2^level nodes covers.
pub(crate) fn start(total: usize, number: u64, level: u32) -> usize {
    ((total as u64 * number) >> level) as usize
}

/// Brings the entries of node `number` of a level, of `total` in all, into leaf order.
pub(crate) fn sort(entries: &mut [Entry], total: usize, (number, level): (u64, u32), depth: u32) {
    if level == depth {
        return;
    }
    let extent = Bounds::of(entries.iter().map(|entry| &entry.position)).extent();
    let axis = extent.imax();
    let half = start(total, 2 * number + 1, level + 1) - start(total, number, level);
    entries.select_nth_unstable_by(half, |a, b| {
        let [before, after] = [a, b].map(|entry| entry.position[axis]);
        // Written so that no branch is needed to tell whether the first is less.
        if (before < after) | (before <= after) & (a.site < b.site) {
            Ordering::Less
        } else if a.site == b.site {
            Ordering::Equal
        } else {
            Ordering::Greater
        }
    });
    let (low, high) = entries.split_at_mut(half);
    let mut low = || sort(low, total, (2 * number, level + 1), depth);
    let mut high = || sort(high, total, (2 * number + 1, level + 1), depth);
    if half > WORTH_SHARING {
        rayon::join(low, high);
    } else {
        low();
        high();
    }
}
