//! Triangulated surfaces and tetrahedral meshes: validated, repaired, measured, made by formula,
//! read from files.
//!
//! A mesh from arrays is a [`surface::SurfaceMesh`] or a [`tets::TetMesh`], unchecked.
//! [`validate::validate_surface`] and [`validate::validate_tets`] decide what bounds or fills a
//! solid and are the only makers of [`validate::ValidSurface`] and [`validate::ValidTetMesh`].
//! Nothing here but `formats` touches files: `formats::read::load` reads, validates and puts
//! the file's name into every message.

pub(crate) mod bores;
pub(crate) mod closed_surface;
pub(crate) mod contacts;
pub(crate) mod cut;
pub mod edges;
pub(crate) mod elements;
#[cfg(feature = "files")]
pub mod formats;
pub(crate) mod holes;
pub(crate) mod nesting;
pub(crate) mod octree;
pub(crate) mod orient;
pub(crate) mod overlap;
#[cfg(feature = "cli")]
pub(crate) mod parts;
pub(crate) mod poly_mesh;
pub mod polygon;
pub(crate) mod repair;
pub mod report;
pub mod shapes;
pub mod similarity;
pub(crate) mod slabs;
pub mod surface;
pub(crate) mod surface_distance;
pub mod tets;
pub(crate) mod triangle_tree;
pub mod validate;
pub(crate) mod weld_tets;
pub(crate) mod winding;
