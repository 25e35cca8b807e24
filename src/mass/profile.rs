//! Densities that are piecewise linear along a direction (\[BL\] section 3.2 and Fig. 5: constant,
//! ramp, constant).
//!
//! The profile is linear between its break planes, so a tetrahedron cut at those planes has linear
//! density in every part and integrates exactly. Closed surfaces are cut through their signed
//! cones, of which the sum is the solid, whatever the planes.

use crate::geometry::moments::Moments;
use crate::integrals::mesh_moments::at_vertices;
use crate::integrals::pairwise::sum_by_halves;
use crate::mass::split::{Node, Side, split};
use nalgebra::{Point3, Vector3};

/// A density that depends on s = direction · y only: linear between breaks, constant before the
/// first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    direction: Vector3<f64>,
    breaks: Vec<[f64; 2]>,
}

/// Why breaks make no profile.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// There is none.
    #[error("a profile needs at least one break `position=density`")]
    Empty,
    /// A position or density that is not finite.
    #[error("break {number} of the profile is not finite")]
    NotFinite {
        /// One-based number of the break.
        number: usize,
    },
    /// Positions must ascend.
    #[error("break {number} of the profile is at {position}, not beyond the one before it")]
    Order {
        /// One-based number of the break.
        number: usize,
        /// Its position.
        position: f64,
    },
    /// The direction is zero or not finite.
    #[error("the profile's direction has no length")]
    Direction,
}

/// A corner of a piece: its place, measured from the origin of the sum, and its s.
#[derive(Clone, Copy, Debug)]
struct ProfileCorner {
    place: Point3<f64>,
    s: f64,
}

impl Profile {
    /// From a direction (any length; s is measured along it in units of L) and breaks
    /// (s, density) with s strictly ascending.
    ///
    /// # Errors
    ///
    /// What is wrong with the direction or with which break.
    pub fn new(direction: &Vector3<f64>, breaks: Vec<[f64; 2]>) -> Result<Self, ProfileError> {
        let finite = |value: &f64| value.is_finite();
        let unit = direction
            .try_normalize(0.0)
            .filter(|unit| unit.iter().all(finite));
        let direction = unit.ok_or(ProfileError::Direction)?;
        if breaks.is_empty() {
            return Err(ProfileError::Empty);
        }
        if let Some(place) = breaks.iter().position(|pair| !pair.iter().all(finite)) {
            return Err(ProfileError::NotFinite { number: place + 1 });
        }
        if let Some(place) = breaks.windows(2).position(|pair| pair[1][0] <= pair[0][0]) {
            return Err(ProfileError::Order {
                number: place + 2,
                position: breaks[place + 1][0],
            });
        }
        Ok(Self { direction, breaks })
    }

    /// The density at s = direction · y.
    #[must_use]
    pub fn at(&self, s: f64) -> f64 {
        let after = self.breaks.partition_point(|pair| pair[0] <= s);
        match (
            after.checked_sub(1).map(|before| self.breaks[before]),
            self.breaks.get(after),
        ) {
            (Some([s0, low]), Some([s1, high])) => low + (high - low) * ((s - s0) / (s1 - s0)),
            (Some([_, value]), None) | (None, Some(&[_, value])) => value,
            (None, None) => 0.0,
        }
    }

    /// s at a point.
    pub(crate) fn along(&self, point: &Point3<f64>) -> f64 {
        self.direction.dot(&point.coords)
    }

    /// The breaks (s, density), s ascending.
    pub(crate) fn breaks(&self) -> &[[f64; 2]] {
        &self.breaks
    }

    /// The density at a point.
    #[must_use]
    pub fn at_point(&self, point: &Point3<f64>) -> f64 {
        self.at(self.direction.dot(&point.coords))
    }

    /// The ten moments of the solid within a closed surface (`K` = 3) or of tetrahedra (`K` = 4),
    /// measured from `origin`.
    ///
    /// # Panics
    ///
    /// If a simplex names a vertex that is not there.
    #[must_use]
    pub fn moments<const K: usize>(
        &self,
        vertices: &[Point3<f64>],
        simplices: &[[u32; K]],
        origin: &Point3<f64>,
    ) -> Moments {
        let corner = |point: &Point3<f64>| ProfileCorner {
            place: Point3::from(point - origin),
            s: self.direction.dot(&point.coords),
        };
        sum_by_halves(simplices.len(), &|range| {
            let (mut places, mut densities, mut tets) = (Vec::new(), Vec::new(), Vec::new());
            for simplex in &simplices[range] {
                // A triangle stands for its cone from the origin.
                let mut tet = [corner(origin); 4];
                for (place, &vertex) in tet[4 - K..].iter_mut().zip(simplex) {
                    *place = corner(&vertices[vertex as usize]);
                }
                for piece in self.pieces(tet) {
                    tets.push([0, 1, 2, 3].map(|k| places.len() as u32 + k));
                    places.extend(piece.map(|corner| corner.place));
                    densities.extend(piece.map(|corner| self.at(corner.s)));
                }
            }
            at_vertices(&places, &tets, &densities, &Point3::origin())
        })
    }

    /// A tetrahedron cut at every break plane it straddles.
    fn pieces(&self, tet: [ProfileCorner; 4]) -> Vec<[ProfileCorner; 4]> {
        let mut pieces = vec![tet];
        for &[plane, _] in &self.breaks {
            let cut = |piece: [ProfileCorner; 4]| cut_at(piece, plane);
            pieces = pieces.into_iter().flat_map(cut).collect();
        }
        pieces
    }
}

/// The parts of a tetrahedron on the two sides of the plane s = `plane`.
fn cut_at(tet: [ProfileCorner; 4], plane: f64) -> Vec<[ProfileCorner; 4]> {
    let Some(parts) = split(tet.map(|corner| Side::of(corner.s - plane)), [0, 1, 2, 3]) else {
        return vec![tet];
    };
    let corner = |[i, j]: Node| {
        if i == j {
            return tet[i];
        }
        let (from, to) = (&tet[i], &tet[j]);
        let share = (plane - from.s) / (to.s - from.s);
        ProfileCorner {
            place: from.place + (to.place - from.place) * share,
            s: plane,
        }
    };
    parts.iter().map(|(_, nodes)| nodes.map(corner)).collect()
}
