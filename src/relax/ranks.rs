//! Ranks: processes that compute one run together, what they tell each other, and how they agree.
//!
//! Whatever leads to an exchange is decided by all ranks together: a failure on one is a failure on all.

use nalgebra::Point3;
use rayon::prelude::*;
use thiserror::Error;

use crate::arrays::MapEach;
use crate::integrals::exact_sum::ExactSum;
use crate::parallel::map;
use crate::relax::cell_check::CellsError;
use crate::relax::space::SpaceError;
use crate::voronoi::diagram::DiagramError;

/// Processes that take part in a run, each calling the same methods in the same order.
pub trait Ranks: Sync {
    /// The number of this process, from zero.
    fn rank(&self) -> usize;

    /// How many there are.
    fn size(&self) -> usize;

    /// Sends `parts[r]` to rank r, for all r, and returns what each has sent here.
    fn exchange(&self, parts: Vec<Vec<u64>>) -> Vec<Vec<u64>>;

    /// Sends `words` to every rank, and returns what each has sent.
    fn share(&self, words: Vec<u64>) -> Vec<Vec<u64>> {
        self.exchange(vec![words; self.size()])
    }

    /// Adds numbers over all ranks, each in its place.
    fn add(&self, numbers: &mut [i64]);

    /// The largest over all ranks of the numbers in each place.
    fn largest(&self, numbers: &mut [f64]);
}

/// Why a run over ranks failed: on all of them, for the same reason.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum RanksError {
    /// The cells are none of a tessellation.
    #[error(transparent)]
    Cells(#[from] CellsError),
    /// What the first rank that failed says.
    #[error("{message}")]
    Failed {
        /// In its words.
        message: String,
    },
}

/// Some of the sites: their numbers among all, ascending, and where they lie.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SomeSites {
    /// Their numbers.
    pub(crate) numbers: Vec<u64>,
    /// Their positions.
    pub(crate) positions: Vec<Point3<f64>>,
}

impl SomeSites {
    /// Sites whose numbers follow each other from `first` on.
    pub(crate) fn following(first: u64, positions: Vec<Point3<f64>>) -> Self {
        Self {
            numbers: (first..first + positions.len() as u64).collect(),
            positions,
        }
    }

    /// A site as it is sent.
    pub(crate) fn words(&self, place: usize) -> [u64; 4] {
        let at = &self.positions[place];
        [
            self.numbers[place],
            at.x.to_bits(),
            at.y.to_bits(),
            at.z.to_bits(),
        ]
    }

    /// The sites that were sent, in the order of their numbers.
    pub(crate) fn of_words(parts: &[Vec<u64>]) -> Self {
        let all = parts.iter().flat_map(|part| part.as_chunks::<4>().0);
        let mut all: Vec<&[u64; 4]> = all.collect();
        all.par_sort_unstable_by_key(|words| words[0]);
        let position = |words: &[u64; 4]| {
            let [x, y, z] = [1, 2, 3].map_each(|axis| f64::from_bits(words[axis]));
            Point3::new(x, y, z)
        };
        Self {
            numbers: map(all.len(), &|place| all[place][0]),
            positions: map(all.len(), &|place| position(all[place])),
        }
    }
}

/// Whether any rank says so.
pub(crate) fn any(ranks: &dyn Ranks, says: bool) -> bool {
    let mut flag = [f64::from(u8::from(says))];
    ranks.largest(&mut flag);
    flag[0] > 0.0
}

/// A sum over all ranks.
pub(crate) fn total(ranks: &dyn Ranks, own: &ExactSum) -> f64 {
    let mut numbers = own.to_numbers();
    ranks.add(&mut numbers);
    ExactSum::from_numbers(&numbers).value()
}

/// What every rank has, or on all the reason of the first rank that has nothing.
///
/// # Errors
/// That reason.
pub(crate) fn agreed<T>(ranks: &dyn Ranks, own: Result<T, String>) -> Result<T, String> {
    if !any(ranks, own.is_err()) {
        return own;
    }
    let reason = own.as_ref().err().map_or("", String::as_str);
    let reasons = share_bytes(ranks, reason.as_bytes());
    let first = reasons.into_iter().find(|reason| !reason.is_empty());
    let first = first.map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    Err(first.unwrap_or_else(|| "a rank failed without a reason".to_owned()))
}

/// The bytes that each rank has.
pub(crate) fn share_bytes(ranks: &dyn Ranks, bytes: &[u8]) -> Vec<Vec<u8>> {
    let (whole, rest) = bytes.as_chunks::<8>();
    let mut last = [0; 8];
    last[..rest.len()].copy_from_slice(rest);
    let mut words = vec![bytes.len() as u64];
    words.extend(
        whole
            .iter()
            .chain([&last])
            .map(|word| u64::from_le_bytes(*word)),
    );
    let of_words = |words: Vec<u64>| {
        let (length, words) = words
            .split_first()
            .map_or((0, &[][..]), |(length, words)| (*length, words));
        let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        bytes.truncate(length as usize);
        bytes
    };
    ranks.share(words).into_iter().map(of_words).collect()
}

/// The words that rank 0 has.
pub(crate) fn from_first(ranks: &dyn Ranks, words: Vec<u64>) -> Vec<u64> {
    let words = if ranks.rank() == 0 { words } else { Vec::new() };
    ranks.share(words).into_iter().next().unwrap_or_default()
}

/// An error whose sites are numbered among all, not among those of `numbers`.
pub(crate) fn renumbered(error: SpaceError, numbers: &[u64]) -> SpaceError {
    let of = |site: usize| numbers.get(site).map_or(site, |&number| number as usize);
    let SpaceError::Diagram(error) = error else {
        return error;
    };
    SpaceError::Diagram(match error {
        DiagramError::NotFinite { site, position } => DiagramError::NotFinite {
            site: of(site),
            position,
        },
        DiagramError::Outside { site, position } => DiagramError::Outside {
            site: of(site),
            position,
        },
        DiagramError::Duplicate {
            first,
            second,
            position,
        } => DiagramError::Duplicate {
            first: of(first),
            second: of(second),
            position,
        },
        other => other,
    })
}
