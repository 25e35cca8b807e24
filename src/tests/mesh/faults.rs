//! Damaged files: the message names file, line or byte, what is wrong and what to do.

use std::fs;

use crate::mesh::formats::read::{load, read, read_tets};
use crate::mesh::shapes;
use tempfile::TempDir;

use crate::tests::mesh::samples;

/// The message of reading `bytes` from a file called `name`, from its name on.
fn message(name: &str, bytes: &[u8]) -> String {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join(name);
    fs::write(&path, bytes).unwrap();
    let message = read(&path).unwrap_err().to_string();
    // The folder has a random name, which may hold that of the file.
    let folder = format!("{}/", directory.path().display());
    message[message.find(&folder).unwrap() + folder.len()..].to_string()
}

/// Asserts that the message starts and ends as given.
fn expect(name: &str, text: &str, start: &str, mend: &str) {
    let message = message(name, text.as_bytes());
    assert!(message.starts_with(start), "{message}");
    assert!(message.contains(mend), "{message}");
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

#[test]
fn nothing_to_read() {
    for name in [
        "a.off", "a.obj", "a.stl", "a.ply", "a.mesh", "a.msh", "a.vtk", "a.vtu", "a.node", "a",
    ] {
        for text in ["", " \n\n"] {
            expect(
                name,
                text,
                &format!("{name}: the file is empty"),
                "export the mesh again",
            );
        }
    }
    let absent = read("no/such/file.off".as_ref()).unwrap_err().to_string();
    assert!(
        absent.starts_with("no/such/file.off: cannot be read (No such file"),
        "{absent}"
    );
}

#[test]
fn unknown_formats() {
    expect(
        "a.glb",
        "glTF",
        "a.glb: a glTF file cannot be read",
        "as OBJ, PLY, STL or 3MF",
    );
    expect(
        "a.off",
        "4OFF\n0 0 0\n",
        "a.off:1: the dialect 4OFF",
        "export plain OFF",
    );
    expect(
        "a.off",
        "OFF BINARY\nxx",
        "a.off:1: the dialect OFF BINARY",
        "export plain OFF",
    );
    expect(
        "a.off",
        "solids\n",
        "a.off:1: expected the header OFF, found `solids`",
        "correct",
    );
    expect(
        "a.msh",
        "$MeshFormat\n3.0 0 8\n",
        "a.msh:2: Gmsh's format 3.0",
        "export version 4.1",
    );
    expect(
        "a.msh",
        "$MeshFormat\n4.1 1 8\n",
        "a.msh:3: the file ends where the byte order",
        "truncated",
    );
    expect(
        "a.vtk",
        "# vtk DataFile Version 3.0\n\nOCTAL\n",
        "a.vtk:3: a OCTAL .vtk",
        "as ASCII, BINARY",
    );
    expect(
        "a.vtk",
        "# vtk DataFile Version 3.0\n\nASCII\nDATASET STRUCTURED_POINTS\n",
        "a.vtk:4: a VTK data set of kind STRUCTURED_POINTS",
        "UNSTRUCTURED_GRID",
    );
    expect(
        "a.vtu",
        "<VTKFile type=\"ImageData\">",
        "a.vtu:1: a VTK file of type ImageData",
        "UnstructuredGrid",
    );
    expect(
        "a.mesh",
        "MeshVersionFormatted 1\nDimension 2\n",
        "a.mesh:2: a mesh of dimension 2",
        "three coordinates",
    );
}

#[test]
fn files_that_stop_early() {
    expect(
        "a.off",
        "OFF\n3 1 0\n0 0 0\n1 0 0\n",
        "a.off:5: the file ends where a coordinate",
        "truncated",
    );
    expect(
        "a.off",
        "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1",
        "a.off:6: the file ends where a vertex index",
        "truncated",
    );
    expect(
        "a.obj",
        "v 0 0",
        "a.obj:1: the file ends where a coordinate",
        "truncated",
    );
    expect(
        "a.stl",
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
        "a.stl:5: the file ends where vertex",
        "truncated",
    );
    expect(
        "a.ply",
        &format!("{PLY}0 0 0\n1 0 0\n"),
        "a.ply:12: the file ends where a coordinate",
        "truncated",
    );
    expect(
        "a.mesh",
        "MeshVersionFormatted 1\nDimension 3\nVertices 2\n0 0 0 1\n1",
        "a.mesh:5: the file ends where a coordinate",
        "truncated",
    );
    expect(
        "a.vtu",
        "<VTKFile type=\"UnstructuredGrid\">\n<Piece>",
        "a.vtu:2: the file ends where </UnstructuredGrid>",
        "truncated",
    );
    let cut = &samples::stl_binary(&shapes::unit_cube())[..400];
    let message = message("a.stl", cut);
    assert_eq!(
        message,
        "a.stl: byte 80: 12 triangles are announced, 6 are there; correct the count or export the file again"
    );
}

#[test]
fn numbers_that_are_none() {
    for (number, found) in [("nan", "nan"), ("-inf", "-inf"), ("1e999", "1e999")] {
        let text = format!("OFF\n3 1 0\n0 0 0\n1 {number} 0\n0 1 0\n3 0 1 2\n");
        expect(
            "a.off",
            &text,
            &format!("a.off:4: `{found}` is not a finite number"),
            "must be finite",
        );
        expect(
            "a.obj",
            &format!("v 0 0 0\n\nv {number} 0 0\n"),
            &format!("a.obj:3: `{found}` is not"),
            "must be finite",
        );
        expect(
            "a.ply",
            &format!("{PLY}0 0 {number}\n"),
            &format!("a.ply:10: `{found}` is not"),
            "must be finite",
        );
    }
    expect(
        "a.off",
        "OFF\n1 1 0\n0 zero 0\n",
        "a.off:3: expected a coordinate, found `zero`",
        "correct the line",
    );
    expect(
        "a.off",
        "OFF\n1 1 0\n0 0\n0\n",
        "a.off:3: a vertex of two coordinates",
        "a solid has three",
    );
    let mut binary = samples::stl_binary(&shapes::unit_cube());
    binary[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let message = message("a.stl", &binary);
    assert!(
        message.starts_with("a.stl: byte 146: `NaN` is not a finite number"),
        "{message}"
    );
}

#[test]
fn indices_out_of_range() {
    let range = "is out of range; the 3 vertices are numbered from";
    expect(
        "a.off",
        "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
        "a.off:6: vertex 3 is out of",
        &format!("{range} 0"),
    );
    expect(
        "a.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
        "a.obj:4: vertex 4",
        &format!("{range} 1"),
    );
    expect(
        "a.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -4\n",
        "a.obj:4: vertex -4",
        range,
    );
    expect(
        "a.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n",
        "a.obj:4: vertex 0",
        range,
    );
    expect(
        "a.ply",
        &format!("{PLY}0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n"),
        "a.ply:13: vertex 9",
        &format!("{range} 0"),
    );
    expect(
        "a.mesh",
        "MeshVersionFormatted 1\nDimension 3\nVertices 3\n0 0 0 0\n1 0 0 0\n0 1 0 0\nTriangles 1\n1 2 0 0\n",
        "a.mesh:8: vertex 0",
        &format!("{range} 1"),
    );
    expect(
        "a.msh",
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n$Elements\n1\n1 2 0 1 2 4\n",
        "a.msh:12: vertex 4",
        "out of range",
    );
}

#[test]
fn counts_that_do_not_hold() {
    let vertices = "0 0 0\n1 0 0\n0 1 0\n";
    expect(
        "a.off",
        &format!("OFF\n3 1 0\n{vertices}3 0 1 2\n3 0 2 1\n3 1 0 2\n"),
        "a.off:7: 1 faces are announced, 3 are there",
        "correct the count",
    );
    expect(
        "a.off",
        &format!("OFF\n2 1 0\n{vertices}3 0 1 2\n"),
        "a.off:5: expected a face of at least 3 vertices, found `0`",
        "counts before it",
    );
    expect(
        "a.off",
        &format!("OFF\n3 -1 0\n{vertices}"),
        "a.off:2: expected the number of faces, found `-1`",
        "correct",
    );
    expect(
        "a.off",
        "OFF\n9999999999 1 0\n",
        "a.off:2: the file holds more than",
        "split or coarsen",
    );
    expect(
        "a.ply",
        &format!("{PLY}{vertices}3 0 1 2\n3 0 1 2\n"),
        "a.ply:14: expected the end of the file, found `3`",
        "counts",
    );
    expect(
        "a.msh",
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n2 0 0 0\n$EndNodes\n",
        "a.msh:7: expected the end of a section",
        "correct",
    );
    expect(
        "a.vtk",
        "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 6\n4 0 1 2 3\n",
        "a.vtk:8: 6 numbers in the cell list are announced, 5",
        "correct",
    );
}

#[test]
fn elements_that_would_leave_holes() {
    let hexahedra = "MeshVersionFormatted 1\nDimension 3\nVertices 1\n0 0 0 0\nHexahedra 1\n";
    expect(
        "a.mesh",
        hexahedra,
        "a.mesh:5: volume elements of type Hexahedra",
        "first or second order only",
    );
    let nodes =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n";
    expect(
        "a.msh",
        &format!("{nodes}1 5 0 1 1 1 1 1 1 1 1\n"),
        "a.msh:10: volume elements of type 5",
        "first or second order",
    );
    expect(
        "a.vtk",
        "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 float\n0 0 0\nCELLS 1 9\n8 0 0 0 0 0 0 0 0\nCELL_TYPES 1\n12\n",
        "a.vtk: volume elements of type VTK 12",
        "first or second order",
    );
    expect(
        "a.obj",
        "v 0 0 0\n",
        "a.obj: the file holds no faces",
        "export the mesh with its faces",
    );
    expect(
        "a.mesh",
        "MeshVersionFormatted 1\nDimension 3\nVertices 1\n0 0 0 0\nEnd\n",
        "a.mesh: the file holds no triangles",
        "with its elements",
    );
}

#[test]
fn a_surface_where_tetrahedra_are_wanted() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("cube.stl");
    fs::write(&path, samples::stl_binary(&shapes::unit_cube())).unwrap();
    let message = read_tets(&path).unwrap_err().to_string();
    assert!(
        message.ends_with(
            "cube.stl: the file holds no tetrahedra; use it as a surface, which needs none"
        ),
        "{message}"
    );
}

#[test]
fn a_refusal_names_the_file() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("one.obj");
    let open = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 2 1 4\n";
    fs::write(&path, open).unwrap();
    let message = load(&path).unwrap_err().to_string();
    assert!(message.contains("one.obj is not closed: 4 boundary edges, the first between vertices 2 and 0 (triangle 0); close it"), "{message}");
}
