//! Voronoi cells of the plane, by the crate `voronator` with a fallback by bisectors.

pub mod diagram;

mod grid;
