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
use crate::parallel::map_runs;

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
    let [points, faces, owner, neighbor, boundary] = MESH_FILES;
    let note = format!(
        "nPoints:{} nCells:{} nFaces:{} nInternalFaces:{}",
        mesh.points.len(),
        mesh.cell_count,
        mesh.face_count(),
        mesh.neighbor.len()
    );
    write_list(
        folder,
        points,
        ("vectorField", ""),
        mesh.points.len(),
        |point, text| {
            let [x, y, z] = mesh.points[point].into();
            writeln!(text, "({x:?} {y:?} {z:?})")
        },
    )?;
    write_list(
        folder,
        faces,
        ("faceList", ""),
        mesh.face_count(),
        |face, text| {
            let corners = mesh.face(face);
            write!(text, "{}(", corners.len())?;
            for (place, corner) in corners.iter().enumerate() {
                write!(text, "{}{corner}", if place > 0 { " " } else { "" })?;
            }
            writeln!(text, ")")
        },
    )?;
    write_list(
        folder,
        owner,
        ("labelList", &note),
        mesh.owner.len(),
        |face, text| writeln!(text, "{}", mesh.owner[face]),
    )?;
    write_list(
        folder,
        neighbor,
        ("labelList", &note),
        mesh.neighbor.len(),
        |face, text| writeln!(text, "{}", mesh.neighbor[face]),
    )?;
    write_list(
        folder,
        boundary,
        ("polyBoundaryMesh", ""),
        mesh.patches.len(),
        |patch, text| write_patch(&mesh.patches[patch], &mesh.patches, text),
    )?;
    write_system(folder)
}

/// Writes a list of `count` entries, in parallel.
fn write_list(
    folder: &Path,
    name: &str,
    (class, note): (&str, &str),
    count: usize,
    entry: impl Fn(usize, &mut Vec<u8>) -> io::Result<()> + Sync,
) -> Result<(), CaseError> {
    let chunks = map_runs(count, CHUNK, |run| text_of(run, &entry));
    let chunks: io::Result<Vec<Vec<u8>>> = chunks.into_iter().collect();
    write_file(folder, name, class, note, |file| {
        write!(file, "{count}\n(\n")?;
        for chunk in chunks? {
            file.write_all(&chunk)?;
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
