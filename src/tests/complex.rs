//! Meshes of cells: conforming, closed, exact in volume, the same for any number of threads.

use nalgebra::{Point3, Vector3};

use crate::complex::assemble::{assemble, assemble_whole, paired};
use crate::complex::collapse::collapse;
use crate::complex::edit_mesh::EditMesh;
use crate::complex::element::CellElement;
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::quality::{MeasuredMesh, MeshQuality};
use crate::complex::solid_mesh::{CleanMesh, Cleanup, clean_solid};
use crate::complex::straighten::straighten_edges;
use crate::complex::wall_patches::WallPatches;
use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::domain::shape::DomainShape;
use crate::domain::tet_mesh::TetSolid;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::random::Random;
use crate::mesh::poly_mesh::PolyMesh;
use crate::mesh::shapes::{bracket, icosphere, torus, unit_cube, unit_cube_tets};
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::surface_distance::SurfaceDistance;
use crate::mesh::validate::{validate_surface, validate_tets};
use crate::voronoi::diagram::Diagram;

fn points(seed: u64, count: usize) -> Vec<Point3<f64>> {
    let (unit, mut random) = (Cuboid::unit().bounds(), Random::new(seed));
    (0..count).map(|_| random.point(&unit)).collect()
}

/// A k×k×k lattice in the unit cube, each coordinate moved by up to ± noise.
fn lattice(k: usize, noise: f64) -> Vec<Point3<f64>> {
    let (unit, mut random) = (Cuboid::unit().bounds(), Random::new(k as u64));
    let site = |n: usize| {
        let cell = Vector3::new((n % k) as f64, (n / k % k) as f64, (n / k / k) as f64);
        let shift = random.point(&unit).coords.add_scalar(-0.5) * (2.0 * noise);
        Point3::from(cell.add_scalar(0.5) / k as f64 + shift)
    };
    (0..k * k * k).map(site).collect()
}

/// Lattices with a second site in the middle of every cube, or with three in the middles of faces.
fn centered(k: usize, offsets: &[[f64; 3]]) -> Vec<Point3<f64>> {
    let moved = |site: &Point3<f64>| {
        let shift =
            |offset: &[f64; 3]| site + (Vector3::from(*offset) - Vector3::repeat(0.25)) / k as f64;
        offsets.iter().map(shift).collect::<Vec<_>>()
    };
    lattice(k, 0.0).iter().flat_map(moved).collect()
}

fn octahedron() -> ConvexPolyhedron {
    let sign = |signs: u32, axis: u32| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
    let wall = |signs: u32| HalfSpace {
        normal: Vector3::new(sign(signs, 0), sign(signs, 1), sign(signs, 2)),
        offset: 1.0,
    };
    ConvexPolyhedron::new(&(0..8).map(wall).collect::<Vec<_>>()).unwrap()
}

fn periodic(axes: [bool; 3]) -> Cuboid {
    Cuboid::new(Cuboid::unit().bounds(), axes).unwrap()
}

fn mesh(domain: &dyn Domain, sites: &[Point3<f64>]) -> PolyMesh {
    let diagram = Diagram::new(domain, sites).unwrap();
    assemble(&diagram, &WallPatches::Each).unwrap()
}

fn quality(mesh: &PolyMesh) -> MeshQuality {
    MeshQuality::of(&MeasuredMesh::new(mesh))
}

/// A mesh that is sound, closed, and as large as the domain.
fn assert_conforms(domain: &dyn Domain, sites: &[Point3<f64>], what: &str) -> PolyMesh {
    let diagram = Diagram::new(domain, sites).unwrap();
    let mesh = assemble(&diagram, &WallPatches::Each);
    let mesh = mesh.unwrap_or_else(|error| panic!("{what}: {error}"));
    let not_balls = mesh.check_closed();
    let not_balls = not_balls.unwrap_or_else(|error| panic!("{what}: {error}"));
    assert!(not_balls.is_empty(), "{what}: {}", not_balls[0]);
    assert_eq!(mesh.cell_count, sites.len(), "{what}");
    let quality = quality(&mesh);
    let off = quality.volume / domain.volume() - 1.0;
    assert!(off.abs() < 1e-12, "{what}: volume off by {off:e}");
    assert_eq!(quality.open_cells, 0, "{what}");
    mesh
}

#[test]
fn random_cells_make_a_conforming_mesh_in_every_box() {
    for count in [1, 2, 3, 5, 20, 300] {
        for axes in 0..8 {
            let domain = periodic([0, 1, 2].map(|axis| axes >> axis & 1 == 1));
            let what = format!("{count} sites, periodic axes {axes:03b}");
            assert_conforms(&domain, &points(count as u64, count), &what);
        }
    }
    assert_conforms(&Cuboid::unit(), &points(9, 3000), "3000 sites");
}

#[test]
fn half_spaces_hold_a_conforming_mesh() {
    let solid = octahedron();
    let sites = points(4, 2000)
        .into_iter()
        .map(|p| p * 2.0 - Vector3::repeat(1.0));
    let sites: Vec<_> = sites.filter(|p| solid.contains(p)).collect();
    let mesh = assert_conforms(&solid, &sites, "octahedron");
    assert_eq!(mesh.patches.len(), 8);
}

#[test]
fn lattices_with_and_without_noise_make_a_conforming_mesh() {
    for k in [2, 5] {
        for noise in [
            0.0, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-3, 0.05,
        ] {
            let sites = lattice(k, noise / k as f64);
            assert_conforms(
                &Cuboid::unit(),
                &sites,
                &format!("cube {k}, noise {noise:e}"),
            );
            assert_conforms(
                &periodic([true; 3]),
                &sites,
                &format!("torus {k}, noise {noise:e}"),
            );
        }
    }
    let body = [[0.0; 3], [0.5; 3]];
    let face = [[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];
    for k in [3, 4] {
        for offsets in [&body[..], &face[..]] {
            let sites = centered(k, offsets);
            assert_conforms(
                &Cuboid::unit(),
                &sites,
                &format!("{} in {k}³", offsets.len()),
            );
            assert_conforms(
                &periodic([true; 3]),
                &sites,
                &format!("periodic {} in {k}³", offsets.len()),
            );
        }
    }
}

#[test]
fn degenerate_sets_make_a_conforming_mesh() {
    let on_plane = |p: Point3<f64>| Point3::new(p.x, p.y, 0.3);
    let on_line = |p: Point3<f64>| Point3::new(p.x, 0.5 * p.x, 1.0 - p.x);
    let on_wall = |p: Point3<f64>| Point3::new(p.x, p.y, p.z.round());
    let clustered = |p: Point3<f64>| Point3::from(p.coords * 1e-4);
    let on_sphere = |p: Point3<f64>| {
        let direction = p.coords.add_scalar(-0.5).normalize();
        Point3::from((direction * 0.4).add_scalar(0.5))
    };
    type Move<'a> = &'a dyn Fn(Point3<f64>) -> Point3<f64>;
    let sets: [(&str, Move<'_>); 5] = [
        ("coplanar", &on_plane),
        ("collinear", &on_line),
        ("on walls", &on_wall),
        ("clustered", &clustered),
        ("cospherical", &on_sphere),
    ];
    for (what, place) in sets {
        let sites: Vec<_> = points(7, 200).into_iter().map(place).collect();
        assert_conforms(&Cuboid::unit(), &sites, what);
    }
}

#[test]
fn an_exact_lattice_is_a_mesh_of_cubes() {
    for noise in [0.0, 4e-10] {
        let mesh = assert_conforms(&Cuboid::unit(), &lattice(10, noise), "lattice");
        assert_eq!((mesh.points.len(), mesh.face_count()), (1331, 3300));
        assert_eq!(mesh.neighbor.len(), 2700);
        let counts: Vec<_> = mesh.patches.iter().map(|patch| patch.count).collect();
        assert_eq!(counts, [100; 6]);
        let cells = mesh.cell_faces();
        let is_hexahedron = |cell: usize| {
            matches!(
                CellElement::of(&mesh, &cells, cell),
                CellElement::Hexahedron(_)
            )
        };
        assert!((0..1000).all(is_hexahedron));
        let quality = quality(&mesh);
        assert!(quality.non_orthogonality_max < 1e-4, "{quality:?}");
        assert!(quality.skewness_max < 1e-6 && quality.bad_pyramids == 0);
        assert!((quality.edge_min - 0.1).abs() < 1e-7);
    }
}

#[test]
fn the_mesh_does_not_depend_on_the_resolution() {
    let sets = [
        ("lattice", lattice(6, 0.0)),
        ("random", points(3, 400)),
        ("bcc", centered(4, &[[0.0; 3], [0.5; 3]])),
    ];
    for (what, sites) in sets {
        let domain = Cuboid::unit();
        let diagram = Diagram::new(&domain, &sites).unwrap();
        let expected = assemble(&diagram, &WallPatches::Each).unwrap();
        for resolution in [1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7] {
            let other = paired(&diagram, resolution).unwrap();
            let other = other.builder().build(&WallPatches::Each);
            let same = (other.points.len(), other.owner, other.neighbor);
            let expected = (
                expected.points.len(),
                expected.owner.clone(),
                expected.neighbor.clone(),
            );
            assert!(same == expected, "{what} {resolution:e}");
        }
    }
}

#[test]
fn a_periodic_mesh_has_pairs_of_patches_one_period_apart() {
    let mesh = mesh(&periodic([true; 3]), &points(5, 200));
    for (number, patch) in mesh.patches.iter().enumerate() {
        let (partner, way) = patch.partner.expect("no walls");
        let other = &mesh.patches[partner];
        assert_eq!(other.partner.map(|(back, _)| back), Some(number));
        assert_eq!(other.count, patch.count);
        for face in 0..patch.count {
            let here: Vec<_> = mesh.face_places(patch.start + face).collect();
            let there: Vec<_> = mesh.face_places(other.start + face).collect();
            for corner in 0..here.len() {
                // The same corner, counted the other way round.
                let back = (here.len() - corner) % here.len();
                assert!((there[back] - way - here[corner]).norm() < 1e-14);
            }
        }
    }
    let names: Vec<_> = mesh
        .patches
        .iter()
        .map(|patch| patch.name.as_str())
        .collect();
    assert!(
        names.contains(&"xmax") && names.contains(&"xmin"),
        "{names:?}"
    );
}

#[test]
fn any_number_of_threads_makes_the_same_mesh() {
    let sites = points(8, 2000);
    let make = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| mesh(&periodic([true, false, false]), &sites))
    };
    assert_eq!(make(1), make(4));
}

/// Random points of a solid.
fn points_in(solid: &dyn Domain, seed: u64, count: usize) -> Vec<Point3<f64>> {
    let mut random = Random::new(seed);
    let bounds = solid.bounds();
    let all = std::iter::repeat_with(|| random.point(&bounds));
    all.filter(|point| solid.contains(point))
        .take(count)
        .collect()
}

/// Every corner of a face on a wall lies on the surface.
fn assert_walls_on(solid: &dyn Domain, mesh: &PolyMesh) {
    let surface = solid.surface_mesh().expect("a surface");
    let planes: Vec<_> = surface
        .all_corners()
        .map(|[a, b, c]| ((b - a).cross(&(c - a)).normalize(), a))
        .collect();
    let extent = solid.bounds().extent().max();
    for face in mesh.neighbor.len()..mesh.face_count() {
        for corner in mesh.face_places(face) {
            let off = planes
                .iter()
                .map(|(normal, at)| normal.dot(&(corner - at)).abs());
            assert!(off.fold(f64::INFINITY, f64::min) < 1e-9 * extent);
        }
    }
}

#[test]
fn solids_have_conforming_meshes_of_their_volume() {
    let shapes: [(&str, SurfaceMesh, usize); 4] = [
        ("cube", unit_cube(), 6),
        ("bracket", bracket(6), 0),
        ("torus", torus(0.3, 0.12, 24, 12), 1),
        ("ball", icosphere(2), 1),
    ];
    for (what, shape, patches) in shapes {
        let solid = SurfaceSolid::new(&validate_surface(&shape).unwrap().0).unwrap();
        let sites = points_in(&solid, 2, 150);
        let groups = WallPatches::by_features(&shape, 40.0);
        let mesh = assemble(&Diagram::new(&solid, &sites).unwrap(), &groups).unwrap();
        mesh.check_closed()
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        let quality = quality(&mesh);
        let off = quality.volume / DomainShape::volume(&solid) - 1.0;
        assert!(
            off.abs() < 1e-9 && quality.open_cells == 0,
            "{what}: {off:e}"
        );
        assert!(patches == 0 || mesh.patches.len() == patches, "{what}");
        assert!(mesh.cell_count >= 150 && mesh.sites[..150].is_sorted());
        assert_walls_on(&solid, &mesh);
    }
}

#[test]
fn lattices_in_step_with_a_solid_have_conforming_meshes() {
    let solid = SurfaceSolid::new(&validate_surface(&unit_cube()).unwrap().0).unwrap();
    for k in [2, 4, 5] {
        let sites = lattice(k, 0.0);
        let patches = WallPatches::by_features(&unit_cube(), 40.0);
        let mesh = assemble(&Diagram::new(&solid, &sites).unwrap(), &patches).unwrap();
        assert_eq!(mesh.check_closed(), Ok(Vec::new()));
        assert_eq!(
            (mesh.points.len(), mesh.face_count()),
            ((k + 1).pow(3), 3 * k * k * (k + 1))
        );
        assert!((quality(&mesh).volume - 1.0).abs() < 1e-12);
    }
    let tets = unit_cube_tets(3);
    let solid = TetSolid::new(&validate_tets(&tets).unwrap().0).unwrap();
    let solid: &dyn Domain = &solid;
    let patches = WallPatches::by_features(solid.surface_mesh().unwrap(), 40.0);
    let mesh = assemble(&Diagram::new(solid, &points(6, 100)).unwrap(), &patches).unwrap();
    assert_eq!(mesh.check_closed(), Ok(Vec::new()));
    assert_eq!(mesh.patches.len(), 6);
}

#[test]
fn a_cell_in_two_pieces_becomes_two_cells() {
    // A U: the cell of the first site reaches into both arms.
    let boxes = [
        ([0.0; 3], [3.0, 1.0, 1.0]),
        ([0.0, 1.0, 0.0], [1.0, 3.0, 1.0]),
        ([2.0, 1.0, 0.0], [3.0, 3.0, 1.0]),
    ];
    let inside = |p: &Point3<f64>| {
        boxes
            .iter()
            .any(|(min, max)| Bounds::from_corners(*min, *max).contains(p))
    };
    let solid = u_shape();
    assert!((DomainShape::volume(&solid) - 7.0).abs() < 1e-12);
    let sites = [
        [0.5, 0.4, 0.5],
        [2.5, 0.4, 0.5],
        [1.5, 0.5, 0.5],
        [0.5, 1.5, 0.5],
        [0.4, 2.8, 0.5],
    ];
    assert!(sites.iter().all(|site| inside(&Point3::from(*site))));
    let mesh = assemble(&Diagram::new(&solid, &sites).unwrap(), &WallPatches::Each).unwrap();
    mesh.check_closed().unwrap();
    let volume = quality(&mesh).volume;
    assert!((volume - 7.0).abs() < 1e-9, "{volume}");
    assert_eq!(mesh.sites.len(), mesh.cell_count);
    assert!(
        mesh.cell_count > sites.len(),
        "the cell of site 4 reaches across the gap"
    );
    let whole = assemble_whole(&Diagram::new(&solid, &sites).unwrap()).unwrap();
    assert_eq!(whole.cell_count, sites.len());
}

/// A bar of 3 × 1 × 1 with two posts of height 2 on its ends.
fn u_shape() -> SurfaceSolid {
    let outline = [
        [0., 0.],
        [3., 0.],
        [3., 3.],
        [2., 3.],
        [2., 1.],
        [1., 1.],
        [1., 3.],
        [0., 3.],
    ];
    let corner = |z: f64| outline.map(|[x, y]| Point3::new(x, y, z));
    let vertices: Vec<_> = corner(0.0).into_iter().chain(corner(1.0)).collect();
    let caps = [
        [0, 1, 4],
        [1, 2, 4],
        [2, 3, 4],
        [0, 4, 5],
        [0, 5, 7],
        [5, 6, 7],
    ];
    let bottom = caps.map(|[a, b, c]| [a, c, b]);
    let top = caps.map(|cap| cap.map(|corner| corner + 8));
    let sides = (0..8_u32).flat_map(|k| {
        let next = (k + 1) % 8;
        [[k, next, next + 8], [k, next + 8, k + 8]]
    });
    let triangles: Vec<_> = bottom.into_iter().chain(top).chain(sides).collect();
    SurfaceSolid::from_arrays(&vertices, &triangles).unwrap()
}

#[test]
fn collapse_keeps_the_volume_and_makes_hexahedra_of_a_disturbed_lattice() {
    let mesh = mesh(&Cuboid::unit(), &lattice(4, 0.01));
    let count = |mesh: &PolyMesh| {
        let cells = mesh.cell_faces();
        let elements = (0..mesh.cell_count).map(|cell| CellElement::of(mesh, &cells, cell));
        let hexahedra = elements.filter(|element| matches!(element, CellElement::Hexahedron(_)));
        hexahedra.count()
    };
    assert_eq!(count(&mesh), 0);
    let before = quality(&mesh);
    let mut edited = EditMesh::of(&mesh);
    assert_eq!(edited.finish(), mesh, "nothing is changed");
    let (collapsed, _) = collapse(&mut edited, 0.3 * 0.25, None);
    assert!(collapsed > 100, "{collapsed}");
    straighten_edges(&mut edited, 0.15 * 0.25);
    let mesh = edited.finish();
    assert_eq!(mesh.check_closed(), Ok(Vec::new()));
    let quality = quality(&mesh);
    assert!((quality.volume - 1.0).abs() < 1e-12);
    assert_eq!((quality.open_cells, quality.bad_pyramids), (0, 0));
    assert!(quality.edge_min > before.edge_min && quality.non_orthogonality_max < 45.0);
    assert!(count(&mesh) >= 32, "{} hexahedra of 64", count(&mesh));
}

/// The clean mesh of cells of random sites in a solid, after two of Lloyd's steps.
fn clean(shape: &SurfaceMesh, count: usize, collapse: f64) -> (SurfaceSolid, CleanMesh) {
    let solid = SurfaceSolid::new(&validate_surface(shape).unwrap().0).unwrap();
    let mut sites = points_in(&solid, 2, count);
    for _ in 0..2 {
        let mesh = mesh_in_pieces(&solid, &sites);
        let cells = mesh.cell_faces();
        let centers = MeshGeometry::of(&mesh, &cells).cell_centers;
        for (site, center) in sites.iter_mut().zip(centers) {
            *site = if solid.contains(&center) {
                center
            } else {
                *site
            };
        }
    }
    let patches = WallPatches::by_features(solid.surface(), 40.0);
    let cleanup = Cleanup {
        collapse,
        angle: 40.0,
        joins_slivers: true,
    };
    let diagram = Diagram::new(&solid, &sites).unwrap();
    let clean = clean_solid(&diagram, solid.surface(), &patches, cleanup).unwrap();
    (solid, clean)
}

fn mesh_in_pieces(solid: &SurfaceSolid, sites: &[Point3<f64>]) -> PolyMesh {
    assemble(&Diagram::new(solid, sites).unwrap(), &WallPatches::Each).unwrap()
}

#[test]
fn walls_of_solids_become_few_polygons_and_no_cell_is_bad() {
    let shapes: [(&str, SurfaceMesh, f64); 4] = [
        ("cube", unit_cube(), 1e-12),
        ("bracket", bracket(6), 0.012),
        ("torus", torus(0.3, 0.12, 24, 12), 0.012),
        ("ball", icosphere(2), 0.012),
    ];
    for (what, shape, lost) in shapes {
        let shares = if what == "torus" {
            &[0.0, 0.1][..]
        } else {
            &[0.1]
        };
        for &collapse in shares {
            let (solid, clean) = clean(&shape, 120, collapse);
            let mesh = clean.mesh;
            assert_eq!(mesh.check_closed(), Ok(Vec::new()), "{what}");
            assert!(
                clean.too_coarse.is_empty(),
                "{what}: {:?}",
                clean.too_coarse
            );
            let quality = quality(&mesh);
            assert_eq!((quality.bad_pyramids, quality.open_cells), (0, 0), "{what}");
            let skewness = quality.skewness_max.max(quality.skewness_wall_max);
            assert!(
                skewness <= 4.0 && quality.non_orthogonality_max < 70.0,
                "{what}: {quality:?}"
            );
            let off = 1.0 - quality.volume / DomainShape::volume(&solid);
            assert!(off.abs() <= lost, "{what}: {off:e}");
            assert!(
                (120..=126).contains(&mesh.cell_count),
                "{what}: {}",
                mesh.cell_count
            );
            let (distance, mut hint) = (SurfaceDistance::new(solid.surface()), 0);
            let extent = DomainShape::bounds(&solid).extent().max();
            for face in mesh.neighbor.len()..mesh.face_count() {
                for corner in mesh.face_places(face) {
                    assert!(distance.at(&corner, &mut hint) < 1e-9 * extent, "{what}");
                }
            }
        }
    }
}

#[test]
fn a_cell_around_a_reentrant_edge_is_cut_along_the_wall() {
    let solid = u_shape();
    let sites = [
        [0.5, 0.4, 0.5],
        [2.5, 0.4, 0.5],
        [1.0, 0.9, 0.5],
        [0.5, 1.7, 0.5],
        [0.5, 2.6, 0.5],
        [2.5, 1.7, 0.5],
        [2.5, 2.6, 0.5],
    ];
    let diagram = Diagram::new(&solid, &sites).unwrap();
    let raw = mesh_in_pieces(&solid, &sites.map(Point3::from));
    assert!(
        quality(&raw).bad_pyramids > 0,
        "cells wrap around the inner edges"
    );
    let patches = WallPatches::by_features(solid.surface(), 40.0);
    let cleanup = Cleanup {
        collapse: 0.1,
        angle: 40.0,
        joins_slivers: true,
    };
    let clean = clean_solid(&diagram, solid.surface(), &patches, cleanup).unwrap();
    let quality = quality(&clean.mesh);
    assert_eq!(clean.mesh.check_closed(), Ok(Vec::new()));
    assert!(clean.mesh.cell_count > sites.len());
    assert_eq!(quality.bad_pyramids, 0, "{quality:?}");
    assert!(
        (quality.volume - 7.0).abs() < 1e-9,
        "planar walls lose nothing: {}",
        quality.volume
    );
    assert_eq!(clean.mesh.patches.len(), 10);
}

#[test]
fn edges_across_periods_collapse_in_pairs() {
    let raw = mesh(&periodic([true, true, false]), &lattice(5, 0.02));
    let mut edited = EditMesh::of(&raw);
    assert_eq!(edited.finish(), raw, "nothing is changed");
    let (collapsed, _) = collapse(&mut edited, 0.3 * 0.2, None);
    straighten_edges(&mut edited, 0.15 * 0.2);
    let mesh = edited.finish();
    assert!(collapsed > 200 && mesh.face_count() < raw.face_count());
    assert_eq!(mesh.check_closed(), Ok(Vec::new()));
    let quality = quality(&mesh);
    assert!((quality.volume - 1.0).abs() < 1e-12 && quality.open_cells == 0);
    for patch in &mesh.patches {
        let Some((partner, way)) = patch.partner else {
            continue;
        };
        let other = &mesh.patches[partner];
        assert_eq!(
            (other.count, other.partner.map(|(_, back)| -back)),
            (patch.count, Some(way))
        );
        for face in 0..patch.count {
            let here: Vec<_> = mesh.face_places(patch.start + face).collect();
            let there: Vec<_> = mesh.face_places(other.start + face).collect();
            assert_eq!(here.len(), there.len());
            for (corner, place) in here.iter().enumerate() {
                let back = (here.len() - corner) % here.len();
                assert!((there[back] - way - place).norm() < 1e-13);
            }
        }
    }
}

#[test]
fn whatever_is_undone_leaves_no_trace() {
    let raw = mesh(&periodic([true, false, false]), &points(4, 60));
    let mut edited = EditMesh::of(&raw);
    let volume = edited.volume();
    for (a, b) in edited.edges().into_iter().step_by(7) {
        if edited.copies_of(a).contains(&b) {
            continue;
        }
        let mark = edited.mark();
        let place = edited.points[b as usize];
        edited.collapse_edge(a, b, place);
        edited.undo_to(mark);
    }
    assert_eq!(edited.finish(), raw);
    assert!((edited.volume() - volume).abs() < 1e-14);
}

#[test]
fn any_number_of_threads_cleans_a_solid_alike() {
    let make = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new();
        let pool = pool.num_threads(threads).build().unwrap();
        pool.install(|| clean(&bracket(4), 80, 0.1).1.mesh)
    };
    assert_eq!(make(1), make(3));
}
