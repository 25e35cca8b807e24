//! Fields with which solids spin, on cells, vertices and points.

use nalgebra::{DVector, Point3, Rotation3, Vector3};

use crate::balance::bases::{eighths, of_cells, of_vertices, points, tetrahedra};
use crate::balance::conditions::SpinAxis;
use crate::balance::dual::DensityRange;
use crate::balance::solve::SolveEnd;
use crate::balance::spin::{SpinBody, SpinSolution, SpinState, SpinWish};
use crate::domain::shape::DomainShape;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::moments::Moments;
use crate::integrals::mesh_moments::at_vertices;
use crate::mesh::tets::TetMesh;
use crate::voronoi::diagram::Diagram;

/// Corners of a grid of 5 × 4 × 3 cubes, sheared a little so that nothing is symmetric, each cube of six
/// tetrahedra.
fn block() -> TetMesh {
    let [nx, ny, nz] = [5_u32, 4, 3];
    let mut mesh = TetMesh::default();
    for z in 0..=nz {
        for y in 0..=ny {
            for x in 0..=nx {
                let [x, y, z] = [x, y, z].map(|at| 0.25 * f64::from(at));
                mesh.vertices
                    .push(Point3::new(x + 0.1 * z, y + 0.07 * x, z - 0.05 * y));
            }
        }
    }
    let at = |x: u32, y: u32, z: u32| (z * (ny + 1) + y) * (nx + 1) + x;
    for (z, y, x) in
        (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (z, y, x))))
    {
        let [a, g] = [at(x, y, z), at(x + 1, y + 1, z + 1)];
        let ring = [
            at(x + 1, y, z),
            at(x + 1, y + 1, z),
            at(x, y + 1, z),
            at(x, y + 1, z + 1),
            at(x, y, z + 1),
            at(x + 1, y, z + 1),
        ];
        for side in 0..6 {
            mesh.tets.push([a, ring[side], ring[(side + 1) % 6], g]);
        }
    }
    mesh
}

fn solid() -> SurfaceSolid {
    let surface = block().boundary();
    SurfaceSolid::from_arrays(&surface.vertices, &surface.triangles).expect("a block")
}

/// An axis off the center and askew.
fn axis() -> SpinAxis {
    let through = Point3::new(0.66, 0.5, 0.36);
    SpinAxis::new(&through, &Vector3::new(0.06, -0.05, 1.0)).expect("a direction")
}

fn wish(axis: SpinAxis) -> SpinWish {
    SpinWish {
        axis,
        principal: true,
        center_at: None,
        stable: None,
        moment: None,
        mass: None,
        gyration_squared: None,
    }
}

const RANGE: DensityRange = DensityRange {
    low: 1.0,
    high: 3.0,
    prefer: 1.5,
};

fn state(body: &SpinBody<'_>, solution: &SpinSolution) -> SpinState {
    let moments = body.weigh(|element| solution.densities[element]);
    SpinState::of(&moments, 1.0, 1.0, &body.axis)
}

fn assert_spins(state: &SpinState) {
    assert!(state.distance < 1e-14, "{:e}", state.distance);
    assert!(state.angle_degrees < 1e-10, "{:e}", state.angle_degrees);
}

/// ½ Σ w (d − d₀)².
fn variance(body: &SpinBody<'_>, densities: &[f64], prefer: f64) -> f64 {
    let pairs = body.moments.iter().zip(densities);
    pairs
        .map(|(moments, density)| 0.5 * moments.mass * (density - prefer).powi(2))
        .sum()
}

#[test]
fn vertices_spin_and_the_linear_field_says_so() {
    let (mesh, axis) = (block(), axis());
    let moments = of_vertices(&mesh, &axis.through);
    let body = SpinBody {
        moments: &moments,
        axis,
    };
    let native = SpinState::of(&body.weigh(|_| 1.0), 1.0, 1.0, &axis);
    assert!(native.distance > 0.01 && native.angle_degrees > 1.0);
    let solution = body.spin(&wish(axis), &RANGE);
    assert_eq!(solution.variance.end, SolveEnd::Met);
    assert!(solution.iterations <= 10, "{}", solution.iterations);
    assert_spins(&state(&body, &solution));
    let (low, high) = solution
        .densities
        .iter()
        .fold((f64::MAX, 0.0_f64), |(low, high), &d| {
            (low.min(d), high.max(d))
        });
    assert!(low >= 1.0 && high <= 3.0);
    let own = at_vertices(
        &mesh.vertices,
        &mesh.tets,
        &solution.densities,
        &axis.through,
    );
    assert_spins(&SpinState::of(&own, 1.0, 1.0, &axis));
}

#[test]
fn cells_spin() {
    let (solid, axis) = (solid(), axis());
    let sites = crate::relax::relaxation::random_sites(&solid, 60, 3).expect("room");
    let diagram = Diagram::new(&solid, &sites).expect("cells");
    let moments = of_cells(&diagram, &axis.through).expect("cells");
    let body = SpinBody {
        moments: &moments,
        axis,
    };
    let solution = body.spin(&wish(axis), &RANGE);
    assert_eq!(solution.variance.end, SolveEnd::Met);
    assert_spins(&state(&body, &solution));
    // The same field by another way: tetrahedra of the cells' convex parts.
    let mut sum = Moments::default();
    for tet in tetrahedra(&diagram).expect("cells") {
        let middle = tet.iter().map(|c| c.coords).sum::<Vector3<f64>>() / 4.0;
        let site = diagram.locate(middle).expect("it lies in the solid");
        let moments =
            crate::integrals::mesh_moments::constant(&tet, &[[0, 1, 2, 3]], &axis.through);
        sum += moments * solution.densities[site];
    }
    let other = SpinState::of(&sum, 1.0, 1.0, &axis);
    assert!(other.distance < 1e-13 && other.angle_degrees < 1e-10);
}

#[test]
fn points_spin_and_their_formula_nearly_so() {
    let (solid, axis) = (solid(), axis());
    let diagram = Diagram::new(&solid, &[[0.6, 0.5, 0.3]]).expect("a cell");
    let tets = eighths(&tetrahedra(&diagram).expect("a cell"));
    let weigh = |tets: &[[Point3<f64>; 4]]| {
        let all = points(tets);
        let moments: Vec<_> = all.iter().map(|p| p.moments(&axis.through)).collect();
        (all, moments)
    };
    let (_, moments) = weigh(&tets);
    let body = SpinBody {
        moments: &moments,
        axis,
    };
    let solution = body.spin(&wish(axis), &RANGE);
    assert_spins(&state(&body, &solution));
    let multipliers = &solution.variance.multipliers;
    let formula = crate::balance::spin::combined(&solution.conditions, multipliers, &axis.through);
    let at = |at: &Point3<f64>| RANGE.clamp(RANGE.prefer + formula.at(at));
    let (finer, moments) = weigh(&eighths(&tets));
    let finer_body = SpinBody {
        moments: &moments,
        axis,
    };
    let moments = finer_body.weigh(|point| at(&finer[point].position));
    let finer = SpinState::of(&moments, 1.0, 1.0, &axis);
    assert!(
        finer.distance > 1e-9 && finer.distance < 2e-4,
        "{:e}",
        finer.distance
    );
    // The text is the same function.
    let text: crate::integrals::polynomial::Polynomial =
        formula.text().parse().expect("a polynomial");
    let place = Point3::new(0.3, 0.8, 0.2);
    assert!((text.at(&place) - formula.at(&place)).abs() < 1e-14);
}

#[test]
fn least_variance_means_least() {
    let (mesh, axis) = (block(), axis());
    let moments = of_vertices(&mesh, &axis.through);
    let body = SpinBody {
        moments: &moments,
        axis,
    };
    let best = body.spin(&wish(axis), &RANGE);
    for prefer in [1.0, 1.2, 2.0, 3.0] {
        let other = body.spin(&wish(axis), &DensityRange { prefer, ..RANGE });
        assert_eq!(other.variance.end, SolveEnd::Met);
        let (least, more) = (
            variance(&body, &best.densities, RANGE.prefer),
            variance(&body, &other.densities, RANGE.prefer),
        );
        assert!(least < more, "{prefer}: {least} {more}");
    }
}

#[test]
fn the_least_contrast_parts_what_is_found_from_what_is_refuted() {
    let (mesh, axis) = (block(), axis());
    let moments = of_vertices(&mesh, &axis.through);
    let body = SpinBody {
        moments: &moments,
        axis,
    };
    let wish = wish(axis);
    let least = body.least_contrast(&wish.conditions(), 1.0);
    assert!(least.contrast > 1.2 && least.contrast < 3.0);
    let within = |high: f64| {
        let range = DensityRange {
            low: 1.0,
            high,
            prefer: 1.0,
        };
        body.spin(&wish, &range).variance.end
    };
    assert_eq!(within(least.contrast * 1.001), SolveEnd::Met);
    assert_eq!(within(least.contrast * 0.999), SolveEnd::Refuted);
    // The certificate: even the densities that favor it leave its integral negative.
    let high = least.contrast * 0.999;
    let (mut most, mut of_one) = (0.0, 0.0);
    for element in &moments {
        let integral = least.certificate.of(element, &axis.through);
        most += if integral > 0.0 {
            high * integral
        } else {
            integral
        };
        of_one += integral.abs();
    }
    assert!(most < 0.0 && most > -0.01 * of_one, "{most} {of_one}");
    // An axis beside the solid is out of reach at any contrast.
    let beside = SpinAxis::new(&Point3::new(5.0, 0.5, 0.3), &axis.along).expect("a direction");
    let outside = body.least_contrast(&beside.center_on(), 1.0);
    assert!(outside.contrast.is_infinite());
}

#[test]
fn mass_moment_and_height_are_met() {
    let (mesh, axis) = (block(), axis());
    let moments = of_vertices(&mesh, &axis.through);
    let body = SpinBody {
        moments: &moments,
        axis,
    };
    let free = body.spin(&wish(axis), &RANGE);
    let was = state(&body, &free);
    let about = |state: &SpinState| state.body.moment_about_axis(&axis.through, &axis.along);
    let wanted = SpinWish {
        center_at: Some(was.height + 0.02),
        mass: Some(was.body.mass * 1.1),
        moment: Some(about(&was) * 1.15),
        ..wish(axis)
    };
    let solution = body.spin(&wanted, &RANGE);
    assert_eq!(solution.variance.end, SolveEnd::Met);
    let is = state(&body, &solution);
    assert_spins(&is);
    assert!((is.height - was.height - 0.02).abs() < 1e-13);
    assert!((is.body.mass / was.body.mass - 1.1).abs() < 1e-13);
    assert!((about(&is) / about(&was) - 1.15).abs() < 1e-12);
    // The mass of a density within the range is bounded.
    let heavy = SpinWish {
        mass: Some(3.1 * body.weigh(|_| 1.0).mass),
        ..wish(axis)
    };
    assert_eq!(body.spin(&heavy, &RANGE).variance.end, SolveEnd::Refuted);
    let ratio = SpinWish {
        gyration_squared: Some(about(&was) / was.body.mass * 1.05),
        ..wish(axis)
    };
    let is = state(&body, &body.spin(&ratio, &RANGE));
    let gained = about(&is) / is.body.mass / (about(&was) / was.body.mass);
    assert!((gained - 1.05).abs() < 1e-12, "{gained}");
}

#[test]
fn the_largest_moment_is_a_cone_and_its_tangent_suffices() {
    // About an axis across the shortest side's the moment is the middle one.
    let mesh = block();
    let axis = SpinAxis::new(
        &Point3::new(0.66, 0.5, 0.36),
        &Vector3::new(0.02, 1.0, 0.01),
    )
    .expect("a direction");
    let moments = of_vertices(&mesh, &axis.through);
    let body = SpinBody {
        moments: &moments,
        axis,
    };
    let range = DensityRange {
        low: 0.5,
        high: 4.0,
        prefer: 1.0,
    };
    let tumbling = state(&body, &body.spin(&wish(axis), &range));
    assert!(tumbling.moment_rank < 2);
    let share = 0.05;
    let stable = SpinWish {
        stable: Some(share),
        ..wish(axis)
    };
    let solution = body.spin(&stable, &range);
    assert_eq!(solution.variance.end, SolveEnd::Met);
    let is = state(&body, &solution);
    assert!(is.distance < 1e-13 && is.angle_degrees < 1e-9);
    assert_eq!(is.moment_rank, 2);
    let principal = is.body.principal().moments;
    assert!(
        (principal[2] / principal[1] - 1.0 - share).abs() < 1e-9,
        "{principal}"
    );
    // Many half-spaces about the height that was found: no better field, and the same one.
    let level = wish(axis.moved_to(is.height));
    let mut conditions = level.conditions();
    let angles = (0..90).map(|k| f64::from(k) * 2_f64.to_radians());
    conditions.extend(angles.map(|angle| level.axis.stable_against(angle, share)));
    let elements = crate::balance::elements::Elements::of_moments(
        &conditions,
        &moments,
        &Moments::default(),
        &axis.through,
    );
    let many = crate::balance::solve::least_variance(&elements, &range);
    let densities = elements.densities(&range, &many.multipliers);
    let (one, other) = (
        variance(&body, &solution.densities, range.prefer),
        variance(&body, &densities, range.prefer),
    );
    // 2 degrees leave cos 2° of the cone's opening.
    assert!(
        (one / other - 1.0).abs() < 2e-3 && one >= other * (1.0 - 1e-9),
        "{one} {other}"
    );
}

#[test]
fn rigid_motions_and_units_carry_the_solution() {
    let (mesh, from) = (block(), axis());
    let rotation = Rotation3::from_euler_angles(0.4, -1.1, 2.0);
    let shift = Vector3::new(30.0, -7.0, 11.0);
    let moved = |point: &Point3<f64>| rotation * (point * 25.4) + shift;
    let mut other = mesh.clone();
    other.vertices = mesh.vertices.iter().map(moved).collect();
    let to = SpinAxis::new(
        &moved(&from.through),
        &(rotation * from.along.as_ref() * 3.0),
    );
    let to = to.expect("a direction");
    let fields = [(&mesh, from), (&other, to)].map(|(mesh, axis)| {
        let moments = of_vertices(mesh, &axis.through);
        let body = SpinBody {
            moments: &moments,
            axis,
        };
        body.spin(&wish(axis), &RANGE).densities
    });
    let error = DVector::from_vec(fields[0].clone()) - DVector::from_vec(fields[1].clone());
    assert!(error.amax() < 1e-10, "{:e}", error.amax());
    let moments = of_vertices(&mesh, &from.through);
    let body = SpinBody {
        moments: &moments,
        axis: from,
    };
    let tenfold = DensityRange {
        low: 10.0,
        high: 30.0,
        prefer: 15.0,
    };
    let heavy = DVector::from_vec(body.spin(&wish(from), &tenfold).densities);
    let error = (heavy / 10.0 - DVector::from_vec(fields[0].clone())).amax();
    assert!(error < 1e-12, "{error:e}");
}

/// The rocker arm's bore by least squares (`density.md` 2.3).
fn bore() -> SpinAxis {
    let through = Point3::new(0.0, 0.067_179_41, 0.084_916_92);
    let along = Vector3::new(0.999_972_85, -0.007_270_18, 0.001_201_18);
    SpinAxis::new(&through, &along).expect("a direction")
}

fn rocker_arm() -> SurfaceSolid {
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models/rocker-arm.obj");
    let mesh = crate::mesh::formats::read::read_surface(&path).expect("the model");
    SurfaceSolid::from_arrays(&mesh.vertices, &mesh.triangles).expect("a solid")
}

#[test]
#[ignore = "needs ../shared/models"]
fn the_rocker_arm_spins_about_its_bore() {
    let (solid, axis) = (rocker_arm(), bore());
    let native = crate::integrals::mesh_moments::constant(
        &solid.surface().vertices,
        &solid.surface().triangles,
        &axis.through,
    );
    let native = SpinState::of(&native, solid.volume(), 1.0, &axis);
    assert!((native.distance - 0.065_502).abs() < 1e-6);
    assert!((native.angle_degrees - 4.6875).abs() < 1e-3);
    let sites = crate::relax::relaxation::random_sites(&solid, 400, 1).expect("room");
    let diagram = Diagram::new(&solid, &sites).expect("cells");
    let tets = tetrahedra(&diagram).expect("cells");
    let moments: Vec<_> = points(&tets)
        .iter()
        .map(|p| p.moments(&axis.through))
        .collect();
    let body = SpinBody {
        moments: &moments,
        axis,
    };
    let range = DensityRange {
        low: 1.0,
        high: 4.0,
        prefer: 1.0,
    };
    let solution = body.spin(&wish(axis), &range);
    assert!(solution.iterations <= 10, "{}", solution.iterations);
    let is = state(&body, &solution);
    assert_spins(&is);
    let mean = is.body.mass / solid.volume();
    assert!((mean - 1.569).abs() < 1e-3, "{mean}");
    assert_eq!(is.moment_rank, 2);
    let least = body.least_contrast(&wish(axis).conditions(), 1.0).contrast;
    assert!(least > 3.34 && least <= 3.36, "{least}");
    let center = body.least_contrast(&axis.center_on(), 1.0).contrast;
    assert!((center - 2.151_660_32).abs() < 1e-3, "{center}");
}
