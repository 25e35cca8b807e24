//! Solids made from numbers: for tests, examples and the scenes' small mesh files.

pub mod boxes;
pub mod bracket;
pub mod sphere;
pub mod tubes;
