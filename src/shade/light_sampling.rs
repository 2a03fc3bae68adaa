//! Sampling of lights for the vertices of a wave.

use super::bsdf_kind::BsdfKind;
use super::random::RandomColumns;
use super::vertices::{Vertices, set, vector};
use crate::scene::Scene;

impl Vertices {
    /// Samples a light for every vertex whose BSDF is not singular, and loads the random numbers
    /// of the vertices.
    pub(super) fn sample_lights(&mut self, scene: &Scene, random: &RandomColumns) {
        for kind in BsdfKind::ALL {
            for at in self.ranges[kind as usize].clone() {
                let random = random.at(self.ray[at] as usize);
                let [u, v] = random.bounce;
                set(&mut self.bsdf_random, at, [u, v, random.roulette[1]]);
                self.roulette[at] = random.roulette[0];
                self.seeds[at] = random.seed;
                let singular = kind.is_singular([self.parameters[0][at], self.parameters[1][at]]);
                let sample = (!singular)
                    .then(|| scene.sample_light(&self.points[at], random.choice, random.light))
                    .flatten();
                let Some(sample) = sample.filter(|sample| sample.density > 0.0) else {
                    set(&mut self.light, at, [0.0; 3]);
                    set(&mut self.wi, at, vector(&self.normal, at));
                    self.light_pdf[at] = 1.0;
                    continue;
                };
                set(&mut self.wi, at, sample.direction.normalize_or_zero().to_array());
                set(&mut self.light, at, sample.radiance.map(|l| l / sample.density));
                // No other ray can hit a singular light, so its own sample has the weight 1.
                self.light_pdf[at] = if sample.singular { f32::INFINITY } else { sample.density };
                self.shadow[at] = (sample.direction.to_array(), sample.t_max);
            }
        }
    }
}
