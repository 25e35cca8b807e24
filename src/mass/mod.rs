//! Mass properties of solids with varying density.
//!
//! A solid is a closed surface or a tetrahedral mesh; its density a constant, a ramp over the
//! body's extent, a piecewise-linear profile, a polynomial, or values at the vertices of the
//! mesh. Each kind has an exact integral over each solid, without voxels or
//! tetrahedralization:
//!
//! ```text
//!              closed surface                       tetrahedral mesh
//! constant     signed cones                         tetrahedra, density 1
//! linear       signed cones of linear density       tetrahedra of linear density
//! polynomial   divergence theorem                   monomials over tetrahedra
//! profile      cones cut at the break planes        tetrahedra cut at the break planes
//! vertex       –                                    tetrahedra of linear density
//! ```
//!
//! [`weigh`] picks the integral and makes a [`body::Body`], with mass, center of mass and
//! inertia about any point or axis; bodies can be combined. [`split`] is the cutting of one
//! tetrahedron by a plane, [`cut`] that of a whole mesh.
//!
//! **Accuracy.** Everything is integrated about the middle of the solid's bounding box and
//! transferred from there to the center of mass once; a body keeps both points apart, so a solid
//! far from the coordinates' origin loses no digit of its inertia about its own center. Sums run
//! by halves in a fixed order: relative errors are a few ulps of the sum of the absolute values
//! of the terms, and the bits do not depend on the number of threads.

pub mod body;
pub mod cut;
pub mod density;
pub(crate) mod evaluate;
pub mod principal;
pub mod profile;
pub(crate) mod sign;
pub mod split;
pub(crate) mod tet_values;
pub mod weigh;
