//! What a scene's method means for the loops.

use crate::relax::descent::DescentOptions;
use crate::relax::levels::levels_for_cubes;
use crate::relax::plan::{KickStyle, Kicks, Plan};
use crate::relax::tessellation::Question;
use crate::scene::description::Scene;
use crate::scene::frames::FrameChoice;
use crate::scene::method::Method;
use crate::scene::method_keys::Anneal;

/// The plan of a scene with `count` sites; `None` where plain Lloyd is all of it.
#[must_use]
pub fn plan(scene: &Scene, count: usize) -> Option<Plan> {
    let levels = levels(scene, count);
    let iterations = scene.method.iterations();
    let whole = Plan {
        question: Question {
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
        Method::Lloyd(_) if levels == 0 => None,
        Method::Lloyd(lloyd) => Some(Plan {
            is_accelerated: lloyd.accelerate,
            descent: None,
            ..whole
        }),
        Method::QuasiNewton(descent) => Some(Plan {
            warm_up: descent.warm_up,
            descent: Some(DescentOptions {
                order: scene.order,
                memory: descent.memory,
                gradient_tolerance: descent.gradient_tolerance,
            }),
            ..whole
        }),
        Method::Anneal(anneal) => Some(Plan {
            warm_up: anneal.warm_up,
            descent: Some(DescentOptions {
                order: scene.order,
                memory: anneal.memory,
                gradient_tolerance: anneal.gradient_tolerance,
            }),
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
