//! Tables of cells and of their faces as CSV: `measure --cells-table FILE --faces-table FILE`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::{Point3, Vector3};

use crate::cli::cell_files::shared_linf_cells;
use crate::cli::failure::{Failure, write_file};
use crate::cli::mesh_cells::patches_of;
use crate::cli::output::OutputRule;
use crate::complex::assemble::paired;
use crate::complex::identify::RESOLUTION;
use crate::mesh::poly_mesh::{CellFaces, PolyMesh};
use crate::relax::metrics::CellMetrics;
use crate::relax::space::Space;
use crate::scene::description::Scene;
use crate::voronoi::diagram::Diagram;

/// The angle of a feature between patches (degrees), as in `mesh`.
const FEATURE: f64 = 40.0;

const NO_FLAT_TABLES: &str = "tables are of cells in space: set \"dimension\": 3, or leave out --cells-table and \
     --faces-table";

const NO_LINF_TABLES: &str = "tables of L∞ cells need faces that neighbors share, which there are in a box or a \
     convex polyhedron, sites apart by more than its last digits; leave out --cells-table and --faces-table, \
     or say --cells l2";

/// Options for tables.
#[derive(Debug, Args)]
pub(crate) struct TableOptions {
    /// Write a CSV table of the cells: site, position, volume, centroid, area, faces, energy, cubeness
    #[arg(long, value_name = "FILE")]
    cells_table: Option<PathBuf>,
    /// Write a CSV table of all cells' faces: site, neighbor or patch, area, outward normal, centroid
    #[arg(long, value_name = "FILE")]
    faces_table: Option<PathBuf>,
    /// Replace tables that are there
    #[arg(long)]
    force: bool,
}

/// Cells, and how their faces lie.
struct TableCells<'a> {
    mesh: PolyMesh,
    faces: CellFaces,
    /// Per face its area times its normal (L²), outward of the owner, and its centroid.
    flat: Vec<(Vector3<f64>, Point3<f64>)>,
    sites: &'a [Point3<f64>],
    metrics: &'a [CellMetrics<3>],
}

impl TableOptions {
    /// Whether a table is wanted.
    pub(crate) fn is_wanted(&self) -> bool {
        self.cells_table.is_some() || self.faces_table.is_some()
    }

    /// Refuses to replace files, and tables of the plane.
    pub(crate) fn check(&self, scene: &Scene, inputs: &[PathBuf]) -> Result<(), Failure> {
        if !self.is_wanted() {
            return Ok(());
        }
        if scene.dimension != 3 {
            return Err(Failure::input(NO_FLAT_TABLES));
        }
        let both = [
            ("--cells-table", &self.cells_table),
            ("--faces-table", &self.faces_table),
        ];
        for (option, path) in both {
            let force = self.force;
            let rule = OutputRule {
                inputs,
                force,
                option,
            };
            rule.check(path.as_slice())?;
        }
        Ok(())
    }

    /// Writes the tables of the cells of `sites`.
    pub(crate) fn write(
        &self,
        (space, scene): (&Space, &Scene),
        sites: &[Point3<f64>],
        metrics: &[CellMetrics<3>],
    ) -> Result<(), Failure> {
        let mesh = match space.linf(sites) {
            None => l2_mesh(space, scene, sites)?,
            Some(cells) => {
                let mesh = shared_linf_cells(&cells);
                mesh.ok_or_else(|| Failure::input(NO_LINF_TABLES))?
            }
        };
        let table = TableCells {
            faces: mesh.cell_faces(),
            flat: (0..mesh.face_count())
                .map(|face| flat_face(&mesh, face))
                .collect(),
            mesh,
            sites,
            metrics,
        };
        write_table(self.cells_table.as_deref(), |file| table.write_cells(file))?;
        write_table(self.faces_table.as_deref(), |file| table.write_faces(file))
    }
}

fn l2_mesh(space: &Space, scene: &Scene, sites: &[Point3<f64>]) -> Result<PolyMesh, Failure> {
    let diagram = Diagram::new(space.domain(), sites).map_err(Failure::input)?;
    let paired = paired(&diagram, RESOLUTION).map_err(Failure::run)?;
    Ok(paired.builder().build(&patches_of(space, scene, FEATURE)))
}

/// A planar face's area times its normal, and its centroid; it need not be convex.
fn flat_face(mesh: &PolyMesh, face: usize) -> (Vector3<f64>, Point3<f64>) {
    let places: Vec<_> = mesh.face_places(face).collect();
    let arms: Vec<_> = places.iter().map(|place| place - places[0]).collect();
    let twice = |pair: &[Vector3<f64>]| pair[0].cross(&pair[1]);
    let area = arms.windows(2).map(twice).sum::<Vector3<f64>>() / 2.0;
    let moment = arms
        .windows(2)
        .map(|pair| twice(pair).dot(&area) * (pair[0] + pair[1]))
        .sum::<Vector3<f64>>();
    let shift = moment / (6.0 * area.norm_squared());
    (area, places[0] + shift)
}

fn write_table(
    path: Option<&Path>,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    match path {
        None => Ok(()),
        Some(path) => write_file(path, |file| content(file)).map_err(Failure::run),
    }
}

impl TableCells<'_> {
    fn write_cells(&self, file: &mut dyn Write) -> io::Result<()> {
        writeln!(
            file,
            "site,x,y,z,volume,centroid_x,centroid_y,centroid_z,area,faces,energy,cubeness"
        )?;
        for (cell, (site, metrics)) in self.sites.iter().zip(self.metrics).enumerate() {
            let center = metrics.centroid;
            let faces = self.faces.of(cell);
            let areas = faces.clone().map(|(face, _)| self.flat[face].0.norm());
            writeln!(
                file,
                "{cell},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{},{:?},{:?}",
                site.x,
                site.y,
                site.z,
                metrics.volume,
                center.x,
                center.y,
                center.z,
                areas.sum::<f64>(),
                faces.len(),
                metrics.energy,
                metrics.cubeness
            )?;
        }
        Ok(())
    }

    /// Every face as each of its cells sees it.
    fn write_faces(&self, file: &mut dyn Write) -> io::Result<()> {
        writeln!(
            file,
            "site,neighbor,patch,area,normal_x,normal_y,normal_z,centroid_x,centroid_y,centroid_z"
        )?;
        for cell in 0..self.mesh.cell_count {
            for (face, is_owner) in self.faces.of(cell) {
                let (area, center) = self.flat[face];
                let outward = if is_owner { area } else { -area };
                let normal: Vector3<f64> = outward.try_normalize(0.0).unwrap_or_default();
                let (neighbor, patch) = self.behind(face, is_owner);
                writeln!(
                    file,
                    "{cell},{neighbor},{patch},{:?},{:?},{:?},{:?},{:?},{:?},{:?}",
                    area.norm(),
                    normal.x,
                    normal.y,
                    normal.z,
                    center.x,
                    center.y,
                    center.z
                )?;
            }
        }
        Ok(())
    }

    /// The neighbor behind a face, beyond a period too, and the name of its patch; each may be empty.
    fn behind(&self, face: usize, is_owner: bool) -> (String, String) {
        if let Some(neighbor) = self.mesh.neighbor_of(face) {
            let other = if is_owner {
                neighbor as u32
            } else {
                self.mesh.owner[face]
            };
            return (other.to_string(), String::new());
        }
        let mut patches = self.mesh.patches.iter();
        let found = patches.find(|patch| (patch.start..patch.start + patch.count).contains(&face));
        let Some(patch) = found else {
            return Default::default();
        };
        let partner = patch.partner.map(|(partner, _)| {
            let other = self.mesh.patches[partner].start + face - patch.start;
            self.mesh.owner[other].to_string()
        });
        (partner.unwrap_or_default(), patch.name.clone())
    }
}
