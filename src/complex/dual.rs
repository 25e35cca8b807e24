//! The dual of a mesh of cells: an element for every vertex, its corners at the sites of the cells there.
//!
//! A vertex where eight cells meet becomes a hexahedron. On walls the corners are a point for every face,
//! for every edge of a feature, and the vertex itself where features meet or turn, so that the dual
//! reaches the walls. Faces are the rings of cells about edges: they are the same from both sides, and
//! the dual conforms. A vertex in which cells touch without a common face gives an element to each
//! connected group.

use std::collections::HashMap;

use nalgebra::Point3;

use crate::complex::edit_mesh::loop_edges;
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::sorted_faces::SortedFaces;
use crate::complex::vertex_groups::VertexGroups;
use crate::mesh::poly_mesh::PolyMesh;

/// Where a point of the dual may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DualAnchor {
    /// Anywhere: it is the site of a cell.
    Site,
    /// On a patch of the wall.
    Wall(u32),
    /// On the edges between two patches.
    Feature([u32; 2]),
    /// Where it is.
    Corner,
}

/// Where a feature has a corner.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FeatureTurns<'a> {
    /// Where it turns by more than an angle (degrees).
    Beyond(f64),
    /// At places of the surface, up to a distance (L): features of the mesh may run a little to and fro
    /// where those of the surface do not turn.
    At(&'a [Point3<f64>], f64),
}

/// The dual of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct DualMesh {
    /// One cell for every vertex.
    pub(crate) mesh: PolyMesh,
    /// Per point where it may be.
    pub(crate) anchors: Vec<DualAnchor>,
}

/// What stands on either side of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DualNode {
    Cell(u32),
    /// The outside of a face on a wall.
    Wall(u32),
}

/// What a point of the dual stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum DualSource {
    Cell(u32),
    Face(u32),
    Edge(u32, u32),
    Vertex(u32),
}

impl DualMesh {
    /// The dual of `mesh`, which has no periods, with a point `corners[c]` for every cell c. Edges of the
    /// wall between two patches are features; one has a corner where `turns` says so.
    #[must_use]
    pub(crate) fn of(mesh: &PolyMesh, corners: &[Point3<f64>], turns: FeatureTurns<'_>) -> Self {
        let mut builder = DualBuilder::new(mesh, corners, turns);
        builder.add_rings();
        builder.add_walls();
        let names: Vec<String> = mesh
            .patches
            .iter()
            .map(|patch| patch.name.clone())
            .collect();
        let (mesh, used, _) = builder.faces.finish(&builder.points, &names);
        let anchors = used.iter().map(|&point| builder.anchors[point as usize]);
        Self {
            mesh,
            anchors: anchors.collect(),
        }
    }
}

struct DualBuilder<'a> {
    mesh: &'a PolyMesh,
    corners: &'a [Point3<f64>],
    geometry: MeshGeometry,
    turns: FeatureTurns<'a>,
    groups: VertexGroups,
    numbers: HashMap<DualSource, u32>,
    points: Vec<Point3<f64>>,
    anchors: Vec<DualAnchor>,
    /// Per face on a wall and edge of it: the face beyond the edge, and whether the edge is a feature.
    across: HashMap<(u32, u32, u32), (u32, bool)>,
    faces: SortedFaces,
}

/// A face at an edge from the lower to the higher vertex, and whether it runs that way.
type EdgeFace = (u32, u32, u32, bool);

impl<'a> DualBuilder<'a> {
    fn new(mesh: &'a PolyMesh, corners: &'a [Point3<f64>], turns: FeatureTurns<'a>) -> Self {
        let groups = VertexGroups::of(mesh);
        Self {
            mesh,
            corners,
            geometry: MeshGeometry::of(mesh, &mesh.cell_faces()),
            turns,
            faces: SortedFaces::default(),
            groups,
            numbers: HashMap::new(),
            points: Vec::new(),
            anchors: Vec::new(),
            across: HashMap::new(),
        }
    }

    fn patch(&self, face: u32) -> u32 {
        let ends = self.mesh.patches.iter();
        let ends = ends.map(|patch| patch.start + patch.count);
        ends.take_while(|&end| end <= face as usize).count() as u32
    }

    /// The faces of the dual between elements: one for every ring of cells about an edge.
    fn add_rings(&mut self) {
        let mut edges: Vec<EdgeFace> = Vec::new();
        for (face, corners) in (0..).zip(self.mesh.faces()) {
            let runs = loop_edges(corners);
            edges.extend(runs.map(|(a, b)| (a.min(b), a.max(b), face, a < b)));
        }
        edges.sort_unstable();
        for faces in edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            for ring in self.rings(faces) {
                self.add_ring([faces[0].0, faces[0].1], &ring);
            }
        }
    }

    /// The cells about an edge in the sense of its direction, from wall to wall or around.
    fn rings(&self, faces: &[EdgeFace]) -> Vec<Vec<DualNode>> {
        // Seen along an edge of a face's loop, the owner comes before the neighbor.
        let steps = faces.iter().map(|&(_, _, face, is_forward)| {
            let owner = DualNode::Cell(self.mesh.owner[face as usize]);
            let other = match self.mesh.neighbor.get(face as usize) {
                Some(&cell) => DualNode::Cell(cell),
                None => DualNode::Wall(face),
            };
            if is_forward {
                (owner, other)
            } else {
                (other, owner)
            }
        });
        let mut steps: Vec<(DualNode, DualNode)> = steps.collect();
        let mut rings = Vec::new();
        while !steps.is_empty() {
            let is_start = |step: &(DualNode, DualNode)| matches!(step.0, DualNode::Wall(_));
            let start = steps.iter().position(is_start).unwrap_or(0);
            let (first, mut last) = steps.swap_remove(start);
            let mut ring = vec![first];
            while last != first {
                ring.push(last);
                let Some(next) = steps.iter().position(|step| step.0 == last) else {
                    break;
                };
                last = steps.swap_remove(next).1;
            }
            rings.push(ring);
        }
        rings
    }

    fn add_ring(&mut self, [a, b]: [u32; 2], ring: &[DualNode]) {
        let cell = ring.iter().find_map(|node| match node {
            DualNode::Cell(cell) => Some(*cell),
            DualNode::Wall(_) => None,
        });
        let Some(cell) = cell else { return };
        let mut corners: Vec<u32> = ring.iter().map(|&node| self.node_point(node)).collect();
        if let (Some(&DualNode::Wall(first)), Some(&DualNode::Wall(last))) =
            (ring.first(), ring.last())
        {
            let is_feature = self.patch(first) != self.patch(last);
            if is_feature {
                corners.push(self.edge_point([a, b], [first, last]));
            }
            self.across.insert((first, a, b), (last, is_feature));
            self.across.insert((last, a, b), (first, is_feature));
        }
        let sides = [a, b].map(|vertex| self.groups.of_cell(vertex, cell));
        self.faces.push_inner(sides, corners);
    }

    fn point(&mut self, source: DualSource, place: Point3<f64>, anchor: DualAnchor) -> u32 {
        let next = self.points.len() as u32;
        let number = *self.numbers.entry(source).or_insert(next);
        if number == next {
            self.points.push(place);
            self.anchors.push(anchor);
        }
        number
    }

    fn node_point(&mut self, node: DualNode) -> u32 {
        match node {
            DualNode::Cell(cell) => {
                let place = self.corners[cell as usize];
                self.point(DualSource::Cell(cell), place, DualAnchor::Site)
            }
            DualNode::Wall(face) => {
                let place = self.geometry.face_centers[face as usize];
                let anchor = DualAnchor::Wall(self.patch(face));
                self.point(DualSource::Face(face), place, anchor)
            }
        }
    }

    fn edge_point(&mut self, [a, b]: [u32; 2], faces: [u32; 2]) -> u32 {
        let [from, to] = [a, b].map(|vertex| self.mesh.points[vertex as usize]);
        let patches = faces.map(|face| self.patch(face));
        let patches = [patches[0].min(patches[1]), patches[0].max(patches[1])];
        let anchor = DualAnchor::Feature(patches);
        self.point(DualSource::Edge(a, b), from + 0.5 * (to - from), anchor)
    }

    /// The faces of the dual on walls: around every vertex there, parted by features.
    fn add_walls(&mut self) {
        let mut at: Vec<(u32, u32)> = Vec::new();
        for face in self.mesh.neighbor.len()..self.mesh.face_count() {
            let face = face as u32;
            let corners = self.mesh.face(face as usize).iter();
            at.extend(corners.map(|&vertex| (vertex, face)));
        }
        at.sort_unstable();
        for faces in at.chunk_by(|one, other| one.0 == other.0) {
            let mut left: Vec<u32> = faces.iter().map(|&(_, face)| face).collect();
            while let Some(&first) = left.first() {
                let fan = self.fan(faces[0].0, first, left.len());
                left.retain(|face| !fan.iter().any(|(member, ..)| member == face));
                self.add_fan(faces[0].0, &fan);
            }
        }
    }

    /// The faces of a wall about a vertex from `first` on, counter-clockwise seen from outside, each with
    /// the other end of the edge that follows, and whether that is a feature.
    fn fan(&self, vertex: u32, first: u32, most: usize) -> Vec<(u32, u32, bool)> {
        let (mut fan, mut face) = (Vec::new(), first);
        while fan.len() < most {
            let corners = self.mesh.face(face as usize);
            let before = loop_edges(corners).find(|&(_, to)| to == vertex);
            let Some((end, _)) = before else { break };
            let edge = (face, vertex.min(end), vertex.max(end));
            let Some(&(next, is_feature)) = self.across.get(&edge) else {
                break;
            };
            fan.push((face, end, is_feature));
            face = next;
            if face == first {
                break;
            }
        }
        if fan.is_empty() {
            fan.push((first, vertex, false));
        }
        fan
    }

    fn add_fan(&mut self, vertex: u32, fan: &[(u32, u32, bool)]) {
        let owner = self.mesh.owner[fan[0].0 as usize];
        let element = self.groups.of_cell(vertex, owner);
        let cuts: Vec<usize> = (0..fan.len()).filter(|&place| fan[place].2).collect();
        let centers = |range: &mut dyn Iterator<Item = usize>, builder: &mut Self| -> Vec<u32> {
            range
                .map(|place| builder.node_point(DualNode::Wall(fan[place % fan.len()].0)))
                .collect()
        };
        let Some(&last) = cuts.last() else {
            let corners = centers(&mut (0..fan.len()), self);
            let patch = self.patch(fan[0].0);
            return self.faces.push_wall(element, corners, patch);
        };
        let corner = self.corner(vertex, fan, &cuts);
        let mut before = last;
        for &cut in &cuts {
            let end = if cut > before { cut } else { cut + fan.len() };
            let mut corners = Vec::new();
            if cuts.len() > 1 {
                corners.push(self.cut_point(vertex, fan[before]));
            }
            corners.extend(centers(&mut (before + 1..=end), self));
            corners.push(self.cut_point(vertex, fan[cut]));
            corners.extend(corner);
            let patch = self.patch(fan[cut].0);
            self.faces.push_wall(element, corners, patch);
            before = cut;
        }
    }

    /// The point on the feature that follows a face of a fan.
    fn cut_point(&self, vertex: u32, (_, end, _): (u32, u32, bool)) -> u32 {
        self.numbers[&DualSource::Edge(vertex.min(end), vertex.max(end))]
    }

    /// The vertex itself where features meet, or one has a corner.
    fn corner(&mut self, vertex: u32, fan: &[(u32, u32, bool)], cuts: &[usize]) -> Option<u32> {
        let here = self.mesh.points[vertex as usize];
        let way = |cut: usize| {
            let end = self.mesh.points[fan[cut].1 as usize];
            (end - here).try_normalize(0.0).unwrap_or_default()
        };
        let is_corner = match *cuts {
            [_] => false,
            [one, other] => match self.turns {
                FeatureTurns::Beyond(angle) => {
                    way(one).dot(&way(other)) > -angle.to_radians().cos()
                }
                FeatureTurns::At(places, reach) => places
                    .iter()
                    .any(|place| (place - here).norm_squared() <= reach * reach),
            },
            _ => true,
        };
        is_corner.then(|| self.point(DualSource::Vertex(vertex), here, DualAnchor::Corner))
    }
}
