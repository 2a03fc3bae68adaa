//! The film of a job: its pixels, its response to light, and its layers.

use super::{Changes, PrepareError};
use crate::aov::Aov;
use crate::film::{Frame, Response};
use crate::plan::{DecidedBy, Effect};
use crate::sensor::ColourFilters;
use petzval_lens::LensModel;
use petzval_scene::filter::PixelFilter;
use petzval_scene_formats::pbrt::{FilmSpec, FilterSpec};
use petzval_spectrum::{Buckets, white_balance};

/// Largest number of pixels of one render. Larger pictures are rendered in parts.
const MAX_PIXELS: u64 = 1 << 27;

/// Returns the pixels of the picture and the part of them that is rendered.
///
/// # Errors
/// Returns an error if the crop is empty or outside the picture, or the part is too large.
pub(super) fn frame(film: &FilmSpec, changes: &Changes) -> Result<Frame, PrepareError> {
    let resolution = changes.resolution.unwrap_or(film.resolution);
    // The crop of a scene file counts in that file's pixels. It keeps its share of the picture.
    let scaled = |pixel: [u32; 2]| {
        [0, 1].map(|i| {
            let share = f64::from(pixel[i]) / f64::from(film.resolution[i]);
            (share * f64::from(resolution[i])).round() as u32
        })
    };
    let [low, high] = changes.crop.unwrap_or(film.bounds.map(scaled));
    let inside = (0..2).all(|i| low[i] < high[i] && high[i] <= resolution[i]);
    if !inside {
        return Err(PrepareError::Request(format!(
            "the crop {},{},{},{} leaves nothing of a picture of {} x {} pixels; \
             it reads X0,Y0,X1,Y1 with X1 and Y1 not included",
            low[0], low[1], high[0], high[1], resolution[0], resolution[1]
        )));
    }
    let pixels = u64::from(high[0] - low[0]) * u64::from(high[1] - low[1]);
    if pixels > MAX_PIXELS {
        return Err(PrepareError::Request(format!(
            "a picture of {pixels} pixels is too large; render it in parts of at most {MAX_PIXELS} \
             pixels with 'crop'"
        )));
    }
    Ok(Frame { resolution, low, high })
}

/// Returns the pixel filter and the colour response.
pub(super) fn response(filter: &FilterSpec, film: &FilmSpec, changes: &Changes) -> Response {
    let white = film.white_balance;
    let camera = film.camera_sensor.as_ref();
    let sensor = camera.map(|sensor| sensor.response(white, film.colour_space));
    let colour = match &sensor {
        Some(sensor) => Some(sensor.to_srgb()),
        None => white.map(|kelvin| white_balance(kelvin, film.colour_space)),
    };
    // A passband leaves no colours, so photosites have no filters either.
    let filters = match (&sensor, changes.passband) {
        (Some(sensor), None) => {
            let picture_from_raw = sensor.to_srgb() * sensor.from_srgb.inverse();
            Some(ColourFilters::new(picture_from_raw, film.colour_space.light([1.0; 3])))
        }
        _ => None,
    };
    Response {
        filter: PixelFilter::new(filter.profile, filter.radius),
        max_component: film.max_component,
        camera: film.camera_sensor.clone(),
        sensor_from_srgb: sensor.map(|sensor| sensor.from_srgb),
        colour: match (changes.passband.map(|passband| passband.grey()), colour) {
            // A passband turns the colours grey.
            (Some(grey), Some(colour)) => Some(grey * colour),
            (grey, colour) => grey.or(colour),
        },
        filters,
        rgb_from_set: None,
        buckets: None,
    }
}

/// Returns the buckets of wavelength that the user or the scene file asks for, and which of them does.
///
/// # Errors
/// Returns an error if the user excludes what buckets need.
pub(super) fn buckets(
    film: &FilmSpec,
    changes: &Changes,
) -> Result<Option<(Buckets, DecidedBy)>, PrepareError> {
    let asked = match changes.buckets {
        Some(asked) => asked.map(|buckets| (buckets, DecidedBy::Flag)),
        None => film.buckets.map(|buckets| (buckets, DecidedBy::Scene)),
    };
    let Some((buckets, by)) = asked else { return Ok(None) };
    let problem = if changes.passband.is_some() {
        "a film with 'passband' sees one colour"
    } else if changes.effects.of(Effect::Spectra) == Some(false) {
        "'effects' turns spectra off, without which light has no wavelengths"
    } else {
        return Ok(asked);
    };
    let (count, [first, last]) = (buckets.count(), buckets.range());
    Err(PrepareError::Request(match by {
        DecidedBy::Flag => format!("'buckets' {count}@{first}..{last}: {problem}"),
        _ => format!(
            "the film of the scene has {count} buckets of wavelength, and {problem}; with 'buckets' none \
             it is an RGB film"
        ),
    }))
}

/// Returns the distance from pixel to pixel (mm).
pub(super) fn pixel_pitch(
    model: &LensModel,
    film: &FilmSpec,
    film_size: [f64; 2],
    resolution: [u32; 2],
) -> f64 {
    let [width, height] = resolution.map(f64::from);
    match model {
        LensModel::Real(_) => film_size[0] / width,
        // The film size of other cameras is not in mm.
        _ => film.diagonal / width.hypot(height),
    }
}

/// Returns the layers that the command line or a film of type "gbuffer" asks for, without duplicates.
pub(super) fn layers(film: &FilmSpec, changes: &Changes) -> Vec<Aov> {
    let from_film: &[Aov] = match film.gbuffer && changes.holds_layers {
        true => &[Aov::Depth, Aov::Position, Aov::Normal, Aov::Albedo, Aov::Variance],
        false => &[],
    };
    let mut layers = Vec::new();
    for &aov in changes.layers.iter().chain(from_film) {
        if !layers.contains(&aov) {
            layers.push(aov);
        }
    }
    layers
}
