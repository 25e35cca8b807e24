//! Bound-constrained minimization on the traits of argmin.
//!
//! argmin keeps five nouns apart: the *problem* (a closure), the *solver* (one step), the
//! *state* between two steps, the *executor* (the loop) and the *observer*. It ships no solver
//! that respects a box, so the two here are our own, and argmin is named nowhere else:
//!
//! * [`newton`]: two or three variables, exact Hessian, convex; one call per Voronoi cell.
//!   `newton_step` minimizes the quadratic model in the box (`box_qp`) and tests the step; `ahead`
//!   predicts the minimum of a polynomial. Its loop is a plain one, for speed.
//! * [`lbfgsb`]: any number of variables, gradients only; \[BL\]'s choice for a cell, and the
//!   solver of the global objective, on argmin's executor. Its [`lbfgsb_state`] holds the
//!   [`history`] of pairs; a step takes the compact model (`compact_bfgs`), the generalized Cauchy
//!   point (`cauchy`), the minimizer over the free variables (`subspace`) and a `line_search`, all within
//!   `variable_bounds`.
//!
//! [`problem`] holds evaluations, minima and why a run ended; an `objective` is a function that may
//! know its higher derivatives. `blas1` has the sums over long vectors.

pub(crate) mod history;
pub(crate) mod lbfgsb;
pub(crate) mod lbfgsb_state;
pub(crate) mod newton;
pub(crate) mod objective;
pub(crate) mod problem;

mod blas1;
mod box_qp;
mod cauchy;
mod compact_bfgs;
mod line_search;
mod newton_step;
mod prediction;
mod subspace;
mod variable_bounds;
