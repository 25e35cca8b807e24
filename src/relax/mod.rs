//! The loops that move sites, and the records they leave.
//!
//! A loop ([`lloyd`]) works on any [`tessellation`]: [`space`] is the one of solids, [`plane`] that
//! of planar domains. It shows an observer one [`record`] per move.

pub mod figures;
pub mod lloyd;
pub mod measure_plane;
pub mod objective;
pub mod plane;
pub mod record;
pub mod space;
pub mod tessellation;

mod plane_figures;
mod shape;
