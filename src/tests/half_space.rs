//! Moments of solids above planes: complements, closed forms, cut tetrahedra, differences; densities of
//! ramps and clamps.

use nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;

use crate::geometry::bounds::Bounds;
use crate::geometry::moments::Moments;
use crate::integrals::half_space::{CutPlane, CuttableSolid, ThreeMoments};
use crate::integrals::mesh_moments;
use crate::mass::cut::cut;
use crate::mass::density::SolidDensity;
use crate::mass::linear_pieces::linear_pieces;
use crate::mass::profile::Profile;
use crate::mass::weigh::{weigh_surface, weigh_tets};
use crate::mesh::shapes::{bracket, cuboid, icosphere, torus, unit_cube, unit_cube_tets};
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::{TetMesh, VertexData};

/// The largest difference of moments, in units of the whole body's.
fn distance(one: &Moments, other: &Moments) -> f64 {
    let pairs = one.ten().into_iter().zip(other.ten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn cuttable(mesh: &SurfaceMesh) -> CuttableSolid<'_> {
    CuttableSolid::new(&mesh.vertices, &mesh.triangles)
}

fn plane(normal: [f64; 3], offset: f64) -> CutPlane {
    CutPlane {
        normal: normal.into(),
        offset,
    }
}

#[test]
fn a_cube_above_a_plane_is_a_box() {
    let cube = unit_cube();
    let solid = cuttable(&cube);
    for height in [-0.2, 0.0, 0.25, 1.0 / 3.0, 0.5, 0.9, 1.0, 1.5_f64] {
        let found = solid.above(&plane([0.0, 0.0, 2.0], 2.0 * height));
        let low = height.clamp(0.0, 1.0);
        let slab = cuboid(&Bounds::from_corners([0.0, 0.0, low], [1.0; 3]));
        let expected = if low < 1.0 {
            mesh_moments::constant(&slab.vertices, &slab.triangles, &solid.middle)
        } else {
            Moments::default()
        };
        assert!(
            distance(&found, &expected) < 1e-16 * 4.0,
            "{height}: {found:?}"
        );
    }
    // The corner x + y + z > 5/2 is a tetrahedron of legs ½.
    let corner = solid.above(&plane([1.0; 3], 2.5));
    assert!((corner.mass - 1.0 / 48.0).abs() < 1e-16);
    // The hexagon x + y + z = 3/2 has sides √½.
    let hexagon = solid.section(&plane([-1.0; 3], -1.5));
    assert!(
        (hexagon.mass - 0.75 * 3.0_f64.sqrt()).abs() < 1e-15,
        "{hexagon:?}"
    );
    assert!(hexagon.first.norm() < 1e-16);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn both_sides_of_a_plane_make_the_whole(normal in proptest::array::uniform3(-1.0..1.0_f64), share in -1.2..1.2_f64) {
        for mesh in [torus(1.0, 0.4, 24, 12), bracket(4), icosphere(3)] {
            let solid = cuttable(&mesh);
            let normal = Vector3::from(normal);
            let reach = normal.abs().dot(&mesh.bounds().extent()) * 0.5;
            let offset = normal.dot(&solid.middle.coords) + share * reach;
            let above = solid.above_to_third(&CutPlane { normal, offset });
            let below = solid.above_to_third(&CutPlane { normal: -normal, offset: -offset });
            let whole = solid.above_to_third(&CutPlane { normal, offset: offset - 9.0 });
            prop_assert!(distance(&(above.low + below.low), &solid.whole) < 1e-14 * solid.whole.mass * 4.0);
            for i in 0..3 { for j in 0..3 { for k in 0..3 {
                let sum = above.third.at(i, j, k) + below.third.at(i, j, k);
                prop_assert!((sum - whole.third.at(i, j, k)).abs() < 1e-14 * solid.whole.mass * 8.0);
            }}}
            let quick = distance(&above.low, &solid.above(&CutPlane { normal, offset }));
            prop_assert!(quick < 1e-14 * solid.whole.mass);
        }
    }
}

/// Tetrahedra of a grid, bent so that none are alike.
fn tets() -> TetMesh {
    let mut mesh = unit_cube_tets(2);
    for vertex in &mut mesh.vertices {
        let [x, y, z] = [vertex.x, vertex.y, vertex.z];
        *vertex += Vector3::new(0.05 * y * z, 0.04 * (3.0 * x).sin(), 0.06 * x * y);
    }
    mesh
}

#[test]
fn tetrahedra_cut_by_the_plane_have_the_same_moments() {
    let mesh = tets();
    let boundary = mesh.boundary();
    let solid = cuttable(&boundary);
    let normal = Vector3::new(0.7, -0.4, 1.1);
    let offset = normal.dot(&solid.middle.coords) + 0.1;
    let parts = cut(&mesh, &normal, offset);
    let above = parts.mesh.tets.iter().zip(&parts.above);
    let above: Vec<_> = above
        .filter_map(|(tet, is_above)| is_above.then_some(*tet))
        .collect();
    let expected = mesh_moments::constant(&parts.mesh.vertices, &above, &solid.middle);
    let found = solid.above(&CutPlane { normal, offset });
    assert!(distance(&found, &expected) < 1e-15 * 8.0);
    // Third moments: those of x² y over the same tetrahedra, by the polynomial density x² y.
    let density = "x^2*y".parse().unwrap();
    let origin = Point3::origin();
    let by_polynomial = mesh_moments::polynomial(&parts.mesh.vertices, &above, &density, &origin);
    let third = solid.above_to_third(&CutPlane { normal, offset });
    let third = third.translated(&solid.middle.coords).third;
    assert!((third.at(1, 0, 0) - by_polynomial.mass).abs() < 1e-15 * 8.0);
}

#[test]
fn sections_are_the_derivatives_of_what_lies_above() {
    let mesh = torus(1.0, 0.4, 24, 12);
    let solid = cuttable(&mesh);
    let normal = Vector3::new(0.3, 0.8, -0.5).normalize();
    let above = |offset: f64| solid.above(&CutPlane { normal, offset });
    let (step, offset) = (1e-5, 0.17);
    let slope = (above(offset - step) + above(offset + step) * -1.0) * (0.5 / step);
    let section = solid.section(&CutPlane { normal, offset });
    assert!(distance(&slope, &section) < 1e-7, "{slope:?} {section:?}");
}

#[test]
fn moments_change_with_the_plane_as_their_derivatives_say() {
    // F_k = ∫_A φ_k u with u = n·y − o has ∂F_k/∂n = m_{k+1}(A) and ∂F_k/∂o = −m_k(A).
    let mesh = bracket(4);
    let solid = cuttable(&mesh);
    let normal = Vector3::new(0.9, 0.4, -0.6);
    let offset = normal.dot(&solid.middle.coords) + 0.05;
    let excess = |normal: Vector3<f64>, offset: f64| -> Moments {
        let ThreeMoments { low, third } = solid.above_to_third(&CutPlane { normal, offset });
        let offset = offset - normal.dot(&solid.middle.coords);
        let along = Moments {
            mass: normal.dot(&low.first),
            first: low.second * normal,
            second: third.along(&normal),
        };
        along + low * -offset
    };
    let at = solid.above_to_third(&CutPlane { normal, offset });
    let step = 1e-5;
    let slope = |low: Moments, high: Moments| (high + low * -1.0) * (0.5 / step);
    let by_offset = slope(excess(normal, offset - step), excess(normal, offset + step));
    assert!(distance(&by_offset, &(at.low * -1.0)) < 1e-8 * solid.whole.mass);
    for axis in 0..3 {
        // u is measured from the coordinates' origin: ∂u/∂n = y = r + middle.
        let turn = Vector3::ith(axis, step);
        let by_normal = slope(excess(normal - turn, offset), excess(normal + turn, offset));
        let unit = Vector3::ith(axis, 1.0);
        let expected = Moments {
            mass: at.low.first[axis],
            first: at.low.second * unit,
            second: at.third.along(&unit),
        } + at.low * solid.middle[axis];
        assert!(
            distance(&by_normal, &expected) < 1e-8 * solid.whole.mass,
            "{axis}"
        );
    }
}

#[test]
fn a_ramp_is_the_profile_of_its_ends_along_any_direction() {
    let mesh = bracket(4);
    let weigh = |text: &str| {
        let density: SolidDensity = text.parse().unwrap();
        weigh_surface(&mesh, &density, &mesh.bounds()).unwrap()
    };
    let along_x = weigh("ramp:direction=2,0,0,from=0.2,to=0.8,low=1,high=5");
    assert_eq!(along_x, weigh("profile:axis=x,0.2=1,0.8=5"));
    assert_eq!(
        along_x,
        weigh("ramp:direction=2,0,0,from=0.8,to=0.2,low=5,high=1")
    );
    let clamped = weigh("clamp(1, 5, 1 + (x - 0.2) * 4 / 0.6)");
    assert!((clamped.mass - along_x.mass).abs() < 1e-14 * along_x.mass);
    let turned = weigh("ramp:direction=1,-2,0.5,from=-0.3,to=0.2,low=1,high=5");
    let unit = Vector3::new(1.0, -2.0, 0.5).normalize();
    let profile = Profile::new(&unit, vec![[-0.3, 1.0], [0.2, 5.0]]).unwrap();
    let same = weigh_surface(&mesh, &SolidDensity::Profile(profile), &mesh.bounds()).unwrap();
    assert!((turned.mass - same.mass).abs() < 1e-14 * same.mass);
}

#[test]
fn clamps_are_constant_linear_or_one_sided_where_their_planes_miss_the_solid() {
    let cube = unit_cube();
    let weigh = |text: &str| weigh_surface(&cube, &text.parse().unwrap(), &cube.bounds()).unwrap();
    for (text, mass) in [
        ("clamp(1, 5, 2 + 1e-13*x)", 2.0 + 0.5e-13),
        ("clamp(1, 5, 2 + 0*x)", 2.0),
        ("clamp(1, 5, 9 + x)", 5.0),
        ("clamp(1, 5, x - 9)", 1.0),
        ("clamp(0, 5, 1 + x)", 1.5),
        // 1 up to x = 1/3, then 1 + 3 (x − 1/3): mass 1 + 3 (2/3)²/2.
        ("clamp(1, inf, 3*x)", 1.0 + 1.5 * 4.0 / 9.0),
        // A step of width 1e-9 in the middle.
        ("clamp(1, 3, 2 + 2e9*(x - 0.5))", 2.0),
    ] {
        let found = weigh(text).mass;
        assert!((found - mass).abs() < 1e-15 * 8.0, "{text}: {found}");
    }
    let step = weigh("ramp:direction=1,0,0,from=0.25,to=0.250000001,low=1,high=5");
    let exact = 1.0 + 4.0 * (0.75 - 0.5e-9);
    assert!(
        (step.mass - exact).abs() < 1e-15 * 8.0,
        "{}",
        step.mass - exact
    );
}

#[test]
fn layers_agree_with_cut_tetrahedra_for_vertices_in_the_planes_too() {
    let mesh = tets();
    let at = mesh.vertices[5];
    for normal in [Vector3::x(), Vector3::new(0.3, -1.0, 0.8).normalize()] {
        let [low, high] = [normal.dot(&at.coords), normal.dot(&at.coords) + 0.3];
        let density =
            Profile::new(&normal, vec![[low, 1.0], [high, 6.0], [high + 0.2, 2.0]]).unwrap();
        let density = SolidDensity::Profile(density);
        let extent = mesh.bounds();
        let weighed = weigh_tets(&mesh, &density, &extent).unwrap();
        let pieces = linear_pieces(&mesh, &density, &extent).unwrap();
        let origin = extent.center();
        let expected = mesh_moments::at_vertices(
            &pieces.mesh.vertices,
            &pieces.mesh.tets,
            &pieces.densities,
            &origin,
        );
        assert!((weighed.mass - expected.mass).abs() < 1e-14 * expected.mass);
        let center = origin + expected.center();
        assert!((weighed.center_of_mass() - center).norm() < 1e-14);
        let inertia = expected.second_about(&Point3::from(expected.center()));
        assert!((weighed.inertia_center().trace() / 2.0 - inertia).abs() < 1e-14 * inertia);
        // Linear in every tetrahedron: the density at a middle is the mean of the corners'.
        let SolidDensity::Profile(profile) = &density else {
            unreachable!()
        };
        for tet in &pieces.mesh.tets {
            let [a, b, c, d] = tet.map(|v| {
                (
                    pieces.mesh.vertices[v as usize].coords,
                    pieces.densities[v as usize],
                )
            });
            let middle = Point3::from((a.0 + b.0 + c.0 + d.0) / 4.0);
            let mean = (a.1 + b.1 + c.1 + d.1) / 4.0;
            assert!((profile.at_point(&middle) - mean).abs() < 1e-12);
        }
    }
}

#[test]
fn clamped_vertex_data_are_cut_where_they_bend() {
    let mut mesh = tets();
    // Data that are an affine function of position: the clamp is one of position then.
    let values = mesh
        .vertices
        .iter()
        .map(|v| 1.0 + 2.0 * v.x - v.y + 0.5 * v.z)
        .collect();
    mesh.vertex_data = vec![VertexData {
        name: "t".into(),
        values,
        fault: None,
    }];
    let extent = mesh.bounds();
    let weigh = |text: &str| weigh_tets(&mesh, &text.parse().unwrap(), &extent).unwrap();
    for (by_data, by_place) in [
        (
            "clamp(1.2, 2.1, vertex:t)",
            "clamp(1.2, 2.1, 1 + 2*x - y + 0.5*z)",
        ),
        (
            "clamp(1.2, inf, vertex)",
            "clamp(1.2, inf, 1 + 2*x - y + 0.5*z)",
        ),
        (
            "ramp:vertex=t,from=1,to=2,low=5,high=3",
            "clamp(3, 5, 7 - 2*(1 + 2*x - y + 0.5*z))",
        ),
        (
            "ramp:vertex=,from=2,to=1,low=3,high=5",
            "clamp(3, 5, 7 - 2*(1 + 2*x - y + 0.5*z))",
        ),
    ] {
        let (one, other) = (weigh(by_data), weigh(by_place));
        assert!(
            (one.mass - other.mass).abs() < 1e-13 * other.mass,
            "{by_data}"
        );
        assert!((one.center_of_mass() - other.center_of_mass()).norm() < 1e-13);
        assert!((one.inertia_center() - other.inertia_center()).amax() < 1e-13);
    }
    let pieces = linear_pieces(
        &mesh,
        &"clamp(1.2, 2.1, vertex:t)".parse().unwrap(),
        &extent,
    )
    .unwrap();
    assert!(pieces.mesh.tets.len() > mesh.tets.len());
    assert_eq!(pieces.mesh.vertex_data.len(), 1);
    assert!((pieces.mesh.volume() - mesh.volume()).abs() < 1e-14);
}

#[test]
fn ramps_and_clamps_that_make_no_sense_are_refused_by_name() {
    for (text, part) in [
        (
            "ramp:direction=1,0,from=0,to=1,low=1,high=2",
            "`1,0` is no direction",
        ),
        (
            "ramp:direction=0,0,0,from=0,to=1,low=1,high=2",
            "direction has no length",
        ),
        (
            "ramp:direction=1,0,0,from=1,to=1,low=1,high=2",
            "a ramp from 1 to 1 has no length",
        ),
        (
            "ramp:direction=1,0,0,from=0,to=1,low=1",
            "a `ramp` density needs `high`",
        ),
        (
            "ramp:from=0,to=1,low=1,high=2",
            "a `ramp` density needs `direction`",
        ),
        (
            "ramp:axis=z,from=0",
            "`axis=z` is no setting of a `ramp` density",
        ),
        (
            "ramp:direction=1,0,0,from=a,to=1,low=1,high=2",
            "`a` in `from=a` is not a finite number",
        ),
        ("clamp(1, 2)", "is written `clamp(LOW, HIGH, POLYNOMIAL)`"),
        ("clamp(1, 2, x", "is written `clamp(LOW, HIGH, POLYNOMIAL)`"),
        ("clamp(2, 1, x)", "a clamp to [2, 1] holds nothing"),
        ("clamp(nan, 1, x)", "a clamp to [NaN, 1] holds nothing"),
        ("clamp(1, 2, x*y)", "`x*y` has degree 2"),
        ("clamp(1, 2, heavy)", "`heavy` is not a density"),
    ] {
        let message = text.parse::<SolidDensity>().unwrap_err().to_string();
        assert!(message.contains(part), "{text}: {message}");
    }
}

#[test]
fn a_turned_solid_has_turned_moments_above_a_turned_plane() {
    let mesh = torus(1.0, 0.4, 24, 12);
    let turn = Rotation3::new(Vector3::new(0.4, -1.0, 0.3));
    let shift = Vector3::new(30.0, -20.0, 10.0);
    let mut moved = mesh.clone();
    for vertex in &mut moved.vertices {
        *vertex = turn * *vertex + shift;
    }
    let normal = Vector3::new(0.2, 1.0, 0.4);
    let here = cuttable(&mesh).above(&CutPlane {
        normal,
        offset: 0.1,
    });
    let there = turn * normal;
    let solid = cuttable(&moved);
    let offset = 0.1 + there.dot(&shift);
    let found = solid.above(&CutPlane {
        normal: there,
        offset,
    });
    let found = found.translated(&(solid.middle - (turn * cuttable(&mesh).middle + shift)));
    assert!(distance(&found, &here.rotated(&turn)) < 1e-13, "{found:?}");
}
