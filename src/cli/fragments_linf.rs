//! The fragments of L∞ cells: their parts in the six cones.

use nalgebra::{Point3, Vector3};

use crate::cli::failure::Failure;
use crate::cli::fragment_part::{FragmentPart, Wanted};
use crate::export::vtu::{FragmentSector, FragmentTets};
use crate::geometry::brep::Piece;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::shell::Shell;
use crate::mesh::tets::tet_volume;
use crate::relax::evaluate_cell::CellMemory;
use crate::relax::frames::Frames;
use crate::relax::linf_cell::visit_fan;
use crate::relax::space::Space;
use crate::voronoi::diagram::Diagram;
use crate::voronoi::linf::cell::{LinfCell, Ties};
use crate::voronoi::linf::cone::{CONES, Cone};

/// The memory of fragments.
#[derive(Debug, Default)]
struct FanScratch {
    cell: CellMemory,
    tetrahedron: Polyhedron,
}

/// The fragments of the cells wanted, each in the order of the sectors, in site order.
///
/// # Errors
/// In domains that are not convex, and when the sites have no diagram.
pub(crate) fn linf_parts(
    space: &Space,
    sites: &[Point3<f64>],
    wanted: Wanted,
) -> Result<Vec<(usize, [FragmentPart; CONES])>, Failure> {
    if !space.domain().is_convex() {
        let message =
            "in a domain that is not convex only L2 cells have fragments: choose --cells l2";
        return Err(Failure::input(message));
    }
    if !matches!(space.frames(), Frames::Axes) {
        let message = "fragments of L∞ cells lie along the axes of space: leave out frames, or choose --cells l2";
        return Err(Failure::input(message));
    }
    let diagram = Diagram::new(space.domain(), sites).map_err(Failure::input)?;
    let cells = diagram.map_linf(Ties::ToSmallerIndex, |scratch: &mut FanScratch, cell| {
        let site = cell.site as usize;
        let is_wanted = wanted.site.is_none_or(|wanted| wanted == site);
        is_wanted.then(|| {
            let part = |number| part(space, &cell, number, wanted, scratch);
            (site, std::array::from_fn(part))
        })
    });
    let cells = cells.map_err(Failure::input)?;
    Ok(cells.into_iter().flatten().collect())
}

/// The part in a cone.
fn part(
    space: &Space,
    cell: &LinfCell<'_>,
    number: usize,
    wanted: Wanted,
    scratch: &mut FanScratch,
) -> FragmentPart {
    let FanScratch {
        cell: memory,
        tetrahedron,
    } = scratch;
    let mut part = FragmentPart::default();
    memory.begin_parts(None);
    cell.visit_cone(number, |_, fragment, is_side| {
        if is_side {
            return;
        }
        if wanted.tets {
            part.tets.extend(tets(cell, number, &fragment.corners));
        }
        visit_fan(fragment, tetrahedron, &mut |tetrahedron: &Polyhedron| {
            memory.add_part(space.domain(), &cell.position, tetrahedron);
        });
    });
    if wanted.tets {
        return part;
    }
    if let Some(outline) = cell.cone_outline(number) {
        part.shell = Shell::from(Piece::Brep(&outline)).translated(&cell.position.coords);
    }
    part.volume = memory.volume();
    part.energy = memory.energy_at_site(wanted.spec);
    part
}

/// The tetrahedra between a fragment of a facet and the site; none that are flat.
fn tets(cell: &LinfCell<'_>, number: usize, corners: &[Vector3<f64>]) -> Option<FragmentTets> {
    let cone = Cone::all()[number];
    let places = || std::iter::once(Vector3::zeros()).chain(corners.iter().copied());
    let height = |at: Vector3<f64>| cone.coordinates(&at)[0].max(0.0);
    let mut part = FragmentTets {
        site: cell.site as usize,
        sector: FragmentSector {
            axis: cone.axis as i64,
            sign: if cone.is_negative { -1 } else { 1 },
        },
        points: places().map(|at| cell.position + at).collect(),
        distances: places().map(height).collect(),
        tets: Vec::new(),
        volumes: Vec::new(),
    };
    for second in 2..corners.len() as u32 {
        let tet = [0, 1, second, second + 1];
        let volume = tet_volume(&tet.map(|vertex| part.points[vertex as usize]));
        if volume > 0.0 {
            part.tets.push(tet);
            part.volumes.push(volume);
        }
    }
    (!part.tets.is_empty()).then_some(part)
}
