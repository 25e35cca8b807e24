//! Writers of sites, cells and run directories.

pub(crate) mod abaqus;
pub mod atomic_write;
#[cfg(feature = "cli")]
pub(crate) mod compress;
pub(crate) mod field_vtu;
pub(crate) mod gmsh;
pub(crate) mod medit;
pub(crate) mod mesh_vtu;
#[cfg(feature = "cli")]
pub(crate) mod octree_vtu;
pub(crate) mod poly_mesh;
#[cfg(feature = "scene")]
pub mod run;
pub mod sites;
pub(crate) mod stl;
pub(crate) mod su2;
pub(crate) mod three_mf;
pub mod vtu;
