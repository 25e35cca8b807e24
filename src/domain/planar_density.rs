//! Densities over domains of the plane: polynomials in x and y.
//!
//! Signs and the integral of a power, which the asymptotic optimum takes, are found over prisms of height 1
//! above the domain's convex pieces by what does the same in space.

use std::sync::OnceLock;

use nalgebra::{Point2, Point3, Vector2, Vector3};

use crate::arrays::MapEach;
use crate::domain::convex::ConvexPolyhedron;
use crate::domain::density_power::{PowerIntegral, over_regions};
use crate::domain::density_region::DensityRegion;
use crate::domain::density_sign::refused_place;
use crate::domain::planar_error::PlaneDomainError;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polygon::ConvexPolygon;
use crate::integrals::bernstein::Bernstein;
use crate::integrals::planar::{over_polygon, plane_terms};
use crate::integrals::polynomial::Polynomial;

/// The power of the density whose integral gives the least energy of order 1 in the plane: D/(D+p).
const OPTIMUM: f64 = 2.0 / 3.0;

/// Sides of pieces shorter than this share of the domain's extent have no direction.
const NO_SIDE: f64 = 1e-12;

/// A positive density over a domain of the plane.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlaneDensity {
    polynomial: Polynomial,
    pieces: Vec<ConvexPolygon>,
    bounds: Bounds<2>,
    mean: f64,
    greatest: f64,
    /// On first use: of ρ^[`OPTIMUM`], and its error.
    power: OnceLock<[f64; 2]>,
}

impl PlaneDensity {
    /// `polynomial` over the convex `pieces` of a domain within `bounds`, repeated by `periods`.
    pub(crate) fn new(
        pieces: &[ConvexPolygon],
        bounds: Bounds<2>,
        periods: [Option<f64>; 2],
        polynomial: &Polynomial,
    ) -> Result<Self, PlaneDomainError> {
        let middle = bounds.center();
        refuse_axes(&polynomial.relative_to(&in_space(&middle)), periods)?;
        pieces
            .iter()
            .try_for_each(|piece| refuse_signs(piece, &bounds, polynomial))?;
        let terms = plane_terms(&polynomial.relative_to(&in_space(&middle)));
        let about = pieces.iter().map(|piece| piece.translated(&-middle.coords));
        let mass: f64 = about
            .map(|piece| over_polygon(&piece, &terms, [[0, 0]])[0])
            .sum();
        let area: f64 = pieces.iter().map(ConvexPolygon::area).sum();
        let mean = mass / area;
        if !(mean.is_normal() && mean > 0.0) {
            let (value, x, y) = (mean, middle.x, middle.y);
            return Err(PlaneDomainError::Density { value, x, y });
        }
        let flat = Bounds {
            min: in_space(&bounds.min),
            max: in_space(&bounds.max),
        };
        Ok(Self {
            greatest: Bernstein::new(polynomial, &flat).range()[1],
            polynomial: polynomial.clone(),
            pieces: pieces.to_vec(),
            bounds,
            mean,
            power: OnceLock::new(),
        })
    }

    /// The density as a polynomial in y − `origin`.
    pub(crate) fn about(&self, origin: &Point2<f64>) -> Polynomial {
        self.polynomial.relative_to(&in_space(origin))
    }

    /// The mean over the domain.
    pub(crate) fn mean(&self) -> f64 {
        self.mean
    }

    /// No less than the density anywhere in the domain.
    pub(crate) fn upper_bound(&self) -> f64 {
        self.greatest
    }

    /// ∫ (ρ/mean)^⅔ over the domain (L²) and an estimate of the error.
    pub(crate) fn optimal_area(&self) -> PowerIntegral {
        let [value, error] = *self.power.get_or_init(|| {
            let region = [DensityRegion::everywhere(self.polynomial.clone())];
            let prisms = self.pieces.iter();
            let prisms = prisms.filter_map(|piece| prism(piece, &self.bounds));
            let all = prisms.map(|prism| over_regions(&prism, &region, OPTIMUM));
            all.fold([0.0; 2], |[value, error], part| {
                [value + part.value, error + part.error]
            })
        });
        let unit = self.mean.powf(-OPTIMUM) / height(&self.bounds);
        PowerIntegral {
            value: value * unit,
            error: error * unit,
        }
    }
}

fn in_space(point: &Point2<f64>) -> Point3<f64> {
    Point3::new(point.x, point.y, 0.0)
}

/// The height of all prisms (L).
fn height(bounds: &Bounds<2>) -> f64 {
    bounds.extent().amax()
}

/// Refuses terms in z and along periodic axes.
fn refuse_axes(polynomial: &Polynomial, periods: [Option<f64>; 2]) -> Result<(), PlaneDomainError> {
    let changes = |axis: usize| {
        let mut terms = polynomial.terms();
        terms.any(|(powers, value)| powers[axis] > 0 && value.abs() > 0.0)
    };
    if changes(2) {
        return Err(PlaneDomainError::DensityOfZ);
    }
    match (0..2).find(|&axis| periods[axis].is_some() && changes(axis)) {
        Some(axis) => Err(PlaneDomainError::DensityAlongPeriod { axis }),
        None => Ok(()),
    }
}

/// Refuses a density that is negative somewhere in a piece.
fn refuse_signs(
    piece: &ConvexPolygon,
    bounds: &Bounds<2>,
    polynomial: &Polynomial,
) -> Result<(), PlaneDomainError> {
    let refused = prism(piece, bounds).and_then(|prism| refused_place(&prism, polynomial));
    match refused {
        Some((place, value)) => Err(PlaneDomainError::Density {
            value,
            x: place.x,
            y: place.y,
        }),
        None => Ok(()),
    }
}

/// The prism about z = 0 above a convex piece; none for a piece that is no more than rounding.
fn prism(piece: &ConvexPolygon, bounds: &Bounds<2>) -> Option<ConvexPolyhedron> {
    let height = height(bounds);
    let edges = piece.edges();
    let sides = edges.filter(|edge| edge.length() > NO_SIDE * height);
    let side = sides.map(|edge| {
        let along: Vector2<f64> = (edge.end - edge.start).normalize();
        HalfSpace {
            normal: Vector3::new(along.y, -along.x, 0.0),
            offset: along.y * edge.start.x - along.x * edge.start.y,
        }
    });
    let ends = [1.0, -1.0].map_each(|sign| HalfSpace {
        normal: Vector3::z() * sign,
        offset: 0.5 * height,
    });
    let half_spaces: Vec<HalfSpace> = side.chain(ends).collect();
    ConvexPolyhedron::new(&half_spaces).ok()
}
