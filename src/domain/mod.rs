//! Where sites may live: domains as signed sums of convex pieces.
//!
//! [`space`] is the door that the floors above knock at; [`cuboid`] and [`convex`] are solids,
//! [`plane`] the domains of the plane. [`beyond`] gives facet labels their meaning.

pub mod beyond;
pub mod convex;
pub mod cuboid;
pub mod error;
pub mod plane;
pub mod space;
