//! A cell's surface as loops of shared corners, for files and pictures.
//!
//! A [`Polyhedron`](crate::geometry::polyhedron::Polyhedron) stores a corner where more than three planes meet as several vertices at one
//! place, and keeps facets without area. Files and pictures need neither: a shell welds such
//! vertices and leaves out facets of fewer than three distinct corners. Unlike a polyhedron it need not be convex, so cells clipped
//! to solids have shells too.
//!
//! # Conventions
//!
//! Facets are loops of corner numbers, counter-clockwise as seen from outside. A shell with a
//! single facet is a polygon of the plane z = 0, counter-clockwise as seen from +z.

use nalgebra::{Point2, Point3, Rotation3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::label::Label;

/// A closed surface of polygons, or one polygon.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shell {
    vertices: Vec<Point3<f64>>,
    /// All facets' corners, one facet after the other.
    corners: Vec<u32>,
    /// Where each facet ends in `corners`.
    ends: Vec<usize>,
}

/// Why a surface is no [`Shell`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("facet {facet} names corner {corner}, but there are only {vertices} vertices")]
pub struct ShellError {
    /// The facet, from zero.
    pub facet: usize,
    /// The corner number that it names.
    pub corner: u32,
    /// How many vertices there are.
    pub vertices: usize,
}

/// Vertices nearer than this share of the surface's largest extent are one. Far above the rounding
/// of coordinates, far below what changes a volume in its first nine digits.
const WELD: f64 = 1e-10;

impl Shell {
    /// The surface whose facets are loops of numbers in `vertices`, welded.
    ///
    /// # Errors
    /// [`ShellError`] if a facet names a vertex that is not there.
    pub fn new<F>(
        vertices: &[Point3<f64>],
        facets: impl IntoIterator<Item = F>,
    ) -> Result<Self, ShellError>
    where
        F: IntoIterator<Item = u32>,
    {
        let welded = weld(vertices);
        let mut shell = Self::default();
        // The new number of a place, by its first vertex; assigned when a facet first needs it.
        let mut numbers = vec![u32::MAX; vertices.len()];
        for (facet, corners) in facets.into_iter().enumerate() {
            let ring = welded_ring(&welded, facet, corners)?;
            if ring.len() >= 3 {
                shell.push_facet(vertices, &mut numbers, &ring);
            }
        }
        Ok(shell)
    }

    /// The polygon of the plane with these corners, counter-clockwise.
    #[must_use]
    pub fn polygon(corners: &[Point2<f64>]) -> Self {
        let lifted: Vec<Point3<f64>> = corners
            .iter()
            .map(|corner| Point3::new(corner.x, corner.y, 0.0))
            .collect();
        let facet = std::iter::once(0..corners.len() as u32);
        Self::new(&lifted, facet).unwrap_or_default()
    }

    /// The corners' places.
    #[must_use]
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// How many facets there are.
    #[must_use]
    pub fn facet_count(&self) -> usize {
        self.ends.len()
    }

    /// The facets as loops of numbers in [`Shell::vertices`].
    pub fn facets(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts
            .zip(&self.ends)
            .map(|(start, end)| &self.corners[start..*end])
    }

    /// The facets as loops of places.
    pub fn loops(&self) -> impl Iterator<Item = impl ExactSizeIterator<Item = Point3<f64>> + '_> {
        let place = |corner: &u32| self.vertices[*corner as usize];
        self.facets().map(move |facet| facet.iter().map(place))
    }

    /// The enclosed volume (L³) by the divergence theorem; zero for a polygon.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let Some(apex) = self.vertices.first() else {
            return 0.0;
        };
        let six_volumes = self.facets().map(|facet| {
            let arm = |corner: u32| self.vertices[corner as usize] - apex;
            let fans = facet.windows(2).skip(1);
            fans.map(|pair| arm(facet[0]).dot(&arm(pair[0]).cross(&arm(pair[1]))))
                .sum::<f64>()
        });
        six_volumes.sum::<f64>() / 6.0
    }

    /// The shell moved by `displacement`.
    #[must_use]
    pub fn translated(&self, displacement: &Vector3<f64>) -> Self {
        let mut moved = self.clone();
        for vertex in &mut moved.vertices {
            *vertex += displacement;
        }
        moved
    }

    /// The same surface turned about the origin.
    #[must_use]
    pub fn rotated(&self, rotation: &Rotation3<f64>) -> Self {
        let mut turned = self.clone();
        for vertex in &mut turned.vertices {
            *vertex = rotation * *vertex;
        }
        turned
    }

    fn push_facet(&mut self, vertices: &[Point3<f64>], numbers: &mut [u32], ring: &[u32]) {
        for &place in ring {
            let number = &mut numbers[place as usize];
            if *number == u32::MAX {
                *number = self.vertices.len() as u32;
                self.vertices.push(vertices[place as usize]);
            }
            self.corners.push(*number);
        }
        self.ends.push(self.corners.len());
    }
}

impl Shell {
    /// The facets of a piece whose labels are to be kept.
    pub(crate) fn of_facets(piece: Piece<'_>, is_kept: impl Fn(Label) -> bool) -> Self {
        let (vertices, mut facets) = (piece.vertices(), Vec::new());
        piece.visit_polygons(|label, _, corners| {
            if is_kept(label) {
                facets.push(corners.to_vec());
            }
        });
        let shell = Self::new(&vertices, facets);
        // A piece's facets name its own vertices only.
        shell.unwrap_or_default()
    }
}

impl From<Piece<'_>> for Shell {
    fn from(piece: Piece<'_>) -> Self {
        Self::of_facets(piece, |_| true)
    }
}

/// A facet's corners by their welded vertices, without repetitions.
pub(crate) fn welded_ring(
    welded: &[u32],
    facet: usize,
    corners: impl IntoIterator<Item = u32>,
) -> Result<Vec<u32>, ShellError> {
    let vertices = welded.len();
    let place = |corner: u32| {
        let place = welded.get(corner as usize).copied();
        place.ok_or(ShellError {
            facet,
            corner,
            vertices,
        })
    };
    let mut ring: Vec<u32> = corners.into_iter().map(place).collect::<Result<_, _>>()?;
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    Ok(ring)
}

/// For every vertex the first one (along x) that lies at the same place.
pub(crate) fn weld(vertices: &[Point3<f64>]) -> Vec<u32> {
    let reach = WELD * Bounds::of(vertices).extent().max();
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    order.sort_by(|a, b| vertices[*a as usize].x.total_cmp(&vertices[*b as usize].x));
    let mut first = order.clone();
    // Distinct places so far, sorted by x.
    let mut places: Vec<u32> = Vec::with_capacity(order.len());
    for &vertex in &order {
        let here = vertices[vertex as usize];
        let same = places
            .iter()
            .rev()
            .take_while(|place| here.x - vertices[**place as usize].x <= reach)
            .find(|place| (here - vertices[**place as usize]).amax() <= reach);
        first[vertex as usize] = same.copied().unwrap_or(vertex);
        if same.is_none() {
            places.push(vertex);
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::polyhedron::Polyhedron;

    fn unit_cube() -> Polyhedron {
        let bounds = Bounds {
            min: Point3::origin(),
            max: Point3::new(1.0, 1.0, 1.0),
        };
        Polyhedron::cuboid(&bounds, [0; 6])
    }

    #[test]
    fn a_cube_is_a_cube() {
        let shell = Shell::from(Piece::Convex(&unit_cube()));
        assert_eq!((shell.vertices().len(), shell.facet_count()), (8, 6));
        assert!((shell.volume() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_repeated_corner_is_welded_and_its_sliver_left_out() {
        // A box whose top corner (1,1,1) is split into two points with a sliver between them.
        let near = 1.0 + 1e-15;
        let vertices = [
            [0., 0., 0.],
            [1., 0., 0.],
            [1., 1., 0.],
            [0., 1., 0.],
            [0., 0., 1.],
            [1., 0., 1.],
            [1., 1., 1.],
            [0., 1., 1.],
            [near, near, 1.],
        ];
        let facets: [&[u32]; 8] = [
            &[0, 3, 2, 1],
            &[4, 5, 8, 6, 7],
            &[0, 1, 5, 4],
            &[1, 2, 8, 5],
            &[2, 3, 7, 6],
            &[3, 0, 4, 7],
            &[2, 6, 8],
            &[8, 6, 8],
        ];
        let facets = facets.map(|facet| facet.iter().copied());
        let shell = Shell::new(&vertices.map(Point3::from), facets).expect("valid numbers");
        assert_eq!((shell.vertices().len(), shell.facet_count()), (8, 6));
        assert!((shell.volume() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_polygon_has_one_facet_and_no_volume() {
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 1.0]].map(Point2::from);
        let shell = Shell::polygon(&corners);
        assert_eq!((shell.vertices().len(), shell.facet_count()), (3, 1));
        assert!(shell.volume().abs() < 1e-15);
    }

    #[test]
    fn numbers_beyond_the_vertices_are_refused() {
        let error = Shell::new(&[Point3::origin()], [[0, 7, 0]]).expect_err("refused");
        assert_eq!((error.facet, error.corner, error.vertices), (0, 7, 1));
    }
}
