//! Which surfaces bound a solid.
//!
//! A surface is accepted if, after the repairs that need no guess, every edge is run along as
//! often in one direction as in the other within each component: then the signed cones from
//! any apex to its triangles fill the solid, whatever its genus, cavities or components.
//!
//! Repairs, each counted in the report: triangles with a repeated vertex and duplicates are
//! dropped; coincident vertices are merged if the surface is open without; triangles are
//! turned to agree with their neighbors; components are turned outward or, inside an odd
//! number of others, inward. Holes are not closed and walls not removed: that is refused.

use nalgebra::Point3;

use crate::mesh::crossings::crossings;
use crate::mesh::edges::EdgeTable;
use crate::mesh::nesting::turn_outward;
use crate::mesh::orient::{Orientation, Places, check_balance, orient, turn_to_neighbors};
use crate::mesh::repair::{Triangles, drop_collapsed, drop_duplicates, weld};
use crate::mesh::report::{Refusal, SurfaceReport, Tally};
use crate::mesh::similarity::Similarity;
use crate::mesh::surface::{SurfaceMesh, triangle_area};
use crate::mesh::tets::compact;

/// A triangle whose area is below this share of its longest edge squared is called flat: the
/// cross product's own rounding.
const FLAT: f64 = 1e-14;

/// A surface that bounds a solid: closed, consistently oriented outward (inward around
/// cavities), of positive volume, without unused vertices. Only [`validate`] makes one.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedSurface {
    surface: SurfaceMesh,
}

impl ClosedSurface {
    /// The surface.
    #[must_use]
    pub fn surface(&self) -> &SurfaceMesh {
        &self.surface
    }

    /// The surface, no longer vouched for.
    #[must_use]
    pub fn into_surface(self) -> SurfaceMesh {
        self.surface
    }

    /// Moves every vertex by `map`, which keeps the surface closed and oriented.
    pub fn transform(&mut self, map: &Similarity) {
        self.surface.transform(map);
    }

    /// Scales uniformly and centers in the unit cube; returns the map.
    pub fn fit_unit_cube(&mut self) -> Similarity {
        self.surface.fit_unit_cube()
    }
}

/// Checks and, where no guess is needed, repairs `mesh`.
///
/// # Errors
///
/// What keeps the surface from bounding a solid, and what to do about it.
pub fn validate(mesh: &SurfaceMesh) -> Result<(ClosedSurface, SurfaceReport), Refusal> {
    check_elements(&mesh.vertices, &mesh.triangles, "triangles")?;
    let mut report = SurfaceReport::default();
    let (vertices, mut triangles, edges) = closed_triangles(mesh, &mut report)?;
    let orientation = orient(&triangles.corners, &edges);
    let places = Places {
        read: &mesh.triangles,
        numbers: &triangles.numbers,
    };
    report.reoriented = turn_to_neighbors(&mut triangles.corners, &orientation, &places)?;
    report.touching = check_balance(&triangles.corners, &edges, &orientation, &places)?;
    let mut surface = SurfaceMesh {
        vertices,
        triangles: triangles.corners,
    };
    turn_outward(&mut surface, &places, &orientation, &mut report);
    describe(
        &surface,
        &triangles.numbers,
        &edges,
        &orientation,
        &mut report,
    );
    report.isolated = unused(mesh);
    compact(&mut surface.vertices, &mut surface.triangles);
    check_volume(&surface)?;
    report.crossings = crossings(&surface).map(|tally| as_read(tally, &triangles.numbers));
    Ok((ClosedSurface { surface }, report))
}

/// Refuses elements without meaning: none, out of range, not finite.
pub(crate) fn check_elements<const N: usize>(
    vertices: &[Point3<f64>],
    elements: &[[u32; N]],
    what: &'static str,
) -> Result<(), Refusal> {
    if elements.is_empty() {
        return Err(Refusal::Empty(what));
    }
    let finite = |point: &Point3<f64>| point.iter().all(|coordinate| coordinate.is_finite());
    if let Some(vertex) = vertices.iter().position(|point| !finite(point)) {
        return Err(Refusal::NotFinite(vertex));
    }
    for (element, corners) in elements.iter().enumerate() {
        if let Some(&vertex) = corners
            .iter()
            .find(|&&vertex| vertex as usize >= vertices.len())
        {
            let vertices = vertices.len();
            return Err(Refusal::OutOfRange {
                element,
                vertex,
                vertices,
            });
        }
    }
    Ok(())
}

/// The vertices, the triangles without collapsed and duplicate ones, and their edges, none of
/// them a boundary; welded only if need be.
fn closed_triangles(
    mesh: &SurfaceMesh,
    report: &mut SurfaceReport,
) -> Result<(Vec<Point3<f64>>, Triangles, EdgeTable), Refusal> {
    let mut vertices = mesh.vertices.clone();
    let mut triangles = Triangles::of(&mesh.triangles);
    let edges = cleaned(&mut triangles, vertices.len(), report);
    let Some(refusal) = open(&edges, mesh, &triangles) else {
        return Ok((vertices, triangles, edges));
    };
    triangles = Triangles::of(&mesh.triangles);
    report.welded = weld(&mut vertices, &mut triangles);
    if report.welded == 0 {
        return Err(refusal);
    }
    let edges = cleaned(&mut triangles, vertices.len(), report);
    match open(&edges, mesh, &triangles) {
        None if triangles.corners.is_empty() => Err(Refusal::Flat),
        None => Ok((vertices, triangles, edges)),
        Some(refusal) => Err(refusal),
    }
}

fn cleaned(triangles: &mut Triangles, vertices: usize, report: &mut SurfaceReport) -> EdgeTable {
    report.collapsed = drop_collapsed(triangles);
    let edges = EdgeTable::of(&triangles.corners, vertices);
    // Duplicates crowd their edges, unless they are all of a component, without volume.
    if edges.iter().all(|edge| edge.sides.len() <= 2) {
        return edges;
    }
    report.duplicates = drop_duplicates(triangles, vertices);
    EdgeTable::of(&triangles.corners, vertices)
}

/// The refusal of edges with a single triangle, if there are any.
fn open(edges: &EdgeTable, mesh: &SurfaceMesh, triangles: &Triangles) -> Option<Refusal> {
    let places = Places {
        read: &mesh.triangles,
        numbers: &triangles.numbers,
    };
    let boundary = edges.iter().filter(|edge| edge.sides.len() == 1);
    let Tally { count, first } = boundary.map(|edge| places.of_side(edge.sides[0])).collect();
    first.map(|first| Refusal::Open { count, first })
}

/// Genus and flat triangles.
fn describe(
    surface: &SurfaceMesh,
    numbers: &[u32],
    edges: &EdgeTable,
    orientation: &Orientation,
    report: &mut SurfaceReport,
) {
    let unused = unused(surface).count;
    let vertices = (surface.vertices.len() - unused) as i64;
    let euler = vertices - edges.len() as i64 + surface.triangles.len() as i64;
    report.genus = orientation.components as i64 - euler / 2;
    let flat = |corners: &[Point3<f64>; 3]| {
        let [a, b, c] = corners;
        let longest_squared = (b - a)
            .norm_squared()
            .max((c - b).norm_squared())
            .max((a - c).norm_squared());
        triangle_area(corners) <= FLAT * longest_squared
    };
    let all = surface.all_corners().zip(numbers);
    report.flat = all
        .filter(|(corners, _)| flat(corners))
        .map(|(_, &number)| number)
        .collect();
}

fn unused(mesh: &SurfaceMesh) -> Tally<u32> {
    let mut used = vec![false; mesh.vertices.len()];
    for &vertex in mesh.triangles.iter().flatten() {
        used[vertex as usize] = true;
    }
    (0..)
        .zip(used)
        .filter(|&(_, used)| !used)
        .map(|(vertex, _)| vertex)
        .collect()
}

/// Refuses a volume that rounding alone could produce.
fn check_volume(surface: &SurfaceMesh) -> Result<(), Refusal> {
    let noise = FLAT * surface.area() * surface.bounds().extent().norm();
    if surface.volume() > noise {
        Ok(())
    } else {
        Err(Refusal::Flat)
    }
}

fn as_read(tally: Tally<[u32; 2]>, numbers: &[u32]) -> Tally<[u32; 2]> {
    let first = tally
        .first
        .map(|pair| pair.map(|triangle| numbers[triangle as usize]));
    Tally { first, ..tally }
}
