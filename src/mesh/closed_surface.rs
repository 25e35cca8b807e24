//! A surface without boundary edges, from triangles as read: cleaned, its vertices merged where it is open
//! without.

use nalgebra::Point3;

use crate::geometry::bounds::Bounds;
use crate::mesh::edges::EdgeTable;
use crate::mesh::orient::{EdgePlaces, is_closed};
use crate::mesh::repair::{Triangles, drop_collapsed, drop_duplicates, drop_twins, weld};
use crate::mesh::report::{Refusal, SurfaceReport, Tally};
use crate::mesh::surface::SurfaceMesh;

/// Vertices of an open surface are merged if they are nearer than so many roundings of its greatest
/// coordinate: a sine or a product of some factors, where another file wrote 0 or a plain number.
const WELD_ROUNDINGS: f64 = 32.0;

/// The same for a surface whose coordinates are all single-precision numbers.
const WELD_ROUNDINGS_SINGLE: f64 = 4.0;

/// Vertices of an open mesh are merged if they are nearer than this share of its box.
pub(crate) const WELD_BOX: f64 = 1e-12;

/// A surface without boundary edges, under repair.
pub(crate) struct ClosedSurface {
    pub(crate) vertices: Vec<Point3<f64>>,
    pub(crate) triangles: Triangles,
    pub(crate) edges: EdgeTable,
    /// Whether every edge is run along as often forward as backward, as read.
    pub(crate) is_balanced: bool,
}

/// The surface without collapsed triangles, duplicates and inner walls. Vertices are merged only if
/// it is open without: equal ones, then those that differ by rounding.
pub(crate) fn closed_surface(
    mesh: &SurfaceMesh,
    weld_within: f64,
    report: &mut SurfaceReport,
) -> Result<ClosedSurface, Refusal> {
    let as_read = (mesh.vertices.clone(), Triangles::of(&mesh.triangles));
    let closed = cleaned(as_read, report);
    let Some(mut refusal) = open(&closed, mesh) else {
        return Ok(closed);
    };
    for distance in weld_distances(mesh, weld_within) {
        let mut welded = (mesh.vertices.clone(), Triangles::of(&mesh.triangles));
        let (merged, apart) = weld(&mut welded.0, &mut welded.1, distance);
        if merged == report.welded {
            continue;
        }
        let mut attempt = SurfaceReport {
            welded: merged,
            welded_apart: apart,
            ..SurfaceReport::default()
        };
        let closed = cleaned(welded, &mut attempt);
        let is_asked = distance <= weld_within;
        let is_guess =
            distance > 0.0 && !is_asked && attempt.collapsed.count > report.collapsed.count;
        match open(&closed, mesh) {
            None if !is_guess => {
                *report = attempt;
                return Ok(closed);
            }
            Some(open) if distance == 0.0 => (refusal, *report) = (open, attempt),
            _ => {}
        }
    }
    Err(as_sheet(refusal, mesh))
}

/// The refusal of an open surface, which for one in a plane says so.
fn as_sheet(refusal: Refusal, mesh: &SurfaceMesh) -> Refusal {
    match refusal {
        Refusal::Open { count, .. } if is_in_plane(mesh) => Refusal::Sheet { count },
        other => other,
    }
}

/// Whether all corners lie in the plane of the greatest triangle, but for rounding.
fn is_in_plane(mesh: &SurfaceMesh) -> bool {
    let normal = |[a, b, c]: [Point3<f64>; 3]| (b - a).cross(&(c - a));
    let greatest = mesh.all_corners().max_by(|one, other| {
        let [one, other] = [*one, *other].map(|corners| normal(corners).norm());
        one.total_cmp(&other)
    });
    let Some(corners) = greatest else {
        return false;
    };
    let Some(unit) = normal(corners).try_normalize(0.0) else {
        return false;
    };
    let size = mesh.bounds().extent().norm();
    mesh.all_corners()
        .flatten()
        .all(|corner| (corner - corners[0]).dot(&unit).abs() <= WELD_BOX * size)
}

/// Within which distances (L) vertices are merged, one after the other: equal ones, those that differ
/// by the rounding of coordinates of this size, the same for single precision if all of them are, a
/// share of the box, and what the caller allows.
fn weld_distances(mesh: &SurfaceMesh, asked: f64) -> Vec<f64> {
    let bounds = mesh.bounds();
    let Bounds { min, max } = bounds;
    let size = min.coords.amax().max(max.coords.amax());
    let single = |x: &f64| f64::from(*x as f32).to_bits() == x.to_bits();
    let mut distances = vec![
        0.0,
        WELD_ROUNDINGS * f64::EPSILON * size,
        WELD_BOX * bounds.extent().amax(),
    ];
    distances.extend((asked > 0.0).then_some(asked));
    if mesh.vertices.iter().all(|vertex| vertex.iter().all(single)) {
        distances.push(WELD_ROUNDINGS_SINGLE * f64::from(f32::EPSILON) * size);
    }
    distances.sort_by(f64::total_cmp);
    distances
}

fn cleaned(
    (vertices, mut triangles): (Vec<Point3<f64>>, Triangles),
    report: &mut SurfaceReport,
) -> ClosedSurface {
    report.collapsed = drop_collapsed(&mut triangles);
    let mut edges = EdgeTable::of(&triangles.corners, vertices.len());
    let mut is_balanced = is_closed(&triangles.corners, &edges);
    if is_balanced {
        (report.cancelled, report.duplicates) = drop_twins(&mut triangles, vertices.len());
        edges = EdgeTable::of(&triangles.corners, vertices.len());
    } else if edges.iter().any(|edge| edge.sides.len() > 2) {
        // A duplicate gives its edges more than two sides.
        report.duplicates = drop_duplicates(&mut triangles, vertices.len());
        edges = EdgeTable::of(&triangles.corners, vertices.len());
        is_balanced = is_closed(&triangles.corners, &edges);
    }
    ClosedSurface {
        vertices,
        triangles,
        edges,
        is_balanced,
    }
}

/// The refusal of edges with a single triangle, if there are any.
fn open(closed: &ClosedSurface, mesh: &SurfaceMesh) -> Option<Refusal> {
    let places = EdgePlaces::of(mesh, &closed.triangles.numbers);
    let boundary = closed.edges.iter().filter(|edge| edge.sides.len() == 1);
    let Tally { count, first } = boundary.map(|edge| places.of_side(edge.sides[0])).collect();
    first.map(|first| Refusal::Open { count, first })
}
