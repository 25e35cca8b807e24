//! Labels of facets.

/// An opaque facet mark: geometry carries it through every clip and never reads it. The domain
/// floor says which marks are walls, the Voronoi floor which are neighbors.
pub type Label = u64;
