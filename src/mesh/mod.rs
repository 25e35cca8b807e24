//! Meshes: read from files, checked, oriented, measured, and a few made by hand.
//!
//! A file becomes a [`surface::SurfaceMesh`] or a [`tets::TetMesh`] as it stands
//! ([`read::read`]). What may bound a solid is decided by [`validate::validate`] and
//! [`sound::validate_tets`], the only makers of [`validate::ClosedSurface`] and
//! [`sound::SoundTets`]; [`load::load`] does both steps and puts the file's name into every
//! message.

pub(crate) mod binary;
pub mod crossings;
pub mod edges;
pub mod error;
pub mod formats;
pub mod kind;
pub mod load;
pub(crate) mod nesting;
pub(crate) mod orient;
pub mod polygon;
pub mod read;
pub(crate) mod repair;
pub mod report;
pub mod shapes;
pub mod similarity;
pub mod sound;
pub mod surface;
pub mod tets;
pub(crate) mod text;
pub mod validate;
pub mod weld;
