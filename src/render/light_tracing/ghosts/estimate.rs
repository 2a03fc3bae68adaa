//! Estimate of the ghosts in a picture and their brightness, from a few thousand light paths
//! through every pair of surfaces.

use rayon::prelude::*;

use super::trace::sample_wave;
use super::{GhostPair, Ghosts, pairs};
use crate::light_tracing::entry::EntryGrid;
use crate::light_tracing::light_paths::{FilmArrival, LightPathInput, LightPaths};
use petzval_base::distribution::Distribution;
use petzval_base::lanes::f32x8;
use petzval_base::sampler::pixel_key;
use petzval_lens::{
    Coating, LensModel, Prescription, RealLens, Row, Side, ghost_sequence, sequence,
};
use petzval_scene::luminance;
use petzval_spectrum::LightBand;

/// Waves of light paths through every pair.
const WAVES: u32 = 8;
/// Cells of the film, along x and y, over which brightness is averaged.
const CELLS: [usize; 2] = [8, 6];
/// Cells of the film, along x and y, that are lit or not.
const LIT_GRID: [u32; 2] = [64, 64];
/// Fewest arrivals for a reliable estimate of a cell's brightness.
const MIN_ARRIVALS: u32 = 8;
/// Cells of the square about the front surface.
const ENTRY_GRID: EntryGrid = EntryGrid { side: 16 };

/// The estimated ghosts of a scene's lights.
#[derive(Clone, Debug)]
pub struct GhostEstimate {
    /// The lens with its known or assumed coating.
    lens: Prescription,
    /// All pairs through which light arrives on the film, the brightest first.
    pairs: Vec<PairEstimate>,
    /// Largest sum of all ghosts in a cell of the film, as luminance of the picture.
    pub peak: f64,
    /// Largest contribution of a single pair to a cell.
    pair_peak: f64,
    /// Share of the film that light reaches without reflections.
    lit: f64,
}

#[derive(Clone, Debug)]
struct PairEstimate {
    rows: [usize; 2],
    /// Mean over the film, as luminance of the picture.
    mean: f64,
    peak: f64,
    /// Sampling density of the entry points.
    entry: Distribution,
}

/// Brightness and number of arrivals by cell of the film.
struct FilmCells {
    sums: Vec<f64>,
    counts: Vec<u32>,
}

impl FilmCells {
    fn new() -> Self {
        let n = CELLS[0] * CELLS[1];
        Self { sums: vec![0.0; n], counts: vec![0; n] }
    }

    fn add(&mut self, other: &Self) {
        for (sum, other) in self.sums.iter_mut().zip(&other.sums) {
            *sum += other;
        }
        for (count, other) in self.counts.iter_mut().zip(&other.counts) {
            *count += other;
        }
    }

    fn peak(&self) -> f64 {
        let known = self.sums.iter().zip(&self.counts).filter(|(_, count)| **count >= MIN_ARRIVALS);
        known.map(|(&sum, _)| sum).fold(0.0, f64::max)
    }
}

/// Estimates the ghosts of a picture. `None` if the camera has no real lens, or if no light reaches
/// the film by reflections.
///
/// A lens without any known coating is taken to have the assumed one
/// ([`Prescription::assume_coating`]).
pub fn estimate(input: &LightPathInput<'_>) -> Option<GhostEstimate> {
    let LensModel::Real(lens) = &input.camera.model else { return None };
    // A sequence of a pair reflects at its two rows only.
    if lens.prescription.has_mirrors() {
        return None;
    }
    let mut coated = lens.prescription.clone();
    coated.assume_coating();
    let waves = unoccluded_waves(input, lens);
    if waves.is_empty() {
        return None;
    }
    let through_pair = |waves: &mut Vec<Box<LightPaths>>, rows: [usize; 2]| {
        let surfaces = ghost_sequence::<f32>(&coated, rows, coated.design.primary_wavelength());
        let mut cells = FilmCells::new();
        let mut entry = vec![0.0; ENTRY_GRID.cells()];
        for wave_paths in waves {
            if wave_paths.trace::<f32x8>(lens, &surfaces) {
                add_arrivals(input, wave_paths, &mut cells, &mut entry);
            }
        }
        let mean = cells.sums.iter().sum::<f64>() / cells.sums.len() as f64;
        // A light of infinite radiance has no ghost with a finite estimate.
        let entry = entry_distribution(&entry).filter(|_| mean > 0.0 && mean.is_finite())?;
        Some((PairEstimate { rows, mean, peak: cells.peak(), entry }, cells))
    };
    let estimates = pairs(&coated).into_par_iter().map_init(|| waves.clone(), through_pair);
    let (mut seen, cells): (Vec<_>, Vec<_>) = estimates.flatten().unzip();
    let mut all = FilmCells::new();
    cells.iter().for_each(|cells| all.add(cells));
    seen.sort_by(|a, b| b.mean.total_cmp(&a.mean));
    let pair_peak = seen.iter().map(|seen| seen.peak).fold(0.0, f64::max);
    (!seen.is_empty()).then(|| GhostEstimate {
        lens: coated,
        pairs: seen,
        peak: all.peak(),
        pair_peak,
        lit: lit_share(input),
    })
}

/// Returns the share of the film that light reaches without reflections.
fn lit_share(input: &LightPathInput<'_>) -> f64 {
    let [columns, rows] = LIT_GRID;
    let cells = (0..rows).flat_map(|y| (0..columns).map(move |x| [x, y]));
    let sees = |cell: &[u32; 2]| {
        let [low, high] = [0, 1].map(|end| cell.map(|v| f64::from(v + end)));
        input.camera.sees_light(low, high, LIT_GRID)
    };
    let lit = cells.filter(sees).count();
    // Ghosts need paths even if no cell is lit.
    lit.max(1) as f64 / f64::from(columns * rows)
}

/// Returns the waves of light paths that have at least one unoccluded path; occluded paths are
/// discarded.
fn unoccluded_waves(input: &LightPathInput<'_>, lens: &RealLens) -> Vec<Box<LightPaths>> {
    let mut waves = Vec::new();
    let Some(uniform) = (EntryGrid { side: 1 }).density(|_| 1.0) else { return waves };
    for wave in 0..WAVES {
        let mut wave_paths = Box::<LightPaths>::default();
        let key = pixel_key(wave, u32::MAX, input.seed);
        sample_wave(input, lens, key, &uniform, &mut wave_paths);
        wave_paths.connect::<f32x8>(input, 0..wave_paths.len() as u32);
        let mut lit = false;
        for i in 0..wave_paths.len() {
            let arrives = luminance(wave_paths.flux(i)) > 0.0;
            lit |= arrives;
            if !arrives {
                wave_paths.discard(i);
            }
        }
        if lit {
            waves.push(wave_paths);
        }
    }
    waves
}

/// Returns the brightest spot that the lights form on the film by direct light through the lens,
/// however small it is: as the number of pixels of luminance 1 with the same light. A spot is a
/// cell of a grid of 32 by 24.
pub fn direct_peak(input: &LightPathInput<'_>) -> f64 {
    const SPOTS: [usize; 2] = [32, 24];
    let LensModel::Real(lens) = &input.camera.model else { return 0.0 };
    let surfaces = sequence::<f32>(&lens.prescription, Side::Scene(0.0));
    let mut spots = vec![0.0; SPOTS[0] * SPOTS[1]];
    for wave_paths in &mut unoccluded_waves(input, lens) {
        if !wave_paths.trace::<f32x8>(lens, &surfaces) {
            continue;
        }
        for FilmArrival { position, luminance, .. } in wave_paths.arrivals(input.camera.film) {
            let [column, row] = [0, 1].map(|i| (position[i] * SPOTS[i] as f64) as usize);
            spots[row * SPOTS[0] + column] += luminance;
        }
    }
    let pixel = [0, 1].map(|i| input.camera.film[i] / f64::from(input.frame.resolution[i]));
    let paths = f64::from(WAVES) * petzval_base::rays::WAVE_SIZE as f64;
    let scale = input.camera.imaging_ratio / (pixel[0] * pixel[1] * paths);
    scale * spots.into_iter().fold(0.0, f64::max)
}

/// Adds the arrivals on the film to their cells.
fn add_arrivals(
    input: &LightPathInput<'_>,
    wave_paths: &LightPaths,
    cells: &mut FilmCells,
    entry: &mut [f64],
) {
    let film = input.camera.film;
    let area = film[0] * film[1] / (CELLS[0] * CELLS[1]) as f64;
    let paths = f64::from(WAVES) * petzval_base::rays::WAVE_SIZE as f64;
    let scale = input.camera.imaging_ratio / (area * paths);
    for arrival in wave_paths.arrivals(film) {
        let light = arrival.luminance * scale;
        let [column, row] = [0, 1].map(|i| (arrival.position[i] * CELLS[i] as f64) as usize);
        cells.sums[row * CELLS[0] + column] += light;
        cells.counts[row * CELLS[0] + column] += 1;
        entry[ENTRY_GRID.cell(arrival.entry)] += light;
    }
}

impl GhostEstimate {
    /// Returns the number of pairs through which light arrives on the film.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// Returns the pairs worth simulating, and the percentage of light in all others. The pairs are
    /// those that make 99 % of the ghosts' light, and those whose peak is more than a tenth of the
    /// brightest peak.
    fn significant_pairs(&self) -> (Vec<&PairEstimate>, f64) {
        let total: f64 = self.pairs.iter().map(|pair| pair.mean).sum();
        let mut sum = 0.0;
        let mut dropped = 0.0;
        let mut kept = Vec::new();
        for pair in &self.pairs {
            if sum < 0.99 * total || pair.peak > 0.1 * self.pair_peak {
                kept.push(pair);
            } else {
                dropped += pair.mean;
            }
            sum += pair.mean;
        }
        (kept, 100.0 * dropped / total)
    }

    /// Returns the number of pairs worth simulating, and the percentage of light in all others.
    pub fn significant(&self) -> (usize, f64) {
        let (kept, dropped) = self.significant_pairs();
        (kept.len(), dropped)
    }

    /// Returns the ghosts of the pairs worth simulating. Light is split into bands if the lens does
    /// so, or if a coating has a colour: for paths that carry spectra into
    /// [`lens_bands`](petzval_spectrum::lens_bands).
    pub fn ghosts(&self, lens: &RealLens, bands: &[LightBand]) -> Ghosts {
        self.make_ghosts(lens, bands, self.significant_pairs().0)
    }

    /// Returns the ghosts of all pairs.
    pub fn ghosts_of_all_pairs(&self, lens: &RealLens, bands: &[LightBand]) -> Ghosts {
        self.make_ghosts(lens, bands, self.pairs.iter().collect())
    }

    fn make_ghosts(
        &self,
        lens: &RealLens,
        bands: &[LightBand],
        kept: Vec<&PairEstimate>,
    ) -> Ghosts {
        let rows = &self.lens.rows;
        let is_coloured = |row: &Row| {
            row.glass.absorbs() || row.coating.as_ref().is_some_and(Coating::is_coloured)
        };
        let coloured = lens.bands.len() > 1 || rows.iter().any(is_coloured);
        let wavelength = self.lens.design.primary_wavelength();
        let whole = LightBand { wavelength, response: [1.0; 3] };
        let bands = if coloured { bands.to_vec() } else { vec![whole] };
        let total: f64 = kept.iter().map(|seen| seen.mean).sum();
        let count = kept.len() as f64;
        let pair = |seen: &&PairEstimate| GhostPair {
            rows: seen.rows,
            share: 0.9 * seen.mean / total + 0.1 / count,
            entry: seen.entry.clone(),
        };
        Ghosts {
            pairs: kept.iter().map(pair).collect(),
            lens: self.lens.clone(),
            lit: self.lit,
            bands,
        }
    }
}

/// Returns a sampling density that is large in and next to the cells through which light came. It
/// is nowhere 0 within the square, so that unseen paths are rare but not impossible.
fn entry_distribution(entry: &[f64]) -> Option<Distribution> {
    let total: f64 = entry.iter().sum();
    let weight = |cell: usize| {
        let sum: f64 = ENTRY_GRID.around(cell).map(|i| entry[i]).sum();
        // The root raises the density of cells that few paths found.
        sum.sqrt() + 0.02 * total.sqrt()
    };
    ENTRY_GRID.density(weight)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::prepare::{Changes, prepare};
    use petzval_scene_formats::pbrt;

    #[test]
    fn the_lit_share_of_a_film_is_that_of_the_pixels_with_samples() {
        for (scene, range) in [("fisheye", 0.2..0.3), ("dgauss", 0.85..1.0), ("wide", 0.8..0.9)] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
            let description = pbrt::read(&path.join(format!("{scene}.pbrt"))).expect("a scene");
            let changes =
                Changes { effects: "none".parse().expect("effects"), ..Changes::default() };
            let job = prepare(description, &changes).expect("a job").job;
            let share = lit_share(&job.light_path_input());
            assert!(range.contains(&share), "{scene}: {share}");
            let samples: u64 = job.tiles().iter().map(|tile| job.sampler(tile, 0..1).count()).sum();
            let [width, height] = job.frame.resolution;
            let pixels = samples as f64 / f64::from(width * height);
            // A cell of the rim counts as lit as a whole.
            assert!(
                (-0.01..0.06).contains(&(share - pixels)),
                "{scene}: {share}, {pixels} of pixels"
            );
        }
    }
}
