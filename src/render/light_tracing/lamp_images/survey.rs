//! Survey of the lamps that a camera sees: which of them light paths find better than camera paths.

use super::LampImages;
use super::lamp::{ENTRY_GRID, Lamp, entry_distribution};
use super::reach::{ArrivalBounds, EntryReach};
use super::trace::LampColumns;
use crate::light_tracing::entry::EntrySquare;
use crate::light_tracing::light_paths::{LightPathInput, LightPathSelection, SurveyedPicture};
use petzval_base::lanes::f32x8;
use petzval_base::rays::WAVE_SIZE;
use petzval_base::sampler::pixel_key;
use petzval_lens::RealLens;
use petzval_scene::{Scene, luminance};

/// Light paths for all lamps together.
const LIGHT_PATHS: u32 = 1 << 19;
/// Fewest and most light paths of one lamp, as long as enough of them arrive.
const PATHS_PER_LAMP: [u32; 2] = [1 << 10, 1 << 12];
/// Most light paths of a lamp of which few arrive: the pupil of a wide lens is a small part of its
/// front.
const PATHS_OF_RARE_LAMP: u32 = 1 << 16;
/// Light paths after which a lamp is out of view if none has arrived.
const PATHS_OF_UNSEEN_LAMP: u32 = 1 << 14;
/// Arrivals on the film that are enough for the distribution of a lamp's entry points.
const ENOUGH_ARRIVALS: u32 = 32;
/// Largest number of lights that are surveyed.
const MAX_LIGHTS: usize = 512;
/// Largest share of the picture of a lamp which is worth light paths.
const LARGEST: f64 = 0.02;
/// Smallest brightness of the lamp's image, relative to the mean of the picture.
const BRIGHTEST: f64 = 10.0;

impl LampImages {
    /// Returns how many lamps and skies there are, in words.
    pub(crate) fn describe(&self, scene: &Scene) -> String {
        let is_sky = |lamp: &&Lamp| scene.lights.skies.contains(&lamp.light);
        let skies = match self.lamps.iter().filter(is_sky).count() {
            0 => "",
            1 => "a sky",
            _ => "skies",
        };
        let shapes = match self.lamps.iter().filter(|lamp| !is_sky(lamp)).count() {
            0 => String::new(),
            1 => "one lamp".to_owned(),
            count => format!("{count} lamps"),
        };
        let and = if skies.is_empty() || shapes.is_empty() { "" } else { " and " };
        format!("{shapes}{and}{skies} in view")
    }
}

/// Surveys the lamps of a picture. Returns why there are none that are worth light paths.
pub(crate) fn survey(picture: &SurveyedPicture<'_>) -> Result<LampImages, &'static str> {
    let SurveyedPicture { input, lens, selection, .. } = *picture;
    let skies: Vec<u32> = match input.hides_sky {
        true => Vec::new(),
        false => input.scene.lights.sampled_skies().collect(),
    };
    let shapes = input.scene.area_lights();
    if skies.is_empty() && shapes.is_empty() {
        return Err("no surface and no image of a sky emits light");
    }
    let view = picture.view()?;
    let lights: Vec<u32> = skies
        .iter()
        .copied()
        .chain(shapes)
        .filter(|&light| {
            matches!(selection, LightPathSelection::All) || view.share(light) <= LARGEST
        })
        .take(MAX_LIGHTS)
        .collect();
    let share = LIGHT_PATHS / lights.len().max(1) as u32;
    let [fewest, most] = PATHS_PER_LAMP;
    let paths = [share.clamp(fewest, most), share.clamp(fewest, PATHS_OF_RARE_LAMP)];
    let mut all =
        LampImages::new(lens, EntrySquare { half: view.half }, input.scene.lights.all.len());
    let film_area = input.camera.film[0] * input.camera.film[1];
    let (mut found, mut variance) = (Vec::new(), 0.0);
    for light in lights {
        let areas = input.scene.emitter_areas(light);
        let Some(lamp) = Lamp::seen_everywhere(light, &areas) else { continue };
        all.set_lamps(vec![(lamp.clone(), 1.0)]);
        let image = LampImage::trace(&all, picture, paths);
        // A lamp of value v on a share s of the film has the mean v s and the variance v^2 s.
        let value = view.exposure * image.radiance;
        let mean_value = input.camera.imaging_ratio * image.flux / film_area;
        let small_and_bright = match selection {
            LightPathSelection::All => true,
            LightPathSelection::Noisy { mean } => {
                mean_value <= LARGEST * value && value >= BRIGHTEST * mean
            }
        };
        let taken = small_and_bright && image.is_lit();
        if let (true, Some(entry)) = (taken, entry_distribution(&image.entry)) {
            variance += value * mean_value;
            // The root gives faint lamps more paths than their light alone.
            found.push((Lamp { entry, ..lamp }, image.flux.sqrt()));
        }
    }
    match selection {
        LightPathSelection::All if found.is_empty() => Err("no lamp is in view"),
        LightPathSelection::Noisy { .. } if found.is_empty() => {
            Err("no lamp in view is small and bright enough")
        }
        _ if !selection.includes(variance) => Err("the lamps in view add little noise"),
        _ => Ok(()),
    }?;
    if input.frame.size() != input.frame.resolution {
        // Dim parts of a sky reach the film from everywhere, but few of the samples come from them.
        for (lamp, _) in found.iter_mut().filter(|(lamp, _)| !skies.contains(&lamp.light)) {
            all.set_lamps(vec![(lamp.clone(), 1.0)]);
            lamp.reach = Some(reach(&all, input, lens, share.clamp(fewest, most)));
        }
    }
    all.set_lamps(found);
    Ok(all)
}

/// Returns where light paths of the only lamp must enter to reach the rendered pixels, by this number
/// of paths.
fn reach(
    light: &LampImages,
    input: &LightPathInput<'_>,
    lens: &RealLens,
    paths: u32,
) -> EntryReach {
    let mut columns = LampColumns::default();
    let mut bounds = ArrivalBounds::new();
    let key = pixel_key(light.lamps[0].light, u32::MAX - 7, input.seed);
    for wave in 0..paths.div_ceil(WAVE_SIZE as u32) {
        light.sample(input, lens, &mut columns, key, wave);
        let band = input.band_of_wave(wave);
        light.front.trace::<f32x8>(lens, band, &mut columns.paths);
        for i in 0..columns.paths.len() {
            if let Some(hit) = columns.paths.film_hit(i) {
                bounds.add(input, columns.paths.entry(i), hit.point);
            }
        }
    }
    bounds.reach(input)
}

/// Image of one lamp, estimated by light paths.
struct LampImage {
    /// Light on the film, as luminance times mm^2 sr.
    flux: f64,
    /// Mean luminance of the lamp where its light on the film comes from.
    radiance: f64,
    /// Number of arrivals on the film, by cell of the entry points.
    entry: Vec<u32>,
}

impl LampImage {
    /// Returns whether any light arrived, and not more than can be summed.
    fn is_lit(&self) -> bool {
        self.flux > 0.0 && self.flux.is_finite()
    }

    /// Traces the first number of light paths, and up to the second if few arrive, but some do.
    fn trace(light: &LampImages, picture: &SurveyedPicture<'_>, [paths, most]: [u32; 2]) -> Self {
        let mut columns = LampColumns::default();
        let mut image = Self { flux: 0.0, radiance: 0.0, entry: vec![0; ENTRY_GRID.cells()] };
        let key = pixel_key(light.lamps[0].light, u32::MAX - 3, picture.input.seed);
        let (mut arrived, mut traced) = (0, 0);
        for wave in 0..most / WAVE_SIZE as u32 {
            let seen = traced >= paths && arrived >= ENOUGH_ARRIVALS;
            if seen || (traced >= PATHS_OF_UNSEEN_LAMP && arrived == 0) {
                break;
            }
            traced += WAVE_SIZE as u32;
            light.sample(picture.input, picture.lens, &mut columns, key, wave);
            for i in picture.arrivals(&light.front, wave, &mut columns.paths) {
                let flux = f64::from(luminance(columns.paths.flux(i)));
                if flux > 0.0 {
                    image.flux += flux;
                    image.radiance += flux * columns.luminances[i];
                    arrived += 1;
                    image.entry[ENTRY_GRID.cell(columns.paths.entry(i))] += 1;
                }
            }
        }
        image.radiance /= image.flux.max(f64::MIN_POSITIVE);
        image.flux /= f64::from(traced);
        image
    }
}
