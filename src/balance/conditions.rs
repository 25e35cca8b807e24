//! Conditions on a body's balance: ∫ d φ = w or ≥ w for polynomials φ of degree two at most.
//!
//! With an axis through o along the unit vector e, u and v across it, and z = e·(y − o): the center of mass
//! lies on the axis where ∫ d u = ∫ d v = 0, and the axis is then a principal one where ∫ d u z = ∫ d v z = 0
//! (shifts of z add multiples of the first two). It has the largest moment where ∫ d (w² − (z − h)²) ≥ 0 for
//! every unit vector w across it, h the height of the center.

use nalgebra::{Matrix3, Point3, Unit, Vector3};

use crate::balance::dual::Relation;
use crate::geometry::moments::Moments;

/// ∫ d φ = wanted, or ≥ wanted, of φ(y) = constant + gradient·r + r·(quadratic r), r = y − about.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Condition {
    /// What is asked.
    pub(crate) relation: Relation,
    /// The point from which φ measures, near the body.
    pub(crate) about: Point3<f64>,
    /// φ at `about`.
    pub(crate) constant: f64,
    /// φ's gradient there.
    pub(crate) gradient: Vector3<f64>,
    /// Half of φ's second derivatives, symmetric.
    pub(crate) quadratic: Matrix3<f64>,
    /// What ∫ d φ is compared with.
    pub(crate) wanted: f64,
}

impl Condition {
    /// ∫ d φ = 0 for φ = constant + gradient·(y − about).
    pub(crate) fn affine(about: &Point3<f64>, constant: f64, gradient: Vector3<f64>) -> Self {
        Self {
            relation: Relation::Equal,
            about: *about,
            constant,
            gradient,
            quadratic: Matrix3::zeros(),
            wanted: 0.0,
        }
    }

    /// The center of mass lies in the plane through `target` across `direction`.
    pub(crate) fn center_level(target: &Point3<f64>, direction: &Vector3<f64>) -> Self {
        Self::affine(target, 0.0, *direction)
    }

    /// The mass is `mass`.
    pub(crate) fn mass(mass: f64) -> Self {
        Self {
            wanted: mass,
            ..Self::affine(&Point3::origin(), 1.0, Vector3::zeros())
        }
    }

    /// The same φ, asked to have ∫ d φ ≥ wanted.
    pub(crate) fn at_least(self) -> Self {
        Self {
            relation: Relation::AtLeast,
            ..self
        }
    }

    /// The same condition, both sides times a positive `factor`.
    pub(crate) fn times(&self, factor: f64) -> Self {
        Self {
            constant: self.constant * factor,
            gradient: self.gradient * factor,
            quadratic: self.quadratic * factor,
            wanted: self.wanted * factor,
            ..self.clone()
        }
    }

    /// φ at a point.
    pub(crate) fn at(&self, point: &Point3<f64>) -> f64 {
        let arm = point - self.about;
        self.constant + self.gradient.dot(&arm) + arm.dot(&(self.quadratic * arm))
    }

    /// ∫ d φ of a body whose `moments` are measured from `origin`.
    pub(crate) fn of(&self, moments: &Moments, origin: &Point3<f64>) -> f64 {
        let here = moments.translated(&(origin - self.about));
        let quadratic = self.quadratic.component_mul(&here.second).sum();
        self.constant * here.mass + self.gradient.dot(&here.first) + quadratic
    }
}

/// A line in space, with two directions across it: a right-handed frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpinAxis {
    /// A point on it.
    pub(crate) through: Point3<f64>,
    /// Its direction.
    pub(crate) along: Unit<Vector3<f64>>,
    /// Unit vectors across it and across each other.
    pub(crate) across: [Vector3<f64>; 2],
}

impl SpinAxis {
    /// The line through a point along a direction; none if that has no length.
    pub(crate) fn new(through: &Point3<f64>, direction: &Vector3<f64>) -> Option<Self> {
        let largest = direction.amax();
        let along = Unit::try_new(direction / largest, 0.5)?;
        let helper = Vector3::ith(along.iamin(), 1.0);
        let first = helper.cross(&along).normalize();
        Some(Self {
            through: *through,
            along,
            across: [first, along.cross(&first)],
        })
    }

    /// The point of the line nearest to `point`.
    pub(crate) fn nearest(&self, point: &Point3<f64>) -> Point3<f64> {
        self.at(self.height(point))
    }

    /// How far along the line `point` lies from `through`.
    pub(crate) fn height(&self, point: &Point3<f64>) -> f64 {
        (point - self.through).dot(&self.along)
    }

    /// The point of the line at a height.
    pub(crate) fn at(&self, height: f64) -> Point3<f64> {
        self.through + self.along.as_ref() * height
    }

    /// The distance of `point` from the line.
    pub(crate) fn distance(&self, point: &Point3<f64>) -> f64 {
        let [first, second] = self.offsets(point);
        first.hypot(second)
    }

    /// How far `point` lies from the line along the two directions across it.
    pub(crate) fn offsets(&self, point: &Point3<f64>) -> [f64; 2] {
        self.across
            .map(|direction| direction.dot(&(point - self.through)))
    }

    /// The same line, with `through` moved to a height.
    pub(crate) fn moved_to(&self, height: f64) -> Self {
        Self {
            through: self.at(height),
            ..*self
        }
    }

    /// The center of mass lies on the line.
    pub(crate) fn center_on(&self) -> [Condition; 2] {
        self.across
            .map(|direction| Condition::center_level(&self.through, &direction))
    }

    /// The center of mass lies at this height.
    pub(crate) fn center_at(&self, height: f64) -> Condition {
        Condition::center_level(&self.at(height), &self.along)
    }

    /// The products of inertia with the line are zero: it is a principal axis if the center lies on it.
    pub(crate) fn principal(&self) -> [Condition; 2] {
        self.across.map(|direction| {
            let product = direction * self.along.transpose();
            self.quadratic((product + product.transpose()) * 0.5)
        })
    }

    /// The moment of inertia about the line is `moment`.
    pub(crate) fn moment(&self, moment: f64) -> Condition {
        let [first, second] = self.across.map(|across| across * across.transpose());
        Condition {
            wanted: moment,
            ..self.quadratic(first + second)
        }
    }

    /// ∫ d (w² − z²) ≥ 0 for the unit vector w = cos α u + sin α v: the moment about the line is no less
    /// than that about the axis across it and w through `through`.
    pub(crate) fn stable_against(&self, angle: f64) -> Condition {
        let [first, second] = self.across;
        let across = first * angle.cos() + second * angle.sin();
        let along = self.along.as_ref();
        self.quadratic(across * across.transpose() - along * along.transpose())
            .at_least()
    }

    fn quadratic(&self, quadratic: Matrix3<f64>) -> Condition {
        Condition {
            quadratic,
            ..Condition::affine(&self.through, 0.0, Vector3::zeros())
        }
    }
}
