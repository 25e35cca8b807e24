//! A 64-bit checksum: FNV-1a over words of eight bytes, with a shift that spreads high bits.
//!
//! Each step h ← m((h ⊕ w) · p), m(h) = h ⊕ (h >> 32), is a bijection of h and of w: a change of a
//! single word always changes the sum. Source of the constants: Fowler, Noll & Vo,
//! draft-eastlake-fnv, section 5.

const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0000_0100_0000_01b3;

/// A checksum under way.
#[derive(Clone, Copy, Debug)]
pub struct Checksum(u64);

impl Default for Checksum {
    fn default() -> Self {
        Self(OFFSET)
    }
}

impl Checksum {
    /// The checksum whose sum so far is this.
    pub(crate) fn going_on(sum: u64) -> Self {
        Self(sum)
    }

    /// Adds a word.
    pub fn add(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(PRIME);
        self.0 ^= self.0 >> 32;
    }

    /// Adds bytes as little-endian words, the last one filled up with zeros, without their number.
    pub fn add_bytes(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        for word in words {
            self.add(u64::from_le_bytes(*word));
        }
        if !rest.is_empty() {
            let mut word = [0; 8];
            word[..rest.len()].copy_from_slice(rest);
            self.add(u64::from_le_bytes(word));
        }
    }

    /// The sum of all that was added.
    #[must_use]
    pub fn sum(&self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(bytes: &[u8]) -> u64 {
        let mut checksum = Checksum::default();
        checksum.add_bytes(bytes);
        checksum.sum()
    }

    #[test]
    fn every_flipped_bit_and_every_exchange_changes_the_sum() {
        let bytes: Vec<u8> = (0..200_u8).collect();
        let whole = sum(&bytes);
        for place in 0..bytes.len() {
            for bit in 0..8 {
                let mut flipped = bytes.clone();
                flipped[place] ^= 1 << bit;
                assert_ne!(sum(&flipped), whole);
                flipped[bytes.len() - 1 - place] ^= 1 << bit;
                assert_ne!(sum(&flipped), whole);
            }
        }
        let mut exchanged = bytes.clone();
        exchanged.swap(3, 19);
        assert_ne!(sum(&exchanged), whole);
        assert_ne!(sum(&bytes[..192]), whole);
    }
}
