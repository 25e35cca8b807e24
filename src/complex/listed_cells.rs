//! A mesh by faces from cells that a file lists one by one.
//!
//! Faces of the same points are one face; a face that only one cell has is on a wall. The loops of a cell
//! are taken as they are where they fit together, and turned outward.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use crate::complex::element::CellElement;
use crate::complex::sorted_faces::SortedFaces;
use crate::mesh::formats::vtu::VtuCells;
use crate::mesh::poly_mesh::PolyMesh;

/// Why cells make no mesh.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ListedCellsError {
    /// A cell of another kind.
    #[error(
        "cell {cell} is of VTK's type {kind}; a mesh has the types 10, 12, 13, 14 and 42 with faces: \
         leave out other cells"
    )]
    Kind {
        /// The cell.
        cell: usize,
        /// Its type.
        kind: u8,
    },
    /// More than two cells at a face.
    #[error(
        "{count} cells have the face of points {corners:?}, the last one is {cell}: a face has two sides"
    )]
    Face {
        /// The points of the face.
        corners: Vec<u32>,
        /// How many cells have it.
        count: usize,
        /// One of them.
        cell: usize,
    },
    /// No two cells share a face.
    #[error(
        "no two of {cells} cells share a face: write every point once, all cells at it use its number"
    )]
    Apart {
        /// How many cells there are.
        cells: usize,
    },
}

/// The mesh of cells; all walls are one patch. Cells keep their order.
///
/// # Errors
/// [`ListedCellsError`] with the cell.
pub(crate) fn mesh_of(listed: &VtuCells) -> Result<PolyMesh, ListedCellsError> {
    let mut by_points = FaceSides::new();
    let mut order = Vec::new();
    for (cell, (kind, corners)) in listed.cells.iter().enumerate() {
        let loops = loops_of(*kind, corners, &listed.faces[cell]);
        let kind = *kind;
        let loops = loops.ok_or(ListedCellsError::Kind { cell, kind })?;
        for corners in outward(&listed.points, loops) {
            let mut key = corners.clone();
            key.sort_unstable();
            let sides = by_points.entry(key.clone()).or_insert_with(|| {
                order.push(key);
                Vec::new()
            });
            sides.push((cell as u32, corners));
        }
    }
    by_faces(listed, &order, &by_points)
}

/// The cells at each face, by its points in ascending order, with their loops.
type FaceSides = HashMap<Vec<u32>, Vec<(u32, Vec<u32>)>>;

fn by_faces(
    listed: &VtuCells,
    order: &[Vec<u32>],
    by_points: &FaceSides,
) -> Result<PolyMesh, ListedCellsError> {
    let mut faces = SortedFaces::default();
    let mut shared = 0;
    for key in order {
        match &by_points[key][..] {
            [(cell, corners)] => faces.push_wall(*cell, corners.clone(), 0),
            [(cell, corners), (other, _)] => {
                shared += 1;
                faces.push_inner([*cell, *other], corners.clone());
            }
            [.., (cell, corners)] => {
                return Err(ListedCellsError::Face {
                    corners: corners.clone(),
                    count: by_points[key].len(),
                    cell: *cell as usize,
                });
            }
            [] => {}
        }
    }
    let cells = listed.cells.len();
    if shared == 0 && cells > 1 {
        return Err(ListedCellsError::Apart { cells });
    }
    Ok(faces.finish(&listed.points, &["walls".to_owned()]).0)
}

/// The loops of a cell's faces; none for other kinds.
fn loops_of(kind: u8, corners: &[u32], faces: &[Vec<u32>]) -> Option<Vec<Vec<u32>>> {
    let element = match kind {
        10 => CellElement::Tetrahedron(corners.try_into().ok()?),
        12 => CellElement::Hexahedron(corners.try_into().ok()?),
        13 => CellElement::Prism(corners.try_into().ok()?),
        14 => CellElement::Pyramid(corners.try_into().ok()?),
        42 => return (faces.len() >= 4).then(|| faces.to_vec()),
        _ => return None,
    };
    let of = |places: &&[usize]| places.iter().map(|&place| corners[place]).collect();
    Some(element.faces().iter().map(of).collect())
}

/// The loops turned outward: all of them where every edge is run once each way, else each by the middle of
/// the cell.
fn outward(points: &[Point3<f64>], mut loops: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    let place = |corner: u32| points[corner as usize].coords;
    let all: Vec<u32> = loops.concat();
    let middle = all
        .iter()
        .map(|&corner| place(corner))
        .sum::<Vector3<f64>>()
        / all.len().max(1) as f64;
    let volume = |corners: &[u32]| pyramid(points, corners, &middle);
    let turned = |corners: &mut Vec<u32>| corners.reverse();
    if fit_together(&loops) {
        if loops.iter().map(|corners| volume(corners)).sum::<f64>() < 0.0 {
            loops.iter_mut().for_each(turned);
        }
        return loops;
    }
    let inward = loops.iter_mut().filter(|corners| volume(corners) < 0.0);
    inward.for_each(turned);
    loops
}

/// Six times the volume (L³) of the pyramid of a loop over a place.
fn pyramid(points: &[Point3<f64>], corners: &[u32], apex: &Vector3<f64>) -> f64 {
    let arm = |corner: u32| points[corner as usize].coords - apex;
    let fans = corners.windows(2).skip(1);
    fans.map(|pair| arm(corners[0]).dot(&arm(pair[0]).cross(&arm(pair[1]))))
        .sum()
}

/// Whether every edge is run once each way.
fn fit_together(loops: &[Vec<u32>]) -> bool {
    let of = |corners: &Vec<u32>| -> Vec<(u32, u32)> {
        let next = corners.iter().cycle().skip(1);
        corners.iter().copied().zip(next.copied()).collect()
    };
    let mut edges: Vec<(u32, u32)> = loops.iter().flat_map(of).collect();
    edges.sort_unstable();
    let has_twin = edges.windows(2).any(|pair| pair[0] == pair[1]);
    let is_back = |&(from, to): &(u32, u32)| edges.binary_search(&(to, from)).is_ok();
    !has_twin && edges.iter().all(is_back)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unit cubes side by side, the second a polyhedron with one loop turned inward.
    fn two_cubes() -> VtuCells {
        let point = |n: usize| Point3::new((n / 4) as f64, (n % 4 / 2) as f64, (n % 2) as f64);
        let (a, b) = ([0, 4, 6, 2, 1, 5, 7, 3], [4, 8, 10, 6, 5, 9, 11, 7]);
        let mut faces = loops_of(12, &b, &[]).expect("a cube");
        faces[2].reverse();
        VtuCells {
            points: (0..12).map(point).collect(),
            cells: vec![(12, a.into()), (42, b.into())],
            faces: vec![Vec::new(), faces],
        }
    }

    #[test]
    fn cells_of_any_kind_share_faces_and_loops_turn_outward() {
        let mesh = mesh_of(&two_cubes()).expect("two cubes");
        assert_eq!(
            (mesh.cell_count, mesh.face_count(), mesh.neighbor.len()),
            (2, 11, 1)
        );
        assert_eq!(mesh.check_closed().expect("closed").len(), 0);
    }

    #[test]
    fn what_makes_no_mesh_is_refused_with_the_cell() {
        let mut listed = two_cubes();
        listed.cells[1].0 = 11;
        let error = mesh_of(&listed).expect_err("a voxel").to_string();
        assert!(error.contains("cell 1 is of VTK's type 11"), "{error}");
        let mut listed = two_cubes();
        listed.cells.push(listed.cells[0].clone());
        listed.faces.push(Vec::new());
        let error = mesh_of(&listed).expect_err("three at a face").to_string();
        assert!(error.contains("a face has two sides"), "{error}");
        let mut listed = two_cubes();
        listed.points.extend(listed.points.clone());
        listed.faces[1]
            .iter_mut()
            .flatten()
            .for_each(|corner| *corner += 12);
        let error = mesh_of(&listed).expect_err("no common points").to_string();
        assert!(error.contains("no two of 2 cells share a face"), "{error}");
    }
}
