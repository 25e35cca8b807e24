//! The overlap of facets of two L∞ cells in one plane, without rounding.
//!
//! In a plane of the grid, by two of its coordinates u and v, all edges run along u, along v, or by as much in
//! one as in the other. Between the places u at which edges begin, end or cross, a facet is a few trapezoids.

use crate::complex::grid_facets::{Coverage, PlaneKey, normal_of};
use crate::complex::grid_lines::Place;

/// A place in a plane, by two of its coordinates.
type FlatPlace = [i64; 2];

/// An edge by its place at both ends in the order of u, and whether it runs that way (1) or back (−1).
#[derive(Clone, Copy, Debug)]
struct FlatEdge {
    ends: [FlatPlace; 2],
    turn: i32,
    facet: usize,
}

/// A plane's coordinates u and v as axes of space.
#[derive(Clone, Copy, Debug)]
struct FlatAxes {
    plane: PlaneKey,
    along: [usize; 2],
    /// The axis that the plane gives.
    across: usize,
}

/// The edges of what two facets in a plane cover from opposite sides, as the first has them: of the parts that it
/// covers one way and those that it covers the other way. None if edges lie beside the grid.
pub(crate) fn overlap(plane: PlaneKey, facets: [&[[Place; 2]]; 2]) -> Option<[Vec<[Place; 2]>; 2]> {
    let axes = FlatAxes::of(plane);
    let flat = |(facet, edges)| axes.flat_edges(facet, edges);
    let edges: Vec<FlatEdge> = (0..).zip(facets).flat_map(flat).collect();
    let mut covered = [Coverage::default(), Coverage::default()];
    let mut spanning = Vec::new();
    for pair in breaks(&edges)?.windows(2) {
        let [start, end] = [pair[0], pair[1]];
        let spans = |edge: &&FlatEdge| edge.ends[0][0] <= start && end <= edge.ends[1][0];
        spanning.clear();
        spanning.extend(edges.iter().filter(spans).map(|edge| {
            let heights = [start, end].map(|u| edge.height(u));
            (heights[0] + heights[1], heights, edge)
        }));
        spanning.sort_by_key(|(middle, ..)| *middle);
        let mut times = [0; 2];
        for edges in spanning.windows(2) {
            let ((_, low, edge), (_, high, _)) = (edges[0], edges[1]);
            times[edge.facet] += edge.turn;
            if low == high || times[0] * times[1] != -1 {
                continue;
            }
            let corners = [
                [start, low[0]],
                [end, low[1]],
                [end, high[1]],
                [start, high[0]],
            ];
            let corners = corners.map(|at| axes.in_space(at));
            let covered = &mut covered[usize::from(times[0] < 0)];
            for (number, &from) in corners.iter().enumerate() {
                covered.add(&[from, corners[(number + 1) % 4]], times[0])?;
            }
        }
    }
    let [one, other] = covered.each_ref().map(Coverage::edges);
    Some([one?, other?])
}

/// The places u at which edges begin, end or cross; none if they cross beside the grid.
fn breaks(edges: &[FlatEdge]) -> Option<Vec<i64>> {
    let ends = edges.iter().flat_map(|edge| edge.ends.map(|end| end[0]));
    let mut breaks: Vec<i64> = ends.collect();
    for (number, one) in edges.iter().enumerate() {
        for other in &edges[number + 1..] {
            let slope = one.slope() - other.slope();
            let start = one.ends[0][0].max(other.ends[0][0]);
            let end = one.ends[1][0].min(other.ends[1][0]);
            if slope == 0 || start >= end {
                continue;
            }
            // One is above the other by so much at the start.
            let above = one.height(start) - other.height(start);
            let further = -above * slope.signum();
            if further <= 0 || further >= (end - start) * slope.abs() {
                continue;
            }
            if further % slope.abs() != 0 {
                return None;
            }
            breaks.push(start + further / slope.abs());
        }
    }
    breaks.sort_unstable();
    breaks.dedup();
    Some(breaks)
}

impl FlatEdge {
    /// How v changes with u.
    fn slope(&self) -> i64 {
        (self.ends[1][1] - self.ends[0][1]).signum()
    }

    fn height(&self, u: i64) -> i64 {
        self.ends[0][1] + self.slope() * (u - self.ends[0][0])
    }
}

impl FlatAxes {
    fn of(plane: PlaneKey) -> Self {
        let normal = normal_of(plane);
        let across = normal.iter().position(|part| *part != 0).unwrap_or(0);
        let along = [(across + 1) % 3, (across + 2) % 3];
        Self {
            plane,
            along,
            across,
        }
    }

    fn in_space(&self, at: FlatPlace) -> Place {
        let normal = normal_of(self.plane);
        let mut place = [0; 3];
        for (axis, at) in self.along.into_iter().zip(at) {
            place[axis] = at;
        }
        let beside: i64 = (0..3).map(|axis| normal[axis] * place[axis]).sum();
        place[self.across] = normal[self.across] * (self.plane.1 - beside);
        place
    }

    /// The edges of a facet but those along v.
    fn flat_edges(self, facet: usize, edges: &[[Place; 2]]) -> impl Iterator<Item = FlatEdge> {
        let flat = move |at: &Place| self.along.map(|axis| at[axis]);
        let edges = edges.iter().map(move |edge| edge.each_ref().map(flat));
        let edges = edges.filter(|[from, to]| from[0] != to[0]);
        edges.map(move |[from, to]| FlatEdge {
            ends: if from[0] < to[0] {
                [from, to]
            } else {
                [to, from]
            },
            turn: if from[0] < to[0] { 1 } else { -1 },
            facet,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The edges of a polygon in the plane z = 5.
    fn polygon(corners: &[[i64; 2]]) -> Vec<[Place; 2]> {
        let next = corners.iter().cycle().skip(1);
        let place = |at: &[i64; 2]| [at[0], at[1], 5];
        (corners.iter().zip(next))
            .map(|(from, to)| [place(from), place(to)])
            .collect()
    }

    #[test]
    fn facets_overlap_from_opposite_sides_only() {
        let plane = (2, 5);
        let square = polygon(&[[0, 0], [8, 0], [8, 8], [0, 8]]);
        let diamond = polygon(&[[8, 12], [16, 4], [8, -4], [0, 4]]);
        let [found, none] = overlap(plane, [&square, &diamond]).unwrap();
        assert!(none.is_empty());
        let mut rest = Coverage::default();
        let expected = polygon(&[[4, 0], [8, 0], [8, 8], [4, 8], [0, 4]]);
        found.iter().for_each(|edge| rest.add(edge, 1).unwrap());
        expected.iter().for_each(|edge| rest.add(edge, -1).unwrap());
        assert!(rest.edges().unwrap().is_empty());
        let turned: Vec<_> = diamond.iter().map(|&[from, to]| [to, from]).collect();
        assert_eq!(overlap(plane, [&square, &turned]), Some([vec![], vec![]]));
    }

    #[test]
    fn facets_that_cover_both_ways_are_told_apart() {
        let mut both = polygon(&[[0, 0], [4, 0], [4, 4], [0, 4]]);
        both.extend(polygon(&[[4, 4], [4, 8], [8, 8], [8, 4]]));
        let other: Vec<_> = both.iter().map(|&[from, to]| [to, from]).collect();
        let [one, two] = overlap((2, 5), [&both, &other]).unwrap();
        assert_eq!((one.len(), two.len()), (4, 4));
    }
}
