//! The shared mesh of L∞ cells: volumes, closed cells, and faces that are the same from both sides.

use std::collections::BTreeMap;

use crate::complex::linf_mesh::linf_mesh;
use crate::domain::cuboid::Cuboid;
use crate::domain::shape::DomainShape;
use crate::geometry::bounds::Bounds;
use crate::geometry::random::Random;
use crate::mesh::poly_mesh::PolyMesh;
use crate::tests::sites::{grid_sites, random_sites};
use crate::voronoi::diagram::Diagram;
use crate::voronoi::linf::cell::Ties;
use nalgebra::Point3;

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
        let mesh = linf_mesh(&domain, &sites).unwrap_or_else(|| panic!("{name}: no mesh"));
        let name = format!("{name} of {}", sites.len());
        assert_eq!(mesh.cell_count, sites.len());
        assert_eq!(open_edges(&mesh), 0, "{name}");
        let diagram = Diagram::new(&domain, &sites).expect("a diagram");
        let cells = diagram.map_linf(Ties::ToSmallerIndex, |(): &mut (), cell| cell.volume());
        for (found, volume) in volumes(&mesh, &sites).iter().zip(cells.expect("cells")) {
            assert!(
                (found - volume).abs() < 1e-13 * domain.volume(),
                "{name}: {found} {volume}"
            );
        }
        if name.starts_with("lattice") {
            assert_eq!((mesh.face_count(), mesh.points.len()), (3 * 9 * 4, 64));
        }
    }
}

#[test]
fn tied_cells_and_sites_of_one_place_have_no_shared_mesh() {
    let level = [[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]].map(Point3::from);
    assert!(linf_mesh(&Cuboid::unit(), &level).is_none());
    let close = [[0.25, 0.5, 0.5], [0.25 + 1e-16, 0.5, 0.5]].map(Point3::from);
    assert!(linf_mesh(&Cuboid::unit(), &close).is_none());
}
