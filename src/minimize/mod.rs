//! Bound-constrained minimization on the traits of argmin.
//!
//! argmin keeps five nouns apart: the *problem* (a closure), the *solver* (one step), the
//! *state* (where it stands), the *executor* (the loop) and the *observer*. It ships no solver
//! that respects a box, so the two here are our own, and argmin is named nowhere else:
//!
//! * [`newton`]: two or three variables, exact Hessian, convex; one call per Voronoi cell. It
//!   stands where `newton_state` says, steps (`newton_step`) by its quadratic model in the box
//!   (`box_quadratic`) and tests the step (`backtracking`) or predicts the minimum (`prediction`). Its loop is
//!   a plain one, for speed.
//! * [`lbfgsb`]: any number of variables, gradients only; the paper's choice for a cell, and the
//!   solver of the global objective. It is asked through [`lbfgsb_options`], stands where
//!   [`lbfgsb_state`] says, remembers its [`history`], and steps (`lbfgsb_step`) by the compact
//!   model (`compact`), the generalized Cauchy point (`cauchy`), the step over the free variables
//!   (`subspace`) and a search along it (`line_search`).
//!
//! [`problem`] holds the words all speak: what an evaluation is, and why a run ended; an
//! `objective` is a function that may know more than its values. `progress`
//! carries L-BFGS-B through argmin's executor.

pub mod history;
pub mod lbfgsb;
pub mod lbfgsb_options;
pub mod lbfgsb_state;
pub mod newton;
pub(crate) mod objective;
pub mod problem;

mod backtracking;
mod box_quadratic;
mod cauchy;
mod compact;
mod inverse;
mod lbfgsb_step;
mod line_search;
mod newton_state;
mod newton_step;
mod prediction;
mod progress;
mod slices;
mod subspace;
