//! A bounding volume hierarchy: a tree of axis-aligned boxes.
//!
//! The tree halves its boxes along the longest axis of their middles until few
//! are left. Nodes are stored in depth-first order, each with the number of the next
//! node after its subtree, so that a query needs no stack.

use std::cell::Cell;

use nalgebra::Point3;

use crate::geometry::bounds::Bounds;

/// Boxes per leaf: testing four boxes costs about what two more levels would.
const LEAF: usize = 4;

/// Boxes, numbered in the order in which they were given.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bvh {
    nodes: Vec<BvhNode>,
    items: Vec<Item>,
}

/// A box and its number.
type Item = (Bounds<3>, u32);

#[derive(Clone, Debug)]
struct BvhNode {
    bounds: Bounds<3>,
    /// The next node after this one's subtree.
    past: u32,
    /// A leaf's boxes in `items`; none for an inner node.
    items: std::ops::Range<u32>,
}

impl Bvh {
    /// The tree over `boxes`.
    #[must_use]
    pub(crate) fn new(boxes: impl IntoIterator<Item = Bounds<3>>) -> Self {
        let mut items: Vec<_> = boxes.into_iter().zip(0..).collect();
        let mut nodes = Vec::with_capacity(2 * items.len() / LEAF + 1);
        if !items.is_empty() {
            build(&mut items, 0, &mut nodes);
        }
        Self { nodes, items }
    }

    /// The number of every box that `meets` and all of whose ancestors do, in an order that
    /// depends on the boxes only.
    pub(crate) fn visit(&self, meets: impl Fn(&Bounds<3>) -> bool, mut found: impl FnMut(u32)) {
        let mut place = 0;
        while let Some(node) = self.nodes.get(place) {
            if !meets(&node.bounds) {
                place = node.past as usize;
                continue;
            }
            let items = node.items.start as usize..node.items.end as usize;
            for (bounds, number) in &self.items[items] {
                if meets(bounds) {
                    found(*number);
                }
            }
            place += 1;
        }
    }
}

impl Bvh {
    /// The number of the item nearest to `point` and the square of its distance, given that of every
    /// item's own; `hint` is an item that may be near. None of nothing.
    pub(crate) fn nearest(
        &self,
        point: &Point3<f64>,
        hint: u32,
        distance_squared: impl Fn(u32) -> f64,
    ) -> Option<(u32, f64)> {
        self.nodes.first()?;
        let best = Cell::new((hint, distance_squared(hint)));
        let is_near =
            |bounds: &Bounds<3>| (bounds.clamp(point) - point).norm_squared() < best.get().1;
        self.visit(is_near, |number| {
            let distance = distance_squared(number);
            if distance < best.get().1 {
                best.set((number, distance));
            }
        });
        Some(best.get())
    }
}

/// Appends the nodes over `items`, which begin at place `first` of all.
fn build(items: &mut [Item], first: u32, nodes: &mut Vec<BvhNode>) {
    let corners = items.iter().flat_map(|(item, _)| [&item.min, &item.max]);
    let bounds = Bounds::of(corners);
    let here = nodes.len();
    let is_leaf = items.len() <= LEAF;
    let last = if is_leaf { items.len() as u32 } else { 0 };
    nodes.push(BvhNode {
        bounds,
        past: 0,
        items: first..first + last,
    });
    if !is_leaf {
        let (low, high) = halve(items);
        build(low, first, nodes);
        build(high, first + low.len() as u32, nodes);
    }
    nodes[here].past = nodes.len() as u32;
}

/// Splits boxes in two halves along the axis on which their middles extend farthest.
fn halve(items: &mut [Item]) -> (&mut [Item], &mut [Item]) {
    let mut middles = Bounds::empty();
    for (item, _) in items.iter() {
        middles.include(&item.center());
    }
    let axis = middles.extent().imax();
    let half = items.len() / 2;
    items.select_nth_unstable_by(half, |(a, i), (b, j)| {
        let by_middle = a.center()[axis].total_cmp(&b.center()[axis]);
        by_middle.then(i.cmp(j))
    });
    items.split_at_mut(half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_query_finds_what_a_scan_finds() {
        let boxes: Vec<Bounds<3>> = (0..100)
            .map(|k| {
                let turn = f64::from(k);
                let min = Point3::new(turn.sin(), (1.3 * turn).cos(), (2.1 * turn).sin());
                let max = min + Vector3::new(0.1, 0.2, 0.05) * (1.0 + turn.cos().abs());
                Bounds { min, max }
            })
            .collect();
        let tree = Bvh::new(boxes.iter().copied());
        for probe in &boxes {
            let mut found = Vec::new();
            tree.visit(|bounds| bounds.overlaps(probe), |number| found.push(number));
            found.sort_unstable();
            let scan = (0..100u32).filter(|&k| boxes[k as usize].overlaps(probe));
            assert_eq!(found, scan.collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_nearest_is_that_of_a_scan_for_any_hint() {
        let place = |k: u32| {
            let turn = f64::from(k);
            Point3::new(turn.sin(), (1.3 * turn).cos(), (2.1 * turn).sin())
        };
        let points: Vec<_> = (0..100).map(place).collect();
        let tree = Bvh::new(points.iter().map(|p| Bounds { min: *p, max: *p }));
        for k in 200..300 {
            let probe = place(k);
            let to = |number: u32| (points[number as usize] - probe).norm_squared();
            let scan = (0..100).map(to).fold(f64::INFINITY, f64::min);
            for hint in [0, k - 200, 99] {
                let (number, distance) = tree.nearest(&probe, hint, to).expect("there are points");
                assert_eq!((distance, to(number)), (scan, scan));
            }
        }
    }

    #[test]
    fn a_tree_of_nothing_finds_nothing() {
        Bvh::new([]).visit(|_| true, |_| panic!("there is nothing"));
    }
}
