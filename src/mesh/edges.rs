//! The table of edges: the triangles at each edge of a surface.
//!
//! A *side* is a corner of a triangle read as the directed edge from it to the next corner:
//! side `3 t + k` runs from corner k to corner k + 1 of triangle t. An *edge* is the
//! undirected pair of vertices and the sides that run along it.

/// The mark of a side without a single partner.
pub const NO_PARTNER: u32 = u32::MAX;

/// All edges of a triangle list, ordered by their vertices.
#[derive(Clone, Debug)]
pub struct EdgeTable {
    vertices: Vec<[u32; 2]>,
    starts: Vec<u32>,
    sides: Vec<u32>,
}

/// One edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceEdge<'a> {
    /// Its vertices, the lower index first.
    pub vertices: [u32; 2],
    /// The sides that run along it, in either direction, ascending.
    pub sides: &'a [u32],
}

impl EdgeTable {
    /// The edges of `triangles` over `vertex_count` vertices, in time linear in the triangles
    /// (buckets by lower vertex). All indices must be below `vertex_count`.
    #[must_use]
    pub fn of(triangles: &[[u32; 3]], vertex_count: usize) -> Self {
        let mut buckets = sides_by_lower_vertex(triangles, vertex_count);
        let mut table = Self {
            vertices: Vec::with_capacity(triangles.len() * 3 / 2),
            starts: vec![0],
            sides: Vec::with_capacity(triangles.len() * 3),
        };
        let ends = buckets.ends;
        let mut begin = 0;
        for (lower, end) in (0..).zip(ends) {
            table.append(lower, &mut buckets.sides[begin..end as usize]);
            begin = end as usize;
        }
        table
    }

    /// The number of edges.
    #[must_use]
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Whether there is no edge.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// The edges in order.
    pub fn iter(&self) -> impl Iterator<Item = SurfaceEdge<'_>> {
        (self.vertices.iter().zip(self.starts.windows(2))).map(|(&vertices, range)| SurfaceEdge {
            vertices,
            sides: &self.sides[range[0] as usize..range[1] as usize],
        })
    }

    /// For every side the one other side along its edge, [`NO_PARTNER`] where there is none or
    /// more than one.
    #[must_use]
    pub fn partners(&self) -> Vec<u32> {
        let mut partners = vec![NO_PARTNER; self.sides.len()];
        for edge in self.iter() {
            if let &[one, other] = edge.sides {
                partners[one as usize] = other;
                partners[other as usize] = one;
            }
        }
        partners
    }

    /// Appends the edges from `lower` to the upper vertices of `sides`.
    fn append(&mut self, lower: u32, sides: &mut [(u32, u32)]) {
        sides.sort_unstable();
        for group in sides.chunk_by(|one, other| one.0 == other.0) {
            self.vertices.push([lower, group[0].0]);
            self.sides.extend(group.iter().map(|&(_, side)| side));
            self.starts.push(self.sides.len() as u32);
        }
    }
}

/// The directed edge of a side.
#[must_use]
pub fn side_vertices(triangles: &[[u32; 3]], side: u32) -> [u32; 2] {
    let triangle = triangles[side as usize / 3];
    let corner = side as usize % 3;
    [triangle[corner], triangle[(corner + 1) % 3]]
}

/// (upper vertex, side) grouped by lower vertex, and the end of every group.
struct Buckets {
    sides: Vec<(u32, u32)>,
    ends: Vec<u32>,
}

fn sides_by_lower_vertex(triangles: &[[u32; 3]], vertex_count: usize) -> Buckets {
    let mut ends = vec![0_u32; vertex_count];
    for &[a, b, c] in triangles {
        for lower in [a.min(b), b.min(c), c.min(a)] {
            ends[lower as usize] += 1;
        }
    }
    let mut total = 0;
    for end in &mut ends {
        total += std::mem::replace(end, total);
    }
    let mut sides = vec![(0, 0); triangles.len() * 3];
    let directed = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    for (side, (from, to)) in (0_u32..).zip(directed) {
        let slot = &mut ends[from.min(to) as usize];
        sides[*slot as usize] = (from.max(to), side);
        *slot += 1;
    }
    Buckets { sides, ends }
}
