//! Material of a surface that a ray hit: the choice in a mixture, and the albedo.

use super::bsdf::{BsdfKind, SurfaceTextures};
use super::footprint::PixelFootprint;
use super::shading_context::ShadingContext;
use petzval_base::rays::{Hit, Ray};
use petzval_base::sampler::hash;
use petzval_scene::{MaterialModel, Scene};

/// Chooses the material of a surface that a ray hit if `material` is a mixture, and returns its
/// index and kind. `context` is called for mixtures only.
#[inline(always)]
pub(super) fn resolve_mixture(
    scene: &Scene,
    material: u32,
    ray: impl Fn() -> Ray,
    context: impl Fn() -> ShadingContext,
) -> (u32, BsdfKind) {
    match BsdfKind::of(&scene.materials[material as usize].model) {
        Some(kind) => (material, kind),
        None => choose_material(scene, material, &ray(), &context()),
    }
}

/// Chooses one of the materials of a mixture.
#[cold]
#[inline(never)]
fn choose_material(
    scene: &Scene,
    mixture: u32,
    ray: &Ray,
    context: &ShadingContext,
) -> (u32, BsdfKind) {
    let mut index = mixture;
    // A mixture consists of materials defined before it, so the loop ends.
    loop {
        let model = &scene.materials[index as usize].model;
        if let Some(kind) = BsdfKind::of(model) {
            return (index, kind);
        }
        if let MaterialModel::Mix { materials, amount } = model {
            let number = hashed_number(index, context.points.position, ray.direction);
            index = materials[usize::from(number < context.number(amount))];
        }
    }
}

/// Returns a random number in [0, 1) that depends only on a point, the direction of a ray and
/// `salt`.
fn hashed_number(salt: u32, point: [f32; 3], direction: [f32; 3]) -> f32 {
    let bits = point.into_iter().chain(direction);
    let mixed = bits.fold(salt, |h, value| hash(h ^ value.to_bits()));
    (mixed >> 8) as f32 / 16_777_216.0
}

/// Returns the approximate share of light that a surface reflects or transmits, by channel.
pub fn albedo(scene: &Scene, footprint: &PixelFootprint, ray: Ray, hit: Hit) -> [f32; 3] {
    let context = ShadingContext::of_hit(scene, footprint, &ray, &hit);
    let shape = &scene.shapes[hit.shape as usize];
    let again = || ShadingContext::of_hit(scene, footprint, &ray, &hit);
    let (material, kind) = resolve_mixture(scene, shape.material, || ray, again);
    kind.stage::<f32>().albedo(&scene.materials[material as usize].model, &context)
}
