//! Validated meshes: surfaces that bound a solid and tetrahedra that fill one.
//!
//! A surface is accepted if every edge is run along as often in one direction as in the other: then
//! the signed cones from any apex to its triangles fill a solid, whatever its genus, cavities or
//! components. Where that holds as read, only twins are dropped (triangles on the same corners, which
//! cancel or repeat each other), and everything is turned if the volume is negative.
//!
//! Other surfaces are repaired where that needs no guess, each repair counted in the report:
//! triangles with a repeated vertex and duplicates are dropped; vertices are merged if the surface is
//! open without, first equal ones, then those nearer than the rounding of their coordinates;
//! triangles are turned to agree with their neighbors, components so repaired are turned outward or,
//! inside an odd number of others, inward. Holes are not closed: that is refused.
//!
//! What an accepted surface encloses more than once or negatively is reported (`overlap`).
//!
//! Of tetrahedra, vertices of boundary facets that nearly coincide are merged (`weld_tets`), inverted ones are turned, flat and duplicate ones dropped, unused vertices
//! removed with their data, each counted in the report. A facet of more than two tetrahedra, or of
//! two on one side, is refused. What they fill more than once is reported.

use nalgebra::Point3;

use crate::mesh::closing::{WELD_BOX, closed_surface};
use crate::mesh::edges::EdgeTable;
use crate::mesh::nesting::{join_open, turn_outward};
use crate::mesh::orient::{EdgePlaces, check_balance, orient, touching, turn_to_neighbors};
use crate::mesh::overlap::overlaps;
use crate::mesh::repair::Welder;
use crate::mesh::report::{Overlap, Refusal, SurfaceReport, Tally, TetReport};
use crate::mesh::similarity::Similarity;
use crate::mesh::surface::{SurfaceMesh, triangle_area};
use crate::mesh::tets::{FACETS, TetMesh, compact, tet_volume, used_vertices};
use crate::mesh::weld_tets::welded_tets;

/// Coordinates beyond this (L) are refused: the product of three of them, 2³² times, still is a number.
const FARTHEST: f64 = 1e98;

/// A triangle whose area is below this share of its longest edge squared is called flat: the
/// cross product's own rounding.
const FLAT_TRIANGLE: f64 = 1e-14;

/// A tetrahedron is flat if its height over its greatest facet is below this share of its greatest
/// coordinate: what the rounding of coordinates makes of four points in a plane.
const FLAT_TET: f64 = 16.0 * f64::EPSILON;

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

    /// Notes of the file's reader, which come first.
    pub(crate) fn set_file_notes(&mut self, notes: Vec<String>) {
        match self {
            Self::Surface(_, report) => report.file = notes,
            Self::Tets(_, report) => report.file = notes,
        }
    }

    /// What is enclosed or filled more than once.
    pub(crate) fn repeated(&self) -> Option<&Overlap> {
        match self {
            Self::Surface(_, report) => report.repeated.as_ref(),
            Self::Tets(_, report) => report.repeated.as_ref(),
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
    number_surface(mesh, 0.0).map(|(surface, report, _)| (surface, report))
}

/// As [`validate_surface`]; where the surface is open, vertices up to `weld` apart (L) are merged too.
/// Also the numbers as read of the triangles that are left.
pub(crate) fn number_surface(
    mesh: &SurfaceMesh,
    weld: f64,
) -> Result<(ValidSurface, SurfaceReport, Vec<u32>), Refusal> {
    check_elements(&mesh.vertices, &mesh.triangles, "triangles")?;
    let mut report = SurfaceReport::default();
    let closed = closed_surface(mesh, weld, &mut report)?;
    let (mut triangles, edges) = (closed.triangles, closed.edges);
    if triangles.corners.is_empty() {
        return Err(Refusal::Flat);
    }
    let mut orientation = orient(&triangles.corners, &edges);
    let places = EdgePlaces::of(mesh, &triangles.numbers);
    if !closed.is_balanced {
        report.reoriented = turn_to_neighbors(&mut triangles.corners, &orientation, &places)?;
        check_balance(&triangles.corners, &edges, &orientation, &places)?;
    }
    report.touching = touching(&edges, &places);
    join_open(&triangles.corners, &edges, &mut orientation);
    let mut surface = SurfaceMesh {
        vertices: closed.vertices,
        triangles: triangles.corners,
    };
    turn_outward(&mut surface, &places, &orientation, &mut report);
    report.genus = genus(&surface, &edges, orientation.components);
    report.flat = flat_triangles(&surface, &triangles.numbers);
    report.isolated = unused(mesh);
    compact(&mut surface.vertices, &mut surface.triangles);
    check_volume(&surface)?;
    let found = overlaps(&surface, &edges);
    report.repeated = as_read(found.repeated, &triangles.numbers);
    report.negative = as_read(found.negative, &triangles.numbers);
    Ok((Valid { mesh: surface }, report, triangles.numbers))
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

/// The overlap with its element's number as read.
fn as_read(overlap: Option<Overlap>, numbers: &[u32]) -> Option<Overlap> {
    overlap.map(|overlap| Overlap {
        element: numbers[overlap.element as usize],
        ..overlap
    })
}

/// Checks and, where no guess is needed, repairs `mesh`.
///
/// # Errors
///
/// What keeps the mesh from filling a solid, and what to do about it.
pub fn validate_tets(mesh: &TetMesh) -> Result<(ValidTetMesh, TetReport), Refusal> {
    number_tets(mesh, 0.0).map(|(tets, report, _)| (tets, report))
}

/// As [`validate_tets`]; vertices up to `weld` apart (L) are merged too. Also the numbers as read of the
/// tetrahedra that are left.
pub(crate) fn number_tets(
    mesh: &TetMesh,
    weld: f64,
) -> Result<(ValidTetMesh, TetReport, Vec<u32>), Refusal> {
    check_elements(&mesh.vertices, &mesh.tets, "tetrahedra")?;
    check_data(mesh)?;
    let mut report = TetReport::default();
    let distance = weld.max(WELD_BOX * mesh.bounds().extent().amax());
    if let Some((welded, merged, apart)) = welded_tets(mesh, distance, weld > 0.0) {
        (report.welded, report.welded_apart) = (merged, apart);
        if let Ok(checked) = checked_tets(welded, report) {
            return Ok(checked);
        }
        report = TetReport::default();
    }
    checked_tets(mesh.clone(), report)
}

/// Checks a mesh whose vertices are merged as far as they are to be.
fn checked_tets(
    mut mesh: TetMesh,
    mut report: TetReport,
) -> Result<(ValidTetMesh, TetReport, Vec<u32>), Refusal> {
    let numbers = keep_positive(&mut mesh, &mut report);
    if mesh.tets.is_empty() {
        return Err(Refusal::Flat);
    }
    check_facets(&mesh, &numbers)?;
    report.repeated = repeated(&mesh, &numbers);
    report.isolated = drop_unused(&mut mesh);
    Ok((Valid { mesh }, report, numbers))
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
    let duplicate = duplicates(mesh);
    let (mut numbers, mut kept) = (Vec::new(), Vec::new());
    for (number, (&tet, duplicate)) in (0..).zip(mesh.tets.iter().zip(duplicate)) {
        let corners = tet.map(|vertex| mesh.vertices[vertex as usize]);
        let volume = tet_volume(&corners);
        if duplicate {
            report.duplicates.add(number);
        } else if is_flat(volume, &corners) {
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

/// Marks of the tetrahedra on the same four corners as an earlier one, with the same vertices or others.
fn duplicates(mesh: &TetMesh) -> Vec<bool> {
    let mut welder = Welder::with_capacity(mesh.vertices.len());
    let place: Vec<u32> = mesh.vertices.iter().map(|v| welder.index(v)).collect();
    let sorted = |tet: &[u32; 4]| {
        let mut places = tet.map(|vertex| place[vertex as usize]);
        places.sort_unstable();
        places
    };
    let mut keys: Vec<([u32; 4], u32)> = mesh.tets.iter().map(sorted).zip(0..).collect();
    keys.sort_unstable();
    let mut marked = vec![false; mesh.tets.len()];
    for pair in keys.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        marked[pair[1].1 as usize] = true;
    }
    marked
}

fn is_flat(volume: f64, corners: &[Point3<f64>; 4]) -> bool {
    let areas = FACETS.map(|facet| triangle_area(&facet.map(|corner| corners[corner])));
    let size = corners.iter().map(|c| c.coords.amax()).fold(0.0, f64::max);
    3.0 * volume.abs() <= FLAT_TET * size * areas.into_iter().fold(0.0, f64::max)
}

/// Refuses facets of more than two tetrahedra, and of two on the same side.
fn check_facets(mesh: &TetMesh, numbers: &[u32]) -> Result<(), Refusal> {
    let mut facets = mesh.facets();
    facets.sort_unstable();
    let groups = facets.chunk_by(|one, other| one.0 == other.0);
    let side = |facet: &([u32; 3], u32)| {
        let [a, b, c] = mesh.facet(facet.1);
        (a < b) ^ (b < c) ^ (c < a)
    };
    let wrong = groups.filter(|group| match group {
        [_] => false,
        [one, other] => side(one) == side(other),
        _ => true,
    });
    let Tally { count, first } = wrong
        .map(|group| numbers[group[0].1 as usize / 4])
        .collect();
    first.map_or(Ok(()), |first| Err(Refusal::Overlap { count, first }))
}

/// What the tetrahedra fill more than once: what their boundary encloses more than once.
fn repeated(mesh: &TetMesh, numbers: &[u32]) -> Option<Overlap> {
    let (boundary, facets) = mesh.boundary_facets();
    let edges = EdgeTable::of(&boundary.triangles, boundary.vertices.len());
    let overlap = overlaps(&boundary, &edges).repeated?;
    let tet = facets[overlap.element as usize] as usize / 4;
    let element = numbers[tet];
    Some(Overlap { element, ..overlap })
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
