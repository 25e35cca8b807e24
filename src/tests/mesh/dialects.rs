//! Dialects of the formats that other programs write: the same solid, or data refused where used.

use std::path::{Path, PathBuf};

use crate::geometry::bounds::Bounds;
use crate::mass::weigh::weigh;
use crate::mesh::formats::mesh::Mesh;
use crate::mesh::formats::read::{load, read};
use crate::mesh::formats::{gmsh, medit, obj, off, ply, stl, vtk, vtu};
use crate::mesh::shapes;
use crate::mesh::validate::{Solid, validate_tets};
use crate::tests::mesh::difference;
use crate::tests::mesh::samples;
use tempfile::TempDir;

fn case(name: &str) -> PathBuf {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    cases.join(name)
}

/// The text of a case with other letters or line ends, loaded from a file of this extension.
fn load_text(extension: &str, text: &str) -> Solid {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("solid").with_extension(extension);
    std::fs::write(&path, text).unwrap();
    load(&path).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn assert_sixth(solid: &Solid, what: &str) {
    assert!(difference(solid.volume(), 1.0 / 6.0) < 1e-15, "{what}");
}

#[test]
fn the_cases_are_the_tetrahedron_that_they_hold() {
    for name in [
        "stl-binary-one-byte-too-many.stl",
        "stl-ascii-upper-case.stl",
        "stl-ascii-mixed-case.stl",
        "stl-ascii-end-solid.stl",
        "stl-ascii-text-after-tags.stl",
        "ply-cr-lines.ply",
        "vtk-global-ids.vtk",
        "vtk-string-field.vtk",
        "vtk-nan-in-unused-data.vtk",
        "msh22-parametric-nodes.msh",
        "msh22-node-data-for-three-of-four.msh",
    ] {
        assert_sixth(&load(&case(name)).unwrap(), name);
    }
}

#[test]
fn text_of_every_format_is_read_with_any_line_ends() {
    let mut mesh = shapes::unit_cube_five_tets();
    let values = (0..8).map(f64::from).collect();
    let data = crate::mesh::tets::VertexData::new("density", values);
    mesh.vertex_data.push(data);
    let mut all = samples::surfaces(&shapes::unit_cube());
    all.extend(samples::tets(&mesh));
    let mut tried = 0;
    for (extension, bytes) in all {
        let Ok(text) = String::from_utf8(bytes) else {
            continue;
        };
        // OFF's sample ends some lines with CR LF already.
        let text = text.replace('\r', "");
        if text.contains("big_endian") || text.contains("little_endian") {
            continue;
        }
        let read_as = |text: &str| {
            let directory = TempDir::new().unwrap();
            let path = directory.path().join("solid").with_extension(extension);
            std::fs::write(&path, text).unwrap();
            read(&path).unwrap_or_else(|error| panic!("{error}\n{text}"))
        };
        let expected = read_as(&text);
        for end in ["\r", "\r\n", "\r\r\n"] {
            assert_eq!(read_as(&text.replace('\n', end)), expected, "{extension}");
            tried += 1;
        }
    }
    assert!(tried >= 45, "{tried}");
}

#[test]
fn lines_are_counted_with_any_ends() {
    for end in ["\n", "\r", "\r\n"] {
        let text = "OFF\n3 1 0\n0 0 0\n1 zero 0\n".replace('\n', end);
        let error = off::parse(text.as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with(":4: expected a coordinate"), "{error}");
    }
}

/// The binary data's first byte is that of a line feed.
#[test]
fn binary_ply_begins_after_a_line_end_of_the_headers_kind() {
    for end in ["\n", "\r\n", "\r"] {
        let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar q\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar uchar vertex_index\nend_header\n";
        let mut bytes = header.replace('\n', end).into_bytes();
        for corner in [[0.0, 0.0, 0.0_f32], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
            bytes.push(b'\n');
            bytes.extend(corner.iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes.extend([3, 0, 1, 2]);
        let mesh = ply::parse(&bytes).unwrap();
        assert!((mesh.area() - 0.5).abs() < 1e-15, "{end:?}");
    }
}

#[test]
fn keywords_are_read_in_any_case() {
    let mesh = shapes::unit_cube();
    for (extension, bytes) in samples::surfaces(&mesh) {
        let Ok(text) = String::from_utf8(bytes) else {
            continue;
        };
        if text.contains("_endian") {
            continue;
        }
        // Numbers keep their exponents: f64 reads both letters. VTK's first line is fixed.
        for changed in [text.to_ascii_lowercase(), text.to_ascii_uppercase()] {
            let solid = load_text(extension, &changed);
            assert!(difference(solid.volume(), 1.0) < 1e-15, "{extension}");
        }
    }
    for name in ["vtk-global-ids.vtk", "msh22-parametric-nodes.msh"] {
        let text = std::fs::read_to_string(case(name)).unwrap();
        let extension = name.rsplit('.').next().unwrap();
        assert_sixth(&load_text(extension, &text.to_ascii_lowercase()), name);
        assert_sixth(&load_text(extension, &text.to_ascii_uppercase()), name);
    }
    let five = "# vtk DataFile Version 5.1\nx\nascii\ndataset unstructured_grid\npoints 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\nmetadata\ninformation 0\n\ncells 2 4\noffsets vtktypeint64\n0 4\nconnectivity vtktypeint64\n0 1 2 3\ncell_types 1\n10\n";
    assert_sixth(&load_text("vtk", five), five);
}

const VTK: &str = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nPOINT_DATA 4\n";

#[test]
fn attributes_of_vtk_that_are_no_scalars_are_passed_over() {
    let scalars = "SCALARS rho double 1\nLOOKUP_TABLE default\n1 2 3 4\n";
    for attribute in [
        "PEDIGREE_IDS p vtkIdType\n5 6 7 8\n".to_owned(),
        "PEDIGREE_IDS p string\na b\n\nc\nSCALARS\n".to_owned(),
        "global_ids g int\n0 1 2 3\n".to_owned(),
        format!("TENSORS6 t float\n{}\n", "1 2 3 4 5 6\n".repeat(4)),
        format!("TENSORS t float\n{}\n", "1 2 3\n".repeat(12)),
        "EDGE_FLAGS e bit\n0 1 1 0\n".to_owned(),
        "FIELD f 2\ns 2 4 string\na\nb\nc\n\nPOINTS 9 float\n%20\ng\nh\nn 1 4 int\n1 2 3 4\n"
            .to_owned(),
        "FIELD f 1\nv 1 4 variant\n13 one two\n13 a\n6 1\n6 2\n".to_owned(),
    ] {
        let Ok(Mesh::Tets(mesh)) = vtk::parse(format!("{VTK}{attribute}{scalars}").as_bytes())
        else {
            panic!("{attribute}");
        };
        assert_eq!(
            mesh.data("rho"),
            Some(&[1.0, 2.0, 3.0, 4.0][..]),
            "{attribute}"
        );
    }
}

/// The tetrahedron's mass by the vertex data `rho`, or why it has none.
fn mass(mesh: Mesh) -> Result<f64, String> {
    let Mesh::Tets(mesh) = mesh else {
        panic!("tetrahedra")
    };
    let (tets, report) = validate_tets(&mesh).map_err(|refusal| refusal.to_string())?;
    let bounds = Bounds::of(&mesh.vertices);
    let density = "vertex:rho".parse().unwrap();
    let solid = Solid::Tets(tets, report);
    assert_sixth(&solid, "data that are not used do no harm");
    let body = weigh(&solid, &density, &bounds);
    body.map(|body| body.mass)
        .map_err(|error| error.to_string())
}

fn gmsh_mass(data: &str) -> Result<f64, String> {
    let head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n10 0 0 0\n20 1 0 0\n30 0 1 0\n40 0 0 1\n50 9 9 9\n$EndNodes\n$Elements\n1\n5 4 2 0 1 10 20 30 40\n$EndElements\n";
    mass(gmsh::parse(format!("{head}{data}").as_bytes()).unwrap())
}

fn node_data(step: usize, values: &[&str]) -> String {
    let count = values.len();
    let lines = values.join("\n");
    format!("$NodeData\n1\n\"rho\"\n1\n0.0\n3\n{step}\n1\n{count}\n{lines}\n$EndNodeData\n")
}

fn assert_says(outcome: Result<f64, String>, words: &str) {
    let message = outcome.expect_err(words);
    assert!(message.contains(words), "{message}");
    assert!(
        message.contains("every node needs one finite value"),
        "{message}"
    );
}

#[test]
fn node_data_of_gmsh_with_gaps_or_repetitions_are_refused_by_node() {
    let whole = ["10 1", "20 2", "30 3", "40 6"];
    assert_eq!(gmsh_mass(&node_data(0, &whole)), Ok(0.5));
    // A node of no tetrahedron needs none, and two sections of one step are one field.
    let halves = node_data(0, &whole[..2]) + &node_data(0, &whole[2..]);
    assert_eq!(gmsh_mass(&halves), Ok(0.5));
    // A later step replaces the earlier, gaps and all.
    let steps = node_data(0, &["10 7"]) + &node_data(1, &whole);
    assert_eq!(gmsh_mass(&steps), Ok(0.5));
    let two_names = node_data(0, &whole).replace("1\n\"rho\"", "2\n\"rho\"\n\"scheme\"");
    assert_eq!(gmsh_mass(&two_names), Ok(0.5));
    let case = std::fs::read(case("msh22-node-data-for-three-of-four.msh")).unwrap();
    assert_says(mass(gmsh::parse(&case).unwrap()), "node 10 has no value");
    assert_says(
        gmsh_mass(&node_data(0, &whole[..3])),
        "node 40 has no value",
    );
    let twice = ["10 1", "20 2", "30 3", "40 6", "20 2"];
    assert_says(gmsh_mass(&node_data(0, &twice)), "node 20 has 2 values");
    let nan = ["10 1", "20 -nan(ind)", "30 3", "40 6"];
    assert_says(gmsh_mass(&node_data(0, &nan)), "node 20 has the value NaN");
}

#[test]
fn point_data_of_vtk_that_are_not_one_number_per_point_are_refused_where_used() {
    let of = |data: &str| mass(vtk::parse(format!("{VTK}{data}").as_bytes()).unwrap());
    let scalars = "SCALARS rho float\nLOOKUP_TABLE default\n";
    assert_eq!(of(&format!("{scalars}1 2 3 6\n")), Ok(0.5));
    assert_says(
        of(&format!("{scalars}1 2 nan 6\n")),
        "point 2 (counted from 0) has the value NaN",
    );
    assert_says(
        of("FIELD f 1\nrho 1 3 float\n1 2 3\n"),
        "it has 3 values for 4 points",
    );
    let twice = format!("{scalars}1 2 3 6\nFIELD f 1\nrho 1 4 float\n1 2 3 6\n");
    assert_says(of(&twice), "several fields of this name");
}

fn vtu_piece(data: &str, shift: i32) -> String {
    format!(
        "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><PointData>{data}</PointData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\">{shift} 0 0 {} 0 0 {shift} 1 0 {shift} 0 1</DataArray></Points><Cells><DataArray type=\"Int32\" Name=\"connectivity\">0 1 2 3</DataArray><DataArray type=\"Int32\" Name=\"offsets\">4</DataArray><DataArray type=\"UInt8\" Name=\"types\">10</DataArray></Cells></Piece>",
        shift + 1
    )
}

fn vtu_text(pieces: &str) -> String {
    format!(
        "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>{pieces}</UnstructuredGrid></VTKFile>"
    )
}

#[test]
fn point_data_of_vtu_that_are_not_one_number_per_point_are_refused_where_used() {
    let array =
        |values: &str| format!("<DataArray type=\"Float64\" Name=\"rho\">{values}</DataArray>");
    let of = |data: &str| mass(vtu::parse(vtu_text(&vtu_piece(data, 0)).as_bytes()).unwrap());
    assert_eq!(of(&array("1 2 3 6")), Ok(0.5));
    assert_says(of(&array("1 2 3")), "it has 3 values for 4 points");
    assert_says(
        of(&array("1 nan 3 6")),
        "point 1 (counted from 0) has the value NaN",
    );
    assert_says(
        of(&array("1 2 3 6").repeat(2)),
        "several fields of this name",
    );
    let complex = "<DataArray type=\"Complex\" Name=\"rho\">1</DataArray>";
    assert_says(of(complex), "the array of type Complex cannot be read");
    // Two solids, of which one has no data; an empty piece has none either.
    let [whole, bare] = [vtu_piece(&array("1 2 3 6"), 0), vtu_piece("", 5)];
    for pieces in [format!("{whole}{bare}"), format!("{bare}{whole}")] {
        let Ok(Mesh::Tets(mesh)) = vtu::parse(vtu_text(&pieces).as_bytes()) else {
            panic!("{pieces}");
        };
        let fault = mesh.field("rho").unwrap().checked().unwrap_err();
        assert!(fault.contains("a piece of the file lacks it"), "{fault}");
    }
    let empty = "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"></Piece>";
    let with_empty = vtu_text(&format!("{empty}{whole}{empty}"));
    assert_eq!(mass(vtu::parse(with_empty.as_bytes()).unwrap()), Ok(0.5));
    let short = whole.replace("NumberOfPoints=\"4\"", "NumberOfPoints=\"5\"");
    let error = vtu::parse(vtu_text(&short).as_bytes())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("5 points are announced, 4 are there"),
        "{error}"
    );
}

#[test]
fn attributes_of_tetgen_that_are_not_finite_are_refused_where_used() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("t.ele");
    std::fs::write(&path, "1 4 0\n1 1 2 3 4\n").unwrap();
    let nodes = "5 3 1 0\n1 0 0 0 1\n2 1 0 0 2\n3 0 1 0 inf\n4 0 0 1 6\n5 9 9 9 nan\n";
    std::fs::write(path.with_extension("node"), nodes).unwrap();
    let Ok(Mesh::Tets(mesh)) = read(&path) else {
        panic!("tetrahedra")
    };
    let fault = mesh.field("attribute1").unwrap().checked().unwrap_err();
    assert!(fault.contains("vertex 3 has the value inf"), "{fault}");
    assert_sixth(&load(&path).unwrap(), "unused");
}

#[test]
fn ply_refuses_what_it_would_read_twice_or_not_at_all() {
    let head = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n";
    for (rest, words) in [
        (
            "property float y\n",
            ":6: expected a property not named before, found `y`",
        ),
        (
            "property list uchar float z\nend_header\n0 0 1 0\n",
            "x, y, z",
        ),
        (
            "element vertex 1\n",
            ":6: expected an element not named before, found `vertex`",
        ),
    ] {
        let error = ply::parse(format!("{head}{rest}").as_bytes()).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn bytes_after_the_last_triangle_of_an_stl_pass_unless_they_are_triangles() {
    let mesh = shapes::unit_cube();
    let whole = samples::stl_binary(&mesh);
    let expected = stl::parse(&whole).unwrap();
    for extra in [1, 2, 49, 51, 100, 512] {
        let mut bytes = whole.clone();
        bytes.resize(whole.len() + extra, 0);
        assert_eq!(stl::parse(&bytes).unwrap(), expected, "{extra}");
    }
    let mut bytes = whole.clone();
    bytes[80] = 10;
    let error = stl::parse(&bytes).unwrap_err().to_string();
    assert!(
        error.contains("10 triangles are announced, 12 are there"),
        "{error}"
    );
}

#[test]
fn an_stl_of_few_lines_or_with_text_anywhere_is_read() {
    let corners = |normal: &str, tags: [&str; 3]| {
        let [start, end, last] = tags;
        let facet = |corners: [[f64; 3]; 3]| {
            let [a, b, c] = corners.map(|[x, y, z]| format!("vertex {x} {y} {z} {start}\n"));
            format!(
                "facet normal {normal} {start}\nouter loop {start}\n{a}{b}{c}{end} {start}\n{last} {start}\n"
            )
        };
        let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        [[o, y, x], [o, z, y], [x, y, z], [o, x, z]]
            .map(facet)
            .concat()
    };
    let plain = corners("0 0 0", ["", "endloop", "endfacet"]);
    for text in [
        format!("solid\n{plain}endsolid"),
        format!("Solid facet outer\n{plain}End Solid facet\n"),
        format!("solid\n{}", plain.replace('\n', " ") + "\nendsolid"),
        format!(
            "solid\n{}ENDSOLID x\n",
            corners("nan -nan(ind) 0", ["; note", "end loop", "End Facet"])
        ),
    ] {
        assert_sixth(&load_text("stl", &text), &text);
    }
    let lacking = plain.replacen("endloop", "vertex 1 1 1", 1);
    let error = stl::parse(format!("solid\n{lacking}endsolid").as_bytes());
    assert!(error.unwrap_err().to_string().contains("expected endloop"));
}

#[test]
fn small_letters_are_headers_of_off_too() {
    let text = off::write(&shapes::unit_cube());
    for header in ["off", "Off", "coff", "noff"] {
        let mesh = off::parse(text.replace("OFF", header).as_bytes()).unwrap();
        assert_eq!(mesh, shapes::unit_cube());
    }
    assert!(off::parse(text.replace("OFF", "nOFF").as_bytes()).is_err());
    assert!(obj::parse(b"V 0 0 0\nV 1 0 0\nV 0 1 0\nF 1 2 3\n").is_ok());
    assert!(medit::parse(b"meshversionformatted 1\nDIMENSION 3\nvertices 3\n0 0 0 0\n1 0 0 0\n0 1 0 0\ntriangles 1\n1 2 3 0\nEND\n").is_ok());
}

/// Found by `tests/mutants.rs`: the determinant was NaN and the tetrahedron turned without a word.
#[test]
fn a_coordinate_beyond_the_range_of_volumes_is_refused() {
    let head = VTK.replace("0 0 0 1 0 0 0 1 0", "2147483648 0 0 1 0 0 0 1 1e308");
    let Ok(Mesh::Tets(mesh)) = vtk::parse(head.as_bytes()) else {
        panic!("tetrahedra")
    };
    let message = validate_tets(&mesh).unwrap_err().to_string();
    assert!(message.contains("beyond 1e98 at vertex 2"), "{message}");
}
