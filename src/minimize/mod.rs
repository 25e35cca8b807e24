//! Bound-constrained minimization on the traits of argmin.
//!
//! argmin keeps five nouns apart: the *problem* (a closure), the *solver* (one step), the
//! *state* (where it stands), the *executor* (the loop) and the *observer*. It ships no solver
//! that respects a box, so the one here is our own, and argmin is named nowhere else:
//!
//! * [`newton`]: two or three variables, exact Hessian, convex; one call per Voronoi cell.
//!
//! [`problem`] holds the words all speak: what an evaluation is, and why a run ended.

pub mod newton;
pub mod problem;

mod box_quadratic;
mod progress;
