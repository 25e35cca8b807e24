//! Convergence curves and pictures of cells.
//!
//! Every flat picture is first a [`figure::Figure`], a plain list of shapes, which [`svg`] and
//! [`png`] write in their formats; pictures in space are pixels from the start. Nothing here
//! touches a file system: pictures are strings and bytes.

pub mod axis;
pub mod camera;
pub mod color;
pub mod convergence;
pub mod cutaway;
pub mod exploded;
pub mod figure;
pub mod font;
pub mod panel;
pub mod patches;
pub mod png;
pub mod svg;
pub mod z_buffer;
