//! What stays of a piece while its center moves: its vertices, facets and edges.

use nalgebra::{Point3, Rotation3, Vector3};
use wide::f64x4;

use crate::chebyshev::at_vertices::AtVertices;
use crate::chebyshev::chunks::{Bits, CHUNK};
use crate::chebyshev::edges::Edges;
use crate::chebyshev::four::FourEdges;
use crate::chebyshev::planes::Planes;
use crate::chebyshev::points::Points;
use crate::chebyshev::seen::Seen;
use crate::chebyshev::slots::Words;
use crate::geometry::brep::{Brep, Edge, Piece};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::moments::Moments;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::simd::sum;
use crate::integrals::polynomial::Polynomial;

/// Vertices whose edges are chosen together.
const ROWS: usize = CHUNK / 3;

/// A piece prepared for integrals about any center, in the piece's coordinates.
#[derive(Clone, Debug, Default)]
pub struct Integrand {
    pub(crate) vertices: Points,
    /// With unit normals.
    pub(crate) facets: Planes,
    pub(crate) edges: Edges,
    pub(crate) at_vertices: AtVertices,
    pub(crate) labels: Vec<Label>,
    /// In the piece's coordinates; none is density 1.
    pub(crate) density: Option<Polynomial>,
    pub(crate) words: Words,
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
            Piece::Brep(piece) => self.assign_brep(piece),
        }
    }

    /// Gives the piece a density, a polynomial in its coordinates; none is density 1.
    pub fn set_density(&mut self, density: Option<&Polynomial>) {
        self.density = density.cloned();
    }

    /// The volume (L³).
    #[must_use]
    pub fn volume(&self) -> f64 {
        let (piece, center) = (self, &Vector3::zeros());
        let seen = Seen { piece, center };
        let volumes = self.edges.blocks().iter().map(|edges| {
            let [left, right] = FourEdges::new(&seen, edges).sides(&seen);
            left.six_volumes() + right.six_volumes()
        });
        sum(volumes.fold(f64x4::ZERO, |all, some| all + some)) / 6.0
    }

    /// Volume and moments about the origin, by the tetrahedra (origin, q, a, b) of all edges.
    #[must_use]
    pub fn moments(&self) -> Moments {
        let mut moments = Moments::default();
        for edge in self.edges.blocks().as_flattened() {
            let [a, b] = [edge.from, edge.to].map(|vertex| self.vertices.get(vertex as usize));
            let (sum, squares) = (a + b, a * a.transpose() + b * b.transpose());
            for (facet, fan) in [(edge.left, a.cross(&b)), (edge.right, b.cross(&a))] {
                let facet = self.facets.get(facet as usize);
                // The foot of the perpendicular from the origin.
                let foot = facet.normal * facet.offset;
                let volume = facet.normal.dot(&fan) * facet.offset / 6.0;
                let all = sum + foot;
                moments.mass += volume;
                moments.first += all * (volume / 4.0);
                let squares = squares + foot * foot.transpose() + all * all.transpose();
                moments.second += squares * (volume / 20.0);
            }
        }
        moments
    }

    /// Turns the piece about the origin. A density would have to be turned too, and is not.
    pub fn rotate(&mut self, rotation: &Rotation3<f64>) {
        self.vertices.rotate(rotation);
        self.facets.rotate(rotation);
    }

    /// The positions of the vertices.
    pub fn vertices(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        self.vertices.iter().map(Point3::from)
    }

    fn assign_convex(&mut self, piece: &Polyhedron) {
        let points = piece.x.iter().zip(&piece.y).zip(&piece.z);
        self.vertices.assign(points.map(|((x, y), z)| [*x, *y, *z]));
        self.assign_facets(piece.planes.iter(), piece.labels.iter());
        self.at_vertices.assign_polyhedron(piece);
        let rows = piece.facets.chunks(ROWS).zip(piece.next.chunks(ROWS));
        let edges = rows.enumerate().flat_map(|(chunk, (facets, next))| {
            let first = (chunk * ROWS) as u32;
            let (facets, ends) = (facets.as_flattened(), next.as_flattened());
            upward(next, first).map(move |number| {
                // The facet on the right is the one before, in turn.
                let (row, slot) = (number / 3, number % 3);
                let right = if slot == 0 { number + 2 } else { number - 1 };
                Edge {
                    from: first + row as u32,
                    to: ends[number],
                    left: facets[number],
                    right: facets[right],
                }
            })
        });
        self.edges.assign(edges, piece.facets.len() * 3 / 2);
    }

    /// A facet that is not convex or not connected is the signed sum of the triangles on its edges
    /// no less than a convex one, and the walk takes it for what it is.
    fn assign_brep(&mut self, piece: &Brep) {
        self.vertices
            .assign(piece.vertices.iter().map(|&vertex| vertex.into()));
        self.at_vertices.clear();
        let facets = piece.facets.iter();
        self.assign_facets(
            facets.clone().map(|(plane, _)| plane),
            facets.map(|(_, label)| label),
        );
        self.edges
            .assign(piece.edges.iter().copied(), piece.edges.len());
    }

    pub(crate) fn assign_facets<'a>(
        &mut self,
        planes: impl Iterator<Item = &'a HalfSpace>,
        labels: impl Iterator<Item = &'a Label>,
    ) {
        self.copy_facets(planes, labels);
        self.facets.normalize();
    }

    /// As [`Integrand::assign_facets`], with normals as they are.
    pub(crate) fn copy_facets<'a>(
        &mut self,
        planes: impl Iterator<Item = &'a HalfSpace>,
        labels: impl Iterator<Item = &'a Label>,
    ) {
        self.facets.assign(planes);
        self.labels.clear();
        self.labels.extend(labels);
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
