//! Elements without a positive Jacobian mended by moving their points a little.
//!
//! A point of a bad element tries places around it, near ones first, and goes where its elements lack least
//! of being good, as little as that takes; points on walls and features stay there. Centers of parted
//! cells move before points on walls, and these before sites. Only points of bad elements do, but
//! where that does not help those around them make room: elements there are made better than good.

use std::collections::BTreeSet;

use nalgebra::{Point3, Vector3};

use crate::complex::dual::{DualAnchor, DualMesh};
use crate::complex::element_mesh::ElementMesh;
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::jacobian::least_jacobian;
use crate::complex::wall_projection::WallProjection;

/// The Jacobian of an element is bad below this share of the cube of its longest edge.
const BAD: f64 = 1e-5;

/// Bad elements are mended until their Jacobians are this share.
const GOOD: f64 = 1e-3;

/// How often all bad elements are visited.
const ROUNDS: usize = 40;

/// What elements around bad ones are to reach, one after the other, so that these have room. A cube has 0.19.
const ROOMY: [f64; 3] = [0.01, 0.03, 0.08];

/// How often the surroundings of bad elements are visited for each of these.
const ROOMY_ROUNDS: usize = 12;

/// Distances of tried places in lengths of the longest edge at a point.
const REACHES: [f64; 5] = [0.004, 0.012, 0.04, 0.1, 0.2];

/// Moves points of `mesh`, the first of which are anchored, until all elements are good or nothing helps.
/// Returns the elements whose Jacobian is not positive.
pub(crate) fn untangle(
    mesh: &mut ElementMesh,
    anchors: &[DualAnchor],
    walls: Option<&WallProjection>,
) -> Vec<usize> {
    let mut at_point: Vec<Vec<u32>> = vec![Vec::new(); mesh.points.len()];
    for (number, element) in (0..).zip(&mesh.elements) {
        for &point in element.corners() {
            at_point[point as usize].push(number);
        }
    }
    let mut untangling = Untangling {
        mesh,
        anchors,
        walls,
        at_point,
        target: 0.0,
    };
    untangling.rounds(ROUNDS, false);
    for target in ROOMY {
        if untangling.below(0.0).is_empty() {
            break;
        }
        untangling.target = target;
        untangling.rounds(ROOMY_ROUNDS, true);
    }
    untangling.below(0.0)
}

/// What elements lack: of being good, in sum, and the squares of what they lack of the target.
#[derive(Clone, Copy)]
struct Lack {
    of_good: f64,
    of_target: f64,
}

impl Lack {
    /// Less of the first beyond rounding, or as much and less of the second.
    fn is_below(self, other: Self) -> bool {
        let is_less = self.of_good < other.of_good - 1e-15;
        is_less || (self.of_good <= other.of_good && self.of_target < other.of_target)
    }
}

struct Untangling<'a> {
    mesh: &'a mut ElementMesh,
    anchors: &'a [DualAnchor],
    walls: Option<&'a WallProjection>,
    /// The elements at every point.
    at_point: Vec<Vec<u32>>,
    /// The quality that elements around bad ones are to reach.
    target: f64,
}

impl Untangling<'_> {
    /// At most `count` rounds over bad elements, or over their surroundings too.
    fn rounds(&mut self, count: usize, is_wide: bool) {
        for _ in 0..count {
            if !self.round(is_wide) {
                break;
            }
        }
    }

    fn longest(&self, element: usize) -> f64 {
        let corners = self.mesh.elements[element].corners();
        let place = |corner: u32| self.mesh.points[corner as usize];
        let to = |from: u32| {
            corners
                .iter()
                .map(move |&to| (place(to) - place(from)).norm_squared())
        };
        let all = corners.iter().flat_map(|&from| to(from));
        all.fold(0.0, f64::max).sqrt()
    }

    fn quality(&self, element: usize) -> f64 {
        let least = least_jacobian(&self.mesh.points, &self.mesh.elements[element]);
        least / self.longest(element).powi(3).max(1e-300)
    }

    /// The elements of no more than a quality.
    fn below(&self, least: f64) -> Vec<usize> {
        let all = 0..self.mesh.elements.len();
        all.filter(|&element| self.quality(element) <= least)
            .collect()
    }

    /// What the elements at a point lack.
    fn lack(&self, point: u32) -> Lack {
        let (mut of_good, mut of_target) = (0.0, 0.0);
        for &element in &self.at_point[point as usize] {
            let quality = self.quality(element as usize);
            of_good += (GOOD - quality).max(0.0);
            of_target += (self.target - quality).max(0.0).powi(2);
        }
        Lack { of_good, of_target }
    }

    /// The points of some elements.
    fn points_of(&self, elements: impl IntoIterator<Item = usize>) -> Vec<u32> {
        let elements = elements.into_iter();
        elements
            .flat_map(|element| self.mesh.elements[element].corners().to_vec())
            .collect()
    }

    /// Moves the points of bad elements, or of those around them too; whether one moved.
    fn round(&mut self, is_wide: bool) -> bool {
        let mut points = self.points_of(self.below(BAD));
        if is_wide {
            let around = points.iter().flat_map(|&at| &self.at_point[at as usize]);
            let around: BTreeSet<usize> = around.map(|&element| element as usize).collect();
            points = self.points_of(around);
        }
        points.sort_unstable_by_key(|&point| (self.rank(point), point));
        points.dedup();
        let mut has_moved = false;
        for point in points {
            has_moved |= self.improve(point);
        }
        has_moved
    }

    /// Which points move first.
    fn rank(&self, point: u32) -> u8 {
        match self.anchors.get(point as usize) {
            None => 0,
            Some(DualAnchor::Site) => 2,
            Some(_) => 1,
        }
    }

    /// Moves a point to the best of the places around it; whether it is better there.
    fn improve(&mut self, point: u32) -> bool {
        let from = self.mesh.points[point as usize];
        let first = self.lack(point);
        let elements = self.at_point[point as usize].iter();
        let size = elements
            .map(|&element| self.longest(element as usize))
            .fold(0.0, f64::max);
        let mut best = (first, from);
        for reach in REACHES {
            if best.0.of_good <= 0.0 && best.0.of_target <= 0.0 {
                break;
            }
            for way in ways() {
                let Some(place) = self.placed(point, from + way * (reach * size)) else {
                    return false;
                };
                self.mesh.points[point as usize] = place;
                let lack = self.lack(point);
                if lack.is_below(best.0) {
                    best = (lack, place);
                }
            }
        }
        self.mesh.points[point as usize] = best.1;
        best.0.is_below(first)
    }

    /// The place nearest to `place` where a point may be; none if it may not move.
    fn placed(&self, point: u32, place: Point3<f64>) -> Option<Point3<f64>> {
        match self.anchors.get(point as usize) {
            None | Some(DualAnchor::Site) => Some(place),
            Some(DualAnchor::Wall(patch)) => self.walls?.nearest(&[*patch], &place),
            Some(DualAnchor::Feature(patches)) => self.walls?.nearest(patches, &place),
            Some(DualAnchor::Corner) => None,
        }
    }
}

/// Unit steps along axes and diagonals.
fn ways() -> impl Iterator<Item = Vector3<f64>> {
    let steps = [-1.0, 0.0, 1.0];
    let all = steps.into_iter().flat_map(move |x| {
        steps
            .into_iter()
            .flat_map(move |y| steps.into_iter().map(move |z| Vector3::new(x, y, z)))
    });
    all.filter_map(|way| way.try_normalize(0.5))
}

/// Moves points on walls and features to where these are.
pub(crate) fn project(points: &mut [Point3<f64>], anchors: &[DualAnchor], walls: &WallProjection) {
    for (place, anchor) in points.iter_mut().zip(anchors) {
        let nearest = match anchor {
            DualAnchor::Site | DualAnchor::Corner => None,
            DualAnchor::Wall(patch) => walls.nearest(&[*patch], place),
            DualAnchor::Feature(patches) => walls.nearest(patches, place),
        };
        *place = nearest.unwrap_or(*place);
    }
}

/// How far the middle of a small face between points of a curved surface sinks on average below it, of how
/// far it does in the middle: κh²/12 of κh²/8 for a square of side h and the sum κ of curvatures.
const MEAN_SAG: f64 = 2.0 / 3.0;

/// Moves points on curved walls out by the sag of the faces around them, so that these enclose the
/// volume of the solid rather than less.
pub(crate) fn balance(dual: &mut DualMesh, walls: &WallProjection) {
    let mesh = &dual.mesh;
    let geometry = MeshGeometry::of(mesh, &mesh.cell_faces());
    let mut sums = vec![(Vector3::zeros(), 0.0); mesh.points.len()];
    for (number, patch) in (0..).zip(&mesh.patches) {
        for face in patch.start..patch.start + patch.count {
            let center = geometry.face_centers[face];
            let Some(place) = walls.nearest(&[number], &center) else {
                continue;
            };
            let area = geometry.face_areas[face].norm();
            for &point in mesh.face(face) {
                let sum: &mut (Vector3<f64>, f64) = &mut sums[point as usize];
                sum.0 += (place - center) * area;
                sum.1 += area;
            }
        }
    }
    let points = dual.mesh.points.iter_mut().zip(&dual.anchors).zip(sums);
    for ((point, anchor), (gap, area)) in points {
        if matches!(anchor, DualAnchor::Wall(_)) && area > 0.0 {
            *point += gap * (MEAN_SAG / area);
        }
    }
}
