//! Writers of sites, cells and run directories.

pub mod atomic_write;
pub(crate) mod field_vtu;
pub(crate) mod mesh_vtu;
pub(crate) mod poly_mesh;
#[cfg(feature = "scene")]
pub mod run;
pub mod sites;
pub mod vtu;
