//! The elements of a solid: its Voronoi cells, the vertices of its tetrahedra, or points that fill it.
//!
//! Each is given by its ten moments at density 1; a density is one number for each. Cells and hat functions
//! of vertices are exact: their sums are the moments of the field that is constant in every cell, or linear
//! in every tetrahedron. Points stand for the tetrahedra of convex parts of cells, four to each by the rule of
//! degree two, so that the solid's own moments are exact; those of a field have the rule's error.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::arrays::MapEach;
use crate::domain::shape::PieceScratch;
use crate::geometry::moments::Moments;
use crate::geometry::polyhedron::Polyhedron;
use crate::mesh::tets::{TetMesh, tet_volume};
use crate::voronoi::diagram::{Diagram, DiagramError};

/// The corner's share and the others' of the four points of degree two: (5 ± √5 …)/20.
const RULE: [f64; 2] = [0.585_410_196_624_968_5, 0.138_196_601_125_010_5];

/// The moments of the cells of a diagram, measured from `origin`, in site order.
///
/// # Errors
/// When two sites coincide.
pub(crate) fn of_cells(
    diagram: &Diagram<'_>,
    origin: &Point3<f64>,
) -> Result<Vec<Moments>, DiagramError> {
    diagram.map_cells(|cell| cell.moments().translated(&(cell.position - origin)))
}

/// The moments of the hat functions of a mesh's vertices, measured from `origin`: over a tetrahedron of the
/// volume V with the corners p, s their sum, V/4; V/20 (s + p_a); V/120 (s sᵀ + Σ p pᵀ + p_a sᵀ + s p_aᵀ +
/// 2 p_a p_aᵀ).
pub(crate) fn of_vertices(mesh: &TetMesh, origin: &Point3<f64>) -> Vec<Moments> {
    let mut hats = vec![Moments::default(); mesh.vertices.len()];
    for (tet, corners) in mesh.tets.iter().zip(mesh.all_corners()) {
        let volume = tet_volume(&corners);
        let arms = corners.map_each(|corner| corner - origin);
        let sum: Vector3<f64> = arms.iter().sum();
        let squares: Matrix3<f64> = arms.iter().map(|arm| arm * arm.transpose()).sum();
        for (&vertex, arm) in tet.iter().zip(&arms) {
            let mixed = arm * sum.transpose();
            let own = arm * arm.transpose() * 2.0;
            let second = sum * sum.transpose() + squares + mixed + mixed.transpose() + own;
            hats[vertex as usize] += Moments {
                mass: volume / 4.0,
                first: (sum + arm) * (volume / 20.0),
                second: second * (volume / 120.0),
            };
        }
    }
    hats
}

/// A point of the weight of the part of a solid for which it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WeightedPoint {
    pub(crate) position: Point3<f64>,
    /// A volume (L³).
    pub(crate) weight: f64,
}

impl WeightedPoint {
    /// Its moments, measured from `origin`.
    pub(crate) fn moments(&self, origin: &Point3<f64>) -> Moments {
        let at_zero = Moments {
            mass: self.weight,
            ..Moments::default()
        };
        at_zero.translated(&(self.position - origin))
    }
}

/// The tetrahedra of convex parts of a diagram's cells: together the domain.
///
/// # Errors
/// When two sites coincide.
pub(crate) fn tetrahedra(diagram: &Diagram<'_>) -> Result<Vec<[Point3<f64>; 4]>, DiagramError> {
    let of_cells = diagram.map(|scratch: &mut PieceScratch, cell| {
        let (domain, site) = (diagram.domain(), &cell.position);
        let mut tets = Vec::new();
        let mut fill = |part: &Polyhedron| fan(part, site, &mut tets);
        domain.convex_parts(site, cell.polyhedron(), scratch, &mut fill);
        tets
    })?;
    Ok(of_cells.concat())
}

/// A convex part as tetrahedra from its first vertex.
fn fan(part: &Polyhedron, site: &Point3<f64>, tets: &mut Vec<[Point3<f64>; 4]>) {
    let corners: Vec<_> = part.vertices().map(|v| site + v.coords).collect();
    for facet in part.facets() {
        let rim: Vec<usize> = facet.vertex_numbers().collect();
        if rim.contains(&0) || rim.len() < 3 {
            continue;
        }
        let pairs = rim[1..].windows(2);
        let tet = |pair: &[usize]| [0, rim[0], pair[0], pair[1]].map_each(|vertex| corners[vertex]);
        tets.extend(pairs.map(tet).filter(|tet| tet_volume(tet) > 0.0));
    }
}

/// Four points for every tetrahedron.
pub(crate) fn points(tets: &[[Point3<f64>; 4]]) -> Vec<WeightedPoint> {
    let of_tet = |tet: &[Point3<f64>; 4]| {
        let weight = tet_volume(tet) / 4.0;
        let sum: Vector3<f64> = tet.iter().map(|corner| corner.coords).sum();
        let at = |corner: Point3<f64>| sum * RULE[1] + corner.coords * (RULE[0] - RULE[1]);
        tet.map_each(|corner| WeightedPoint {
            position: at(corner).into(),
            weight,
        })
    };
    tets.iter().flat_map(of_tet).collect()
}

/// Every tetrahedron cut into eight by the middles of its edges.
pub(crate) fn eighths(tets: &[[Point3<f64>; 4]]) -> Vec<[Point3<f64>; 4]> {
    let of_tet = |tet: &[Point3<f64>; 4]| {
        let middle = |i: usize, k: usize| nalgebra::center(&tet[i], &tet[k]);
        let [ab, ac, ad] = [1, 2, 3].map_each(|k| middle(0, k));
        let [bc, bd, cd] = [middle(1, 2), middle(1, 3), middle(2, 3)];
        let [a, b, c, d] = *tet;
        [
            [a, ab, ac, ad],
            [ab, b, bc, bd],
            [ac, bc, c, cd],
            [ad, bd, cd, d],
            [ab, ac, ad, bd],
            [ab, bc, ac, bd],
            [ac, cd, ad, bd],
            [ac, bc, cd, bd],
        ]
    };
    tets.iter().flat_map(of_tet).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::cuboid::Cuboid;
    use crate::domain::tri_surface::solid::SurfaceSolid;
    use crate::integrals::mesh_moments::{at_vertices, constant};

    fn close(one: &Moments, other: &Moments) -> f64 {
        let pairs = one.ten().into_iter().zip(other.ten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    fn tet_mesh() -> TetMesh {
        let vertices = [
            [0.0, 0.0, 0.0],
            [1.0, 0.1, 0.0],
            [0.2, 1.0, 0.1],
            [0.1, 0.2, 1.1],
            [1.0, 1.1, 1.2],
        ];
        TetMesh {
            vertices: vertices.map(Point3::from).to_vec(),
            tets: vec![[0, 1, 2, 3], [1, 4, 2, 3]],
            vertex_data: Vec::new(),
        }
    }

    #[test]
    fn hats_add_up_to_linear_fields() {
        let (mesh, origin) = (tet_mesh(), Point3::new(0.3, 0.1, -0.2));
        let values = [1.0, 0.5, 2.0, 0.25, 3.0];
        let hats = of_vertices(&mesh, &origin);
        let sum = hats
            .iter()
            .zip(values)
            .fold(Moments::default(), |sum, (hat, value)| sum + *hat * value);
        let wanted = at_vertices(&mesh.vertices, &mesh.tets, &values, &origin);
        assert!(close(&sum, &wanted) < 1e-15);
    }

    #[test]
    fn cells_and_points_fill_a_solid_that_is_not_convex() {
        let corners: Vec<[f64; 3]> = vec![
            [0., 0., 0.],
            [2., 0., 0.],
            [2., 1., 0.],
            [1., 1., 0.],
            [1., 2., 0.],
            [0., 2., 0.],
            [0., 0., 1.],
            [2., 0., 1.],
            [2., 1., 1.],
            [1., 1., 1.],
            [1., 2., 1.],
            [0., 2., 1.],
        ];
        let mut triangles = vec![[0, 2, 1], [0, 3, 2], [0, 5, 3], [3, 5, 4]];
        triangles.extend(
            triangles
                .clone()
                .iter()
                .map(|&[a, b, c]: &[u32; 3]| [a + 6, c + 6, b + 6]),
        );
        for side in 0..6 {
            let next = (side + 1) % 6;
            triangles.push([side, next, next + 6]);
            triangles.push([side, next + 6, side + 6]);
        }
        let solid = SurfaceSolid::from_arrays(&corners, &triangles).expect("an L");
        let sites = [
            [0.5, 0.5, 0.5],
            [1.5, 0.4, 0.3],
            [0.4, 1.6, 0.7],
            [0.9, 0.9, 0.2],
        ];
        let diagram = Diagram::new(&solid, &sites).expect("cells");
        let origin = Point3::new(0.1, 0.2, 0.3);
        let places: Vec<_> = corners.iter().map(|&c| Point3::from(c)).collect();
        let wanted = constant(&places, &triangles, &origin);
        let cells = of_cells(&diagram, &origin).expect("cells");
        let sum = |all: &[Moments]| all.iter().fold(Moments::default(), |sum, one| sum + *one);
        assert!(close(&sum(&cells), &wanted) < 1e-13);
        let tets = tetrahedra(&diagram).expect("cells");
        for tets in [&tets, &eighths(&tets)] {
            let points = points(tets);
            assert!(points.iter().all(|point| point.weight > 0.0));
            let points: Vec<_> = points.iter().map(|point| point.moments(&origin)).collect();
            assert!(close(&sum(&points), &wanted) < 1e-13);
        }
        let cube = Cuboid::unit();
        let diagram = Diagram::new(&cube, &[[0.5; 3]]).expect("a cell");
        assert_eq!(tetrahedra(&diagram).expect("a cell").len(), 6);
    }
}
