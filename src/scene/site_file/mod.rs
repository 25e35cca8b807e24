//! Sites from disk: one file per format, chosen by the file's extension in [`read`].
//!
//! Every reader says in which line (or row) a point is not one.

pub mod json;
pub mod npy;
pub mod read;
pub mod text;
