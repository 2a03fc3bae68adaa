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
    /// Returns what was found if there are no strips or tiles, if they do not fill the picture, or if they have more
    /// samples than the file can hold.
    pub fn read(
        file: &Numbers<'_>,
        directory: usize,
        size: [usize; 2],
        compressed: bool,
    ) -> Result<Self, String> {
        let all = |tag| file.entry(directory, tag);
        let side = |tag| -> Result<usize, String> {
            let side = file.first(directory, tag)?.unwrap_or(0);
            Ok(usize::try_from(side).unwrap_or(usize::MAX))
        };
        let [width, height] = size;
        let strips = all(tags::STRIP_OFFSETS)?.zip(all(tags::STRIP_BYTES)?);
        let is_tiled = strips.is_none();
        let (chunk, (offsets, lengths)) = match strips {
            Some(places) => {
                // Without their number of rows, strips have the same.
                let rows = match side(tags::ROWS_PER_STRIP)? {
                    0 => height.div_ceil(places.0.len().max(1)),
                    rows => rows.min(height),
                };
                ([width, rows], places)
            }
            None => {
                let places = all(tags::TILE_OFFSETS)?.zip(all(tags::TILE_BYTES)?);
                let places = places.ok_or("its raw data is in neither strips nor tiles")?;
                ([side(tags::TILE_SIZE[0])?, side(tags::TILE_SIZE[1])?], places)
            }
        };
        let [across, down] =
            [0, 1].map(|i| if chunk[i] > 0 { size[i].div_ceil(chunk[i]) } else { 0 });
        let (count, found) = (across.saturating_mul(down), offsets.len());
        if count == 0 || count != found || count != lengths.len() {
            return Err(format!(
                "its raw data has {found} strips or tiles of {} x {} pixels; expected {count} for {width} x {height}",
                chunk[0], chunk[1]
            ));
        }
        let places = offsets.into_iter().zip(lengths).map(|(at, length)| [at, length]).collect();
        let chunks = Self { size, chunk, is_tiled, places };
        // A compressed code has a bit at least. A hostile file claims no more memory, neither by its sizes nor by chunks
        // that share their bytes.
        let bytes = file.bytes.len() as u64;
        let lengths = chunks.places.iter().map(|[_, length]| *length);
        let stored = lengths.fold(0_u64, u64::saturating_add);
        let most = if compressed { 8 * bytes } else { bytes / 2 };
        if stored > bytes || chunks.samples() > most {
            return Err(cut());
        }
        Ok(chunks)
    }

    /// Returns the number of samples of all chunks, with their padding.
    pub fn samples(&self) -> u64 {
        let [width, rows] = self.chunk.map(|side| side as u64);
        let padded = width.saturating_mul(rows).saturating_mul(self.places.len() as u64);
        match self.is_tiled {
            true => padded,
            false => (self.size[0] as u64).saturating_mul(self.size[1] as u64),
        }
    }

    /// Returns the codes of all pixels, row after row.
    ///
    /// # Errors
    /// Returns what was found if they are cut off or damaged.
    pub fn codes(&self, file: &Numbers<'_>, compressed: bool) -> Result<Vec<u16>, String> {
        let [width, height] = self.size;
        let across = width.div_ceil(self.chunk[0]);
        let chunks: Vec<Vec<u16>> = (0..self.places.len())
            .into_par_iter()
            .map(|number| {
                let [chunk_width, mut rows] = self.chunk;
                if !self.is_tiled {
                    rows = rows.min(height - number * rows);
                }
                let bytes = self.bytes(file, number).ok_or_else(cut)?;
                let samples = chunk_width * rows;
                if compressed {
                    let decoded = lossless_jpeg::decode(bytes, samples);
                    return decoded
                        .map_err(|fault| format!("its raw data, chunk {number}: {fault}"));
                }
                // A strip may be longer than its samples.
                let codes = bytes.as_chunks::<2>().0.get(..samples).ok_or_else(cut)?;
                Ok(codes.iter().map(|&code| file.short(code)).collect())
            })
            .collect::<Result<_, String>>()?;
        let mut codes = vec![0; width * height];
        for (number, chunk) in chunks.iter().enumerate() {
            let [left, top] = [number % across * self.chunk[0], number / across * self.chunk[1]];
            let kept = self.chunk[0].min(width - left);
            let rows = codes.chunks_exact_mut(width).skip(top);
            for (from, to) in chunk.chunks_exact(self.chunk[0]).zip(rows) {
                to[left..left + kept].copy_from_slice(&from[..kept]);
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
