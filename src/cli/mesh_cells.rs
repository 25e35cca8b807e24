//! The cells of a run as a clean mesh, as the options of `chebloyd mesh` say.

use nalgebra::Point3;

use crate::cli::failure::{Failure, print_note};
use crate::complex::assemble::assemble;
use crate::complex::collapse::collapse;
use crate::complex::edit_mesh::EditMesh;
use crate::complex::solid_mesh::{Cleanup, clean_solid};
use crate::complex::straighten::straighten_edges;
use crate::complex::wall_patches::{WallPatches, joined_by_name};
use crate::domain::domain::Domain;
use crate::mesh::poly_mesh::PolyMesh;
use crate::relax::space::Space;
use crate::scene::description::Scene;
use crate::scene::domain::SceneDomain;
use crate::scene::mesh_domain::GroupedSolid;
use crate::voronoi::diagram::Diagram;

/// Edges up to this share of the mean cell's side collapse in solids unless an option says otherwise:
/// shorter ones than that make the skewed faces on walls.
const COLLAPSE: f64 = 0.1;

/// Cells listed in a message.
const LISTED: usize = 5;

/// How cells become a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellMeshing {
    /// Whether walls keep all triangles of the surface.
    pub(crate) is_exact: bool,
    /// The angle of a feature (degrees).
    pub(crate) angle: f64,
    /// Whether the mesh is made into its dual.
    pub(crate) is_for_dual: bool,
    /// The share of the mean cell's side below which edges collapse, if it is given.
    pub(crate) collapse: Option<f64>,
}

/// A mesh of cells, and what is wrong with it still.
pub(crate) struct MeshedCells {
    /// The mesh.
    pub(crate) mesh: PolyMesh,
    /// How many cells are too coarse for the wall, and where; nothing if there are none.
    pub(crate) complaint: Option<String>,
}

/// The patches of a domain's walls.
pub(crate) fn patches_of(space: &Space, scene: &Scene, angle: f64) -> WallPatches {
    let grouped = scene.domain.grouped_surface();
    patches_with(space, scene, angle, grouped.ok().flatten().as_ref())
}

/// The same, given the groups of the surface's file.
fn patches_with(
    space: &Space,
    scene: &Scene,
    angle: f64,
    grouped: Option<&GroupedSolid>,
) -> WallPatches {
    match (&scene.domain, space.domain().surface_mesh()) {
        (SceneDomain::Box(_), _) => WallPatches::Box,
        (_, Some(surface)) => match grouped {
            Some(file) => WallPatches::by_groups(surface, angle, &file.groups, &file.names),
            None => WallPatches::by_features(surface, angle),
        },
        (_, None) => WallPatches::Each,
    }
}

/// The mesh of the cells of `sites`.
pub(crate) fn mesh_cells(
    space: &Space,
    scene: &Scene,
    sites: &[Point3<f64>],
    meshing: CellMeshing,
) -> Result<MeshedCells, Failure> {
    let grouped = scene.domain.grouped_surface().map_err(Failure::input)?;
    let domain: &dyn Domain = match &grouped {
        Some(file) => &file.solid,
        None => space.domain(),
    };
    let patches = patches_with(space, scene, meshing.angle, grouped.as_ref());
    let diagram = Diagram::new(domain, sites).map_err(Failure::input)?;
    let surface = domain.surface_mesh().filter(|_| !meshing.is_exact);
    if let Some(surface) = surface {
        let cleanup = Cleanup {
            collapse: meshing.collapse.unwrap_or(COLLAPSE),
            angle: meshing.angle,
            joins_slivers: !meshing.is_for_dual,
        };
        let clean = clean_solid(&diagram, surface, &patches, cleanup).map_err(Failure::run)?;
        clean.mesh.check_closed().map_err(Failure::run)?;
        return Ok(MeshedCells {
            complaint: complaint(&clean.too_coarse),
            mesh: joined_by_name(&clean.mesh),
        });
    }
    let mut mesh = assemble(&diagram, &patches).map_err(Failure::run)?;
    let not_balls = mesh.check_closed().map_err(Failure::run)?;
    if let Some(first) = not_balls.first() {
        let count = not_balls.len();
        print_note(format!(
            "{count} cells are no balls, the first: {first}; more sites mend that"
        ));
    }
    let share = meshing.collapse.unwrap_or(0.0);
    if share > 0.0 {
        mesh = collapsed(&mesh, domain.volume(), share)?;
    }
    Ok(MeshedCells {
        mesh: joined_by_name(&mesh),
        complaint: None,
    })
}

/// The mesh without edges shorter than `share` sides of the mean cell, as far as quality allows it.
fn collapsed(mesh: &PolyMesh, volume: f64, share: f64) -> Result<PolyMesh, Failure> {
    let side = (volume / mesh.cell_count as f64).cbrt();
    let mut edited = EditMesh::of(mesh);
    collapse(&mut edited, share * side, None);
    straighten_edges(&mut edited, 0.5 * share * side);
    let mesh = edited.finish();
    mesh.check_closed().map_err(Failure::run)?;
    Ok(mesh)
}

/// The cells that are too coarse, in words.
fn complaint(cells: &[(u32, Point3<f64>)]) -> Option<String> {
    if cells.is_empty() {
        return None;
    }
    let places = cells
        .iter()
        .take(LISTED)
        .map(|(site, at)| format!("site {site} at [{:.4}, {:.4}, {:.4}]", at.x, at.y, at.z));
    let places: Vec<String> = places.collect();
    let more = if cells.len() > LISTED { ", …" } else { "" };
    Some(format!(
        "{} cells are too coarse for the wall, where two walls or edges lie within one cell: {}{more}; take \
         more sites there, or keep the mesh as it is",
        cells.len(),
        places.join(", ")
    ))
}
