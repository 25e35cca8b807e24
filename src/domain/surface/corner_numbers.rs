//! The numbers of the corners that triangles share within a cell.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use crate::domain::surface::triangle::Origin;

/// Numbers by what made the corner.
#[derive(Clone, Debug, Default)]
pub(crate) struct CornerNumbers {
    numbers: HashMap<u64, u32, BuildHasherDefault<Mixer>>,
}

impl CornerNumbers {
    pub(crate) fn clear(&mut self) {
        self.numbers.clear();
    }

    /// The number of the corner, which `make` gives to a new one. A corner within one triangle is
    /// always new.
    pub(crate) fn of(&mut self, origin: Origin, make: impl FnOnce() -> u32) -> u32 {
        let key = match origin {
            Origin::Within => return make(),
            Origin::Vertex(vertex) => u64::from(vertex),
            Origin::Side { edge, plane } => {
                1 << 63 | u64::from(edge) << 31 | u64::from(plane & 0x7fff_ffff)
            }
        };
        *self.numbers.entry(key).or_insert_with(make)
    }
}

/// Fibonacci hashing: numbers of a mesh are no attack, and a cell asks for many.
#[derive(Clone, Copy, Debug, Default)]
struct Mixer(u64);

impl Hasher for Mixer {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }

    fn write_u64(&mut self, number: u64) {
        let mixed = (self.0 ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ (mixed >> 32);
    }
}
