//! The cells of a diagram as one conforming mesh of polyhedra.
//!
//! A cell on its own is exact, but it knows nothing of the others: neighbors compute their common
//! vertices anew. Here vertices get an identity, the planes that meet in them ([`vertex_key`]).
//! [`cell_surface`] lists a cell's boundary by its planes, [`identify`] numbers the vertices of all
//! cells, [`loops`] removes what rounding alone made, [`assemble`] pairs faces into a mesh,
//! and [`check`] tests it. [`face_geometry`] and [`quality`] measure by the definitions of
//! OpenFOAM's `checkMesh`, [`element`] recognizes hexahedra, prisms, pyramids and tetrahedra.
//! [`linf_mesh`] does all of this for L∞ cells, without rounding, on [`grid_lines`], with
//! [`grid_facets`], [`tied_facets`] and [`numbered_facets`]; [`wall_clip`] clips them to convex polyhedra.
//! [`collapse`] removes short edges from an [`edit_mesh`], [`straighten`] vertices of two edges; both keep to
//! the limits of [`edit_shapes`]. [`solid_mesh`] does what a solid's walls need beyond that:
//! [`wall_polygons`], [`wall_cut`], [`cell_union`], [`repair`], all on the surface ([`wall_projection`]).
//! [`dual`] makes an element of every vertex, and [`divide`] parts those that are no hexahedra, prisms,
//! pyramids or tetrahedra with a positive [`jacobian`] into an [`element_mesh`]. [`listed_cells`] pairs the
//! faces of cells from a file.

pub(crate) mod assemble;
pub(crate) mod cell_surface;
pub(crate) mod cell_union;
pub(crate) mod check;
pub(crate) mod collapse;
pub(crate) mod divide;
pub(crate) mod dual;
pub(crate) mod edit_mesh;
pub(crate) mod edit_shapes;
pub(crate) mod edited_order;
pub(crate) mod element;
pub(crate) mod element_mesh;
pub(crate) mod face_geometry;
pub(crate) mod facet_overlap;
pub(crate) mod grid_facets;
pub(crate) mod grid_lines;
pub(crate) mod identify;
pub(crate) mod jacobian;
pub(crate) mod linf_mesh;
#[cfg(feature = "cli")]
pub(crate) mod listed_cells;
pub(crate) mod loop_corner;
pub(crate) mod loop_shape;
pub(crate) mod loops;
pub(crate) mod merge_flat;
pub(crate) mod mesh_builder;
pub(crate) mod numbered_facets;
pub(crate) mod point_copies;
pub(crate) mod polygon_cut;
pub(crate) mod quality;
pub(crate) mod repair;
pub(crate) mod shifted_union;
pub(crate) mod solid_mesh;
pub(crate) mod sorted_faces;
pub(crate) mod straighten;
pub(crate) mod straighten_all;
pub(crate) mod tied_facets;
pub(crate) mod untangle;
pub(crate) mod vertex_groups;
pub(crate) mod vertex_key;
pub(crate) mod wall_clip;
pub(crate) mod wall_cut;
pub(crate) mod wall_patches;
pub(crate) mod wall_polygons;
pub(crate) mod wall_projection;
