//! Every format gives the same solid; files cut short or damaged are refused, never panic.

use std::fs;
use std::path::PathBuf;

use crate::mesh::formats::mesh::Mesh;
use crate::mesh::formats::read::{read, read_surface, read_tets};
use crate::mesh::formats::{gmsh, medit, obj, off, ply, stl, tetgen, three_mf, vtk, vtu};
use crate::mesh::shapes;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::{TetMesh, VertexData};
use crate::mesh::validate::{validate_surface, validate_tets};
use nalgebra::Point3;
use proptest::prelude::*;
use tempfile::TempDir;

use crate::tests::mesh::samples::{self, Sample};

fn solid_surface() -> SurfaceMesh {
    let mut mesh = shapes::bracket(2);
    mesh.vertices[3].x += 1e-17;
    mesh.vertices[5].y -= 1.0 / 3.0;
    mesh
}

/// Fewer and rounder, for tests that try every byte.
fn small_surface() -> SurfaceMesh {
    shapes::torus(1.0, 0.25, 3, 3)
}

fn solid_tets() -> TetMesh {
    let mut mesh = shapes::unit_cube_tets(3);
    let values = mesh
        .vertices
        .iter()
        .map(|p| 1.0 + p.x / 3.0 + 7e-9 * p.y)
        .collect();
    let name = "density";
    mesh.vertex_data.push(VertexData::new(name, values));
    mesh
}

fn file(directory: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = directory.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn parse((extension, bytes): &Sample) -> Result<Mesh, crate::mesh::formats::error::ParseError> {
    match *extension {
        "off" => off::parse(bytes).map(Mesh::Surface),
        "obj" => obj::parse(bytes).map(Mesh::Surface),
        "stl" => stl::parse(bytes).map(Mesh::Surface),
        "ply" => ply::parse(bytes).map(Mesh::Surface),
        "mesh" => medit::parse(bytes),
        "msh" => gmsh::parse(bytes),
        "vtk" => vtk::parse(bytes),
        "3mf" => three_mf::read(bytes).map(|file| file.mesh),
        _ => vtu::parse(bytes),
    }
}

#[test]
fn every_surface_format_gives_the_same_triangles() {
    let directory = TempDir::new().unwrap();
    let mesh = solid_surface();
    let corners: Vec<_> = mesh.all_corners().collect();
    for (number, (extension, bytes)) in samples::surfaces(&mesh).iter().enumerate() {
        let path = file(&directory, &format!("{number}.{extension}"), bytes);
        let got = read_surface(&path).unwrap();
        assert_eq!(
            got.vertices.len(),
            mesh.vertices.len(),
            "{extension} {number}"
        );
        assert!(
            got.all_corners().eq(corners.iter().copied()),
            "{extension} {number}"
        );
        // The first bytes identify all formats but OBJ, which is guessed from its lines.
        let nameless = file(&directory, "nameless", bytes);
        assert_eq!(
            read_surface(&nameless).unwrap(),
            got,
            "{extension} {number}"
        );
    }
}

#[test]
fn binary_stl_is_welded_and_rounded_only_to_f32() {
    let directory = TempDir::new().unwrap();
    let mut mesh = solid_surface();
    mesh.vertices[0] = Point3::new(-0.0, 0.0, -0.0);
    let path = file(&directory, "solid.stl", &samples::stl_binary(&mesh));
    let got = read_surface(&path).unwrap();
    let rounded = |p: Point3<f64>| p.map(|x| f64::from(x as f32));
    assert_eq!(got.vertices.len(), mesh.vertices.len());
    assert!(
        got.all_corners()
            .eq(mesh.all_corners().map(|corners| corners.map(rounded)))
    );
    assert!(validate_surface(&got).unwrap().1.notes().is_empty());
}

#[test]
fn every_tetrahedral_format_gives_the_same_solid() {
    let directory = TempDir::new().unwrap();
    let mesh = solid_tets();
    for (number, (extension, bytes)) in samples::tets(&mesh).iter().enumerate() {
        let got = read_tets(&file(&directory, &format!("{number}.{extension}"), bytes)).unwrap();
        assert_eq!(
            (&got.vertices, &got.tets),
            (&mesh.vertices, &mesh.tets),
            "{extension} {number}"
        );
        let has_data = *extension != "mesh";
        assert_eq!(
            got.data("density"),
            has_data.then_some(&mesh.vertex_data[0].values[..]),
            "{extension} {number}"
        );
        assert_eq!(got.data("wind"), None);
    }
}

#[test]
fn tetgen_pairs_count_from_zero_or_one() {
    let directory = TempDir::new().unwrap();
    let mesh = solid_tets();
    for first in [0, 1] {
        let (nodes, elements) = samples::tetgen(&mesh, first);
        let node = file(&directory, "solid.1.node", &nodes);
        let ele = file(&directory, "solid.1.ele", &elements);
        let got = read_tets(&node).unwrap();
        assert_eq!((&got.vertices, &got.tets), (&mesh.vertices, &mesh.tets));
        assert_eq!(
            got.data("attribute1"),
            Some(&mesh.vertex_data[0].values[..])
        );
        assert_eq!(read_tets(&ele).unwrap(), got);
        fs::remove_file(&ele).unwrap();
        let message = read(&node).unwrap_err().to_string();
        assert!(message.contains("solid.1.ele: cannot be read"), "{message}");
    }
}

#[test]
fn written_files_read_back_bit_for_bit() {
    let surface = solid_surface();
    assert_eq!(
        off::parse(off::write(&surface).as_bytes()).unwrap(),
        surface
    );
    let tets = shapes::unit_cube_tets(3);
    assert_eq!(
        medit::parse(medit::write(&tets).as_bytes()).unwrap(),
        Mesh::Tets(tets)
    );
}

/// One line for each square of the unit cube.
fn squares(before: &str, first: usize, after: &str) -> String {
    const QUADS: [[usize; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let line = |quad: [usize; 4]| quad.map(|vertex| (vertex + first).to_string()).join(" ");
    QUADS
        .map(|quad| format!("{before}{}{after}\n", line(quad)))
        .concat()
}

/// The unit cube in six squares.
fn cubes_of_squares() -> Vec<Sample> {
    let vertices = shapes::unit_cube().vertices;
    let lines: Vec<String> = vertices
        .iter()
        .map(|p| format!("{} {} {}\n", p.x, p.y, p.z))
        .collect();
    let points = lines.concat();
    let each = |line: &dyn Fn(usize, &str) -> String| -> String {
        lines
            .iter()
            .enumerate()
            .map(|(k, text)| line(k, text))
            .collect()
    };
    let off = format!("OFF\n8 6 12\n{points}{}", squares("4 ", 0, ""));
    let obj = each(&|_, line| format!("v {line}")) + &squares("f ", 1, "");
    let ply = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n";
    let ply = format!("{ply}{points}{}", squares("4 ", 0, ""));
    let medit = "MeshVersionFormatted 1\nDimension 3\nVertices 8\n";
    let medit = format!(
        "{medit}{}Quadrilaterals 6\n{}",
        points.replace('\n', " 0\n"),
        squares("", 1, " 0")
    );
    let nodes = each(&|k, line| format!("{} {line}", k + 1));
    let gmsh = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n{nodes}$EndNodes\n$Elements\n6\n{}$EndElements\n",
        squares("1 3 2 0 0 ", 1, "")
    );
    let vtk = "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 float\n";
    let vtk = format!(
        "{vtk}{points}CELLS 6 30\n{}CELL_TYPES 6\n9 9 9 9 7 9\n",
        squares("4 ", 0, "")
    );
    let files = [
        ("off", off),
        ("obj", obj),
        ("ply", ply),
        ("mesh", medit),
        ("msh", gmsh),
        ("vtk", vtk),
    ];
    files
        .map(|(extension, text)| (extension, text.into_bytes()))
        .to_vec()
}

#[test]
fn polygons_of_every_format_close_the_cube() {
    for sample in cubes_of_squares() {
        let Ok(Mesh::Surface(mesh)) = parse(&sample) else {
            panic!("{} is a surface", sample.0);
        };
        let (closed, report) = validate_surface(&mesh).unwrap();
        assert_eq!(report.notes(), Vec::<String>::new(), "{}", sample.0);
        assert!((closed.mesh().volume() - 1.0).abs() < 1e-15, "{}", sample.0);
        assert_eq!(mesh.triangles.len(), 12);
    }
}

#[test]
fn a_file_cut_anywhere_is_refused_or_a_smaller_mesh() {
    let mut mesh = shapes::unit_cube_five_tets();
    let values = (0..8).map(f64::from).collect();
    mesh.vertex_data.push(VertexData::new("density", values));
    let mut all = samples::surfaces(&small_surface());
    all.push(("stl", samples::stl_binary(&small_surface())));
    all.extend(samples::tets(&mesh));
    let (nodes, elements) = samples::tetgen(&mesh, 1);
    for (extension, bytes) in all {
        for length in 0..bytes.len() {
            check(parse(&(extension, bytes[..length].to_vec())));
        }
    }
    for length in 0..nodes.len() {
        if let Ok(cut) = tetgen::parse_nodes(&nodes[..length]) {
            check(tetgen::parse_elements(&elements, cut).map(Mesh::Tets));
        }
    }
    for length in 0..elements.len() {
        let whole = tetgen::parse_nodes(&nodes).unwrap();
        check(tetgen::parse_elements(&elements[..length], whole).map(Mesh::Tets));
    }
}

/// A mesh that is read refers to its own vertices only, with finite numbers, so that checking it
/// cannot panic; a fault has something to say.
fn check(outcome: Result<Mesh, crate::mesh::formats::error::ParseError>) {
    match outcome {
        Ok(Mesh::Surface(mesh)) => {
            assert!(
                mesh.triangles
                    .iter()
                    .flatten()
                    .all(|&v| (v as usize) < mesh.vertices.len())
            );
            assert!(
                mesh.vertices
                    .iter()
                    .all(|p| p.iter().all(|x| x.is_finite()))
            );
            drop(validate_surface(&mesh));
        }
        Ok(Mesh::Tets(mesh)) => {
            assert!(
                mesh.tets
                    .iter()
                    .flatten()
                    .all(|&v| (v as usize) < mesh.vertices.len())
            );
            assert!(
                mesh.vertex_data
                    .iter()
                    .all(|field| field.values.len() == mesh.vertices.len())
            );
            drop(validate_tets(&mesh));
        }
        Err(fault) => assert!(fault.to_string().len() > 20),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn damaged_files_never_panic(
        damage in proptest::collection::vec((any::<prop::sample::Index>(), prop_oneof![any::<u8>(), Just(b'9'), Just(b'-'), Just(b'\n'), Just(b'<')]), 1..6),
    ) {
        let mut mesh = shapes::unit_cube_five_tets();
        mesh.vertex_data.push(VertexData::new("density", vec![1.0; 8]));
        let mut all = samples::surfaces(&small_surface());
        all.push(("stl", samples::stl_binary(&small_surface())));
        all.extend(samples::tets(&mesh));
        for (extension, mut bytes) in all {
            for (place, byte) in &damage {
                let place = place.index(bytes.len());
                bytes[place] = *byte;
            }
            check(parse(&(extension, bytes)));
        }
    }
}
