//! Mass properties of densities that have no closed integral, with estimates of their errors.
//!
//! Radial densities are summed over the surface to rounding; formulas over its signed cones, or over
//! tetrahedra, until the tolerance is reached.

use nalgebra::Point3;
use rayon::prelude::*;

use crate::geometry::bounds::Bounds;
use crate::geometry::moments::Moments;
use crate::integrals::adaptive::{
    AdaptiveIntegral, Estimate, Goal, MomentErrors, Signs, integrate,
};
use crate::integrals::cone_rule::{ConePiece, ConeRules};
use crate::integrals::expression::Expression;
use crate::integrals::mesh_moments::at_vertices;
use crate::integrals::radial::Radial;
use crate::mass::body::Body;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::surface_distance::SurfaceDistance;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::Solid;

/// The default tolerance of formulas.
pub(crate) const TOLERANCE: f64 = 1e-6;

/// The default tolerance of formulas of the distance to the surface, which has kinks.
pub(crate) const DISTANCE_TOLERANCE: f64 = 1e-4;

/// Sums over surfaces are refined to this.
const ROUNDING: f64 = 1e-13;

/// The most pieces, about 300 MB of them, beside those of the mesh.
const MOST_PIECES: usize = 1 << 20;

/// Why a formula has no integral.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum NumericError {
    /// A formula without a value.
    #[error(
        "the density is {value} at {position:?}; a formula must be a finite number everywhere in the \
         body's box (surfaces are integrated by cones from its middle; of tetrahedra, in those)"
    )]
    NotFinite {
        /// Its value.
        value: f64,
        /// Where.
        position: [f64; 3],
    },
}

/// Moments of a density with the bounds of their errors, measured from a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NumericMoments {
    pub(crate) moments: Moments,
    pub(crate) errors: MomentErrors,
    pub(crate) near: Point3<f64>,
    /// Where the tolerance was not reached.
    pub(crate) missed: Option<MissedTolerance>,
}

/// The budget of pieces ended before the tolerance was reached.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the integrals are known to {reached:.1e} only after {pieces} pieces, and the tolerance is \
     {tolerance:e}; give a larger --tolerance, or a smoother density"
)]
pub(crate) struct MissedTolerance {
    /// The relative error.
    reached: f64,
    /// The tolerance.
    tolerance: f64,
    /// How many pieces there were.
    pieces: usize,
}

/// Bounds of the errors of a body's mass properties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BodyErrors {
    /// Of the mass.
    pub(crate) mass: f64,
    /// Of the center of mass (L).
    pub(crate) center: f64,
    /// Of any entry of the inertia tensor about the center.
    pub(crate) inertia: f64,
    /// The largest of the three as shares of the mass, of the body's extent and of the tensor's largest
    /// entry.
    pub(crate) relative: f64,
}

impl BodyErrors {
    /// The same in other units, of which `length` and `mass` make one of the old.
    pub(crate) fn in_units(&self, length: f64, mass: f64) -> Self {
        Self {
            mass: self.mass * mass,
            center: self.center * length,
            inertia: self.inertia * (mass * length * length),
            ..*self
        }
    }

    /// Of moments measured from `near` that belong to `body`, in a box of diagonal `extent`.
    pub(crate) fn of(body: &Body, errors: &MomentErrors, near: &Point3<f64>, extent: f64) -> Self {
        let arm = (body.center_of_mass() - near).norm();
        let about = errors.moved(arm);
        // The true center is |∫d y| over the true mass away from the one found, the tensor about it less by the
        // product of both.
        let center = about.first / (body.mass - about.mass).max(0.0);
        let inertia = about.inertia + about.first * center;
        let shares = [
            about.mass / body.mass,
            center / extent,
            inertia / body.inertia_center().amax(),
        ];
        Self {
            mass: about.mass,
            center,
            inertia,
            relative: shares.into_iter().fold(0.0, f64::max),
        }
    }
}

/// The moments of a radial density.
pub(crate) fn radial_moments(solid: &Solid, density: &Radial) -> NumericMoments {
    let surface = boundary(solid);
    let (near, goal) = start(&surface.bounds(), ROUNDING, surface.triangles.len());
    let sum = density.moments(surface.all_corners(), &near, goal);
    numeric(&sum, near)
}

/// The moments of a formula, to `tolerance` or the default.
///
/// # Errors
/// When the formula has no value somewhere.
pub(crate) fn formula_moments(
    solid: &Solid,
    density: &Expression,
    tolerance: Option<f64>,
) -> Result<NumericMoments, NumericError> {
    let tolerance = tolerance.unwrap_or_else(|| default_tolerance(density));
    let (sum, near, pieces) = by_cones(solid, density, tolerance)?;
    let reached = sum.relative;
    let missed = (reached > tolerance || reached.is_nan()).then_some(MissedTolerance {
        reached,
        tolerance,
        pieces,
    });
    Ok(NumericMoments {
        missed,
        ..numeric(&sum, near)
    })
}

/// The moments of a formula sampled at the vertices of tetrahedra and linear in between (\[BL\] section
/// 3.3); the errors are those against the formula itself.
///
/// # Errors
/// When the formula has no value somewhere.
pub(crate) fn sampled_moments(
    solid: &Solid,
    mesh: &TetMesh,
    density: &Expression,
    values: &[f64],
) -> Result<NumericMoments, NumericError> {
    let (sum, near, _) = by_cones(solid, density, default_tolerance(density))?;
    let moments = at_vertices(&mesh.vertices, &mesh.tets, values, &near);
    let own = MomentErrors::between(&moments, &sum.estimate.moments);
    Ok(NumericMoments {
        moments,
        errors: own.plus(&sum.estimate.errors),
        near,
        missed: None,
    })
}

fn default_tolerance(density: &Expression) -> f64 {
    if density.uses_distance() {
        DISTANCE_TOLERANCE
    } else {
        TOLERANCE
    }
}

/// The distance to a surface has kinks at the places that have two nearest points.
fn signs(density: &Expression) -> Signs {
    if density.uses_distance() {
        Signs::Independent
    } else {
        Signs::Unknown
    }
}

/// A formula with the distance to a solid's surface, where it uses that.
#[derive(Clone, Debug)]
pub(crate) struct FormulaField {
    formula: Expression,
    distance: Option<SurfaceDistance>,
}

impl FormulaField {
    pub(crate) fn new(formula: &Expression, surface: impl FnOnce() -> SurfaceMesh) -> Self {
        let distance = (formula.uses_distance()).then(|| SurfaceDistance::new(&surface()));
        Self {
            formula: formula.clone(),
            distance,
        }
    }

    /// The value at a point; `hint` is a triangle that may be near.
    pub(crate) fn at(&self, point: &Point3<f64>, hint: &mut u32) -> f64 {
        let distance = self.distance.as_ref().map_or(0.0, |it| it.at(point, hint));
        self.formula.at(point, distance)
    }
}

/// The sum over cones, the point from which it is measured, and the most pieces.
fn by_cones(
    solid: &Solid,
    density: &Expression,
    tolerance: f64,
) -> Result<(AdaptiveIntegral, Point3<f64>, usize), NumericError> {
    let field = FormulaField::new(density, || boundary(solid));
    let (bounds, pieces) = cones(solid);
    let (near, smooth) = start(&bounds, tolerance, pieces.len());
    let goal = Goal {
        signs: signs(density),
        ..smooth
    };
    let rules = ConeRules::new();
    let estimate = |piece: &ConePiece| -> Estimate {
        let mut hint = first_hint(solid, piece);
        rules.estimate(piece, &near, |place| field.at(place, &mut hint))
    };
    let value = |place: &Point3<f64>| field.at(place, &mut 0);
    let sum = integrate(pieces, goal, &estimate);
    if sum.estimate.moments.mass.is_finite() {
        return Ok((sum, near, goal.most));
    }
    let (_, pieces) = cones(solid);
    let fault = pieces
        .par_iter()
        .find_map_first(|piece| rules.fault(piece, value));
    let (position, value) = fault.unwrap_or((near, f64::NAN));
    Err(NumericError::NotFinite {
        value,
        position: position.into(),
    })
}

/// The cones of a surface from the middle of its box, or tetrahedra as cones from their first corners.
fn cones(solid: &Solid) -> (Bounds<3>, Vec<ConePiece>) {
    match solid {
        Solid::Surface(closed, _) => {
            let bounds = closed.mesh().bounds();
            let triangles = closed.mesh().all_corners().zip(0..);
            let cone = |(corners, number)| ConePiece::new(bounds.center(), corners, number);
            (bounds, triangles.map(cone).collect())
        }
        Solid::Tets(sound, _) => {
            let tets = sound.mesh().all_corners().zip(0..);
            let cone = |([apex, a, b, c], number): ([Point3<f64>; 4], u32)| {
                ConePiece::new(apex, [a, b, c], number)
            };
            (sound.mesh().bounds(), tets.map(cone).collect())
        }
    }
}

/// A triangle near a piece: its own.
fn first_hint(solid: &Solid, piece: &ConePiece) -> u32 {
    match solid {
        Solid::Surface(..) => piece.number,
        Solid::Tets(..) => 0,
    }
}

/// The triangles that bound a solid.
pub(crate) fn boundary(solid: &Solid) -> SurfaceMesh {
    match solid {
        Solid::Surface(closed, _) => closed.mesh().clone(),
        Solid::Tets(sound, _) => sound.mesh().boundary(),
    }
}

/// The point from which sums are measured, and their goal.
fn start(bounds: &Bounds<3>, tolerance: f64, pieces: usize) -> (Point3<f64>, Goal) {
    let goal = Goal {
        tolerance,
        extent: bounds.extent().norm(),
        most: MOST_PIECES + 2 * pieces,
        signs: Signs::Unknown,
    };
    (bounds.center(), goal)
}

fn numeric(sum: &AdaptiveIntegral, near: Point3<f64>) -> NumericMoments {
    NumericMoments {
        moments: sum.estimate.moments,
        errors: sum.estimate.errors,
        near,
        missed: None,
    }
}
