//! Random numbers of a wave of light paths.

use petzval_base::rays::{Column, WAVE_SIZE};
use petzval_base::sampler::{Dimension, fill_2d};

/// Random numbers of every path of a wave, calculated in vectors.
#[derive(Clone, Debug, Default)]
pub(crate) struct WaveNumbers {
    choice: [Column<f32>; 2],
    entry: [Column<f32>; 2],
    light: [Column<f32>; 2],
}

/// Random numbers of a path, in [0, 1).
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathNumbers {
    /// Numbers that select a light and its triangle.
    pub choice: [f32; 2],
    /// Numbers that select its entry point into the lens.
    pub entry: [f32; 2],
    /// Numbers that select the point on the light.
    pub light: [f32; 2],
}

impl WaveNumbers {
    /// Fills in the numbers of a wave whose paths share a key. `first` is the number of its first path.
    pub fn fill(&mut self, key: u32, first: u32) {
        let (mut keys, mut numbers) = (Column::<u32>::default(), Column::<u32>::default());
        keys.fill(key);
        for (number, i) in numbers.iter_mut().zip(first..) {
            *number = i;
        }
        let Self { choice, entry, light } = self;
        for ([u, v], dimension) in [
            (choice, Dimension::LightChoice(0)),
            (entry, Dimension::Pupil),
            (light, Dimension::Light(0)),
        ] {
            fill_2d(&keys[..WAVE_SIZE], &numbers[..WAVE_SIZE], dimension, &mut u[..], &mut v[..]);
        }
    }

    /// Returns the numbers of a path of the wave.
    #[inline(always)]
    pub fn of_path(&self, i: usize) -> PathNumbers {
        let at = |columns: &[Column<f32>; 2]| [columns[0][i], columns[1][i]];
        PathNumbers { choice: at(&self.choice), entry: at(&self.entry), light: at(&self.light) }
    }
}
