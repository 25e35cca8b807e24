//! Half-spaces, convex polyhedra and the clipping of one by the other.

pub mod bounds;
pub mod half_plane;
pub mod label;
pub mod polygon;
