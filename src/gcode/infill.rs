//! The feature types that are infill and may be modulated.

/// The names of sparse infill: PrusaSlicer's `Internal infill`, OrcaSlicer's and Bambu Studio's
/// `Sparse infill`, Cura's `FILL`, Simplify3D's `infill`.
const SPARSE: [&str; 4] = ["internal infill", "sparse infill", "fill", "infill"];

/// The feature types that count as infill.
#[derive(Clone, Debug, Default)]
pub(crate) struct InfillTypes(Vec<String>);

impl InfillTypes {
    /// These names, or the usual ones if there are none.
    pub(crate) fn new(names: impl IntoIterator<Item = String>) -> Self {
        let names = names.into_iter();
        let mut names: Vec<_> = names.map(|name| name.trim().to_ascii_lowercase()).collect();
        if names.is_empty() {
            names = SPARSE.map(str::to_owned).to_vec();
        }
        Self(names)
    }

    /// Whether the type `name` is infill, whatever its case.
    pub(crate) fn has(&self, name: &str) -> bool {
        let is = |known: &String| known.eq_ignore_ascii_case(name.trim());
        self.0.iter().any(is)
    }

    /// The names, each of which must be in the file.
    pub(crate) fn names(&self) -> &[String] {
        &self.0
    }
}
