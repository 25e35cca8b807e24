//! Why a scene or its sites cannot be used: every way to refuse what comes in.

use std::path::PathBuf;

use crate::domain::error::DomainError;
use crate::domain::planar::PlaneDomainError;
use crate::mesh::formats::read::LoadError;

/// Why a scene or its sites cannot be used. Site indices count from zero, lines from one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be opened or read.
    #[error("cannot read {path}: {source}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A scene is not JSON, or a value has the wrong type.
    #[error("{path}, line {line}, column {column}: {message}", path = path.display())]
    Json {
        /// The scene's file.
        path: PathBuf,
        /// Counted from one.
        line: usize,
        /// Counted from one.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// A scene has a key, or a name as value, that means nothing there.
    #[error(
        "{path}, line {line}, column {column}: unknown key `{key}`; did you mean `{nearest}`? Known here: {known}",
        path = path.display()
    )]
    UnknownKey {
        /// The scene's file.
        path: PathBuf,
        /// Counted from one.
        line: usize,
        /// Counted from one.
        column: usize,
        /// The unknown word.
        key: String,
        /// The known word most like it.
        nearest: String,
        /// All words known there.
        known: String,
    },
    /// A value of the scene has the right type and makes no sense.
    #[error("the scene's `{key}`: {message}")]
    Value {
        /// The key's path, for example `domain.box.min`.
        key: String,
        /// What is wrong and what would be right.
        message: String,
    },
    /// An override that does not fit the scene.
    #[error("{option} does not fit the scene: {message}")]
    Override {
        /// The command line's option.
        option: &'static str,
        /// What is wrong and what would be right.
        message: String,
    },
    /// A site file whose name does not tell its format.
    #[error(
        "cannot tell the format of {path}: name it .csv, .npy, .xyz, .txt or .json",
        path = path.display()
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// A line of a site file is not a point.
    #[error("{path}, line {line}: {message}", path = path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Counted from one.
        line: usize,
        /// What is wrong there.
        message: String,
    },
    /// A site file as a whole cannot be used.
    #[error("{path}: {message}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// A coordinate is NaN or infinite.
    #[error("site {index} {point} is not finite")]
    NotFinite {
        /// Counted from zero.
        index: usize,
        /// The point as text.
        point: String,
    },
    /// Sites outside the domain.
    #[error(
        "site {index} {point} lies outside the domain{}; move or remove it, enlarge the scene's domain, or leave such sites out with --drop-outside", more(*others)
    )]
    Outside {
        /// The first such site, counted from zero.
        index: usize,
        /// The point as text.
        point: String,
        /// How many more there are.
        others: usize,
    },
    /// No site is left inside the domain.
    #[error("all sites lie outside the domain: none is left")]
    AllOutside,
    /// Two sites at the same place.
    #[error(
        "sites {first} and {second} are at the same place {point}{}; remove one of them", more(*others)
    )]
    Duplicate {
        /// The lower index, counted from zero.
        first: usize,
        /// The higher index.
        second: usize,
        /// The point as text.
        point: String,
        /// How many more sites repeat an earlier one.
        others: usize,
    },
    /// The scene's domain in space is none.
    #[error("the scene's `domain`: {0}")]
    Solid(#[from] DomainError),
    /// The scene's mesh file gives no solid.
    #[error(transparent)]
    Mesh(#[from] LoadError),
    /// The scene's domain in the plane is none.
    #[error("the scene's `domain`: {0}")]
    Plane(#[from] PlaneDomainError),
    /// No site fell into the domain.
    #[error(
        "no random point fell into the domain in {draws} draws: it fills too little of its bounding box"
    )]
    NoRoom {
        /// How many were drawn.
        draws: u64,
    },
    /// A grid of which the domain holds no point.
    #[error("the domain holds no point of the grid; give it more points")]
    EmptyGrid,
}

impl Error {
    pub(crate) fn value(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Value {
            key: key.into(),
            message: message.into(),
        }
    }
}

fn more(others: usize) -> String {
    match others {
        0 => String::new(),
        _ => format!(" (and {others} more such sites)"),
    }
}
