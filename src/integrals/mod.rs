//! Closed forms: exact integrals of polynomials over simplices and polyhedra.
//!
//! Nothing here samples: every integral is a finite expression in the coordinates of the
//! vertices, exact up to rounding. Sources: \[M\] Mirtich, *Fast and Accurate Computation of
//! Polyhedral Mass Properties*, 1996; \[CP\] Cattani & Paoluzzi, *Boundary integration over linear
//! polyhedra*, 1990; \[BL\] Bukenberger & Lensch, *Tetrahedra of Varying Density and their
//! Applications*.

pub mod simplex;
