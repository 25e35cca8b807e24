//! Points drawn at random from domains.

use nalgebra::{Point2, Point3};

use crate::domain::planar::PlaneDomain;
use crate::domain::shape::DomainShape;
use crate::geometry::cover::Cover;
use crate::geometry::random::{PointSource, Random, points_inside};

/// `count` points uniform over Ω: by rejection from its bounds, or from a [`Cover`] of it where those
/// are nearly empty.
///
/// # Errors
/// The number of draws in a row that missed Ω.
pub(crate) fn random_points(
    shape: &dyn DomainShape,
    count: usize,
    seed: u64,
) -> Result<Vec<Point3<f64>>, u64> {
    let contains = |site: &Point3<f64>| shape.contains(site);
    points_inside(count, seed, &shape.bounds(), contains, || {
        source_in_solid(shape)
    })
}

/// A source of points uniform over a [`Cover`] of Ω, if its boundary is one of triangles.
pub(crate) fn source_in_solid(shape: &dyn DomainShape) -> Option<PointSource<'static, 3>> {
    let contains = |point: &Point3<f64>| shape.contains(point);
    let cover = Cover::new(&shape.boundary(), shape.volume(), contains)?;
    Some(Box::new(move |random| cover.point(random)))
}

/// A source of points uniform over a domain of the plane, by the triangles of its pieces' fans.
pub(crate) fn source_in_plane(domain: &PlaneDomain) -> Option<PointSource<'static, 2>> {
    let mut sum = 0.0;
    let (mut triangles, mut areas) = (Vec::new(), Vec::new());
    for piece in domain.pieces() {
        let corners = piece.vertices();
        for pair in corners[1..].windows(2) {
            let doubled = (pair[0] - corners[0]).perp(&(pair[1] - corners[0]));
            sum += 0.5 * doubled.max(0.0);
            areas.push(sum);
            triangles.push([corners[0], pair[0], pair[1]]);
        }
    }
    Some(Box::new(move |random| {
        in_triangles(&triangles, &areas, random)
    }))
}

/// A point uniform over triangles; `areas` are those of each and all before it.
fn in_triangles(triangles: &[[Point2<f64>; 3]], areas: &[f64], random: &mut Random) -> Point2<f64> {
    let share = random.uniform() * areas.last().copied().unwrap_or(0.0);
    let at = areas
        .partition_point(|&sum| sum <= share)
        .min(areas.len() - 1);
    let (mut along, mut across) = (random.uniform(), random.uniform());
    // The far half of the parallelogram, turned onto the triangle.
    if along + across > 1.0 {
        (along, across) = (1.0 - along, 1.0 - across);
    }
    let [from, one, other] = triangles[at];
    from + along * (one - from) + across * (other - from)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::domain::convex::ConvexPolyhedron;
    use crate::domain::tri_surface::solid::SurfaceSolid;
    use crate::geometry::half_space::HalfSpace;
    use crate::mesh::formats::read::read_surface;
    use nalgebra::Vector3;

    const COUNT: usize = 1000;

    /// Mean and mean square of where the points stand along the diagonal, as shares of its length.
    fn assert_even_along(points: &[Point3<f64>], along: &Vector3<f64>) {
        let share = |point: &Point3<f64>| point.coords.dot(along) / along.norm_squared();
        let count = points.len() as f64;
        let mean = points.iter().map(share).sum::<f64>() / count;
        let square = points.iter().map(|p| share(p).powi(2)).sum::<f64>() / count;
        // Deviations of x and x² uniform in [0, 1]: √(1/12), √(4/45).
        assert!(
            (mean - 0.5).abs() < 4.0 * (1.0 / 12.0 / count).sqrt(),
            "{mean}"
        );
        assert!(
            (square - 1.0 / 3.0).abs() < 4.0 * (4.0 / 45.0 / count).sqrt(),
            "{square}"
        );
    }

    #[test]
    fn sites_in_thin_diagonal_rods_are_even() {
        for name in ["diagonal-rod-1e-04.off", "diagonal-rod-1e-08.off"] {
            let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
            let mesh = read_surface(&cases.join(name)).unwrap();
            let solid = SurfaceSolid::from_arrays(&mesh.vertices, &mesh.triangles).unwrap();
            let points = random_points(&solid, COUNT, 1).unwrap();
            assert_eq!(points[..100], random_points(&solid, 100, 1).unwrap());
            assert!(points.iter().all(|point| solid.contains(point)));
            assert_even_along(&points, &(mesh.vertices[1] - mesh.vertices[0]));
        }
    }

    #[test]
    fn sites_in_thin_half_space_solids_are_even() {
        let along = Vector3::new(1.0, 2.0, -1.5).normalize();
        let across = along.cross(&Vector3::x()).normalize();
        let wall = |normal: Vector3<f64>, offset| HalfSpace { normal, offset };
        let third = along.cross(&across);
        let walls = [
            wall(along, 1.0),
            wall(-along, 0.0),
            wall(across, 1e-5),
            wall(-across, 1e-5),
            wall(third, 1e-5),
            wall(-third, 1e-5),
        ];
        let solid = ConvexPolyhedron::new(&walls).unwrap();
        let points = random_points(&solid, COUNT, 3).unwrap();
        assert!(points.iter().all(|point| solid.contains(point)));
        assert_even_along(&points, &along);
    }

    #[test]
    fn sites_in_a_thin_diagonal_strip_are_even() {
        let corners = [
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0 - 1e-8, 1.0 + 1e-8],
            [-1e-8, 1e-8],
        ];
        let domain = PlaneDomain::from_corners(&corners.map(Point2::from)).unwrap();
        let contains = |point: &Point2<f64>| domain.contains(point);
        let bounds = domain.bounds();
        let points =
            points_inside(COUNT, 1, &bounds, contains, || source_in_plane(&domain)).unwrap();
        let points: Vec<_> = points.iter().map(|p| Point3::new(p.x, p.y, 0.0)).collect();
        assert_even_along(&points, &Vector3::new(1.0, 1.0, 0.0));
    }
}
