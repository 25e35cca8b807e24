//! Bodies: transfer of axes, cutting, profiles, one mass computed in three ways.

use crate::geometry::bounds::Bounds;
use crate::geometry::moments::Moments;
use crate::integrals::mesh_moments;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::reference::{cattani_paoluzzi, tetrahedron};
use crate::mass::body::Body;
use crate::mass::cut::cut;
use crate::mass::density::{Ramp, SolidDensity};
use crate::mass::profile::{Profile, ProfileError};
use crate::mass::split::{Side, split};
use crate::mass::weigh::{WeighError, weigh_surface, weigh_tets};
use crate::mesh::formats::read::load;
use crate::mesh::shapes::{bracket, cuboid, icosphere, torus, unit_cube, unit_cube_tets};
use crate::mesh::similarity::Similarity;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::{TetMesh, VertexData};
use crate::mesh::validate::{Solid, validate_surface, validate_tets};
use crate::tests::models::shared_model;
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};
use proptest::prelude::*;

fn close(got: f64, expected: f64, relative: f64, what: &str) {
    assert!(
        (got - expected).abs() <= relative * expected.abs(),
        "{what}: {got} is not {expected}"
    );
}

/// Masses, centers and inertias agree relative to the body's size.
fn same(a: &Body, b: &Body, relative: f64, what: &str) {
    let size = b.inertia_center().norm();
    let length = (size / b.mass).sqrt();
    close(a.mass, b.mass, relative, what);
    let apart = (a.center_of_mass() - b.center_of_mass()).norm();
    assert!(apart <= relative * length, "{what}: centers {apart} apart");
    let apart = (a.inertia_center() - b.inertia_center()).norm();
    assert!(apart <= relative * size, "{what}: inertias {apart} apart");
}

fn block(min: [f64; 3], max: [f64; 3]) -> SurfaceMesh {
    cuboid(&Bounds {
        min: min.into(),
        max: max.into(),
    })
}

fn weighed(mesh: &SurfaceMesh, density: &SolidDensity) -> Body {
    weigh_surface(mesh, density, &mesh.bounds()).unwrap()
}

fn ramp(axis: usize) -> SolidDensity {
    let (from, to) = (0.0, 1.0);
    SolidDensity::Ramp(Ramp { axis, from, to })
}

fn moved(mesh: &SurfaceMesh, map: impl Fn(&Point3<f64>) -> Point3<f64>) -> SurfaceMesh {
    SurfaceMesh {
        vertices: mesh.vertices.iter().map(map).collect(),
        triangles: mesh.triangles.clone(),
    }
}

// ------------------------------------------------------------- bodies

#[test]
fn a_box_has_its_textbook_inertia() {
    let mesh = block([1.0, 2.0, 3.0], [2.0, 4.0, 6.0]);
    let body = weighed(&mesh, &SolidDensity::Constant(2.0));
    close(body.volume, 6.0, 1e-15, "volume");
    close(body.surface_area, 22.0, 1e-15, "area");
    close(body.mass, 12.0, 1e-15, "mass");
    assert!((body.center_of_mass() - Point3::new(1.5, 3.0, 4.5)).norm() < 1e-15);
    let expected = Matrix3::from_diagonal(&Vector3::new(13.0, 10.0, 5.0));
    assert!((body.inertia_center() - expected).amax() < 1e-14);
    let c = Vector3::<f64>::new(1.5, 3.0, 4.5);
    let about_origin: Matrix3<f64> =
        expected + 12.0 * (Matrix3::from_diagonal_element(c.norm_squared()) - c * c.transpose());
    assert!((body.inertia_origin() - about_origin).amax() < 1e-13);
    let edge = body.moment_about_axis(&Point3::new(1.0, 2.0, 0.0), &Vector3::new(0.0, 0.0, -3.0));
    close(edge, 12.0 * (1.0 + 4.0) / 3.0, 1e-14, "about an edge");
}

#[test]
fn a_unit_cube_at_a_million_keeps_twelve_digits() {
    for shift in [Vector3::repeat(1e6), Vector3::new(1e6, -3e6, 2e6)] {
        let mesh = moved(&unit_cube(), |v| v + shift);
        let body = weighed(&mesh, &SolidDensity::Constant(1.0));
        close(body.mass, 1.0, 1e-15, "mass");
        let sixth = Matrix3::from_diagonal_element(1.0 / 6.0);
        assert!((body.inertia_center() - sixth).amax() < 1e-15);
        assert!((body.principal().moments - Vector3::repeat(1.0 / 6.0)).amax() < 1e-15);
        let graded = weighed(&mesh, &ramp(2));
        close(graded.mass, 0.5, 1e-15, "graded mass");
        // ∫z³ − (∫z²)²/∫z + ∫zy² − ∫z·¼ with the unit cube's own coordinates
        let expected = 1.0 / 4.0 - 2.0 / 9.0 + 1.0 / 6.0 - 1.0 / 8.0;
        close(
            graded.inertia_center().m11,
            expected,
            1e-12,
            "graded inertia",
        );
        // Two halves taken together far away.
        let halves = [
            moved(&block([0.0; 3], [0.5, 1.0, 1.0]), |v| v + shift),
            moved(&block([0.5, 0.0, 0.0], [1.0; 3]), |v| v + shift),
        ];
        let halves = halves.map(|half| weighed(&half, &SolidDensity::Constant(1.0)));
        let whole = Body::combined(&halves).unwrap();
        assert!((whole.inertia_center() - sixth).amax() < 1e-15);
    }
}

#[test]
fn parts_taken_together_are_the_whole() {
    let whole = block([0.0; 3], [3.0, 1.0, 2.0]);
    let parts = [
        block([0.0; 3], [1.0, 1.0, 2.0]),
        block([1.0, 0.0, 0.0], [3.0, 1.0, 0.5]),
        block([1.0, 0.0, 0.5], [3.0, 1.0, 2.0]),
    ];
    for density in [
        SolidDensity::Constant(3.0),
        "1 + x^2*y - 0.5*z".parse().unwrap(),
    ] {
        let bodies = parts.each_ref().map(|part| weighed(part, &density));
        let together = Body::combined(&bodies).unwrap();
        same(&together, &weighed(&whole, &density), 1e-14, "parts");
        close(together.volume, 6.0, 1e-15, "volume");
    }
    let [near, far, _] = parts
        .each_ref()
        .map(|part| weighed(part, &SolidDensity::Constant(1.0)));
    let heavy = Body::combined(&[near.weighing(3.0), far.weighing(1.0)]).unwrap();
    close(heavy.mass, 4.0, 1e-15, "given masses");
    close(
        heavy.center_of_mass().x,
        (3.0 * 0.5 + 1.0 * 2.0) / 4.0,
        1e-15,
        "given masses",
    );
    assert!(Body::combined(&[]).is_none());
}

#[test]
fn the_body_frame_is_right_handed_and_diagonalizes() {
    let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    let mesh = moved(&block([-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]), |v| turn * v);
    let body = weighed(&mesh, &SolidDensity::Constant(1.0));
    let principal = body.principal();
    let mass = 48.0;
    for (got, sides) in principal
        .moments
        .iter()
        .zip([[1.0, 2.0], [1.0, 3.0], [2.0, 3.0]])
    {
        let [a, b] = sides.map(|half: f64| half * half);
        close(*got, mass * (a + b) / 3.0, 1e-14, "principal moment");
    }
    let [a, b, c] = principal.axes;
    assert!((a.cross(&b) - c).norm() < 1e-15);
    assert!(
        (turn.matrix().column(2) - a)
            .norm()
            .min((turn.matrix().column(2) + a).norm())
            < 1e-14
    );
    for axis in [a, b] {
        assert!(axis[axis.iamax()] > 0.0);
    }
    for (axis, moment) in principal.axes.iter().zip(principal.moments.iter()) {
        assert!((body.inertia_center() * axis - axis * *moment).norm() < 1e-12);
        let about = body.moment_about_axis(&body.center_of_mass(), axis);
        close(about, *moment, 1e-14, "about a principal axis");
    }
}

#[test]
fn a_cube_has_the_coordinate_axes_for_its_body_frame() {
    let third = 1.0 / 3.0;
    let mesh = block([-third, 1.0, 0.1], [2.0 * third, 2.0, 1.1]);
    let principal = weighed(&mesh, &SolidDensity::Constant(1.0)).principal();
    for (axis, unit) in principal
        .axes
        .iter()
        .zip(Matrix3::<f64>::identity().column_iter())
    {
        assert!(
            (axis - unit).norm() < 1e-15 || axis.amax() > 1.0 - 1e-15,
            "{axis}"
        );
    }
}

// ------------------------------------------------------------- splitting and cutting

fn tet_volume(corners: &[Point3<f64>; 4]) -> f64 {
    tetrahedron::volume(corners)
}

/// Every placement of four corners about a plane, every order of ids.
#[test]
fn every_case_of_a_split_conserves_volume_and_orientation() {
    let orders: Vec<[u32; 4]> = (0..256)
        .map(|code: u32| [0, 1, 2, 3].map(|k| code >> (2 * k) & 3))
        .filter(|ids| (0..4).all(|id| ids.contains(&id)))
        .collect();
    assert_eq!(orders.len(), 24);
    let corners = [
        [0.0, 0.0, 0.1],
        [1.0, 0.2, 0.0],
        [0.1, 1.1, 0.3],
        [0.3, 0.2, 0.9],
    ];
    let corners = corners.map(Point3::from);
    let whole = tet_volume(&corners);
    let mut cases = std::collections::BTreeMap::new();
    for code in 0..81 {
        let distances = [1, 3, 9, 27].map(|power| {
            let sign = f64::from(code / power % 3 - 1);
            sign * (0.3 + f64::from(power) / 40.0)
        });
        let sides = distances.map(Side::of);
        let [below, on] = [Side::Below, Side::On]
            .map(|side| sides.iter().filter(|&&other| other == side).count());
        for &ids in &orders {
            let Some(pieces) = split(sides, ids) else {
                assert!(below == 0 || below + on == 4);
                continue;
            };
            assert!(below > 0 && below + on < 4);
            let above = 4 - below - on;
            cases.insert((below.min(above), on, below.max(above)), pieces.len());
            let mut sum = 0.0;
            for (side, nodes) in pieces {
                let distance_and_place = nodes.map(|[i, j]| {
                    let share = if i == j {
                        0.0
                    } else {
                        distances[i] / (distances[i] - distances[j])
                    };
                    let place = corners[i] + (corners[j] - corners[i]) * share;
                    (if i == j { distances[i] } else { 0.0 }, place)
                });
                let volume = tet_volume(&distance_and_place.map(|(_, place)| place));
                assert!(volume > 0.0, "{sides:?} {ids:?} {nodes:?}");
                sum += volume;
                let wrong = if side == Side::Below { 1.0 } else { -1.0 };
                assert!(distance_and_place.iter().all(|(d, _)| d * wrong <= 0.0));
            }
            close(sum, whole, 1e-14, "volume");
        }
    }
    let expected = [
        ((1, 0, 3), 4),
        ((1, 1, 2), 3),
        ((1, 2, 1), 2),
        ((2, 0, 2), 6),
    ];
    assert_eq!(cases.into_iter().collect::<Vec<_>>(), expected);
}

fn tets_with_density() -> TetMesh {
    let mut mesh = unit_cube_tets(3);
    for vertex in &mut mesh.vertices {
        let wave = Vector3::new(vertex.y * vertex.z, vertex.x, 0.3 * vertex.x * vertex.y);
        *vertex += 0.2 * wave;
    }
    let values = mesh
        .vertices
        .iter()
        .map(|v| 1.0 + v.x * v.x + v.y)
        .collect();
    let name = "density";
    mesh.vertex_data.push(VertexData::new(name, values));
    mesh
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_cut_mesh_conserves_volume_mass_center_and_conformity(
        normal in prop::array::uniform3(-1.0_f64..1.0),
        place in prop::array::uniform3(0.2_f64..0.9),
        on_grid in any::<bool>(),
    ) {
        let mesh = tets_with_density();
        // Half of the planes pass through a vertex, so that corners lie on them.
        let vertex = mesh.vertices[(place[0] * 60.0) as usize];
        let normal = Vector3::from(normal);
        let offset = if on_grid { normal.dot(&vertex.coords) } else { normal.dot(&Vector3::from(place)) };
        let halves = cut(&mesh, &normal, offset);
        let density = SolidDensity::Vertex(None);
        let before = weigh_tets(&mesh, &density, &mesh.bounds()).unwrap();
        let after = weigh_tets(&halves.mesh, &density, &mesh.bounds()).unwrap();
        close(after.volume, before.volume, 1e-14, "volume");
        same(&after, &before, 1e-13, "cut");
        for (tet, &above) in halves.mesh.all_corners().zip(&halves.above) {
            prop_assert!(tetrahedron::volume(&tet) >= 0.0);
            let side = tet.iter().map(|v| normal.dot(&v.coords) - offset);
            let (low, high) = side.fold((0.0_f64, 0.0_f64), |(l, h), d| (l.min(d), h.max(d)));
            let on_its_side = if above { low > -1e-14 } else { high < 1e-14 };
            prop_assert!(on_its_side);
        }
        // Conforming: no facet lacks its partner but those of the cube's surface.
        close(after.surface_area, before.surface_area, 1e-14, "surface");
    }

    #[test]
    fn rigid_motions_move_the_body_with_its_axes(
        angles in prop::array::uniform3(-3.0_f64..3.0),
        shift in prop::array::uniform3(-50.0_f64..50.0),
    ) {
        let mesh = bracket(3);
        let turn = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let image = moved(&mesh, |v| turn * v + Vector3::from(shift));
        let [body, turned] = [&mesh, &image].map(|mesh| weighed(mesh, &SolidDensity::Constant(1.5)));
        close(turned.mass, body.mass, 1e-13, "mass");
        let center = turn * body.center_of_mass() + Vector3::from(shift);
        prop_assert!((turned.center_of_mass() - center).norm() < 1e-12);
        let inertia = turn.matrix() * body.inertia_center() * turn.matrix().transpose();
        prop_assert!((turned.inertia_center() - inertia).amax() < 1e-12);
        let moments = [body, turned].map(|body| body.principal().moments);
        prop_assert!((moments[0] - moments[1]).amax() < 1e-12);
    }
}

// ------------------------------------------------------------- profiles

#[test]
fn a_profile_over_a_box_is_an_integral_over_its_length() {
    // Density 1 up to x = 0.5, ramp to 3 at x = 1.5, then 3: Fig. 5 of the paper.
    let profile = Profile::new(&Vector3::x(), vec![[0.5, 1.0], [1.5, 3.0]]).unwrap();
    let mesh = block([0.0; 3], [2.0, 1.0, 1.0]);
    let body = weighed(&mesh, &SolidDensity::Profile(profile.clone()));
    close(body.mass, 0.5 + 2.0 + 1.5, 1e-15, "mass");
    // ∫ρx = ½·¼ + ∫(2x)x dx over [½, 3/2] + 3·(4 − 9/4)/2
    let first = 0.125 + (2.0 / 3.0) * (3.375 - 0.125) + 2.625;
    close(body.center_of_mass().x, first / 4.0, 1e-15, "center");
    close(body.center_of_mass().y, 0.5, 1e-15, "center");
    for (s, value) in [(-9.0, 1.0), (0.5, 1.0), (1.0, 2.0), (1.5, 3.0), (9.0, 3.0)] {
        close(profile.at(s), value, 1e-15, "value");
    }
    // Breaks beyond the body leave a linear density.
    let wide = Profile::new(&Vector3::x(), vec![[-1.0, 0.0], [5.0, 6.0]]).unwrap();
    let linear = SolidDensity::Polynomial("1 + x".parse().unwrap());
    same(
        &weighed(&mesh, &SolidDensity::Profile(wide)),
        &weighed(&mesh, &linear),
        1e-15,
        "linear",
    );
}

#[test]
fn a_profile_weighs_the_same_in_tetrahedra_and_within_the_surface() {
    let direction = Vector3::new(1.0, -2.0, 0.5);
    let breaks = vec![[-1.1, 1.0], [-0.6, 4.0], [-0.2, 0.5], [0.3, 2.0]];
    let profile = SolidDensity::Profile(Profile::new(&direction, breaks).unwrap());
    let mesh = tets_with_density();
    let extent = mesh.bounds();
    let filled = weigh_tets(&mesh, &profile, &extent).unwrap();
    let bounded = weigh_surface(&mesh.boundary(), &profile, &extent).unwrap();
    same(&filled, &bounded, 1e-13, "profile");
    // Cutting the mesh at the planes first and reading the densities at vertices is the same.
    let SolidDensity::Profile(inner) = &profile else {
        unreachable!("made above")
    };
    let unit = direction.normalize();
    let sliced = [-1.1, -0.6, -0.2, 0.3]
        .iter()
        .fold(mesh, |mesh, &offset| cut(&mesh, &unit, offset).mesh);
    let densities: Vec<f64> = sliced.vertices.iter().map(|v| inner.at_point(v)).collect();
    let near = extent.center();
    let moments = mesh_moments::at_vertices(&sliced.vertices, &sliced.tets, &densities, &near);
    let by_hand = Body::from_moments(filled.volume, 0.0, &moments, &near);
    same(&by_hand, &filled, 1e-13, "sliced");
}

#[test]
fn breaks_that_make_no_profile_are_refused() {
    let profile = |breaks: &[[f64; 2]]| Profile::new(&Vector3::z(), breaks.to_vec());
    assert_eq!(profile(&[]), Err(ProfileError::Empty));
    let order = profile(&[[0.0, 1.0], [0.0, 2.0]]).unwrap_err().to_string();
    assert_eq!(
        order,
        "break 2 of the profile is at 0, not beyond the one before it"
    );
    let finite = profile(&[[0.0, f64::NAN]]).unwrap_err().to_string();
    assert_eq!(finite, "break 1 of the profile is not finite");
    let nowhere = Profile::new(&Vector3::zeros(), vec![[0.0, 1.0]]);
    assert_eq!(nowhere, Err(ProfileError::Direction));
}

// ------------------------------------------------------------- one mass by several ways

/// [CP] eq. 15, term by term, for density × {1, x, …, zx} in coordinates relative to `near`.
fn by_structure_products(mesh: &SurfaceMesh, density: &Polynomial, near: &Point3<f64>) -> Moments {
    let local: Vec<_> = mesh
        .vertices
        .iter()
        .map(|v| Point3::from(v - near))
        .collect();
    let density = density.relative_to(near);
    #[rustfmt::skip]
    let ten = [
        [0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 0, 0],
        [0, 2, 0], [0, 0, 2], [1, 1, 0], [0, 1, 1], [1, 0, 1],
    ];
    Moments::from_ten(ten.map(|e: [u32; 3]| {
        let product = density.clone() * Polynomial::monomial(1.0, e);
        let terms = product.terms();
        terms
            .map(|(e, value)| value * cattani_paoluzzi::solid(&local, &mesh.triangles, e))
            .sum()
    }))
}

/// Tetrahedra of linear density from one vertex of the surface to every triangle.
fn by_cones(mesh: &SurfaceMesh, density: &Polynomial, near: &Point3<f64>) -> Moments {
    let values: Vec<f64> = mesh.vertices.iter().map(|v| density.at(v)).collect();
    let cones: Vec<_> = mesh
        .triangles
        .iter()
        .map(|&[a, b, c]| [0, a, b, c])
        .collect();
    mesh_moments::at_vertices(&mesh.vertices, &cones, &values, near)
}

fn three_ways(mesh: &SurfaceMesh, what: &str) {
    for axis in 0..3 {
        let mut mesh = mesh.clone();
        Similarity::to_unit_height(&mesh.bounds(), axis).move_all(&mut mesh.vertices);
        let mut exponents = [0; 3];
        exponents[axis] = 1;
        let density = Polynomial::monomial(1.0, exponents);
        let near = mesh.bounds().center();
        let product = weighed(&mesh, &ramp(axis));
        let ways = [
            by_structure_products(&mesh, &density, &near),
            by_cones(&mesh, &density, &near),
            mesh_moments::polynomial(&mesh.vertices, &mesh.triangles, &density, &near),
        ];
        for moments in ways {
            let body = Body::from_moments(product.volume, product.surface_area, &moments, &near);
            same(&body, &product, 1e-12, &format!("{what}, axis {axis}"));
        }
    }
}

#[test]
fn generated_shapes_weigh_the_same_three_ways() {
    three_ways(&torus(1.0, 0.4, 24, 12), "torus");
    three_ways(&bracket(4), "bracket");
    three_ways(&icosphere(2), "icosphere");
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn casting_and_rocker_arm_weigh_the_same_three_ways() {
    for name in ["casting.off", "rocker-arm.obj"] {
        let Solid::Surface(closed, _) = load(&shared_model(name)).unwrap() else {
            panic!("{name} is a surface");
        };
        three_ways(closed.mesh(), name);
    }
}

#[test]
fn a_cube_in_tetrahedra_weighs_what_its_surface_encloses() {
    assert_weighs_what_its_boundary_does(unit_cube_tets(3));
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn the_bunny_in_tetrahedra_weighs_what_its_surface_encloses() {
    let Solid::Tets(tets, _) = load(&shared_model("bunny.mesh")).unwrap() else {
        panic!("the bunny is made of tetrahedra");
    };
    assert_weighs_what_its_boundary_does(tets.into_mesh());
}

/// Weights by tetrahedra and by their boundary are equal for densities of every kind.
fn assert_weighs_what_its_boundary_does(mut mesh: TetMesh) {
    for axis in 0..3 {
        Similarity::to_unit_height(&mesh.bounds(), axis).move_all(&mut mesh.vertices);
        let extent = mesh.bounds();
        let boundary = mesh.boundary();
        for density in [
            SolidDensity::Constant(1.0),
            ramp(axis),
            "1 + x*y + z^3".parse().unwrap(),
        ] {
            let filled = weigh_tets(&mesh, &density, &extent).unwrap();
            let bounded = weigh_surface(&boundary, &density, &extent).unwrap();
            same(&filled, &bounded, 1e-12, "bunny");
            close(filled.surface_area, bounded.surface_area, 1e-13, "area");
        }
    }
}

#[test]
fn every_density_weighs_the_same_in_tetrahedra_and_within_the_surface() {
    let mesh = tets_with_density();
    let extent = mesh.bounds();
    let boundary = mesh.boundary();
    for text in [
        "2",
        "linear:axis=y,from=1,to=3",
        "x*y*z + 1",
        "profile:axis=x,0.2=1,0.7=9",
    ] {
        let density: SolidDensity = text.parse().unwrap();
        let filled = weigh_tets(&mesh, &density, &extent).unwrap();
        let bounded = weigh_surface(&boundary, &density, &extent).unwrap();
        same(&filled, &bounded, 1e-13, text);
        close(filled.volume, bounded.volume, 1e-14, text);
        close(filled.surface_area, bounded.surface_area, 1e-14, text);
    }
}

#[test]
fn a_ball_approaches_the_ball() {
    let body = weighed(&icosphere(5), &SolidDensity::Constant(1.0));
    let volume = 4.0 / 3.0 * std::f64::consts::PI;
    close(body.volume, volume, 2e-3, "volume");
    close(body.surface_area, 3.0 * volume, 2e-3, "area");
    close(body.inertia_center().m11, 0.4 * volume, 4e-3, "inertia");
    close(
        mesh_moments::volume(
            &icosphere(5).vertices,
            &icosphere(5).triangles,
            &Point3::origin(),
        ),
        body.volume,
        1e-14,
        "volume",
    );
}

// ------------------------------------------------------------- densities as text, refusals

#[test]
fn densities_read_what_they_say() {
    let read = |text: &str| text.parse::<SolidDensity>().unwrap();
    assert_eq!(read("2.5"), SolidDensity::Constant(2.5));
    assert_eq!(read(" 1e3 "), SolidDensity::Constant(1000.0));
    let (axis, from, to) = (2, 0.0, 1.0);
    assert_eq!(
        read("linear:axis=z,from=0,to=1"),
        SolidDensity::Ramp(Ramp { axis, from, to })
    );
    assert_eq!(
        read("linear: to=1, from=0, axis=Z"),
        SolidDensity::Ramp(Ramp { axis, from, to })
    );
    assert_eq!(
        read("1+x"),
        SolidDensity::Polynomial("1 + x".parse().unwrap())
    );
    assert_eq!(read("vertex"), SolidDensity::Vertex(None));
    assert_eq!(read("vertex:rho"), SolidDensity::Vertex(Some("rho".into())));
    let profile = Profile::new(&Vector3::x(), vec![[0.2, 1.0], [0.8, 5.0]]).unwrap();
    assert_eq!(
        read("profile:axis=x,0.2=1,0.8=5"),
        SolidDensity::Profile(profile)
    );
}

#[test]
fn what_is_no_density_is_refused_by_name() {
    for (text, part) in [
        (
            "heavy",
            "`heavy` is not a density: column 1: expected a number",
        ),
        ("lineal:axis=z", "density kind `lineal` does not exist"),
        ("linear:axis=w,from=0,to=1", "axis `w` does not exist"),
        ("linear:axis=z,from=0", "a `linear` density needs `to`"),
        (
            "linear:axis=z,from=a,to=1",
            "`a` in `from=a` is not a finite number",
        ),
        (
            "linear:axis=z,low=0",
            "`low=0` is no setting of a `linear` density",
        ),
        ("profile:axis=z,1=2,0=3", "break 2 of the profile is at 0"),
        ("profile:0=1", "a `profile` density needs `axis`"),
    ] {
        let message = text.parse::<SolidDensity>().unwrap_err().to_string();
        assert!(message.contains(part), "{text}: {message}");
    }
}

#[test]
fn what_cannot_be_weighed_is_refused() {
    let cube = unit_cube();
    let weigh = |text: &str| weigh_surface(&cube, &text.parse().unwrap(), &cube.bounds());
    assert_eq!(weigh("0"), Err(WeighError::Massless { mass: 0.0 }));
    assert!(matches!(weigh("x - 1"), Err(WeighError::Massless { mass }) if mass < 0.0));
    assert_eq!(weigh("vertex"), Err(WeighError::VertexOfSurface));
    let tets = tets_with_density();
    let weigh = |text: &str| weigh_tets(&tets, &text.parse().unwrap(), &tets.bounds());
    let missing = weigh("vertex:rho").unwrap_err().to_string();
    assert_eq!(
        missing,
        "the mesh has no vertex data `rho`; it has `density`"
    );
    assert!(weigh("vertex:density").is_ok());
}

#[test]
fn the_generated_shapes_are_sound() {
    for mesh in [
        unit_cube(),
        torus(1.0, 0.4, 24, 12),
        bracket(4),
        icosphere(2),
    ] {
        validate_surface(&mesh).unwrap();
    }
    validate_tets(&tets_with_density()).unwrap();
}

/// ∫ {1, x, y, z, x², y², z², xy, yz, zx} over a closed surface by fractions: cones from the origin.
fn ten_by_fractions(mesh: &SurfaceMesh, origin: &Point3<f64>) -> [f64; 10] {
    let fraction = |x: f64| BigRational::from_float(x).unwrap();
    let mut sums = vec![BigRational::zero(); 10];
    for corners in mesh.all_corners() {
        let [a, b, c] = corners.map(|p| [0, 1, 2].map(|k| fraction(p[k]) - fraction(origin[k])));
        let minor = |i: usize, j: usize| &b[i] * &c[j] - &b[j] * &c[i];
        let six = &a[0] * minor(1, 2) + &a[1] * minor(2, 0) + &a[2] * minor(0, 1);
        let sum = [0, 1, 2].map(|k| &a[k] + &b[k] + &c[k]);
        sums[0] += &six;
        for k in 0..3 {
            let second =
                |l: usize| &a[k] * &a[l] + &b[k] * &b[l] + &c[k] * &c[l] + &sum[k] * &sum[l];
            sums[1 + k] += &six * &sum[k];
            sums[4 + k] += &six * second(k);
            sums[7 + k] += &six * second((k + 1) % 3);
        }
    }
    let number = |k: usize| sums[k].to_f64().unwrap();
    let factor = |k: usize| [6.0, 24.0, 24.0, 24.0].get(k).copied().unwrap_or(120.0);
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(|k| number(k) / factor(k))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Rods of any direction, down to a width of 10⁻⁹ of their length: every moment is that of
    /// fractions on the same numbers, to a few roundings over the width.
    #[test]
    fn thin_rods_keep_their_moments(turn in proptest::array::uniform3(-3.0..3.0_f64), width in -9..0_i32, bent in any::<bool>()) {
        let width = 10_f64.powi(width);
        let map = Rotation3::new(Vector3::from(turn));
        let mut mesh = block([0.0; 3], [1.0, width, 0.7 * width]);
        if bent {
            // A frame of three rods: the cones of the solid have both signs.
            mesh = torus(1.0, width, 12, 5);
        }
        let mesh = moved(&mesh, |p| map * p);
        let near = mesh.bounds().center();
        let exact = ten_by_fractions(&mesh, &near);
        let got = mesh_moments::constant(&mesh.vertices, &mesh.triangles, &near).ten();
        let volume = mesh_moments::volume(&mesh.vertices, &mesh.triangles, &near);
        let tolerance = 1e-14 * exact[0] + 4e-16 / width * exact[0];
        prop_assert!((volume - exact[0]).abs() <= tolerance, "{} {}", volume, exact[0]);
        prop_assert!((mesh.volume() - exact[0]).abs() <= tolerance, "{} {}", mesh.volume(), exact[0]);
        for (got, exact) in got.iter().zip(&exact) {
            prop_assert!((got - exact).abs() <= tolerance, "{} {}", got, exact);
        }
        let linear = mesh_moments::polynomial(&mesh.vertices, &mesh.triangles, &"1".parse().unwrap(), &near);
        for (got, exact) in linear.ten().iter().zip(&exact) {
            prop_assert!((got - exact).abs() <= tolerance, "{} {}", got, exact);
        }
    }
}
