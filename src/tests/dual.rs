//! The dual of cells: hexahedra of lattices, positive Jacobians, conformity, walls and features.

use nalgebra::Point3;

use crate::complex::assemble::assemble;
use crate::complex::collapse::collapse;
use crate::complex::divide::divide;
use crate::complex::dual::{DualAnchor, DualMesh, FeatureTurns};
use crate::complex::edit_mesh::EditMesh;
use crate::complex::element::{CellElement, KINDS, scaled_jacobian};
use crate::complex::element_mesh::ElementMesh;
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::jacobian::least_jacobian;
use crate::complex::merge_flat::merge_flat;
use crate::complex::straighten_all::without_chains;
use crate::complex::untangle::untangle;
use crate::complex::wall_patches::WallPatches;
use crate::domain::cuboid::Cuboid;
use crate::mesh::poly_mesh::PolyMesh;
use crate::relax::relaxation::random_sites;
use crate::voronoi::diagram::Diagram;

/// The mesh of the cells of sites in the unit cube, edges up to `reach` collapsed.
fn cells(sites: &[Point3<f64>], reach: f64) -> PolyMesh {
    let cube = Cuboid::unit();
    let diagram = Diagram::new(&cube, sites).expect("sites in the cube");
    let mesh = assemble(&diagram, &WallPatches::Box).expect("a mesh");
    let mut edited = EditMesh::of(&mesh);
    collapse(&mut edited, reach, None);
    without_chains(&edited.finish(), 40.0)
}

fn elements(sites: &[Point3<f64>], reach: f64) -> (DualMesh, ElementMesh) {
    let mut dual = DualMesh::of(&cells(sites, reach), sites, FeatureTurns::Beyond(40.0));
    merge_flat(&mut dual);
    let mut mesh = divide(&dual.mesh);
    let bad = untangle(&mut mesh, &dual.anchors, None);
    assert_eq!(bad, Vec::<usize>::new());
    (dual, mesh)
}

fn volume(mesh: &PolyMesh) -> f64 {
    let geometry = MeshGeometry::of(mesh, &mesh.cell_faces());
    geometry.cell_volumes.iter().sum()
}

#[test]
fn the_dual_of_a_lattice_is_a_lattice_of_hexahedra_that_reaches_the_walls() {
    let third = |n: usize| (n % 3) as f64 / 3.0 + 1.0 / 6.0;
    let site = |n: usize| Point3::new(third(n), third(n / 3), third(n / 9));
    let (dual, mesh) = elements(&(0..27).map(site).collect::<Vec<_>>(), 0.0);
    assert_eq!(mesh.elements.len(), 64);
    assert_eq!(mesh.points.len(), 125);
    let is_hexahedron = |element: &CellElement| matches!(element, CellElement::Hexahedron(_));
    assert!(mesh.elements.iter().all(is_hexahedron));
    let count = |wanted: fn(&DualAnchor) -> bool| dual.anchors.iter().filter(|a| wanted(a)).count();
    assert_eq!(count(|anchor| *anchor == DualAnchor::Site), 27);
    assert_eq!(count(|anchor| matches!(anchor, DualAnchor::Wall(_))), 54);
    assert_eq!(count(|anchor| matches!(anchor, DualAnchor::Feature(_))), 36);
    assert_eq!(count(|anchor| *anchor == DualAnchor::Corner), 8);
    let faces = mesh.by_faces();
    assert_eq!(faces.check_closed(), Ok(Vec::new()));
    assert!((volume(&faces) - 1.0).abs() < 1e-14);
    let names: Vec<&str> = faces
        .patches
        .iter()
        .map(|patch| patch.name.as_str())
        .collect();
    assert_eq!(names, ["xmin", "xmax", "ymin", "ymax", "zmin", "zmax"]);
    assert!(faces.patches.iter().all(|patch| patch.count == 16));
}

#[test]
fn elements_of_any_sites_conform_fill_the_cube_and_are_positive_everywhere() {
    for (seed, reach) in [(1, 0.0), (2, 0.05), (3, 0.1)] {
        let sites = random_sites(&Cuboid::unit(), 60, seed).expect("sites");
        let (dual, mesh) = elements(&sites, reach);
        // Its cells are closed balls, and every face is of two elements or on a wall.
        let faces = mesh.by_faces();
        assert_eq!(faces.check_closed(), Ok(Vec::new()), "seed {seed}");
        assert_eq!(faces.cell_count, mesh.elements.len());
        assert!((volume(&faces) - 1.0).abs() < 1e-12, "seed {seed}");
        assert!((volume(&dual.mesh) - 1.0).abs() < 1e-12, "seed {seed}");
        for element in &mesh.elements {
            assert!(least_jacobian(&mesh.points, element) > 0.0, "{element:?}");
            assert!(element.kind() < KINDS.len() - 1);
        }
        let area = |wall: &(Vec<u32>, u32)| wall.0.len() - 2;
        let triangles: usize = mesh.walls.iter().map(area).sum();
        let walls = faces.face_count() - faces.neighbor.len();
        assert!(walls == mesh.walls.len() && triangles >= walls);
    }
}

#[test]
fn scaled_jacobians_of_a_sheared_cube_are_the_sine_of_its_angle() {
    let mut mesh = PolyMesh::default();
    let shear = 0.3_f64;
    let corners = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    mesh.points.extend(corners.map(Point3::from));
    mesh.points
        .extend(corners.map(|[x, y, _]| Point3::new(x + shear, y, 1.0)));
    let wanted = 1.0 / (1.0 + shear * shear).sqrt();
    let found = scaled_jacobian(&mesh, &[0, 1, 2, 3, 4, 5, 6, 7]);
    assert!((found - wanted).abs() < 1e-15, "{found} {wanted}");
}
