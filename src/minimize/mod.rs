//! Bound-constrained minimization on the traits of argmin.
