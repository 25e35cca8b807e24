//! Voronoi cells of the plane, through the crate `voronator` with a fallback of our own.

pub mod diagram;

mod grid;
