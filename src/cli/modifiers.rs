//! `--modifiers N` of `stand` and `spin`: a field as closed bodies for slicers.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use nalgebra::Point3;
use serde::Serialize;

use crate::balance::modifiers::ModifierBody;
use crate::cli::failure::{Failure, write_file};
use crate::export::stl::write_stl;
use crate::export::three_mf::{FilledBody, write_3mf};
use crate::geometry::moments::Moments;
use crate::mesh::surface::SurfaceMesh;

/// The part and all bodies in one file.
const ARCHIVE: &str = "modifiers.3mf";

/// The bodies that were written, and what they weigh together.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ModifiersReport {
    /// The part with all bodies.
    archive: &'static str,
    bodies: Vec<BodyReport>,
    mass: f64,
    center_of_mass: [f64; 3],
}

#[derive(Clone, Debug, Serialize)]
struct BodyReport {
    file: String,
    density: f64,
    /// The share of the filling that stands for this density.
    fill_percent: f64,
    volume: f64,
    triangles: usize,
}

/// The number of bodies, from a text.
pub(crate) fn modifier_count(text: &str) -> Result<usize, String> {
    let count = text.parse::<usize>().ok();
    let count = count.filter(|count| (3..=200).contains(count));
    count.ok_or_else(|| "N is a whole number from 3 to 200".to_owned())
}

fn name(body: usize) -> String {
    format!("modifier-{:03}.stl", body + 1)
}

/// The files that up to `count` bodies are written to.
pub(crate) fn modifier_files(directory: &Path, count: usize) -> Vec<PathBuf> {
    let names = (0..count).map(name).chain([ARCHIVE.to_owned()]);
    names.map(|name| directory.join(name)).collect()
}

/// The moments of bodies together, measured from `origin`.
pub(crate) fn weigh_bodies(bodies: &[ModifierBody], origin: &Point3<f64>) -> Moments {
    let weighed = bodies.iter().map(|body| body.weigh(origin));
    weighed.fold(Moments::default(), |sum, body| sum + body)
}

/// Writes bodies into a directory, made if it is not there; the density `solid_density` is a filling of 100 %.
pub(crate) fn write_modifiers(
    directory: &Path,
    part: &SurfaceMesh,
    bodies: &[ModifierBody],
    solid_density: f64,
) -> Result<ModifiersReport, Failure> {
    fs::create_dir_all(directory)
        .map_err(|error| Failure::run(format!("cannot make {}: {error}", directory.display())))?;
    let percent = |body: &ModifierBody| 100.0 * body.density / solid_density;
    let mut reports = Vec::new();
    for (number, body) in bodies.iter().enumerate() {
        let file = name(number);
        write_file(&directory.join(&file), |writer| {
            write_stl(writer, &body.surface)
        })
        .map_err(Failure::run)?;
        reports.push(BodyReport {
            file,
            density: body.density,
            fill_percent: percent(body),
            volume: body.surface.volume(),
            triangles: body.surface.triangles.len(),
        });
    }
    let filled: Vec<FilledBody<'_>> = bodies
        .iter()
        .zip(&reports)
        .map(|(body, report)| FilledBody {
            name: report.file.trim_end_matches(".stl").to_owned(),
            surface: &body.surface,
            percent: report.fill_percent,
        })
        .collect();
    write_file(&directory.join(ARCHIVE), |writer| {
        write_3mf(writer, part, &filled)?;
        writer.flush()
    })
    .map_err(Failure::run)?;
    let origin = part.bounds().center();
    let moments = weigh_bodies(bodies, &origin);
    Ok(ModifiersReport {
        archive: ARCHIVE,
        bodies: reports,
        mass: moments.mass,
        center_of_mass: (origin + moments.center()).into(),
    })
}

impl ModifiersReport {
    /// A line for each body.
    pub(crate) fn table(&self) -> String {
        let [x, y, z] = self.center_of_mass;
        let lines = self.bodies.iter().map(|body| {
            format!(
                "{}: density {:.6}, filling {:.2} %\n",
                body.file, body.density, body.fill_percent
            )
        });
        let bodies: String = lines.collect();
        bodies
            + &format!(
                "{}: their center of mass is ({x}, {y}, {z})\n",
                self.archive
            )
    }
}
