//! `mesh.su2`: SU2's native format, a marker for every patch.
//!
//! Source: SU2 documentation, "Mesh File" (types are VTK's, numbers count from zero).

use std::io::{self, Write};
use std::path::Path;

use crate::complex::element_mesh::ElementMesh;
use crate::export::atomic_write;

/// VTK's types in the order of [`crate::complex::element::KINDS`].
const TYPES: [u32; 4] = [12, 13, 14, 10];

/// Writes a mesh of elements.
///
/// # Errors
/// The error of the system; the file is then as it was before.
pub(crate) fn write_su2(path: &Path, mesh: &ElementMesh) -> io::Result<()> {
    atomic_write::write(path, |file| {
        writeln!(file, "NDIME= 3\nNELEM= {}", mesh.elements.len())?;
        for (number, element) in mesh.elements.iter().enumerate() {
            let kind = TYPES[element.kind()];
            write_entry(file, kind, element.corners())?;
            writeln!(file, " {number}")?;
        }
        writeln!(file, "NPOIN= {}", mesh.points.len())?;
        for (number, point) in mesh.points.iter().enumerate() {
            writeln!(file, "{:?} {:?} {:?} {number}", point.x, point.y, point.z)?;
        }
        writeln!(file, "NMARK= {}", mesh.patches.len())?;
        for (patch, name) in (0..).zip(&mesh.patches) {
            write_marker(file, mesh, patch, name)?;
        }
        Ok(())
    })
}

fn write_marker(
    file: &mut impl Write,
    mesh: &ElementMesh,
    patch: u32,
    name: &str,
) -> io::Result<()> {
    let faces = mesh.walls.iter().filter(|(_, of)| *of == patch);
    // A name ends at a blank.
    let name = name.replace(char::is_whitespace, "_");
    writeln!(
        file,
        "MARKER_TAG= {name}\nMARKER_ELEMS= {}",
        faces.clone().count()
    )?;
    for (corners, _) in faces {
        let kind = if corners.len() == 3 { 5 } else { 9 };
        write_entry(file, kind, corners)?;
        writeln!(file)?;
    }
    Ok(())
}

fn write_entry(file: &mut impl Write, kind: u32, corners: &[u32]) -> io::Result<()> {
    write!(file, "{kind}")?;
    corners
        .iter()
        .try_for_each(|corner| write!(file, " {corner}"))
}
