//! Sums that do not depend on the order of their numbers, nor on who adds which: exact until they are rounded.
//!
//! Every `f64` is a whole multiple of 2⁻¹⁰⁷⁴ below 2²⁰⁹⁸ of them. A sum is kept as words of 32 bits of that
//! integer in 64, so that 2²⁹ numbers fit before carries are passed on (Neal, *Fast exact summation using
//! small and large superaccumulators*, 2015).

use crate::parallel::{RUN, map_runs};

/// Words of the integer: 66 hold any number, and four more 2¹²⁸ of them.
const WORDS: usize = 70;

/// Numbers that may be added between two carries.
const MOST_PENDING: u32 = 1 << 29;

/// Bits of a fraction, without the leading one.
const FRACTION: usize = 52;

/// A sum, exactly.
#[derive(Clone, Debug)]
pub(crate) struct ExactSum {
    /// Multiples of 2^(32 k − 1074).
    words: [i64; WORDS],
    /// Numbers added since the last carry.
    pending: u32,
    /// How many numbers were +∞, −∞ and no number.
    special: [i64; 3],
}

impl Default for ExactSum {
    fn default() -> Self {
        Self {
            words: [0; WORDS],
            pending: 0,
            special: [0; 3],
        }
    }
}

impl ExactSum {
    /// How many numbers [`ExactSum::to_numbers`] gives.
    pub(crate) const NUMBERS: usize = WORDS + 3;

    /// Adds a number.
    #[inline]
    pub(crate) fn add(&mut self, number: f64) {
        let bits = number.to_bits();
        let exponent = (bits >> FRACTION & 0x7ff) as usize;
        if exponent == 0x7ff {
            return self.add_special(number);
        }
        let fraction = (bits & ((1 << FRACTION) - 1)) | u64::from(exponent > 0) << FRACTION;
        let shift = exponent.max(1) - 1;
        let wide = u128::from(fraction) << (shift % 32);
        // All bits of a negative number's, so that x ^ flip − flip is −x.
        let flip = -((bits >> 63) as i64);
        for part in 0..3 {
            let word = i64::from((wide >> (32 * part)) as u32);
            self.words[shift / 32 + part] += (word ^ flip) - flip;
        }
        self.pending += 1;
        if self.pending >= MOST_PENDING {
            self.carry();
        }
    }

    #[cold]
    fn add_special(&mut self, number: f64) {
        let kind = match number {
            f64::INFINITY => 0,
            f64::NEG_INFINITY => 1,
            _ => 2,
        };
        self.special[kind] += 1;
    }

    /// Adds another sum's numbers.
    pub(crate) fn merge(&mut self, mut other: Self) {
        self.carry();
        other.carry();
        for (word, more) in self.words.iter_mut().zip(other.words) {
            *word += more;
        }
        for (count, more) in self.special.iter_mut().zip(other.special) {
            *count += more;
        }
        self.pending = 2;
    }

    /// All words below 2³² and not negative, but for the last.
    fn carry(&mut self) {
        for k in 0..WORDS - 1 {
            let up = self.words[k] >> 32;
            self.words[k] -= up << 32;
            self.words[k + 1] += up;
        }
        self.pending = 1;
    }

    /// The sum as numbers that may be added to those of up to 2²⁹ other sums, one by one.
    pub(crate) fn to_numbers(&self) -> [i64; Self::NUMBERS] {
        let mut sum = self.clone();
        sum.carry();
        let mut numbers = [0; Self::NUMBERS];
        numbers[..WORDS].copy_from_slice(&sum.words);
        numbers[WORDS..].copy_from_slice(&sum.special);
        numbers
    }

    /// The sum of sums whose numbers were added.
    pub(crate) fn from_numbers(numbers: &[i64; Self::NUMBERS]) -> Self {
        let mut sum = Self::default();
        sum.words.copy_from_slice(&numbers[..WORDS]);
        sum.special.copy_from_slice(&numbers[WORDS..]);
        sum.carry();
        sum
    }

    /// The nearest number, of two the one with an even fraction.
    pub(crate) fn value(&self) -> f64 {
        let [up, down, none] = self.special;
        if up + down + none > 0 {
            return match (up, down, none) {
                (_, 0, 0) => f64::INFINITY,
                (0, _, 0) => f64::NEG_INFINITY,
                _ => f64::NAN,
            };
        }
        let mut size = self.clone();
        size.carry();
        let is_negative = size.words[WORDS - 1] < 0;
        if is_negative {
            size.words.iter_mut().for_each(|word| *word = -*word);
            size.carry();
        }
        let rounded = size.rounded();
        if is_negative { -rounded } else { rounded }
    }

    /// The nearest number to a sum that is not negative and has been carried.
    fn rounded(&self) -> f64 {
        let Some(top) = self.words.iter().rposition(|&word| word != 0) else {
            return 0.0;
        };
        let highest = 32 * top + self.words[top].ilog2() as usize;
        if highest <= FRACTION {
            // The integer is the number's bits, subnormal or of the least exponent.
            return f64::from_bits(self.bits(0));
        }
        let low = highest - FRACTION;
        let kept = self.bits(low) & ((1 << (FRACTION + 1)) - 1);
        let half = self.bits(low - 1) & 1;
        let is_odd = kept & 1 == 1;
        let up = half == 1 && (is_odd || self.has_bits_below(low - 1));
        // The leading one counts for an exponent of its own; a fraction that overflows goes on to the next.
        let exponent = low as u64 + 1;
        let bits = (exponent << FRACTION) + (kept - (1 << FRACTION)) + u64::from(up);
        f64::from_bits(bits.min(f64::INFINITY.to_bits()))
    }

    /// 64 bits of the integer, from bit `first` on.
    fn bits(&self, first: usize) -> u64 {
        let word = |k: usize| {
            self.words
                .get(first / 32 + k)
                .map_or(0, |&word| word as u128)
        };
        let wide = word(0) | word(1) << 32 | word(2) << 64;
        (wide >> (first % 32)) as u64
    }

    /// Whether any bit below bit `end` is set.
    fn has_bits_below(&self, end: usize) -> bool {
        let (whole, rest) = (end / 32, end % 32);
        let is_set = |&word: &i64| word != 0;
        self.words[..whole].iter().any(is_set) || self.words[whole] & ((1 << rest) - 1) != 0
    }
}

impl Extend<f64> for ExactSum {
    fn extend<T: IntoIterator<Item = f64>>(&mut self, numbers: T) {
        numbers.into_iter().for_each(|number| self.add(number));
    }
}

/// Exact sums of what `numbers` gives for every item, added by all threads.
pub(crate) fn exact_sums<T: Sync, const K: usize>(
    items: &[T],
    numbers: impl Fn(&T) -> [f64; K] + Sync,
) -> [ExactSum; K] {
    let runs = map_runs(items.len(), RUN, |run| {
        let mut sums: [ExactSum; K] = std::array::from_fn(|_| ExactSum::default());
        for item in &items[run] {
            for (sum, number) in sums.iter_mut().zip(numbers(item)) {
                sum.add(number);
            }
        }
        sums
    });
    let mut sums: [ExactSum; K] = std::array::from_fn(|_| ExactSum::default());
    for run in runs {
        for (sum, more) in sums.iter_mut().zip(run) {
            sum.merge(more);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_rational::BigRational;
    use num_traits::Zero;

    fn exact(numbers: &[f64]) -> BigRational {
        let all = numbers
            .iter()
            .map(|&number| BigRational::from_float(number).expect("finite"));
        all.fold(BigRational::zero(), |sum, number| sum + number)
    }

    fn sum(numbers: &[f64]) -> f64 {
        let mut sum = ExactSum::default();
        sum.extend(numbers.iter().copied());
        sum.value()
    }

    /// No number is nearer to the sum, and of two as near the one found is even.
    fn assert_nearest(numbers: &[f64]) {
        let (found, exact) = (sum(numbers), exact(numbers));
        let off = |number: f64| {
            let number = BigRational::from_float(number).expect("finite");
            let way = number - &exact;
            if way < BigRational::zero() { -way } else { way }
        };
        for other in [found.next_up(), found.next_down()] {
            let (own, beside) = (off(found), off(other));
            let is_even = found.to_bits() & 1 == 0;
            assert!(
                own < beside || own == beside && is_even,
                "{found:e} {numbers:?}"
            );
        }
    }

    #[test]
    fn sums_are_the_nearest_numbers_to_rational_ones() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            state >> 1
        };
        for spread in [1, 5, 60, 900] {
            for count in [1, 2, 3, 17, 100] {
                let numbers: Vec<f64> = (0..count)
                    .map(|_| {
                        let exponent = 1023 - spread / 2 + random() % spread;
                        let sign = (random() & 1) << 63;
                        f64::from_bits(sign | exponent << 52 | random() & ((1 << 52) - 1))
                    })
                    .collect();
                assert_nearest(&numbers);
            }
        }
        // Cancellation, halfway cases, subnormals, the largest.
        let tiny = f64::from_bits(1);
        for numbers in [
            vec![1e300, 1.0, -1e300],
            vec![1.0, f64::EPSILON / 2.0],
            vec![1.0, f64::EPSILON / 2.0, tiny],
            vec![1.0 + f64::EPSILON, f64::EPSILON / 2.0],
            vec![-1.0, -f64::EPSILON / 2.0, -tiny],
            vec![tiny, tiny, -1e-310, 2.3e-308],
            vec![f64::MAX / 2.0, f64::MAX / 4.0, -1.0],
            vec![0.0, -0.0],
            vec![0.1; 4000],
            vec![],
        ] {
            assert_nearest(&numbers);
        }
        assert_eq!(sum(&[0.1; 4000]).to_bits(), 400_f64.to_bits());
        assert!(sum(&[f64::MAX, f64::MAX]).is_infinite());
        assert!(sum(&[f64::INFINITY, 1.0]).is_infinite());
        assert!(sum(&[f64::INFINITY, f64::NEG_INFINITY]).is_nan() && sum(&[f64::NAN]).is_nan());
    }

    #[test]
    fn neither_order_nor_parts_change_a_bit() {
        let numbers: Vec<f64> = (1..30_000_u32)
            .map(|k| f64::from(k).sin() * 2_f64.powi((k % 97) as i32 - 40))
            .collect();
        let whole = sum(&numbers);
        let reversed: Vec<f64> = numbers.iter().rev().copied().collect();
        assert_eq!(whole.to_bits(), sum(&reversed).to_bits());
        let [by_threads, twice] = exact_sums(&numbers, |&number| [number, 2.0 * number]);
        assert_eq!(whole.to_bits(), by_threads.value().to_bits());
        assert_eq!((2.0 * whole).to_bits(), twice.value().to_bits());
        // As ranks add them up.
        let mut added = [0; ExactSum::NUMBERS];
        for part in numbers.chunks(7777) {
            let [part] = exact_sums(part, |&number| [number]);
            for (word, more) in added.iter_mut().zip(part.to_numbers()) {
                *word += more;
            }
        }
        let by_ranks = ExactSum::from_numbers(&added).value();
        assert_eq!(whole.to_bits(), by_ranks.to_bits());
    }
}
