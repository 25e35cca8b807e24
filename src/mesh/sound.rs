//! Which tetrahedral meshes fill a solid.
//!
//! Inverted tetrahedra are turned, flat and duplicate ones dropped, unused vertices removed with
//! their data; each is counted in the report. A facet of more than two tetrahedra is refused.
//! Other overlaps are not looked for.

use nalgebra::Point3;

use crate::mesh::report::{Refusal, Tally, TetReport};
use crate::mesh::similarity::Similarity;
use crate::mesh::tets::{TetMesh, compact, tet_volume};
use crate::mesh::validate::check_elements;

/// A tetrahedron whose volume is below this share of its longest edge cubed is flat: less than
/// the determinant's own rounding.
const FLAT: f64 = 1e-15;

/// A mesh that fills a solid: every tetrahedron of positive volume, every facet of at most two
/// of them, no unused vertices. Only [`validate_tets`] makes one.
#[derive(Clone, Debug, PartialEq)]
pub struct SoundTets {
    mesh: TetMesh,
}

impl SoundTets {
    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// The mesh, no longer vouched for.
    #[must_use]
    pub fn into_mesh(self) -> TetMesh {
        self.mesh
    }

    /// Moves every vertex by `map`, which keeps the tetrahedra sound.
    pub fn transform(&mut self, map: &Similarity) {
        self.mesh.transform(map);
    }

    /// Scales uniformly and centers in the unit cube; returns the map.
    pub fn fit_unit_cube(&mut self) -> Similarity {
        self.mesh.fit_unit_cube()
    }
}

/// Checks and, where no guess is needed, repairs `mesh`.
///
/// # Errors
///
/// What keeps the mesh from filling a solid, and what to do about it.
pub fn validate_tets(mesh: &TetMesh) -> Result<(SoundTets, TetReport), Refusal> {
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
    Ok((SoundTets { mesh }, report))
}

fn check_data(mesh: &TetMesh) -> Result<(), Refusal> {
    for field in &mesh.vertex_data {
        let bad = field.values.iter().position(|value| !value.is_finite());
        let missing = (field.values.len() != mesh.vertices.len()).then_some(field.values.len());
        bad.or(missing)
            .map_or(Ok(()), |vertex| Err(Refusal::NotFinite(vertex)))?;
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
        } else if volume.abs() <= FLAT * longest_edge(&corners).powi(3) {
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

/// Which tetrahedra stand on the same four vertices as an earlier one.
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
    let crowded = groups.filter(|group| group.len() > 2);
    let Tally { count, first } = crowded
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
