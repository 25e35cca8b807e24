//! Reference implementations of the papers' own formulas.
//!
//! Nothing in production calls them: they are the independent second opinion that the routines of
//! [`mesh_moments`](crate::integrals::mesh_moments) are tested against, and a starting point for
//! who needs a monomial over a surface or faces with holes.

pub mod cattani_paoluzzi;
pub mod mirtich;
pub mod polygon;
pub mod tetrahedron;
