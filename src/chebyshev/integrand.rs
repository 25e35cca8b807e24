//! What stays constant of a piece while its center moves.
//!
//! Every facet f is fanned from the foot q of the perpendicular from the origin of the piece's
//! coordinates (for a cell: its site), which is never farther from the origin than the facet is.
//! The triangle (q, a, b) of a directed edge has twice the area σ = n·(a×b), n the unit normal:
//! constant for the piece's life, so that the tetrahedron with the center c has six times the volume
//! σ H with H = d − n·c, the signed height of c below the facet. No polygon is cut for an integral:
//! an edge that runs through several sectors splits its σ in proportion.

use nalgebra::{Point3, Rotation3, Vector3};

use crate::chebyshev::at_vertices::AtVertices;
use crate::chebyshev::chunks::{Bits, CHUNK};
use crate::chebyshev::points::Points;
use crate::geometry::faceted::{Faceted, Piece};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::moments::Moments;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::polynomial::Polynomial;

/// Vertices whose edges are chosen together.
const ROWS: usize = CHUNK / 3;

/// An edge, and the doubled areas that its two facets' fans have on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeConstants {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) left: u32,
    pub(crate) right: u32,
    pub(crate) left_area: f64,
    pub(crate) right_area: f64,
}

impl EdgeConstants {
    /// The edge between two vertices, which are at `points`, with facets left and right of it, and six
    /// times the volume of its tetrahedra with the origin.
    #[inline(always)]
    pub(crate) fn new(
        [from, to]: [u32; 2],
        [left, right]: [u32; 2],
        [a, b]: [Vector3<f64>; 2],
        facets: &[HalfSpace],
    ) -> (Self, f64) {
        let fan = a.cross(&b);
        let [on_left, on_right] = [left, right].map(|facet| &facets[facet as usize]);
        let edge = Self {
            from,
            to,
            left,
            right,
            left_area: on_left.normal.dot(&fan),
            right_area: -on_right.normal.dot(&fan),
        };
        let six_volumes = edge.left_area * on_left.offset + edge.right_area * on_right.offset;
        (edge, six_volumes)
    }
}

/// A piece prepared for integrals about any center, in the piece's coordinates.
#[derive(Clone, Debug, Default)]
pub struct Integrand {
    pub(crate) vertices: Points,
    /// With unit normals.
    pub(crate) facets: Vec<HalfSpace>,
    pub(crate) edges: Vec<EdgeConstants>,
    pub(crate) at_vertices: AtVertices,
    pub(crate) labels: Vec<Label>,
    /// In the piece's coordinates; none is density 1.
    pub(crate) density: Option<Polynomial>,
    pub(crate) volume: f64,
}

impl Integrand {
    /// Prepares `piece`.
    #[must_use]
    pub fn new(piece: &Polyhedron) -> Self {
        let mut integrand = Self::default();
        integrand.assign(Piece::Convex(piece));
        integrand
    }

    /// Prepares `piece` of density 1, keeping the memory of the piece before.
    pub fn assign(&mut self, piece: Piece<'_>) {
        self.density = None;
        match piece {
            Piece::Convex(piece) => self.assign_convex(piece),
            Piece::Faceted(piece) => self.assign_faceted(piece),
        }
    }

    /// Gives the piece a density, a polynomial in its coordinates; none is density 1.
    pub fn set_density(&mut self, density: Option<&Polynomial>) {
        self.density = density.cloned();
    }

    /// The volume (L³).
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Volume and moments about the origin, by the tetrahedra (origin, q, a, b) of all edges.
    #[must_use]
    pub fn moments(&self) -> Moments {
        let mut moments = Moments::default();
        for edge in &self.edges {
            let [a, b] = [edge.from, edge.to].map(|vertex| self.vertices.get(vertex as usize));
            let (sum, squares) = (a + b, a.norm_squared() + b.norm_squared());
            for (facet, area) in [(edge.left, edge.left_area), (edge.right, edge.right_area)] {
                let facet = &self.facets[facet as usize];
                // The foot of the perpendicular from the origin.
                let foot = facet.normal * facet.offset;
                let (all, volume) = (sum + foot, area * facet.offset / 6.0);
                moments.volume += volume;
                moments.first += all * (volume / 4.0);
                let squares = squares + foot.norm_squared() + all.norm_squared();
                moments.second += volume / 20.0 * squares;
            }
        }
        moments
    }

    /// Turns the piece about the origin. Areas stay; a density would have to be turned too, and is
    /// not.
    pub fn rotate(&mut self, rotation: &Rotation3<f64>) {
        self.vertices.rotate(rotation);
        for facet in &mut self.facets {
            facet.normal = rotation * facet.normal;
        }
    }

    /// The positions of the vertices.
    pub fn vertices(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        self.vertices.iter().map(Point3::from)
    }

    fn assign_convex(&mut self, piece: &Polyhedron) {
        let axes = [&piece.x, &piece.y, &piece.z].map(Vec::as_slice);
        self.vertices.assign(axes, piece.vertex_count());
        self.assign_facets(piece.planes.iter(), piece.labels.iter());
        self.edges.reserve(piece.facets.len() * 3 / 2);
        self.at_vertices.assign_polyhedron(piece);
        let rows = piece.facets.chunks(ROWS).zip(piece.next.chunks(ROWS));
        let mut six_volumes = 0.0;
        for (chunk, (facets, next)) in rows.enumerate() {
            let first = (chunk * ROWS) as u32;
            let (facets, ends) = (facets.as_flattened(), next.as_flattened());
            for number in upward(next, first) {
                // The facet on the right is the one before, in turn.
                let (row, slot) = (number / 3, number % 3);
                let right = if slot == 0 { number + 2 } else { number - 1 };
                let ends = [first + row as u32, ends[number]];
                six_volumes += self.push_edge(ends, [facets[number], facets[right]]);
            }
        }
        self.volume = six_volumes / 6.0;
    }

    /// A facet that is not convex or not connected is the signed sum of the triangles on its edges
    /// no less than a convex one, and the walk takes it for what it is.
    fn assign_faceted(&mut self, piece: &Faceted) {
        self.vertices.clear();
        self.at_vertices.clear();
        for vertex in &piece.vertices {
            self.vertices.push(vertex);
        }
        let facets = piece.facets.iter();
        self.assign_facets(
            facets.clone().map(|(plane, _)| plane),
            facets.map(|(_, label)| label),
        );
        let mut six_volumes = 0.0;
        for edge in &piece.edges {
            six_volumes += self.push_edge([edge.from, edge.to], [edge.left, edge.right]);
        }
        self.volume = six_volumes / 6.0;
    }

    pub(crate) fn assign_facets<'a>(
        &mut self,
        planes: impl Iterator<Item = &'a HalfSpace>,
        labels: impl Iterator<Item = &'a Label>,
    ) {
        self.copy_facets(planes, labels);
        HalfSpace::normalize(&mut self.facets);
    }

    /// As [`Integrand::assign_facets`], with normals as they are.
    pub(crate) fn copy_facets<'a>(
        &mut self,
        planes: impl Iterator<Item = &'a HalfSpace>,
        labels: impl Iterator<Item = &'a Label>,
    ) {
        self.facets.clear();
        self.facets.extend(planes);
        self.labels.clear();
        self.labels.extend(labels);
        self.edges.clear();
    }

    /// Adds an edge and returns six times the volume of the tetrahedra on it.
    #[inline(always)]
    fn push_edge(&mut self, ends: [u32; 2], sides: [u32; 2]) -> f64 {
        let points = ends.map(|vertex| self.vertices.get(vertex as usize));
        let (edge, six_volumes) = EdgeConstants::new(ends, sides, points, &self.facets);
        self.edges.push(edge);
        six_volumes
    }
}

/// Of the edges that leave [`ROWS`] vertices from number `first` on, the numbers of those that lead to a
/// vertex of higher number.
#[inline]
fn upward(next: &[[u32; 3]], first: u32) -> Bits {
    let mut bits = 0;
    for (row, ends) in next.iter().take(ROWS).enumerate() {
        let from = first + row as u32;
        let [a, b, c] = ends.map(|end| u64::from(from < end));
        bits |= (a | b << 1 | c << 2) << (3 * row);
    }
    Bits::of(bits)
}
