//! The cells that VTK's two formats share.

use crate::mesh::formats::error::ErrorKind;
use crate::mesh::formats::mesh::{Collected, no_tetrahedron};
use crate::mesh::polygon::triangulate;

/// Adds a cell of VTK's type number `kind` over the vertices `cell`: tetrahedra (10), triangles
/// (5), polygons (7), quads (9), pixels (8). Vertices and lines (1 to 4) are passed over, all
/// else is refused.
pub(crate) fn add_cell(mesh: &mut Collected, kind: u32, cell: &[u32]) -> Result<(), ErrorKind> {
    match (kind, cell) {
        (10, &[a, b, c, d]) => mesh.tets.push([a, b, c, d]),
        (8, &[a, b, c, d]) => triangulate(&mesh.vertices, &[a, b, d, c], &mut mesh.triangles),
        (5 | 7 | 9, _) if cell.len() >= 3 => {
            triangulate(&mesh.vertices, cell, &mut mesh.triangles);
        }
        (1..=4, _) => {}
        (5 | 7..=10, _) => {
            let expected = "a cell with the vertices of its type";
            let found = format!("type {kind} with {} vertices", cell.len());
            return Err(ErrorKind::Expected { expected, found });
        }
        _ => return Err(no_tetrahedron(format!("VTK {kind}"))),
    }
    Ok(())
}

/// The cells of a list `offsets` (n + 1 ascending positions, from 0) into `connectivity`;
/// `None` if an offset is out of order or range.
pub(crate) fn cell_ranges(offsets: &[usize], connectivity: usize) -> Option<Vec<[usize; 2]>> {
    let ordered = |pair: &[usize]| {
        (pair[0] <= pair[1] && pair[1] <= connectivity).then_some([pair[0], pair[1]])
    };
    offsets.windows(2).map(ordered).collect()
}
