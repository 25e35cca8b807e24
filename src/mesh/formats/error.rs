//! Errors of mesh files: the place, the fault, and the remedy.

use std::fmt;
use std::path::PathBuf;

use thiserror::Error;

/// The greatest number of vertices or triangles: sides (3 per triangle) must fit 32 bits.
pub(crate) const ELEMENT_LIMIT: usize = (u32::MAX / 4) as usize;

/// A mesh file that could not be read.
#[derive(Debug, Error)]
#[error("{}{error}", file.display())]
pub struct ReadError {
    /// The file as it was named by the caller.
    pub file: PathBuf,
    /// The place in it and what is wrong there.
    pub error: ParseError,
}

/// A place in a mesh file and what is wrong there.
#[derive(Debug, Error)]
#[error("{place}: {kind}")]
pub struct ParseError {
    /// Where reading stopped.
    pub place: Place,
    /// What is wrong.
    pub kind: ErrorKind,
}

impl ParseError {
    /// `kind` on the one-based `line` of a text file.
    #[must_use]
    pub fn on_line(line: usize, kind: ErrorKind) -> Self {
        let place = Place::Line(line);
        Self { place, kind }
    }

    /// `kind` at a zero-based byte offset of a binary file.
    #[must_use]
    pub fn at_byte(offset: usize, kind: ErrorKind) -> Self {
        let place = Place::Byte(offset);
        Self { place, kind }
    }

    /// `kind` with the file as a whole.
    #[must_use]
    pub fn whole(kind: ErrorKind) -> Self {
        let place = Place::Whole;
        Self { place, kind }
    }

    /// A file without the wanted elements `what`.
    pub(crate) fn missing(what: &'static str, mend: &'static str) -> Self {
        Self::whole(ErrorKind::Missing { what, mend })
    }
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// A one-based line of a text file.
    Line(usize),
    /// A zero-based byte offset of a binary file.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => Ok(()),
            Self::Line(line) => write!(out, ":{line}"),
            Self::Byte(offset) => write!(out, ": byte {offset}"),
        }
    }
}

/// What is wrong with a mesh file; every sentence ends with the mend.
#[derive(Debug, Error)]
pub enum ErrorKind {
    /// The operating system refused.
    #[error("cannot be read ({0}); check the path and its permissions")]
    Unreadable(#[from] std::io::Error),
    /// No bytes, or nothing but white space.
    #[error("the file is empty; export the mesh again")]
    Empty,
    /// The file stops early.
    #[error(
        "the file ends where {expected} should stand; it is truncated, copy or export it again"
    )]
    Truncated {
        /// The content expected next.
        expected: &'static str,
    },
    /// Something else than expected.
    #[error("expected {expected}, found `{found}`; correct the line or the counts before it")]
    Expected {
        /// The expected content.
        expected: &'static str,
        /// The content found, shortened.
        found: String,
    },
    /// A NaN or infinite number.
    #[error("`{found}` is not a finite number; every coordinate and value must be finite")]
    NotFinite {
        /// The number as written.
        found: String,
    },
    /// An element refers to a vertex that is not there.
    #[error("vertex {index} is out of range; the {vertices} vertices are numbered from {first}")]
    OutOfRange {
        /// The index as written.
        index: i64,
        /// How many vertices there are.
        vertices: usize,
        /// The number of the first vertex in this format.
        first: i64,
    },
    /// An announced count that differs from the number of elements in the file.
    #[error(
        "{announced} {what} are announced, {found} are there; correct the count or export the file again"
    )]
    WrongCount {
        /// What is counted.
        what: &'static str,
        /// The announced count.
        announced: usize,
        /// The count found.
        found: usize,
    },
    /// Valid, but not a dialect read here.
    #[error("{what} cannot be read; {mend}")]
    Unsupported {
        /// The dialect or element met.
        what: String,
        /// How to export the mesh instead.
        mend: &'static str,
    },
    /// A second-order element whose edges are not straight.
    #[error(
        "a second-order element is curved: its middle node at ({}, {}, {}) lies {share:.1e} of its edge's length off the edge; export first-order elements of a finer mesh",
        place[0], place[1], place[2]
    )]
    Curved {
        /// The middle node (L).
        place: [f64; 3],
        /// Its distance from the edge, in lengths of the edge.
        share: f64,
    },
    /// Compressed data that do not unpack.
    #[error("the compressed data are damaged ({0}); copy or pack the file again")]
    Damaged(String),
    /// The file holds no elements of the wanted kind.
    #[error("the file holds no {what}; {mend}")]
    Missing {
        /// The wanted elements.
        what: &'static str,
        /// What to do instead.
        mend: &'static str,
    },
    /// More elements than a 32-bit index counts.
    #[error("the file holds more than {limit} {what}; split or coarsen the mesh")]
    TooMany {
        /// What is counted.
        what: &'static str,
        /// The greatest count that can be indexed.
        limit: usize,
    },
}

impl ErrorKind {
    /// [`ErrorKind::Expected`] with what was found instead.
    pub(crate) fn expected(expected: &'static str, found: impl Into<String>) -> Self {
        let found = found.into();
        Self::Expected { expected, found }
    }

    /// [`ErrorKind::Unsupported`] with the way to export the mesh instead.
    pub(crate) fn unsupported(what: impl Into<String>, mend: &'static str) -> Self {
        let what = what.into();
        Self::Unsupported { what, mend }
    }

    /// [`ErrorKind::OutOfRange`] unless `vertex`, numbered from `first`, is one of `vertices`; its
    /// zero-based index.
    pub(crate) fn check_vertex(index: i64, vertices: usize, first: i64) -> Result<u32, Self> {
        let zero_based = index.checked_sub(first).and_then(|i| u32::try_from(i).ok());
        zero_based
            .filter(|&vertex| (vertex as usize) < vertices)
            .ok_or(Self::OutOfRange {
                index,
                vertices,
                first,
            })
    }

    /// [`ErrorKind::WrongCount`] unless as many `what` were found as announced.
    pub(crate) fn check_count(
        what: &'static str,
        announced: usize,
        found: usize,
    ) -> Result<(), Self> {
        if announced == found {
            return Ok(());
        }
        Err(Self::WrongCount {
            what,
            announced,
            found,
        })
    }

    /// [`ErrorKind::TooMany`] above the greatest count that is indexed.
    pub(crate) fn check_limit(what: &'static str, count: usize) -> Result<usize, Self> {
        let limit = ELEMENT_LIMIT;
        if count <= limit {
            return Ok(count);
        }
        Err(Self::TooMany { what, limit })
    }
}
