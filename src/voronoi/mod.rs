//! Where a cell comes from: L2 Voronoi cells clipped to a domain.

pub mod plane;
mod plane_grid;
pub mod cell;
pub mod diagram;
pub mod index;
