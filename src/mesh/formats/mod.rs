//! One file per mesh format. Every `parse` takes the file's bytes and returns the mesh or a
//! [`error::ParseError`] with the line or byte where it stopped; none of them touches the disk,
//! panics on any bytes, or trusts an announced count with memory. [`read`] opens files.

pub(crate) mod binary;
pub mod error;
pub(crate) mod foreign;
pub mod gmsh;
pub(crate) mod gmsh_data;
pub(crate) mod gmsh_groups;
pub(crate) mod gmsh_input;
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
pub(crate) mod second_order;
pub mod stl;
pub mod tetgen;
pub(crate) mod three_mf;
pub(crate) mod unpack;
pub(crate) mod volint;
pub mod vtk;
pub(crate) mod vtk_input;
pub(crate) mod vtk_xml;
pub mod vtu;
pub(crate) mod words;
pub(crate) mod xml;
pub(crate) mod zip;
