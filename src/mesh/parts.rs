//! Volumes that several solids, parts of one body, have in common.

use nalgebra::Point3;

use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::mesh::edges::EdgeTable;
use crate::mesh::overlap::overlaps;
use crate::mesh::report::Overlap;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::validate::Solid;
use crate::mesh::winding::visit_turns;

/// Less than this share of what the parts themselves enclose repeatedly is rounding.
const ROUNDING: f64 = 1e-9;

/// A volume that belongs to several parts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SharedVolume {
    /// The volume (L³) by which the parts' sum exceeds that of their union.
    pub(crate) volume: f64,
    /// A point in several parts.
    pub(crate) place: Point3<f64>,
    /// The numbers of the parts that hold it.
    pub(crate) parts: Vec<usize>,
}

/// What `solids` have in common beyond what each of them encloses more than once.
#[must_use]
pub(crate) fn shared_volume(solids: &[Solid]) -> Option<SharedVolume> {
    if solids.len() < 2 {
        return None;
    }
    let (all, part_of) = together(solids);
    let edges = EdgeTable::of(&all.triangles, all.vertices.len());
    let Overlap { volume, place, .. } = overlaps(&all, &edges).repeated?;
    let repeated = solids.iter().filter_map(Solid::repeated);
    let own: f64 = repeated.map(|overlap| overlap.volume).sum();
    let shared = volume - own;
    let tree = Bvh::new(all.all_corners().map(|corners| Bounds::of(&corners)));
    let mut windings = vec![0; solids.len()];
    visit_turns(&all, &tree, &place, |triangle, turns| {
        windings[part_of[triangle as usize]] += turns;
    });
    let parts = (0..solids.len()).filter(|&part| windings[part] != 0);
    (shared > ROUNDING * own).then(|| SharedVolume {
        volume: shared,
        place,
        parts: parts.collect(),
    })
}

/// The boundaries of all solids as one surface, and the solid of every triangle.
fn together(solids: &[Solid]) -> (SurfaceMesh, Vec<usize>) {
    let mut all = SurfaceMesh::default();
    let mut part_of = Vec::new();
    for (number, solid) in solids.iter().enumerate() {
        let boundary = match solid {
            Solid::Surface(surface, _) => surface.mesh().clone(),
            Solid::Tets(tets, _) => tets.mesh().boundary(),
        };
        let base = all.vertices.len() as u32;
        let moved = boundary
            .triangles
            .iter()
            .map(|t| t.map(|vertex| vertex + base));
        all.triangles.extend(moved);
        all.vertices.extend(boundary.vertices);
        part_of.resize(all.triangles.len(), number);
    }
    (all, part_of)
}
