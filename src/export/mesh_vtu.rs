//! `mesh.vtu`: a conforming mesh as a VTK file, points shared between cells.
//!
//! The format is that of `cells.vtu` (`export::vtu`): XML, version 1.0, arrays appended as raw
//! little-endian binary. Hexahedra, prisms, pyramids and tetrahedra have VTK's own types (12, 13, 14,
//! 10), other cells are polyhedra (42) with `faces` and `faceoffsets`. A prism's first triangle runs
//! counter-clockwise as seen from inside, as in hexahedra: with the other order, which VTK's documentation shows,
//! VTK's own filters find negative volumes (9.7.2).

use std::io::{self, Write};
use std::path::Path;

use nalgebra::Point3;

use crate::complex::element::CellElement;
use crate::export::atomic_write;
use crate::mesh::poly_mesh::{CellFaces, PolyMesh};

/// Numbers for every cell.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CellColumn {
    /// Whole numbers.
    Integers(Vec<i64>),
    /// Real numbers.
    Reals(Vec<f64>),
}

/// An array of the file: section, type, name, bytes.
pub(crate) type FileArray = (&'static str, &'static str, String, Vec<u8>);

/// Writes `mesh` with a column of numbers for each name. Unless `standard` types are wanted, all cells
/// are polyhedra.
///
/// # Errors
/// The error of the system; the file is then as it was before.
pub(crate) fn write_mesh(
    path: &Path,
    mesh: &PolyMesh,
    columns: &[(&str, CellColumn)],
    standard: bool,
) -> io::Result<()> {
    let points = mesh.points.iter();
    let coordinates = real_bytes(points.flat_map(|point| [point.x, point.y, point.z]));
    let mut arrays = vec![("Points", "Float64", "Points".to_owned(), coordinates)];
    arrays.extend(cell_arrays(mesh, standard));
    arrays.extend(
        columns
            .iter()
            .map(|(name, column)| column_array(name, column)),
    );
    let counts = [mesh.points.len(), mesh.cell_count];
    atomic_write::write(path, |file| write_arrays(file, counts, &arrays))
}

/// Cells of VTK's own types.
#[derive(Clone, Debug, Default)]
pub(crate) struct GridArrays {
    pub(crate) points: Vec<Point3<f64>>,
    pub(crate) connectivity: Vec<i64>,
    /// Where every cell's corners end in `connectivity`.
    pub(crate) offsets: Vec<i64>,
    pub(crate) types: Vec<u8>,
}

/// Writes cells with a column of numbers for each name.
///
/// # Errors
/// The error of the system; the file is then as it was before.
pub(crate) fn write_grid(
    path: &Path,
    grid: &GridArrays,
    columns: &[(&str, CellColumn)],
) -> io::Result<()> {
    let points = grid
        .points
        .iter()
        .flat_map(|point| <[f64; 3]>::from(*point));
    let named = |section, kind, name: &str, bytes| (section, kind, name.to_owned(), bytes);
    let mut arrays = vec![
        named("Points", "Float64", "Points", real_bytes(points)),
        named(
            "Cells",
            "Int64",
            "connectivity",
            integer_bytes(&grid.connectivity),
        ),
        named("Cells", "Int64", "offsets", integer_bytes(&grid.offsets)),
        named("Cells", "UInt8", "types", grid.types.clone()),
    ];
    arrays.extend(
        columns
            .iter()
            .map(|(name, column)| column_array(name, column)),
    );
    let counts = [grid.points.len(), grid.types.len()];
    atomic_write::write(path, |file| write_arrays(file, counts, &arrays))
}

/// Writes the faces of `mesh` as polygons with their areas (L²), owners, neighbors and patches, the last two -1
/// where there is none.
///
/// # Errors
/// The error of the system; the file is then as it was before.
pub(crate) fn write_faces(path: &Path, mesh: &PolyMesh, areas: Vec<f64>) -> io::Result<()> {
    let mut grid = GridArrays {
        points: mesh.points.clone(),
        types: vec![7; mesh.face_count()],
        ..GridArrays::default()
    };
    for corners in mesh.faces() {
        let corners = corners.iter().map(|&corner| i64::from(corner));
        grid.connectivity.extend(corners);
        grid.offsets.push(grid.connectivity.len() as i64);
    }
    write_grid(path, &grid, &face_columns(mesh, areas))
}

/// The data of faces.
fn face_columns(mesh: &PolyMesh, areas: Vec<f64>) -> [(&'static str, CellColumn); 4] {
    let neighbor = |face| mesh.neighbor_of(face).map_or(-1, |cell| cell as i64);
    let mut walls = vec![-1; mesh.neighbor.len()];
    for (number, patch) in (0..).zip(&mesh.patches) {
        walls.extend(std::iter::repeat_n(number, patch.count));
    }
    let owners = mesh.owner.iter().map(|&cell| i64::from(cell)).collect();
    let neighbors = (0..mesh.face_count()).map(neighbor).collect();
    [
        ("area", CellColumn::Reals(areas)),
        ("owner", CellColumn::Integers(owners)),
        ("neighbor", CellColumn::Integers(neighbors)),
        ("wall", CellColumn::Integers(walls)),
    ]
}

fn column_array(name: &str, column: &CellColumn) -> FileArray {
    let (kind, bytes) = match column {
        CellColumn::Integers(all) => ("Int64", integer_bytes(all)),
        CellColumn::Reals(all) => ("Float64", real_bytes(all.iter().copied())),
    };
    ("CellData", kind, name.to_owned(), bytes)
}

pub(crate) fn real_bytes(all: impl IntoIterator<Item = f64>) -> Vec<u8> {
    all.into_iter().flat_map(f64::to_le_bytes).collect()
}

pub(crate) fn integer_bytes(all: &[i64]) -> Vec<u8> {
    all.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Connectivity, offsets, types, and the faces of polyhedra.
fn cell_arrays(mesh: &PolyMesh, standard: bool) -> Vec<FileArray> {
    let faces = mesh.cell_faces();
    let (mut points, mut offsets, mut types) = (Vec::new(), Vec::new(), Vec::new());
    let (mut streams, mut stream_ends) = (Vec::new(), Vec::new());
    for cell in 0..mesh.cell_count {
        let element = match standard {
            true => CellElement::of(mesh, &faces, cell),
            false => CellElement::Polyhedron,
        };
        let (kind, corners): (u8, Vec<u32>) = match element {
            CellElement::Tetrahedron(corners) => (10, corners.into()),
            CellElement::Hexahedron(corners) => (12, corners.into()),
            CellElement::Prism(corners) => (13, corners.into()),
            CellElement::Pyramid(corners) => (14, corners.into()),
            CellElement::Polyhedron => (42, push_stream(mesh, &faces, cell, &mut streams)),
        };
        points.extend(corners.iter().map(|&corner| i64::from(corner)));
        offsets.push(points.len() as i64);
        types.push(kind);
        stream_ends.push(if kind == 42 { streams.len() as i64 } else { -1 });
    }
    let integers =
        |name: &str, all: &[i64]| ("Cells", "Int64", name.to_owned(), integer_bytes(all));
    let mut arrays = vec![
        integers("connectivity", &points),
        integers("offsets", &offsets),
        ("Cells", "UInt8", "types".to_owned(), types),
    ];
    if !streams.is_empty() {
        arrays.push(integers("faces", &streams));
        arrays.push(integers("faceoffsets", &stream_ends));
    }
    arrays
}

/// Adds a polyhedron's faces, each as seen from outside, and returns its points in ascending order.
fn push_stream(mesh: &PolyMesh, faces: &CellFaces, cell: usize, stream: &mut Vec<i64>) -> Vec<u32> {
    let mut points = Vec::new();
    stream.push(faces.of(cell).len() as i64);
    for (face, is_owner) in faces.of(cell) {
        let corners = mesh.face(face);
        points.extend_from_slice(corners);
        stream.push(corners.len() as i64);
        let start = stream.len();
        stream.extend(corners.iter().map(|&corner| i64::from(corner)));
        if !is_owner {
            stream[start..].reverse();
        }
    }
    points.sort_unstable();
    points.dedup();
    points
}

/// Writes a whole file of so many points and cells.
pub(crate) fn write_arrays(
    file: &mut impl Write,
    [points, cells]: [usize; 2],
    arrays: &[FileArray],
) -> io::Result<()> {
    write!(
        file,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">\n"
    )?;
    let mut offset = 0;
    for section in ["Points", "Cells", "CellData", "PointData"] {
        let scalars = match section == "CellData" && arrays.iter().any(|array| array.2 == "energy")
        {
            true => " Scalars=\"energy\"",
            false => "",
        };
        writeln!(file, "<{section}{scalars}>")?;
        for (_, kind, name, bytes) in arrays.iter().filter(|array| array.0 == section) {
            let components = if section == "Points" { 3 } else { 1 };
            writeln!(
                file,
                "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
                 format=\"appended\" offset=\"{offset}\"/>"
            )?;
            offset += size_of::<u64>() + bytes.len();
        }
        writeln!(file, "</{section}>")?;
    }
    write!(
        file,
        "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_"
    )?;
    for (_, _, _, bytes) in arrays {
        file.write_all(&(bytes.len() as u64).to_le_bytes())?;
        file.write_all(bytes)?;
    }
    write!(file, "\n</AppendedData>\n</VTKFile>\n")
}
