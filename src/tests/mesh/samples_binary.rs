//! Binary files of the formats that are mostly text, in either byte order, and packages: written by the
//! tests, to the letter of the formats' descriptions.

use std::fmt::Write as _;
use std::io::Write as _;

use flate2::write::DeflateEncoder;
use flate2::{Compression, Crc};

use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;

/// Numbers one after the other, in one byte order.
struct Binary {
    bytes: Vec<u8>,
    big_endian: bool,
}

impl Binary {
    fn new(text: &str, big_endian: bool) -> Self {
        let bytes = text.as_bytes().to_vec();
        Self { bytes, big_endian }
    }

    fn put(&mut self, little: &[u8]) {
        match self.big_endian {
            true => self.bytes.extend(little.iter().rev()),
            false => self.bytes.extend(little),
        }
    }

    fn ints(&mut self, numbers: &[i32]) {
        numbers.iter().for_each(|n| self.put(&n.to_le_bytes()));
    }

    fn sizes(&mut self, numbers: &[u64]) {
        numbers.iter().for_each(|n| self.put(&n.to_le_bytes()));
    }

    fn reals(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|n| self.put(&n.to_le_bytes()));
    }

    fn text(&mut self, text: &str) {
        self.bytes.extend(text.as_bytes());
    }
}

/// Gmsh 2.2, 4.0 or 4.1; tags 10, 20, 30, … for the vertices.
pub(crate) fn gmsh(mesh: &TetMesh, data: &[f64], version: &str, big_endian: bool) -> Vec<u8> {
    let mut file = Binary::new(&format!("$MeshFormat\n{version} 1 8\n"), big_endian);
    file.ints(&[1]);
    file.text("\n$EndMeshFormat\n$Comments\nany \0 bytes $Nodes\n$EndComments\n$Nodes\n");
    let count = mesh.vertices.len();
    let tag = |vertex: usize| 10 * vertex as i32 + 10;
    match version {
        "2.2" => file.text(&format!("{count}\n")),
        "4.0" => {
            file.sizes(&[1, count as u64]);
            file.ints(&[1, 3, 0]);
            file.sizes(&[count as u64]);
        }
        _ => {
            file.sizes(&[1, count as u64, 10, 10 * count as u64]);
            // Parameters of a face behind the coordinates.
            file.ints(&[2, 1, 1]);
            file.sizes(&[count as u64]);
            (0..count).for_each(|vertex| file.sizes(&[tag(vertex) as u64]));
        }
    }
    for (vertex, point) in mesh.vertices.iter().enumerate() {
        if version != "4.1" {
            file.ints(&[tag(vertex)]);
        }
        file.reals(&[point.x, point.y, point.z]);
        if version == "4.1" {
            file.reals(&[0.5, 0.25]);
        }
    }
    file.text("\n$EndNodes\n$Elements\n");
    gmsh_elements(&mut file, mesh, version);
    file.text("\n$EndElements\n$NodeData\n1\n\"density\"\n1\n0.0\n3\n0\n1\n");
    file.text(&format!("{count}\n"));
    for (vertex, value) in data.iter().enumerate() {
        file.ints(&[tag(vertex)]);
        file.reals(&[*value]);
    }
    file.text("\n$EndNodeData\n");
    file.bytes
}

/// A point, a triangle, and the tetrahedra.
fn gmsh_elements(file: &mut Binary, mesh: &TetMesh, version: &str) {
    let corners = |tet: &[u32; 4]| tet.map(|vertex| 10 * vertex as i32 + 10);
    let count = mesh.tets.len() as u64 + 2;
    let blocks: [(i32, Vec<Vec<i32>>); 3] = [
        (15, vec![vec![10]]),
        (2, vec![vec![10, 20, 30]]),
        (4, mesh.tets.iter().map(|t| corners(t).to_vec()).collect()),
    ];
    match version {
        "2.2" => file.text(&format!("{count}\n")),
        "4.0" => file.sizes(&[3, count]),
        _ => file.sizes(&[3, count, 1, count]),
    }
    for (kind, elements) in blocks {
        match version {
            "2.2" => file.ints(&[kind, elements.len() as i32, 2]),
            _ => {
                file.ints(&[3, 1, kind]);
                file.sizes(&[elements.len() as u64]);
            }
        }
        for (number, nodes) in (1..).zip(elements) {
            match version {
                "2.2" => file.ints(&[number, 1, 1]),
                "4.0" => file.ints(&[number]),
                _ => file.sizes(&[number as u64]),
            }
            match version {
                "4.1" => nodes.iter().for_each(|&node| file.sizes(&[node as u64])),
                _ => file.ints(&nodes),
            }
        }
    }
}

/// Legacy VTK: lists with counts before each cell, or offsets and connectivity.
pub(crate) fn vtk(mesh: &TetMesh, data: &[f64], has_offsets: bool) -> Vec<u8> {
    let version = if has_offsets { "5.1" } else { "3.0" };
    let count = mesh.vertices.len();
    let head = format!(
        "# vtk DataFile Version {version}\nbinary\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS {count} double\n"
    );
    let mut file = Binary::new(&head, true);
    for point in &mesh.vertices {
        file.reals(&[point.x, point.y, point.z]);
    }
    let tets = mesh.tets.len();
    if has_offsets {
        file.text(&format!(
            "\nCELLS {} {}\nOFFSETS vtktypeint64\n",
            tets + 1,
            4 * tets
        ));
        (0..=tets as u64).for_each(|k| file.sizes(&[4 * k]));
        file.text("\nCONNECTIVITY vtktypeint64\n");
        let corners = mesh.tets.iter().flatten();
        corners.for_each(|&vertex| file.sizes(&[u64::from(vertex)]));
    } else {
        file.text(&format!("\nCELLS {tets} {}\n", 5 * tets));
        for [a, b, c, d] in mesh.tets.iter().map(|tet| tet.map(|v| v as i32)) {
            file.ints(&[4, a, b, c, d]);
        }
    }
    file.text(&format!("\nCELL_TYPES {tets}\n"));
    file.ints(&vec![10; tets]);
    file.text(&format!(
        "\nPOINT_DATA {count}\nSCALARS density double\nLOOKUP_TABLE default\n"
    ));
    file.reals(data);
    file.text(&format!("\nFIELD FieldData 2\nnames 1 {count} string\n"));
    for vertex in 0..count {
        // Short texts have their length in one byte, longer ones in two.
        let long = if vertex == 0 { 100 } else { 5 };
        match long {
            5 => file.bytes.push(0b1100_0000 | 5),
            _ => file.put(&(0x8000_u16 | 100).to_le_bytes()),
        }
        file.bytes.extend(std::iter::repeat_n(b'n', long));
    }
    file.text(&format!("\nflags 1 {count} bit\n"));
    file.bytes.extend(vec![0xff; count.div_ceil(8)]);
    file.text("\n");
    file.bytes
}

/// Raw appended polygonal data of either byte order.
pub(crate) fn vtp(mesh: &SurfaceMesh, big_endian: bool) -> Vec<u8> {
    let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
    let order = if big_endian {
        "BigEndian"
    } else {
        "LittleEndian"
    };
    let lengths = [24 * vertices, 12 * triangles, 8 * triangles];
    let [points, corners, _] = lengths.map(|length| length + 8);
    let array = |kind: &str, name: &str, offset: usize| {
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"3\" format=\"appended\" offset=\"{offset}\"/>\n"
        )
    };
    let head = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{order}\" header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"{vertices}\" NumberOfVerts=\"0\" NumberOfPolys=\"{triangles}\">\n<Points>\n{}</Points>\n<Verts>\n</Verts>\n<Polys>\n{}{}</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_",
        array("Float64", "Points", 0),
        array("Int32", "connectivity", points),
        array("Int64", "offsets", points + corners),
    );
    let mut file = Binary::new(&head, big_endian);
    file.sizes(&[lengths[0] as u64]);
    for point in &mesh.vertices {
        file.reals(&[point.x, point.y, point.z]);
    }
    file.sizes(&[lengths[1] as u64]);
    let corners = mesh.triangles.iter().flatten();
    corners.for_each(|&vertex| file.ints(&[vertex as i32]));
    file.sizes(&[lengths[2] as u64]);
    (1..=triangles as u64).for_each(|k| file.sizes(&[3 * k]));
    file.text("\n</AppendedData>\n</VTKFile>\n");
    file.bytes
}

/// A package of one object, and one for support, which is left out.
pub(crate) fn three_mf(mesh: &SurfaceMesh) -> Vec<u8> {
    let mut object = String::from("<mesh>\n<vertices>\n");
    for p in &mesh.vertices {
        writeln!(
            object,
            "<vertex x=\"{}\" y=\"{}\" z=\"{}\" />",
            p.x, p.y, p.z
        )
        .unwrap();
    }
    object.push_str("</vertices>\n<triangles>\n");
    for [a, b, c] in &mesh.triangles {
        writeln!(object, "<triangle v1='{a}' v2='{b}' v3='{c}'/>").unwrap();
    }
    object.push_str("</triangles>\n</mesh>\n");
    three_mf_of(
        &[("7", "model", &object), ("8", "support", &object)],
        "<item objectid=\"7\"/><item objectid=\"8\"/>",
    )
}

/// A package of objects, each with its number, type and content, and a build.
pub(crate) fn three_mf_of(objects: &[(&str, &str, &str)], build: &str) -> Vec<u8> {
    let mut model = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n<resources>\n",
    );
    for (number, kind, content) in objects {
        writeln!(
            model,
            "<object id=\"{number}\" type=\"{kind}\">\n{content}</object>"
        )
        .unwrap();
    }
    writeln!(model, "</resources>\n<build>{build}</build>\n</model>").unwrap();
    let relations = "<Relationships><Relationship Target=\"/3D/part.model\" Id=\"r\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    zip(&[
        ("_rels/.rels", relations, false),
        ("3D/part.model", &model, true),
    ])
}

/// An archive of texts, each stored or deflated.
pub(crate) fn zip(files: &[(&str, &str, bool)]) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for &(name, text, is_deflated) in files {
        let mut crc = Crc::new();
        crc.update(text.as_bytes());
        let content = match is_deflated {
            false => text.as_bytes().to_vec(),
            true => {
                let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
                encoder.write_all(text.as_bytes()).unwrap();
                encoder.finish().unwrap()
            }
        };
        let start = bytes.len() as u32;
        let mut common = Vec::new();
        for field in [20_u16, 0, if is_deflated { 8 } else { 0 }, 0, 33] {
            common.extend(field.to_le_bytes());
        }
        for field in [crc.sum(), content.len() as u32, text.len() as u32] {
            common.extend(field.to_le_bytes());
        }
        common.extend((name.len() as u16).to_le_bytes());
        common.extend(0_u16.to_le_bytes());
        bytes.extend(b"PK\x03\x04");
        bytes.extend(&common);
        bytes.extend(name.as_bytes());
        bytes.extend(&content);
        directory.extend(b"PK\x01\x02\x14\x00");
        directory.extend(&common);
        directory.extend([0; 10]);
        directory.extend(start.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let start = bytes.len() as u32;
    bytes.extend(&directory);
    bytes.extend(b"PK\x05\x06\0\0\0\0");
    bytes.extend((files.len() as u16).to_le_bytes());
    bytes.extend((files.len() as u16).to_le_bytes());
    bytes.extend((directory.len() as u32).to_le_bytes());
    bytes.extend(start.to_le_bytes());
    bytes.extend([0; 2]);
    bytes
}
