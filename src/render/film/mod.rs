//! Film: pixels, the positions of their samples, and the sums of the light that they receive.

mod accumulate;
mod dropped;
mod extra_sums;
mod film_sums;
mod hero;
mod response;
mod sample;

pub use accumulate::TileSums;
pub use dropped::{DroppedSamples, SampleId};
pub use extra_sums::ExtraChannels;
pub use film_sums::FilmSums;
pub(crate) use film_sums::clamp_to_f32;
pub(crate) use film_sums::{FilmStrip, Splat};
pub use hero::HeroWeights;
pub use response::Response;
pub use sample::{LightSplit, SpectralSplit, TileSampler, sample};

use std::ops::Range;

use petzval_image::PictureWindow;

/// Pixels of a picture, and the crop window of those that are rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Width and height of the whole picture (pixels).
    pub resolution: [u32; 2],
    /// First pixel that is rendered, (x, y).
    pub low: [u32; 2],
    /// End of the rendered pixels (x, y), exclusive.
    pub high: [u32; 2],
}

/// Usual side of a tile (pixels).
pub const TILE: u32 = 16;

/// A rectangle of pixels that one worker owns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tile {
    /// First pixel, (x, y) in the whole picture.
    pub low: [u32; 2],
    /// Width and height (pixels).
    pub size: [u32; 2],
}

impl Tile {
    /// Returns the pixel (x, y) in the whole picture with this index in the tile.
    pub fn pixel(&self, index: u32) -> [u32; 2] {
        [self.low[0] + index % self.size[0], self.low[1] + index / self.size[0]]
    }

    /// Returns the ranges of the tile's rows in the rendered pixels of a frame.
    fn rows(&self, frame: &Frame) -> impl Iterator<Item = Range<usize>> {
        let row = frame.size()[0] as usize;
        let [x, y] = [0, 1].map(|i| (self.low[i] - frame.low[i]) as usize);
        let [width, height] = self.size.map(|n| n as usize);
        (y..y + height).map(move |y| y * row + x..y * row + x + width)
    }

    /// Copies values of the tile's pixels into values of a frame's rendered pixels.
    pub fn paste<T: Clone>(&self, frame: &Frame, from: &[T], to: &mut [T]) {
        self.paste_columns(frame, from, to, 1);
    }

    /// Copies the values of the tile's pixels out of values of a frame's rendered pixels.
    pub fn cut<T: Clone>(&self, frame: &Frame, from: &[T]) -> Vec<T> {
        self.cut_columns(frame, from, 1)
    }

    /// Does the same as [`Self::paste`] for `count` values of each pixel.
    fn paste_columns<T: Clone>(&self, frame: &Frame, from: &[T], to: &mut [T], count: usize) {
        let width = self.size[0] as usize * count;
        for (i, row) in self.rows(frame).enumerate() {
            let to = &mut to[row.start * count..row.end * count];
            to.clone_from_slice(&from[i * width..(i + 1) * width]);
        }
    }

    /// Does the same as [`Self::cut`] for `count` values of each pixel.
    fn cut_columns<T: Clone>(&self, frame: &Frame, from: &[T], count: usize) -> Vec<T> {
        let rows = self.rows(frame).map(|row| row.start * count..row.end * count);
        rows.flat_map(|row| &from[row]).cloned().collect()
    }
}

impl Frame {
    /// The whole picture.
    pub fn whole(resolution: [u32; 2]) -> Self {
        Self { resolution, low: [0, 0], high: resolution }
    }

    /// Returns the window of the rendered part within the whole picture.
    pub fn window(&self) -> PictureWindow {
        PictureWindow { origin: self.low, frame: self.resolution }
    }

    /// Returns the width and height of the crop window (pixels).
    pub fn size(&self) -> [u32; 2] {
        [self.high[0] - self.low[0], self.high[1] - self.low[1]]
    }

    /// Returns the tiles of at most this width and height that cover the crop window, row by row.
    pub fn tiles(&self, side: u32) -> Vec<Tile> {
        let steps = |axis: usize| (self.low[axis]..self.high[axis]).step_by(side as usize);
        steps(1)
            .flat_map(|y| steps(0).map(move |x| [x, y]))
            .map(|low| Tile { low, size: [0, 1].map(|i| side.min(self.high[i] - low[i])) })
            .collect()
    }
}
