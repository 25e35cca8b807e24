//! Sorts sites into the order of the tree's leaves, on all threads from the root on.

use std::cmp::Ordering;

use nalgebra::Point3;

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::parallel::{map_parts, map_runs};

/// Halves larger than this are sorted by two threads.
const PARALLEL_SORT: usize = 1 << 12;

/// Nodes larger than this are halved by all threads.
const SHARED_HALVING: usize = 1 << 17;

/// Entries that a thread parts at a time when all halve a node: what a core has near.
const HALVING_RUN: usize = 1 << 12;

/// Of so many entries one is looked at to guess where a half ends.
const SAMPLE_STEP: usize = 512;

/// A site while it is being sorted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SortEntry {
    pub(crate) position: Point3<f64>,
    pub(crate) site: u32,
}

impl SortEntry {
    /// The order of coordinates, and of sites where they are equal.
    #[inline(always)]
    fn order_along(&self, axis: usize, other: &Self) -> Ordering {
        if self.is_before(axis, other) {
            Ordering::Less
        } else if self.site == other.site {
            Ordering::Equal
        } else {
            Ordering::Greater
        }
    }

    /// Written so that the common case, that coordinates differ, needs no branch.
    #[inline(always)]
    fn is_before(&self, axis: usize, other: &Self) -> bool {
        let [before, after] = [self, other].map_each(|entry| entry.position[axis]);
        (before < after) | (before <= after) & (self.site < other.site)
    }
}

/// The first of `total` places that node `number` of a level with 2^level nodes covers.
pub(crate) fn start(total: usize, number: u64, level: u32) -> usize {
    ((total as u64 * number) >> level) as usize
}

/// Brings the entries of node `number` of a level, of `total` in all, into leaf order, unless that is
/// stopped.
pub(crate) fn sort(
    entries: &mut [SortEntry],
    total: usize,
    (number, level): (u64, u32),
    (depth, is_stopped): (u32, &(dyn Fn() -> bool + Sync)),
) {
    if level == depth || entries.len() > PARALLEL_SORT && is_stopped() {
        return;
    }
    let axis = extents(entries).extent().imax();
    let half = start(total, 2 * number + 1, level + 1) - start(total, number, level);
    halve(entries, half, axis);
    let (low, high) = entries.split_at_mut(half);
    let whole = (depth, is_stopped);
    let mut low = || sort(low, total, (2 * number, level + 1), whole);
    let mut high = || sort(high, total, (2 * number + 1, level + 1), whole);
    if half > PARALLEL_SORT {
        rayon::join(low, high);
    } else {
        low();
        high();
    }
}

/// The box around the entries of a node.
fn extents(entries: &[SortEntry]) -> Bounds<3> {
    let around = |entries: &[SortEntry]| Bounds::of(entries.iter().map(|entry| &entry.position));
    if entries.len() <= SHARED_HALVING {
        return around(entries);
    }
    let runs = map_runs(entries.len(), HALVING_RUN, |run| around(&entries[run]));
    Bounds::of(runs.iter().flat_map(|run| [&run.min, &run.max]))
}

/// Brings the `half` least entries along an axis before the others.
fn halve(entries: &mut [SortEntry], half: usize, axis: usize) {
    let (start, end) = if entries.len() > SHARED_HALVING {
        bracket(entries, half, axis)
    } else {
        (0, entries.len())
    };
    let order = |a: &SortEntry, b: &SortEntry| a.order_along(axis, b);
    entries[start..end].select_nth_unstable_by(half - start, order);
}

/// Where the half ends, nearly: first and end of few entries that hold it, with all lesser ones before and all
/// greater ones after them. Two samples' entries part all others, so a bad guess costs time and nothing else.
fn bracket(entries: &mut [SortEntry], half: usize, axis: usize) -> (usize, usize) {
    let sample = entries.iter().step_by(SAMPLE_STEP).copied();
    let mut sample: Vec<SortEntry> = sample.collect();
    sample.sort_unstable_by(|a, b| a.order_along(axis, b));
    // Four standard deviations of the half's rank among random samples.
    let (rank, margin) = (half / SAMPLE_STEP, 2 * sample.len().isqrt());
    let least = sample[rank.saturating_sub(margin)];
    let most = sample[(rank + margin).min(sample.len() - 1)];
    let first = part(entries, &|entry| entry.is_before(axis, &least));
    if first > half {
        return (0, first);
    }
    let end = first + part(&mut entries[first..], &|entry| entry.is_before(axis, &most));
    if end > half {
        (first, end)
    } else {
        (end, entries.len())
    }
}

/// Brings the entries for which `is_low` holds before the others; returns how many they are.
fn part(entries: &mut [SortEntry], is_low: &(dyn Fn(&SortEntry) -> bool + Sync)) -> usize {
    let runs: Vec<&mut [SortEntry]> = entries.chunks_mut(HALVING_RUN).collect();
    let lows = map_parts(runs, &|run| {
        let mut lows = 0;
        for place in 0..run.len() {
            run.swap(place, lows);
            lows += usize::from(is_low(&run[lows]));
        }
        lows
    });
    let all: usize = lows.iter().sum();
    // Runs lie in order; what is on the wrong side of the end of all lows changes places.
    let (mut high, mut low) = (Vec::new(), Vec::new());
    let mut first = 0;
    for (run, lows) in entries.chunks_mut(HALVING_RUN).zip(lows) {
        let [before, length] = [all.max(first) - first, run.len()];
        first += length;
        let (of_lows, of_highs) = run.split_at_mut(lows);
        low.push(&mut of_lows[before.min(lows)..]);
        high.push(&mut of_highs[..before.clamp(lows, length) - lows]);
    }
    exchange(high, low);
    all
}

/// Exchanges the entries of two lists of slices that hold equally many.
fn exchange(ones: Vec<&mut [SortEntry]>, others: Vec<&mut [SortEntry]>) {
    let mut others = others.into_iter();
    let mut other: &mut [SortEntry] = &mut [];
    let mut pairs = Vec::new();
    for mut one in ones {
        while !one.is_empty() {
            if other.is_empty() {
                let Some(next) = others.next() else { break };
                other = next;
                continue;
            }
            let length = one.len().min(other.len());
            let [(here, left), (there, right)] =
                [one, other].map_each(|slice| slice.split_at_mut(length));
            pairs.push((here, there));
            (one, other) = (left, right);
        }
    }
    map_parts(pairs, &|(here, there)| here.swap_with_slice(there));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    /// Entries whose first coordinates are these.
    fn entries(along: impl Iterator<Item = f64>) -> Vec<SortEntry> {
        let entry = |(site, along): (u32, f64)| SortEntry {
            position: Point3::new(along, 0.0, 0.0),
            site,
        };
        (0..).zip(along).map(entry).collect()
    }

    #[test]
    fn all_threads_halve_as_one_does() {
        let count = 5 * SHARED_HALVING / 4;
        let mut stream = Random::new(1);
        let random: Vec<f64> = (0..count).map(|_| stream.uniform()).collect();
        // The samples lie all in front: the guess is bad.
        let misled = random.iter().enumerate();
        let misled = misled.map(|(place, &x)| if place % SAMPLE_STEP == 0 { x - 9.0 } else { x });
        let misled: Vec<f64> = misled.collect();
        let cases = [
            entries((0..count).map(|place| place as f64)),
            entries((0..count).map(|place| -(place as f64))),
            entries((0..count).map(|place| (place % 7) as f64)),
            entries((0..count).map(|_| 0.5)),
            entries(misled.iter().map(|x| -x)),
            entries(misled.into_iter()),
            entries(random.into_iter()),
        ];
        for case in cases {
            let (mut sorted, mut halved) = (case.clone(), case);
            sorted.sort_unstable_by(|a, b| a.order_along(0, b));
            for half in [1, count / 3, count / 2, count - 1] {
                halve(&mut halved, half, 0);
                let is_low = |entry: &SortEntry| entry.is_before(0, &sorted[half]);
                assert!(halved[..half].iter().all(is_low));
                assert!(!halved[half..].iter().any(is_low));
            }
            let mut sites: Vec<u32> = halved.iter().map(|entry| entry.site).collect();
            sites.sort_unstable();
            assert!(sites.into_iter().eq(0..count as u32));
        }
    }
}
