//! What a scene asks of every cell.

use chebloyd::relax::relaxation_space::EnergySpec;
use chebloyd::scene::description::Scene;

/// The scene's norm, order and minimizer.
pub(crate) fn question(scene: &Scene) -> EnergySpec {
    EnergySpec {
        norm: scene.norm.into(),
        order: scene.order,
        minimizer: scene.method.minimizer().into(),
    }
}
