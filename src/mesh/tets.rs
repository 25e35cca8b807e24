//! Tetrahedral meshes with scalar data at their vertices.

use nalgebra::Point3;

use crate::geometry::bounds::Bounds;
use crate::geometry::double_double::six_volume;
use crate::mesh::surface::SurfaceMesh;

/// The corners of the four facets of a tetrahedron of positive volume, counter-clockwise seen
/// from outside; facet k lies opposite corner k.
pub const FACETS: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// A tetrahedral mesh as it was read: perhaps with inverted or flat elements. One that fills a
/// solid is a [`crate::mesh::validate::ValidTetMesh`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TetMesh {
    /// Vertex positions (L).
    pub vertices: Vec<Point3<f64>>,
    /// Zero-based vertex indices; the volume is positive where vertex 3 sees 0, 1, 2
    /// counter-clockwise.
    pub tets: Vec<[u32; 4]>,
    /// Scalar fields such as densities.
    pub vertex_data: Vec<VertexData>,
}

/// One scalar per vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexData {
    /// The field's name in the file.
    pub name: String,
    /// The values in vertex order; NaN where there is none.
    pub values: Vec<f64>,
    /// Why they do not give every vertex one finite value, naming the first node at fault as the
    /// file does. Such data do no harm while nobody asks for them.
    pub fault: Option<String>,
}

impl VertexData {
    /// A field of values in vertex order, at fault if one is not finite.
    pub fn new(name: &str, values: Vec<f64>) -> Self {
        let bad = values.iter().position(|value| !value.is_finite());
        let fault = bad.map(|vertex| format!("vertex {vertex} has the value {}", values[vertex]));
        let name = name.to_owned();
        Self {
            name,
            values,
            fault,
        }
    }

    /// The values in vertex order, all finite.
    ///
    /// # Errors
    ///
    /// A sentence about the first vertex that has no value, several, or one that is not finite.
    pub fn checked(&self) -> Result<&[f64], String> {
        match &self.fault {
            None => Ok(&self.values),
            Some(fault) => Err(format!(
                "the vertex data `{}` cannot be used: {fault}; every node needs one finite value",
                self.name
            )),
        }
    }
}

impl TetMesh {
    /// The corners of a tetrahedron.
    #[must_use]
    pub fn corners(&self, tet: usize) -> [Point3<f64>; 4] {
        self.tets[tet].map(|vertex| self.vertices[vertex as usize])
    }

    /// All tetrahedra's corners.
    pub fn all_corners(&self) -> impl ExactSizeIterator<Item = [Point3<f64>; 4]> + '_ {
        (0..self.tets.len()).map(|tet| self.corners(tet))
    }

    /// The field called `name`.
    #[must_use]
    pub fn field(&self, name: &str) -> Option<&VertexData> {
        self.vertex_data.iter().find(|field| field.name == name)
    }

    /// The values of the field called `name`, in vertex order; NaN where there is none.
    #[must_use]
    pub fn data(&self, name: &str) -> Option<&[f64]> {
        Some(&self.field(name)?.values)
    }

    /// The least box that holds all tetrahedra; vertices none of them uses do not count.
    #[must_use]
    pub fn bounds(&self) -> Bounds<3> {
        Bounds::of(
            self.tets
                .iter()
                .flatten()
                .map(|&v| &self.vertices[v as usize]),
        )
    }

    /// The sum of the signed volumes (L³).
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.all_corners().map(|corners| tet_volume(&corners)).sum()
    }

    /// The facets that belong to one tetrahedron only, oriented outward, over the vertices they
    /// use, in the order of the tetrahedra.
    #[must_use]
    pub fn boundary(&self) -> SurfaceMesh {
        self.boundary_facets().0
    }

    /// The boundary, and for each of its triangles 4 · tetrahedron + facet.
    pub(crate) fn boundary_facets(&self) -> (SurfaceMesh, Vec<u32>) {
        let mut facets = self.facets();
        facets.sort_unstable();
        let single =
            (facets.chunk_by(|one, other| one.0 == other.0)).filter(|group| group.len() == 1);
        let mut facets: Vec<u32> = single.map(|group| group[0].1).collect();
        facets.sort_unstable();
        let triangles = facets.iter().map(|&facet| self.facet(facet)).collect();
        let mut surface = SurfaceMesh {
            vertices: self.vertices.clone(),
            triangles,
        };
        compact(&mut surface.vertices, &mut surface.triangles);
        (surface, facets)
    }

    /// (sorted vertices, 4 · tetrahedron + facet) of all facets.
    pub(crate) fn facets(&self) -> Vec<([u32; 3], u32)> {
        let key = |tet: &[u32; 4], corners: [usize; 3]| {
            let mut vertices = corners.map(|corner| tet[corner]);
            vertices.sort_unstable();
            vertices
        };
        let keys = self
            .tets
            .iter()
            .flat_map(|tet| FACETS.map(|corners| key(tet, corners)));
        keys.zip(0..).collect()
    }

    /// A facet by number, oriented outward.
    pub(crate) fn facet(&self, facet: u32) -> [u32; 3] {
        let tet = facet as usize / 4;
        let [a, b, c] = FACETS[facet as usize % 4].map(|corner| self.tets[tet][corner]);
        if tet_volume(&self.corners(tet)) < 0.0 {
            return [a, c, b];
        }
        [a, b, c]
    }
}

/// The signed volume of a tetrahedron, to full precision however flat it is: positive where d sees
/// a, b, c counter-clockwise.
#[must_use]
pub fn tet_volume([a, b, c, d]: &[Point3<f64>; 4]) -> f64 {
    six_volume(a, [b, c, d]) / 6.0
}

/// For every vertex, whether an element uses it.
pub(crate) fn used_vertices<const N: usize>(elements: &[[u32; N]], count: usize) -> Vec<bool> {
    let mut used = vec![false; count];
    for &vertex in elements.iter().flatten() {
        used[vertex as usize] = true;
    }
    used
}

/// Drops the vertices that no element uses and renumbers the elements; returns the kept
/// vertices' former indices.
pub(crate) fn compact<const N: usize>(
    vertices: &mut Vec<Point3<f64>>,
    elements: &mut [[u32; N]],
) -> Vec<u32> {
    let used = used_vertices(elements, vertices.len());
    let kept: Vec<u32> = (0..)
        .zip(&used)
        .filter(|&(_, &used)| used)
        .map(|(v, _)| v)
        .collect();
    if kept.len() < vertices.len() {
        let mut new_index = vec![0; vertices.len()];
        for (new, &old) in (0..).zip(&kept) {
            new_index[old as usize] = new;
        }
        for vertex in elements.iter_mut().flatten() {
            *vertex = new_index[*vertex as usize];
        }
        *vertices = kept.iter().map(|&old| vertices[old as usize]).collect();
    }
    kept
}
