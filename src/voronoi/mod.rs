//! Voronoi cells clipped to a domain: L2 cells, and in `linf` those of the Chebyshev distance.
//!
//! [`diagram`] validates sites and visits their cells in parallel, [`cell`] builds one cell from the
//! bisectors that [`search`] selects: candidates come nearest first from the [`kd_tree`], those
//! beyond the first radius only where a vertex can still be cut (`search::VertexBalls`). [`check`]
//! tests whether cells form a tessellation, [`cell_arrays`] lays chosen cells out flat. [`planar`] is the counterpart in the plane,
//! [`linf`] that for the Chebyshev distance.

pub(crate) mod cell;
pub(crate) mod cell_arrays;
pub(crate) mod check;
pub(crate) mod diagram;
pub(crate) mod linf;
pub(crate) mod planar;

mod kd_tree;
mod search;
