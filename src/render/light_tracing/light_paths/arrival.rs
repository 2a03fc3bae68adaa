//! Arrival of light paths on the film: in which pixels and bands, and with which weight.
//!
//! A path is traced in all bands that share a camera ray (hero wavelengths,
//! [`HeroWeights`](crate::film::HeroWeights)), and arrives at a film point p_k in each. Let g_k be
//! the filter of a pixel at p_k times the transmission of the lens. A camera ray along the path may
//! come from every p_h, with the probability |g_h| / sum |g_k|. If it takes the share c_h of the light
//! then, light paths take in this pixel and in every band the share
//!
//! ```text
//! sum_h |g_h| (1 - c_h) / sum_k |g_k|
//! ```
//!
//! The shares 1 - c_h come from the density of the camera rays of p_h. No band needs another.

use super::LightPathInput;
use super::front::FrontEntry;
use super::path_count::PathCount;
use super::wave::{FilmHit, LightPaths};
use super::wave_light::PathBand;
use crate::film::Splat;
use petzval_base::lanes::Real;
use petzval_lens::RealLens;
use petzval_scene::luminance;

/// A path that arrives near the rendered pixels in one of its bands.
struct Arrival {
    /// Index of the path.
    path: usize,
    /// Weights of the band in the channels of the path.
    weights: [f64; 3],
    hit: FilmHit,
    /// Position in the whole picture (pixels).
    at: [f64; 2],
}

/// Light of a path in one band and one pixel.
struct PixelLight {
    pixel: [i64; 2],
    /// Index of the arrival.
    arrival: usize,
    /// Filter of the pixel.
    filter: f64,
}

/// Traces a wave of light paths of one sample number to the film, in the bands that share its paths,
/// and adds its splats to `splats`. The sample number has `count` paths, and the wave is of a set of
/// wavelengths. `weight` returns the weight of a path by its index and its arrival on the film.
pub(crate) fn add_splats<R: Real<Scalar = f32>>(
    input: &LightPathInput<'_>,
    (lens, front): (&RealLens, &FrontEntry),
    (count, set, bands): (PathCount, usize, &[PathBand]),
    paths: &mut LightPaths,
    weight: impl Fn(usize, &FilmHit) -> f64,
    splats: &mut Vec<Splat>,
) {
    let mut arrivals = Vec::new();
    for &PathBand { band, weights } in bands {
        front.trace::<R>(lens, band, paths);
        add_arrivals(input, paths, weights, &mut arrivals);
    }
    // Stable: the bands of a path keep their order.
    arrivals.sort_by_key(|arrival| arrival.path);
    paths.connect::<R>(input, arrivals.iter().map(|arrival| arrival.path as u32));
    let scale = count.splat_scale(input);
    let (mut lit, mut weights) = (Vec::new(), Vec::new());
    for of_path in arrivals.chunk_by(|a, b| a.path == b.path) {
        let flux = paths.flux(of_path[0].path);
        if !(luminance(flux) > 0.0 && flux.iter().all(|c| c.is_finite())) {
            continue;
        }
        find_pixels(input, of_path, &mut lit);
        weights.clear();
        weights.extend(of_path.iter().map(|Arrival { path, hit, .. }| weight(*path, hit)));
        for in_pixel in lit.chunk_by(|a, b| a.pixel == b.pixel) {
            let magnitude = |PixelLight { arrival, filter, .. }: &PixelLight| {
                filter.abs() * of_path[*arrival].hit.transmission
            };
            let total: f64 = in_pixel.iter().map(magnitude).sum();
            if total <= 0.0 {
                continue;
            }
            let weight: f64 =
                in_pixel.iter().map(|lit| magnitude(lit) / total * weights[lit.arrival]).sum();
            let pixel = in_pixel[0].pixel.map(|p| p as u32);
            let exposure = input.row_exposure(paths.arrival_time(of_path[0].path), pixel);
            if exposure <= 0.0 {
                continue;
            }
            let mut light = [0.0; 3];
            for PixelLight { arrival, filter, .. } in in_pixel {
                let Arrival { hit, weights, .. } = &of_path[*arrival];
                let factor = hit.transmission * weight * scale;
                for c in 0..3 {
                    light[c] += f64::from(flux[c]) * factor * filter * weights[c] * exposure;
                }
            }
            // Bands of a path that arrive in a pixel come from almost the same direction.
            let left_half = input.is_left_half(lens, &of_path[in_pixel[0].arrival].hit);
            let light = light.map(|c| c as f32);
            splats.push(Splat { pixel, set: set as u16, left_half, light });
        }
    }
}

/// Adds the paths of the last trace that arrive near the rendered pixels.
fn add_arrivals(
    input: &LightPathInput<'_>,
    paths: &LightPaths,
    weights: [f64; 3],
    arrivals: &mut Vec<Arrival>,
) {
    let frame = input.frame;
    let margin = input.response.filter.margin();
    for path in 0..paths.len() {
        let Some(hit) = paths.film_hit(path) else { continue };
        let at = input.film_map().pixel(hit.point);
        let near = (0..2).all(|i| {
            at[i] > f64::from(frame.low[i]) - margin[i]
                && at[i] < f64::from(frame.high[i]) + margin[i]
        });
        if near {
            arrivals.push(Arrival { path, weights, hit, at });
        }
    }
}

/// Finds the rendered pixels that the arrivals of a path light, pixel by pixel.
fn find_pixels(input: &LightPathInput<'_>, of_path: &[Arrival], lit: &mut Vec<PixelLight>) {
    let frame = input.frame;
    lit.clear();
    for (arrival, Arrival { at, .. }) in of_path.iter().enumerate() {
        input.response.filter.pixels_at(*at, |pixel, filter| {
            let inside = (0..2).all(|k| {
                pixel[k] >= i64::from(frame.low[k]) && pixel[k] < i64::from(frame.high[k])
            });
            if inside && filter != 0.0 {
                lit.push(PixelLight { pixel, arrival, filter });
            }
        });
    }
    if of_path.len() > 1 {
        lit.sort_by_key(|lit| [lit.pixel[1], lit.pixel[0]]);
    }
}
