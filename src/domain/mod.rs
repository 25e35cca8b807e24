//! Where sites may live: domains as signed sums of convex pieces.
//!
//! [`space`] is the door that the floors above knock at; [`cuboid`] and [`convex`] are convex
//! solids, [`surface`] those bounded by triangles, [`tets`] those filled with tetrahedra, [`plane`]
//! the domains of the plane. [`beyond`] gives facet labels their meaning, [`weighted`] domains a
//! density, also one that follows from a wanted size of cells.

pub mod beyond;
pub mod convex;
pub mod cuboid;
pub mod error;
pub(crate) mod graded;
pub(crate) mod near;
pub mod plane;
pub(crate) mod positive;
pub mod space;
pub mod surface;
pub mod tets;
pub mod weighted;
pub(crate) mod within;
