//! The cells at every vertex of a mesh, in groups that are connected by faces at the vertex.

use crate::mesh::poly_mesh::PolyMesh;

/// Groups of cells at vertices, numbered by vertex.
#[derive(Clone, Debug)]
pub(crate) struct VertexGroups {
    /// Vertices with their cells, ascending.
    incidences: Vec<(u32, u32)>,
    groups: Vec<u32>,
    count: usize,
}

impl VertexGroups {
    #[must_use]
    pub(crate) fn of(mesh: &PolyMesh) -> Self {
        let mut incidences = Vec::new();
        for (face, corners) in mesh.faces().enumerate() {
            let cells = [Some(&mesh.owner[face]), mesh.neighbor.get(face)];
            for &cell in cells.into_iter().flatten() {
                incidences.extend(corners.iter().map(|&vertex| (vertex, cell)));
            }
        }
        incidences.sort_unstable();
        incidences.dedup();
        let mut groups = Self {
            groups: (0..incidences.len() as u32).collect(),
            incidences,
            count: 0,
        };
        for (face, &neighbor) in mesh.neighbor.iter().enumerate() {
            for &vertex in mesh.face(face) {
                groups.join(vertex, [mesh.owner[face], neighbor]);
            }
        }
        groups.number();
        groups
    }

    fn place(&self, vertex: u32, cell: u32) -> usize {
        let found = self.incidences.binary_search(&(vertex, cell));
        found.unwrap_or_else(|place| place.min(self.incidences.len() - 1))
    }

    fn root(&mut self, mut place: usize) -> usize {
        while self.groups[place] as usize != place {
            let above = self.groups[place] as usize;
            self.groups[place] = self.groups[above];
            place = above;
        }
        place
    }

    fn join(&mut self, vertex: u32, cells: [u32; 2]) {
        let [one, other] = cells.map(|cell| {
            let place = self.place(vertex, cell);
            self.root(place)
        });
        self.groups[one.max(other)] = one.min(other) as u32;
    }

    /// Replaces first members by numbers without gaps.
    fn number(&mut self) {
        let roots: Vec<usize> = (0..self.groups.len())
            .map(|place| self.root(place))
            .collect();
        for (place, &root) in roots.iter().enumerate() {
            self.groups[place] = match root == place {
                true => {
                    self.count += 1;
                    self.count as u32 - 1
                }
                // A group's first member comes before the others.
                false => self.groups[root],
            };
        }
    }

    /// The group of a cell at a vertex that it has.
    #[must_use]
    pub(crate) fn of_cell(&self, vertex: u32, cell: u32) -> u32 {
        self.groups[self.place(vertex, cell)]
    }
}
