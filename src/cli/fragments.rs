//! `chebloyd fragments`: one cell parted by the axis and direction of its Chebyshev distance.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::{Point3, Rotation3, Vector3};

use crate::cli::failure::{Failure, format_of, no_site, print, write_file};
use crate::cli::fragment_part::{FragmentPart, Wanted};
use crate::cli::fragments_linf::linf_parts;
use crate::cli::fragments_plane::draw_fragments;
use crate::cli::options::{Common, SceneOptions, print_notes, space};
use crate::cli::output::OutputRule;
use crate::domain::facet_kind::FacetKind;
use crate::domain::{domain::Domain, shape::PieceScratch};
use crate::energy::fragments::fragments_in_frame;
use crate::energy::sector::Sector;
use crate::export::vtu::{CellGeometry, FragmentGeometry, FragmentSector, FragmentTets, VtuWriter};
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::shell::Shell;
use crate::mesh::tets::tet_volume;
use crate::plot::exploded::{Fragment, FragmentedCell, exploded};
use crate::plot::exploded_lines::exploded_figure;
use crate::plot::svg::svg;
use crate::relax::evaluate_cell::CellMemory;
use crate::relax::relaxation_space::{Norm, RelaxationSpace};
use crate::relax::space::Space;
use crate::scene::description::Scene;
use crate::scene::overrides::Overrides;
use crate::scene::run::{RunSpace, energy_spec};
use crate::voronoi::diagram::Diagram;

/// Tetrahedra of at most this share of their longest edge cubed are flat: rounding of the determinant.
const FLAT: f64 = 4e-15;

/// Take one cell apart into its six fragments (in the plane four), as a picture or as polyhedra
///
/// A fragment holds the points whose Chebyshev distance from the site lies along one axis and
/// direction. In a .vtu file each is a polyhedron with its volume, its share of the energy in the scene's
/// norm, order and density, its axis and sign, and the distance at its points. With --tets the file
/// holds tetrahedra, over which the distance is linear: `chebloyd mass --density vertex:distance` of
/// those of all cells is the sum of the energies of order 1 that `measure` prints.
#[derive(Debug, Args)]
pub(crate) struct FragmentsOptions {
    #[command(flatten)]
    scene: SceneOptions,
    /// Whose cell, counting from zero [default: the site nearest the middle of the domain]
    #[arg(long, value_name = "I")]
    site: Option<usize>,
    /// Write the fragments of every cell (.vtu only)
    #[arg(long, conflicts_with = "site")]
    all: bool,
    /// Write the fragments as tetrahedra, fanned from the site, with the distance at their points (.vtu
    /// only)
    #[arg(long)]
    tets: bool,
    /// The file to write: .svg, .png or .vtu (in the plane .svg or .png)
    #[arg(long, short, value_name = "FILE", required = true)]
    output: PathBuf,
    /// Replace FILE if it is there
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(options: &FragmentsOptions, common: Common) -> Result<(), Failure> {
    let scene = options.scene.scene(Overrides::default())?;
    let format = format_of(&options.output, ["png", "svg", "vtu"])?;
    let is_picture = format != "vtu";
    if scene.dimension == 2 && !is_picture {
        let message = "in the plane fragments are drawn: name the file .svg or .png";
        return Err(Failure::input(message));
    }
    if is_picture && (options.all || options.tets) {
        let message = "--all and --tets write a .vtu file; a picture shows one cell";
        return Err(Failure::input(message));
    }
    let rule = OutputRule {
        inputs: &options.scene.inputs(&scene),
        force: options.force,
        option: "-o",
    };
    rule.check(std::slice::from_ref(&options.output))?;
    if scene.dimension == 2 {
        draw_fragments(&scene, options.site, (&options.output, format))?;
    } else {
        write_in_space(options, &scene, format)?;
    }
    if common.quiet {
        return Ok(());
    }
    print(format!("{}\n", options.output.display()))
}

/// Writes the fragments of cells in space.
fn write_in_space(options: &FragmentsOptions, scene: &Scene, format: &str) -> Result<(), Failure> {
    let space = space(scene)?;
    let placed = space.placed(scene).map_err(Failure::input)?;
    print_notes(&placed.notes);
    let sites = placed.sites;
    let site = options.site.unwrap_or_else(|| middle(&space, &sites));
    let position = *sites.get(site).ok_or_else(|| no_site(site, sites.len()))?;
    let wanted = Wanted {
        site: (!options.all).then_some(site),
        spec: energy_spec(scene),
        tets: options.tets,
    };
    let cells = match space.cells() {
        Norm::L2 => parts(&space, &sites, wanted)?,
        Norm::Linf => linf_parts(&space, &sites, wanted)?,
    };
    let file = (&*options.output, format);
    match cells.first() {
        Some((_, parts)) if format != "vtu" => draw(file, site, &position, parts),
        _ => export(&options.output, &space, &sites, &cells),
    }
}

/// The site nearest the middle of the domain's box.
fn middle(space: &Space, sites: &[Point3<f64>]) -> usize {
    let center = space.bounds().center();
    let distance = |site: usize| (sites[site] - center).norm_squared();
    (0..sites.len())
        .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
        .unwrap_or_default()
}

/// The memory of [`part`].
#[derive(Debug, Default)]
struct PartScratch {
    cell: CellMemory,
    piece: PieceScratch,
}

/// The fragments of the cells wanted, each in the order of the sectors, in site order.
fn parts(
    space: &Space,
    sites: &[Point3<f64>],
    wanted: Wanted,
) -> Result<Vec<(usize, [FragmentPart; 6])>, Failure> {
    let diagram = Diagram::new(space.domain(), sites).map_err(Failure::input)?;
    let cells = diagram.map(|scratch: &mut PartScratch, cell| {
        let site = cell.site as usize;
        let is_wanted = wanted.site.is_none_or(|wanted| wanted == site);
        is_wanted.then(|| {
            let frame = space.frames().of(cell.site).copied().unwrap_or_default();
            let (origin, label) = (Point3::origin(), FacetKind::Inner.label());
            let wedges = fragments_in_frame(cell.polyhedron(), &origin, &frame, label);
            let cell = FragmentedSite {
                domain: space.domain(),
                site,
                position: cell.position,
                frame,
            };
            let mut sectors = Sector::ALL.into_iter();
            let parts = wedges.map(|wedge| {
                let sector = sectors.next().unwrap_or(Sector::ALL[0]);
                cell.part(sector, &wedge, wanted, scratch)
            });
            (site, parts)
        })
    });
    Ok(cells
        .map_err(Failure::input)?
        .into_iter()
        .flatten()
        .collect())
}

/// A site whose cell is taken apart.
#[derive(Debug)]
struct FragmentedSite<'a> {
    domain: &'a dyn Domain,
    site: usize,
    position: Point3<f64>,
    /// The frame in which distances are measured.
    frame: Rotation3<f64>,
}

impl FragmentedSite<'_> {
    /// The part of a wedge within the domain.
    fn part(
        &self,
        sector: Sector,
        wedge: &Polyhedron,
        wanted: Wanted,
        scratch: &mut PartScratch,
    ) -> FragmentPart {
        let mut part = FragmentPart::default();
        if wedge.is_empty() {
            return part;
        }
        let (domain, site) = (self.domain, &self.position);
        if wanted.tets {
            let fill = |convex: &Polyhedron| part.tets.push(self.tets(sector, convex));
            domain.convex_parts(site, wedge, &mut scratch.piece, &mut { fill });
            return part;
        }
        domain.outline(site, wedge, &mut scratch.piece, &mut |piece| {
            part.shell = Shell::from(piece).translated(&site.coords);
        });
        let memory = &mut scratch.cell;
        memory.load_part(domain, site, wedge, Some(&self.frame));
        part.volume = memory.volume();
        part.energy = memory.energy_at_site(wanted.spec);
        part
    }

    /// A convex part of a fragment as tetrahedra: its vertex nearest to the site, which for a whole
    /// fragment is the site, with the fan triangles of every facet that does not hold that vertex.
    fn tets(&self, sector: Sector, convex: &Polyhedron) -> FragmentTets {
        let distance_squared = |&vertex: &usize| convex.vertex(vertex).coords.norm_squared();
        let apex = (0..convex.vertex_count())
            .min_by(|a, b| distance_squared(a).total_cmp(&distance_squared(b)))
            .unwrap_or_default();
        let mut part = FragmentTets {
            site: self.site,
            sector: of_sector(sector),
            points: convex
                .vertices()
                .map(|v| self.position + v.coords)
                .collect(),
            distances: convex
                .vertices()
                .map(|v| self.distance(sector, &v.coords))
                .collect(),
            tets: Vec::new(),
            volumes: Vec::new(),
        };
        for facet in convex.facets() {
            let rim: Vec<usize> = facet.vertex_numbers().collect();
            if rim.contains(&apex) {
                continue;
            }
            for pair in rim[1..].windows(2) {
                let tet = [apex, rim[0], pair[0], pair[1]];
                let corners = tet.map(|vertex| part.points[vertex]);
                let volume = tet_volume(&corners);
                // Rounding alone: coincident vertices, and facets through the apex.
                let longest = (1..4)
                    .map(|k| (corners[k] - corners[0]).norm())
                    .fold(0.0, f64::max);
                if volume > FLAT * longest.powi(3) {
                    part.tets.push(tet.map(|vertex| vertex as u32));
                    part.volumes.push(volume);
                }
            }
        }
        part
    }

    /// The Chebyshev distance of a point of a fragment, given by its displacement from the site.
    fn distance(&self, sector: Sector, displacement: &Vector3<f64>) -> f64 {
        let turned = self.frame.inverse() * displacement;
        (turned[sector.axis()] * sector.sign()).max(0.0)
    }

    /// A fragment as the file holds it.
    fn geometry(&self, sector: Sector, part: &FragmentPart) -> FragmentGeometry {
        let vertices = part.shell.vertices().iter();
        let distances = vertices.map(|v| self.distance(sector, &(v - self.position)));
        FragmentGeometry {
            sector: of_sector(sector),
            distances: distances.collect(),
            cell: CellGeometry {
                site: self.site,
                energy: part.energy,
                volume: part.volume,
                cubeness: 0.0,
                facet_count: part.shell.facet_count(),
                shell: part.shell.clone(),
            },
        }
    }
}

fn of_sector(sector: Sector) -> FragmentSector {
    FragmentSector {
        axis: sector.axis() as i64,
        sign: if sector.sign() > 0.0 { 1 } else { -1 },
    }
}

fn draw(
    (path, format): (&Path, &str),
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
    let bytes = match format {
        "svg" => svg(&exploded_figure(&cell)).into_bytes(),
        _ => exploded(&[cell]).map_err(Failure::run)?,
    };
    write_file(path, |file| file.write_all(&bytes)).map_err(Failure::input)
}

fn export(
    path: &Path,
    space: &Space,
    sites: &[Point3<f64>],
    cells: &[(usize, [FragmentPart; 6])],
) -> Result<(), Failure> {
    let mut file = VtuWriter::new(path);
    for (site, parts) in cells {
        let number = u32::try_from(*site).unwrap_or(u32::MAX);
        let cell = FragmentedSite {
            domain: space.domain(),
            site: *site,
            position: sites[*site],
            frame: space.frames().of(number).copied().unwrap_or_default(),
        };
        for (sector, part) in Sector::ALL.into_iter().zip(parts) {
            if part.shell.facet_count() > 0 || part.volume > 0.0 {
                let fragment = cell.geometry(sector, part);
                file.push_fragment(&fragment).map_err(Failure::input)?;
            }
            for tets in &part.tets {
                file.push_tets(tets).map_err(Failure::input)?;
            }
        }
    }
    file.finish().map_err(Failure::input)?;
    Ok(())
}
