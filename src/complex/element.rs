//! Recognition of hexahedra, prisms, pyramids and tetrahedra among polyhedra, and scaled Jacobians.
//!
//! A cell is one of them when its faces are: six quadrilaterals about eight points, two triangles and
//! three quadrilaterals about six, and so on, each corner in three faces but for the pyramid's apex.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::mesh::poly_mesh::{CellFaces, PolyMesh};

/// The shape of a cell by its faces, its points in VTK's order but for polyhedra.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum CellElement {
    /// Four triangles.
    Tetrahedron([u32; 4]),
    /// A quadrilateral and four triangles.
    Pyramid([u32; 5]),
    /// Two triangles and three quadrilaterals.
    Prism([u32; 6]),
    /// Six quadrilaterals.
    Hexahedron([u32; 8]),
    /// Anything else.
    Polyhedron,
}

/// The kinds of elements, in the order in which reports name them.
pub(crate) const KINDS: [&str; 5] = [
    "hexahedron",
    "prism",
    "pyramid",
    "tetrahedron",
    "polyhedron",
];

impl CellElement {
    /// The shape of a cell.
    #[must_use]
    pub(crate) fn of(mesh: &PolyMesh, cells: &CellFaces, cell: usize) -> Self {
        Self::standard(mesh, cells, cell).unwrap_or(Self::Polyhedron)
    }

    /// Its place in [`KINDS`].
    #[must_use]
    pub(crate) fn kind(&self) -> usize {
        match self {
            Self::Hexahedron(_) => 0,
            Self::Prism(_) => 1,
            Self::Pyramid(_) => 2,
            Self::Tetrahedron(_) => 3,
            Self::Polyhedron => 4,
        }
    }

    fn standard(mesh: &PolyMesh, cells: &CellFaces, cell: usize) -> Option<Self> {
        let count = cells.of(cell).len();
        if !(4..=6).contains(&count) {
            return None;
        }
        let loops: Vec<Vec<u32>> = cells
            .of(cell)
            .map(|(face, is_owner)| outward(mesh.face(face), is_owner))
            .collect();
        let triangles = loops.iter().filter(|corners| corners.len() == 3).count();
        let quads = loops.iter().filter(|corners| corners.len() == 4).count();
        let sized = |size: usize| loops.iter().find(|corners| corners.len() == size);
        let spokes = Spokes::of(&loops)?;
        match (count, triangles, quads, spokes.point_count()) {
            (4, 4, 0, 4) => spokes.over(sized(3)?).map(Self::Tetrahedron),
            (5, 4, 1, 5) => spokes.over(sized(4)?).map(Self::Pyramid),
            (5, 2, 3, 6) => spokes.prism(sized(3)?).map(Self::Prism),
            (6, 0, 6, 8) => spokes.prism(sized(4)?).map(Self::Hexahedron),
            _ => None,
        }
    }
}

/// A face's loop as seen from outside the cell.
fn outward(corners: &[u32], is_owner: bool) -> Vec<u32> {
    match is_owner {
        true => corners.to_vec(),
        false => corners.iter().rev().copied().collect(),
    }
}

/// The other ends of the edges of every point of a cell.
struct Spokes(BTreeMap<u32, Vec<u32>>);

impl Spokes {
    /// None where a point has fewer than three edges.
    fn of(loops: &[Vec<u32>]) -> Option<Self> {
        let mut ends: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for corners in loops {
            for (place, &from) in corners.iter().enumerate() {
                ends.entry(from)
                    .or_default()
                    .push(corners[(place + 1) % corners.len()]);
            }
        }
        for list in ends.values_mut() {
            list.sort_unstable();
            list.dedup();
        }
        ends.values()
            .all(|list| list.len() >= 3)
            .then_some(Self(ends))
    }

    fn point_count(&self) -> usize {
        self.0.len()
    }

    /// The base, counter-clockwise seen from inside, and the one point that all its points lead to.
    fn over<const N: usize>(&self, base: &[u32]) -> Option<[u32; N]> {
        let mut points: Vec<u32> = base.iter().rev().copied().collect();
        let apex = *self.0.keys().find(|point| !base.contains(point))?;
        let leads = |point: &u32| self.0[point].contains(&apex);
        points.push(apex);
        base.iter().all(leads).then_some(())?;
        points.try_into().ok()
    }

    /// The base, counter-clockwise seen from inside, and the points above it.
    fn prism<const N: usize>(&self, base: &[u32]) -> Option<[u32; N]> {
        let mut points: Vec<u32> = base.iter().rev().copied().collect();
        for place in 0..base.len() {
            let ends = &self.0[&points[place]];
            let mut above = ends.iter().filter(|end| !base.contains(end));
            let (first, second) = (above.next(), above.next());
            points.push(*first.filter(|_| second.is_none())?);
        }
        let size = base.len();
        let joined = |place: usize| {
            let (from, to) = (points[size + place], points[size + (place + 1) % size]);
            self.0[&from].contains(&to)
        };
        (0..size).all(joined).then_some(())?;
        points.try_into().ok()
    }
}

/// The corners of a hexahedron with their three neighbors, right-handed.
const HEX_CORNERS: [[usize; 4]; 8] = [
    [0, 1, 3, 4],
    [1, 2, 0, 5],
    [2, 3, 1, 6],
    [3, 0, 2, 7],
    [4, 7, 5, 0],
    [5, 4, 6, 1],
    [6, 5, 7, 2],
    [7, 6, 4, 3],
];

/// The scaled Jacobian of a hexahedron: the least over its corners of the determinant of the
/// three unit vectors along the edges, 1 for a box.
#[must_use]
pub(crate) fn scaled_jacobian(mesh: &PolyMesh, corners: &[u32; 8]) -> f64 {
    let place = |corner: usize| mesh.points[corners[corner] as usize];
    let at = |[here, a, b, c]: [usize; 4]| {
        let along = |end: usize| {
            let way: Vector3<f64> = place(end) - place(here);
            way / way.norm().max(1e-300)
        };
        along(a).cross(&along(b)).dot(&along(c))
    };
    HEX_CORNERS
        .into_iter()
        .map(at)
        .fold(f64::INFINITY, f64::min)
}
