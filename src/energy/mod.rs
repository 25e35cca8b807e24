//! The Chebyshev energy of convex pieces about a center, and its minimizer.
//!
//! [`fragments`] cuts a cell into the six fragments of \[BL\] (section 3.5, Fig. 12) as geometry. Integrals
//! need no fragments: they sum over the piece's surface, subdivided by sector.
//!
//! # One evaluation
//!
//! A cell's energy for p = 1, from a center to value and derivatives, passes through eight files:
//!
//! 1. [`evaluation`]: `energy_jet` adds up signed pieces and chooses the sums;
//! 2. `surface`: `sum_over_surface` loops over edges, then over segments;
//! 3. `prepared`: vertices, facets and edges of the piece about the center, four at a time;
//! 4. `edge_crossings_simd`: the sectors of four edges' ends, and where the edges cross between them;
//! 5. `segments`: crossings and diagonals, paired up to segments of interfaces on facets;
//! 6. [`sector`]: the tables of sectors, interfaces and diagonals;
//! 7. `sums_linear`: the sums themselves, to value, gradient, Hessian and third derivatives;
//! 8. `geometry::simd`: products of vectors side by side.
//!
//! `edge_crossings` finds the few crossings that are left by 4. Other sums take the places of 7:
//! `sums_power` for any p, `sums_polynomial` where there is a density; and with integrals over facets
//! besides, for [`facet_terms`], the gradient of the global objective.
//!
//! # Before and after
//!
//! `preparation` makes prepared pieces, [`moments`] measures them, [`center`] minimizes the energy, for
//! p = 1 by `prediction`. [`planar`] is all of this in the plane, for one
//! polygon, [`planar_cell`] for a cell of several pieces, perhaps with a density; [`faceted`] is for
//! solids given by loose fragments of their boundary, [`swept`] for those swept by rectangles.
//!
//! \[BL\] Bukenberger & Lensch, *Tetrahedra of Varying Density and their Applications*.

pub(crate) mod center;
pub(crate) mod evaluation;
pub(crate) mod facet_terms;
pub(crate) mod faceted;
pub(crate) mod fragments;
pub(crate) mod moments;
pub(crate) mod planar;
pub(crate) mod planar_cell;
mod planar_density;
pub(crate) mod prepared;
pub(crate) mod sector;
pub(crate) mod swept;

mod edge_crossings;
mod edge_crossings_simd;
mod prediction;
mod preparation;
mod segments;
mod sums_linear;
mod sums_polynomial;
mod sums_power;
mod surface;
