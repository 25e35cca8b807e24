//! Conditions on a body's balance: ∫ d φ = w or ≥ w for polynomials φ of degree two at most.
//!
//! With an axis through o along the unit vector e, u and v across it, and z = e·(y − o): the center of mass
//! lies on the axis where ∫ d u = ∫ d v = 0, and the axis is then a principal one where ∫ d u z = ∫ d v z = 0
//! (shifts of z add multiples of the first two). It has the largest moment where ∫ d (t² − (z − h)²) ≥ 0 for
//! every unit vector t across it, h the height of the center.

use nalgebra::{Matrix3, Point3, Unit, Vector3};

use crate::arrays::MapEach;
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

    /// The same φ, measured from another point.
    pub(crate) fn seen_from(&self, about: &Point3<f64>) -> Self {
        let arm = about - self.about;
        Self {
            about: *about,
            constant: self.at(about),
            gradient: self.gradient + self.quadratic * arm * 2.0,
            ..self.clone()
        }
    }

    /// φ at a point.
    pub(crate) fn at(&self, point: &Point3<f64>) -> f64 {
        let arm = point - self.about;
        self.constant + self.gradient.dot(&arm) + arm.dot(&(self.quadratic * arm))
    }

    /// φ as a polynomial of the coordinates, as text.
    pub(crate) fn text(&self) -> String {
        let mut text = format!("{}", self.constant);
        let mut add = |factor: f64, names: &[usize]| {
            if factor != 0.0 {
                let sign = if factor < 0.0 { '-' } else { '+' };
                let names: Vec<_> = names.iter().map(|&axis| self.centered(axis)).collect();
                text += &format!(" {sign} {}*{}", factor.abs(), names.join("*"));
            }
        };
        for axis in 0..3 {
            add(self.gradient[axis], &[axis]);
        }
        for (one, other) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
            let twice = if one == other { 1.0 } else { 2.0 };
            add(twice * self.quadratic[(one, other)], &[one, other]);
        }
        text
    }

    /// A coordinate from where φ is centered, as text.
    fn centered(&self, axis: usize) -> String {
        let name = ["x", "y", "z"][axis];
        match self.about[axis] {
            0.0 => name.to_owned(),
            middle if middle < 0.0 => format!("({name} + {})", -middle),
            middle => format!("({name} - {middle})"),
        }
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

    /// How far along the line `point` lies from `through`.
    pub(crate) fn height(&self, point: &Point3<f64>) -> f64 {
        (point - self.through).dot(&self.along)
    }

    /// The point of the line at a height.
    pub(crate) fn at(&self, height: f64) -> Point3<f64> {
        self.through + self.along.as_ref() * height
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
        self.across.map_each(|direction| {
            let product = direction * self.along.transpose();
            self.quadratic((product + product.transpose()) * 0.5)
        })
    }

    /// The moment of inertia about the line is `moment`.
    pub(crate) fn moment(&self, moment: f64) -> Condition {
        let [first, second] = self.across.map_each(|across| across * across.transpose());
        Condition {
            wanted: moment,
            ..self.quadratic(first + second)
        }
    }

    /// With the unit vectors t = cos α u + sin α v and w across it: the moment about the line exceeds that
    /// about the line along t through `through` by a `share` of it, ∫ d (t² + w² − (1 + share)(w² + z²)) ≥ 0.
    pub(crate) fn stable_against(&self, angle: f64, share: f64) -> Condition {
        let [u, v] = self.across;
        let (sine, cosine) = angle.sin_cos();
        let (t, w) = (u * cosine + v * sine, v * cosine - u * sine);
        let square = |vector: &Vector3<f64>| vector * vector.transpose();
        let about_t = square(&w) + square(self.along.as_ref());
        let about_line = square(&t) + square(&w);
        self.quadratic(about_line - about_t * (1.0 + share))
            .at_least()
    }

    fn quadratic(&self, quadratic: Matrix3<f64>) -> Condition {
        Condition {
            quadratic,
            ..Condition::affine(&self.through, 0.0, Vector3::zeros())
        }
    }
}
