//! What a cell is worth: the Chebyshev energy of convex pieces about a center.

pub mod plane;
pub mod plane_center;
