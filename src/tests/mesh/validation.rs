//! Validation of meshes: accepted solids, reported repairs, refusals.

use crate::geometry::bounds::Bounds;
use crate::mesh::report::{EdgePlace, Refusal, Tally};
use crate::mesh::shapes;
use crate::mesh::similarity::Similarity;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::VertexData;
use crate::mesh::validate::{validate_surface, validate_tets};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

/// A cube around `center`.
fn cube(center: [f64; 3], edge: f64) -> SurfaceMesh {
    let half = Vector3::repeat(edge / 2.0);
    let center = Point3::from(center);
    shapes::cuboid(&Bounds {
        min: center - half,
        max: center + half,
    })
}

fn together(parts: &[SurfaceMesh]) -> SurfaceMesh {
    let mut all = SurfaceMesh::default();
    for part in parts {
        let base = all.vertices.len() as u32;
        all.vertices.extend(&part.vertices);
        all.triangles.extend(
            part.triangles
                .iter()
                .map(|triangle| triangle.map(|v| v + base)),
        );
    }
    all
}

fn turned(mut mesh: SurfaceMesh) -> SurfaceMesh {
    mesh.triangles
        .iter_mut()
        .for_each(|triangle| triangle.swap(0, 1));
    mesh
}

fn volume_and_notes(mesh: &SurfaceMesh) -> (f64, Vec<String>) {
    let (closed, report) = validate_surface(mesh).unwrap();
    (closed.mesh().volume(), report.notes())
}

fn near(one: f64, other: f64) -> bool {
    (one - other).abs() < 1e-13 * other.abs()
}

#[test]
fn a_flipped_triangle_is_turned_back() {
    let flawless = shapes::bracket(3);
    let mut mesh = flawless.clone();
    mesh.triangles[7].swap(0, 2);
    mesh.triangles[20].swap(0, 2);
    let (closed, report) = validate_surface(&mesh).unwrap();
    assert_eq!(
        report.reoriented,
        Tally {
            count: 2,
            first: Some(7)
        }
    );
    assert!(report.notes()[0].starts_with("2 triangles were turned to agree with their neighbors"));
    assert!(near(closed.mesh().volume(), flawless.volume()));
}

#[test]
fn a_surface_inside_out_is_turned() {
    let (volume, notes) = volume_and_notes(&turned(shapes::torus(1.0, 0.25, 12, 8)));
    assert!(near(volume, shapes::torus(1.0, 0.25, 12, 8).volume()));
    assert_eq!(
        notes,
        ["1 components were turned inside out, the first at element 0"]
    );
}

/// Four cubes, one in the other and one beside, that are all closed: nothing is turned but everything
/// at once, the volume is the signed sum, and what is enclosed twice or negatively is found.
#[test]
fn closed_parts_stay_as_they_are_turned() {
    let cubes = [
        (cube([0.0; 3], 5.0), 125.0),
        (cube([0.1; 3], 3.0), 27.0),
        (cube([0.2; 3], 1.0), 1.0),
        (cube([9.0, 0.0, 0.0], 2.0), 8.0),
    ];
    for mask in 0..16 {
        let signs = [0, 1, 2, 3].map(|k: usize| if mask >> k & 1 == 1 { -1 } else { 1 });
        let parts = cubes.iter().zip(signs).map(|((mesh, _), sign)| {
            if sign < 0 {
                turned(mesh.clone())
            } else {
                mesh.clone()
            }
        });
        let (closed, report) = validate_surface(&together(&parts.collect::<Vec<_>>())).unwrap();
        let sum: f64 = cubes
            .iter()
            .zip(signs)
            .map(|(cube, s)| cube.1 * f64::from(s))
            .sum();
        assert!(near(closed.mesh().volume(), sum.abs()));
        assert_eq!((report.components, report.genus), (4, 0));
        assert_eq!(report.inverted.count, if sum < 0.0 { 4 } else { 0 });
        // The winding numbers of the four regions and their volumes.
        let [a, b, c, d] = signs.map(|sign| if sum < 0.0 { -sign } else { sign });
        let regions = [(a, 98.0), (a + b, 26.0), (a + b + c, 1.0), (d, 8.0)];
        let excess = |f: fn(i32) -> i32| -> f64 {
            regions
                .iter()
                .map(|&(w, volume)| f64::from(f(w)) * volume)
                .sum()
        };
        for (found, expected) in [
            (report.repeated, excess(|w| (w - 1).max(0))),
            (report.negative, excess(|w| (-w).max(0))),
        ] {
            let volume = found.map_or(0.0, |overlap| overlap.volume);
            assert!(
                (volume - expected).abs() < 1e-12,
                "{mask}: {volume} {expected}"
            );
        }
    }
}

/// Parts that contradict themselves, however they are mixed, are turned as they lie in each other.
#[test]
fn mixed_parts_are_turned_by_their_nesting() {
    let cubes = [
        cube([0.0; 3], 5.0),
        cube([0.1; 3], 3.0),
        cube([0.2; 3], 1.0),
        cube([9.0, 0.0, 0.0], 2.0),
    ];
    for mask in 0..16 {
        let turn = |(k, mesh): (usize, &SurfaceMesh)| {
            let mut mesh = mesh.clone();
            mesh.triangles[k].swap(0, 1);
            if mask >> k & 1 == 1 {
                turned(mesh)
            } else {
                mesh
            }
        };
        let parts: Vec<SurfaceMesh> = cubes.iter().enumerate().map(turn).collect();
        let (closed, report) = validate_surface(&together(&parts)).unwrap();
        assert_eq!((report.components, report.cavities), (4, 1));
        assert!(near(closed.mesh().volume(), 125.0 - 27.0 + 1.0 + 8.0));
        assert_eq!(report.repeated.or(report.negative), None);
        // Right as given: every cube outward but the cavity.
        let inverted = (mask ^ 0b10_usize).count_ones() as usize;
        assert_eq!(report.inverted.count, inverted);
        assert_eq!(report.reoriented.count, 4);
    }
}

#[test]
fn a_component_in_the_hole_of_a_torus_is_no_cavity() {
    let ring = shapes::torus(2.0, 0.5, 24, 12);
    let (volume, notes) = volume_and_notes(&together(&[ring.clone(), cube([0.0; 3], 0.5)]));
    assert!(notes.is_empty() && near(volume, ring.volume() + 0.125));
}

#[test]
fn duplicates_are_dropped() {
    let mut mesh = cube([0.0; 3], 2.0);
    mesh.triangles.push(mesh.triangles[4]);
    let [a, b, c] = mesh.triangles[5];
    mesh.triangles.push([c, b, a]);
    let (closed, report) = validate_surface(&mesh).unwrap();
    assert_eq!(
        report.duplicates,
        Tally {
            count: 2,
            first: Some(12)
        }
    );
    assert!(near(closed.mesh().volume(), 8.0));
    assert_eq!(closed.mesh().triangles.len(), 12);
}

#[test]
fn two_cubes_glued_by_a_doubled_wall_become_one_solid() {
    let tets = shapes::unit_cube_tets(2);
    let half = |upper: bool| {
        let sum =
            |tet: &[u32; 4]| -> f64 { tet.iter().map(|&v| tets.vertices[v as usize].x).sum() };
        let mut part = tets.clone();
        part.tets.retain(|tet| (sum(tet) > 2.0) == upper);
        part.boundary()
    };
    let mesh = together(&[half(false), half(true)]);
    // Apart they are two closed solids that touch, welded they have a doubled wall.
    assert_eq!(validate_surface(&mesh).unwrap().1.components, 2);
    let mut text = mesh.clone();
    text.triangles.clear();
    let find = |point: &Point3<f64>| {
        mesh.vertices
            .iter()
            .position(|other| other == point)
            .unwrap() as u32
    };
    text.triangles = mesh
        .all_corners()
        .map(|corners| corners.each_ref().map(find))
        .collect();
    let (closed, report) = validate_surface(&text).unwrap();
    assert_eq!((report.components, report.cancelled.count), (1, 16));
    assert!(near(closed.mesh().volume(), 1.0));
}

#[test]
fn an_inner_wall_is_refused() {
    let mut mesh = cube([0.0; 3], 1.0);
    let [a, b, _] = mesh.triangles[0];
    let d = *(0..8)
        .collect::<Vec<u32>>()
        .iter()
        .find(|&&v| {
            (mesh.vertices[v as usize] + mesh.vertices[a as usize].coords)
                .coords
                .norm()
                < 1e-9
        })
        .unwrap();
    mesh.triangles.push([a, b, d]);
    mesh.triangles.push([b, a, d]);
    mesh.triangles.push([a, b, 7 - b]);
    let outcome = validate_surface(&mesh);
    assert!(
        matches!(
            outcome,
            Err(Refusal::Open { .. } | Refusal::NonManifold { .. })
        ),
        "{outcome:?}"
    );
}

#[test]
fn cubes_that_share_an_edge_or_a_vertex_are_accepted_and_told() {
    let one = cube([0.0; 3], 2.0);
    for (center, touching) in [([2.0, 2.0, 0.0], 1), ([2.0; 3], 0)] {
        let mut mesh = together(&[one.clone(), cube(center, 2.0)]);
        let find = |point: &Point3<f64>| {
            mesh.vertices
                .iter()
                .position(|other| other == point)
                .unwrap() as u32
        };
        mesh.triangles = mesh
            .all_corners()
            .map(|corners| corners.each_ref().map(find))
            .collect();
        let (closed, report) = validate_surface(&mesh).unwrap();
        assert_eq!((report.components, report.touching.count), (2, touching));
        assert!(near(closed.mesh().volume(), 16.0));
        assert_eq!(
            closed.mesh().vertices.len(),
            if touching == 1 { 14 } else { 15 }
        );
    }
}

#[test]
fn one_sided_surfaces_are_refused() {
    // A torus grid whose seam is glued with a reflection: a Klein bottle.
    let (around, across) = (12, 9);
    let mut mesh = shapes::torus(2.0, 0.5, around, across);
    let seam = (around - 1) * across;
    for triangle in &mut mesh.triangles {
        if triangle.iter().any(|&v| v >= seam) && triangle.iter().any(|&v| v < across) {
            *triangle = triangle.map(|v| if v < across { (across - v) % across } else { v });
        }
    }
    let refusal = validate_surface(&mesh).unwrap_err();
    assert!(matches!(refusal, Refusal::OneSided { .. }), "{refusal}");
    assert!(refusal.to_string().contains("Klein bottle"));
}

#[test]
fn holes_are_counted() {
    let mut mesh = shapes::icosphere(2);
    mesh.triangles.remove(100);
    let Err(Refusal::Open { count, first }) = validate_surface(&mesh) else {
        panic!("it is open")
    };
    assert_eq!(count, 3);
    let EdgePlace {
        vertices: [from, to],
        triangle,
    } = first;
    let corners = mesh.triangles[triangle as usize];
    assert!(corners.contains(&from) && corners.contains(&to));
}

#[test]
fn triangle_soup_is_merged_only_if_it_must_be() {
    let mesh = shapes::icosphere(1);
    let vertices: Vec<Point3<f64>> = mesh.all_corners().flatten().collect();
    let triangles = (0..mesh.triangles.len() as u32)
        .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
        .collect();
    let (closed, report) = validate_surface(&SurfaceMesh {
        vertices,
        triangles,
    })
    .unwrap();
    assert_eq!(report.welded, 240 - 42);
    assert_eq!(closed.mesh().vertices.len(), 42);
    assert!(near(closed.mesh().volume(), mesh.volume()));
}

#[test]
fn collapsed_and_flat_triangles_and_lost_vertices_are_told() {
    let mut mesh = cube([0.0; 3], 1.0);
    // Split the diagonal of the first face at its middle: two triangles become four; then a
    // T-vertex filled by a flat triangle on the other side.
    let [a, b, c] = mesh.triangles[0];
    mesh.vertices.push(nalgebra::center(
        &mesh.vertices[a as usize],
        &mesh.vertices[c as usize],
    ));
    mesh.triangles[0] = [a, b, 8];
    mesh.triangles.push([8, b, c]);
    mesh.triangles.push([a, 8, c]);
    mesh.triangles.push([a, a, b]);
    mesh.vertices.push(Point3::new(50.0, 0.0, 0.0));
    let (closed, report) = validate_surface(&mesh).unwrap();
    assert_eq!(
        report.flat,
        Tally {
            count: 1,
            first: Some(13)
        }
    );
    assert_eq!(
        report.collapsed,
        Tally {
            count: 1,
            first: Some(14)
        }
    );
    assert_eq!(
        report.isolated,
        Tally {
            count: 1,
            first: Some(9)
        }
    );
    assert_eq!(report.notes().len(), 3);
    assert!(near(closed.mesh().volume(), 1.0));
    assert!(near(mesh.bounds().max.x, 0.5));
}

#[test]
fn surfaces_without_inside_are_refused() {
    let pillow = SurfaceMesh {
        vertices: vec![
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, 1.0, 0.0),
            Point3::new(0.1, 0.1, 0.0),
        ],
        triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]],
    };
    assert_eq!(validate_surface(&pillow).unwrap_err(), Refusal::Flat);
    assert_eq!(
        validate_surface(&SurfaceMesh::default()).unwrap_err(),
        Refusal::Empty("triangles")
    );
    let mut mesh = cube([0.0; 3], 1.0);
    mesh.triangles[3][1] = 8;
    assert_eq!(
        validate_surface(&mesh).unwrap_err(),
        Refusal::OutOfRange {
            element: 3,
            vertex: 8,
            vertices: 8
        }
    );
    let mut mesh = cube([0.0; 3], 1.0);
    mesh.vertices[2].y = f64::NAN;
    assert_eq!(validate_surface(&mesh).unwrap_err(), Refusal::NotFinite(2));
    let thin = shapes::cuboid(&Bounds {
        min: Point3::origin(),
        max: Point3::new(1.0, 1.0, 1e-9),
    });
    assert!(validate_surface(&thin).is_ok());
}

#[test]
fn crossing_parts_are_told_touching_ones_not() {
    let report = |mesh: &SurfaceMesh| validate_surface(mesh).unwrap().1;
    let common = |center: [f64; 3]| {
        let report = report(&together(&[cube([0.0; 3], 2.0), cube(center, 2.0)]));
        assert_eq!(report.negative, None);
        let volume = report.repeated.map_or(0.0, |overlap| overlap.volume);
        let expected: f64 = center
            .iter()
            .map(|shift| (2.0 - shift.abs()).max(0.0))
            .product();
        assert!((volume - expected).abs() < 1e-14, "{volume} {expected}");
        report.repeated
    };
    for apart in [[2.0, 0.3, 0.1], [2.0, 0.0, 0.0], [2.0; 3], [5.0, 0.0, 0.0]] {
        assert_eq!(common(apart), None);
    }
    for near in [
        [0.7, 0.3, 0.1],
        [1.0; 3],
        [0.5, 0.0, 0.0],
        [0.0, 1.0, 1.0],
        [0.0; 3],
    ] {
        let place = common(near).unwrap().place;
        let inside = |at: f64, shift: f64| at.abs() < 1.0 && (at - shift).abs() < 1.0;
        assert!(
            (0..3).all(|axis| inside(place[axis], near[axis])),
            "{place}"
        );
    }
    // A ridge on a ridge.
    let turned = |mut mesh: SurfaceMesh, turn: fn([f64; 3]) -> [f64; 3]| {
        for vertex in &mut mesh.vertices {
            *vertex = Point3::from(turn((*vertex).into()));
        }
        mesh
    };
    let lower = turned(cube([0.0; 3], 2.0), |[x, y, z]| {
        [x - z, 4.0 * y, x + z - 2.0]
    });
    let upper = turned(cube([0.0; 3], 2.0), |[x, y, z]| {
        [4.0 * y, z - x, x + z + 2.0]
    });
    assert_eq!(report(&together(&[lower, upper])).repeated, None);
    assert_eq!(report(&shapes::trefoil(0.4, 120, 12)).repeated, None);
    let crossed = report(&shapes::trefoil(0.9, 120, 12));
    assert!(crossed.repeated.unwrap().volume > 0.0);
    assert!(crossed.notes()[0].contains("Boolean union"));
}

#[test]
fn tetrahedra_are_turned_dropped_and_told() {
    let mut mesh = shapes::unit_cube_tets(2);
    let count = mesh.tets.len();
    let values = (0..27).map(f64::from).collect();
    mesh.vertex_data.push(VertexData::new("density", values));
    mesh.vertices.insert(0, Point3::new(9.0, 9.0, 9.0));
    mesh.vertex_data[0].values.insert(0, -1.0);
    mesh.tets
        .iter_mut()
        .flatten()
        .for_each(|vertex| *vertex += 1);
    mesh.tets[5].swap(2, 3);
    mesh.tets.push([1, 2, 3, 3]);
    mesh.tets.push([1, 2, 3, 4]);
    let [a, b, c, d] = mesh.tets[0];
    mesh.tets.push([b, a, c, d]);
    let (valid, report) = validate_tets(&mesh).unwrap();
    assert_eq!(
        report.inverted,
        Tally {
            count: 1,
            first: Some(5)
        }
    );
    assert_eq!(report.flat.count, 2);
    assert_eq!(
        report.duplicates,
        Tally {
            count: 1,
            first: Some(count as u32 + 2)
        }
    );
    assert_eq!(
        report.isolated,
        Tally {
            count: 1,
            first: Some(0)
        }
    );
    assert_eq!(report.notes().len(), 4);
    assert!(near(valid.mesh().data("density").unwrap()[26], 26.0));
    assert!(
        valid
            .mesh()
            .all_corners()
            .all(|c| crate::mesh::tets::tet_volume(&c) > 0.0)
    );
    assert!(near(valid.mesh().volume(), 1.0));
}

#[test]
fn tetrahedra_that_fill_nothing_or_overlap_are_refused() {
    let mut mesh = shapes::unit_cube_five_tets();
    assert_eq!(
        validate_tets(&mesh).unwrap().1.notes(),
        Vec::<String>::new()
    );
    mesh.vertices.push(Point3::new(0.4, 0.4, 0.4));
    mesh.tets.push([1, 2, 4, 8]);
    let refusal = validate_tets(&mesh).unwrap_err();
    assert!(
        matches!(refusal, Refusal::Overlap { count: 1, .. }),
        "{refusal}"
    );
    mesh.tets = vec![[0, 1, 2, 3]];
    assert_eq!(validate_tets(&mesh).unwrap_err(), Refusal::Flat);
    mesh.tets = vec![[0, 1, 2, 4]];
    let (one, _) = validate_tets(&mesh).unwrap();
    assert_eq!(
        (
            one.mesh().vertices.len(),
            one.mesh().boundary().triangles.len()
        ),
        (4, 4)
    );
}

#[test]
fn fitting_keeps_the_shape() {
    let mut mesh = shapes::trefoil(0.4, 60, 8);
    let (volume, height) = (mesh.volume(), mesh.bounds().extent().z);
    let map = Similarity::into_unit_cube(&mesh.bounds());
    map.move_all(&mut mesh.vertices);
    let bounds = mesh.bounds();
    assert!(near(bounds.extent().max(), 1.0) && near(mesh.volume(), volume * map.scale.powi(3)));
    assert!((bounds.center() - Point3::new(0.5, 0.5, 0.5)).norm() < 1e-15);
    let map = Similarity::to_unit_height(&bounds, 2);
    map.move_all(&mut mesh.vertices);
    assert!(
        near(mesh.bounds().extent().z, 1.0) && bounds.extent().z * map.scale > 0.99 && height > 0.0
    );
    assert!(mesh.bounds().min.coords.norm() < 1e-15);
    let target = Bounds {
        min: Point3::new(1.0, 2.0, 3.0),
        max: Point3::new(9.0, 4.0, 9.0),
    };
    Similarity::into_box(&mesh.bounds(), &target).move_all(&mut mesh.vertices);
    let slack = target.extent() - mesh.bounds().extent();
    assert!(slack.min().abs() < 1e-14 && slack.iter().all(|&slack| slack > -1e-14));
}

proptest! {
    /// Any turns of triangles and any order of them give the same solid.
    #[test]
    fn orientation_is_found_from_any_start(turns in proptest::collection::vec(any::<bool>(), 96), shift in 0..96_usize) {
        let flawless = shapes::torus(1.0, 0.4, 8, 6);
        let mut mesh = flawless.clone();
        for (triangle, turn) in mesh.triangles.iter_mut().zip(&turns) {
            if *turn {
                triangle.swap(0, 1);
            }
        }
        mesh.triangles.rotate_left(shift);
        let (closed, report) = validate_surface(&mesh).unwrap();
        prop_assert!(near(closed.mesh().volume(), flawless.volume()));
        let count = turns.iter().filter(|&&turn| turn).count();
        prop_assert_eq!(report.reoriented.count, count.min(96 - count));
    }
}
