//! Sampling of lights for the vertices of a wave.

use super::random::RandomColumns;
use super::vertices::Vertices;
use petzval_base::lanes::Real;
use petzval_scene::{LightInputs, Scene};

impl Vertices {
    /// Samples a light for every vertex whose BSDF is not singular.
    pub(super) fn sample_lights<R: Real<Scalar = f32>>(
        &mut self,
        scene: &Scene,
        random: &RandomColumns,
    ) {
        self.lit.clear();
        for (range, kind) in self.shaded_ranges() {
            let stage = kind.stage::<f32>();
            for at in range {
                if stage.unlit(&self.parameters, at) {
                    self.lights.clear(at, self.surfaces.shading_normal(at));
                } else {
                    self.lit.push(at as u32);
                }
            }
        }
        let inputs = LightInputs {
            surfaces: &self.surfaces,
            facing: &self.facing,
            lobes: self.lobes.columns(&self.wo),
            choice: &random.choice,
            u: &random.light,
            entries: &self.lit,
        };
        scene.sample_lights::<R>(&inputs, &mut self.light_columns, &mut self.lights);
    }
}
