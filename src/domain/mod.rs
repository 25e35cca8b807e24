//! Where sites may live: domains as signed sums of convex pieces.

pub mod plane;
pub mod beyond;
pub mod convex;
pub mod cuboid;
pub mod error;
pub mod space;
