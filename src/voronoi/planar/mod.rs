//! Voronoi cells of the plane, by the crate `voronator` with a fallback by bisectors; L∞ cells by a sweep.

pub(crate) mod diagram;

mod grid;
mod linf;
