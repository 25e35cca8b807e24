//! What a scene asks of every cell.

use chebloyd::relax::tessellation::Question;
use chebloyd::scene::description::Scene;

/// The scene's norm, order and minimizer.
pub(crate) fn question(scene: &Scene) -> Question {
    Question {
        norm: scene.norm.into(),
        order: scene.order,
        minimizer: scene.method.minimizer().into(),
    }
}
