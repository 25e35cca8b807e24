//! The key that polygons of one facet of an L∞ cell share.

use crate::domain::facet_kind::FacetKind;
use crate::geometry::label::Label;

/// What tells facets of a cell apart: the label, and the cone and the form of the demand; of a wall the
/// label alone; between two cones the number of their common plane.
pub(crate) type FacetKey = (Label, usize, u8);

/// The label of facets between two cones.
pub(crate) const BETWEEN_CONES: Label = FacetKind::Inner.label();
