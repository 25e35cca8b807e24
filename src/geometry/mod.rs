//! Half-spaces, convex polyhedra and the clipping of one by the other; half-planes and polygons.

pub mod bounds;
pub mod box_tree;
pub mod clip;
pub mod faceted;
pub mod half_plane;
pub mod half_space;
pub mod label;
pub(crate) mod lanes;
pub mod moments;
pub mod outline;
pub mod polygon;
pub mod polyhedron;
pub mod primitives;
pub mod random;
pub mod section;
pub mod shell;
pub mod small_polyhedron;
pub mod small_polyhedron_clip;
