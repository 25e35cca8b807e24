//! L∞ Voronoi cells: { y : d∞(x_i, y) ≤ d∞(x_j, y) for all j }, clipped to a domain.
//!
//! Such a cell is star-shaped about its site but not convex. Each of its six [`cone`]s, the points whose
//! largest coordinate difference from the site is ±k, is described over the square of directions
//! (u, v) ∈ \[−1, 1\]² by the gauge g = 1/h, h the distance to the cell's boundary: every site demands
//! g ≥ the least of at most three linear functions, every wall g ≥ one of them. [`envelope`] is the
//! upper envelope of these demands, convex polygons ([`ring`]) with one linear function each; [`search`]
//! walks outward in L∞ order up to the security distance 2 / min g. [`cell`] builds a cell, [`diagram`]
//! all of them, `outline` merges a cell's polygons to facets for files and pictures.
//!
//! # Ties
//!
//! Two sites with an equal coordinate are equidistant from whole regions of space. A tied region
//! belongs to the site with the smaller index, so that every point belongs to one cell and volumes
//! sum to the domain's. Among the periodic images of one site it belongs to the nearest in every
//! coordinate. Whether coordinates are equal is decided without rounding (`search`), so that
//! all cells agree on it.

pub(crate) mod cell;
pub(crate) mod cone;
pub(crate) mod diagram;

mod block;
mod facet_key;
mod oblique;
mod outline;
mod search;
mod strips;
mod sweep;
