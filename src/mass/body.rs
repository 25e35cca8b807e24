//! Mass, center of mass and inertia of a body, and of several combined.

use crate::geometry::moments::Moments;
use crate::mass::principal::Principal;
use nalgebra::{Matrix3, Point3, Vector3};

/// Mass properties of one solid or of several taken together.
///
/// The center of mass is kept as a point near the body and a short offset from it, and the second
/// moments about the center: adding a large coordinate to a small offset would round the offset,
/// and moving second moments far away and back would cancel them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// The volume (L³).
    pub volume: f64,
    /// The boundary's area (L²); of several parts the sum of theirs.
    pub surface_area: f64,
    /// The mass.
    pub mass: f64,
    /// A point near the body.
    near: Point3<f64>,
    /// The center of mass, from `near` (L).
    offset: Vector3<f64>,
    /// ∫ρ y yᵀ dV about the center of mass (mass · L²).
    second: Matrix3<f64>,
}

impl Body {
    /// From moments measured from `near`, which carry mass that is not zero.
    #[must_use]
    pub fn from_moments(
        volume: f64,
        surface_area: f64,
        moments: &Moments,
        near: &Point3<f64>,
    ) -> Self {
        let offset = moments.center();
        Self {
            volume,
            surface_area,
            mass: moments.mass,
            near: *near,
            offset,
            second: moments.second - offset * offset.transpose() * moments.mass,
        }
    }

    /// The same body with its densities scaled so that it weighs `mass`: a part of known mass
    /// instead of known density (\[M\] Problem 1).
    #[must_use]
    pub fn weighing(&self, mass: f64) -> Self {
        Self {
            mass,
            second: self.second * (mass / self.mass),
            ..*self
        }
    }

    /// The same body with a boundary of this area (L²): parts that touch have less than theirs together.
    #[must_use]
    pub(crate) fn with_surface_area(&self, surface_area: f64) -> Self {
        Self {
            surface_area,
            ..*self
        }
    }

    /// The same body in other units, of which `length` and `mass` make one of the old.
    #[must_use]
    pub(crate) fn in_units(&self, length: f64, mass: f64) -> Self {
        Self {
            volume: self.volume * length.powi(3),
            surface_area: self.surface_area * length * length,
            mass: self.mass * mass,
            near: self.near * length,
            offset: self.offset * length,
            second: self.second * (mass * length * length),
        }
    }

    /// Parts taken together (\[M\] eq. 5 and the transfer of axes, eq. 12-17); `None` of none or
    /// if the masses sum to zero. Parts that overlap count twice there.
    #[must_use]
    pub fn combined(parts: &[Self]) -> Option<Self> {
        let near = parts.first()?.near;
        let mass: f64 = parts.iter().map(|part| part.mass).sum();
        let offset_of = |part: &Self| (part.near - near) + part.offset;
        let first: Vector3<f64> = parts.iter().map(|part| offset_of(part) * part.mass).sum();
        let offset = first / mass;
        let second = parts.iter().fold(Matrix3::zeros(), |sum, part| {
            let arm = offset_of(part) - offset;
            sum + part.second + arm * arm.transpose() * part.mass
        });
        let body = Self {
            volume: parts.iter().map(|part| part.volume).sum(),
            surface_area: parts.iter().map(|part| part.surface_area).sum(),
            mass,
            near,
            offset,
            second,
        };
        offset.iter().all(|x| x.is_finite()).then_some(body)
    }

    /// The center of mass (L), \[M\] eq. 5.
    #[must_use]
    pub fn center_of_mass(&self) -> Point3<f64> {
        self.near + self.offset
    }

    /// The inertia tensor about the center of mass (mass · L²): \[M\] eq. 3, off-diagonals the
    /// negative products of inertia.
    #[must_use]
    pub fn inertia_center(&self) -> Matrix3<f64> {
        inertia_of(&self.second)
    }

    /// The inertia tensor about `point` (mass · L²), by the transfer of axes.
    #[must_use]
    pub fn inertia_about(&self, point: &Point3<f64>) -> Matrix3<f64> {
        let arm = (self.near - point) + self.offset;
        inertia_of(&(self.second + arm * arm.transpose() * self.mass))
    }

    /// The inertia tensor about the coordinates' origin (mass · L²).
    #[must_use]
    pub fn inertia_origin(&self) -> Matrix3<f64> {
        self.inertia_about(&Point3::origin())
    }

    /// The moment of inertia (mass · L²) about the axis through `point` along `direction`, whose
    /// length does not matter but must not be zero.
    #[must_use]
    pub fn moment_about_axis(&self, point: &Point3<f64>, direction: &Vector3<f64>) -> f64 {
        let unit = direction.normalize();
        unit.dot(&(self.inertia_about(point) * unit))
    }

    /// The body frame: principal moments about the center of mass, and their axes.
    #[must_use]
    pub fn principal(&self) -> Principal {
        Principal::of(&self.inertia_center())
    }
}

/// tr(S) − S: the inertia tensor of second moments S = ∫ρ y yᵀ dV.
fn inertia_of(second: &Matrix3<f64>) -> Matrix3<f64> {
    Moments {
        second: *second,
        ..Moments::default()
    }
    .inertia()
}
