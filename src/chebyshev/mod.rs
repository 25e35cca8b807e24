//! What a cell is worth: the Chebyshev energy of convex pieces about a center.
//!
//! [`fragments`] cuts a cell into the six fragments of \[BL\] as geometry. The integrals come the
//! short way: [`integrand`] keeps what does not depend on the center, [`walk`] measures the piece's
//! surface and splits it by [`sector`], four edges at a time, [`energy`] sums up, [`center`]
//! minimizes. [`plane`] holds the integrals in the plane.

pub mod borders;
pub mod center;
pub mod energy;
pub mod fragments;
pub mod integrand;
pub(crate) mod interface;
pub(crate) mod mark;
pub mod plane;
pub mod sector;
pub mod walk;
pub(crate) mod weighted;
pub(crate) mod weighted_borders;

mod at_vertices;
mod bend;
mod chunks;
mod crossing;
mod detours;
mod edges;
mod endpoint;
mod endpoints;
mod family;
mod four;
mod linear;
mod linear_borders;
mod passing;
mod passings;
mod pierced;
mod planes;
mod points;
mod quartic;
mod seen;
mod segments;
mod sight;
mod slots;
mod terms;
mod visit;
