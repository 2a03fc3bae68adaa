//! Strips and tiles of raw data.

use rayon::prelude::*;

use super::lossless_jpeg;
use super::numbers::Numbers;
use super::tags;

/// The parts in which raw data is stored: strips of whole rows, or tiles.
pub(super) struct Chunks {
    /// Width and height of the raw data (pixels).
    size: [usize; 2],
    /// Width and height of a chunk. Tiles at the right and lower edge are padded to it; the last strip is not.
    chunk: [usize; 2],
    is_tiled: bool,
    /// Place and length of each (bytes).
    places: Vec<[u64; 2]>,
}

fn cut() -> String {
    "its raw data is cut off".to_owned()
}

impl Chunks {
    /// Reads the places of the chunks of a directory.
    ///
    /// # Errors
    /// Returns what was found if there are no strips or tiles, or another number than fill the picture.
    pub fn read(file: &Numbers<'_>, directory: usize, size: [usize; 2]) -> Result<Self, String> {
        let all = |tag| file.entry(directory, tag);
        let side = |tag| -> Result<Option<usize>, String> {
            Ok(file.first(directory, tag)?.and_then(|side| usize::try_from(side).ok()))
        };
        let [width, height] = size;
        let strips = all(tags::STRIP_OFFSETS)?.zip(all(tags::STRIP_BYTES)?);
        let (chunk, offsets, is_tiled) = match strips {
            Some(places) => {
                let rows = side(tags::ROWS_PER_STRIP)?.unwrap_or(height).min(height);
                ([width, rows], places, false)
            }
            None => {
                let places = all(tags::TILE_OFFSETS)?.zip(all(tags::TILE_BYTES)?);
                let places = places.ok_or("its raw data is in neither strips nor tiles")?;
                let [across, down] = tags::TILE_SIZE.map(side);
                ([across?.unwrap_or(0), down?.unwrap_or(0)], places, true)
            }
        };
        let count = (0..2).try_fold(1_usize, |count, i| {
            (chunk[i] > 0).then(|| size[i].div_ceil(chunk[i]))?.checked_mul(count)
        });
        let (offsets, lengths) = offsets;
        if count.is_none_or(|n| n == 0 || n != offsets.len() || n != lengths.len()) {
            return Err(cut());
        }
        let places = offsets.into_iter().zip(lengths).map(|(at, length)| [at, length]).collect();
        Ok(Self { size, chunk, is_tiled, places })
    }

    /// Returns the codes of all pixels, row after row.
    ///
    /// # Errors
    /// Returns what was found if they are cut off or damaged.
    pub fn codes(&self, file: &Numbers<'_>, compressed: bool) -> Result<Vec<u16>, String> {
        let [width, height] = self.size;
        // A compressed code has a bit at least. The sizes of a hostile file claim no more memory.
        let most = if compressed { 8 * file.bytes.len() } else { file.bytes.len() / 2 };
        let count = width.checked_mul(height).filter(|&n| n <= most).ok_or_else(cut)?;
        let across = width.div_ceil(self.chunk[0]);
        let chunks: Vec<Vec<u16>> = (0..self.places.len())
            .into_par_iter()
            .map(|number| {
                let [chunk_width, mut rows] = self.chunk;
                if !self.is_tiled {
                    rows = rows.min(height - number * rows);
                }
                let bytes = self.bytes(file, number).ok_or_else(cut)?;
                let samples = chunk_width.checked_mul(rows).ok_or_else(cut)?;
                match compressed {
                    true if samples > 8 * bytes.len() => Err(cut()),
                    true => lossless_jpeg::decode(bytes, samples)
                        .map_err(|fault| format!("its raw data, chunk {number}: {fault}")),
                    false if bytes.len() / 2 != samples => Err(cut()),
                    false => {
                        let codes = bytes.as_chunks::<2>().0.iter();
                        Ok(codes.map(|&code| file.short(code)).collect())
                    }
                }
            })
            .collect::<Result<_, String>>()?;
        let mut codes = vec![0; count];
        for (number, chunk) in chunks.iter().enumerate() {
            let [left, top] = [number % across * self.chunk[0], number / across * self.chunk[1]];
            let kept = self.chunk[0].min(width - left);
            for (row, from) in chunk.chunks_exact(self.chunk[0]).enumerate() {
                if let Some(to) = codes.chunks_exact_mut(width).nth(top + row) {
                    to[left..left + kept].copy_from_slice(&from[..kept]);
                }
            }
        }
        Ok(codes)
    }

    /// Returns the bytes of a chunk.
    fn bytes<'a>(&self, file: &Numbers<'a>, number: usize) -> Option<&'a [u8]> {
        let [from, length] = self.places[number].map(|n| usize::try_from(n).ok());
        file.bytes.get(from?..from?.checked_add(length?)?)
    }
}
