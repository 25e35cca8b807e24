//! The Chebyshev energy of a solid given by convex plane fragments of its boundary, about any center.
//!
//! The solid need not be convex, nor its fragments match along their edges. Every fragment is cut into
//! the sectors of its points; fanned, each part spans tetrahedra with the center on which the distance is
//! linear, with a sign where the fragment is seen from behind (\[BL\] eq. 6). The Hessian has besides the
//! integrals over interfaces between sectors, A w wᵀ/√2 for p = 1, w the difference of both directions
//! (\[BL\] eq. 7): an edge of a part along an interface spans a triangle of it with the center.

use nalgebra::{Matrix3, Vector3};

use crate::arrays::MapEach;
use crate::integrals::simplex::linear_power;
use crate::minimize::problem::Evaluation;

/// A solid given by fragments of its boundary.
#[derive(Clone, Debug, Default)]
pub(crate) struct FacetedSolid {
    corners: Vec<Vector3<f64>>,
    /// Where the corners of every fragment end.
    ends: Vec<usize>,
    part: Vec<PartCorner>,
    spare: Vec<PartCorner>,
}

/// The direction in which the distance is measured: an axis and a sign.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Direction {
    axis: usize,
    sign: f64,
}

/// A corner of a part of a fragment in one sector, relative to the center.
#[derive(Clone, Copy, Debug)]
struct PartCorner {
    at: Vector3<f64>,
    /// The sector beyond the edge to the next corner, where that lies on an interface.
    beyond: Option<Direction>,
}

impl Direction {
    fn all() -> [Self; 6] {
        std::array::from_fn(|number| Self {
            axis: number / 2,
            sign: if number % 2 == 0 { 1.0 } else { -1.0 },
        })
    }

    #[inline]
    fn distance(self, at: &Vector3<f64>) -> f64 {
        self.sign * at[self.axis]
    }

    fn vector(self) -> Vector3<f64> {
        Vector3::ith(self.axis, self.sign)
    }
}

impl FacetedSolid {
    /// Becomes the solid without fragments, keeping its memory.
    pub(crate) fn clear(&mut self) {
        self.corners.clear();
        self.ends.clear();
    }

    /// Adds a convex fragment, its corners counter-clockwise from outside.
    pub(crate) fn push(&mut self, corners: &[Vector3<f64>]) {
        self.corners.extend_from_slice(corners);
        self.ends.push(self.corners.len());
    }

    /// Energy (L^(3+p)), gradient (L^(2+p)) and Hessian (L^(1+p)) about `center`. `order` is p ≥ 1.
    pub(crate) fn energy(&mut self, center: &Vector3<f64>, order: u32) -> Evaluation<3> {
        let mut total = Evaluation {
            value: 0.0,
            gradient: Vector3::zeros(),
            hessian: Matrix3::zeros(),
        };
        let (mut part, mut spare) = (
            std::mem::take(&mut self.part),
            std::mem::take(&mut self.spare),
        );
        let mut first = 0;
        for &end in &self.ends {
            let fragment = &self.corners[first..end];
            first = end;
            for direction in Direction::all() {
                part.clear();
                part.extend(fragment.iter().map(|corner| PartCorner {
                    at: corner - center,
                    beyond: None,
                }));
                if is_in_sector(&mut part, &mut spare, direction) {
                    add_part(&mut total, &part, direction, order);
                }
            }
        }
        (self.part, self.spare) = (part, spare);
        total
    }
}

/// Cuts a part to a sector; says whether anything is left.
fn is_in_sector(
    part: &mut Vec<PartCorner>,
    spare: &mut Vec<PartCorner>,
    direction: Direction,
) -> bool {
    for other in Direction::all() {
        if other.axis != direction.axis {
            cut(part, spare, direction, other);
            if part.len() < 3 {
                return false;
            }
        }
    }
    true
}

/// Cuts a part to where `direction` measures no less than `other`.
fn cut(
    part: &mut Vec<PartCorner>,
    spare: &mut Vec<PartCorner>,
    direction: Direction,
    other: Direction,
) {
    let excess = |at: &Vector3<f64>| direction.distance(at) - other.distance(at);
    if part.iter().all(|corner| excess(&corner.at) > 0.0) {
        return;
    }
    spare.clear();
    for (number, corner) in part.iter().enumerate() {
        let next = &part[if number + 1 == part.len() {
            0
        } else {
            number + 1
        }];
        let (here, there) = (excess(&corner.at), excess(&next.at));
        let on_interface = PartCorner {
            beyond: Some(other),
            ..*corner
        };
        if here >= 0.0 {
            let leaves_along = here <= 0.0 && there <= 0.0;
            spare.push(if leaves_along { on_interface } else { *corner });
        }
        if here > 0.0 && there < 0.0 {
            let at = corner.at + (next.at - corner.at) * (here / (here - there));
            spare.push(PartCorner { at, ..on_interface });
        } else if here < 0.0 && there > 0.0 {
            let at = next.at + (corner.at - next.at) * (there / (there - here));
            spare.push(PartCorner { at, ..*corner });
        }
    }
    std::mem::swap(part, spare);
}

/// Adds the tetrahedra and the triangles on interfaces that a part spans with the center.
fn add_part(total: &mut Evaluation<3>, part: &[PartCorner], direction: Direction, order: u32) {
    let (toward, p) = (direction.vector(), f64::from(order));
    let first = &part[0].at;
    for pair in part[1..].windows(2) {
        let [a, b] = [&pair[0].at, &pair[1].at];
        let volume = first.dot(&a.cross(b)) / 6.0;
        let distances = [first, a, b].map_each(|at| direction.distance(at));
        let values = [0.0, distances[0], distances[1], distances[2]];
        total.value += linear_power(volume, &values, order);
        total.gradient -= toward * (p * linear_power(volume, &values, order - 1));
        if order > 1 {
            let weight = p * (p - 1.0) * linear_power(volume, &values, order - 2);
            total.hessian[(direction.axis, direction.axis)] += weight;
        }
    }
    for (number, corner) in part.iter().enumerate() {
        let Some(beyond) = corner.beyond else {
            continue;
        };
        let next = &part[if number + 1 == part.len() {
            0
        } else {
            number + 1
        }];
        let across = toward - beyond.vector();
        // Its area over √2. Both sectors count it, half each.
        let share = corner.at.cross(&next.at).dot(&across) / 8.0;
        let distances = [&corner.at, &next.at].map_each(|at| direction.distance(at));
        let weight = p * linear_power(share, &[0.0, distances[0], distances[1]], order - 1);
        total.hessian += across * across.transpose() * weight;
    }
}
