//! Names of feature types and objects, numbered as they appear, and the types that are no part.

use std::collections::HashMap;

/// What has no mark before the first layer or type of a file that has some.
pub(crate) const START_CODE: &str = "(start code)";

/// What has no mark otherwise.
pub(crate) const UNTYPED: &str = "(untyped)";

/// What is pushed out between other features when tools change.
pub(crate) const FLUSH: &str = "(flush)";

/// What a raft is made of where its type is one of the part's.
pub(crate) const RAFT: &str = "(raft)";

/// Words in the names of types that are no part: PrusaSlicer's `Skirt/Brim`, `Support material`,
/// `Wipe tower`, `Custom` (start, end and change of tools), OrcaSlicer's and Bambu Studio's `Skirt`,
/// `Brim`, `Support`, `Prime tower`, Cura's `SKIRT`, `SUPPORT-INTERFACE`, `PRIME-TOWER`.
const NO_PART: [&str; 10] = [
    "skirt",
    "brim",
    "raft",
    "support",
    "tower",
    "purge",
    "prime",
    "flush",
    "custom",
    "start code",
];

/// Whether beads of the type `name` belong to the part.
pub(crate) fn is_part(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    !NO_PART.iter().any(|word| name.contains(word))
}

/// Names in the order of their appearance.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    list: Vec<String>,
    places: HashMap<String, usize>,
}

impl Names {
    /// The place of `name` in the list, at its end if it is new.
    pub(crate) fn place(&mut self, name: &str) -> usize {
        if let Some(&place) = self.places.get(name) {
            return place;
        }
        self.list.push(name.to_owned());
        self.places.insert(name.to_owned(), self.list.len() - 1);
        self.list.len() - 1
    }

    pub(crate) fn list(&self) -> &[String] {
        &self.list
    }
}
