//! The film: which pixels there are, where their samples lie, and what they have received.

mod accumulate;
mod colours;
mod dropped;
pub mod filter;
mod response;
mod sample;

pub(crate) use accumulate::single;
pub use accumulate::{FilmSums, TileSums};
pub use colours::Colours;
pub use dropped::{Dropped, SampleName};
pub use filter::Filter;
pub use response::Response;
pub use sample::{TileSampler, sample};

use std::ops::Range;

/// The picture's pixels and the part of them that is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Width and height of the whole picture.
    pub resolution: [u32; 2],
    /// First pixel that is rendered.
    pub low: [u32; 2],
    /// First pixel that is not rendered any more.
    pub high: [u32; 2],
}

/// Side of a tile, pixels.
const TILE: u32 = 16;

/// A square of pixels that one worker owns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tile {
    /// First pixel.
    pub low: [u32; 2],
    /// Width and height.
    pub size: [u32; 2],
}

impl Tile {
    /// The pixel, x and y in the whole picture, with this index in the tile.
    pub fn pixel(&self, index: u32) -> [u32; 2] {
        [self.low[0] + index % self.size[0], self.low[1] + index / self.size[0]]
    }

    /// Where its rows of pixels lie in the part of a frame that is rendered.
    fn rows(&self, frame: &Frame) -> impl Iterator<Item = Range<usize>> {
        let row = frame.size()[0] as usize;
        let [x, y] = [0, 1].map(|i| (self.low[i] - frame.low[i]) as usize);
        let [width, height] = self.size.map(|n| n as usize);
        (y..y + height).map(move |y| y * row + x..y * row + x + width)
    }

    /// Copies values of its pixels to where they lie in the part of a frame that is rendered.
    pub fn paste<T: Copy>(&self, frame: &Frame, from: &[T], to: &mut [T]) {
        for (row, pixels) in self.rows(frame).zip(from.chunks_exact(self.size[0] as usize)) {
            to[row].copy_from_slice(pixels);
        }
    }

    /// Copies the values of its pixels out of the part of a frame that is rendered.
    pub fn cut<T: Copy>(&self, frame: &Frame, from: &[T]) -> Vec<T> {
        self.rows(frame).flat_map(|row| &from[row]).copied().collect()
    }
}

impl Frame {
    /// The whole picture.
    pub fn whole(resolution: [u32; 2]) -> Self {
        Self { resolution, low: [0, 0], high: resolution }
    }

    /// Width and height of the part that is rendered.
    pub fn size(&self) -> [u32; 2] {
        [self.high[0] - self.low[0], self.high[1] - self.low[1]]
    }

    /// The tiles that cover it, row by row.
    pub fn tiles(&self) -> Vec<Tile> {
        let steps = |axis: usize| (self.low[axis]..self.high[axis]).step_by(TILE as usize);
        steps(1)
            .flat_map(|y| steps(0).map(move |x| [x, y]))
            .map(|low| Tile { low, size: [0, 1].map(|i| TILE.min(self.high[i] - low[i])) })
            .collect()
    }
}
