//! Files of `../shared/models`, which are not part of the repository.

use std::path::{Path, PathBuf};

/// A shared model.
///
/// # Panics
/// If it is absent: tests that need it are ignored unless requested (`--ignored`).
pub(crate) fn shared_model(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["../shared/models", "../../shared/models"].map(|folder| root.join(folder));
    let folder = folders.iter().find(|folder| folder.exists());
    let path = folder.unwrap_or(&folders[0]).join(name);
    assert!(path.exists(), "there is no {}", path.display());
    path
}
