//! Where a cell comes from: L2 Voronoi cells clipped to a domain.
//!
//! [`diagram`] checks sites and visits their cells in parallel, [`cell`] builds one from what
//! [`index`] finds nearby, as [`search`] asks for it. [`plane`] is the planar counterpart, through the crate `voronator`.

pub mod cell;
pub mod diagram;
pub mod index;
pub mod plane;
pub mod search;

mod delaunay;
mod far;
mod plane_grid;
mod plane_sites;
mod shape;
mod surroundings;
