//! A whole run of a scene as one call: from the sites that it names to where its method leaves them.
//!
//! [`run`] does all of it; [`RunSpace`] and [`relax`] are its parts for a caller that knows the
//! dimension, keeps checkpoints ([`Checkpoint`]) or goes on from one. Nothing is printed or written:
//! an observer is shown every record and says whether to go on.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nalgebra::{Point, Point2, Point3};

use crate::relax::descent::DescentOptions;
use crate::relax::driver::{Observer, RunEnd};
use crate::relax::metrics::{CellMetrics, Metrics};
use crate::relax::multilevel::levels_for_cubes;
use crate::relax::plan::{Perturbation, PerturbationKind, Plan};
use crate::relax::planar::Plane;
use crate::relax::ranked_lloyd::is_plain;
use crate::relax::record::Record;
use crate::relax::relaxation::{Checkpoint, continue_run};
use crate::relax::relaxation_space::{EnergySpec, Norm, RelaxationSpace};
use crate::relax::space::Space;
use crate::scene::description::Scene;
use crate::scene::error::Error;
use crate::scene::frames::FrameChoice;
use crate::scene::memory;
use crate::scene::method::{Anneal, SceneMethod};
use crate::scene::place::{PlacedSites, SiteRegion, place};

/// Sites of a run, by dimension.
#[derive(Clone, Debug, PartialEq)]
pub enum Points<Plane, Space> {
    /// In the plane.
    Plane(Plane),
    /// In space.
    Space(Space),
}

/// Sites of a run while it goes on.
pub type PointsSoFar<'a> = Points<&'a [Point2<f64>], &'a [Point3<f64>]>;

/// What a run leaves.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SceneOutcome {
    /// The sites, in the order of those that the scene names.
    pub sites: Points<Vec<Point2<f64>>, Vec<Point3<f64>>>,
    /// Every record, the first of the sites before any move.
    pub records: Vec<Record>,
    /// Why the run ended.
    pub ended: RunEnd,
    /// What was repaired in the scene's mesh, one sentence each.
    pub notes: Vec<String>,
}

/// Runs a validated scene. The observer is shown every record with its sites and may stop the run.
///
/// # Errors
/// When the scene's files cannot be read, its domain is none, or its sites have no diagram.
pub fn run(
    scene: &Scene,
    observer: impl FnMut(&Record, PointsSoFar<'_>) -> ControlFlow<()>,
) -> Result<SceneOutcome, Error> {
    run_until(scene, &Arc::default(), observer)
}

/// As [`run`], ended by an error soon after another thread raises `flag`, in space also within a move.
///
/// # Errors
/// As [`run`], and when it was stopped.
pub fn run_until(
    scene: &Scene,
    flag: &Arc<AtomicBool>,
    mut observer: impl FnMut(&Record, PointsSoFar<'_>) -> ControlFlow<()>,
) -> Result<SceneOutcome, Error> {
    let mut records = Vec::new();
    let mut keep = |record: &Record, sites: PointsSoFar<'_>| {
        records.push(record.clone());
        observer(record, sites)
    };
    let (sites, ended, notes) = if scene.dimension == 2 {
        let plane = plane(scene)?;
        let sites = plane.place(scene)?;
        check_memory(scene, sites.len())?;
        let mut checkpoint = Checkpoint::at_start(sites);
        let ended = relax(&plane, scene, &mut checkpoint, &mut |record, sites, _| {
            keep(record, Points::Plane(sites))
        })?;
        (
            Points::Plane(all_sites(&plane, &checkpoint)?),
            ended,
            Vec::new(),
        )
    } else {
        let (space, notes) = space(scene)?;
        let space = space.stop_by(flag);
        let sites = space.place(scene)?;
        let stopped = space.check_stop();
        stopped.map_err(|error| Error::Relax(Box::new(error)))?;
        check_memory(scene, sites.len())?;
        let mut checkpoint = Checkpoint::at_start(sites);
        let ended = relax(&space, scene, &mut checkpoint, &mut |record, sites, _| {
            keep(record, Points::Space(sites))
        })?;
        (Points::Space(all_sites(&space, &checkpoint)?), ended, notes)
    };
    Ok(SceneOutcome {
        sites,
        records,
        ended,
        notes,
    })
}

/// A space in which a scene's sites are placed, measured and relaxed.
pub trait RunSpace<const D: usize>: RelaxationSpace<D> {
    /// The domain, to place sites in.
    fn region(&self) -> SiteRegion<'_, D>;

    /// The figures of every cell, in the norm of `spec`.
    ///
    /// # Errors
    /// When the sites have no diagram.
    fn cells(
        &self,
        sites: &[Point<f64, D>],
        spec: EnergySpec,
    ) -> Result<Vec<CellMetrics<D>>, Self::Error>;

    /// The figures of all cells together, those of `cells`.
    ///
    /// # Errors
    /// When the sites have no diagram.
    fn figures(
        &self,
        sites: &[Point<f64, D>],
        cells: &[CellMetrics<D>],
    ) -> Result<Metrics, Self::Error> {
        debug_assert_eq!(sites.len(), cells.len());
        Ok(Metrics::of(self.volume(), &self.optimum(), cells))
    }

    /// The scene's sites.
    ///
    /// # Errors
    /// As [`place()`], and where there is no memory for so many.
    fn place(&self, scene: &Scene) -> Result<Vec<Point<f64, D>>, Error> {
        Ok(self.placed(scene)?.sites)
    }

    /// The scene's sites, and what there is to say about them.
    ///
    /// # Errors
    /// As [`RunSpace::place`].
    fn placed(&self, scene: &Scene) -> Result<PlacedSites<D>, Error> {
        placed_in(&self.region(), scene)
    }
}

fn placed_in<const D: usize>(
    region: &SiteRegion<'_, D>,
    scene: &Scene,
) -> Result<PlacedSites<D>, Error> {
    scene.sites.announced().map_or(Ok(()), memory::check)?;
    let mut placed = place(scene, region)?;
    placed.sites.shrink_to_fit();
    memory::check(placed.sites.len() as u64)?;
    Ok(placed)
}

/// Sites of a lattice whose cells have less than this share of the mean volume are left out: where two walls
/// meet in a wedge a cell is a sliver, and few moves do not mend that. A cell in a corner has an eighth.
const LEAST_CELL: f64 = 0.1;

/// Leaves out the sites of slivers, one round: their neighbors take the volume.
fn without_slivers(
    space: &Space,
    scene: &Scene,
    sites: Vec<Point3<f64>>,
) -> Result<Vec<Point3<f64>>, Error> {
    let cells = space.metrics(&sites, energy_spec(scene));
    let cells = cells.map_err(|error| Error::value("sites", error.to_string()))?;
    let sum: f64 = cells.iter().map(|cell| cell.volume).sum();
    let least = LEAST_CELL * sum / sites.len() as f64;
    let kept = sites.into_iter().zip(&cells);
    let kept = kept.filter(|(_, cell)| cell.volume >= least);
    Ok(kept.map(|(site, _)| site).collect())
}

impl RunSpace<2> for Plane {
    fn region(&self) -> SiteRegion<'_, 2> {
        SiteRegion::<2>::of_plane(&self.domain)
    }

    fn cells(
        &self,
        sites: &[Point2<f64>],
        spec: EnergySpec,
    ) -> Result<Vec<CellMetrics<2>>, Self::Error> {
        self.metrics(sites, spec)
    }

    fn figures(
        &self,
        sites: &[Point2<f64>],
        cells: &[CellMetrics<2>],
    ) -> Result<Metrics, Self::Error> {
        let figures = Metrics::of(self.volume(), &self.optimum(), cells);
        Ok(figures.beside(self.both(sites)?))
    }
}

impl RunSpace<3> for Space {
    fn region(&self) -> SiteRegion<'_, 3> {
        SiteRegion {
            stop: self.stop.clone(),
            ..SiteRegion::<3>::of_solid(self.domain())
        }
    }

    fn placed(&self, scene: &Scene) -> Result<PlacedSites<3>, Error> {
        let mut placed = placed_in(&self.region(), scene)?;
        if scene.sites.is_lattice() && self.domain().surface_mesh().is_some() {
            placed.sites = without_slivers(self, scene, placed.sites)?;
        }
        Ok(placed)
    }

    fn cells(
        &self,
        sites: &[Point3<f64>],
        spec: EnergySpec,
    ) -> Result<Vec<CellMetrics<3>>, Self::Error> {
        self.metrics(sites, spec)
    }

    fn figures(
        &self,
        sites: &[Point3<f64>],
        cells: &[CellMetrics<3>],
    ) -> Result<Metrics, Self::Error> {
        let figures = Metrics::of(self.volume(), &self.optimum(), cells);
        Ok(figures.beside(self.both(sites)?))
    }
}

/// The plane of a validated scene of dimension 2.
///
/// # Errors
/// When the scene's domain or its density is none.
pub fn plane(scene: &Scene) -> Result<Plane, Error> {
    let domain = scene.plane()?;
    let domain = domain.with_linf_cells(scene.cells == Norm::Linf);
    Ok(Plane { domain })
}

/// The space of a validated scene of dimension 3, and what was repaired in its mesh, one sentence
/// each.
///
/// # Errors
/// When the scene's domain or its density is none, or its frames do not fit its sites.
pub fn space(scene: &Scene) -> Result<(Space, Vec<String>), Error> {
    let (domain, notes) = scene.solid()?;
    let space = Space::new(domain).with_cells(scene.cells);
    let Some(choice) = &scene.frames else {
        return Ok((space, notes));
    };
    // Frames belong to the sites of the start, also where a run goes on from later ones.
    let sites = space.place(scene)?;
    let frames = choice.frames(space.domain(), &sites)?;
    Ok((space.framed(frames), notes))
}

/// Refuses more sites than there is memory for in a run of the scene.
///
/// # Errors
/// [`Error::TooManySites`].
pub fn check_memory(scene: &Scene, count: usize) -> Result<(), Error> {
    match scene.method.remembered() {
        Some(steps) => memory::check_descent(count as u64, steps),
        None => memory::check(count as u64),
    }
}

/// Refuses more sites than there is memory for in a run over `size` ranks, `neighbors` of which share a machine:
/// each holds its part of them, or, where the method is not Lloyd's iteration alone, all.
///
/// # Errors
/// [`Error::TooManySites`].
pub(crate) fn check_memory_over_ranks(
    scene: &Scene,
    count: usize,
    [size, neighbors]: [usize; 2],
) -> Result<(), Error> {
    let share = if is_plain(&plan(scene, count)) {
        [neighbors, size]
    } else {
        [neighbors, 1]
    };
    let steps = scene.method.remembered().unwrap_or(0);
    memory::check_share(count as u64, steps, share.map(|part| part as u64))
}

/// Moves the sites of `checkpoint` by the scene's method, from the start or from where it was left.
///
/// # Errors
/// When the sites have no diagram.
pub fn relax<const D: usize, S: RunSpace<D>>(
    space: &S,
    scene: &Scene,
    checkpoint: &mut Checkpoint<D>,
    observer: &mut Observer<'_, D>,
) -> Result<RunEnd, Error> {
    let plan = plan(scene, checkpoint.sites.len());
    continue_run(space, &plan, checkpoint, observer).map_err(|error| Error::Relax(Box::new(error)))
}

/// All sites of a run that has stopped: the checkpoint's, those of a coarse level split without moves.
///
/// # Errors
/// When the domain has no room for so many distinct sites.
pub fn all_sites<const D: usize, S: RunSpace<D>>(
    space: &S,
    checkpoint: &Checkpoint<D>,
) -> Result<Vec<Point<f64, D>>, Error> {
    let sites = checkpoint.finest_sites(space);
    sites.map_err(|error| Error::Relax(Box::new(error)))
}

/// The norm, the order and the minimizer of a scene's cell energies.
#[must_use]
pub fn energy_spec(scene: &Scene) -> EnergySpec {
    EnergySpec {
        norm: scene.norm,
        order: scene.order,
        minimizer: scene.method.minimizer(),
    }
}

/// The plan of a scene with `count` sites.
#[must_use]
pub fn plan(scene: &Scene, count: usize) -> Plan {
    let levels = levels(scene, count);
    let iterations = scene.method.iterations();
    let whole = Plan {
        spec: energy_spec(scene),
        levels,
        tolerance: scene.method.tolerance(),
        steps: iterations.div_ceil(u64::from(levels) + 1),
        ..Plan::quasi_newton(scene.order, iterations)
    };
    let descend = |memory, gradient_tolerance| {
        Some(DescentOptions {
            order: scene.order,
            memory,
            gradient_tolerance,
        })
    };
    match &scene.method {
        SceneMethod::Lloyd(lloyd) => Plan {
            is_accelerated: lloyd.accelerate,
            descent: None,
            ..whole
        },
        SceneMethod::QuasiNewton(descent) => Plan {
            warm_up: descent.warm_up,
            descent: descend(descent.memory, descent.gradient_tolerance),
            ..whole
        },
        SceneMethod::Anneal(anneal) => Plan {
            warm_up: anneal.warm_up,
            descent: descend(anneal.memory, anneal.gradient_tolerance),
            steps: anneal.first_steps,
            perturbation: Some(perturbation(anneal)),
            ..whole
        },
    }
}

fn levels(scene: &Scene, count: usize) -> u32 {
    let has_own_frames = scene.frames.as_ref().is_some_and(FrameChoice::is_per_site);
    let chosen = match &scene.method {
        SceneMethod::Anneal(anneal) if anneal.exchange && !has_own_frames => {
            match scene.dimension {
                2 => levels_for_cubes::<2>(count),
                _ => levels_for_cubes::<3>(count),
            }
        }
        _ => 0,
    };
    scene.coarse_to_fine.unwrap_or(chosen)
}

fn perturbation(anneal: &Anneal) -> Perturbation {
    Perturbation {
        rounds: anneal.rounds,
        steps: anneal.steps,
        noise: anneal.noise,
        fall: anneal.fall,
        kind: if anneal.exchange {
            PerturbationKind::Exchange
        } else {
            PerturbationKind::Anneal
        },
        seed: anneal.seed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::read;
    use std::path::Path;

    fn scene(text: &str) -> Scene {
        let scene = read::parse(text, Path::new("test")).expect("a scene");
        scene.validate().expect("numbers that make sense");
        scene
    }

    #[test]
    fn a_run_leaves_sites_records_and_why_it_ended() {
        let descent = r#"{ "sites": { "random": { "count": 9 } },
            "method": { "quasi_newton": { "iterations": 3 } } }"#;
        let lloyd = r#"{ "dimension": 2, "sites": { "random": { "count": 9 } },
            "method": { "lloyd": { "iterations": 3 } } }"#;
        for text in [descent, lloyd] {
            let outcome = run(&scene(text), |_, _| ControlFlow::Continue(())).expect("a run");
            assert_eq!(outcome.records.len(), 4);
            assert_eq!(outcome.ended, RunEnd::Iterations);
            let count = match &outcome.sites {
                Points::Plane(sites) => sites.len(),
                Points::Space(sites) => sites.len(),
            };
            assert_eq!(count, 9);
            let energy = |k: usize| outcome.records[k].energy_mean;
            assert!(energy(3) < energy(0));
        }
    }

    #[test]
    fn the_observer_stops_a_run_and_progress_goes_on_with_it_to_the_bit() {
        let scene = scene(
            r#"{ "sites": { "random": { "count": 30 } },
            "method": { "quasi_newton": { "iterations": 6, "warm_up": 1 } } }"#,
        );
        let (space, _) = space(&scene).expect("a box");
        let sites = space.place(&scene).expect("random sites");
        let mut whole = Checkpoint::at_start(sites.clone());
        let mut parts = Checkpoint::at_start(sites);
        relax(&space, &scene, &mut whole, &mut |_, _, _| {
            ControlFlow::Continue(())
        })
        .expect("a run");
        let ended = relax(
            &space,
            &scene,
            &mut parts,
            &mut |record, _, _| match record.iteration {
                3 => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            },
        );
        assert_eq!(ended.expect("a run"), RunEnd::Interrupted);
        let ended = relax(&space, &scene, &mut parts, &mut |_, _, _| {
            ControlFlow::Continue(())
        });
        assert_eq!(ended.expect("a run"), RunEnd::Iterations);
        assert_eq!(whole.sites, parts.sites);
    }
}
