//! A whole run of a scene as one call: from the sites that it names to where its method leaves them.
//!
//! [`run`] does all of it; [`RunSpace`] and [`relax`] are its parts for a caller that knows the
//! dimension, keeps checkpoints ([`Progress`]) or goes on from one. Nothing is printed or written:
//! an observer is shown every record and says whether to go on.

use std::ops::ControlFlow;

use nalgebra::{Point, Point2, Point3};

use crate::relax::descent::DescentOptions;
use crate::relax::figures::CellFigures;
use crate::relax::levels::levels_for_cubes;
use crate::relax::lloyd::{Ended, LloydOptions, lloyd};
use crate::relax::plan::{KickStyle, Kicks, Plan};
use crate::relax::plane::Plane;
use crate::relax::record::Record;
use crate::relax::space::Space;
use crate::relax::stand::Stand;
use crate::relax::tessellation::{Question, Tessellation};
use crate::relax::travel::travel;
use crate::scene::description::Scene;
use crate::scene::error::Error;
use crate::scene::frames::FrameChoice;
use crate::scene::method::{Anneal, Method};
use crate::scene::place::{Region, place};

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
pub struct Outcome {
    /// The sites, in the order of those that the scene names.
    pub sites: Points<Vec<Point2<f64>>, Vec<Point3<f64>>>,
    /// Every record, the first of the sites before any move.
    pub records: Vec<Record>,
    /// Why the run ended.
    pub ended: Ended,
    /// What was repaired in the scene's mesh, one sentence each.
    pub notes: Vec<String>,
}

/// Runs a validated scene. The observer is shown every record with its sites and may stop the run.
///
/// # Errors
/// When the scene's files cannot be read, its domain is none, or its sites have no diagram.
pub fn run(
    scene: &Scene,
    mut observer: impl FnMut(&Record, PointsSoFar<'_>) -> ControlFlow<()>,
) -> Result<Outcome, Error> {
    let mut records = Vec::new();
    let mut keep = |record: &Record, sites: PointsSoFar<'_>| {
        records.push(record.clone());
        observer(record, sites)
    };
    let (sites, ended, notes) = if scene.dimension == 2 {
        let plane = plane(scene)?;
        let mut progress = Progress::at_start(plane.place(scene)?);
        let ended = relax(&plane, scene, &mut progress, &mut |record, sites, _| {
            keep(record, Points::Plane(sites))
        })?;
        (Points::Plane(progress.sites), ended, Vec::new())
    } else {
        let (space, notes) = space(scene)?;
        let mut progress = Progress::at_start(space.place(scene)?);
        let ended = relax(&space, scene, &mut progress, &mut |record, sites, _| {
            keep(record, Points::Space(sites))
        })?;
        (Points::Space(progress.sites), ended, notes)
    };
    Ok(Outcome {
        sites,
        records,
        ended,
        notes,
    })
}

/// How far a run has come: all that it needs to go on, to the bit as if it had not been left.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress<const D: usize> {
    /// The sites.
    pub sites: Vec<Point<f64, D>>,
    /// The record that describes them; none before the first.
    pub last: Option<Record>,
    /// The method's own state after that record; none for plain Lloyd and before the first.
    pub state: Option<Stand>,
}

impl<const D: usize> Progress<D> {
    /// A run before its first record.
    #[must_use]
    pub fn at_start(sites: Vec<Point<f64, D>>) -> Self {
        Self {
            sites,
            last: None,
            state: None,
        }
    }
}

/// Is shown a record, the sites it describes and the method's state, and says whether to go on.
pub type Observer<'a, const D: usize> =
    dyn FnMut(&Record, &[Point<f64, D>], Option<&Stand>) -> ControlFlow<()> + 'a;

/// A space in which a scene's sites are placed, measured and relaxed.
pub trait RunSpace<const D: usize>: Tessellation<D> {
    /// The domain, to place sites in.
    fn region(&self) -> Region<'_, D>;

    /// The figures of every cell, in the norm of `question`.
    ///
    /// # Errors
    /// When the sites have no diagram.
    fn cells(
        &self,
        sites: &[Point<f64, D>],
        question: Question,
    ) -> Result<Vec<CellFigures<D>>, Self::Error>;

    /// Carries out a plan from where `progress` is.
    ///
    /// # Errors
    /// When the sites have no diagram, or the plan cannot be carried out here.
    fn carry_out(
        &self,
        plan: &Plan,
        progress: &mut Progress<D>,
        observer: &mut Observer<'_, D>,
    ) -> Result<Ended, Error>;

    /// The scene's sites.
    ///
    /// # Errors
    /// As [`place()`].
    fn place(&self, scene: &Scene) -> Result<Vec<Point<f64, D>>, Error> {
        place(&scene.sites, &self.region(), scene.drop_outside)
    }
}

impl RunSpace<2> for Plane {
    fn region(&self) -> Region<'_, 2> {
        Region::<2>::of_plane(&self.domain)
    }

    fn cells(
        &self,
        sites: &[Point2<f64>],
        question: Question,
    ) -> Result<Vec<CellFigures<2>>, Self::Error> {
        self.figures(sites, question)
    }

    fn carry_out(
        &self,
        _: &Plan,
        _: &mut Progress<2>,
        _: &mut Observer<'_, 2>,
    ) -> Result<Ended, Error> {
        Err(Error::value(
            "method",
            "in the plane there is plain Lloyd only",
        ))
    }
}

impl RunSpace<3> for Space {
    fn region(&self) -> Region<'_, 3> {
        Region::<3>::of_solid(self.domain())
    }

    fn cells(
        &self,
        sites: &[Point3<f64>],
        question: Question,
    ) -> Result<Vec<CellFigures<3>>, Self::Error> {
        self.figures(sites, question)
    }

    fn carry_out(
        &self,
        plan: &Plan,
        progress: &mut Progress<3>,
        observer: &mut Observer<'_, 3>,
    ) -> Result<Ended, Error> {
        let (sites, last) = (&mut progress.sites, &mut progress.last);
        let fresh = || Stand::new(sites.len(), plan.levels);
        let state = progress.state.get_or_insert_with(fresh);
        let resumed = last.clone();
        let mut watch = |record: &Record, sites: &[Point3<f64>], state: &Stand| {
            *last = Some(record.clone());
            observer(record, sites, Some(state))
        };
        travel(self, plan, sites, state, resumed.as_ref(), &mut watch)
            .map_err(|error| Error::Relax(Box::new(error)))
    }
}

/// The plane of a validated scene of dimension 2.
///
/// # Errors
/// When the scene's domain is none.
pub fn plane(scene: &Scene) -> Result<Plane, Error> {
    let domain = scene.domain.plane()?;
    Ok(Plane { domain })
}

/// The space of a validated scene of dimension 3, and what was repaired in its mesh, one sentence
/// each.
///
/// # Errors
/// When the scene's domain or its density is none, or its frames do not fit its sites.
pub fn space(scene: &Scene) -> Result<(Space, Vec<String>), Error> {
    let (domain, notes) = scene.solid()?;
    let space = Space::new(domain);
    let Some(choice) = &scene.frames else {
        return Ok((space, notes));
    };
    // Frames belong to the sites of the start, also where a run goes on from later ones.
    let sites = space.place(scene)?;
    let frames = choice.frames(space.domain(), &sites)?;
    Ok((space.framed(frames), notes))
}

/// Moves the sites of `progress` by the scene's method, from the start or from where it was left.
///
/// # Errors
/// When the sites have no diagram.
pub fn relax<const D: usize, S: RunSpace<D>>(
    space: &S,
    scene: &Scene,
    progress: &mut Progress<D>,
    observer: &mut Observer<'_, D>,
) -> Result<Ended, Error> {
    if let Some(plan) = plan(scene, progress.sites.len()) {
        return space.carry_out(&plan, progress, observer);
    }
    let options = LloydOptions {
        iterations: scene.method.iterations(),
        tolerance: scene.method.tolerance(),
        question: question(scene),
        is_accelerated: scene.method.is_accelerated(),
    };
    let (resumed, last) = (progress.last.clone(), &mut progress.last);
    let mut observe = |record: &Record, sites: &[Point<f64, D>]| {
        *last = Some(record.clone());
        observer(record, sites, None)
    };
    let sites = &mut progress.sites;
    lloyd(space, sites, &options, resumed.as_ref(), &mut observe)
        .map_err(|error| Error::Relax(Box::new(error)))
}

/// The norm, the order and the minimizer of a scene's cell energies.
#[must_use]
pub fn question(scene: &Scene) -> Question {
    Question {
        norm: scene.norm,
        order: scene.order,
        minimizer: scene.method.minimizer(),
    }
}

/// The plan of a scene with `count` sites; `None` where plain Lloyd is all of it.
#[must_use]
pub fn plan(scene: &Scene, count: usize) -> Option<Plan> {
    let levels = levels(scene, count);
    let iterations = scene.method.iterations();
    let whole = Plan {
        question: question(scene),
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
        Method::Lloyd(_) if levels == 0 => None,
        Method::Lloyd(lloyd) => Some(Plan {
            is_accelerated: lloyd.accelerate,
            descent: None,
            ..whole
        }),
        Method::QuasiNewton(descent) => Some(Plan {
            warm_up: descent.warm_up,
            descent: descend(descent.memory, descent.gradient_tolerance),
            ..whole
        }),
        Method::Anneal(anneal) => Some(Plan {
            warm_up: anneal.warm_up,
            descent: descend(anneal.memory, anneal.gradient_tolerance),
            steps: anneal.first_steps,
            kicks: Some(kicks(anneal)),
            ..whole
        }),
    }
}

fn levels(scene: &Scene, count: usize) -> u32 {
    let has_own_frames = scene.frames.as_ref().is_some_and(FrameChoice::is_per_site);
    let chosen = match &scene.method {
        Method::Anneal(anneal) if anneal.exchange && !has_own_frames => levels_for_cubes(count),
        _ => 0,
    };
    scene.coarse_to_fine.unwrap_or(chosen)
}

fn kicks(anneal: &Anneal) -> Kicks {
    Kicks {
        rounds: anneal.rounds,
        steps: anneal.steps,
        noise: anneal.noise,
        fall: anneal.fall,
        style: if anneal.exchange {
            KickStyle::Exchange
        } else {
            KickStyle::Anneal
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
            assert_eq!(outcome.ended, Ended::Iterations);
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
        let mut whole = Progress::at_start(sites.clone());
        let mut parts = Progress::at_start(sites);
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
        assert_eq!(ended.expect("a run"), Ended::Interrupted);
        let ended = relax(&space, &scene, &mut parts, &mut |_, _, _| {
            ControlFlow::Continue(())
        });
        assert_eq!(ended.expect("a run"), Ended::Iterations);
        assert_eq!(whole.sites, parts.sites);
    }
}
