//! Sites by distance, one after the other, however the index lies.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::geometry::label::Label;
use crate::voronoi::candidate::{Candidate, Subtree};

/// No site in a box is nearer than the box by more than rounding, which this share is far above.
const SURELY: f64 = 1.0 - 1e-12;

/// What comes next.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Next {
    /// A site that no other one precedes.
    Candidate(Candidate),
    /// Sites that may be nearer than all others.
    Subtree(Subtree),
}

/// What has still to be looked at.
#[derive(Clone, Debug, Default)]
pub(crate) struct Queue {
    heap: BinaryHeap<Entry>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    /// The squared distance of a candidate, or one that no site in a subtree falls below (L²).
    square: f64,
    /// The candidate's label. Subtrees have none and come first.
    label: Option<Label>,
    next: Next,
}

impl Queue {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.heap.clear();
    }

    /// Adds a site and its label.
    pub(crate) fn push_candidate(&mut self, candidate: Candidate, label: Label) {
        self.heap.push(Entry {
            square: candidate.distance_squared,
            label: Some(label),
            next: Next::Candidate(candidate),
        });
    }

    /// Adds a subtree.
    pub(crate) fn push_subtree(&mut self, subtree: Subtree) {
        self.heap.push(Entry {
            square: SURELY * subtree.gap_squared,
            label: None,
            next: Next::Subtree(subtree),
        });
    }

    /// Takes out what comes next.
    pub(crate) fn pop(&mut self) -> Option<Next> {
        self.heap.pop().map(|entry| entry.next)
    }
}

impl Ord for Entry {
    /// The nearest is the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        let by_square = other.square.total_cmp(&self.square);
        by_square.then_with(|| other.label.cmp(&self.label))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use rayon::prelude::*;

    use crate::domain::cuboid::Cuboid;
    use crate::domain::domain::Domain;
    use crate::domain::shape::DomainShape;
    use crate::geometry::bounds::Bounds;
    use crate::voronoi::cell::CellBuilder;
    use crate::voronoi::index::SiteIndex;
    use crate::voronoi::search::Manner;

    /// The bits of all cells, by site.
    fn cells(domain: &dyn Domain, index: &SiteIndex) -> Vec<String> {
        let (mut builder, places) = (CellBuilder::default(), index.places_of_sites());
        let cells = places.iter().map(|&place| {
            let built = builder.build_in(Manner::InOrder, domain, index, place as usize);
            format!("{:?}", built.map(|cell| cell.polyhedron().clone()))
        });
        cells.collect()
    }

    #[test]
    fn however_the_index_lies_cells_are_cut_alike() {
        // Every vertex of a lattice is shared by eight cells, and each site has equally far others.
        let at = |n: usize| (n as f64 + 0.5) / 5.0;
        let sites: Vec<_> = (0..125)
            .map(|n| Point3::new(at(n % 5), at(n / 5 % 5), at(n / 25)))
            .collect();
        let bounds = Bounds::of(&[Point3::origin(), Point3::new(1.0, 1.0, 1.0)]);
        for axes in [[false; 3], [true, false, true]] {
            let domain = Cuboid::new(bounds, axes).expect("a box");
            let index =
                |sites: &[Point3<f64>]| SiteIndex::new(sites.par_iter().copied(), domain.periods());
            let fresh = index(&sites);
            // One that was made for the sites in other places.
            let turned: Vec<_> = sites
                .iter()
                .map(|p| Point3::new(p.y, 1.0 - p.z, p.x))
                .collect();
            let mut refitted = index(&turned);
            let now = refitted.sites().iter().map(|&site| sites[site as usize]);
            let now = now.collect();
            refitted.refit(now);
            assert_ne!(fresh.sites(), refitted.sites());
            assert!(cells(&domain, &fresh) == cells(&domain, &refitted));
        }
    }
}
