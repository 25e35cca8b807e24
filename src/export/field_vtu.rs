//! `density.vtu`: triangles or tetrahedra with the density at their points.
//!
//! The format is that of `mesh.vtu` (`export::mesh_vtu`); cells are VTK's triangles (type 5) and
//! tetrahedra (type 10).

use std::io;
use std::path::Path;

use nalgebra::Point3;

use crate::export::atomic_write;
use crate::export::mesh_vtu::{FileArray, integer_bytes, real_bytes, write_arrays};

/// Writes simplices with columns of numbers at their points, named.
///
/// # Errors
/// The error of the system; the file is then as it was before.
pub(crate) fn write_simplices<const K: usize>(
    path: &Path,
    points: &[Point3<f64>],
    simplices: &[[u32; K]],
    at_points: &[(&str, &[f64])],
) -> io::Result<()> {
    let coordinates = points.iter().flat_map(|point| [point.x, point.y, point.z]);
    let corners = simplices.iter().flatten().map(|&corner| i64::from(corner));
    let corners: Vec<i64> = corners.collect();
    let ends: Vec<i64> = (1..=simplices.len()).map(|end| (K * end) as i64).collect();
    let kind = if K == 3 { 5 } else { 10 };
    let named =
        |section, kind, name: &str, bytes| -> FileArray { (section, kind, name.to_owned(), bytes) };
    let mut arrays = vec![
        named("Points", "Float64", "Points", real_bytes(coordinates)),
        named("Cells", "Int64", "connectivity", integer_bytes(&corners)),
        named("Cells", "Int64", "offsets", integer_bytes(&ends)),
        named("Cells", "UInt8", "types", vec![kind; simplices.len()]),
    ];
    for (name, values) in at_points {
        let bytes = real_bytes(values.iter().copied());
        arrays.push(named("PointData", "Float64", name, bytes));
    }
    let counts = [points.len(), simplices.len()];
    atomic_write::write(path, |file| write_arrays(file, counts, &arrays))
}
