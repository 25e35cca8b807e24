//! The cells of a diagram as one conforming mesh of polyhedra.
//!
//! A cell on its own is exact, but it knows nothing of the others: neighbors compute their common
//! vertices anew. Here vertices get an identity, the planes that meet in them ([`vertex_key`]).
//! [`cell_surface`] lists a cell's boundary by its planes, [`identify`] numbers the vertices of all
//! cells, [`loops`] removes what rounding alone made, [`assemble`] pairs faces into a mesh,
//! and [`check`] tests it. [`face_geometry`] and [`quality`] measure by the definitions of
//! OpenFOAM's `checkMesh`, [`element`] recognizes hexahedra, prisms, pyramids and tetrahedra.
//! [`linf_mesh`] does all of this for L∞ cells, without rounding, on [`grid_lines`].
//! [`collapse`] removes short edges from an [`edit_mesh`].

pub(crate) mod assemble;
pub(crate) mod cell_surface;
pub(crate) mod check;
pub(crate) mod collapse;
pub(crate) mod edit_mesh;
pub(crate) mod element;
pub(crate) mod face_geometry;
pub(crate) mod grid_lines;
pub(crate) mod identify;
pub(crate) mod linf_mesh;
pub(crate) mod loops;
pub(crate) mod mesh_builder;
pub(crate) mod quality;
pub(crate) mod shifted_union;
pub(crate) mod vertex_key;
pub(crate) mod wall_patches;
