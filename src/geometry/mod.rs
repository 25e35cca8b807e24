//! Half-spaces, convex polyhedra and the clipping of one by the other.

pub mod bounds;
pub mod half_plane;
pub mod label;
pub mod polygon;
pub mod clip;
pub mod half_space;
pub mod label;
pub mod moments;
pub mod polyhedron;
