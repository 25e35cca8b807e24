//! L∞ Voronoi cells: { y : d∞(x_i, y) ≤ d∞(x_j, y) for all j }, clipped to a domain.
//!
//! Such a cell is star-shaped about its site but not convex. Each of its six [`cone`]s, the points whose
//! largest coordinate difference from the site is ±k, is swept from the site outward ([`sweep`]). At the
//! height h its section is a square, of which a neighbor takes a quadrant of one corner that moves with
//! speed 1 along both axes: what is left is a few rectangles whose sides move evenly between events that
//! are coordinates, halves and sums of two. Between two events a rectangle is a convex [`block`], over which
//! any power of h has a closed integral; [`corner_paths`] are what sums about any center need, [`strips`] are the polygons of the boundary, and `oblique` clips
//! both by walls that are not along the axes. [`search`] walks outward in L∞ order up to the security
//! distance, twice that of the cell's farthest point. [`cell`] builds a cell, [`diagram`] all of them,
//! `outline` merges a cell's polygons to facets for files and pictures.
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
mod columns;
mod corner_paths;
mod facet_key;
mod oblique;
mod outline;
mod quadrant;
mod search;
mod strips;
mod sweep;
