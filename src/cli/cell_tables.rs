//! Tables of cells and of their faces as CSV: `measure --cells-table FILE --faces-table FILE`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::{Point3, Vector3};

use crate::cli::failure::{Failure, write_file};
use crate::cli::mesh_cells::patches_of;
use crate::cli::output::OutputRule;
use crate::complex::assemble::paired;
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::identify::RESOLUTION;
use crate::mesh::poly_mesh::PolyMesh;
use crate::relax::metrics::CellMetrics;
use crate::relax::space::Space;
use crate::scene::description::Scene;
use crate::voronoi::diagram::Diagram;

/// The angle of a feature between patches (degrees), as in `mesh`.
const FEATURE: f64 = 40.0;

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

/// A mesh and its measures.
struct MeasuredCells {
    mesh: PolyMesh,
    geometry: MeshGeometry,
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
            let message = "tables are of cells in space: set \"dimension\": 3, or leave out --cells-table and --faces-table";
            return Err(Failure::input(message));
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
        cells: &[CellMetrics<3>],
    ) -> Result<(), Failure> {
        let patches = patches_of(space, scene, FEATURE);
        let diagram = Diagram::new(space.domain(), sites).map_err(Failure::input)?;
        let paired = paired(&diagram, RESOLUTION).map_err(Failure::run)?;
        let mesh = paired.builder().build(&patches);
        let geometry = MeshGeometry::of(&mesh, &mesh.cell_faces());
        let measured = MeasuredCells { mesh, geometry };
        write_table(self.cells_table.as_deref(), |file| {
            measured.write_cells(file, sites, cells)
        })?;
        write_table(self.faces_table.as_deref(), |file| {
            measured.write_faces(file)
        })
    }
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

impl MeasuredCells {
    fn write_cells(
        &self,
        file: &mut dyn Write,
        sites: &[Point3<f64>],
        cells: &[CellMetrics<3>],
    ) -> io::Result<()> {
        writeln!(
            file,
            "site,x,y,z,volume,centroid_x,centroid_y,centroid_z,area,faces,energy,cubeness"
        )?;
        let faces = self.mesh.cell_faces();
        for (cell, (site, metrics)) in sites.iter().zip(cells).enumerate() {
            let center = self.geometry.cell_centers[cell];
            let areas = faces
                .of(cell)
                .map(|(face, _)| self.geometry.face_areas[face].norm());
            writeln!(
                file,
                "{cell},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{},{:?},{:?}",
                site.x,
                site.y,
                site.z,
                self.geometry.cell_volumes[cell],
                center.x,
                center.y,
                center.z,
                areas.sum::<f64>(),
                faces.of(cell).len(),
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
        let faces = self.mesh.cell_faces();
        for cell in 0..self.mesh.cell_count {
            for (face, is_owner) in faces.of(cell) {
                let area = self.geometry.face_areas[face];
                let outward = if is_owner { area } else { -area };
                let normal: Vector3<f64> = outward.try_normalize(0.0).unwrap_or_default();
                let center = self.geometry.face_centers[face];
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
