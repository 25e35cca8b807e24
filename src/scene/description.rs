//! The scene: one JSON object with all that a run depends on, its defaults and its validation.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::domain as space;
use crate::domain::planar::PlaneDomain;
use crate::mesh::formats::read::tetgen_pair;
use crate::mesh::formats::unpack::extension_of;
use crate::relax::relaxation_space::Norm;
use crate::scene::density::SceneDensity;
use crate::scene::domain::SceneDomain;
use crate::scene::error::Error;
use crate::scene::frames::FrameChoice;
use crate::scene::method::SceneMethod;
use crate::scene::site_file::SiteFormat;
use crate::scene::sites::Sites;

/// The largest order p: beyond it d∞^p underflows for cells of a thousandth of the domain.
const LARGEST_ORDER: u32 = 64;

/// Moves of a descent from random sites to those of a graded mesh.
const GRADED_MOVES: u64 = 100;

/// 8^20 sites are more than any machine holds.
const MOST_LEVELS: u32 = 20;

/// The scene that runs when none is given: the paper's main job, kept beside the others.
const EMBEDDED: &str = include_str!("../../scenes/cube.json");

/// A relaxation: which sites, in which domain, by which method, leaving what.
///
/// Only `sites` has no default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// The place of this schema, for editors; it changes nothing.
    #[serde(rename = "$schema", default, skip_serializing)]
    pub schema: Option<String>,
    /// 3, or 2 for sites in the plane.
    #[serde(default = "three")]
    pub dimension: usize,
    /// Where the sites live; the unit cube (in the plane: the unit square) by default.
    #[serde(default)]
    pub domain: SceneDomain,
    /// How much every place of the domain weighs; the same everywhere by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<SceneDensity>,
    /// The sites to start from.
    pub sites: Sites,
    /// The format of the sites' file, where its name does not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sites_format: Option<SiteFormat>,
    /// Whether sites outside the domain are left out instead of refused.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub drop_outside: bool,
    /// The distance in which a cell's points are nearest to its site: `"l2"` or `"linf"`.
    #[serde(default = "l2", skip_serializing_if = "is_l2")]
    pub cells: Norm,
    /// The distance a site minimizes over its cell.
    #[serde(default)]
    pub norm: Norm,
    /// The order p ≥ 1 of the Chebyshev energy ∫ d∞^p; the paper's case is 1.
    #[serde(default = "one")]
    pub order: u32,
    /// How the sites move.
    #[serde(default)]
    pub method: SceneMethod,
    /// How often the number of sites is divided by eight (in the plane by four) before the first descent;
    /// each level then splits every site into as many. Left out, it is what the method thinks best: 0, except for
    /// exchanges.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coarse_to_fine: Option<u32>,
    /// The axes along which distances are measured, if not those of space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<FrameChoice>,
    /// Which files a run leaves besides its log and its sites.
    #[serde(default)]
    pub output: Output,
}

/// Which files a run leaves besides `log.jsonl`, `run.json` and `sites.csv`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "each says whether a file is written"
)]
pub struct Output {
    /// The cells: `cells.vtu` in space, and a picture of them.
    pub cells: bool,
    /// The energy and movement curves: `convergence.svg`.
    pub plot: bool,
    /// The energies in percent that the colors of the cells' picture span, so that several pictures have the
    /// same; left out, all but the outermost 2 % of the cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Of the cells, `cells.vtu`.
    #[serde(skip_serializing_if = "is_true")]
    pub cells_file: bool,
    /// All pictures: of the cells and of the curves.
    #[serde(skip_serializing_if = "is_true")]
    pub pictures: bool,
    /// Whether `cells.vtu` is compressed by zlib: smaller and slower, the numbers are the same.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub compress: bool,
    /// A checkpoint every so many moves. Left out, `relax` keeps one at least every second, less often where
    /// they take long to write, and `chebloyd-mpi` every 10 moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checkpoint: Option<u64>,
}

impl Default for Output {
    fn default() -> Self {
        Self {
            cells: true,
            plot: true,
            range: None,
            cells_file: true,
            pictures: true,
            compress: false,
            checkpoint: None,
        }
    }
}

impl Output {
    fn validate(&self) -> Result<(), Error> {
        match self.range {
            Some([low, high]) if !(low.is_finite() && high.is_finite() && low < high) => {
                let message = format!("{low:?} is not below {high:?}");
                Err(Error::value("output.range", message))
            }
            _ if self.checkpoint == Some(0) => {
                let message = "0 moves are no interval; 1 keeps a checkpoint after every move";
                Err(Error::value("output.checkpoint", message.to_owned()))
            }
            _ => Ok(()),
        }
    }
}

impl Scene {
    /// The embedded scene: 1000 uniform random sites in the unit cube, 50 iterations of L2∣∞
    /// Lloyd. Its defaults are filled in.
    ///
    /// # Panics
    /// Never: a test reads the embedded text.
    #[must_use]
    pub fn embedded() -> Self {
        let mut scene: Self = serde_json::from_str(EMBEDDED).expect("the embedded scene is valid");
        scene.fill_defaults();
        scene
    }

    /// Makes random sites those of a lattice, to mesh with. Under a density they stay random, and the descent
    /// takes more moves unless `iterations` are given.
    pub(crate) fn set_mesh_start(&mut self, iterations: Option<u64>) {
        if self.density.is_none() {
            self.sites.set_lattice();
        } else if let (SceneMethod::QuasiNewton(descent), None) = (&mut self.method, iterations) {
            descent.iterations = GRADED_MOVES;
        }
    }

    /// The domain in space with its density, of a validated scene of dimension 3, and what was
    /// repaired in its mesh, one sentence each.
    ///
    /// # Errors
    /// As [`SceneDomain::solid`], and when the density does not fit the domain.
    pub fn solid(&self) -> Result<(Box<dyn space::Domain>, Vec<String>), Error> {
        match &self.density {
            Some(density) => density.weigh(&self.domain, self.order),
            None => self.domain.solid(),
        }
    }

    /// The domain in the plane with its density, of a validated scene of dimension 2.
    ///
    /// # Errors
    /// As [`SceneDomain::plane`], and when the density does not fit the domain.
    pub fn plane(&self) -> Result<PlaneDomain, Error> {
        let domain = self.domain.plane()?;
        match &self.density {
            Some(density) => {
                let weighted = domain.weighted(&density.in_plane()?);
                weighted.map_err(|error| Error::value("density", error.to_string()))
            }
            None => Ok(domain),
        }
    }

    /// The JSON Schema of scenes, for editors.
    #[must_use]
    pub fn schema() -> serde_json::Value {
        schemars::schema_for!(Self).to_value()
    }

    /// Validates every number of a scene whose defaults are filled in.
    ///
    /// # Errors
    /// [`Error::Value`] with the key of the first one that makes no sense.
    pub fn validate(&self) -> Result<(), Error> {
        if !(2..=3).contains(&self.dimension) {
            let message = format!("{} is neither 2 nor 3", self.dimension);
            return Err(Error::value("dimension", message));
        }
        if !(1..=LARGEST_ORDER).contains(&self.order) {
            let message = format!("{} is not between 1 and {LARGEST_ORDER}", self.order);
            return Err(Error::value("order", message));
        }
        if let Some(density) = self.density.as_ref().filter(|_| self.dimension == 2) {
            density.in_plane()?;
        }
        self.domain.validate(self.dimension)?;
        self.sites.validate(self.dimension)?;
        if let Some(frames) = &self.frames {
            frames.validate(self.dimension)?;
        }
        self.validate_combinations()?;
        self.output.validate()?;
        self.method.validate()
    }

    /// Refuses keys that exclude each other.
    fn validate_combinations(&self) -> Result<(), Error> {
        let levels = self.coarse_to_fine.unwrap_or(0);
        let is_per_site = self.frames.as_ref().is_some_and(FrameChoice::is_per_site);
        if is_per_site && levels > 0 {
            let message = "every site has its own frame, so their number must not change; give 0";
            return Err(Error::value("coarse_to_fine", message));
        }
        let is_lloyd = matches!(self.method, SceneMethod::Lloyd(_));
        if self.norm == Norm::L2 && !is_lloyd {
            let message = "only \"lloyd\" can minimize another norm than \"linf\"";
            return Err(Error::value("norm", message));
        }
        self.validate_cells()?;
        if levels > MOST_LEVELS {
            let message = format!("more than {MOST_LEVELS} levels make no sense");
            return Err(Error::value("coarse_to_fine", message));
        }
        Ok(())
    }

    /// Refuses what L∞ cells do not go with.
    fn validate_cells(&self) -> Result<(), Error> {
        if self.cells == Norm::L2 {
            return Ok(());
        }
        let is_per_site = self.frames.as_ref().is_some_and(FrameChoice::is_per_site);
        let is_turned = self.frames.is_some() && !self.domain.is_plain();
        let has_both = self.frames.is_some() && self.density.is_some();
        let refused = [
            (is_per_site, "frames of single sites"),
            (is_turned, "frames in a domain that is periodic or a mesh"),
            (has_both, "frames and a density"),
            (self.norm == Norm::L2, "\"norm\": \"l2\""),
        ];
        match refused.into_iter().find(|(is_given, _)| *is_given) {
            Some((_, what)) => {
                let message = format!("\"linf\" does not go with {what}; choose \"l2\"");
                Err(Error::value("cells", message))
            }
            None => Ok(()),
        }
    }

    /// The files that the scene names, but for the sites'; TetGen's as the pair that they are.
    pub(crate) fn domain_files(&self) -> Vec<PathBuf> {
        let mesh = self.domain.file().map(Path::to_owned);
        let is_pair = |mesh: &&PathBuf| ["node", "ele"].contains(&extension_of(mesh).as_str());
        let pair = mesh.as_ref().filter(is_pair).map(|mesh| tetgen_pair(mesh));
        let pair = pair.into_iter().flatten();
        let pair = pair.filter(|file| Some(file) != mesh.as_ref());
        let frames = self.frames.as_ref().and_then(FrameChoice::file);
        let files = mesh.iter().cloned().chain(pair);
        files.chain(frames.map(Path::to_owned)).collect()
    }

    /// All files that the scene names.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let mut files = self.domain_files();
        if let Sites::File(file) = &self.sites {
            files.push(file.clone());
        }
        let field = self.density.as_ref().and_then(SceneDensity::file);
        files.extend(field.map(Path::to_owned));
        files
    }

    /// Fills in the defaults that depend on the dimension.
    pub(crate) fn fill_defaults(&mut self) {
        self.domain.fill_defaults(self.dimension);
    }

    /// Makes every relative path of the scene start at `folder`.
    pub(crate) fn anchor(&mut self, folder: &Path) {
        self.domain.anchor(folder);
        self.sites.anchor(folder);
        if let Some(density) = &mut self.density {
            density.anchor(folder);
        }
        if let Some(frames) = &mut self.frames {
            frames.anchor(folder);
        }
    }
}

fn is_true(value: &bool) -> bool {
    *value
}

fn l2() -> Norm {
    Norm::L2
}

fn is_l2(norm: &Norm) -> bool {
    *norm == Norm::L2
}

fn three() -> usize {
    3
}

fn one() -> u32 {
    1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_embedded_scene_is_the_main_job() {
        let scene = Scene::embedded();
        let text = serde_json::to_value(&scene).expect("a scene is JSON");
        assert_eq!(
            text,
            serde_json::json!({
                "dimension": 3,
                "domain": { "box": {
                    "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 1.0],
                    "periodic": [false, false, false],
                }},
                "sites": { "random": { "count": 1000, "seed": 1 } },
                "norm": "linf",
                "order": 1,
                "method": { "lloyd": { "iterations": 50, "tolerance": 0.0, "minimizer": "newton" } },
                "output": { "cells": true, "plot": true },
            })
        );
    }

    #[test]
    fn an_interval_of_checkpoints_has_moves() {
        let output = |checkpoint| Output {
            checkpoint,
            ..Output::default()
        };
        let refused = output(Some(0)).validate().expect_err("no interval");
        assert!(
            refused.to_string().contains("output.checkpoint"),
            "{refused}"
        );
        assert!(output(Some(1)).validate().is_ok() && output(None).validate().is_ok());
    }

    #[test]
    fn a_resolved_scene_reads_back_as_itself() {
        let scene = Scene::embedded();
        let text = serde_json::to_string(&scene).expect("a scene is JSON");
        let mut again: Scene = serde_json::from_str(&text).expect("what was written reads");
        again.fill_defaults();
        assert_eq!(scene, again);
    }
}
