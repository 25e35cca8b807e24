//! Merging of a tetrahedral mesh's nearly coincident vertices, as pieces of a file leave them.
//!
//! Only vertices of facets without a neighbor are compared: others have theirs. Nothing is merged where
//! the data of two vertices differ, which then mean a jump.

use nalgebra::Point3;

use crate::mesh::repair::merge_near;
use crate::mesh::tets::TetMesh;

/// The mesh with vertices up to `distance` apart merged, how many were merged away, and the greatest
/// distance between two of them (L); `None` if there are none, if their data differ, or if a
/// tetrahedron would collapse that need not.
pub(crate) fn welded_tets(
    mesh: &TetMesh,
    distance: f64,
    may_collapse: bool,
) -> Option<(TetMesh, usize, f64)> {
    let places = boundary_vertices(mesh);
    let at = |&place: &u32| mesh.vertices[place as usize];
    let points: Vec<Point3<f64>> = places.iter().map(at).collect();
    let (kept, new_index, apart) = merge_near(&points, distance);
    let merged = points.len() - kept.len();
    if merged == 0 {
        return None;
    }
    let kept_by = representatives(mesh.vertices.len(), &places, &new_index);
    if has_jump(mesh, &kept_by) {
        return None;
    }
    let welded = renumbered(mesh, &kept_by);
    let collapses = |tet: &[u32; 4]| (1..4).any(|k| tet[..k].contains(&tet[k]));
    let is_kept = may_collapse || !welded.tets.iter().any(collapses);
    is_kept.then_some((welded, merged, apart))
}

/// The vertices of the facets of one tetrahedron only, ascending.
fn boundary_vertices(mesh: &TetMesh) -> Vec<u32> {
    let mut facets = mesh.facets();
    facets.sort_unstable();
    let single = facets.chunk_by(|one, other| one.0 == other.0);
    let single = single.filter(|group| group.len() == 1);
    let mut vertices: Vec<u32> = single.flat_map(|group| group[0].0).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// For every vertex the one that stands for it: of `places`, the first with the same new index.
fn representatives(count: usize, places: &[u32], new_index: &[u32]) -> Vec<u32> {
    let mut kept_by: Vec<u32> = (0..count as u32).collect();
    let mut first = vec![u32::MAX; places.len()];
    for (&place, &index) in places.iter().zip(new_index) {
        let first = &mut first[index as usize];
        *first = (*first).min(place);
        kept_by[place as usize] = *first;
    }
    kept_by
}

/// Whether two merged vertices have different values of a field.
fn has_jump(mesh: &TetMesh, kept_by: &[u32]) -> bool {
    let differs = |values: &[f64]| {
        let mut pairs = values.iter().zip(kept_by);
        pairs.any(|(value, &kept)| value.to_bits() != values[kept as usize].to_bits())
    };
    mesh.vertex_data.iter().any(|field| differs(&field.values))
}

fn renumbered(mesh: &TetMesh, kept_by: &[u32]) -> TetMesh {
    let is_kept = |&at: &usize| kept_by[at] as usize == at;
    let kept: Vec<usize> = (0..kept_by.len()).filter(is_kept).collect();
    let mut number = vec![0; kept_by.len()];
    for (new, &old) in (0..).zip(&kept) {
        number[old] = new;
    }
    let mut welded = mesh.clone();
    welded.vertices = kept.iter().map(|&at| mesh.vertices[at]).collect();
    for vertex in welded.tets.iter_mut().flatten() {
        *vertex = number[kept_by[*vertex as usize] as usize];
    }
    for field in &mut welded.vertex_data {
        field.values = kept.iter().map(|&at| field.values[at]).collect();
    }
    welded
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::tets::VertexData;

    /// The cube's five tetrahedra, each with its own vertices, moved by `gap` times its number.
    fn apart(gap: f64) -> TetMesh {
        let cube = shapes::unit_cube_five_tets();
        let mut mesh = TetMesh::default();
        for (number, corners) in cube.all_corners().enumerate() {
            let first = mesh.vertices.len() as u32;
            let shift = nalgebra::Vector3::new(gap * number as f64, 0.0, 0.0);
            mesh.vertices.extend(corners.map(|corner| corner + shift));
            mesh.tets.push([0, 1, 2, 3].map(|k| first + k));
        }
        mesh
    }

    #[test]
    fn tetrahedra_with_their_own_vertices_become_neighbors() {
        for gap in [0.0, 1e-14] {
            let (welded, merged, gap_found) = welded_tets(&apart(gap), 1e-12, false).unwrap();
            assert_eq!((welded.vertices.len(), merged), (8, 12));
            assert_eq!(welded.boundary().triangles.len(), 12);
            assert!(gap_found <= 5.0 * gap);
        }
        assert!(welded_tets(&apart(1e-9), 1e-12, false).is_none());
        assert!(welded_tets(&apart(1e-9), 1e-8, true).is_some());
        assert!(welded_tets(&shapes::unit_cube_five_tets(), 1e-12, false).is_none());
        assert!(
            welded_tets(&apart(0.0), 2.0, false).is_none(),
            "all would collapse"
        );
    }

    #[test]
    fn data_that_jump_keep_their_vertices_apart() {
        let mut mesh = apart(0.0);
        let values = (0..20).map(|vertex| f64::from(vertex / 4)).collect();
        mesh.vertex_data.push(VertexData::new("rho", values));
        assert!(welded_tets(&mesh, 1e-12, false).is_none());
        let values = mesh.vertices.iter().map(|p| 1.0 + p.x).collect();
        mesh.vertex_data[0] = VertexData::new("rho", values);
        let (welded, ..) = welded_tets(&mesh, 1e-12, false).unwrap();
        assert_eq!(welded.data("rho").unwrap().len(), 8);
    }
}
