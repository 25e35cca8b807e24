//! The plan of a run, from the scene's method.

use crate::relax::descent::DescentOptions;
use crate::relax::multilevel::levels_for_cubes;
use crate::relax::plan::{Perturbation, PerturbationKind, Plan};
use crate::relax::relaxation_space::EnergySpec;
use crate::scene::description::Scene;
use crate::scene::frames::FrameChoice;
use crate::scene::method::Method;
use crate::scene::method_keys::Anneal;

/// The plan of a scene with `count` sites.
#[must_use]
pub fn plan(scene: &Scene, count: usize) -> Plan {
    let levels = levels(scene, count);
    let iterations = scene.method.iterations();
    let whole = Plan {
        spec: EnergySpec {
            norm: scene.norm.into(),
            order: scene.order,
            minimizer: scene.method.minimizer().into(),
        },
        levels,
        tolerance: scene.method.tolerance(),
        steps: iterations.div_ceil(u64::from(levels) + 1),
        ..Plan::quasi_newton(scene.order, iterations)
    };
    match &scene.method {
        Method::Lloyd(lloyd) => Plan {
            is_accelerated: lloyd.accelerate,
            descent: None,
            ..whole
        },
        Method::QuasiNewton(descent) => Plan {
            warm_up: descent.warm_up,
            descent: Some(DescentOptions {
                order: scene.order,
                memory: descent.memory,
                gradient_tolerance: descent.gradient_tolerance,
            }),
            ..whole
        },
        Method::Anneal(anneal) => Plan {
            warm_up: anneal.warm_up,
            descent: Some(DescentOptions {
                order: scene.order,
                memory: anneal.memory,
                gradient_tolerance: anneal.gradient_tolerance,
            }),
            steps: anneal.first_steps,
            perturbation: Some(perturbation(anneal)),
            ..whole
        },
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
