//! A file becomes a solid: read, checked, repaired where no guess is needed.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::mesh::error::ReadError;
use crate::mesh::kind::Mesh;
use crate::mesh::read::read;
use crate::mesh::report::{Refusal, SurfaceReport, TetReport};
use crate::mesh::similarity::Similarity;
use crate::mesh::sound::{SoundTets, validate_tets};
use crate::mesh::validate::{ClosedSurface, validate};

/// A solid given by its boundary or by tetrahedra that fill it.
#[derive(Clone, Debug, PartialEq)]
pub enum Solid {
    /// The boundary.
    Surface(ClosedSurface, SurfaceReport),
    /// The filling.
    Tets(SoundTets, TetReport),
}

/// A file that gives no solid.
#[derive(Debug, Error)]
pub enum LoadError {
    /// It could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// It was read, but bounds or fills no solid.
    #[error("{} {refusal}", file.display())]
    Refused {
        /// The file as it was named by the caller.
        file: PathBuf,
        /// Why, and what to do.
        refusal: Refusal,
    },
}

/// Reads and checks a mesh file of either kind.
///
/// # Errors
///
/// The file and what is wrong with it, with the mend.
pub fn load(path: &Path) -> Result<Solid, LoadError> {
    let solid = match read(path)? {
        Mesh::Surface(mesh) => {
            validate(&mesh).map(|(surface, report)| Solid::Surface(surface, report))
        }
        Mesh::Tets(mesh) => validate_tets(&mesh).map(|(tets, report)| Solid::Tets(tets, report)),
    };
    solid.map_err(|refusal| {
        let file = path.to_path_buf();
        LoadError::Refused { file, refusal }
    })
}

impl Solid {
    /// What was found and repaired, one sentence each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        match self {
            Self::Surface(_, report) => report.notes(),
            Self::Tets(_, report) => report.notes(),
        }
    }

    /// The solid's volume (L³).
    #[must_use]
    pub fn volume(&self) -> f64 {
        match self {
            Self::Surface(surface, _) => surface.surface().volume(),
            Self::Tets(tets, _) => tets.mesh().volume(),
        }
    }

    /// Moves the solid by `map`.
    pub fn transform(&mut self, map: &Similarity) {
        match self {
            Self::Surface(surface, _) => surface.transform(map),
            Self::Tets(tets, _) => tets.transform(map),
        }
    }
}
