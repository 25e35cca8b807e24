//! Solids bounded by triangles: the common part of a cell and such a solid.
//!
//! [`solid`] is the domain, [`indexed`] its surface. A cell that no triangle touches, often
//! decided by `distance` alone, lies wholly inside and is its own only piece. Of any other,
//! [`triangle`] clips the near triangles to the cell and [`clip_cell`] closes them with the inner
//! parts of the cell's facets, found edge by edge (`edges`), to one solid, whatever its shape. Where
//! rounding or a coincidence prevents that, [`signed_prisms`] gives the same set as a signed sum of
//! convex pieces that needs no case analysis, and `outline` undoes the coincidence for files and
//! pictures. [`crate::mesh::winding`] computes exactly whether a point is inside, and where a ray leaves.

pub(crate) mod clip_cell;
pub(crate) mod convex_parts;
pub(crate) mod distance;
pub(crate) mod edges;
pub(crate) mod indexed;
pub(crate) mod outline;
pub(crate) mod signed_prisms;
pub(crate) mod solid;
pub(crate) mod triangle;
