//! Half-spaces, convex polyhedra and the clipping of one by the other; half-planes and polygons.
//!
//! A convex cell has two forms, each with its own clipper of the same tolerance policy:
//! [`small_polyhedron`] in fixed slots, for the many cuts that make a cell, and [`polyhedron`] of
//! any size ([`clip`]). Solids of any shape have two more: [`brep`], which integrals take, and
//! [`shell`], welded loops of corners, the form in which cells leave the program.

pub mod bounds;
pub mod brep;
pub mod bvh;
pub mod clip;
pub mod facet_polygons;
pub mod half_plane;
pub mod half_space;
pub mod label;
pub mod moments;
pub mod polygon;
pub mod polyhedron;
pub mod random;
pub mod section;
pub mod shell;
pub(crate) mod simd;
pub mod small_polyhedron;
pub mod small_polyhedron_clip;
