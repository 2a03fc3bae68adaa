//! Spectra of a measured surface, and its colours at the wavelengths of a path.

use std::sync::{Arc, OnceLock};

use petzval_spectrum::{
    BandSpectrum, WAVELENGTH_SETS, WAVELENGTHS_PER_PATH, band_shares, bands_of_set,
    daylight_weights,
};

use super::warp::Grid;

/// Reflection by wavelength over the points of a surface's table.
#[derive(Debug)]
pub(super) struct MeasuredSpectra {
    /// Ascending wavelengths (nm), the channels of the grid.
    wavelengths: Vec<f64>,
    grid: Grid,
    /// By set, made when they are first asked for.
    in_sets: [OnceLock<Arc<Grid>>; WAVELENGTH_SETS],
}

impl MeasuredSpectra {
    pub fn new(wavelengths: &[f32], grid: Grid) -> Self {
        let wavelengths = wavelengths.iter().map(|&nm| f64::from(nm)).collect();
        Self { wavelengths, grid, in_sets: [const { OnceLock::new() }; WAVELENGTH_SETS] }
    }

    /// Returns linear sRGB, illuminated by daylight (D65).
    pub fn to_srgb(&self) -> Grid {
        let weights = daylight_weights(&self.wavelengths);
        let of = |channel: usize| {
            let terms = weights.iter().enumerate();
            terms.map(|(i, weight)| (i, weight[channel])).collect::<Vec<_>>()
        };
        self.grid.mixed(&[0, 1, 2].map(of))
    }

    /// Returns the values at the wavelengths of a set.
    pub fn in_set(&self, set: usize) -> Arc<Grid> {
        let make = || {
            let shares = band_shares(&self.wavelengths);
            Arc::new(self.grid.mixed(&bands_of_set(set).map(|band| shares[band].clone())))
        };
        self.in_sets[set].get_or_init(make).clone()
    }

    /// Returns the memory that the values at the wavelengths of all sets take (bytes).
    pub fn bytes_of_sets(&self) -> usize {
        let points = self.grid.values.len() / self.wavelengths.len();
        points * WAVELENGTHS_PER_PATH * WAVELENGTH_SETS * size_of::<f32>()
    }

    /// Returns the mean spectrum of all points.
    pub fn mean(&self) -> BandSpectrum {
        let points = self.grid.size[0] * self.grid.size[1];
        let mut sums = vec![0.0f64; self.wavelengths.len()];
        for (i, plane) in self.grid.values.chunks_exact(points).enumerate() {
            let sum: f64 = plane.iter().map(|&value| f64::from(value)).sum();
            sums[i % self.wavelengths.len()] += sum;
        }
        let shares = band_shares(&self.wavelengths);
        let slices = (self.grid.values.len() / self.wavelengths.len()) as f64;
        let of_band = |band: usize| {
            let sum: f64 = shares[band].iter().map(|(i, share)| share * sums[*i]).sum();
            (sum / slices) as f32
        };
        BandSpectrum::from_bands(of_band)
    }
}

impl Grid {
    /// Returns a grid whose channels are weighted sums of the channels of this one.
    fn mixed(&self, weights: &[Vec<(usize, f64)>; 3]) -> Self {
        let points = self.size[0] * self.size[1];
        let slices = self.values.chunks_exact(points * self.channels);
        let mut values = Vec::with_capacity(slices.len() * points * weights.len());
        for slice in slices {
            for terms in weights {
                values.extend((0..points).map(|point| {
                    let value = |i: usize| f64::from(slice[i * points + point]);
                    terms.iter().map(|(i, weight)| weight * value(*i)).sum::<f64>() as f32
                }));
            }
        }
        Self {
            channels: weights.len(),
            values,
            size: self.size,
            parameters: self.parameters.clone(),
        }
    }
}
