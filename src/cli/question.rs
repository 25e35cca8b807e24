//! What a scene asks of every cell.

use chebloyd::relax::tessellation::Question;
use chebloyd::scene::description::Scene;
use chebloyd::scene::method::Method;

/// The scene's norm, order and minimizer.
pub(crate) fn question(scene: &Scene) -> Question {
    let Method::Lloyd(lloyd) = &scene.method;
    Question {
        norm: scene.norm.into(),
        order: scene.order,
        minimizer: lloyd.minimizer.into(),
    }
}
