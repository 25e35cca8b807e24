//! `mesh.mesh`: MEDIT's format in ASCII. References of faces are patches, counted from one and named in
//! comments; those of elements and points are zero.
//!
//! Source: Frey, *MEDIT: an interactive mesh visualization software*, INRIA RT-0253, 2001; the keywords
//! `Prisms` and `Pyramids` are those of libMeshb.

use std::io::{self, Write};
use std::path::Path;

use crate::complex::element_mesh::ElementMesh;
use crate::export::atomic_write;

/// Keywords in the order of [`crate::complex::element::KINDS`].
const KEYWORDS: [&str; 4] = ["Hexahedra", "Prisms", "Pyramids", "Tetrahedra"];

/// Writes a mesh of elements.
///
/// # Errors
/// The error of the system; the file is then as it was before.
pub(crate) fn write_medit(path: &Path, mesh: &ElementMesh) -> io::Result<()> {
    atomic_write::write(path, |file| {
        writeln!(file, "MeshVersionFormatted 2\nDimension 3")?;
        for (reference, name) in (1..).zip(&mesh.patches) {
            writeln!(file, "# {reference}: {}", name.replace('\n', " "))?;
        }
        writeln!(file, "Vertices\n{}", mesh.points.len())?;
        for point in &mesh.points {
            writeln!(file, "{:?} {:?} {:?} 0", point.x, point.y, point.z)?;
        }
        for (keyword, corners) in [("Triangles", 3), ("Quadrilaterals", 4)] {
            let faces = mesh.walls.iter().filter(|(face, _)| face.len() == corners);
            write_list(
                file,
                keyword,
                faces.map(|(face, patch)| (face.as_slice(), patch + 1)),
            )?;
        }
        for (kind, keyword) in KEYWORDS.into_iter().enumerate() {
            let elements = mesh
                .elements
                .iter()
                .filter(|element| element.kind() == kind);
            write_list(
                file,
                keyword,
                elements.map(|element| (element.corners(), 0)),
            )?;
        }
        writeln!(file, "End")
    })
}

fn write_list<'a>(
    file: &mut impl Write,
    keyword: &str,
    entries: impl Iterator<Item = (&'a [u32], u32)> + Clone,
) -> io::Result<()> {
    let count = entries.clone().count();
    if count == 0 {
        return Ok(());
    }
    writeln!(file, "{keyword}\n{count}")?;
    for (corners, reference) in entries {
        for corner in corners {
            write!(file, "{} ", corner + 1)?;
        }
        writeln!(file, "{reference}")?;
    }
    Ok(())
}
