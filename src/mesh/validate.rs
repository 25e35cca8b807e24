//! Validated meshes: surfaces that bound a solid and tetrahedra that fill one.
//!
//! A surface is accepted if, after the repairs that need no guess, every edge is run along as
//! often in one direction as in the other within each component: then the signed cones from
//! any apex to its triangles fill the solid, whatever its genus, cavities or components.
//!
//! Repairs, each counted in the report: triangles with a repeated vertex and duplicates are
//! dropped; coincident vertices are merged if the surface is open without; triangles are
//! turned to agree with their neighbors; components are turned outward or, inside an odd
//! number of others, inward. Holes are not closed and walls not removed: that is refused.
//!
//! Of tetrahedra, inverted ones are turned, flat and duplicate ones dropped, unused vertices
//! removed with their data, each counted in the report. A facet of more than two tetrahedra is
//! refused. Other overlaps are not searched for.

use nalgebra::Point3;

use crate::mesh::crossings::crossings;
use crate::mesh::edges::EdgeTable;
use crate::mesh::nesting::turn_outward;
use crate::mesh::orient::{EdgePlaces, check_balance, orient, turn_to_neighbors};
use crate::mesh::repair::{Triangles, drop_collapsed, drop_duplicates, weld};
use crate::mesh::report::{Refusal, SurfaceReport, Tally, TetReport};
use crate::mesh::similarity::Similarity;
use crate::mesh::surface::{SurfaceMesh, triangle_area};
use crate::mesh::tets::{TetMesh, compact, tet_volume, used_vertices};

/// Coordinates beyond this (L) are refused: the product of three of them, 2³² times, still is a number.
const FARTHEST: f64 = 1e98;

/// A triangle whose area is below this share of its longest edge squared is called flat: the
/// cross product's own rounding.
const FLAT_TRIANGLE: f64 = 1e-14;

/// A tetrahedron whose volume is below this share of its longest edge cubed is flat: less than
/// the determinant's own rounding.
const FLAT_TET: f64 = 1e-15;

/// A mesh that was checked. Only [`validate_surface`] and [`validate_tets`] make one.
#[derive(Clone, Debug, PartialEq)]
pub struct Valid<M> {
    mesh: M,
}

/// A surface that bounds a solid: closed, consistently oriented outward (inward around
/// cavities), of positive volume, without unused vertices.
pub type ValidSurface = Valid<SurfaceMesh>;

/// Tetrahedra that fill a solid: each of positive volume, every facet of at most two of them, no
/// unused vertices.
pub type ValidTetMesh = Valid<TetMesh>;

impl<M> Valid<M> {
    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &M {
        &self.mesh
    }

    /// The mesh, no longer known to be valid.
    #[must_use]
    pub fn into_mesh(self) -> M {
        self.mesh
    }
}

/// A solid given by its boundary or by tetrahedra that fill it, with what was repaired.
#[derive(Clone, Debug, PartialEq)]
pub enum Solid {
    /// The boundary.
    Surface(ValidSurface, SurfaceReport),
    /// The filling.
    Tets(ValidTetMesh, TetReport),
}

impl Solid {
    /// What was found and repaired, one sentence each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        match self {
            Self::Surface(_, report) => report.notes(),
            Self::Tets(_, report) => report.notes(),
        }
    }

    /// The solid's volume (L³).
    #[must_use]
    pub fn volume(&self) -> f64 {
        match self {
            Self::Surface(surface, _) => surface.mesh.volume(),
            Self::Tets(tets, _) => tets.mesh.volume(),
        }
    }

    /// Moves the solid by `map`, which keeps it valid.
    pub fn transform(&mut self, map: &Similarity) {
        match self {
            Self::Surface(surface, _) => map.move_all(&mut surface.mesh.vertices),
            Self::Tets(tets, _) => map.move_all(&mut tets.mesh.vertices),
        }
    }
}

/// Checks and, where no guess is needed, repairs `mesh`.
///
/// # Errors
///
/// What keeps the surface from bounding a solid, and what to do about it.
pub fn validate_surface(mesh: &SurfaceMesh) -> Result<(ValidSurface, SurfaceReport), Refusal> {
    check_elements(&mesh.vertices, &mesh.triangles, "triangles")?;
    let mut report = SurfaceReport::default();
    let (vertices, mut triangles, edges) = closed_triangles(mesh, &mut report)?;
    let orientation = orient(&triangles.corners, &edges);
    let places = EdgePlaces::of(mesh, &triangles.numbers);
    report.reoriented = turn_to_neighbors(&mut triangles.corners, &orientation, &places)?;
    report.touching = check_balance(&triangles.corners, &edges, &orientation, &places)?;
    let mut surface = SurfaceMesh {
        vertices,
        triangles: triangles.corners,
    };
    turn_outward(&mut surface, &places, &orientation, &mut report);
    report.genus = genus(&surface, &edges, orientation.components);
    report.flat = flat_triangles(&surface, &triangles.numbers);
    report.isolated = unused(mesh);
    compact(&mut surface.vertices, &mut surface.triangles);
    check_volume(&surface)?;
    report.crossings = crossings(&surface).map(|tally| as_read(tally, &triangles.numbers));
    Ok((Valid { mesh: surface }, report))
}

/// Refuses elements that reach so far that their volumes overflow.
fn check_reach<const N: usize>(
    vertices: &[Point3<f64>],
    elements: &[[u32; N]],
) -> Result<(), Refusal> {
    let is_far = |vertex: &&u32| {
        let point = vertices.get(**vertex as usize);
        point.is_some_and(|point| point.coords.amax() > FARTHEST)
    };
    match elements.iter().flatten().find(is_far) {
        Some(&vertex) => Err(Refusal::TooFar(vertex)),
        None => Ok(()),
    }
}

/// Refuses elements without meaning: none, out of range, not finite.
fn check_elements<const N: usize>(
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
    check_reach(vertices, elements)?;
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
    // A duplicate gives its edges more than two sides, unless the whole component is duplicated:
    // that encloses no volume.
    if edges.iter().all(|edge| edge.sides.len() <= 2) {
        return edges;
    }
    report.duplicates = drop_duplicates(triangles, vertices);
    EdgeTable::of(&triangles.corners, vertices)
}

/// The refusal of edges with a single triangle, if there are any.
fn open(edges: &EdgeTable, mesh: &SurfaceMesh, triangles: &Triangles) -> Option<Refusal> {
    let places = EdgePlaces::of(mesh, &triangles.numbers);
    let boundary = edges.iter().filter(|edge| edge.sides.len() == 1);
    let Tally { count, first } = boundary.map(|edge| places.of_side(edge.sides[0])).collect();
    first.map(|first| Refusal::Open { count, first })
}

/// The sum of the components' genera by Euler's formula.
fn genus(surface: &SurfaceMesh, edges: &EdgeTable, components: usize) -> i64 {
    let unused = unused(surface).count;
    let vertices = (surface.vertices.len() - unused) as i64;
    let euler = vertices - edges.len() as i64 + surface.triangles.len() as i64;
    components as i64 - euler / 2
}

/// The triangles without area, by their numbers as read.
fn flat_triangles(surface: &SurfaceMesh, numbers: &[u32]) -> Tally<u32> {
    let flat = |corners: &[Point3<f64>; 3]| {
        let [a, b, c] = corners;
        let longest_squared = (b - a)
            .norm_squared()
            .max((c - b).norm_squared())
            .max((a - c).norm_squared());
        triangle_area(corners) <= FLAT_TRIANGLE * longest_squared
    };
    let all = surface.all_corners().zip(numbers);
    all.filter(|(corners, _)| flat(corners))
        .map(|(_, &number)| number)
        .collect()
}

fn unused(mesh: &SurfaceMesh) -> Tally<u32> {
    let used = used_vertices(&mesh.triangles, mesh.vertices.len());
    (0..)
        .zip(used)
        .filter(|&(_, used)| !used)
        .map(|(vertex, _)| vertex)
        .collect()
}

/// Refuses a volume that rounding alone could produce.
fn check_volume(surface: &SurfaceMesh) -> Result<(), Refusal> {
    let noise = FLAT_TRIANGLE * surface.area() * surface.bounds().extent().norm();
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

/// Checks and, where no guess is needed, repairs `mesh`.
///
/// # Errors
///
/// What keeps the mesh from filling a solid, and what to do about it.
pub fn validate_tets(mesh: &TetMesh) -> Result<(ValidTetMesh, TetReport), Refusal> {
    check_elements(&mesh.vertices, &mesh.tets, "tetrahedra")?;
    check_data(mesh)?;
    let mut mesh = mesh.clone();
    let mut report = TetReport::default();
    let numbers = keep_positive(&mut mesh, &mut report);
    if mesh.tets.is_empty() {
        return Err(Refusal::Flat);
    }
    check_facets(&mesh, &numbers)?;
    report.isolated = drop_unused(&mut mesh);
    Ok((Valid { mesh }, report))
}

/// Refuses data of the wrong length, and values of the tetrahedra's vertices that are not finite
/// where the field itself does not say so.
fn check_data(mesh: &TetMesh) -> Result<(), Refusal> {
    let used = used_vertices(&mesh.tets, mesh.vertices.len());
    for field in &mesh.vertex_data {
        if field.values.len() != mesh.vertices.len() {
            return Err(Refusal::NotFinite(field.values.len()));
        }
        let is_bad = |(value, used): (&f64, &bool)| *used && !value.is_finite();
        let bad = field.values.iter().zip(&used).position(is_bad);
        if let (Some(vertex), None) = (bad, &field.fault) {
            return Err(Refusal::NotFinite(vertex));
        }
    }
    Ok(())
}

/// Turns inverted tetrahedra, drops flat and duplicate ones; returns the numbers as read of
/// those kept.
fn keep_positive(mesh: &mut TetMesh, report: &mut TetReport) -> Vec<u32> {
    let duplicate = duplicates(&mesh.tets);
    let mut numbers = Vec::with_capacity(mesh.tets.len());
    let mut kept = Vec::with_capacity(mesh.tets.len());
    for (number, (&tet, duplicate)) in (0..).zip(mesh.tets.iter().zip(duplicate)) {
        let corners = tet.map(|vertex| mesh.vertices[vertex as usize]);
        let volume = tet_volume(&corners);
        if duplicate {
            report.duplicates.add(number);
        } else if volume.abs() <= FLAT_TET * longest_edge(&corners).powi(3) {
            report.flat.add(number);
        } else {
            let [a, b, c, d] = tet;
            kept.push(if volume > 0.0 { tet } else { [a, c, b, d] });
            numbers.push(number);
            if volume < 0.0 {
                report.inverted.add(number);
            }
        }
    }
    mesh.tets = kept;
    numbers
}

/// Marks of the tetrahedra on the same four vertices as an earlier one.
fn duplicates(tets: &[[u32; 4]]) -> Vec<bool> {
    let sorted = |mut tet: [u32; 4]| {
        tet.sort_unstable();
        tet
    };
    let mut keys: Vec<([u32; 4], u32)> = tets.iter().map(|&tet| sorted(tet)).zip(0..).collect();
    keys.sort_unstable();
    let mut marked = vec![false; tets.len()];
    for pair in keys.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        marked[pair[1].1 as usize] = true;
    }
    marked
}

fn longest_edge(corners: &[Point3<f64>; 4]) -> f64 {
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let lengths = pairs.map(|(from, to)| (corners[to] - corners[from]).norm());
    lengths.into_iter().fold(0.0, f64::max)
}

fn check_facets(mesh: &TetMesh, numbers: &[u32]) -> Result<(), Refusal> {
    let mut facets = mesh.facets();
    facets.sort_unstable();
    let groups = facets.chunk_by(|one, other| one.0 == other.0);
    let overfull = groups.filter(|group| group.len() > 2);
    let Tally { count, first } = overfull
        .map(|group| numbers[group[0].1 as usize / 4])
        .collect();
    first.map_or(Ok(()), |first| Err(Refusal::Overlap { count, first }))
}

/// Drops unused vertices with their data.
fn drop_unused(mesh: &mut TetMesh) -> Tally<u32> {
    let before = mesh.vertices.len();
    let kept = compact(&mut mesh.vertices, &mut mesh.tets);
    for field in &mut mesh.vertex_data {
        field.values = kept
            .iter()
            .map(|&vertex| field.values[vertex as usize])
            .collect();
    }
    let first_gap = (0..)
        .zip(&kept)
        .find(|&(at, &vertex)| at != vertex)
        .map(|(at, _)| at);
    let count = before - kept.len();
    let first = first_gap.or((count > 0).then_some(kept.len() as u32));
    Tally { count, first }
}
