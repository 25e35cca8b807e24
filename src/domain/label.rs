//! What lies beyond a facet.
//!
//! The floors below carry labels without reading them; here they get their meaning.

/// An opaque facet label as geometry carries it.
pub type Label = u64;
