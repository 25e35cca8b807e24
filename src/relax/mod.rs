//! The loop that moves sites, and the records that it leaves.
//!
//! [`driver`] carries out a [`plan`] in any [`relaxation_space`]: [`space`] is that of solids,
//! [`planar`] that of planar domains. It shows an observer one [`record`] per move. Its moves are
//! those of [`lloyd`], the steps of a [`descent`] along the global [`objective`], perturbations
//! (`perturb`, `noise`), and the levels of [`multilevel`]. Its [`state`] is all that a later process
//! needs to go on.
//!
//! [`evaluate_cell`] computes a cell's energy and minimizer in its own [`frames`]; [`metrics`] are
//! the figures of cells for `measure`.

pub mod descent;
pub mod driver;
pub mod evaluate_cell;
pub mod frames;
pub mod lloyd;
pub mod metrics;
pub mod multilevel;
pub mod objective;
pub mod plan;
pub mod planar;
pub mod record;
pub mod relaxation;
pub mod relaxation_space;
pub mod space;
pub mod state;

mod perturb;
