//! Command-line options that several commands share: threads, the scene, and its method's keys.

use std::fs::Metadata;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use nalgebra::Point;
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::cli::failure::{Failure, print_note};
use crate::mesh::formats::unpack::STANDARD_INPUT;
use crate::relax::space::Space;
use crate::scene::density::SceneDensity;
use crate::scene::description::Scene;
use crate::scene::overrides::Overrides;
use crate::scene::site_file::{SiteFormat, read_as};
use crate::scene::{read, run};

const NORMS: [(&str, &str); 2] = [
    ("linf", "Chebyshev: cells become near-cubic"),
    ("l2", "Euclidean: the classical control"),
];

const CELLS: [(&str, &str); 2] = [
    ("l2", "Euclidean: convex cells"),
    ("linf", "Chebyshev: star-shaped cells, fastest in a box"),
];

const SITE_FORMATS: [(&str, &str); 4] = [
    ("csv", "A table: commas, semicolons or tabs between columns"),
    ("xyz", "Text by white space, or chemistry's XYZ"),
    ("json", "An array of arrays of numbers"),
    ("npy", "A NumPy array"),
];

/// Options of every command.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Common {
    /// How many threads compute; results do not depend on it [default: all cores]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) threads: Option<u32>,
    /// Print errors only
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Say on stderr what is done and how many seconds it took
    #[arg(long, short, global = true, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
}

/// Which tessellation: a scene, or other sites in it.
#[derive(Debug, Default, Args)]
pub(crate) struct SceneOptions {
    /// The scene; or a run.json or a run's directory (its scene, with the sites that it left), or a mesh
    /// (random sites in it) [default: 1000 random sites in the unit cube]
    #[arg(value_name = "SCENE.json")]
    scene: Option<PathBuf>,
    /// Take the sites from a .csv, .tsv, .npy, .xyz, .txt or .json file, plain or .gz; - is standard
    /// input
    #[arg(long, value_name = "FILE", conflicts_with_all = ["count", "seed", "edge"])]
    sites: Option<PathBuf>,
    /// The format of the sites, where neither the name nor the content says it
    #[arg(long, value_name = "FORMAT", value_parser = named(&SITE_FORMATS))]
    sites_format: Option<String>,
    /// Merge vertices of an open mesh up to L apart, in the file's unit [default: 1e-12 of its box]
    #[arg(long, value_name = "L", value_parser = length)]
    weld: Option<f64>,
    /// Leave out sites outside the domain instead of refusing them
    #[arg(long)]
    drop_outside: bool,
    /// Number of random sites
    #[arg(long, value_name = "N")]
    count: Option<usize>,
    /// As many random sites as cubes of edge L fill the domain, in its own unit; in a box the product of
    /// the sides' rounded counts. A formula in x, y, z or @field.json is an edge that varies: the scene's
    /// density becomes {"size": L}
    #[arg(long, value_name = "L", value_parser = edge_length, conflicts_with = "count", allow_hyphen_values = true)]
    edge: Option<String>,
    /// Seed of random sites, or of a grid's jitter
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// The distance in which a cell's points are nearest to its site [default: l2]
    #[arg(long, value_name = "NORM", value_parser = named(&CELLS))]
    cells: Option<String>,
    /// The distance to integrate and to minimize
    #[arg(long, value_name = "NORM", value_parser = named(&NORMS))]
    norm: Option<String>,
    /// The order p of the Chebyshev energy, the integral of the distance to the power p [default: 1]
    #[arg(long, value_name = "P")]
    order: Option<u32>,
}

/// Options that replace keys of the scene's method; each is named like its key.
#[derive(Debug, Args, Serialize)]
#[command(next_help_heading = "Options of methods")]
pub(crate) struct MethodOptions {
    /// lloyd: go three times as far where that ends lower
    #[arg(long)]
    accelerate: bool,
    /// quasi-newton, anneal: how many of Lloyd's moves come first [default: 0]
    #[arg(long, value_name = "K")]
    warm_up: Option<u64>,
    /// quasi-newton, anneal: steps that the curvature model remembers [default: 10, of L∞ cells in space 6]
    #[arg(long, value_name = "M")]
    memory: Option<usize>,
    /// quasi-newton, anneal: end a descent when no component of the projected gradient is larger than
    /// G s^(2+p), s the side of the mean cell [default: 1e-9]
    #[arg(long, value_name = "G", value_parser = finite)]
    gradient_tolerance: Option<f64>,
    /// anneal: how many rounds [default: 60; for --goal cubes, squares 200]
    #[arg(long, value_name = "R")]
    rounds: Option<u64>,
    /// anneal: the greatest noise, in sides of the mean cell [default: 0.5; for --goal cubes, squares 0.4]
    #[arg(long, value_name = "A", value_parser = finite)]
    noise: Option<f64>,
}

/// Names that an option takes, each with its help.
pub(crate) fn named(names: &[(&'static str, &'static str)]) -> PossibleValuesParser {
    let values = names
        .iter()
        .map(|&(name, help)| PossibleValue::new(name).help(help));
    values.collect::<Vec<_>>().into()
}

/// A number that JSON can hold.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| "a finite number is needed".to_owned())
}

/// More cells than an edge may ask for.
const MOST_CELLS: f64 = 4e9;

/// A positive length, or what may be a formula.
pub(crate) fn edge_length(text: &str) -> Result<String, String> {
    match text.parse::<f64>() {
        Ok(edge) if !(edge > 0.0 && edge.is_finite()) => {
            Err("a positive length is needed, or a formula in x, y, z".to_owned())
        }
        _ => Ok(text.to_owned()),
    }
}

/// A finite number that is not negative.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    let length = finite(text)?;
    match length >= 0.0 {
        true => Ok(length),
        false => Err("a length of 0 or more is needed".to_owned()),
    }
}

/// Options as keys of a scene, those left out that were not given.
pub(crate) fn given(options: impl Serialize) -> Map<String, Value> {
    let mut keys = given_values(options);
    keys.retain(|_, value| *value != Value::Bool(false));
    keys
}

/// As [`given`], where false is given too.
pub(crate) fn given_values(options: impl Serialize) -> Map<String, Value> {
    let Ok(Value::Object(mut keys)) = serde_json::to_value(options) else {
        return Map::new();
    };
    keys.retain(|_, value| !value.is_null());
    keys
}

impl SceneOptions {
    /// The scene, changed by these options and by `others`, and validated.
    pub(crate) fn scene(&self, mut others: Overrides) -> Result<Scene, Failure> {
        let (mut scene, notes) = match &self.scene {
            Some(path) => read::noted(path).map_err(Failure::input)?,
            None => (Scene::embedded(), Vec::new()),
        };
        print_notes(&notes);
        self.set_sites(&scene, &mut others)?;
        let edge = self.edge.as_deref().map(str::parse::<f64>);
        let count = match (&edge, &self.edge) {
            (Some(Err(_)), Some(size)) => Self::graded_count(size, &scene, &mut others)?,
            _ => self.count,
        };
        let edge = edge.and_then(Result::ok);
        others.sites.extend(given(
            json!({ "count": count, "seed": self.seed, "edge": edge }),
        ));
        // The count and the edge replace each other.
        if edge.is_some() {
            others.sites.insert("count".to_owned(), Value::Null);
        } else if count.is_some() && scene.sites.has_edge() {
            others.sites.insert("edge".to_owned(), Value::Null);
        }
        others.scene.extend(given(json!({
            "drop_outside": self.drop_outside, "cells": self.cells, "norm": self.norm,
            "order": self.order, "sites_format": self.sites_format,
        })));
        if self.weld.is_some() && scene.domain.file().is_none() {
            let message = "--weld is for meshes; this scene's domain is none";
            return Err(Failure::input(message));
        }
        others.domain.extend(given(json!({ "weld": self.weld })));
        change(&mut scene, &others)?;
        Ok(scene)
    }

    /// The options of a mesh file or scene, cells of edge `edge` in it.
    pub(crate) fn of_file(file: &Path, edge: Option<&str>, weld: Option<f64>) -> Self {
        Self {
            scene: Some(file.to_owned()),
            edge: edge.map(str::to_owned),
            weld,
            ..Self::default()
        }
    }

    /// Makes the edge, which varies, the scene's density; returns how many cells there are then: ∫ h⁻³.
    fn graded_count(
        size: &str,
        scene: &Scene,
        others: &mut Overrides,
    ) -> Result<Option<usize>, Failure> {
        if scene.dimension != 3 {
            let message = format!("--edge {size} is for sites in space; in the plane say --count");
            return Err(Failure::input(message));
        }
        let density = SceneDensity::Size {
            size: size.to_owned(),
        };
        let cells = density.mass(&scene.domain).map_err(Failure::input)?;
        let is_count = (0.5..MOST_CELLS).contains(&cells);
        if !is_count {
            let message = format!("--edge {size}: cells of such edges are {cells:.3e} in number");
            return Err(Failure::input(message));
        }
        others.scene.insert("density".to_owned(), json!(density));
        Ok(Some(cells.round() as usize))
    }

    /// Sites from a file; or from standard input or a pipe, which a list then holds for whoever goes on.
    fn set_sites(&self, scene: &Scene, others: &mut Overrides) -> Result<(), Failure> {
        let Some(file) = &self.sites else {
            return Ok(());
        };
        // A pipe can be read once, and by nobody who resumes the run.
        if !is_stream(file) {
            return others.set_site_file(file).map_err(Failure::input);
        }
        let format = self.sites_format.as_deref();
        let format = format.and_then(|name| serde_json::from_value(json!(name)).ok());
        let (rows, notes) = match scene.dimension {
            2 => rows::<2>(file, format)?,
            _ => rows::<3>(file, format)?,
        };
        print_notes(&notes);
        others
            .scene
            .insert("sites".to_owned(), json!({ "list": rows }));
        Ok(())
    }

    /// The files that a command reads for `scene`, which these options name.
    pub(crate) fn inputs(&self, scene: &Scene) -> Vec<PathBuf> {
        let mut inputs = scene.files();
        inputs.extend(self.scene.clone());
        inputs
    }
}

/// Whether a file can be read but once.
fn is_stream(file: &Path) -> bool {
    let is_pipe = |file: Metadata| !file.is_file() && !file.is_dir();
    file.as_os_str() == STANDARD_INPUT || file.metadata().is_ok_and(is_pipe)
}

/// The sites of a file as a scene lists them, and what there is to say about it.
fn rows<const D: usize>(
    file: &Path,
    format: Option<SiteFormat>,
) -> Result<(Vec<Vec<f64>>, Vec<String>), Failure> {
    let file = read_as::<D>(file, format).map_err(Failure::input)?;
    let row = |site: &Point<f64, D>| site.iter().copied().collect();
    Ok((file.sites.iter().map(row).collect(), file.notes))
}

/// Prints notes on stderr.
pub(crate) fn print_notes(notes: &[String]) {
    for note in notes {
        print_note(note);
    }
}

/// Applies overrides and validates what comes of it.
pub(crate) fn change(scene: &mut Scene, overrides: &Overrides) -> Result<(), Failure> {
    overrides.apply(scene).map_err(Failure::input)?;
    scene.validate().map_err(Failure::input)
}

/// The space of a scene. What was repaired in its mesh is printed on stderr.
pub(crate) fn space(scene: &Scene) -> Result<Space, Failure> {
    let (space, notes) = run::space(scene).map_err(Failure::input)?;
    print_notes(&notes);
    Ok(space)
}
