//! Convergence curves and pictures of cells.
//!
//! Every picture is first a [`figure::Figure`], a plain list of shapes, which [`svg`] and [`png`]
//! write in their formats. Nothing here touches a file system: pictures are strings and bytes.

pub mod axis;
pub mod color;
pub mod convergence;
pub mod figure;
pub mod font;
pub mod png;
pub mod svg;
