//! Closed forms: exact integrals of polynomials over simplices and polyhedra.
//!
//! Nothing here samples: every integral is a finite expression in the coordinates of the
//! vertices, exact up to rounding. Sources: \[M\] Mirtich, *Fast and Accurate Computation of
//! Polyhedral Mass Properties*, 1996; \[CP\] Cattani & Paoluzzi, *Boundary integration over linear
//! polyhedra*, 1990, as restated in *Finite domain integration of polynomials* (LAR-CC, 2015);
//! \[BL\] Bukenberger & Lensch, *Tetrahedra of Varying Density and their Applications*.
//!
//! ```text
//!     simplex                    powers of one linear function
//!     series                     all monomials up to a degree, on any simplex; planar: in the plane
//!        │      polynomial ← formula (double_double) ← polynomial_text
//!        │          │             └ bernstein  bounds in a box
//!     mesh_moments  ┘          the ten moments of a surface, of tetrahedra, of a piece
//!        └ monomials           all integrals up to a degree over a surface, over a solid
//!        │
//!      lanes                   four simplices at a time
//!     half_space ← clip        … of the part of a solid above a plane
//!     pairwise                 sums by halves, in a fixed order
//!     reference                the papers' own formulas: [M], [CP], [BL]
//! ```
//!
//! Surfaces are slices of vertices and of triangles that name them, counter-clockwise seen from
//! outside. A routine that takes an `origin` measures from it: the caller picks one near the
//! body, so that coordinates far from zero cost no digits, and transfers the result with
//! [`Moments::translated`](crate::geometry::moments::Moments::translated).

pub(crate) mod adaptive;
pub mod bernstein;
pub(crate) mod cell_moments;
pub(crate) mod clip;
pub(crate) mod cone_rule;
mod double_double;
pub(crate) mod exact_sum;
pub(crate) mod expression;
pub(crate) mod expression_text;
mod formula;
pub mod half_space;
pub mod lanes;
pub mod mesh_moments;
pub(crate) mod monomials;
pub mod pairwise;
pub(crate) mod planar;
pub mod polynomial;
pub mod polynomial_text;
pub(crate) mod radial;
pub mod reference;
pub mod series;
pub mod simplex;
pub(crate) mod sine_jet;
