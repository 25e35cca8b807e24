//! Convergence curves and pictures of cells.
//!
//! Every flat picture is first a [`figure::Figure`], a plain list of shapes, which [`svg`] and
//! [`png`] write in their formats; pictures in space are pixels from the start. Nothing here
//! touches a file system: pictures are strings and bytes.

pub(crate) mod axis;
pub(crate) mod camera;
pub(crate) mod color;
pub(crate) mod convergence;
pub(crate) mod cutaway;
pub(crate) mod density_cut;
pub(crate) mod exploded;
pub(crate) mod exploded_lines;
pub(crate) mod figure;
pub(crate) mod font;
pub(crate) mod histograms;
pub(crate) mod mesh_cutaway;
pub(crate) mod octrees;
pub(crate) mod panel;
pub(crate) mod patches;
pub(crate) mod planar_fragments;
pub(crate) mod png;
pub(crate) mod print_layer;
pub(crate) mod series;
pub(crate) mod svg;
pub(crate) mod z_buffer;
