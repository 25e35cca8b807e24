//! Octrees of solids, as \[BL\] section 4.1 compares its integrals with.
//!
//! The root is the solid's bounding box. A node that the surface touches is halved along all axes down
//! to a given depth; an untouched one is wholly inside or outside. The tree's size counts nodes that are
//! touched or inside, on all levels. Whether a triangle touches a box is decided by separating axes,
//! whether a point is inside by exact predicates along a line parallel to x; boxes are closed.

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::winding::{depth, turns};

/// The greatest depth: beyond it the boxes of a node's column would not fit memory.
pub(crate) const DEEPEST: u32 = 10;

/// A triangle nearer to a box than this share of the root's extent touches it: faces that lie in the planes
/// between boxes touch those on both sides, whatever their rounding.
const SLACK: f64 = 1e-12;

/// A node that is not halved and not outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OctreeLeaf {
    /// Its corner of least coordinates, in boxes of the last level.
    pub(crate) place: [u32; 3],
    /// How often the root was halved.
    pub(crate) level: u32,
    /// Whether the surface touches it, on the last level; else it is inside.
    pub(crate) is_touched: bool,
    /// Whether its middle is inside the solid.
    pub(crate) is_solid: bool,
}

/// An octree's leaves and size.
#[derive(Clone, Debug)]
pub(crate) struct Octree {
    /// The root.
    pub(crate) bounds: Bounds<3>,
    /// How often it is halved.
    pub(crate) depth: u32,
    /// The leaves that are touched or inside.
    pub(crate) leaves: Vec<OctreeLeaf>,
    /// How many nodes of all levels are touched or inside.
    pub(crate) nodes: usize,
}

impl Octree {
    /// The tree of so many levels below the root, of the solid within a closed surface.
    #[must_use]
    pub(crate) fn new(surface: &SurfaceMesh, depth: u32) -> Self {
        let bounds = surface.bounds();
        let tree = Self {
            bounds,
            depth,
            leaves: Vec::new(),
            nodes: 0,
        };
        let columns = Columns::of(surface, &tree);
        let mut builder = Builder {
            surface,
            columns,
            tree,
        };
        let all: Vec<u32> = (0..surface.triangles.len() as u32).collect();
        builder.visit([0; 3], 0, &all);
        builder.tree
    }

    /// The box of a node.
    #[must_use]
    pub(crate) fn node_box(&self, place: [u32; 3], level: u32) -> Bounds<3> {
        let count = 1_u32 << (self.depth - level);
        Bounds {
            min: self.corner(place),
            max: self.corner(place.map(|k| k + count)),
        }
    }

    /// A corner of the boxes of the last level; the same number for all boxes that share it.
    #[must_use]
    pub(crate) fn corner(&self, place: [u32; 3]) -> Point3<f64> {
        let all = f64::from(1_u32 << self.depth);
        let extent = self.bounds.extent();
        Point3::from(Vector3::from_fn(|axis, _| {
            self.bounds.min[axis] + extent[axis] * (f64::from(place[axis]) / all)
        }))
    }

    /// The middle of the box of the last level at `place`.
    fn middle(&self, place: [u32; 3]) -> Point3<f64> {
        nalgebra::center(&self.corner(place), &self.corner(place.map(|k| k + 1)))
    }
}

/// A tree under construction.
struct Builder<'a> {
    surface: &'a SurfaceMesh,
    columns: Columns,
    tree: Octree,
}

impl Builder<'_> {
    /// Adds the node at `place`, which only the triangles `near` may touch.
    fn visit(&mut self, place: [u32; 3], level: u32, near: &[u32]) {
        let (is_touched, is_last) = (!near.is_empty(), level == self.tree.depth);
        let is_solid =
            (is_last || !is_touched) && self.columns.hold(self.surface, &self.tree, place);
        if !is_touched && !is_solid {
            return;
        }
        self.tree.nodes += 1;
        if is_touched && !is_last {
            self.halve(place, level, near);
            return;
        }
        self.tree.leaves.push(OctreeLeaf {
            place,
            level,
            is_touched,
            is_solid,
        });
    }

    fn halve(&mut self, place: [u32; 3], level: u32, near: &[u32]) {
        let half = 1_u32 << (self.tree.depth - level - 1);
        for octant in 0..8_u32 {
            let child = [0, 1, 2].map(|axis| place[axis] + (octant >> axis & 1) * half);
            let slack = self.tree.bounds.extent() * SLACK;
            let node = self.tree.node_box(child, level + 1).grown(&slack);
            let touches = |triangle: &&u32| {
                let corners = self.surface.corners(**triangle as usize);
                node.meets_triangle(&corners)
            };
            let near: Vec<u32> = near.iter().filter(touches).copied().collect();
            self.visit(child, level + 1, &near);
        }
    }
}

/// For every column of boxes of the last level, the triangles that the line through their middles
/// meets, each with how it turns about the line.
struct Columns {
    side: u32,
    met: Vec<Vec<(u32, i32)>>,
}

impl Columns {
    fn of(surface: &SurfaceMesh, tree: &Octree) -> Self {
        let side = 1_u32 << tree.depth;
        let met = vec![Vec::new(); (side * side) as usize];
        let mut columns = Self { side, met };
        for (triangle, corners) in (0..).zip(surface.all_corners()) {
            let reach = Bounds::of(&corners);
            let [rows, columns_of_row] = [1, 2].map(|axis| columns.span(tree, &reach, axis));
            for j in rows {
                for k in columns_of_row.clone() {
                    let turns = turns(&corners, &tree.middle([0, j, k]));
                    if turns != 0 {
                        columns.met[(j * side + k) as usize].push((triangle, turns));
                    }
                }
            }
        }
        columns
    }

    /// The boxes whose middles may lie within `reach` along an axis.
    fn span(&self, tree: &Octree, reach: &Bounds<3>, axis: usize) -> std::ops::Range<u32> {
        let size = tree.bounds.extent()[axis] / f64::from(self.side);
        let place = |x: f64| (x - tree.bounds.min[axis]) / size - 0.5;
        // A box more on either side for rounding; casts saturate.
        let first = (place(reach.min[axis]).floor() - 1.0).max(0.0) as u32;
        let last = (place(reach.max[axis]).ceil() + 2.0).max(0.0) as u32;
        first.min(self.side)..last.min(self.side)
    }

    /// Whether the middle of the box of the last level at `place` is inside.
    fn hold(&self, surface: &SurfaceMesh, tree: &Octree, place: [u32; 3]) -> bool {
        let middle = tree.middle(place);
        let met = &self.met[(place[1] * self.side + place[2]) as usize];
        let ahead = met.iter().filter(|(triangle, turns)| {
            let corners = surface.corners(*triangle as usize);
            depth(&corners, &middle) * f64::from(*turns) > 0.0
        });
        ahead.map(|(_, turns)| turns).sum::<i32>() != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bvh::Bvh;
    use crate::mesh::shapes::{bracket, torus, unit_cube};
    use crate::mesh::winding::winding;

    #[test]
    fn the_unit_cube_is_touched_on_its_skin_only() {
        for depth in 0..=4 {
            let tree = Octree::new(&unit_cube(), depth);
            let side = 1_usize << depth;
            let inner = side.saturating_sub(2).pow(3);
            let touched = tree.leaves.iter().filter(|leaf| leaf.is_touched).count();
            assert_eq!(touched, side.pow(3) - inner, "depth {depth}");
            assert!(tree.leaves.iter().all(|leaf| leaf.is_solid));
        }
    }

    #[test]
    fn middles_are_inside_where_the_winding_number_says_so() {
        for surface in [torus(1.0, 0.4, 24, 12), bracket(4)] {
            let tree = Octree::new(&surface, 4);
            let bvh = Bvh::new(surface.all_corners().map(|corners| Bounds::of(&corners)));
            let mut outside = 16_usize.pow(3);
            for leaf in &tree.leaves {
                let middle = tree.node_box(leaf.place, leaf.level).center();
                if let Some(turns) = winding(&surface, &bvh, &middle) {
                    assert_eq!(leaf.is_solid, turns != 0, "{leaf:?}");
                }
                outside -= 1 << (3 * (4 - leaf.level));
            }
            assert!(outside > 0 && tree.leaves.iter().any(|leaf| !leaf.is_touched));
        }
    }

    #[test]
    fn a_leaf_is_touched_where_a_sample_of_the_surface_lies_in_it() {
        let surface = torus(1.0, 0.4, 24, 12);
        let tree = Octree::new(&surface, 5);
        let touched: Vec<_> = tree.leaves.iter().filter(|leaf| leaf.is_touched).collect();
        for [a, b, c] in surface.all_corners() {
            for [u, v] in [[0.2, 0.3], [0.0, 0.0], [0.1, 0.8]] {
                let place = a + (b - a) * u + (c - a) * v;
                let holds = |leaf: &&OctreeLeaf| tree.node_box(leaf.place, 5).contains(&place);
                assert!(touched.iter().copied().any(|leaf| holds(&leaf)), "{place}");
            }
        }
    }
}
