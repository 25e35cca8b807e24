//! Where a cell comes from: L2 Voronoi cells clipped to a domain.
//!
//! [`diagram`] checks sites and visits their cells in parallel, [`cell`] builds one from what
//! [`search`] finds around its site: the near sites in order (`surroundings`), which are gathered
//! from the [`index`] for many sites at once (`crowd`, in layers), and what else the cell can feel
//! (`far`). [`plane`] is the planar counterpart, through the crate `voronator`.

pub mod cell;
pub mod diagram;
pub mod index;
pub mod plane;
pub mod search;
pub mod shifts;

mod body;
mod candidate;
mod crowd;
mod delaunay;
mod far;
mod layer;
mod leaf_order;
mod plane_grid;
mod plane_sites;
mod shape;
mod siblings;
mod surroundings;
