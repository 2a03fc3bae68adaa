//! What is known of the pixels beside their colours, as layers of the picture.
//!
//! "AOV" is what renderers call such outputs (arbitrary output variables). A layer costs time only
//! when it is asked for.

mod features;
mod vignetting;

pub(crate) use features::FeatureSums;
pub use features::{FeatureFilm, Features};
pub use vignetting::vignetting;

use crate::film::FilmSums;
use crate::image::Layer;
use crate::lens::Model;
use crate::render::Job;

/// A layer that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aov {
    /// `depth.Z`: how far before the camera's origin, along its axis, the surfaces are that a
    /// pixel sees, in units of the scene; `depth.coverage`: the share of its light paths that
    /// meet a surface at all.
    Depth,
    /// Where they are, world space.
    Position,
    /// Their shading normals, unit before they are averaged, world space.
    Normal,
    /// The share of light that they send back or let through.
    Albedo,
    /// `object.shape` and `object.instance`: numbers, in the order of the scene file, of what
    /// the first path of the pixel meets; -1 for none.
    Object,
    /// The number of its material.
    Material,
    /// Variance of the pixel's value, by channel: its standard error squared.
    Variance,
    /// `samples.taken` and `samples.passed`: how many samples the pixel took, and how many of
    /// them came through the lens.
    Samples,
    /// Diameter of the circle of confusion of what the pixel sees on the film, um, to first
    /// order.
    Coc,
    /// Which surface of the lens takes which share of the light.
    Vignetting,
}

impl Aov {
    /// Whether it makes sense with a real lens only.
    pub fn needs_lens(self) -> bool {
        matches!(self, Self::Coc | Self::Vignetting)
    }
}

/// How many channels its layers have, at most.
pub fn channels(job: &Job) -> usize {
    let channels = |aov: &Aov| match (aov, &job.camera.model) {
        (Aov::Depth | Aov::Object | Aov::Samples, _) => 2,
        (Aov::Position | Aov::Normal | Aov::Albedo | Aov::Variance, _) => 3,
        (Aov::Vignetting, Model::Real(lens)) => lens.prescription.rows.len() + 1,
        (Aov::Material | Aov::Coc | Aov::Vignetting, _) => 1,
    };
    job.layers.iter().map(channels).sum()
}

/// The layers that a job asked for, after its render.
pub fn layers(job: &Job, film: &FilmSums, features: Option<&FeatureFilm>) -> Vec<Layer> {
    let samples = job.samples.end - job.samples.start;
    let layer = |aov: &Aov| match (aov, &job.camera.model) {
        (Aov::Vignetting, Model::Real(lens)) => Some(vignetting(lens, job.camera.film, &job.frame)),
        (Aov::Variance, _) => {
            let variance = film.variance(samples)?;
            let channel = |c: usize| variance.iter().map(|v| v[c]).collect();
            let channels = ["R", "G", "B"].into_iter().enumerate();
            Some(Layer {
                name: "variance".to_owned(),
                channels: channels.map(|(c, name)| (name.to_owned(), channel(c))).collect(),
            })
        }
        (aov, _) => features?.layer(*aov),
    };
    job.layers.iter().filter_map(layer).collect()
}
