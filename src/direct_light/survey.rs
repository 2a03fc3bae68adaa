//! Survey of the lamps that a camera sees: which of them light paths find better than camera paths.

use glam::Vec3;

use super::DirectLight;
use super::lamp::{ENTRY_CELLS, Lamp, entry_distribution};
use super::splat::DirectColumns;
use crate::lanes::f32x8;
use crate::lens::{LensColumns, LensModel, RealLens};
use crate::light_paths::LightPathInput;
use crate::rays::{HitBatch, NO_INDEX, RayBatch, SampleBatch, WAVE_SIZE};
use crate::sampler::{Dimension, pixel_key, sample_2d};
use crate::scene::{TraversalStack, luminance};
use crate::stats::LensStats;

/// Waves of camera rays.
const CAMERA_WAVES: u32 = 4;
/// Light paths for all lamps together.
const LIGHT_PATHS: u32 = 1 << 19;
/// Fewest and most light paths of one lamp.
const PATHS_PER_LAMP: [u32; 2] = [1 << 10, 1 << 12];
/// Largest number of lights that are surveyed.
const MAX_LIGHTS: usize = 512;
/// Largest share of the camera rays that hit a lamp which is worth light paths.
const LARGEST: f64 = 0.02;
/// Smallest brightness of the lamp's image, relative to the mean of the picture.
const BRIGHTEST: f64 = 10.0;
/// Smallest variance of a camera sample that is worth light paths, relative to the square of the mean
/// of the picture: that of all lamps together.
const NOISIEST: f64 = 10.0;
/// Margin of the square of entry points about the camera rays.
const MARGIN: f64 = 1.05;

/// Result of a survey.
#[derive(Clone, Debug)]
pub struct Survey {
    /// The lamps, if light paths are worth their time.
    pub direct_light: Option<DirectLight>,
    /// The reason, in a sentence.
    pub reason: String,
}

/// Which lamps light paths start from.
#[derive(Clone, Copy, Debug)]
pub enum Lamps {
    /// All that are in view.
    All,
    /// Lamps with a small bright image, if they make the picture noisy.
    Noisy {
        /// The mean luminance of the picture.
        mean: f64,
    },
}

impl Survey {
    /// No light paths, by the user's wish.
    pub fn unwanted() -> Self {
        Self { direct_light: None, reason: "not wanted".to_owned() }
    }
}

/// Surveys the lamps of a scene.
pub fn survey(input: &LightPathInput<'_>, wanted: Lamps) -> Survey {
    match lamps_in_view(input, wanted) {
        Ok(lamps) => {
            let reason = match lamps.lamps() {
                1 => "one lamp in view".to_owned(),
                count => format!("{count} lamps in view"),
            };
            Survey { direct_light: Some(lamps), reason }
        }
        Err(reason) => Survey { direct_light: None, reason: reason.to_owned() },
    }
}

/// Returns the lamps from which light paths start, or why there are none.
fn lamps_in_view(input: &LightPathInput<'_>, wanted: Lamps) -> Result<DirectLight, &'static str> {
    let LensModel::Real(lens) = &input.camera.model else {
        return Err("the camera has no lens of glass");
    };
    obstacle(input, lens).map_or(Ok(()), Err)?;
    let lights = input.scene.area_lights();
    if lights.is_empty() {
        return Err("no surface emits light");
    }
    let view = CameraView::new(input).ok_or("no ray leaves the lens")?;
    let lights: Vec<u32> = lights
        .into_iter()
        .filter(|&light| matches!(wanted, Lamps::All) || view.share(light) <= LARGEST)
        .take(MAX_LIGHTS)
        .collect();
    let paths =
        (LIGHT_PATHS / lights.len().max(1) as u32).clamp(PATHS_PER_LAMP[0], PATHS_PER_LAMP[1]);
    let mut all = DirectLight::new(lens, view.half, input.scene.lights.all.len());
    let film_area = input.camera.film[0] * input.camera.film[1];
    let (mut found, mut variance) = (Vec::new(), 0.0);
    for light in lights {
        let areas = input.scene.emitter_areas(light);
        let Some(lamp) = Lamp::seen_everywhere(light, &areas) else { continue };
        all.set_lamps(vec![(lamp.clone(), 1.0)]);
        let image = LampImage::trace(&all, input, lens, paths);
        let bright = match wanted {
            Lamps::All => true,
            Lamps::Noisy { mean } => view.exposure * image.radiance >= BRIGHTEST * mean,
        };
        if let (true, Some(entry)) = (bright && image.is_lit(), entry_distribution(&image.entry)) {
            // A lamp of value v on a share s of the film has the variance v^2 s.
            let value = input.camera.imaging_ratio * image.flux / film_area;
            variance += view.exposure * image.radiance * value;
            // The root gives faint lamps more paths than their light alone.
            found.push((Lamp { entry, ..lamp }, image.flux.sqrt()));
        }
    }
    match wanted {
        Lamps::All if found.is_empty() => Err("no lamp is in view"),
        Lamps::Noisy { .. } if found.is_empty() => {
            Err("no lamp in view is small and bright enough")
        }
        Lamps::Noisy { mean } if variance < NOISIEST * mean * mean => {
            Err("the lamps in view add little noise")
        }
        _ => Ok(()),
    }?;
    all.set_lamps(found);
    Ok(all)
}

/// Returns why light paths cannot find the light of this picture.
pub(crate) fn obstacle(input: &LightPathInput<'_>, lens: &RealLens) -> Option<&'static str> {
    let matrix = input.camera.world_from_camera.matrix3;
    let lengths = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.length_squared());
    let similar = |i: usize| (lengths[i] / lengths[0] - 1.0).abs() < 1e-6;
    match () {
        () if input.timing.is_some() => Some("something moves"),
        () if lens.bands.len() > 1 => Some("the lens has dispersion"),
        () if lens.bands[0].response != [1.0; 3] => Some("the film takes a passband"),
        () if lens.prescription.has_mirrors() => Some("the lens has mirrors"),
        () if lens.prescription.rear().index != 1.0 => Some("the film is not in air"),
        () if input.scene.has_media() => Some("the scene has media"),
        () if input.response.max_component.is_some() => Some("bright samples are clamped"),
        () if input.camera.depth != [0.0, f64::INFINITY] => Some("the camera clips distances"),
        () if !(similar(1) && similar(2)) => Some("the camera is stretched"),
        () => None,
    }
}

/// The camera rays of the survey.
pub(crate) struct CameraView {
    /// Half side of a square about the front vertex that holds all of them (mm).
    pub half: f64,
    /// Value of a pixel that sees radiance 1.
    pub exposure: f64,
    /// Number of hits, by light.
    hits: Vec<u32>,
    rays: u32,
}

impl CameraView {
    /// Traces the rays; `None` if none leaves the lens.
    pub fn new(input: &LightPathInput<'_>) -> Option<Self> {
        let LensModel::Real(lens) = &input.camera.model else { return None };
        let camera_from_world = input.camera.world_from_camera.inverse();
        let mut view =
            Self { half: 0.0, exposure: 0.0, hits: vec![0; input.scene.lights.all.len()], rays: 0 };
        let (mut columns, mut rays) = (LensColumns::default(), RayBatch::default());
        let (mut hits, mut stack) = (HitBatch::default(), TraversalStack::default());
        let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
        let key = pixel_key(u32::MAX, u32::MAX - 2, input.seed);
        for wave in 0..CAMERA_WAVES {
            for i in 0..WAVE_SIZE {
                let number = wave * WAVE_SIZE as u32 + i as u32;
                let [film, pupil] =
                    [Dimension::Film, Dimension::Pupil].map(|d| sample_2d(key, number, d));
                for axis in 0..2 {
                    let place = (f64::from(film[axis]) - 0.5) * input.camera.film[axis];
                    samples.film[axis][i] = place as f32;
                    samples.pupil[axis][i] = pupil[axis];
                }
            }
            let mut stats = LensStats::default();
            input.camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
            input.scene.intersect::<f32x8>(&rays, &mut hits, &mut stack);
            for i in 0..rays.len {
                let origin = Vec3::from(rays.ray(i).origin).as_dvec3();
                let place = camera_from_world.transform_point3(origin) / lens.units_per_mm;
                view.half = view.half.max(place.x.abs()).max(place.y.abs());
                view.exposure += f64::from(luminance(rays.throughput(i)));
                let shape = hits[i].shape;
                if let Some(shape) =
                    (shape != NO_INDEX).then(|| &input.scene.shapes[shape as usize])
                    && let Some(count) = view.hits.get_mut(shape.light as usize)
                {
                    *count += 1;
                }
            }
            view.rays += WAVE_SIZE as u32;
        }
        view.half *= MARGIN;
        view.exposure /= f64::from(view.rays);
        (view.half > 0.0 && view.half.is_finite()).then_some(view)
    }

    fn share(&self, light: u32) -> f64 {
        f64::from(self.hits[light as usize]) / f64::from(self.rays)
    }
}

/// Image of one lamp, estimated by light paths.
struct LampImage {
    /// Light on the film, as luminance times mm^2 sr.
    flux: f64,
    /// Mean luminance of the radiance of the lamp.
    radiance: f64,
    /// Number of arrivals on the film, by cell of the entry points.
    entry: Vec<u32>,
}

impl LampImage {
    /// Returns whether any light arrived, and not more than can be summed.
    fn is_lit(&self) -> bool {
        self.flux > 0.0 && self.flux.is_finite()
    }

    fn trace(light: &DirectLight, input: &LightPathInput<'_>, lens: &RealLens, paths: u32) -> Self {
        let mut columns = DirectColumns::default();
        let mut image =
            Self { flux: 0.0, radiance: 0.0, entry: vec![0; ENTRY_CELLS * ENTRY_CELLS] };
        let key = pixel_key(light.lamps[0].light, u32::MAX - 3, input.seed);
        let (mut radiance, mut sampled) = (0.0, 0.0f64);
        for wave in 0..paths / WAVE_SIZE as u32 {
            radiance += light.sample(input, lens, &mut columns, key, wave);
            sampled += columns.paths.len() as f64;
            light.front.trace::<f32x8>(lens, &mut columns.paths, &mut columns.blocked);
            let hits = columns.paths.film_hits();
            let on_film = |i: &usize| {
                2.0 * f64::from(hits.x[*i]).abs() < input.camera.film[0]
                    && 2.0 * f64::from(hits.y[*i]).abs() < input.camera.film[1]
            };
            let arrivals: Vec<usize> = (0..columns.paths.len()).filter(on_film).collect();
            columns.paths.connect::<f32x8>(input, arrivals.iter().map(|&i| i as u32));
            for i in arrivals {
                let flux = f64::from(luminance(columns.paths.flux(i)));
                if flux > 0.0 {
                    image.flux += flux / f64::from(paths);
                    let [x, y] = columns
                        .paths
                        .entry(i)
                        .map(|u| ((u * ENTRY_CELLS as f32) as usize).min(ENTRY_CELLS - 1));
                    image.entry[y * ENTRY_CELLS + x] += 1;
                }
            }
        }
        image.radiance = if sampled > 0.0 { radiance / sampled } else { 0.0 };
        image
    }
}
