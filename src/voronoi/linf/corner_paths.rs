//! The ways of the corners of a cone's sections, from height to height.

use crate::arrays::MapEach;
use crate::voronoi::linf::block::{Column, Lasting, Line};
use crate::voronoi::linf::quadrant::Quadrant;
use crate::voronoi::linf::sweep::SweepVisitor;

/// A corner of a section: the lines along u and v on which it moves, and whether it counts with +1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SectionCorner {
    u: Line,
    v: Line,
    is_added: bool,
}

/// Passes the corners of a sweep's sections to a function, with both ends (h, u, v) of their ways and
/// whether they count with +1. Corners that two columns share cancel and are left out.
#[derive(Debug)]
pub(crate) struct CornerPathMaker<Visit> {
    lasting: Lasting<SectionCorner>,
    corners: Vec<SectionCorner>,
    visit: Visit,
}

impl<Visit: FnMut([[f64; 3]; 2], bool)> CornerPathMaker<Visit> {
    pub(crate) fn new(visit: Visit) -> Self {
        Self {
            lasting: Lasting::default(),
            corners: Vec::new(),
            visit,
        }
    }

    /// Adds the corners where two columns meet, or one ends.
    fn push_between(&mut self, [left, right]: [Option<&Column>; 2]) {
        for end in [0, 1] {
            let lines = [left, right].map_each(|column| column.map(|column| column.v[end]));
            if lines[0].is_some() && lines[0] == lines[1] {
                continue;
            }
            let columns = [(left, 1), (right, 0)];
            let corners = columns.into_iter().filter_map(|(column, side)| {
                column.map(|column| SectionCorner {
                    u: column.u[side],
                    v: column.v[end],
                    is_added: side == end,
                })
            });
            self.corners.extend(corners);
        }
    }
}

impl<Visit: FnMut([[f64; 3]; 2], bool)> SweepVisitor for CornerPathMaker<Visit> {
    const WANTS_COVERED: bool = false;

    fn columns(&mut self, columns: &[Column], height: f64) {
        self.corners.clear();
        let is_open = |column: &&Column| column.closing() > height;
        let open = |number: usize| columns.get(number).filter(is_open);
        for number in 0..=columns.len() {
            let left = number.checked_sub(1).and_then(open);
            self.push_between([left, open(number)]);
        }
        let visit = &mut self.visit;
        (self.lasting).turn(self.corners.iter().copied(), height, |corner, heights| {
            visit(
                heights.map_each(|height| [height, corner.u.at(height), corner.v.at(height)]),
                corner.is_added,
            );
        });
    }

    fn covered(&mut self, _: &[Column], _: f64, _: &Quadrant) {}
}
