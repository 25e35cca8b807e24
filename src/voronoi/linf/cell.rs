//! One L∞ Voronoi cell: the envelopes of its six cones.

use nalgebra::{Point3, Vector3};

use crate::domain::domain::Domain;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::voronoi::kd_tree::tree::KdTree;
use crate::voronoi::linf::cone::{CONES, Cone};
use crate::voronoi::linf::envelope::{Envelope, Patch};
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
    /// The site's index.
    pub(crate) site: u32,
    /// The site's position.
    pub(crate) position: Point3<f64>,
    cones: &'a [Envelope; CONES],
    labels: &'a [Label],
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

    /// How many fragments there are.
    pub(crate) fn fragment_count(&self) -> usize {
        self.cones.iter().map(|cone| cone.patches().len()).sum()
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
        let reach = security_distance(cones);
        search.walk(tree, place, reach, |nearby| {
            if nearby.distance <= 0.0 {
                let (first, second) = (site.min(nearby.site), site.max(nearby.site));
                return Err(Duplicate { first, second });
            }
            let wins_ties = ties == Ties::Cut || nearby.site < site;
            if cut(cones, nearby, wins_ties, labels.len() as u32) {
                labels.push(nearby.label(tree));
            }
            Ok(security_distance(cones))
        })?;
        Ok(LinfCell {
            site,
            position,
            cones,
            labels,
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
