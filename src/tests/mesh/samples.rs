//! The same solids written by the tests in every format: second opinions on the readers that
//! share no code with them.

use std::fmt::Write as _;
use std::io::Write as _;

use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::tests::mesh::samples_binary;

/// A format's file extension and a file of it.
pub(crate) type Sample = (&'static str, Vec<u8>);

/// `mesh` in every surface format, coordinates in full.
pub(crate) fn surfaces(mesh: &SurfaceMesh) -> Vec<Sample> {
    vec![
        ("off", off(mesh)),
        ("off", coff(mesh)),
        ("obj", obj(mesh)),
        ("obj", obj_backward(mesh)),
        ("stl", stl_text(mesh)),
        ("ply", ply_text(mesh)),
        ("ply", ply_binary(mesh, false)),
        ("ply", ply_binary(mesh, true)),
        ("mesh", medit_surface(mesh)),
        ("vtk", vtk_polydata(mesh)),
        ("vtp", samples_binary::vtp(mesh, false)),
        ("vtp", samples_binary::vtp(mesh, true)),
        ("3mf", samples_binary::three_mf(mesh)),
    ]
}

/// `mesh`, whose first vertex data are written where the format has them, in every format of
/// tetrahedra.
pub(crate) fn tets(mesh: &TetMesh) -> Vec<Sample> {
    let data = &mesh.vertex_data[0].values;
    vec![
        ("mesh", medit(mesh)),
        ("msh", gmsh_two(mesh, data)),
        ("msh", gmsh_four(mesh, data)),
        ("vtk", vtk_four(mesh, data)),
        ("vtk", vtk_five(mesh, data)),
        ("vtu", vtu(mesh, data, Vtu::Text)),
        ("vtu", vtu(mesh, data, Vtu::Base64)),
        ("vtu", vtu(mesh, data, Vtu::Compressed)),
        ("vtu", vtu(mesh, data, Vtu::Raw)),
        ("msh", samples_binary::gmsh(mesh, data, "2.2", false)),
        ("msh", samples_binary::gmsh(mesh, data, "4.0", true)),
        ("msh", samples_binary::gmsh(mesh, data, "4.1", false)),
        ("msh", samples_binary::gmsh(mesh, data, "4.1", true)),
        ("vtk", samples_binary::vtk(mesh, data, false)),
        ("vtk", samples_binary::vtk(mesh, data, true)),
    ]
}

fn off(mesh: &SurfaceMesh) -> Vec<u8> {
    let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
    let mut text = format!("OFF {vertices} {triangles} 0 # counts beside the header\n\n");
    for p in &mesh.vertices {
        writeln!(text, "{:?}\t{:e} {}\r", p.x, p.y, p.z).unwrap();
    }
    text.push_str("# faces\n");
    for [a, b, c] in &mesh.triangles {
        writeln!(text, "3  {a} {b} {c}").unwrap();
    }
    text.into_bytes()
}

fn coff(mesh: &SurfaceMesh) -> Vec<u8> {
    let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
    let mut text = format!("# a comment first\nCOFF\n{vertices} {triangles}\n");
    for p in &mesh.vertices {
        writeln!(text, "{} {} {} 255 0 0 255", p.x, p.y, p.z).unwrap();
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(text, "3 {a} {b} {c} 0.5 0.5 0.5").unwrap();
    }
    text.into_bytes()
}

fn obj(mesh: &SurfaceMesh) -> Vec<u8> {
    let mut text = String::from("mtllib none.mtl\no solid\n");
    for p in &mesh.vertices {
        writeln!(text, "v {} {} {} 1.0", p.x, p.y, p.z).unwrap();
    }
    text.push_str("vt 0 0\nvn 0 0 1\ns off\n");
    for (k, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|vertex| vertex + 1);
        match k % 4 {
            0 => writeln!(text, "f {a} {b} {c}"),
            1 => writeln!(text, "f {a}/1 {b}/1 {c}/1 # with texture"),
            2 => writeln!(text, "f {a}//1 {b}//1 {c}//1"),
            _ => writeln!(text, "f {a}/1/1 \\\n {b}/1/1 {c}/1/1"),
        }
        .unwrap();
    }
    text.into_bytes()
}

/// Indices counted from the last vertex.
fn obj_backward(mesh: &SurfaceMesh) -> Vec<u8> {
    let mut text = String::new();
    for p in &mesh.vertices {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| i64::from(vertex) - mesh.vertices.len() as i64);
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    text.into_bytes()
}

fn stl_text(mesh: &SurfaceMesh) -> Vec<u8> {
    let mut text = String::from("solid a facet of its name\n");
    for corners in mesh.all_corners() {
        text.push_str("  facet normal nan 0 0\n    outer loop\n");
        for p in corners {
            writeln!(text, "      vertex {} {} {}", p.x, p.y, p.z).unwrap();
        }
        text.push_str("    endloop\n  endfacet\n");
    }
    text.push_str("endsolid a facet of its name\n");
    text.into_bytes()
}

/// Binary STL, whose coordinates are f32, behind a header that starts like a text file.
pub(crate) fn stl_binary(mesh: &SurfaceMesh) -> Vec<u8> {
    let mut bytes = b"solid but binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for corners in mesh.all_corners() {
        bytes.extend([0; 12]);
        for p in corners {
            bytes.extend(
                p.iter()
                    .flat_map(|&coordinate| (coordinate as f32).to_le_bytes()),
            );
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn ply_text(mesh: &SurfaceMesh) -> Vec<u8> {
    let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
    let mut text = format!(
        "ply\nformat ascii 1.0\ncomment made by a test\nelement vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\nelement face {triangles}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    for p in &mesh.vertices {
        writeln!(text, "{} {} {}", p.x, p.y, p.z).unwrap();
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    text.into_bytes()
}

/// Binary PLY with properties in a strange order and strange company.
fn ply_binary(mesh: &SurfaceMesh, big_endian: bool) -> Vec<u8> {
    let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
    let format = if big_endian { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{format}_endian 1.0\nelement camera 2\nproperty list uchar short shots\nelement vertex {vertices}\nproperty uchar red\nproperty double z\nproperty float quality\nproperty double x\nproperty double y\nelement face {triangles}\nproperty int label\nproperty list ushort uint vertex_index\nproperty list uchar float texcoord\nend_header\n"
    )
    .into_bytes();
    let mut put = |number: &[u8]| {
        let ordered: Vec<u8> = if big_endian {
            number.iter().rev().copied().collect()
        } else {
            number.to_vec()
        };
        bytes.extend(ordered);
    };
    for shots in [2_u8, 0] {
        put(&[shots]);
        (0..shots).for_each(|shot| put(&i16::from(shot).to_le_bytes()));
    }
    for p in &mesh.vertices {
        put(&[7]);
        put(&p.z.to_le_bytes());
        put(&f32::NAN.to_le_bytes());
        put(&p.x.to_le_bytes());
        put(&p.y.to_le_bytes());
    }
    for triangle in &mesh.triangles {
        put(&(-1_i32).to_le_bytes());
        put(&3_u16.to_le_bytes());
        triangle
            .iter()
            .for_each(|vertex| put(&vertex.to_le_bytes()));
        put(&[1]);
        put(&0.5_f32.to_le_bytes());
    }
    bytes
}

fn medit_surface(mesh: &SurfaceMesh) -> Vec<u8> {
    let mut text = String::from("MeshVersionFormatted 1\n\nDimension\n3\n# vertices\nVertices\n");
    writeln!(text, "{}", mesh.vertices.len()).unwrap();
    for p in &mesh.vertices {
        writeln!(text, "{} {} {} 1", p.x, p.y, p.z).unwrap();
    }
    writeln!(
        text,
        "Corners\n1\n1\nTetrahedra 0\nTriangles\n{}",
        mesh.triangles.len()
    )
    .unwrap();
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|vertex| vertex + 1)) {
        writeln!(text, "{a} {b} {c} 5").unwrap();
    }
    text.push_str("End\n");
    text.into_bytes()
}

fn vtk_polydata(mesh: &SurfaceMesh) -> Vec<u8> {
    let mut text = String::from("# vtk DataFile Version 3.0\nsurface\nASCII\nDATASET POLYDATA\n");
    writeln!(text, "POINTS {} double", mesh.vertices.len()).unwrap();
    for p in &mesh.vertices {
        writeln!(text, "{} {} {}", p.x, p.y, p.z).unwrap();
    }
    let count = mesh.triangles.len();
    writeln!(text, "POLYGONS {count} {}", 4 * count).unwrap();
    for [a, b, c] in &mesh.triangles {
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    text.into_bytes()
}

fn medit(mesh: &TetMesh) -> Vec<u8> {
    let mut text = String::from("MeshVersionFormatted 2 Dimension 3 Vertices\n");
    writeln!(text, "{}", mesh.vertices.len()).unwrap();
    for p in &mesh.vertices {
        writeln!(text, "{} {} {} 0", p.x, p.y, p.z).unwrap();
    }
    writeln!(text, "Triangles 1\n1 2 3 0\nTetrahedra {}", mesh.tets.len()).unwrap();
    for [a, b, c, d] in mesh.tets.iter().map(|t| t.map(|vertex| vertex + 1)) {
        writeln!(text, "{a} {b} {c} {d} 0").unwrap();
    }
    text.push_str("Edges\n1\n1 2 0\nEnd\n");
    text.into_bytes()
}

/// Tags 10, 20, 30, … for the vertices.
fn gmsh_two(mesh: &TetMesh, data: &[f64]) -> Vec<u8> {
    let mut text = String::from(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"body\"\n$EndPhysicalNames\n",
    );
    writeln!(text, "$Nodes\n{}", mesh.vertices.len()).unwrap();
    for (k, p) in mesh.vertices.iter().enumerate() {
        writeln!(text, "{} {} {} {}", 10 * k + 10, p.x, p.y, p.z).unwrap();
    }
    writeln!(
        text,
        "$EndNodes\n$Elements\n{}\n1 15 2 0 1 10",
        mesh.tets.len() + 2
    )
    .unwrap();
    text.push_str("2 2 2 0 1 10 20 30\n");
    for (k, [a, b, c, d]) in mesh.tets.iter().map(|t| t.map(|v| 10 * v + 10)).enumerate() {
        writeln!(text, "{} 4 2 1 1 {a} {b} {c} {d}", k + 3).unwrap();
    }
    text.push_str("$EndElements\n");
    gmsh_data(&mut text, data);
    text.into_bytes()
}

/// Two node blocks, the second with the parameters of a curved face.
fn gmsh_four(mesh: &TetMesh, data: &[f64]) -> Vec<u8> {
    let count = mesh.vertices.len();
    let mut text = String::from(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 1 1 1 0 0\n$EndEntities\n",
    );
    writeln!(text, "$Nodes\n2 {count} 10 {}", 10 * count).unwrap();
    for (dimension, parametric, range) in [(3, 0, 0..count - 2), (2, 1, count - 2..count)] {
        writeln!(text, "{dimension} 1 {parametric} {}", range.len()).unwrap();
        for k in range.clone() {
            writeln!(text, "{}", 10 * k + 10).unwrap();
        }
        for p in &mesh.vertices[range] {
            let parameters = if parametric == 1 { " 0.5 0.5" } else { "" };
            writeln!(text, "{} {} {}{parameters}", p.x, p.y, p.z).unwrap();
        }
    }
    let tets = mesh.tets.len();
    writeln!(
        text,
        "$EndNodes\n$Elements\n2 {} 1 {}\n1 1 1 1\n1 10 20",
        tets + 1,
        tets + 1
    )
    .unwrap();
    writeln!(text, "3 1 4 {tets}").unwrap();
    for (k, [a, b, c, d]) in mesh.tets.iter().map(|t| t.map(|v| 10 * v + 10)).enumerate() {
        writeln!(text, "{} {a} {b} {c} {d}", k + 2).unwrap();
    }
    text.push_str("$EndElements\n");
    gmsh_data(&mut text, data);
    text.into_bytes()
}

/// A vector field, which is passed over, and the scalar field.
fn gmsh_data(text: &mut String, data: &[f64]) {
    text.push_str("$NodeData\n1\n\"wind\"\n1\n0.0\n3\n0\n3\n1\n10 1 2 3\n$EndNodeData\n");
    writeln!(
        text,
        "$NodeData\n1\n\"density\"\n1\n0.0\n3\n0\n1\n{}",
        data.len()
    )
    .unwrap();
    for (k, value) in data.iter().enumerate() {
        writeln!(text, "{} {value}", 10 * k + 10).unwrap();
    }
    text.push_str("$EndNodeData\n");
}

/// TetGen's two files, numbered from `first`.
pub(crate) fn tetgen(mesh: &TetMesh, first: u32) -> (Vec<u8>, Vec<u8>) {
    let data = &mesh.vertex_data[0].values;
    let mut nodes = format!("# nodes\n{} 3 1 1\n", mesh.vertices.len());
    for (k, (p, value)) in (first..).zip(mesh.vertices.iter().zip(data)) {
        writeln!(nodes, "{k}  {} {} {}  {value} 1", p.x, p.y, p.z).unwrap();
    }
    let mut elements = format!("{} 4 1\n", mesh.tets.len());
    for (k, [a, b, c, d]) in (first..).zip(mesh.tets.iter().map(|t| t.map(|v| v + first))) {
        writeln!(elements, "{k} {a} {b} {c} {d} 9 # region").unwrap();
    }
    (nodes.into_bytes(), elements.into_bytes())
}

fn vtk_points(mesh: &TetMesh, version: &str) -> String {
    let mut text =
        format!("# vtk DataFile Version {version}\nany title\nASCII\nDATASET UNSTRUCTURED_GRID\n");
    writeln!(text, "POINTS {} double", mesh.vertices.len()).unwrap();
    for p in &mesh.vertices {
        write!(text, "{} {} {} ", p.x, p.y, p.z).unwrap();
    }
    text.push('\n');
    text
}

fn vtk_four(mesh: &TetMesh, data: &[f64]) -> Vec<u8> {
    let count = mesh.tets.len();
    let mut text = vtk_points(mesh, "3.0");
    writeln!(text, "CELLS {count} {}", 5 * count).unwrap();
    for [a, b, c, d] in &mesh.tets {
        writeln!(text, "4 {a} {b} {c} {d}").unwrap();
    }
    writeln!(text, "CELL_TYPES {count}\n{}", "10\n".repeat(count)).unwrap();
    writeln!(
        text,
        "CELL_DATA {count}\nSCALARS region int 1\nLOOKUP_TABLE default\n{}",
        "1 ".repeat(count)
    )
    .unwrap();
    writeln!(
        text,
        "POINT_DATA {}\nVECTORS wind float\n{}",
        data.len(),
        "0 0 1\n".repeat(data.len())
    )
    .unwrap();
    text.push_str("SCALARS density double\nLOOKUP_TABLE default\n");
    data.iter()
        .for_each(|value| writeln!(text, "{value}").unwrap());
    text.into_bytes()
}

fn vtk_five(mesh: &TetMesh, data: &[f64]) -> Vec<u8> {
    let count = mesh.tets.len();
    let mut text = vtk_points(mesh, "5.1");
    text.push_str("METADATA\nINFORMATION 0\n\n");
    writeln!(
        text,
        "CELLS {} {}\nOFFSETS vtktypeint64",
        count + 1,
        4 * count
    )
    .unwrap();
    (0..=count).for_each(|k| write!(text, "{} ", 4 * k).unwrap());
    text.push_str("\nCONNECTIVITY vtktypeint64\n");
    mesh.tets
        .iter()
        .flatten()
        .for_each(|vertex| write!(text, "{vertex} ").unwrap());
    writeln!(text, "\nCELL_TYPES {count}\n{}", "10\n".repeat(count)).unwrap();
    writeln!(
        text,
        "POINT_DATA {}\nFIELD FieldData 2\nwind 2 {} double",
        data.len(),
        data.len()
    )
    .unwrap();
    text.push_str(&"1 2 ".repeat(data.len()));
    writeln!(text, "\ndensity 1 {} double", data.len()).unwrap();
    data.iter()
        .for_each(|value| write!(text, "{value} ").unwrap());
    text.into_bytes()
}

#[derive(Clone, Copy, PartialEq)]
enum Vtu {
    Text,
    Base64,
    Compressed,
    Raw,
}

fn vtu(mesh: &TetMesh, data: &[f64], mode: Vtu) -> Vec<u8> {
    let compressor = if mode == Vtu::Compressed {
        " compressor=\"vtkZLibDataCompressor\""
    } else {
        ""
    };
    let order = if mode == Vtu::Raw {
        "BigEndian"
    } else {
        "LittleEndian"
    };
    let points: Vec<f64> = mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    let corners: Vec<f64> = mesh
        .tets
        .iter()
        .flatten()
        .map(|&vertex| f64::from(vertex))
        .collect();
    let offsets: Vec<f64> = (1..=mesh.tets.len()).map(|k| (4 * k) as f64).collect();
    let mut file = VtuFile {
        mode,
        text: String::new(),
        appended: Vec::new(),
    };
    write!(file.text, "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{order}\" header_type=\"UInt64\"{compressor}>\n<UnstructuredGrid>\n").unwrap();
    writeln!(
        file.text,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData>",
        mesh.vertices.len(),
        mesh.tets.len()
    )
    .unwrap();
    file.array("density", 1, "Float64", data);
    file.array("wind", 3, "Float64", &points);
    file.text.push_str("</PointData>\n<Points>\n");
    file.array("Points", 3, "Float64", &points);
    file.text.push_str("</Points>\n<Cells>\n");
    file.array("connectivity", 1, "Int64", &corners);
    file.array("offsets", 1, "Int64", &offsets);
    file.array("types", 1, "UInt8", &vec![10.0; mesh.tets.len()]);
    file.text
        .push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n");
    file.finish()
}

struct VtuFile {
    mode: Vtu,
    text: String,
    appended: Vec<u8>,
}

impl VtuFile {
    fn array(&mut self, name: &str, components: usize, kind: &str, numbers: &[f64]) {
        let tag = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\""
        );
        let encode = |&x: &f64| match kind {
            "Float64" => x.to_le_bytes().to_vec(),
            "Int64" => (x as i64).to_le_bytes().to_vec(),
            _ => vec![x as u8],
        };
        let bytes: Vec<u8> = numbers.iter().flat_map(encode).collect();
        let mut all = (bytes.len() as u64).to_le_bytes().to_vec();
        match self.mode {
            Vtu::Text => {
                let numbers: Vec<String> = numbers.iter().map(ToString::to_string).collect();
                writeln!(
                    self.text,
                    "{tag} format=\"ascii\">\n{}\n</DataArray>",
                    numbers.join(" ")
                )
            }
            Vtu::Base64 => {
                all.extend(bytes);
                writeln!(
                    self.text,
                    "{tag} format=\"binary\">\n  {}\n</DataArray>",
                    base64(&all)
                )
            }
            Vtu::Compressed => {
                writeln!(
                    self.text,
                    "{tag} format=\"binary\">{}</DataArray>",
                    compressed(&bytes)
                )
            }
            Vtu::Raw => {
                let offset = self.appended.len();
                self.appended.extend(all.iter().rev());
                self.appended
                    .extend(numbers.iter().flat_map(|x| encode(x).into_iter().rev()));
                writeln!(self.text, "{tag} format=\"appended\" offset=\"{offset}\"/>")
            }
        }
        .unwrap();
    }

    fn finish(self) -> Vec<u8> {
        let mut file = self.text.into_bytes();
        if self.mode == Vtu::Raw {
            file.extend(b"<AppendedData encoding=\"raw\">\n_");
            file.extend(self.appended);
            file.extend(b"\n</AppendedData>\n");
        }
        file.extend(b"</VTKFile>\n");
        file
    }
}

/// Blocks of 1000 bytes, as VTK's writer splits and encodes them.
fn compressed(bytes: &[u8]) -> String {
    let blocks: Vec<Vec<u8>> = bytes
        .chunks(1000)
        .map(|block| {
            let mut encoder =
                flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            encoder.write_all(block).unwrap();
            encoder.finish().unwrap()
        })
        .collect();
    let mut header = vec![blocks.len() as u64, 1000, (bytes.len() % 1000) as u64];
    header.extend(blocks.iter().map(|block| block.len() as u64));
    let header: Vec<u8> = header
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    base64(&header) + &base64(&blocks.concat())
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = (0..3).fold(0_u32, |bits, k| {
            bits << 8 | u32::from(*group.get(k).unwrap_or(&0))
        });
        for k in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * k) & 63) as usize];
            text.push(if k <= group.len() {
                letter as char
            } else {
                '='
            });
        }
    }
    text
}
