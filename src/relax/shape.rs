//! The shape of a cell in space: its counted facets, aligned area and overlap with a cube.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::domain::beyond::Beyond;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::moments::Moments;
use crate::geometry::polyhedron::Polyhedron;
use crate::relax::figures::{ALIGNED, FACET_SHARE};

/// What is added up over the signed pieces of a cell whose site is the origin.
#[derive(Debug, Default)]
pub(crate) struct Shape {
    /// Per facet label, the area vector over all pieces.
    areas: BTreeMap<Label, Vector3<f64>>,
    overlap: f64,
}

impl Shape {
    /// Adds `sign` times the piece of a cell of volume `volume`.
    pub(crate) fn add(
        &mut self,
        sign: f64,
        piece: &Polyhedron,
        volume: f64,
        scratch: &mut ClipScratch,
    ) {
        for facet in piece.facets() {
            if Beyond::of(facet.label()) != Beyond::Inner {
                let sum = self.areas.entry(facet.label()).or_default();
                *sum += facet.area_vector() * sign;
            }
        }
        self.overlap += sign * cube_overlap(piece, volume, scratch);
    }

    /// How many facets are larger than [`FACET_SHARE`] of V^{2/3}.
    pub(crate) fn facets(&self, volume: f64) -> u32 {
        let least = FACET_SHARE * volume.cbrt().powi(2);
        self.areas
            .values()
            .filter(|area| area.norm() > least)
            .count() as u32
    }

    /// The share of the facet area whose unit normal has a component of at least [`ALIGNED`].
    pub(crate) fn axis_aligned(&self) -> f64 {
        let (mut aligned, mut all) = (0.0, 0.0);
        for vector in self.areas.values() {
            let area = vector.norm();
            all += area;
            if vector.amax() >= ALIGNED * area {
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

/// The volume of a piece's common part with the axis-aligned cube of volume `volume` about the
/// origin.
fn cube_overlap(piece: &Polyhedron, volume: f64, scratch: &mut ClipScratch) -> f64 {
    let mut common = piece.clone();
    let offset = 0.5 * volume.max(0.0).cbrt();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut normal = Vector3::zeros();
            normal[axis] = sign;
            let side = HalfSpace { normal, offset };
            if clip(&mut common, &side, Beyond::Inner.label(), scratch) == Clip::Emptied {
                return 0.0;
            }
        }
    }
    Moments::of(&common).volume
}
