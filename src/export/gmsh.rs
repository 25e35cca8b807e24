//! `mesh.msh`: Gmsh's MSH 4.1 in ASCII, a physical group for every patch and one for the volume.
//!
//! Source: Gmsh reference manual, section 10.1 (MSH file format). Tags count from one; the order of points is the mesh's.

use std::io::{self, Write};
use std::path::Path;

use crate::complex::element::CellElement;
use crate::complex::element_mesh::ElementMesh;
use crate::export::atomic_write;

/// Gmsh's types of triangles and quadrilaterals.
const FACE_TYPES: [(usize, u32); 2] = [(3, 2), (4, 3)];

/// Gmsh's types of elements in the order of [`crate::complex::element::KINDS`].
const TYPES: [u32; 4] = [5, 6, 7, 4];

/// Writes a mesh of elements.
///
/// # Errors
/// The error of the system; the file is then as it was before.
pub(crate) fn write_gmsh(path: &Path, mesh: &ElementMesh) -> io::Result<()> {
    atomic_write::write(path, |file| {
        writeln!(file, "$MeshFormat\n4.1 0 8\n$EndMeshFormat")?;
        write_groups(file, mesh)?;
        write_points(file, mesh)?;
        write_elements(file, mesh)
    })
}

/// Physical groups, and an entity for each.
fn write_groups(file: &mut impl Write, mesh: &ElementMesh) -> io::Result<()> {
    let count = mesh.patches.len();
    writeln!(file, "$PhysicalNames\n{}", count + 1)?;
    for (tag, name) in (1..).zip(&mesh.patches) {
        writeln!(file, "2 {tag} \"{}\"", name.replace('"', "'"))?;
    }
    writeln!(file, "3 {} \"volume\"\n$EndPhysicalNames", count + 1)?;
    let bound = |start: f64, pick: fn(f64, f64) -> f64| {
        let fold = |axis: usize| {
            mesh.points
                .iter()
                .map(|point| point[axis])
                .fold(start, pick)
        };
        let [x, y, z] = [0, 1, 2].map(fold);
        format!("{x:?} {y:?} {z:?}")
    };
    let bounds = format!(
        "{} {}",
        bound(f64::INFINITY, f64::min),
        bound(f64::NEG_INFINITY, f64::max)
    );
    writeln!(file, "$Entities\n0 0 {count} 1")?;
    for tag in 1..=count {
        writeln!(file, "{tag} {bounds} 1 {tag} 0")?;
    }
    write!(file, "1 {bounds} 1 {} {count}", count + 1)?;
    for tag in 1..=count {
        write!(file, " {tag}")?;
    }
    writeln!(file, "\n$EndEntities")
}

fn write_points(file: &mut impl Write, mesh: &ElementMesh) -> io::Result<()> {
    let count = mesh.points.len();
    writeln!(file, "$Nodes\n1 {count} 1 {count}\n3 1 0 {count}")?;
    for tag in 1..=count {
        writeln!(file, "{tag}")?;
    }
    for point in &mesh.points {
        writeln!(file, "{:?} {:?} {:?}", point.x, point.y, point.z)?;
    }
    writeln!(file, "$EndNodes")
}

/// Elements of one type in one entity: dimension, entity, type, corners.
type Block<'a> = ([u32; 3], Vec<&'a [u32]>);

fn write_elements(file: &mut impl Write, mesh: &ElementMesh) -> io::Result<()> {
    let mut blocks: Vec<Block<'_>> = Vec::new();
    for patch in 0..mesh.patches.len() as u32 {
        for (corners, kind) in FACE_TYPES {
            let faces = mesh.walls.iter();
            let faces = faces.filter(|(face, of)| *of == patch && face.len() == corners);
            let faces = faces.map(|(face, _)| face.as_slice());
            blocks.push(([2, patch + 1, kind], faces.collect()));
        }
    }
    for (kind, gmsh) in TYPES.into_iter().enumerate() {
        let elements = mesh
            .elements
            .iter()
            .filter(|element| element.kind() == kind);
        blocks.push(([3, 1, gmsh], elements.map(CellElement::corners).collect()));
    }
    blocks.retain(|(_, elements)| !elements.is_empty());
    let count = mesh.walls.len() + mesh.elements.len();
    writeln!(file, "$Elements\n{} {count} 1 {count}", blocks.len())?;
    let mut tag = 0;
    for ([dimension, entity, kind], elements) in blocks {
        writeln!(file, "{dimension} {entity} {kind} {}", elements.len())?;
        for corners in elements {
            tag += 1;
            write!(file, "{tag}")?;
            for corner in corners {
                write!(file, " {}", corner + 1)?;
            }
            writeln!(file)?;
        }
    }
    writeln!(file, "$EndElements")
}
