//! Labels of facets: opaque marks that are kept through clips.

/// An opaque facet mark: geometry keeps it through every clip and never reads it.
/// [`FacetKind`](crate::domain::facet_kind::FacetKind) gives its meaning: wall or neighbor.
pub(crate) type Label = u64;
