//! Survey: whether light paths find the caustics of a picture, and on which surfaces they start.

use std::ops::Range;

use super::Caustics;
use super::caster::casters;
use super::walk::{CausticColumns, Connected};
use crate::light_tracing::entry::{EntrySampler, EntrySquare};
use crate::light_tracing::light_paths::{FrontEntry, LightPathSelection, SurveyedPicture};
use petzval_base::distribution::DiscreteDistribution;
use petzval_base::lanes::f32x8;
use petzval_base::rays::WAVE_SIZE;
use petzval_base::sampler::pixel_key;
use petzval_scene::luminance;

/// Waves of the first part of the survey, which finds the casters, and of the second.
const WAVES: [u32; 2] = [12, 16];
/// Share of the light paths that start on any caster, whatever the survey found there.
const ANYWHERE: f64 = 0.2;
/// Reflectance that is assumed of surfaces on which caustics fall.
const REFLECTANCE: f64 = 0.5;
/// Largest variance of light paths relative to that of camera paths.
const LARGEST: f64 = 0.5;

/// Surveys the caustics of a picture. Returns why there are none that are worth light paths.
pub(crate) fn survey(picture: &SurveyedPicture<'_>) -> Result<Caustics, &'static str> {
    let SurveyedPicture { input, lens, selection, .. } = *picture;
    let limits = input.path_limits;
    match () {
        () if input.scene.area_lights().is_empty() => Err("no surface emits light for caustics"),
        () if limits.max_depth < 2 || limits.direct_only => Err("paths are too short for caustics"),
        () if input.scene.has_media() => Err("the scene has media"),
        () if limits.regularize => Err("the scene removes caustics"),
        () => Ok(()),
    }?;
    let casters = casters(input.scene)?;
    let view = picture.view()?;
    let square = EntrySquare { half: view.half };
    let mut caustics = Caustics {
        casters,
        choice: DiscreteDistribution::from_probabilities(&[1.0]),
        entry: EntrySampler::new(lens, square),
        front: FrontEntry::new(lens, square),
    };
    let areas: Vec<f64> = caustics.casters.iter().map(|caster| caster.area.sqrt()).collect();
    caustics.set_shares(&areas);
    let first = Pilot::trace(&caustics, picture, 0..WAVES[0]);
    if first.light <= 0.0 {
        return Err("no caustics are in view");
    }
    // The best share of a caster is the root of its second moment under the share that it had.
    let moments: Vec<f64> = caustics
        .casters
        .iter()
        .zip(&first.squares)
        .map(|(caster, square)| (square * caster.share).sqrt())
        .collect();
    let total: f64 = moments.iter().sum();
    let anywhere: f64 = areas.iter().sum();
    let shares: Vec<f64> = moments
        .iter()
        .zip(&areas)
        .map(|(moment, area)| (1.0 - ANYWHERE) * moment / total + ANYWHERE * area / anywhere)
        .collect();
    caustics.set_shares(&shares);
    if matches!(selection, LightPathSelection::All) {
        return Ok(caustics);
    }
    let second = Pilot::trace(&caustics, picture, WAVES[0]..WAVES[0] + WAVES[1]);
    // A camera path that finds the light has the value v: the variance is v times the mean.
    let camera = view.exposure * REFLECTANCE * second.light_by_radiance;
    if !selection.includes(camera) {
        return Err("caustics add little noise");
    }
    if second.squares.iter().sum::<f64>() > LARGEST * camera {
        return Err("light paths would be as noisy as camera paths in caustics");
    }
    Ok(caustics)
}

/// Sums over the light paths of some waves.
struct Pilot {
    /// Mean value of a pixel by caustics.
    light: f64,
    /// The same times the luminance of the lights.
    light_by_radiance: f64,
    /// Variance of a pixel in one sample number, by caster.
    squares: Vec<f64>,
}

impl Pilot {
    fn trace(caustics: &Caustics, picture: &SurveyedPicture<'_>, waves: Range<u32>) -> Self {
        let input = picture.input;
        let mut columns = CausticColumns::default();
        let mut pilot =
            Self { light: 0.0, light_by_radiance: 0.0, squares: vec![0.0; caustics.casters.len()] };
        let count = caustics.path_count(input.frame);
        let pixels = input.frame.resolution.map(f64::from).iter().product::<f64>();
        let scale = count.splat_scale(input);
        // Each path stands for several of the render.
        let each = count.paths() / (f64::from(waves.end - waves.start) * WAVE_SIZE as f64);
        let key = pixel_key(0, u32::MAX - 5, input.seed);
        for wave in waves {
            let mut found = |Connected { paths, slots, starts }: Connected| {
                for i in picture.arrivals(&caustics.front, wave, paths) {
                    let transmission = paths.film_hit(i).map_or(0.0, |hit| hit.transmission);
                    let value = f64::from(luminance(paths.flux(i))) * transmission * scale;
                    if !(value > 0.0 && value.is_finite()) {
                        continue;
                    }
                    let start = &starts[slots[i] as usize];
                    pilot.light += each * value / pixels;
                    pilot.light_by_radiance += each * value * start.radiance / pixels;
                    pilot.squares[start.caster as usize] += each * value * value / pixels;
                }
            };
            caustics.walk::<f32x8>(input, &mut columns, [key, wave], &mut found);
        }
        pilot
    }
}
