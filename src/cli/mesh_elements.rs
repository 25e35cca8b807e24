//! The hexahedra of `chebloyd mesh --elements hexes`, and the formats that take elements only.

use std::collections::BTreeSet;
use std::path::Path;

use nalgebra::Point3;

use crate::cli::failure::Failure;
use crate::complex::divide::divide;
use crate::complex::dual::{DualMesh, FeatureTurns};
use crate::complex::element::{CellElement, scaled_jacobian};
use crate::complex::element_mesh::ElementMesh;
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::merge_flat::{join_bad, merge_flat};
use crate::complex::straighten_all::without_chains;
use crate::complex::untangle::{balance, project, untangle};
use crate::complex::wall_patches::WallPatches;
use crate::complex::wall_projection::WallProjection;
use crate::domain::shape::DomainShape;
use crate::export::abaqus::write_abaqus;
use crate::export::gmsh::write_gmsh;
use crate::export::medit::write_medit;
use crate::export::mesh_vtu::CellColumn;
use crate::export::su2::write_su2;
use crate::mesh::poly_mesh::PolyMesh;

/// Formats of elements: option, file.
const ELEMENT_FORMATS: [(&str, &str); 4] = [
    ("msh", "mesh.msh"),
    ("inp", "mesh.inp"),
    ("medit", "mesh.mesh"),
    ("su2", "mesh.su2"),
];

/// How far a corner of the mesh may be from one of the surface, in sides of the mean cell: cleaning puts a
/// vertex there to 1e-5.
const CORNER_REACH: f64 = 1e-4;

/// How often cells are joined where elements stay inverted.
const JOINS: usize = 8;

/// The file of a format of elements.
pub(crate) fn file_of(format: &str) -> Option<&'static str> {
    let found = ELEMENT_FORMATS.iter().find(|(known, _)| *known == format);
    found.map(|(_, name)| *name)
}

/// The data of elements: volumes, and scaled Jacobians of the hexahedra, zero elsewhere.
pub(crate) fn element_columns(
    mesh: &PolyMesh,
    geometry: &MeshGeometry,
) -> Vec<(&'static str, CellColumn)> {
    let cells = mesh.cell_faces();
    let jacobian = |cell| match CellElement::of(mesh, &cells, cell) {
        CellElement::Hexahedron(corners) => scaled_jacobian(mesh, &corners),
        _ => 0.0,
    };
    let jacobians = (0..mesh.cell_count).map(jacobian).collect();
    vec![
        ("volume", CellColumn::Reals(geometry.cell_volumes.clone())),
        ("scaled_jacobian", CellColumn::Reals(jacobians)),
    ]
}

/// Writes a mesh of elements in one of [`ELEMENT_FORMATS`].
pub(crate) fn write_elements(
    output: &Path,
    format: &str,
    mesh: &ElementMesh,
) -> Result<(), Failure> {
    let Some(name) = file_of(format) else {
        return Ok(());
    };
    let path = output.join(name);
    std::fs::create_dir_all(output)
        .and_then(|()| match format {
            "msh" => write_gmsh(&path, mesh),
            "inp" => write_abaqus(&path, mesh),
            "medit" => write_medit(&path, mesh),
            _ => write_su2(&path, mesh),
        })
        .map_err(|error| Failure::run(format!("cannot write {}: {error}", path.display())))
}

/// The hexahedra, prisms, pyramids and tetrahedra with corners at the sites of `cells`, and on walls.
pub(crate) fn elements(
    cells: &PolyMesh,
    sites: &[Point3<f64>],
    (domain, patches, angle): (&dyn DomainShape, &WallPatches, f64),
) -> Result<ElementMesh, Failure> {
    if cells.patches.iter().any(|patch| patch.partner.is_some()) {
        let message = "hexahedra across a period are not made: take a domain without periods, or --elements cells";
        return Err(Failure::input(message));
    }
    let cells = without_chains(cells, angle);
    let side = (domain.volume() / cells.cell_count.max(1) as f64).cbrt();
    let walls = domain.surface_mesh().map(|surface| {
        let numbers: Vec<u32> = (0..surface.triangles.len() as u32)
            .map(|wall| number_of(&cells, &patches.name(patches.of(wall))))
            .collect();
        WallProjection::new(surface, &numbers, angle, 2.0 * side)
    });
    let turns = match &walls {
        Some(walls) => FeatureTurns::At(&walls.corners, CORNER_REACH * side),
        None => FeatureTurns::Beyond(angle),
    };
    let mut dual = DualMesh::of(&cells, &corners(&cells, sites), turns);
    if let Some(walls) = &walls {
        project(&mut dual.mesh.points, &dual.anchors, walls);
        balance(&mut dual, walls);
    }
    dual.mesh.check_closed().map_err(Failure::run)?;
    merge_flat(&mut dual);
    dual.mesh.check_closed().map_err(Failure::run)?;
    let (mesh, bad) = untangled(dual, walls.as_ref());
    refuse_inverted(&mesh, &bad)?;
    Ok(mesh)
}

/// The elements of a dual, their points moved and its cells joined until none is inverted, or nothing helps;
/// and those that are still.
fn untangled(mut dual: DualMesh, walls: Option<&WallProjection>) -> (ElementMesh, Vec<usize>) {
    let mut joins = 0;
    loop {
        let mut mesh = divide(&dual.mesh);
        let bad = untangle(&mut mesh, &dual.anchors, walls);
        let cells: BTreeSet<u32> = bad.iter().map(|&element| mesh.cells[element]).collect();
        // Points of the dual come first; they stay where they helped.
        let count = dual.mesh.points.len();
        dual.mesh.points.copy_from_slice(&mesh.points[..count]);
        if cells.is_empty() || joins == JOINS || !join_bad(&mut dual, &cells) {
            return (mesh, bad);
        }
        joins += 1;
    }
}

/// The number of a patch by its name; none has the highest.
fn number_of(mesh: &PolyMesh, name: &str) -> u32 {
    let place = mesh.patches.iter().position(|patch| patch.name == name);
    place.map_or(u32::MAX, |place| place as u32)
}

/// Per cell its site, or its center where the site lies in another piece of it.
fn corners(mesh: &PolyMesh, sites: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let faces = mesh.cell_faces();
    let geometry = MeshGeometry::of(mesh, &faces);
    let corner = |cell: usize| {
        let site = sites[mesh.sites[cell] as usize];
        let is_inside = faces.of(cell).all(|(face, is_owner)| {
            let below = geometry.face_areas[face].dot(&(geometry.face_centers[face] - site));
            (below > 0.0) == is_owner
        });
        if is_inside {
            site
        } else {
            geometry.cell_centers[cell]
        }
    };
    (0..mesh.cell_count).map(corner).collect()
}

fn refuse_inverted(mesh: &ElementMesh, bad: &[usize]) -> Result<(), Failure> {
    let Some(&first) = bad.first() else {
        return Ok(());
    };
    let corners = mesh.elements[first].corners();
    let sum: Point3<f64> = corners.iter().fold(Point3::origin(), |sum, &corner| {
        sum + mesh.points[corner as usize].coords
    });
    let place = sum / corners.len() as f64;
    Err(Failure::run(format!(
        "{} of {} elements are inverted, the first near ({:.6}, {:.6}, {:.6}) in the coordinates of the sites; \
         more sites, or a larger --collapse, mend that",
        bad.len(),
        mesh.elements.len(),
        place.x,
        place.y,
        place.z
    )))
}
