//! Strategies of light tracing: where paths start, how they reach the lens, and their weights.

use super::caustics::{CausticColumns, Caustics};
use super::ghosts::Ghosts;
use super::lamp_images::{LampColumns, LampImages};
use super::light_paths::{FrontEntry, LightPathInput, LightPaths, Splat};
use crate::film::{Frame, PixelFilter};
use crate::lanes::Real;
use crate::lens::RealLens;
use crate::rays::WAVE_SIZE;

/// A kind of light paths, for light that camera paths hardly ever find.
#[derive(Clone, Copy, Debug)]
pub enum Strategy<'a> {
    /// Paths from a lamp or a sky straight to the lens, weighed against camera paths.
    LampImages(&'a LampImages),
    /// Paths from a lamp by mirrors or clear glass to a surface that is connected to the lens. Their
    /// weight is 1, as camera paths leave them out.
    Caustics(&'a Caustics),
    /// Paths from a light by two reflections inside the lens. Their weight is 1, as there are no such
    /// camera paths.
    Ghosts(&'a Ghosts),
}

/// Columns of one worker, made when a strategy first needs them.
#[derive(Default)]
pub(super) struct StrategyColumns {
    lamps: Option<Box<LampColumns>>,
    caustics: Option<Box<CausticColumns>>,
    ghosts: Option<Box<LightPaths>>,
}

impl Strategy<'_> {
    /// Returns the number of waves of a sample number: none in a crop that no light can reach.
    pub(super) fn waves(self, frame: &Frame) -> u32 {
        match self {
            Self::LampImages(lamps) if !lamps.reaches_pixels() => 0,
            Self::LampImages(lamps) => lamps.path_count(frame).waves,
            Self::Caustics(caustics) => caustics.path_count(frame).waves,
            Self::Ghosts(ghosts) => ghosts.path_count(frame).waves,
        }
    }

    /// Traces a wave of a sample number, given as `[wave, sample]`, and returns its splats. They depend
    /// on these numbers and the seed only.
    pub(super) fn trace<R: Real<Scalar = f32>>(
        self,
        input: &LightPathInput<'_>,
        lens: &RealLens,
        columns: &mut StrategyColumns,
        wave: [u32; 2],
    ) -> Vec<Splat> {
        let StrategyColumns { lamps, caustics, ghosts } = columns;
        match self {
            Self::LampImages(of) => of.trace::<R>(input, lens, lamps.get_or_insert_default(), wave),
            Self::Caustics(of) => {
                of.trace::<R>(input, lens, caustics.get_or_insert_default(), wave)
            }
            Self::Ghosts(of) => of.trace::<R>(input, lens, ghosts.get_or_insert_default(), wave),
        }
    }

    /// Returns the largest size of the splats of a wave (bytes).
    pub(super) fn wave_bytes(self, filter: &PixelFilter, lens: &RealLens) -> u64 {
        let splats_per_path = match self {
            Self::LampImages(_) | Self::Caustics(_) => {
                let [columns, rows] =
                    filter.margin().map(|margin| (2.0 * margin).ceil() as u64 + 2);
                columns * rows * FrontEntry::bands_per_path(lens)
            }
            Self::Ghosts(_) => Ghosts::BANDS_PER_PATH as u64,
        };
        splats_per_path * (WAVE_SIZE * size_of::<Splat>()) as u64
    }

    /// Returns the size of a worker's columns (bytes).
    pub(super) fn column_bytes(self) -> u64 {
        let bytes = match self {
            Self::LampImages(_) | Self::Ghosts(_) => size_of::<LightPaths>(),
            Self::Caustics(_) => Caustics::COLUMN_BYTES,
        };
        bytes as u64
    }
}
