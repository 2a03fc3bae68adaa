//! Number of the light paths of a picture, and the scale of their splats.

use super::LightPathInput;
use petzval_base::rays::WAVE_SIZE;

/// Number of the light paths of a sample number, in whole waves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathCount {
    /// Number of waves.
    pub waves: u32,
}

impl PathCount {
    /// One path for every `samples_per_path` pixels of a picture of this width and height.
    pub fn new(resolution: [u32; 2], samples_per_path: u64) -> Self {
        Self::of_part(resolution, 1.0, samples_per_path)
    }

    /// One path for every `samples_per_path` pixels of a part of a picture of this width and height.
    /// `share` is the part's share of the picture, above 0.
    pub fn of_part([width, height]: [u32; 2], share: f64, samples_per_path: u64) -> Self {
        let pixels = (share * f64::from(width) * f64::from(height)).ceil() as u64;
        Self { waves: pixels.div_ceil(samples_per_path * WAVE_SIZE as u64) as u32 }
    }

    /// Returns the number of paths.
    pub fn paths(self) -> f64 {
        f64::from(self.waves) * WAVE_SIZE as f64
    }

    /// Returns the number of a wave of a sample number, given as `[wave, sample]`, among the waves of
    /// all sample numbers.
    pub fn wave_number(self, [wave, sample]: [u32; 2]) -> u32 {
        sample.wrapping_mul(self.waves).wrapping_add(wave)
    }

    /// Returns the factor from the flux of a path (radiance times mm^2 sr) to the value of the pixel
    /// that receives it.
    pub fn splat_scale(self, input: &LightPathInput<'_>) -> f64 {
        let pitch = input.camera.pixel_pitch(input.frame.resolution);
        // The film divides by the number of samples.
        input.camera.imaging_ratio / (pitch[0] * pitch[1] * self.paths())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_picture_has_its_share_of_the_paths_in_whole_waves() {
        let waves = |resolution, share| PathCount::of_part(resolution, share, 4).waves;
        assert_eq!(waves([400, 300], 1.0), 30);
        assert_eq!(PathCount::new([400, 300], 4).waves, 30);
        assert_eq!(waves([400, 300], 0.25), 8);
        assert_eq!([waves([400, 300], 1e-9), waves([1, 1], 0.1)], [1, 1]);
    }
}
