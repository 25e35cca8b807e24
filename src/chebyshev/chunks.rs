//! Choosing from a list without a branch.
//!
//! Where a condition on geometry decides, a processor guesses wrong every other time, and pays more
//! than the work in question costs. So the condition is computed for a chunk of the list, and those
//! chosen are taken from a set of bits, one by one or four at a time.

/// Members of a list whose fate is decided together: as many as a set of bits holds.
pub(crate) const CHUNK: usize = u64::BITS as usize;

/// The members of a set of bits, in ascending order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bits(u64);

impl Bits {
    /// The members of a set of bits.
    #[inline]
    pub(crate) fn of(bits: u64) -> Self {
        Self(bits)
    }
}

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let number = self.0.trailing_zeros() as usize;
        (self.0 != 0).then(|| {
            self.0 &= self.0 - 1;
            number % CHUNK
        })
    }
}

/// Members of a list four at a time; a last group of less is filled up with `none`.
#[inline(always)]
pub(crate) fn fours<Item: Copy>(
    mut items: impl Iterator<Item = Item>,
    none: Item,
) -> impl Iterator<Item = [Item; 4]> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let first = items.next()?;
            let mut next = || items.next().unwrap_or(none);
            Some([first, next(), next(), next()])
        },
    )
}
