//! The walk from a site outward over the others, in L∞ order, up to a reach that shrinks.

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::domain::facet_kind::FacetKind;
use crate::geometry::bounds::Bounds;
use crate::geometry::label::Label;
use crate::voronoi::kd_tree::tree::KdTree;
use crate::voronoi::linf::cone::exact_displacement;

/// How far the first shell reaches, relative to the ball that holds an L2 cell's initial candidates.
const FIRST_SHELL: f64 = 0.8;

/// How much farther every shell reaches at most than the one before.
const GROWTH: f64 = 1.4;

/// A site, or a periodic image of one, near another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearby {
    /// How far it is in the Chebyshev distance (L).
    pub(crate) distance: f64,
    /// The displacement to it (L), exact in sign.
    pub(crate) displacement: Vector3<f64>,
    /// The site's index.
    pub(crate) site: u32,
    /// The number of its image among the tree's images.
    shift: u32,
}

impl Nearby {
    /// The label of facets towards it.
    pub(crate) fn label(&self, tree: &KdTree) -> Label {
        let image = tree.images()[self.shift as usize].image;
        let site = self.site;
        FacetKind::Neighbor { site, image }.label()
    }
}

/// The memory of a walk.
#[derive(Clone, Debug, Default)]
pub(crate) struct OutwardSearch {
    shell: Vec<Nearby>,
    stack: Vec<u32>,
}

impl OutwardSearch {
    /// Shows `visit` the other sites and their images, shell by shell and nearest first in each, until
    /// they are farther than the last reach it has returned (L). A site's own images are left out.
    pub(crate) fn walk<Stop>(
        &mut self,
        tree: &KdTree,
        place: usize,
        mut visit: impl FnMut(&[Nearby]) -> Result<f64, Stop>,
    ) -> Result<(), Stop> {
        let initial = FIRST_SHELL * tree.initial_radius_squared(place).sqrt();
        let (mut searched, mut limit) = (-1.0, initial.max(f64::MIN_POSITIVE));
        loop {
            self.gather(tree, place, (searched, limit));
            let reach = visit(&self.shell)?;
            if limit >= reach {
                return Ok(());
            }
            searched = limit;
            limit = (GROWTH * limit).min(reach);
        }
    }

    /// Lists the sites at distances above the first and up to the second, nearest first.
    fn gather(&mut self, tree: &KdTree, place: usize, (above, limit): (f64, f64)) {
        let Self { shell, stack } = self;
        let (own, here) = (tree.site(place), tree.position(place));
        shell.clear();
        for (shift, image) in tree.images().iter().enumerate() {
            let origin = here - image.by;
            // The boxes are displaced with rounding.
            let margin = limit + 4.0 * f64::EPSILON * (here.coords.amax() + image.by.amax());
            stack.push(1);
            while let Some(node) = stack.pop() {
                if gap(&tree.bounds(node), &origin) > margin {
                    continue;
                }
                if !tree.is_leaf(node) {
                    stack.extend([2 * node, 2 * node + 1]);
                    continue;
                }
                for other in tree.places(node).filter(|&other| tree.site(other) != own) {
                    let to = tree.position(other);
                    let displacement = exact_displacement(&here, &to, &image.by);
                    let distance = displacement.amax();
                    if distance > above && distance <= limit {
                        shell.push(Nearby {
                            distance,
                            displacement,
                            site: tree.site(other),
                            shift: shift as u32,
                        });
                    }
                }
            }
        }
        shell.sort_unstable_by(|one, other| {
            let ties = (one.site, one.shift).cmp(&(other.site, other.shift));
            one.distance.total_cmp(&other.distance).then(ties)
        });
    }
}

/// The site nearest to a point in the Chebyshev distance, or an image of it; of several the one with
/// the least index.
pub(crate) fn nearest(tree: &KdTree, point: &Point3<f64>) -> u32 {
    let (mut least, mut nearest) = (f64::INFINITY, u32::MAX);
    let mut stack = Vec::new();
    for image in tree.images() {
        let here = point - image.by;
        let rounding = 4.0 * f64::EPSILON * (point.coords.amax() + image.by.amax());
        stack.push(1);
        while let Some(node) = stack.pop() {
            if gap(&tree.bounds(node), &here) > least + rounding {
                continue;
            }
            if !tree.is_leaf(node) {
                let children = [2 * node, 2 * node + 1];
                let gaps = children.map_each(|child| gap(&tree.bounds(child), &here));
                let nearer_last = if gaps[0] < gaps[1] { 1 } else { 0 };
                stack.extend([children[nearer_last], children[1 - nearer_last]]);
                continue;
            }
            for place in tree.places(node) {
                let to = tree.position(place);
                let distance = exact_displacement(point, &to, &image.by).amax();
                if (distance, tree.site(place)) < (least, nearest) {
                    (least, nearest) = (distance, tree.site(place));
                }
            }
        }
    }
    nearest
}

/// The Chebyshev distance of a box from a point (L).
#[inline]
fn gap(bounds: &Bounds<3>, here: &Point3<f64>) -> f64 {
    let along = |axis: usize| (bounds.min[axis] - here[axis]).max(here[axis] - bounds.max[axis]);
    along(0).max(along(1)).max(along(2)).max(0.0)
}
