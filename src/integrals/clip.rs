//! Triangles and their parts clipped by planes, for surface integrals over what remains.

use nalgebra::Vector3;

/// A triangle clipped by two planes has at most so many corners.
const MOST_CORNERS: usize = 5;

/// A convex polygon's part above a plane: its corners in order, and the edge that lies in the plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClippedPolygon {
    corners: [Vector3<f64>; MOST_CORNERS],
    count: usize,
    /// Where the boundary leaves what is above the plane and where it returns.
    pub(crate) edge: Option<[Vector3<f64>; 2]>,
}

impl ClippedPolygon {
    /// Clips a polygon of at most four corners by their heights above the plane.
    pub(crate) fn of(corners: &[Vector3<f64>], heights: &[f64]) -> Self {
        let mut part = Self {
            corners: [Vector3::zeros(); MOST_CORNERS],
            count: 0,
            edge: None,
        };
        let (mut leaves, mut returns) = (None, None);
        for from in 0..corners.len() {
            let to = (from + 1) % corners.len();
            let (is_above, next_is_above) = (heights[from] > 0.0, heights[to] > 0.0);
            if is_above {
                part.push(corners[from]);
            }
            if is_above != next_is_above {
                let (up, down) = if is_above { (from, to) } else { (to, from) };
                let place = crossing(corners, heights, up, down);
                part.push(place);
                *(if is_above { &mut leaves } else { &mut returns }) = Some(place);
            }
        }
        part.edge = leaves
            .zip(returns)
            .map(|(leaves, returns)| [leaves, returns]);
        part
    }

    fn push(&mut self, corner: Vector3<f64>) {
        self.corners[self.count] = corner;
        self.count += 1;
    }

    /// The corners of the part.
    pub(crate) fn corners(&self) -> &[Vector3<f64>] {
        &self.corners[..self.count]
    }

    /// The triangles of the part, from its first corner.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [Vector3<f64>; 3]> {
        let corners = self.corners;
        (2..self.count).map(move |k| [corners[0], corners[k - 1], corners[k]])
    }
}

/// Where the edge from a corner above to one not above passes the plane: the same bits for both polygons
/// that share the edge.
fn crossing(corners: &[Vector3<f64>], heights: &[f64], up: usize, down: usize) -> Vector3<f64> {
    let share = heights[up] / (heights[up] - heights[down]);
    corners[up] + (corners[down] - corners[up]) * share
}
