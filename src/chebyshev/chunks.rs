//! Choosing from a list without a branch.
//!
//! Where a condition on geometry decides, a processor guesses wrong every other time, and pays more
//! than the work in question costs. So the condition is computed for a chunk of the list, and those
//! chosen are taken from a set of bits.

/// Members of a list whose fate is decided together: as many as a set of bits holds.
pub(crate) const CHUNK: usize = u64::BITS as usize;

/// The numbers, in ascending order, of those among the first [`CHUNK`] members that are wanted.
#[inline]
pub(crate) fn chosen<Member>(
    members: &[Member],
    is_wanted: impl Fn(usize, &Member) -> bool,
) -> Bits {
    let mut bits = 0;
    for (number, member) in members.iter().take(CHUNK).enumerate() {
        bits |= u64::from(is_wanted(number, member)) << number;
    }
    Bits(bits)
}

/// The members of a set of bits, in ascending order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bits(u64);

impl Bits {
    /// The members of a set of bits.
    #[inline]
    pub(crate) fn of(bits: u64) -> Self {
        Self(bits)
    }

    /// Those of the first `count` that are not in the set.
    #[inline]
    pub(crate) fn others(self, count: usize) -> Self {
        Self(!self.0 & u64::MAX >> (CHUNK - count.clamp(1, CHUNK)))
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
