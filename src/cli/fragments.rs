//! `chebloyd fragments`: one cell parted by the axis and direction of its Chebyshev distance.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::{Point3, Rotation3, Vector3};

use crate::domain::facet_kind::FacetKind;
use crate::domain::{domain::Domain, shape::PieceScratch};
use crate::energy::evaluation::EnergyScratch;
use crate::energy::evaluation::{SignedPiece, energy};
use crate::energy::fragments::fragments_in_frame;
use crate::energy::prepared::PreparedPiece;
use crate::energy::sector::Sector;
use crate::export::vtu::{CellGeometry, write_cells};
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::shell::Shell;
use crate::plot::exploded::{Fragment, FragmentedCell, exploded};
use crate::relax::relaxation_space::{Norm, RelaxationSpace};
use crate::relax::space::Space;
use crate::scene::overrides::Overrides;
use crate::scene::run::RunSpace;
use crate::voronoi::diagram::Diagram;

use crate::cli::failure::{Failure, format_of, print, write_file};
use crate::cli::options::{Common, SceneOptions, space};

/// Take one cell apart into its six fragments, as a picture or as polyhedra
///
/// A fragment holds the points whose Chebyshev distance from the site lies along one axis and
/// direction. In a .vtu file each is a polyhedron with its volume and its share of the energy.
#[derive(Debug, Args)]
pub(crate) struct FragmentsOptions {
    #[command(flatten)]
    scene: SceneOptions,
    /// Whose cell, counting from zero [default: the site nearest the middle of the domain]
    #[arg(long, value_name = "I")]
    site: Option<usize>,
    /// The file to write: .png or .vtu
    #[arg(long, short, value_name = "FILE", required = true)]
    output: PathBuf,
}

pub(crate) fn run(options: &FragmentsOptions, common: Common) -> Result<(), Failure> {
    let scene = options.scene.scene(Overrides::default())?;
    if scene.dimension != 3 {
        let message = "fragments are drawn of cells in space only: choose \"dimension\": 3";
        return Err(Failure::input(message));
    }
    if scene.cells == Norm::Linf {
        let message = "fragments are drawn of L2 cells only: choose --cells l2";
        return Err(Failure::input(message));
    }
    let is_picture = format_of(&options.output, ["png", "vtu"])? == "png";
    let space = space(&scene)?;
    let sites = space.place(&scene).map_err(Failure::input)?;
    let site = options.site.unwrap_or_else(|| middle(&space, &sites));
    let position = *sites.get(site).ok_or_else(|| {
        let count = sites.len();
        Failure::input(format!(
            "there is no site {site} among {count}; the first is 0"
        ))
    })?;
    let parts = parts(&space, &sites, site)?;
    if is_picture {
        draw(&options.output, site, &position, &parts)?;
    } else {
        export(&options.output, site, &parts)?;
    }
    if common.quiet {
        return Ok(());
    }
    print(format!("{}\n", options.output.display()))
}

/// The site nearest the middle of the domain's box.
fn middle(space: &Space, sites: &[Point3<f64>]) -> usize {
    let center = space.bounds().center();
    let distance = |site: usize| (sites[site] - center).norm_squared();
    (0..sites.len())
        .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
        .unwrap_or_default()
}

/// A fragment of a cell within the domain.
#[derive(Clone, Debug, Default)]
struct FragmentPart {
    shell: Shell,
    /// The integral of the Chebyshev distance from the site over it.
    energy: f64,
}

/// The fragments of a site's cell, in the order of the sectors.
fn parts(space: &Space, sites: &[Point3<f64>], site: usize) -> Result<Vec<FragmentPart>, Failure> {
    let diagram = Diagram::new(space.domain(), sites).map_err(Failure::input)?;
    let cells = diagram.map(|scratch: &mut PieceScratch, cell| {
        let wanted = cell.site as usize == site;
        wanted.then(|| {
            let frame = frame(space, site);
            let (origin, label) = (Point3::origin(), FacetKind::Inner.label());
            let wedges = fragments_in_frame(cell.polyhedron(), &origin, &frame, label);
            wedges.map(|wedge| part(space.domain(), &cell.position, &frame, &wedge, scratch))
        })
    });
    let parts = cells.map_err(Failure::input)?.swap_remove(site);
    Ok(parts.map(Vec::from).unwrap_or_default())
}

/// The frame in which a site's cell measures distances.
fn frame(space: &Space, site: usize) -> Rotation3<f64> {
    let number = u32::try_from(site).unwrap_or(u32::MAX);
    space.frames().of(number).copied().unwrap_or_default()
}

/// The part of a wedge within the domain, in coordinates relative to the site.
fn part(
    domain: &dyn Domain,
    site: &Point3<f64>,
    frame: &Rotation3<f64>,
    wedge: &Polyhedron,
    scratch: &mut PieceScratch,
) -> FragmentPart {
    let mut part = FragmentPart::default();
    if wedge.is_empty() {
        return part;
    }
    domain.outline(site, wedge, scratch, &mut |piece| {
        part.shell = Shell::from(piece).translated(&site.coords);
    });
    let mut energy_scratch = EnergyScratch::default();
    domain.pieces(site, wedge, scratch, &mut |sign, piece| {
        let mut prepared = PreparedPiece::default();
        prepared.assign(piece);
        prepared.rotate(&frame.inverse());
        let piece = SignedPiece {
            sign,
            piece: prepared,
        };
        part.energy += energy([&piece], &Vector3::zeros(), 1, &mut energy_scratch).value;
    });
    part
}

fn draw(
    path: &Path,
    site: usize,
    position: &Point3<f64>,
    parts: &[FragmentPart],
) -> Result<(), Failure> {
    let fragment = |(sector, part): (Sector, &FragmentPart)| Fragment {
        axis: sector.axis(),
        positive: sector.sign() > 0.0,
        shell: part.shell.clone(),
    };
    let cell = FragmentedCell {
        caption: format!("Fragments of the cell of site {site}"),
        center: *position,
        fragments: Sector::ALL.into_iter().zip(parts).map(fragment).collect(),
    };
    let bytes = exploded(&[cell]).map_err(Failure::run)?;
    write_file(path, |file| file.write_all(&bytes)).map_err(Failure::input)
}

fn export(path: &Path, site: usize, parts: &[FragmentPart]) -> Result<(), Failure> {
    let is_there = |part: &&FragmentPart| part.shell.facet_count() > 0;
    let cells = parts.iter().filter(is_there).map(|part| CellGeometry {
        site,
        energy: part.energy,
        volume: part.shell.volume(),
        cubeness: 0.0,
        facet_count: part.shell.facet_count(),
        shell: part.shell.clone(),
    });
    write_cells(path, cells).map_err(Failure::input)?;
    Ok(())
}
