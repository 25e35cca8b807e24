//! One file per mesh format. Every `parse` takes the file's bytes and returns the mesh or a
//! [`error::ParseError`] with the line or byte where it stopped; none of them touches the disk,
//! panics on any bytes, or trusts an announced count with memory. [`read`] opens files.

pub(crate) mod binary;
pub mod error;
pub mod gmsh;
pub mod medit;
pub mod mesh;
pub mod obj;
pub mod off;
pub(crate) mod open_foam;
pub mod ply;
pub(crate) mod point_data;
#[cfg(feature = "scene")]
pub(crate) mod polygons;
pub mod read;
pub mod stl;
pub mod tetgen;
pub(crate) mod volint;
pub mod vtk;
pub mod vtu;
pub(crate) mod words;
pub(crate) mod xml;
