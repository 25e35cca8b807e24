//! One L∞ Voronoi cell: the envelopes of its six cones.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::domain::domain::Domain;
use crate::domain::facet_kind::FacetKind;
use crate::geometry::bounds::Bounds;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::voronoi::kd_tree::tree::KdTree;
use crate::voronoi::linf::cone::{CONES, Cone};
use crate::voronoi::linf::envelope::{Envelope, Patch};
use crate::voronoi::linf::facet_key::{BETWEEN_CONES, FacetKey};
use crate::voronoi::linf::search::{Nearby, OutwardSearch};
use crate::voronoi::search::Duplicate;

/// Which sites with an equal coordinate cut a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ties {
    /// Those of smaller index: cells fill the domain.
    ToSmallerIndex,
    /// All of them: what is left is nearer to the site than to any other.
    Cut,
}

/// An L∞ cell while it is visited, in coordinates relative to its site.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinfCell<'a> {
    /// The site's position.
    pub(crate) position: Point3<f64>,
    cones: &'a [Envelope; CONES],
    labels: &'a [Label],
    has_ties: bool,
}

/// A fragment of a facet of a cell: a convex polygon, counter-clockwise from outside. With the site
/// it spans a convex part of the cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fragment {
    /// What is beyond.
    pub(crate) label: Label,
    /// Relative to the site (L).
    pub(crate) corners: Vec<Vector3<f64>>,
}

impl LinfCell<'_> {
    /// ∫ d∞^p over the part in each of the cones +x, −x, +y, −y, +z, −z (L^(3+p)).
    pub(crate) fn integrals(&self, order: u32) -> [f64; CONES] {
        self.cones.each_ref().map(|cone| cone.integral(order))
    }

    /// Its volume before it is clipped to a domain that is not convex (L³).
    pub(crate) fn volume(&self) -> f64 {
        self.integrals(0).iter().sum()
    }

    /// The fragments of its facets.
    pub(crate) fn visit_fragments(&self, mut visit: impl FnMut(&Fragment)) {
        let mut fragment = Fragment::default();
        for (cone, envelope) in Cone::all().into_iter().zip(self.cones) {
            for patch in envelope.patches() {
                fragment.assign(cone, patch, self.labels);
                visit(&fragment);
            }
        }
    }

    /// Passes the boundary of the cell to `visit`, as convex polygons that are counter-clockwise from
    /// outside: its fragments, and where regions are tied also the sides of its cones, which cancel
    /// except where the cell ends between two of them. Polygons of one facet have the same key.
    pub(crate) fn visit_boundary(&self, mut visit: impl FnMut(FacetKey, &[Vector3<f64>])) {
        let mut fragment = Fragment::default();
        for ((number, cone), envelope) in Cone::all().into_iter().enumerate().zip(self.cones) {
            for patch in envelope.patches() {
                fragment.assign(cone, patch, self.labels);
                let key = match FacetKind::of(fragment.label) {
                    FacetKind::Neighbor { .. } => (fragment.label, number, patch.form),
                    FacetKind::Wall(_) | FacetKind::Inner => (fragment.label, 0, 0),
                };
                visit(key, &fragment.corners);
                if self.has_ties {
                    visit_sides(cone, patch, &mut visit);
                }
            }
        }
    }

    /// The share of a displacement from the site that lies in the cell, which is star-shaped: at least
    /// 1 for one that ends in it. Infinite for none.
    pub(crate) fn share_within(&self, displacement: &Vector3<f64>) -> f64 {
        let of_cone = |cone: &Cone| cone.coordinates(displacement)[0];
        let ahead = Cone::all().into_iter().enumerate();
        let Some((number, cone)) = ahead.max_by(|a, b| of_cone(&a.1).total_cmp(&of_cone(&b.1)))
        else {
            return f64::INFINITY;
        };
        let [height, along_u, along_v] = cone.coordinates(displacement);
        if height <= 0.0 {
            return f64::INFINITY;
        }
        1.0 / (height * self.cones[number].at(along_u / height, along_v / height))
    }

    /// The least axis-aligned box around the cell, relative to its site.
    pub(crate) fn bounds(&self) -> Bounds<3> {
        let mut bounds = Bounds::of(&[Point3::origin()]);
        for (cone, envelope) in Cone::all().into_iter().zip(self.cones) {
            for corner in envelope.patches().iter().flat_map(Patch::corners) {
                bounds.include(&cone.displacement(*corner).into());
            }
        }
        bounds
    }

    /// Its volume within the cube of half side `half` about the site (L³).
    pub(crate) fn volume_within(&self, half: f64) -> f64 {
        let within = |envelope: &Envelope| {
            let mut envelope = envelope.clone();
            envelope.insert_constant(1.0 / half);
            envelope.integral(0)
        };
        self.cones.iter().map(within).sum()
    }

    /// The area vectors of its facets (L²), by what is beyond and by the cone and the normal, of which
    /// a neighbor may have several.
    pub(crate) fn facet_areas(&self) -> BTreeMap<FacetKey, Vector3<f64>> {
        let mut areas: BTreeMap<_, Vector3<f64>> = BTreeMap::new();
        self.visit_boundary(|key, corners| {
            let arm = |corner: usize| corners[corner] - corners[0];
            let fan = (2..corners.len()).map(|corner| arm(corner - 1).cross(&arm(corner)) * 0.5);
            *areas.entry(key).or_default() += fan.sum::<Vector3<f64>>();
        });
        areas
    }
}

impl Fragment {
    fn assign(&mut self, cone: Cone, patch: &Patch, labels: &[Label]) {
        self.label = labels[patch.source as usize];
        self.corners.clear();
        let corners = patch.corners().iter();
        (self.corners).extend(corners.map(|&corner| cone.displacement(corner)));
        if cone.is_negative {
            self.corners.reverse();
        }
    }
}

/// Passes the sides of a cone that a patch spans with the site, which are planes between two cones.
fn visit_sides(cone: Cone, patch: &Patch, visit: &mut impl FnMut(FacetKey, &[Vector3<f64>])) {
    let corners = patch.corners();
    for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        for along in [0, 1] {
            if from[along].abs() < 1.0 || from[along].to_bits() != to[along].to_bits() {
                continue;
            }
            let [a, b] = [from, to].map(|corner| cone.displacement(*corner));
            let ends = if cone.is_negative { [a, b] } else { [b, a] };
            let key = (BETWEEN_CONES, cone.side(along, from[along] < 0.0), 0);
            visit(key, &[Vector3::zeros(), ends[0], ends[1]]);
        }
    }
}

/// The memory in which cells are built, one after the other.
#[derive(Debug, Default)]
pub(crate) struct LinfCellBuilder {
    start: Polyhedron,
    cones: [Envelope; CONES],
    labels: Vec<Label>,
    search: OutwardSearch,
}

impl LinfCellBuilder {
    /// Builds the cell of the site in `place` of the tree.
    ///
    /// # Errors
    /// When another site, or an image of one, lies in the same place.
    pub(crate) fn build<'a>(
        &'a mut self,
        domain: &dyn Domain,
        tree: &KdTree,
        place: usize,
        ties: Ties,
    ) -> Result<LinfCell<'a>, Duplicate> {
        let (site, position) = (tree.site(place), tree.position(place));
        domain.start(&position, site, &mut self.start);
        self.begin();
        let Self {
            cones,
            labels,
            search,
            ..
        } = self;
        let (reach, mut has_ties) = (security_distance(cones), false);
        search.walk(tree, place, reach, |nearby| {
            if nearby.distance <= 0.0 {
                let (first, second) = (site.min(nearby.site), site.max(nearby.site));
                return Err(Duplicate { first, second });
            }
            has_ties |= nearby.displacement.iter().any(|&along| along == 0.0);
            let wins_ties = ties == Ties::Cut || nearby.site < site;
            if cut(cones, nearby, wins_ties, labels.len() as u32) {
                labels.push(nearby.label(tree));
            }
            Ok(security_distance(cones))
        })?;
        Ok(LinfCell {
            position,
            cones,
            labels,
            has_ties,
        })
    }

    /// Starts with the domain's walls.
    fn begin(&mut self) {
        self.labels.clear();
        self.cones.iter_mut().for_each(Envelope::clear);
        for facet in self.start.facets() {
            let (wall, source) = (facet.half_space(), self.labels.len() as u32);
            for (cone, envelope) in Cone::all().into_iter().zip(&mut self.cones) {
                envelope.insert(&cone.of_wall(&wall), source);
            }
            self.labels.push(facet.label());
        }
    }
}

/// Cuts the cones by a neighbor; says whether that changes any.
fn cut(cones: &mut [Envelope; CONES], nearby: &Nearby, wins_ties: bool, source: u32) -> bool {
    let mut is_changed = false;
    for (cone, envelope) in Cone::all().into_iter().zip(cones) {
        // No demand of a site exceeds 2 over its distance.
        if nearby.distance * envelope.least() >= 2.0 {
            continue;
        }
        let demand = cone.of_neighbor(&nearby.displacement, wins_ties);
        if !demand.is_empty() {
            is_changed |= envelope.insert(&demand, source);
        }
    }
    is_changed
}

/// The distance beyond which no site cuts: twice that of the farthest point (L).
fn security_distance(cones: &[Envelope; CONES]) -> f64 {
    let least = cones.iter().map(Envelope::least);
    2.0 / least.fold(f64::INFINITY, f64::min)
}
