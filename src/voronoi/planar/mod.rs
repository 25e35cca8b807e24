//! Voronoi cells of the plane, by the crate `voronator` with a fallback by bisectors.

pub(crate) mod diagram;

mod grid;
