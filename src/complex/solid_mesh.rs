//! The mesh of a diagram's cells in a solid: walls of few polygons, no cell inverted.
//!
//! The conforming complex has all triangles of the surface on its walls. Then, in this order: the faces of a
//! cell's walls are merged ([`wall_polygons`](crate::complex::wall_polygons)), chains straightened, small
//! pieces joined to neighbors, bad cells improved ([`repair`](crate::complex::repair)), short edges collapsed,
//! and what is bad still improved again; vertices that came to one place become one, slivers that are left join a
//! neighbor.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Point3;

use crate::complex::assemble::{AssembleError, assemble_with_walls};
use crate::complex::collapse::collapse;
use crate::complex::edit_mesh::EditMesh;
use crate::complex::repair::Repair;
use crate::complex::straighten::straighten_edges;
use crate::complex::wall_patches::WallPatches;
use crate::complex::wall_polygons::{merge_walls, pin_corners};
use crate::complex::wall_projection::WallProjection;
use crate::mesh::poly_mesh::PolyMesh;
use crate::mesh::surface::SurfaceMesh;
use crate::voronoi::diagram::Diagram;

/// How far (degrees) merged triangles may be turned from their mean, and how far chords may lie from chains of
/// edges, in sides of the mean cell: the coarsest of these that loses no more than [`LOST`] is taken.
const LEVELS: [(f64, f64); 4] = [(40.0, 0.1), (20.0, 0.05), (10.0, 0.03), (5.0, 0.01)];

/// The share of the volume that walls may lose before their finest level.
const LOST: f64 = 0.009;

/// Rounding of places, in sides of the mean cell.
const ROUNDING: f64 = 1e-9;

/// Vertices nearer to each other than this, in sides of the mean cell, are at one place for a solver.
const SAME_PLACE: f64 = 1e-6;

/// How walls and edges are cleaned.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cleanup {
    /// Edges shorter than this share of the mean cell's side collapse.
    pub(crate) collapse: f64,
    /// The angle of a feature (degrees).
    pub(crate) angle: f64,
    /// Whether all is done to join slivers to neighbors: solvers need that for cells; for the dual it leaves
    /// worse elements.
    pub(crate) joins_slivers: bool,
}

/// A clean mesh, and the cells that are too coarse for the wall: their sites and places.
#[derive(Clone, Debug)]
pub(crate) struct CleanMesh {
    /// The mesh.
    pub(crate) mesh: PolyMesh,
    /// Per cell that misses the limits: its site, and where it is.
    pub(crate) too_coarse: Vec<(u32, Point3<f64>)>,
}

/// The mesh of the cells of `diagram` within `surface`.
///
/// # Errors
/// [`AssembleError`] when a site has no cell, or cells do not fit together.
pub(crate) fn clean_solid(
    diagram: &Diagram<'_>,
    surface: &SurfaceMesh,
    patches: &WallPatches,
    cleanup: Cleanup,
) -> Result<CleanMesh, AssembleError> {
    let (raw, walls) = assemble_with_walls(diagram, patches)?;
    let site_count = raw.sites.iter().max().map_or(0, |&last| last + 1);
    let side = (diagram.domain().volume() / f64::from(site_count.max(1))).cbrt();
    let inner = raw.neighbor.len();
    // The patches of the mesh by the numbers of its walls.
    let mut numbers = BTreeMap::new();
    for (number, patch) in (0..).zip(&raw.patches) {
        numbers.insert(patches.of(walls[patch.start - inner]), number);
    }
    let of_triangle = (0..surface.triangles.len() as u32).map(|triangle| {
        numbers
            .get(&patches.of(triangle))
            .copied()
            .unwrap_or(u32::MAX)
    });
    let of_triangle: Vec<u32> = of_triangle.collect();
    let projection = WallProjection::new(surface, &of_triangle, cleanup.angle, 2.0 * side);
    let raw = EditMesh::of(&raw);
    let of_face: BTreeMap<u32, u32> = (inner as u32..).zip(walls).collect();
    let mut mesh = raw.clone();
    for (turn, chord) in LEVELS {
        mesh = raw.clone();
        merge_walls(&mut mesh, &of_face, &projection, turn);
        pin_corners(&mut mesh, &projection, 1e-5 * side);
        straighten_edges(&mut mesh, ROUNDING * side);
        straighten_edges(&mut mesh, chord * side);
        let lost = 1.0 - mesh.volume() / diagram.domain().volume();
        if lost.abs() <= LOST {
            break;
        }
    }
    drop(raw);
    let too_coarse = clean(&mut mesh, &projection, site_count, (side, cleanup));
    let places = too_coarse.into_iter().map(|cell| {
        let center = mesh.cell_shape(cell).center;
        (mesh.sites[cell as usize], center)
    });
    let too_coarse = places.collect();
    Ok(CleanMesh {
        mesh: mesh.finish(),
        too_coarse,
    })
}

/// Cleans a mesh whose walls are few polygons; returns the cells that are bad still.
fn clean(
    mesh: &mut EditMesh,
    walls: &WallProjection,
    first_piece: u32,
    (side, cleanup): (f64, Cleanup),
) -> Vec<u32> {
    let mut repair = Repair {
        mesh,
        walls,
        side,
        first_piece,
        mends_unions: cleanup.joins_slivers,
        stuck: BTreeSet::new(),
    };
    repair.join_pieces();
    repair.run();
    let share = cleanup.collapse;
    if share > 0.0 {
        collapse(repair.mesh, share * side, Some(walls));
        straighten_edges(repair.mesh, 0.5 * share * side);
        repair.stuck.clear();
    }
    repair.run();
    if share > 0.0 {
        // Vertices that were moved to one place of the surface.
        collapse(repair.mesh, SAME_PLACE * side, Some(walls));
    }
    repair.join_slivers();
    repair.failing()
}
