//! Cutting of a tetrahedral mesh by a plane (\[BL\] Appendix B).

use crate::arrays::MapEach;
use crate::mass::split::{Node, Side, split};
use crate::mesh::tets::{TetMesh, VertexData};
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// A cut mesh: it fills what the mesh filled, and no tetrahedron straddles the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct CutMesh {
    /// The vertices of the mesh, then one per cut edge; the uncut tetrahedra in their order, each
    /// cut one replaced by its pieces. Vertex data are interpolated along the cut edges.
    pub mesh: TetMesh,
    /// Per tetrahedron: whether it lies where normal · y > offset.
    pub above: Vec<bool>,
    /// How many tetrahedra were cut.
    pub cut: usize,
}

/// Cuts `mesh` by the plane normal · y = `offset`.
///
/// A conforming mesh stays conforming: neighbors share the new vertices and the diagonals of the
/// faces they share. Volume is conserved, and so are mass and mass center of a density linear in
/// every tetrahedron, up to rounding of the new positions.
///
/// # Panics
///
/// If a tetrahedron names a vertex, or a vertex lacks a value, that is not there, or if there
/// would be more than 2³² vertices.
#[must_use]
pub fn cut(mesh: &TetMesh, normal: &Vector3<f64>, offset: f64) -> CutMesh {
    let distances: Vec<f64> = mesh
        .vertices
        .iter()
        .map(|vertex| normal.dot(&vertex.coords) - offset)
        .collect();
    cut_at(mesh, &distances)
}

/// Cuts `mesh` where a function that is linear in every tetrahedron vanishes, given its values at the
/// vertices; what is above is where it is positive.
pub(crate) fn cut_at(mesh: &TetMesh, distances: &[f64]) -> CutMesh {
    let mut cutter = MeshCutter {
        mesh: TetMesh {
            tets: Vec::with_capacity(mesh.tets.len()),
            ..mesh.clone()
        },
        above: Vec::with_capacity(mesh.tets.len()),
        distances,
        new: HashMap::new(),
    };
    let are_cut = mesh.tets.iter().map(|tet| cutter.push(tet));
    let cut = are_cut.filter(|is_cut| *is_cut).count();
    let MeshCutter { mesh, above, .. } = cutter;
    CutMesh { mesh, above, cut }
}

/// The cut mesh under construction.
struct MeshCutter<'a> {
    mesh: TetMesh,
    above: Vec<bool>,
    /// The signed distances of the vertices from the plane, times the normal's length.
    distances: &'a [f64],
    /// The vertex that cuts an edge, by the edge's ends, lower first.
    new: HashMap<[u32; 2], u32>,
}

impl MeshCutter<'_> {
    /// Adds a tetrahedron or, if it is cut, its pieces; returns whether it is cut.
    fn push(&mut self, tet: &[u32; 4]) -> bool {
        let sides = tet.map_each(|vertex| Side::of(self.distances[vertex as usize]));
        let Some(pieces) = split(sides, *tet) else {
            self.mesh.tets.push(*tet);
            self.above.push(sides.contains(&Side::Above));
            return false;
        };
        for (side, nodes) in pieces {
            let piece = nodes.map_each(|node| self.vertex(tet, node));
            self.mesh.tets.push(piece);
            self.above.push(side == Side::Above);
        }
        true
    }

    /// The number of a corner, or of the vertex on a cut edge, which is added when first needed.
    fn vertex(&mut self, tet: &[u32; 4], [i, j]: Node) -> u32 {
        if i == j {
            return tet[i];
        }
        let edge = [tet[i], tet[j]];
        if let Some(&vertex) = self.new.get(&edge) {
            return vertex;
        }
        let vertex = u32::try_from(self.mesh.vertices.len()).expect("vertices fit 32-bit numbers");
        let [from, to] = edge.map_each(|end| end as usize);
        let share = self.distances[from] / (self.distances[from] - self.distances[to]);
        let position = between(&self.mesh.vertices[from], &self.mesh.vertices[to], share);
        self.mesh.vertices.push(position);
        for VertexData { values, .. } in &mut self.mesh.vertex_data {
            values.push(values[from] + (values[to] - values[from]) * share);
        }
        self.new.insert(edge, vertex);
        vertex
    }
}

fn between(from: &Point3<f64>, to: &Point3<f64>, share: f64) -> Point3<f64> {
    from + (to - from) * share
}
