//! Solids that are made to stand: the figures of `density.md` 1.3-1.5 and 5.3, and their properties.

use nalgebra::{DVector, Point2, Point3, Rotation3, Vector3};

use crate::balance::conditions::Condition;
use crate::balance::contrast::least_contrast;
use crate::balance::dual::{Balance, DensityRange};
use crate::balance::solid::SolidBalance;
use crate::balance::solve::{LeastVariance, SolveEnd, greatest_product, least_variance};
use crate::balance::stand::{StandGoal, StandPlan, Standing, stand};
use crate::balance::support::{Ground, Support, SupportError};
use crate::mesh::formats::read::read_surface;
use crate::mesh::shapes::{icosphere, unit_cube};
use crate::mesh::surface::SurfaceMesh;
use crate::tests::models::shared_model;

fn close(got: f64, expected: f64, tolerance: f64, what: &str) {
    let off = (got - expected).abs();
    assert!(
        off <= tolerance,
        "{what}: {got}, not {expected}: off by {off:e}"
    );
}

/// The center of mass lies at `target` along each of `axes`.
fn levels(target: [f64; 3], axes: &[Vector3<f64>]) -> Vec<Condition> {
    let target = Point3::from(target);
    let level = |axis: &Vector3<f64>| Condition::center_level(&target, &-axis);
    axes.iter().map(level).collect()
}

fn range(low: f64, high: f64, prefer: f64) -> DensityRange {
    DensityRange { low, high, prefer }
}

/// Gradient, mass, greatest density and center of a solution.
struct Found {
    gradient: Vector3<f64>,
    mass: f64,
    center: Point3<f64>,
    solution: LeastVariance,
}

fn solved(balance: &SolidBalance<'_>, range: &DensityRange) -> Found {
    let solution = least_variance(balance, range);
    assert_eq!(solution.end, SolveEnd::Met, "{solution:?}");
    let form = balance.combined(&solution.multipliers).less(-range.prefer);
    let moments = balance.clamped(&form, range);
    Found {
        gradient: form.gradient,
        mass: moments.mass,
        center: balance.middle + moments.center(),
        solution,
    }
}

#[test]
fn a_cube_needs_the_contrast_of_hand_calculation() {
    let cube = [unit_cube()];
    for (target, contrast) in [(1.0 / 3.0, 4.0), (0.25, 9.0), (0.1, 81.0), (0.5, 1.0)] {
        let balance = SolidBalance::new(&cube, &levels([target, 0.0, 0.0], &[Vector3::x()]));
        let least = least_contrast(&balance);
        close(1.0 + least.growth, contrast, 1e-13 * contrast, "x");
        if contrast > 1.0 {
            let plane = balance
                .combined(&least.multipliers)
                .plane_at(&balance.middle);
            let (point, normal) = plane.expect("it has a gradient");
            close(point.x, target, 1e-13, "plane");
            assert_eq!(normal, -Vector3::x());
        }
    }
    let target = [1.0 / 3.0, 1.0 / 3.0, 0.0];
    let balance = SolidBalance::new(&cube, &levels(target, &[Vector3::x(), Vector3::y()]));
    let least = least_contrast(&balance);
    close(1.0 + least.growth, 7.75, 1e-12, "x and y");
    let gradient = balance.combined(&least.multipliers).gradient.normalize();
    close(gradient.x, -0.5_f64.sqrt(), 1e-12, "normal");
    close(gradient.y, -0.5_f64.sqrt(), 1e-12, "normal");
    // Targets on the surface or outside: no density does it.
    for target in [0.0, -0.2, 1.0, 7.0] {
        let balance = SolidBalance::new(&cube, &levels([target, 0.0, 0.0], &[Vector3::x()]));
        assert_eq!(least_contrast(&balance).growth, f64::INFINITY, "{target}");
    }
}

#[test]
fn a_cube_has_the_least_variance_of_hand_calculation() {
    let cube = [unit_cube()];
    let at = |c: f64| SolidBalance::new(&cube, &levels([c, 0.0, 0.0], &[Vector3::x()]));
    let balance = at(1.0 / 3.0);
    // One-sided: slope 3 (½ − c)/c³ below x = c.
    let found = solved(&balance, &range(1.0, f64::INFINITY, 1.0));
    close(found.gradient.x, -13.5, 1e-12, "slope");
    close(found.mass, 1.75, 1e-13, "mass");
    close(found.center.x, 1.0 / 3.0, 1e-14, "center");
    let highest = 1.0 + 13.5 / 3.0;
    close(highest, 5.5, 1e-13, "highest");
    // Both bounds inactive: d = 1.5 − 1.5 x.
    let found = solved(&balance, &range(1e-9, f64::INFINITY, 1.0));
    close(found.gradient.x, -1.5, 1e-7, "slope");
    let found = solved(&balance, &range(-9.0, 9.0, 1.0));
    close(found.gradient.x, -1.5, 1e-13, "slope");
    close(found.mass, 0.75, 1e-13, "mass");
    let found = solved(&balance, &range(1.0, 4.5, 1.0));
    close(found.gradient.x, -16.039014932345435, 1e-10, "slope");
    close(found.mass, 1.78478535875368, 1e-10, "mass");
    assert!(found.solution.iterations() <= 7, "{:?}", found.solution.log);
}

/// Three spheres of diameter 1, each leaning over the one below.
fn spheres(lean: f64) -> Vec<SurfaceMesh> {
    let rise = (1.0 - lean * lean).sqrt();
    let sphere = |level: u32| {
        let mut mesh = icosphere(4);
        let level = f64::from(level);
        for vertex in &mut mesh.vertices {
            *vertex = Point3::from(vertex.coords * 0.5 + Vector3::new(lean, 0.0, rise) * level);
        }
        mesh
    };
    (0..3).map(sphere).collect()
}

#[test]
fn three_spheres_stand_over_the_lowest_ones_axis() {
    let solids = spheres(0.25);
    let over_axis = levels([0.0; 3], &[Vector3::x(), Vector3::y()]);
    let balance = SolidBalance::new(&solids, &over_axis);
    let least = least_contrast(&balance);
    let contrast = 1.0 + least.growth;
    close(contrast, 7.988676, 1e-6, "spheres");
    // The table of 1.3: iterations at 1.01, 1.2, 1.5 and 2 times the least contrast.
    for (factor, most) in [(1.01, 10), (1.2, 7), (1.5, 6), (2.0, 4)] {
        let found = solved(&balance, &range(1.0, factor * contrast, 1.0));
        let iterations = found.solution.iterations();
        assert!(iterations <= most + 1, "{factor}: {iterations}");
        assert!(found.center.x.abs() < 1e-13 && found.center.y.abs() < 1e-13);
    }
}

/// The 24-gon of the spheres' foot.
fn foot() -> Support {
    let corner = |k: u32| {
        let angle = f64::from(k) * std::f64::consts::PI / 12.0;
        Point2::new(0.15 * angle.cos(), 0.15 * angle.sin())
    };
    Support::hull((0..24).map(corner).collect()).expect("24 corners")
}

#[test]
fn three_spheres_stand_on_their_foot() {
    let solids = spheres(0.25);
    let body = SolidBalance::new(&solids, &[]);
    let vertices = solids.iter().flat_map(|mesh| &mesh.vertices);
    let mut ground = Ground::below(&Vector3::z(), vertices).expect("up has a length");
    ground.height = -0.5;
    for (degrees, contrast) in [(0.0_f64, 2.682214), (5.0, 5.809565)] {
        let tilt = degrees.to_radians().tan();
        let plan = plan(ground, foot(), 0.02, tilt);
        let standing = stand(&body, &plan).expect("it has a polygon");
        close(1.0 + standing.contrast.growth, contrast, 1e-6, "foot");
        let field = standing.field.expect("it is reachable");
        let iterations = field.solution.iterations();
        assert!((1..=9).contains(&iterations), "{iterations}");
        let moments = body.clamped(&field.form, &field.range);
        let center = body.middle + moments.center();
        let [_, steepest] = foot().slack(&ground, &center).expect("a polygon");
        assert!(steepest > tilt, "{steepest}");
    }
}

fn plan(ground: Ground, support: Support, margin: f64, tilt: f64) -> StandPlan {
    StandPlan {
        ground,
        support,
        margin,
        tilt,
        range: None,
        prefer: None,
        mass: None,
        goal: StandGoal::LeastVariance,
    }
}
