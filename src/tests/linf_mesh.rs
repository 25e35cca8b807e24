//! The shared mesh of L∞ cells: volumes, closed cells, and faces that are the same from both sides.

use std::collections::BTreeMap;

use crate::complex::linf_mesh::linf_mesh;
use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::shape::DomainShape;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::random::Random;
use crate::mesh::poly_mesh::PolyMesh;
use crate::tests::sites::{grid_sites, random_sites};
use crate::voronoi::diagram::Diagram;
use crate::voronoi::linf::cell::Ties;
use nalgebra::{Point3, Rotation3, Vector3};

fn jittered(count: usize, noise: f64) -> Vec<Point3<f64>> {
    let mut random = Random::new(11);
    let mut moved = |x: f64| x + noise * (2.0 * random.uniform() - 1.0);
    let sites = grid_sites(count).into_iter();
    sites
        .map(|site| Point3::from(site.coords.map(&mut moved)))
        .collect()
}

/// The volumes of the cells by the divergence sum over their faces, fanned from their first corners.
fn volumes(mesh: &PolyMesh, sites: &[Point3<f64>]) -> Vec<f64> {
    let mut volumes = vec![0.0; mesh.cell_count];
    let mut add = |cell: usize, face: usize, sign: f64| {
        let places: Vec<_> = mesh.face_places(face).map(|at| at - sites[cell]).collect();
        for pair in places[1..].windows(2) {
            volumes[cell] += sign * places[0].dot(&pair[0].cross(&pair[1])) / 6.0;
        }
    };
    for face in 0..mesh.face_count() {
        add(mesh.owner[face] as usize, face, 1.0);
        if let Some(cell) = mesh.neighbor_of(face) {
            add(cell, face, -1.0);
        }
    }
    volumes
}

/// How often an edge of a cell does not run once each way.
fn open_edges(mesh: &PolyMesh) -> usize {
    let mut edges: BTreeMap<(usize, [u32; 2]), i32> = BTreeMap::new();
    for (face, corners) in mesh.faces().enumerate() {
        let cells = [
            (Some(mesh.owner[face] as usize), 1),
            (mesh.neighbor_of(face), -1),
        ];
        for (cell, sign) in cells
            .into_iter()
            .filter_map(|(cell, sign)| Some((cell?, sign)))
        {
            for (&from, &to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                let turn = if from < to { sign } else { -sign };
                *edges
                    .entry((cell, [from.min(to), from.max(to)]))
                    .or_default() += turn;
            }
        }
    }
    edges.values().filter(|sum| **sum != 0).count()
}

#[test]
fn l_infinity_cells_share_their_faces_to_the_bit() {
    let unit = Cuboid::unit();
    let torus = Cuboid::new(unit.bounds(), [true, false, true]).expect("a box");
    let long = Bounds::from_corners([0.1, -0.3, 7.0], [1.9, 0.4, 7.7]);
    let long = Cuboid::new(long, [false; 3]).expect("a box");
    let moved = |site: Point3<f64>| {
        Point3::new(0.1 + 1.8 * site.x, -0.3 + 0.7 * site.y, 7.0 + 0.7 * site.z)
    };
    let away: Vec<_> = random_sites(60, 4).into_iter().map(moved).collect();
    let mut cases = vec![
        ("random", unit, random_sites(80, 3)),
        ("torus", torus, random_sites(40, 5)),
        ("away", long, away),
        ("lattice", unit, grid_sites(3)),
    ];
    for noise in [1e-15, 1e-13, 1e-10, 1e-6] {
        cases.push(("jittered", unit, jittered(3, noise)));
        cases.push(("jittered torus", torus, jittered(3, noise)));
    }
    for (name, domain, sites) in cases {
        let mesh = assert_fits(name, &domain, &sites);
        if name == "lattice" {
            assert_eq!((mesh.face_count(), mesh.points.len()), (3 * 9 * 4, 64));
        }
    }
}

/// The mesh of the cells, closed and of their volumes.
fn assert_fits(name: &str, domain: &impl DomainShape, sites: &[Point3<f64>]) -> PolyMesh {
    let name = format!("{name} of {}", sites.len());
    let mesh = linf_mesh(domain, sites).unwrap_or_else(|| panic!("{name}: no mesh"));
    assert_eq!(mesh.cell_count, sites.len());
    assert_eq!(open_edges(&mesh), 0, "{name}");
    let diagram = Diagram::new(domain, sites).expect("a diagram");
    let cells = diagram.map_linf(Ties::ToSmallerIndex, |(): &mut (), cell| cell.volume());
    for (found, volume) in volumes(&mesh, sites).iter().zip(cells.expect("cells")) {
        assert!(
            (found - volume).abs() < 1e-13 * domain.volume(),
            "{name}: {found} {volume}"
        );
    }
    mesh
}

/// Random sites of the unit cube that lie in a solid.
fn within(domain: &impl DomainShape, count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut sites = random_sites(count, seed);
    sites.retain(|site| domain.contains(site));
    sites
}

#[test]
fn l_infinity_cells_of_convex_polyhedra_share_their_faces_to_the_bit() {
    let signs = (0..8).map(|n| [0, 1, 2].map(|axis| if n >> axis & 1 == 1 { -1.0 } else { 1.0 }));
    let octahedron = signs.map(|normal| {
        let normal = Vector3::from(normal);
        HalfSpace {
            normal,
            offset: 0.5 + 0.5 * normal.sum(),
        }
    });
    let corner = [
        [1.0, 1.0, 1.0],
        [-1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, -1.0],
    ];
    let corner = corner.map(|normal| HalfSpace {
        normal: normal.into(),
        offset: f64::from(u8::from(normal[0] > 0.0)),
    });
    let turn = Rotation3::from_euler_angles(0.3, -0.5, 0.7);
    let turned = [0, 1, 2].into_iter().flat_map(|axis| {
        let normal = turn * Vector3::ith(axis, 1.0);
        [1.0, -1.0].map(|sign| HalfSpace {
            normal: normal * sign,
            offset: 0.3 + sign * 0.5 * normal.sum(),
        })
    });
    let solids = [
        ("octahedron", octahedron.collect::<Vec<_>>()),
        ("corner", corner.to_vec()),
        ("turned cube", turned.collect()),
    ];
    for (name, walls) in solids {
        let solid = ConvexPolyhedron::new(&walls).expect("a solid");
        for (count, seed) in [(6, 1), (60, 2), (600, 3)] {
            let sites = within(&solid, count, seed);
            let mesh = assert_fits(name, &solid, &sites);
            let volume: f64 = volumes(&mesh, &sites).iter().sum();
            assert!((volume / solid.volume() - 1.0).abs() < 1e-12, "{name}");
        }
        let sites = [
            jittered(5, 1e-6),
            lattice_places(7.0, 90, 8),
            level_sites(&[2], 40, 9),
        ];
        for mut sites in sites {
            sites.retain(|site| solid.contains(site));
            assert_fits(name, &solid, &sites);
        }
    }
}

/// Random sites with a coordinate in common along each of `axes`.
fn level_sites(axes: &[usize], count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut sites = random_sites(count, seed);
    for site in &mut sites {
        axes.iter().for_each(|&axis| site[axis] = 0.375);
    }
    sites
}

/// Random places of a lattice of `steps` along each axis, every one once, in random order.
fn lattice_places(steps: f64, count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut sites: Vec<Point3<f64>> = Vec::new();
    for site in random_sites(count, seed) {
        let place = Point3::from(site.coords.map(|x| ((x * steps).floor() + 0.5) / steps));
        if !sites.contains(&place) {
            sites.push(place);
        }
    }
    sites
}

#[test]
fn tied_cells_share_their_faces_to_the_bit() {
    let unit = Cuboid::unit();
    let torus = Cuboid::new(unit.bounds(), [true; 3]).expect("a box");
    let cases = [
        ("two", level_sites(&[1, 2], 2, 3)),
        ("rod", level_sites(&[0, 2], 20, 4)),
        ("sheet", level_sites(&[1], 60, 5)),
        ("few places", lattice_places(5.0, 60, 6)),
        ("many places", lattice_places(20.0, 200, 7)),
    ];
    for (name, sites) in cases {
        assert_fits(name, &unit, &sites);
        assert_fits(name, &torus, &sites);
    }
}

#[test]
fn sites_of_one_place_on_the_grid_have_no_shared_mesh() {
    let close = [[0.25, 0.5, 0.5], [0.25 + 1e-16, 0.5, 0.5]].map(Point3::from);
    assert!(linf_mesh(&Cuboid::unit(), &close).is_none());
}
