//! Domains of sites, of which every cell's part is a signed sum of pieces.
//!
//! A [`domain`] is a [`shape`], perhaps with a [`density`] beside it, also one that follows from a
//! wanted size of cells ([`density_region`]); [`density_sign`] finds where one is negative,
//! [`density_power`] integrates its powers. [`cuboid`] and [`convex`] are convex shapes, [`tri_surface`] those bounded
//! by triangles, [`tet_mesh`] those filled with tetrahedra, [`planar`] the domains of the plane, in convex parts by
//! [`trapezoids`], with a [`planar_density`].
//! [`facet_kind`] gives facet labels their meaning.

pub(crate) mod candidates;
pub(crate) mod convex;
pub(crate) mod cuboid;
pub(crate) mod density;
pub(crate) mod density_power;
pub(crate) mod density_region;
pub(crate) mod density_sign;
#[allow(clippy::module_inception, reason = "it names the folder")]
pub(crate) mod domain;
pub(crate) mod error;
pub(crate) mod facet_kind;
pub(crate) mod planar;
pub(crate) mod planar_density;
pub(crate) mod planar_error;
pub(crate) mod random_points;
pub(crate) mod shape;
pub(crate) mod shape_integrator;
pub(crate) mod tet_mesh;
pub(crate) mod trapezoids;
pub(crate) mod tri_surface;
