//! Closed forms: exact integrals of polynomials over simplices and polyhedra.
//!
//! Nothing here samples: every integral is a finite expression in the coordinates of the
//! vertices, exact up to rounding. Sources: \[M\] Mirtich, *Fast and Accurate Computation of
//! Polyhedral Mass Properties*, 1996; \[CP\] Cattani & Paoluzzi, *Boundary integration over linear
//! polyhedra*, 1990, as restated in *Finite domain integration of polynomials* (LAR-CC, 2015);
//! \[BL\] Bukenberger & Lensch, *Tetrahedra of Varying Density and their Applications*.
//!
//! ```text
//!                    simplex                 powers of one linear function
//!                    series                  all monomials up to a degree, on any simplex
//!        ┌──────────────┼──────────────┐
//!    structure       polygon       polynomial ← polynomial_text
//!    [CP]            loops, holes      │      └─── bernstein     bounds in a box
//!                                 polynomial_density
//!    mirtich [M]     tetrahedra [BL]   surface           the ten moments of a body
//!        └──────────────┴──────┬───────┴── moments
//!                             lanes                  four simplices at a time
//!                            pairwise                sums by halves, in a fixed order
//! ```
//!
//! Surfaces are slices of vertices and of triangles that name them, counter-clockwise seen from
//! outside. A routine that takes an `origin` measures from it: the caller picks one near the
//! body, so that coordinates far from zero cost no digits, and transfers the result with
//! [`moments::Moments::moved`].

pub mod bernstein;
pub mod lanes;
pub mod mirtich;
pub mod moments;
pub mod pairwise;
pub mod polygon;
pub mod polynomial;
pub mod polynomial_density;
pub mod polynomial_text;
pub mod series;
pub mod simplex;
pub mod structure;
pub mod surface;
pub mod tetrahedra;
