//! A case of OpenFOAM: `constant/polyMesh` in ASCII, and the `system` that `checkMesh` asks for.
//!
//! Source: OpenFOAM v1912, user guide, section 4.1 (mesh description); `cyclicPolyPatch.C` for the
//! pairs of a period. Coordinates are the shortest decimals that read back to the same f64.

use std::fs;
use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::export::atomic_write;
use crate::mesh::poly_mesh::{MeshPatch, PolyMesh};
use crate::parallel::{map, map_runs};

/// The files of a mesh, relative to the case.
pub(crate) const MESH_FILES: [&str; 5] = [
    "constant/polyMesh/points",
    "constant/polyMesh/faces",
    "constant/polyMesh/owner",
    "constant/polyMesh/neighbour",
    "constant/polyMesh/boundary",
];

/// Entries of a list that one task writes.
const CHUNK: usize = 4096;

/// Entries whose text is kept in memory together.
const TOGETHER: usize = 64 * CHUNK;

/// A file that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub(crate) struct CaseError {
    path: PathBuf,
    source: io::Error,
}

/// Writes `mesh` into the case `folder`; a `system` with a `controlDict` stays as it is.
///
/// # Errors
/// [`CaseError`] naming the file, which is then as it was before.
pub(crate) fn write_case(folder: &Path, mesh: &PolyMesh) -> Result<(), CaseError> {
    // Together, so that threads go on while the disk takes a file.
    let lists: [&(dyn Fn() -> Result<(), CaseError> + Sync); 5] = [
        &|| write_points(folder, mesh),
        &|| write_faces(folder, mesh),
        &|| write_cells(folder, MESH_FILES[2], mesh, &mesh.owner),
        &|| write_cells(folder, MESH_FILES[3], mesh, &mesh.neighbor),
        &|| write_boundary(folder, mesh),
    ];
    let written = map(lists.len(), &|list| lists[list]());
    written.into_iter().collect::<Result<(), _>>()?;
    write_system(folder)
}

fn write_points(folder: &Path, mesh: &PolyMesh) -> Result<(), CaseError> {
    let count = mesh.points.len();
    write_list(
        folder,
        MESH_FILES[0],
        ("vectorField", ""),
        count,
        |point, text| {
            let [x, y, z] = mesh.points[point].into();
            writeln!(text, "({x:?} {y:?} {z:?})")
        },
    )
}

fn write_faces(folder: &Path, mesh: &PolyMesh) -> Result<(), CaseError> {
    let count = mesh.face_count();
    write_list(
        folder,
        MESH_FILES[1],
        ("faceList", ""),
        count,
        |face, text| {
            let corners = mesh.face(face);
            push_number(corners.len() as u32, text);
            for (place, &corner) in corners.iter().enumerate() {
                text.push(if place > 0 { b' ' } else { b'(' });
                push_number(corner, text);
            }
            text.extend_from_slice(b")\n");
            Ok(())
        },
    )
}

/// Writes a cell of every face.
fn write_cells(folder: &Path, name: &str, mesh: &PolyMesh, cells: &[u32]) -> Result<(), CaseError> {
    let note = format!(
        "nPoints:{} nCells:{} nFaces:{} nInternalFaces:{}",
        mesh.points.len(),
        mesh.cell_count,
        mesh.face_count(),
        mesh.neighbor.len()
    );
    write_list(
        folder,
        name,
        ("labelList", &note),
        cells.len(),
        |face, text| {
            push_number(cells[face], text);
            text.push(b'\n');
            Ok(())
        },
    )
}

fn write_boundary(folder: &Path, mesh: &PolyMesh) -> Result<(), CaseError> {
    let (class, count) = (("polyBoundaryMesh", ""), mesh.patches.len());
    write_list(folder, MESH_FILES[4], class, count, |patch, text| {
        write_patch(&mesh.patches[patch], &mesh.patches, text)
    })
}

/// Appends a number's digits; formatting by the standard library takes several times as long.
fn push_number(mut number: u32, text: &mut Vec<u8>) {
    let mut digits = [b'0'; 10];
    let mut start = digits.len();
    loop {
        start -= 1;
        digits[start] = b'0' + (number % 10) as u8;
        number /= 10;
        if number == 0 {
            break;
        }
    }
    text.extend_from_slice(&digits[start..]);
}

/// Writes a list of `count` entries, some of which at a time all threads put into words.
fn write_list(
    folder: &Path,
    name: &str,
    (class, note): (&str, &str),
    count: usize,
    entry: impl Fn(usize, &mut Vec<u8>) -> io::Result<()> + Sync,
) -> Result<(), CaseError> {
    write_file(folder, name, class, note, |file| {
        write!(file, "{count}\n(\n")?;
        for first in (0..count).step_by(TOGETHER) {
            let chunks = map_runs(TOGETHER.min(count - first), CHUNK, |run| {
                text_of(first + run.start..first + run.end, &entry)
            });
            for chunk in chunks {
                file.write_all(&chunk?)?;
            }
        }
        writeln!(file, ")")
    })
}

fn text_of(
    mut entries: Range<usize>,
    entry: impl Fn(usize, &mut Vec<u8>) -> io::Result<()>,
) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    entries.try_for_each(|number| entry(number, &mut text))?;
    Ok(text)
}

fn write_file(
    folder: &Path,
    name: &str,
    class: &str,
    note: &str,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), CaseError> {
    let path = folder.join(name);
    let (location, object) = name.rsplit_once('/').unwrap_or(("", name));
    let write = || {
        fs::create_dir_all(folder.join(location))?;
        atomic_write::write(&path, |file| {
            writeln!(
                file,
                "FoamFile\n{{\n    version     2.0;\n    format      ascii;"
            )?;
            writeln!(file, "    class       {class};")?;
            if !note.is_empty() {
                writeln!(file, "    note        \"{note}\";")?;
            }
            writeln!(
                file,
                "    location    \"{location}\";\n    object      {object};\n}}\n"
            )?;
            content(file)
        })
    };
    write().map_err(|source| CaseError {
        path: path.clone(),
        source,
    })
}

fn write_patch(patch: &MeshPatch, all: &[MeshPatch], text: &mut Vec<u8>) -> io::Result<()> {
    let kind = if patch.partner.is_some() {
        "cyclic"
    } else {
        "patch"
    };
    writeln!(
        text,
        "    {}\n    {{\n        type            {kind};",
        patch.name
    )?;
    writeln!(text, "        nFaces          {};", patch.count)?;
    writeln!(text, "        startFace       {};", patch.start)?;
    if let Some((partner, way)) = patch.partner {
        let name = &all[partner].name;
        writeln!(
            text,
            "        matchTolerance  0.0001;\n        transform       translational;"
        )?;
        writeln!(
            text,
            "        separationVector ({:?} {:?} {:?});",
            way.x, way.y, way.z
        )?;
        writeln!(text, "        neighbourPatch  {name};")?;
    }
    writeln!(text, "    }}")
}

/// Dictionaries with which a steady Laplace problem runs.
const SYSTEM: [(&str, &str); 3] = [
    (
        "system/controlDict",
        "application     checkMesh;\nstartFrom       startTime;\nstartTime       0;\nstopAt          endTime;\n\
         endTime         1;\ndeltaT          1;\nwriteControl    timeStep;\nwriteInterval   1;\n\
         writeFormat     ascii;\nwritePrecision  17;\ntimeFormat      general;\nrunTimeModifiable false;\n",
    ),
    (
        "system/fvSchemes",
        "ddtSchemes { default steadyState; }\ngradSchemes { default leastSquares; }\n\
         divSchemes { default none; }\nlaplacianSchemes { default Gauss linear corrected; }\n\
         interpolationSchemes { default linear; }\nsnGradSchemes { default corrected; }\n",
    ),
    ("system/fvSolution", "solvers\n{\n}\n"),
];

fn write_system(folder: &Path) -> Result<(), CaseError> {
    if folder.join(SYSTEM[0].0).exists() {
        return Ok(());
    }
    for (name, content) in SYSTEM {
        if !folder.join(name).exists() {
            write_file(folder, name, "dictionary", "", |file| {
                file.write_all(content.as_bytes())
            })?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_their_digits() {
        for number in [0, 7, 10, 99, 100, 4_294_967_295] {
            let mut text = b"a".to_vec();
            push_number(number, &mut text);
            assert_eq!(text, format!("a{number}").into_bytes());
        }
    }
}
