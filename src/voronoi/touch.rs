//! Whether a cell is touched by a site that has no facet of it.
//!
//! In an exact lattice the six nearest sites make a cube, and twenty more pass by its corners and
//! edges without a cut. The cube looks sound by itself, but the least move makes facets of those
//! sites: such a cell must not be carried.

use crate::geometry::bounds::Bounds;
use crate::geometry::small_polyhedron::{SmallPolyhedron, slots};
use crate::voronoi::candidate::{Candidate, Subtree};
use crate::voronoi::far::FarVertices;
use crate::voronoi::index::SiteIndex;

/// A site touches a vertex if its squared distance from there is at most so much more than the
/// own site's, as a share: above the rounding of vertices, and below what cells beyond doubt leave
/// to others.
const TOUCH: f64 = 4e-12;

/// Once in so many levels of the index, what vertices feel is looked at closely.
const LEVELS: u32 = 4;

/// The memory of the question.
#[derive(Clone, Debug, Default)]
pub(crate) struct Touch {
    vertices: FarVertices,
    stack: Vec<Subtree>,
}

impl Touch {
    /// Whether the cell of the site in `place` is touched.
    pub(crate) fn is_touched(
        &mut self,
        index: &SiteIndex,
        place: usize,
        cell: &SmallPolyhedron,
    ) -> bool {
        let Self { vertices, stack } = self;
        vertices.clear();
        for slot in slots(cell.alive) {
            let reach = cell.square[slot] * (1.0 + TOUCH);
            vertices.push([cell.x[slot], cell.y[slot], cell.z[slot], reach]);
        }
        // What touches a vertex is at most twice as far away.
        let limit = 4.0 * cell.radius_squared() * (1.0 + TOUCH);
        let site = index.position(place);
        stack.clear();
        stack.extend((0..index.shifts().len()).map(Subtree::whole));
        while let Some(subtree) = stack.pop() {
            let by = index.shifts()[subtree.shift as usize].by;
            let here = site - by;
            let is_asked = index.is_leaf(subtree.node) || subtree.node.ilog2() % LEVELS == 0;
            if is_asked && !vertices.meet(&index.bounds(subtree.node), &here) {
                continue;
            }
            if !index.is_leaf(subtree.node) {
                let children = subtree.children(index, &here).into_iter();
                stack.extend(children.filter(|child| child.gap_squared <= limit));
                continue;
            }
            let touches = |other: usize| {
                let candidate = Candidate::new(index, &site, (other, subtree.shift), &by);
                let [min, max] = [index.position(other); 2];
                candidate.distance_squared <= limit
                    && vertices.meet(&Bounds { min, max }, &here)
                    && !cell.labels.contains(&candidate.label(index))
            };
            let mut others = index.places(subtree.node).filter(|&other| other != place);
            if others.any(touches) {
                return true;
            }
        }
        false
    }
}
