//! Files written by other programs (Gmsh 4.15, meshio 5.3, VTK 9, lib3mf 2.5, trimesh), and what is made
//! of files that no reader is for.

use std::fs;
use std::path::{Path, PathBuf};

use crate::mesh::formats::mesh::Mesh;
use crate::mesh::formats::read::{load, load_within, read};
use crate::mesh::formats::{gmsh, medit, three_mf, vtk};
use crate::mesh::shapes;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::Solid;
use crate::tests::mesh::difference;
use crate::tests::mesh::{samples, samples_binary};
use tempfile::TempDir;

fn case(name: &str) -> PathBuf {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    cases.join(format!("written-by-{name}"))
}

fn load_bytes(name: &str, bytes: &[u8]) -> Result<Solid, String> {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join(name);
    fs::write(&path, bytes).unwrap();
    load(&path).map_err(|error| error.to_string())
}

/// The notes of the box 1 × 2 × 3 in this file.
fn notes_of_box(name: &str) -> Vec<String> {
    let solid = load(&case(name)).unwrap_or_else(|error| panic!("{error}"));
    assert!(difference(solid.volume(), 6.0) < 1e-14, "{name}");
    solid.notes()
}

#[test]
fn gmsh_files_of_every_version_are_the_box() {
    for name in [
        "gmsh-1-text.msh",
        "gmsh-22-binary.msh",
        "gmsh-22-binary-parametric.msh",
        "gmsh-40-text.msh",
        "gmsh-41-binary.msh",
        "gmsh-41-binary-parametric.msh",
        "gmsh-22-text.msh.gz",
        "meshio-22-binary.msh",
        "meshio-40-binary.msh",
        "meshio-41-binary.msh",
    ] {
        assert_eq!(notes_of_box(name), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn legacy_vtk_files_of_either_kind_are_the_box() {
    for name in [
        "meshio-binary.vtk",
        "meshio42-binary.vtk",
        "vtk-42-binary.vtk",
        "vtk-51-binary.vtk",
        "vtk-51-text.vtk",
        "vtk-polys-binary.vtk",
        "vtk-strips-binary.vtk",
        "vtk-strips-text.vtk",
    ] {
        assert_eq!(notes_of_box(name), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn polygonal_data_of_vtk_are_the_box_in_every_encoding() {
    for name in [
        "vtk-big.vtp",
        "vtk-polys-text.vtp",
        "vtk-polys-base64.vtp",
        "vtk-polys-base64-z.vtp",
        "vtk-polys-appended.vtp",
        "vtk-polys-appended-enc.vtp",
        "vtk-polys-appended-z.vtp",
        "vtk-polys-appended-enc-z.vtp",
        "vtk-strips-appended-z.vtp",
        "vtk-strips-text.vtp",
        "vtk-lz4.vtu",
    ] {
        assert_eq!(notes_of_box(name), Vec::<String>::new(), "{name}");
    }
    let message = read(&case("vtk-lzma.vtu")).unwrap_err().to_string();
    assert!(message.contains("vtkLZMADataCompressor"), "{message}");
    assert!(message.ends_with("compressed by zlib or LZ4"), "{message}");
}

#[test]
fn second_order_tetrahedra_are_read_by_their_corners() {
    for name in [
        "gmsh-22-second-order-binary.msh",
        "gmsh-41-second-order.msh",
        "gmsh-second-order-binary.vtk",
        "vtk-second-order.vtu",
    ] {
        let notes = notes_of_box(name);
        assert_eq!(notes.len(), 1, "{name}: {notes:?}");
        assert!(
            notes[0].starts_with("42 second-order elements"),
            "{notes:?}"
        );
    }
    let message = load(&case("gmsh-curved.msh")).unwrap_err().to_string();
    assert!(
        message.contains("a second-order element is curved"),
        "{message}"
    );
}

/// The mesh with a middle node on every edge of every tetrahedron, shifted by `off`.
fn second_order(mesh: &TetMesh, off: f64) -> (TetMesh, Vec<[u32; 10]>) {
    let (mut mesh, mut all) = (mesh.clone(), Vec::new());
    for (number, tet) in mesh.tets.clone().into_iter().enumerate() {
        let corners = mesh.corners(number);
        let mut nodes = [tet[0], tet[1], tet[2], tet[3], 0, 0, 0, 0, 0, 0];
        let edges = [[0, 1], [1, 2], [0, 2], [0, 3], [2, 3], [1, 3]];
        for (place, [a, b]) in (4..).zip(edges) {
            nodes[place] = mesh.vertices.len() as u32;
            let mut middle = nalgebra::center(&corners[a], &corners[b]);
            middle.x += off;
            mesh.vertices.push(middle);
        }
        all.push(nodes);
    }
    (mesh, all)
}

#[test]
fn second_order_files_in_text_keep_straight_elements_only() {
    use std::fmt::Write as _;
    for (off, is_straight) in [(0.0, true), (1e-11, true), (1e-6, false)] {
        let (mesh, all) = second_order(&shapes::unit_cube_five_tets(), off);
        let medit_text = medit::write(&mesh);
        let head = &medit_text[..medit_text.find("Tetrahedra").unwrap()];
        let mut text = format!("{head}TetrahedraP2\n{}\n", all.len());
        let mut elements = format!("{} 10 0\n", all.len());
        for (number, nodes) in (1..).zip(&all) {
            let nodes = nodes.map(|node| (node + 1).to_string()).join(" ");
            writeln!(text, "{nodes} 0").unwrap();
            writeln!(elements, "{number} {nodes}").unwrap();
        }
        text += "End\n";
        let mut nodes = format!("{} 3 0 0\n", mesh.vertices.len());
        for (number, p) in (1..).zip(&mesh.vertices) {
            writeln!(nodes, "{number} {} {} {}", p.x, p.y, p.z).unwrap();
        }
        let directory = TempDir::new().unwrap();
        let at = |name: &str| directory.path().join(name);
        fs::write(at("a.mesh"), text).unwrap();
        fs::write(at("b.node"), nodes).unwrap();
        fs::write(at("b.ele"), elements).unwrap();
        for name in ["a.mesh", "b.node"] {
            match load(&at(name)) {
                Ok(solid) => {
                    assert!(
                        is_straight && (solid.volume() - 1.0).abs() < 1e-14,
                        "{name}"
                    );
                    let notes = solid.notes();
                    assert_eq!(notes.len(), 1, "{notes:?}");
                }
                Err(error) => {
                    assert!(!is_straight, "{error}");
                    let text = error.to_string();
                    assert!(text.contains("curved") && text.contains(":"), "{text}");
                }
            }
        }
    }
}

#[test]
fn three_mf_packages_are_placed_as_their_build_says() {
    let notes = notes_of_box("trimesh-box.3mf");
    assert!(notes[0].contains("the file's unit, the "), "{notes:?}");
    // A tetrahedron of volume 1 thrice, once mirrored, at twice its size, and once alone.
    let solid = load(&case("lib3mf-components.3mf")).unwrap();
    assert!(
        difference(solid.volume(), 25.0) < 1e-6,
        "{}",
        solid.volume()
    );
    let Solid::Surface(surface, report) = &solid else {
        panic!("a surface")
    };
    assert_eq!((report.components, report.inverted.count), (4, 0));
    let bounds = surface.mesh().bounds();
    assert!((bounds.max.x - 12.0).abs() < 1e-6 && (bounds.max.y - 18.0).abs() < 1e-6);
    assert!((bounds.min.x + 2.0).abs() < 1e-6 && (bounds.min.z + 50.0).abs() < 1e-6);
}

#[test]
fn packages_that_hold_no_solid_say_why() {
    let message = |objects: &[(&str, &str, &str)], build: &str| {
        let bytes = samples_binary::three_mf_of(objects, build);
        load_bytes("a.3mf", &bytes).unwrap_err()
    };
    let round = "<components><component objectid=\"1\"/></components>";
    let text = message(&[("1", "model", round)], "<item objectid=\"1\"/>");
    assert!(text.contains("multiply without end"), "{text}");
    let text = message(&[("1", "model", round)], "<item objectid=\"5\"/>");
    assert!(text.contains("an object's number, found `5`"), "{text}");
    let text = message(&[("1", "model", round)], "");
    assert!(text.contains("no objects in its build"), "{text}");
    let placed = "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 0 0\"/>";
    let text = message(&[("1", "model", round)], placed);
    assert!(text.contains("twelve numbers"), "{text}");
    let other = samples_binary::zip(&[("word/document.xml", "<w/>", true)]);
    let text = load_bytes("a.docx", &other).unwrap_err();
    assert!(text.contains("no 3-D model"), "{text}");
    let mut damaged = samples_binary::three_mf(&shapes::unit_cube());
    let end = damaged.len() / 2;
    damaged[end] ^= 0x55;
    let text = load_bytes("a.3mf", &damaged).unwrap_err();
    assert!(text.contains("damaged"), "{text}");
}

#[test]
fn components_in_other_models_of_a_package_are_found() {
    let cube = samples_binary::three_mf(&shapes::unit_cube());
    let model = three_mf::read(&cube).unwrap();
    let Mesh::Surface(mesh) = model.mesh else {
        panic!("a surface")
    };
    let mut object = String::from("<mesh><vertices>");
    for p in &mesh.vertices {
        object += &format!("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x, p.y, p.z);
    }
    object += "</vertices><triangles>";
    for [a, b, c] in &mesh.triangles {
        object += &format!("<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>");
    }
    object += "</triangles></mesh>";
    let part = format!("<model><resources><object id=\"3\">{object}</object></resources></model>");
    let whole = "<model unit=\"inch\"><resources><object id=\"1\"><components><component p:path=\"/3D/Objects/part.model\" objectid=\"3\" transform=\"2 0 0 0 2 0 0 0 -2 1 1 1\"/></components></object></resources><build><item objectid=\"1\"/></build></model>";
    let package = samples_binary::zip(&[
        ("3D/3dmodel.model", whole, true),
        ("3D/Objects/part.model", &part, true),
    ]);
    let solid = load_bytes("a.3mf", &package).unwrap();
    assert!((solid.volume() - 8.0).abs() < 1e-14);
    assert_eq!(solid.notes(), ["lengths are in the file's unit, the inch"]);
}

#[test]
fn binary_files_of_either_byte_order_are_cut_without_panic() {
    let mesh = shapes::unit_cube_five_tets();
    for version in ["2.2", "4.0", "4.1"] {
        for big_endian in [false, true] {
            let bytes = samples_binary::gmsh(&mesh, &[1.0; 8], version, big_endian);
            assert_eq!(gmsh::parse(&bytes).unwrap(), gmsh_with_data(&mesh));
            for length in 0..bytes.len() {
                drop(gmsh::parse(&bytes[..length]));
            }
        }
    }
    // An announced billion must not be reserved.
    let huge = "# vtk DataFile Version 3.0\n\nBINARY\nDATASET POLYDATA\nPOINTS 900000000 double\n";
    assert!(vtk::parse(huge.as_bytes()).is_err());
}

fn gmsh_with_data(mesh: &TetMesh) -> Mesh {
    let mut mesh = mesh.clone();
    let data = crate::mesh::tets::VertexData::new("density", vec![1.0; 8]);
    mesh.vertex_data.push(data);
    Mesh::Tets(mesh)
}

#[test]
#[allow(clippy::too_many_lines, reason = "one table")]
fn formats_of_other_programs_are_refused_with_what_to_export() {
    let text = |bytes: &str| bytes.as_bytes().to_vec();
    let iges = format!("{:72}S      1\n", "");
    for (name, bytes, what, mend) in [
        (
            "a.step",
            text("ISO-10303-21;\nHEADER;"),
            "a STEP file",
            "STL",
        ),
        ("a", text("ISO-10303-21;\nHEADER;"), "a STEP file", "STL"),
        ("a.igs", text(&iges), "an IGES file", "STL"),
        (
            "a.dae",
            text("<?xml version=\"1.0\"?>\n<COLLADA>"),
            "a Collada file",
            "OBJ",
        ),
        (
            "a.xml",
            text("<?xml version=\"1.0\"?>\n<amf>"),
            "an AMF file",
            "3MF",
        ),
        (
            "a.fbx",
            text("Kaydara FBX Binary  \0"),
            "an FBX file",
            "OBJ",
        ),
        (
            "a.gltf",
            text("{\"asset\": {\"version\": \"2.0\"}}"),
            "a glTF file",
            "OBJ",
        ),
        ("a.blend", text("BLENDER-v279"), "a Blender file", "OBJ"),
        (
            "a.x_t",
            text("**ABCDEFGHIJKLMNOPQRSTUVWXYZ**"),
            "a Parasolid file",
            "STL",
        ),
        (
            "a.sldprt",
            text("anything"),
            "a file of a CAD program",
            "STL",
        ),
        (
            "a.3dm",
            text("3D Geometry File Format        4"),
            "a Rhino file",
            "STL",
        ),
        (
            "a.msh",
            text("(0 \"GAMBIT\")\n(2 3)"),
            "a mesh of ANSYS Fluent",
            "meshio",
        ),
        (
            "a.inp",
            text("*Heading\n** Job"),
            "an Abaqus deck",
            "meshio",
        ),
        ("a.cgns", text("\u{89}HDF"), "a file of a solver", "meshio"),
        (
            "a.meshb",
            vec![1, 0, 0, 0, 3],
            "a binary MEDIT file",
            "transmesh",
        ),
        (
            "a.pvtu",
            text("<?xml?><VTKFile type=\"PUnstructuredGrid\">"),
            "a VTK file of type PUnstructuredGrid",
            "export",
        ),
        (
            "a.stl.bz2",
            text("BZh91AY"),
            "a file packed by bzip2",
            "bunzip2",
        ),
        (
            "a.off.zst",
            vec![0x28, 0xb5, 0x2f, 0xfd],
            "a file packed by Zstandard",
            "unzstd",
        ),
    ] {
        let message = load_bytes(name, &bytes).unwrap_err();
        assert!(
            message.contains(what) && message.contains(mend),
            "{name}: {message}"
        );
    }
    for name in ["trimesh.glb", "sphere.step"] {
        let message = load(&case(name)).unwrap_err().to_string();
        assert!(message.contains("cannot be read; export"), "{message}");
    }
}

#[test]
fn flat_sheets_are_called_sheets() {
    let square = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
    let tilted = "OFF\n4 2 0\n0 0 0.5\n1 0.1 0.9\n1 1.1 1.9\n0 1 1.5\n3 0 1 2\n3 0 2 3\n";
    for sheet in [square, tilted] {
        let message = load_bytes("sheet.off", sheet.as_bytes()).unwrap_err();
        assert!(
            message.contains("is a flat sheet") && message.contains("polygon"),
            "{message}"
        );
    }
    let bent = square.replace("0 1 0\n3", "0 1 0.25\n3");
    let message = load_bytes("bent.off", bent.as_bytes()).unwrap_err();
    assert!(message.contains("is not closed"), "{message}");
    let plane = "OFF\n3 1 0\n0 0\n1 0\n0 1\n3 0 1 2\n";
    let message = load_bytes("plane.off", plane.as_bytes()).unwrap_err();
    assert!(message.contains("two coordinates"), "{message}");
}

#[test]
fn every_format_is_read_packed() {
    use std::io::Write as _;
    let pack = |bytes: &[u8]| {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let directory = TempDir::new().unwrap();
    let cube = shapes::unit_cube();
    let mut all = samples::surfaces(&cube);
    all.push(("stl", samples::stl_binary(&cube)));
    for (number, (extension, bytes)) in all.iter().enumerate() {
        let name = directory.path().join(format!("{number}.{extension}.gz"));
        fs::write(&name, pack(bytes)).unwrap();
        assert!(
            (load(&name).unwrap().volume() - 1.0).abs() < 1e-15,
            "{extension}"
        );
        // Cut anywhere, packed data are refused.
        let packed = pack(bytes);
        fs::write(&name, &packed[..packed.len() / 2]).unwrap();
        let message = load(&name).unwrap_err().to_string();
        assert!(message.contains("compressed data are damaged"), "{message}");
    }
    let mut tets = shapes::unit_cube_five_tets();
    let data = crate::mesh::tets::VertexData::new("rho", vec![1.0; 8]);
    tets.vertex_data.push(data);
    let (nodes, elements) = samples::tetgen(&tets, 1);
    fs::write(directory.path().join("t.1.node.gz"), pack(&nodes)).unwrap();
    fs::write(directory.path().join("t.1.ele.gz"), pack(&elements)).unwrap();
    for name in ["t.1.node.gz", "t.1.ele.gz"] {
        let solid = load(&directory.path().join(name)).unwrap();
        assert!((solid.volume() - 1.0).abs() < 1e-15);
    }
}

/// The cube as separate triangles, each moved outward by `gap`.
fn gaping(gap: f64) -> SurfaceMesh {
    let cube = shapes::unit_cube();
    let mut soup = SurfaceMesh::default();
    for (number, corners) in cube.all_corners().enumerate() {
        let first = soup.vertices.len() as u32;
        let shift = nalgebra::Vector3::repeat(gap * (number % 3) as f64 / 2.0);
        soup.vertices.extend(corners.map(|corner| corner + shift));
        soup.triangles.push([first, first + 1, first + 2]);
    }
    soup
}

#[test]
fn gaps_up_to_a_share_of_the_box_are_closed_and_told() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("soup.off");
    for (gap, weld, note) in [
        (
            0.0,
            0.0,
            Some("28 coincident vertices were merged to close the surface"),
        ),
        (5e-13, 0.0, Some("28 vertices up to ")),
        (1e-8, 0.0, None),
        (1e-8, 1.0001e-8, Some("28 vertices up to ")),
        (1e-3, 1.0e-2, Some("28 vertices up to ")),
    ] {
        let text = crate::mesh::formats::off::write(&gaping(gap));
        fs::write(&path, text).unwrap();
        let outcome = load_within(&path, weld).map_err(|error| error.to_string());
        match (outcome, note) {
            (Ok(solid), Some(note)) => {
                let notes = solid.notes();
                assert!(notes.len() == 1 && notes[0].starts_with(note), "{notes:?}");
                assert!((solid.volume() - 1.0).abs() <= 10.0 * gap + 1e-15);
            }
            (Err(message), None) => {
                assert!(
                    message.contains("not closed") && message.contains("--weld"),
                    "{message}"
                );
            }
            (outcome, _) => panic!("{gap} {weld}: {outcome:?}"),
        }
    }
}
