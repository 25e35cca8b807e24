//! Errors of scenes and of the sites they name; unknown keys with the nearest known one.
//!
//! serde names unknown keys in the text of its message only ("unknown field `a`, expected one of
//! `b`, `c`"); `unknown_key` takes the words out of it again. A message of another form is shown
//! as it is.

use std::path::{Path, PathBuf};

use crate::domain::error::DomainError;
use crate::domain::planar_error::PlaneDomainError;
use crate::mesh::formats::error::ErrorKind;
use crate::mesh::formats::read::LoadError;
use crate::voronoi::diagram::DiagramError;
use crate::voronoi::planar::diagram::PlaneDiagramError;

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
        /// The command line's option, named like the key.
        option: String,
        /// What is wrong and what would be right.
        message: String,
    },
    /// A site file whose name does not determine its format.
    #[error(
        "cannot tell the format of {path}: name it .csv, .tsv, .npy, .xyz, .txt or .json, or say it by --sites-format",
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
        "no random point fell into the domain in {draws} draws: it fills too little of its bounding box; give the sites in a list or a file"
    )]
    NoRoom {
        /// How many were drawn.
        draws: u64,
    },
    /// More sites than there is memory for, or than can be numbered.
    #[error("{count} sites need about {needed} of memory: {available}; take fewer")]
    TooManySites {
        /// How many.
        count: u64,
        /// The estimate, with its unit.
        needed: String,
        /// What there is instead.
        available: String,
    },
    /// A grid of which the domain holds no point.
    #[error("the domain holds no point of the grid; give it more points")]
    EmptyGrid,
    /// Sites in space have no diagram.
    #[error(transparent)]
    Diagram(#[from] DiagramError),
    /// Sites of the plane have no diagram.
    #[error(transparent)]
    PlaneDiagram(#[from] PlaneDiagramError),
    /// The sites have no diagram, or the method cannot be carried out on it.
    #[error(transparent)]
    Relax(Box<dyn std::error::Error + Send + Sync>),
}

impl Error {
    /// A function from the system's error to that of reading `path`.
    pub(crate) fn reading(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        |source| Self::Read { path, source }
    }

    /// A file whose bytes could not be had.
    pub(crate) fn of_bytes(path: &Path, error: ErrorKind) -> Self {
        let path = path.to_owned();
        match error {
            ErrorKind::Unreadable(source) => Self::Read { path, source },
            other => Self::File {
                path,
                message: other.to_string(),
            },
        }
    }

    pub(crate) fn value(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Value {
            key: key.into(),
            message: message.into(),
        }
    }
}

/// The message without the position that serde_json appends.
pub(crate) fn bare_message(error: &serde_json::Error) -> String {
    let position = format!(" at line {} column {}", error.line(), error.column());
    let message = error.to_string();
    message
        .strip_suffix(&position)
        .unwrap_or(&message)
        .to_owned()
}

/// The error of serde_json in `text` of the file `path`, with its place and the nearest known key;
/// `mended` adds to a message what would be right.
pub(crate) fn json_error(
    error: &serde_json::Error,
    path: &Path,
    text: &str,
    mended: impl FnOnce(String) -> String,
) -> Error {
    let (line, column) = (error.line(), error.column());
    let (path, message) = (path.to_owned(), bare_message(error));
    match unknown_key(&message) {
        Some(UnknownKey {
            key,
            nearest,
            known,
        }) => Error::UnknownKey {
            path,
            line,
            column: start_of(&key, text, line, column),
            nearest,
            known,
            key,
        },
        None => Error::Json {
            path,
            line: line.max(1),
            column: column.max(1),
            message: mended(message),
        },
    }
}

/// serde_json points at the end of a key; this is its first column if the key is found there.
fn start_of(key: &str, text: &str, line: usize, column: usize) -> usize {
    let row = text.lines().nth(line.saturating_sub(1)).unwrap_or("");
    let quoted = format!("\"{key}\"");
    match row.get(..column) {
        Some(before) if before.ends_with(&quoted) => column - quoted.len() + 1,
        _ => column.max(1),
    }
}

/// A key, or a name as value, that is not known at its place.
pub(crate) struct UnknownKey {
    pub(crate) key: String,
    /// The known word most like it.
    pub(crate) nearest: String,
    /// All words known there.
    pub(crate) known: String,
}

/// The unknown word and the known ones, where serde's `message` is about such.
pub(crate) fn unknown_key(message: &str) -> Option<UnknownKey> {
    let rest = message
        .strip_prefix("unknown field `")
        .or_else(|| message.strip_prefix("unknown variant `"))?;
    let (key, expected) = rest.split_once("`, expected ")?;
    let known: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
    let distance = |word: &&&str| strsim::damerau_levenshtein(key, word);
    Some(UnknownKey {
        key: key.to_owned(),
        nearest: (*known.iter().min_by_key(distance)?).to_owned(),
        known: known.join(", "),
    })
}

fn more(others: usize) -> String {
    match others {
        0 => String::new(),
        _ => format!(" (and {others} more such sites)"),
    }
}
