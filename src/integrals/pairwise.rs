//! Pairwise summation, in an order that does not depend on the number of threads.
//!
//! A sum of n terms added one after the other may lose n ulps, by halves log₂ n; and halves can
//! be handed to two threads without changing a bit, because where a range is split depends on
//! its ends alone.

use std::ops::{Add, Range};

/// Items that a leaf adds one after the other: long enough to hide the halving, short enough
/// that the plain sum inside loses no digit that matters.
pub const LEAF: usize = 256;

/// Ranges longer than this are worth a second thread.
const PARALLEL: usize = 64 * LEAF;

/// Σ `leaf`(range) over ranges of at most [`LEAF`] items that cover `0..count`, added by halves:
/// the same bits for any number of threads.
pub fn sum_by_halves<T>(count: usize, leaf: &(impl Fn(Range<usize>) -> T + Sync)) -> T
where
    T: Add<Output = T> + Send,
{
    halves(0..count, leaf)
}

fn halves<T>(range: Range<usize>, leaf: &(dyn Fn(Range<usize>) -> T + Sync)) -> T
where
    T: Add<Output = T> + Send,
{
    let count = range.len();
    if count <= LEAF {
        return leaf(range);
    }
    let middle = range.start + (count / 2).next_multiple_of(LEAF);
    let (lower, upper) = (range.start..middle, middle..range.end);
    let (lower, upper) = if count > PARALLEL {
        rayon::join(|| halves(lower, leaf), || halves(upper, leaf))
    } else {
        (halves(lower, leaf), halves(upper, leaf))
    };
    lower + upper
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_is_counted_once() {
        for count in [0, 1, 255, 256, 257, 511, 513, 16_385, 100_000] {
            let total = sum_by_halves(count, &|range: Range<usize>| range.sum::<usize>());
            assert_eq!(total, count * count.saturating_sub(1) / 2);
        }
    }

    #[test]
    fn a_million_tenths_keep_thirteen_digits() {
        let sum: f64 = sum_by_halves(1_000_000, &|range: Range<usize>| {
            range.fold(0.0_f64, |sum, _| sum + 0.1)
        });
        assert!((sum - 1e5).abs() < 2e-9, "{sum}");
    }
}
