//! `octree-N.vtu`: the leaves of an octree as a VTK file, corners shared between them.

use std::collections::HashMap;
use std::io;
use std::path::Path;

use crate::export::mesh_vtu::{CellColumn, GridArrays, write_grid};
use crate::mesh::octree::Octree;

/// VTK's order of a box's corners as bits of x, y, z (type 12).
const CORNERS: [u32; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

/// Writes the leaves with their level, and whether they are touched and solid.
///
/// # Errors
/// The error of the system; the file is then as it was before.
pub(crate) fn write_octree(path: &Path, tree: &Octree) -> io::Result<()> {
    let mut numbers: HashMap<[u32; 3], i64> = HashMap::new();
    let mut grid = GridArrays::default();
    for leaf in &tree.leaves {
        let side = 1_u32 << (tree.depth - leaf.level);
        for bits in CORNERS {
            let place = [0, 1, 2].map(|axis| leaf.place[axis] + (bits >> axis & 1) * side);
            let corner = *numbers.entry(place).or_insert_with(|| {
                grid.points.push(tree.corner(place));
                grid.points.len() as i64 - 1
            });
            grid.connectivity.push(corner);
        }
        grid.offsets.push(grid.connectivity.len() as i64);
        grid.types.push(12);
    }
    let column = |value: &dyn Fn(usize) -> i64| {
        CellColumn::Integers((0..tree.leaves.len()).map(value).collect())
    };
    let columns = [
        ("level", column(&|leaf| i64::from(tree.leaves[leaf].level))),
        (
            "touched",
            column(&|leaf| i64::from(tree.leaves[leaf].is_touched)),
        ),
        (
            "solid",
            column(&|leaf| i64::from(tree.leaves[leaf].is_solid)),
        ),
    ];
    write_grid(path, &grid, &columns)
}
