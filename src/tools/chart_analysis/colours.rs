//! Colour errors from a picture of a colour checker.

use std::ops::Range;

use petzval_image::Picture;
use petzval_spectrum::{ciede2000, colour_checker, lab_from_srgb};

use super::luminance;
use super::patches::{PatchError, PatchMean, patch_mean};
use crate::charts::patch_grid::PatchGrid;

/// Grey patches but for white, which may be clipped, and black, which shows stray light.
const GREYS: Range<usize> = 19..23;

/// Why colours cannot be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ColoursError {
    /// A patch cannot be measured.
    #[error(transparent)]
    Patch(#[from] PatchError),
    /// There is no light.
    #[error("its grey patches are black; expected a picture of a colour checker in this region")]
    Black,
}

/// A patch of a photographed colour checker.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchColour {
    /// Name on the chart.
    pub name: &'static str,
    /// Mean of its pixels, linear sRGB.
    pub mean: [f64; 3],
    /// Standard deviation of the luminance of its pixels relative to their mean; 0 without light.
    pub noise: f64,
    /// CIELAB of the mean times the scale; white is D65 of luminance 1.
    pub lab: [f64; 3],
    /// CIELAB of its published reflectance in daylight (D65).
    pub expected: [f64; 3],
}

impl PatchColour {
    /// Returns the colour difference (CIEDE2000).
    pub fn difference(&self) -> f64 {
        ciede2000(self.lab, self.expected)
    }
}

/// Colours of a photographed colour checker.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourPatches {
    /// The patches, row after row.
    pub patches: Vec<PatchColour>,
    /// Factor on the picture by which the luminances of its grey patches, but for white and black, come nearest to those
    /// of the chart, relative to each.
    pub scale: f64,
}

impl ColourPatches {
    /// Measures the patches that fill a region of a picture (pixels): first column and row, and those that no longer
    /// belong to it.
    ///
    /// # Errors
    /// Returns an error if the patches have too few pixels or no finite light.
    pub fn measure(picture: &Picture, region: [[usize; 2]; 2]) -> Result<Self, ColoursError> {
        let region = region.map(|at| at.map(|n| n as f64));
        let mut patches = Vec::new();
        for (i, (name, reflectance)) in colour_checker().enumerate() {
            let PatchMean { mean, deviation } = patch_mean(picture, PatchGrid::COLOURS, region, i)?;
            let light = luminance(mean);
            let noise = if light > 0.0 { deviation / light } else { 0.0 };
            let expected = lab_from_srgb(reflectance.in_daylight());
            patches.push(PatchColour { name, mean, noise, lab: [0.0; 3], expected });
        }
        let scale = scale(&patches).ok_or(ColoursError::Black)?;
        for patch in &mut patches {
            patch.lab = lab_from_srgb(patch.mean.map(|value| scale * value));
        }
        Ok(Self { patches, scale })
    }

    /// Returns the mean colour difference (CIEDE2000).
    pub fn mean_difference(&self) -> f64 {
        self.patches.iter().map(PatchColour::difference).sum::<f64>() / self.patches.len() as f64
    }

    /// Returns the patch with the largest colour difference.
    pub fn worst(&self) -> &PatchColour {
        let of = |patch: &&PatchColour| patch.difference();
        self.patches.iter().max_by(|a, b| of(a).total_cmp(&of(b))).expect("there are patches")
    }

    /// Returns mean a* and b* of the grey patches but for white and black, less those of the chart: 0 for a perfect white
    /// balance.
    pub fn white_balance_error(&self) -> [f64; 2] {
        let greys = &self.patches[GREYS];
        [1, 2].map(|i| {
            greys.iter().map(|patch| patch.lab[i] - patch.expected[i]).sum::<f64>()
                / greys.len() as f64
        })
    }
}

/// Returns the factor by which the luminances of the grey patches come nearest to those of the chart, relative to
/// each.
fn scale(patches: &[PatchColour]) -> Option<f64> {
    let reflectances =
        colour_checker().map(|(_, reflectance)| luminance(reflectance.in_daylight()));
    let ratios = patches.iter().zip(reflectances).skip(GREYS.start).take(GREYS.len());
    let ratios = ratios.map(|(patch, expected)| luminance(patch.mean) / expected);
    let (sum, squares) = ratios.fold((0.0, 0.0), |(sum, squares), r| (sum + r, squares + r * r));
    let factor = sum / squares;
    (factor.is_finite() && factor > 0.0).then_some(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws the chart in a region of 402 x 265.2 pixels.
    fn chart(of: impl Fn([f64; 3]) -> [f64; 3]) -> (Picture, [[usize; 2]; 2]) {
        let (size, region) = ([450, 300], [[20, 10], [422, 275]]);
        let mut picture = Picture { size, pixels: vec![[0.18; 3]; 450 * 300] };
        for (i, (_, reflectance)) in colour_checker().enumerate() {
            let borders =
                PatchGrid::COLOURS.borders(region.map(|at| at.map(|n| n as f64)), i, [0.0, 1.0]);
            let [low, high] = borders.map(|at| at.map(|n| n.round() as usize));
            let colour = of(reflectance.in_daylight()).map(|value| value as f32);
            for y in low[1]..high[1] {
                picture.pixels[y * size[0]..][low[0]..high[0]].fill(colour);
            }
        }
        (picture, region)
    }

    #[test]
    fn colours_of_the_chart_have_no_error_in_any_exposure() {
        for factor in [0.2, 1.0, 3.0] {
            let (picture, region) = chart(|rgb| rgb.map(|value| factor * value));
            let found = ColourPatches::measure(&picture, region).unwrap();
            assert!((found.scale * factor - 1.0).abs() < 1e-5);
            assert!(found.worst().difference() < 1e-3, "{:?}", found.worst());
            assert!(found.white_balance_error().iter().all(|error| error.abs() < 1e-3));
            assert!(found.patches.iter().all(|patch| patch.noise.abs() < 1e-6));
        }
    }

    #[test]
    fn a_wrong_balance_and_a_wrong_patch_are_told() {
        let (picture, region) = chart(|[r, g, b]| [1.1 * r, g, 0.9 * b]);
        let found = ColourPatches::measure(&picture, region).unwrap();
        let [a, b] = found.white_balance_error();
        assert!(a > 0.5 && b > 4.0, "{a} and {b}");
        let (mut picture, region) = chart(|rgb| rgb);
        // The sixth patch, bluish green, becomes white.
        for pixel in picture.pixels.chunks_mut(450).take(60).flat_map(|row| &mut row[366..420]) {
            *pixel = [0.9; 3];
        }
        let found = ColourPatches::measure(&picture, region).unwrap();
        assert_eq!(found.worst().name, "bluish green");
        assert!(found.worst().difference() > 20.0 && found.mean_difference() < 2.0);
    }

    #[test]
    fn pictures_without_a_chart_are_refused() {
        let black = Picture { size: [450, 300], pixels: vec![[0.0; 3]; 450 * 300] };
        assert_eq!(ColourPatches::measure(&black, [[0, 0], [450, 300]]), Err(ColoursError::Black));
        let small = ColourPatches::measure(&black, [[0, 0], [60, 30]]).unwrap_err();
        assert!(small.to_string().contains("about 9 x 7 pixels"), "{small}");
        // Clipped black has neither light nor noise.
        let (dark, region) = chart(|rgb| rgb.map(|value| if value < 0.05 { 0.0 } else { value }));
        let found = ColourPatches::measure(&dark, region).unwrap();
        assert_eq!((found.patches[23].noise, found.patches[23].mean), (0.0, [0.0; 3]));
        assert!((found.scale - 1.0).abs() < 1e-5, "black does not count");
        let (mut picture, region) = chart(|rgb| rgb);
        picture.pixels[30 * 450 + 50][1] = f32::NAN;
        let found = ColourPatches::measure(&picture, region).unwrap_err();
        assert_eq!(
            found.to_string(),
            "the patch in row 1, column 1 has pixels that are not finite"
        );
    }
}
