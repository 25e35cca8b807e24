//! The loop that moves sites, and the records that it leaves.
//!
//! [`driver`] carries out a [`plan`] in any [`relaxation_space`]: [`space`] is that of solids,
//! [`planar`] that of planar domains. It shows an observer one [`record`] per move. Its moves are
//! those of [`lloyd`], the steps of a [`descent`] along the global [`objective`], perturbations
//! (`perturb`, `noise`), and the levels of [`multilevel`] (`split`). Its [`state`] is all that a later
//! process needs to go on. An [`optimum`] is what energies are compared with, [`cell_check`] what must
//! hold of them.
//!
//! [`evaluate_cell`] computes a cell's energy and minimizer in its own [`frames`]; [`linf_cell`] the same of an L∞
//! cell, [`linf`] of all; [`planar_cell`] of one in the plane; [`metrics`] are the figures of cells for `measure`.
//!
//! Over [`ranks`] sites are distributed by [`bricks`] ([`ranked_sites`]): Lloyd's iteration holds no others
//! ([`ranked_lloyd`]), all other methods share out the cells alone ([`ranked_space`]).

pub(crate) mod bricks;
pub(crate) mod cell_check;
pub(crate) mod descent;
pub(crate) mod driver;
pub(crate) mod evaluate_cell;
pub(crate) mod frames;
pub(crate) mod linf;
pub(crate) mod linf_cell;
pub(crate) mod lloyd;
pub(crate) mod method;
pub(crate) mod metrics;
pub(crate) mod multilevel;
pub(crate) mod objective;
pub(crate) mod optimum;
pub(crate) mod plan;
pub(crate) mod planar;
pub(crate) mod planar_cell;
pub(crate) mod ranked_lloyd;
pub(crate) mod ranked_sites;
pub(crate) mod ranked_space;
pub(crate) mod ranks;
pub(crate) mod record;
pub(crate) mod relaxation;
pub(crate) mod relaxation_space;
pub(crate) mod space;
pub(crate) mod split;
pub(crate) mod state;

mod perturb;
