//! The shape of a cell in space: its counted facets, aligned area and overlap with a cube.

use std::collections::BTreeMap;

use nalgebra::{Rotation3, Vector3};

use crate::domain::facet_kind::FacetKind;
use crate::geometry::brep::Piece;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::relax::figures::{ALIGNED, FACET_SHARE};

/// What is added up over the signed pieces of a cell whose site is the origin.
#[derive(Debug, Default)]
pub(crate) struct Shape {
    /// Per facet label, the area vector over all pieces. A wall is what the domain says it is: for a
    /// surface, the triangles in one plane that hang together.
    areas: BTreeMap<Label, Vector3<f64>>,
    overlap: f64,
}

impl Shape {
    /// Adds the facets of `sign` times the piece.
    pub(crate) fn add(&mut self, sign: f64, piece: Piece<'_>) {
        piece.visit_facets(|label, _, area| {
            if FacetKind::of(label) != FacetKind::Inner {
                *self.areas.entry(label).or_default() += area * sign;
            }
        });
    }

    /// Adds `volume` to what the cell and its cube have in common.
    pub(crate) fn add_overlap(&mut self, volume: f64) {
        self.overlap += volume;
    }

    /// How many facets are larger than [`FACET_SHARE`] of V^{2/3}.
    pub(crate) fn facets(&self, volume: f64) -> u32 {
        let least = FACET_SHARE * volume.cbrt().powi(2);
        self.areas
            .values()
            .filter(|area| area.norm() > least)
            .count() as u32
    }

    /// The share of the facet area whose unit normal has a component of at least [`ALIGNED`] in the
    /// cell's frame.
    pub(crate) fn axis_aligned(&self, frame: Option<&Rotation3<f64>>) -> f64 {
        let (mut aligned, mut all) = (0.0, 0.0);
        for vector in self.areas.values() {
            let area = vector.norm();
            all += area;
            let turned = frame.map_or(*vector, |frame| frame.inverse() * vector);
            if turned.amax() >= ALIGNED * area {
                aligned += area;
            }
        }
        if all > 0.0 { aligned / all } else { 0.0 }
    }

    /// |C ∩ Q| / |C ∪ Q| for the cube Q of the cell's volume about its site.
    pub(crate) fn cubeness(&self, volume: f64) -> f64 {
        let union = 2.0 * volume - self.overlap;
        if union > 0.0 {
            self.overlap / union
        } else {
            0.0
        }
    }
}

/// The common part of a cell with the cube of volume `volume` about the origin, in the cell's frame.
pub(crate) fn within_cube(
    cell: &Polyhedron,
    volume: f64,
    frame: Option<&Rotation3<f64>>,
    scratch: &mut ClipScratch,
) -> Polyhedron {
    let mut common = cell.clone();
    let offset = 0.5 * volume.max(0.0).cbrt();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut normal = Vector3::zeros();
            normal[axis] = sign;
            let normal = frame.map_or(normal, |frame| frame * normal);
            let side = HalfSpace { normal, offset };
            if clip(&mut common, &side, FacetKind::Inner.label(), scratch) == Clip::Emptied {
                return common;
            }
        }
    }
    common
}
