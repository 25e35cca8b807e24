//! Half-spaces, convex polyhedra and the clipping of one by the other; half-planes and polygons.
//!
//! A convex cell has two forms, each with its own clipper of the same tolerance policy:
//! [`small_polyhedron`] in fixed slots, for the many cuts that make a cell, and [`polyhedron`] of
//! any size ([`clip`]). Solids of any shape have two more: [`brep`], which integrals take, and
//! [`shell`], welded loops of corners, the form in which cells leave the program.

pub(crate) mod bounds;
pub(crate) mod brep;
pub(crate) mod bvh;
pub(crate) mod clip;
pub(crate) mod cover;
pub(crate) mod double_double;
pub(crate) mod facet_polygons;
pub(crate) mod half_plane;
pub(crate) mod half_space;
pub(crate) mod label;
pub(crate) mod moments;
pub(crate) mod polygon;
pub(crate) mod polyhedron;
pub(crate) mod random;
pub(crate) mod section;
pub(crate) mod shell;
pub(crate) mod simd;
pub(crate) mod small_polyhedron;
pub(crate) mod small_polyhedron_clip;
