//! Where sites may live: domains as signed sums of convex pieces.

pub mod plane;
