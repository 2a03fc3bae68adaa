//! Which ghosts a lens makes of a scene's lights, and how bright: a few thousand light paths
//! through every pair.

use super::photons::Photons;
use super::{Ghosts, Pair, pairs, sequences};
use crate::distribution::Distribution;
use crate::lanes::f32x8;
use crate::lens::{Coating, D_LINE, From, Model, Prescription, RealLens, ghost_sequence, sequence};
use crate::render::Job;
use crate::sampler::pixel_key;
use crate::scene::luminance;
use crate::spectrum::LightBand;

/// Waves of light paths that are sent through every pair.
const WAVES: u32 = 8;
/// Cells of the film, along and across, over which brightness is averaged.
const CELLS: [usize; 2] = [8, 6];
/// Arrivals from which on the brightness of a cell is believed.
const FEW: u32 = 8;
/// Cells of the square about the front surface, along each side.
const ENTRY: usize = 16;

/// What ghosts a lens makes of a scene's lights.
#[derive(Clone, Debug)]
pub struct Sighting {
    /// The lens, coated.
    lens: Prescription,
    /// Whether its coating is known.
    pub coated: bool,
    /// All pairs through which light came to the film, the brightest first.
    seen: Vec<Seen>,
    /// The most that all together add to a cell of the film, as luminance of the picture.
    pub peak: f64,
    /// The most that a pair adds to a cell.
    pair_peak: f64,
}

#[derive(Clone, Debug)]
struct Seen {
    rows: [usize; 2],
    /// Over the film, as luminance of the picture.
    mean: f64,
    peak: f64,
    entry: Vec<f64>,
}

/// Brightness by cell of the film, and how many paths made it.
struct Cells {
    sums: Vec<f64>,
    counts: Vec<u32>,
}

impl Cells {
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
        let known = self.sums.iter().zip(&self.counts).filter(|(_, count)| **count >= FEW);
        known.map(|(&sum, _)| sum).fold(0.0, f64::max)
    }
}

/// Looks for ghosts. A lens of which no coating is known is taken to have a layer of magnesium
/// fluoride everywhere, as nearly all lenses since the middle of the twentieth century. `None` where the camera has no lens of glass, or no light comes to the film
/// that way.
pub fn survey(job: &Job) -> Option<Sighting> {
    let Model::Real(lens) = &job.camera.model else { return None };
    let mut coated = lens.prescription.clone();
    let known = coated.rows.iter().any(|row| row.coating.is_some());
    if !known {
        coated.coat(Coating::Mgf2);
    }
    let mut waves = lit(job, lens);
    if waves.is_empty() {
        return None;
    }
    let mut all = Cells::new();
    let mut seen = Vec::new();
    for rows in pairs(&coated) {
        let surfaces = ghost_sequence::<f32>(&coated, rows, D_LINE);
        let mut cells = Cells::new();
        let mut entry = vec![0.0; ENTRY * ENTRY];
        for photons in &mut waves {
            if photons.through::<f32x8>(lens, &surfaces) {
                gather(job, photons, &mut cells, &mut entry);
            }
        }
        let mean = cells.sums.iter().sum::<f64>() / cells.sums.len() as f64;
        // A lamp beyond all numbers makes no ghost that could be told.
        if mean > 0.0 && mean.is_finite() {
            seen.push(Seen { rows, mean, peak: cells.peak(), entry });
            all.add(&cells);
        }
    }
    seen.sort_by(|a, b| b.mean.total_cmp(&a.mean));
    let pair_peak = seen.iter().map(|seen| seen.peak).fold(0.0, f64::max);
    (!seen.is_empty()).then(|| Sighting {
        lens: coated,
        coated: known,
        seen,
        peak: all.peak(),
        pair_peak,
    })
}

/// Waves of light paths that nothing in the scene stands in the way of.
fn lit(job: &Job, lens: &RealLens) -> Vec<Box<Photons>> {
    let mut waves = Vec::new();
    for wave in 0..WAVES {
        let mut photons = Box::<Photons>::default();
        photons.sample(job, lens, pixel_key(wave, u32::MAX, job.seed), None);
        photons.connect::<f32x8>(job, 0..photons.len() as u32);
        let mut lit = false;
        for i in 0..photons.len() {
            let arrives = luminance(photons.arrived(i)) > 0.0;
            lit |= arrives;
            if !arrives {
                // What the scene stands in the way of goes no further.
                photons.block(i);
            }
        }
        if lit {
            waves.push(photons);
        }
    }
    waves
}

/// The brightest spot that lamps make on the film by the straight way through the lens, however
/// small it is: as light of so many pixels of luminance 1. A spot is a cell of a grid of 32 by 24.
pub fn lamp(job: &Job) -> f64 {
    const SPOTS: [usize; 2] = [32, 24];
    let Model::Real(lens) = &job.camera.model else { return 0.0 };
    let surfaces = sequence::<f32>(&lens.prescription, From::Scene(0.0));
    let mut spots = vec![0.0; SPOTS[0] * SPOTS[1]];
    for photons in &mut lit(job, lens) {
        if !photons.through::<f32x8>(lens, &surfaces) {
            continue;
        }
        for (place, light, _) in photons.seen(job.camera.film) {
            let [column, row] = [0, 1].map(|i| (place[i] * SPOTS[i] as f64) as usize);
            spots[row * SPOTS[0] + column] += light;
        }
    }
    let pixel = [0, 1].map(|i| job.camera.film[i] / f64::from(job.frame.resolution[i]));
    let paths = f64::from(WAVES) * crate::rays::WAVE as f64;
    let scale = job.camera.imaging_ratio / (pixel[0] * pixel[1] * paths);
    scale * spots.into_iter().fold(0.0, f64::max)
}

/// Adds what arrives on the film.
fn gather(job: &Job, photons: &Photons, cells: &mut Cells, entry: &mut [f64]) {
    let film = job.camera.film;
    let area = film[0] * film[1] / (CELLS[0] * CELLS[1]) as f64;
    let paths = f64::from(WAVES) * crate::rays::WAVE as f64;
    let scale = job.camera.imaging_ratio / (area * paths);
    for (place, light, entered) in photons.seen(film) {
        let light = light * scale;
        let [column, row] = [0, 1].map(|i| (place[i] * CELLS[i] as f64) as usize);
        cells.sums[row * CELLS[0] + column] += light;
        cells.counts[row * CELLS[0] + column] += 1;
        let [u, v] = entered.map(|u| ((u * ENTRY as f32) as usize).min(ENTRY - 1));
        entry[v * ENTRY + u] += light;
    }
}

impl Sighting {
    /// How many pairs let light through to the film.
    pub fn pairs(&self) -> usize {
        self.seen.len()
    }

    /// The pairs worth simulating: those that make 99 % of the ghosts' light, and those that are
    /// at least a tenth as bright somewhere as the brightest. Also the share of light, in
    /// percent, of those that are left out.
    fn worth(&self) -> (Vec<&Seen>, f64) {
        let total: f64 = self.seen.iter().map(|seen| seen.mean).sum();
        let mut sum = 0.0;
        let mut dropped = 0.0;
        let mut kept = Vec::new();
        for seen in &self.seen {
            if sum < 0.99 * total || seen.peak > 0.1 * self.pair_peak {
                kept.push(seen);
            } else {
                dropped += seen.mean;
            }
            sum += seen.mean;
        }
        (kept, 100.0 * dropped / total)
    }

    /// How many pairs are worth simulating, and the percentage of light of all others.
    pub fn kept(&self) -> (usize, f64) {
        let (kept, dropped) = self.worth();
        (kept.len(), dropped)
    }

    /// Makes the pairs ready that are worth it. Light is taken apart into bands if the lens does
    /// so, or if a coating has a colour.
    pub fn ghosts(&self, lens: &RealLens, bands: &[LightBand]) -> Ghosts {
        self.prepare(lens, bands, self.worth().0)
    }

    /// Makes all pairs ready, for tests and for whoever wants them.
    pub fn all(&self, lens: &RealLens, bands: &[LightBand]) -> Ghosts {
        self.prepare(lens, bands, self.seen.iter().collect())
    }

    fn prepare(&self, lens: &RealLens, bands: &[LightBand], kept: Vec<&Seen>) -> Ghosts {
        let rows = &self.lens.rows;
        let coloured =
            lens.bands.len() > 1 || rows.iter().any(|row| row.coating == Some(Coating::Mgf2));
        let whole = [LightBand { wavelength: D_LINE, response: [1.0; 3] }];
        let bands = if coloured { bands } else { &whole };
        let total: f64 = kept.iter().map(|seen| seen.mean).sum();
        let count = kept.len() as f64;
        let pair = |seen: &&Seen| Pair {
            rows: seen.rows,
            share: 0.9 * seen.mean / total + 0.1 / count,
            entry: spread(&seen.entry),
            bands: sequences(&self.lens, seen.rows, bands),
        };
        Ghosts { pairs: kept.iter().map(pair).collect() }
    }
}

/// A density that is large where light came through, there and in the cells beside, and nowhere 0
/// within the front surface's square: what was not seen is rare, but not forgotten.
fn spread(entry: &[f64]) -> Distribution {
    let total: f64 = entry.iter().sum();
    let near = |i: usize| i.saturating_sub(1)..(i + 2).min(ENTRY);
    let weight = |x: usize, y: usize| {
        let sum: f64 = near(y).flat_map(|y| near(x).map(move |x| entry[y * ENTRY + x])).sum();
        // The root: cells that few paths found deserve more than their share.
        sum.sqrt() + 0.02 * total.sqrt()
    };
    Distribution::new([ENTRY; 2], weight).expect("light came through somewhere")
}
