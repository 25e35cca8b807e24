//! Domains of sites, of which every cell's part is a signed sum of pieces.
//!
//! A [`domain`] is a [`shape`], perhaps with a [`density`] beside it, also one that follows from a
//! wanted size of cells. [`cuboid`] and [`convex`] are convex shapes, [`tri_surface`] those bounded
//! by triangles, [`tet_mesh`] those filled with tetrahedra, [`planar`] the domains of the plane.
//! [`facet_kind`] gives facet labels their meaning.

pub(crate) mod candidates;
pub mod convex;
pub mod cuboid;
pub mod density;
#[allow(clippy::module_inception, reason = "it names the folder")]
pub mod domain;
pub mod error;
pub mod facet_kind;
pub mod planar;
pub mod shape;
pub mod tet_mesh;
pub mod tri_surface;
