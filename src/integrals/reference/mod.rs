//! Reference implementations of the papers' own formulas.
//!
//! They are not used in production: the routines of [`mesh_moments`](crate::integrals::mesh_moments)
//! are tested against them, and they integrate monomials over surfaces and faces with holes.

pub mod cattani_paoluzzi;
pub mod mirtich;
pub mod polygon;
pub mod tetrahedron;
