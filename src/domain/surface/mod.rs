//! Solids bounded by triangles: what a cell and such a solid have in common.
//!
//! [`solid`] is the domain. A cell that no triangle touches lies wholly inside and is its own only
//! piece. Of any other, [`triangle`] clips the near triangles to the cell and [`clipped`] closes
//! them with the inner parts of the cell's facets, found edge by edge, to one solid, whatever its
//! shape. Where rounding or a coincidence spoils that, [`shadow`] gives the same set as a signed
//! sum of convex pieces that needs no case analysis, and `outline` undoes the coincidence for files
//! and pictures. [`winding`] tells inside from outside, exactly; [`way`] tells how far one may go
//! before leaving.

pub(crate) mod cell_edges;
pub(crate) mod clearance;
pub mod clipped;
pub(crate) mod corner_numbers;
pub(crate) mod outline;
pub mod shadow;
pub mod solid;
pub mod triangle;
pub mod walls;
pub mod way;
pub mod winding;
