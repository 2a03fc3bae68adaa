//! Reads the mosaic of a DNG. The tiff crate decodes no directory of colour filters, and its decoder does not open a
//! file that begins with one.

use super::chunks::Chunks;
use super::numbers::Numbers;
use super::tags;
use crate::raw_codes::RawCodes;

/// Photometric interpretations of raw data: behind colour filters, and without.
const COLOR_FILTER_ARRAY: u64 = tags::COLOR_FILTER_ARRAY as u64;
const LINEAR_RAW: u64 = 34892;
/// `Compression` of lossless JPEG.
const LOSSLESS_JPEG: u64 = 7;
/// Most directories that are looked at: a file could refer to its own.
const MAX_DIRECTORIES: usize = 64;

/// The raw data of a file, and where its entries are.
pub(super) struct RawDirectory<'a> {
    pub file: Numbers<'a>,
    /// Place of the first directory, which has the colours of the camera.
    pub first: usize,
    /// Place of the directory of the raw data.
    pub directory: usize,
    /// Whether the sensor has colour filters.
    filtered: bool,
}

/// Reads the mosaic, or the readings of a sensor without filters.
///
/// # Errors
/// Returns what was found if the file has none that this reads.
pub(crate) fn read_mosaic(bytes: &[u8]) -> Result<RawCodes, String> {
    RawDirectory::find(bytes)?.codes()
}

/// Returns the number of samples that the raw data of a file has to be decoded to.
///
/// # Errors
/// As [`read_mosaic`].
pub(crate) fn raw_samples(bytes: &[u8]) -> Result<u64, String> {
    let RawDirectory { file, directory, .. } = RawDirectory::find(bytes)?;
    Ok(Layout::read(&file, directory)?.chunks.samples())
}

impl<'a> RawDirectory<'a> {
    /// Finds the raw data of a file.
    ///
    /// # Errors
    /// Returns what was found if there is none.
    pub fn find(bytes: &'a [u8]) -> Result<Self, String> {
        let file = Numbers::new(bytes);
        let first = file.first_directory();
        let first = first.ok_or("it is not a TIFF file with addresses of 32 bits, as a DNG is")?;
        let mut directories = vec![first];
        let mut looked_at = 0;
        // Raw data of less size or of more work, if there is no other.
        let mut second_choice = None;
        while let Some(&directory) = directories.get(looked_at) {
            looked_at += 1;
            if file.at(directory, 2).is_none() {
                return Err("it is cut off".to_owned());
            }
            let photometric = file.first(directory, tags::PHOTOMETRIC)?;
            if let Some(COLOR_FILTER_ARRAY | LINEAR_RAW) = photometric {
                let filtered = photometric == Some(COLOR_FILTER_ARRAY);
                if file.first(directory, tags::NEW_SUBFILE_TYPE)?.unwrap_or(0) == 0 {
                    return Ok(Self { file, first, directory, filtered });
                }
                second_choice.get_or_insert((directory, filtered));
            }
            let more = file.entry(directory, tags::SUB_DIRECTORIES)?.unwrap_or_default();
            directories.extend(more.into_iter().map(|place| place as usize).take(MAX_DIRECTORIES));
            if looked_at == MAX_DIRECTORIES {
                break;
            }
        }
        let (directory, filtered) = second_choice.ok_or("it has no raw data")?;
        Ok(Self { file, first, directory, filtered })
    }

    /// Reads the codes.
    ///
    /// # Errors
    /// Returns what was found if they are of a form that this does not read.
    pub fn codes(&self) -> Result<RawCodes, String> {
        read_directory(&self.file, self.directory, self.filtered)
    }
}

/// How raw data is stored.
struct Layout {
    size: [usize; 2],
    compressed: bool,
    /// Bits of a code.
    bits: u32,
    chunks: Chunks,
}

impl Layout {
    fn read(file: &Numbers<'_>, directory: usize) -> Result<Self, String> {
        let one =
            |tag, default: u64| file.first(directory, tag).map(|found| found.unwrap_or(default));
        let compressed = match one(tags::COMPRESSION, 1)? {
            1 => false,
            LOSSLESS_JPEG => true,
            method => {
                return Err(format!(
                    "its raw data is compressed by the method {method}; expected none or lossless JPEG, as Adobe DNG \
                     Converter writes; petzval measure noise also reads codes from TIFF files"
                ));
            }
        };
        let [bits, samples] = [one(tags::BITS, 1)?, one(tags::SAMPLES, 1)?];
        let least = if compressed { 2 } else { 16 };
        if samples != 1 || !(least..=16).contains(&bits) {
            return Err(format!(
                "its raw data has {samples} samples of {bits} bits a pixel; expected one of 16, or of fewer by lossless JPEG; \
                 petzval measure noise also reads codes from TIFF files"
            ));
        }
        let size = [one(tags::WIDTH, 0)?, one(tags::HEIGHT, 0)?]
            .map(|side| usize::try_from(side).unwrap_or(0));
        let chunks = Chunks::read(file, directory, size, compressed)?;
        Ok(Self { size, compressed, bits: bits as u32, chunks })
    }
}

fn read_directory(
    file: &Numbers<'_>,
    directory: usize,
    filtered: bool,
) -> Result<RawCodes, String> {
    let all = |tag| file.entry(directory, tag);
    let Layout { size: [width, height], compressed, bits, chunks } = Layout::read(file, directory)?;
    let filters = match (filtered, all(tags::CFA_PATTERN)?.as_deref()) {
        (false, _) => None,
        (true, Some(&[a, b, c, d]))
            if all(tags::CFA_SIZE)? == Some(vec![2, 2]) && [a, b, c, d].iter().all(|&f| f < 3) =>
        {
            Some([a, b, c, d].map(|filter| filter as u8))
        }
        (true, _) => {
            return Err(
                "its filters are not those of two by two pixels in red, green and blue".to_owned()
            );
        }
    };
    let mut codes = chunks.codes(file, compressed)?;
    if let Some(table) = all(tags::LINEARIZATION_TABLE)? {
        // Codes beyond the table are its last one.
        let last = table.len().checked_sub(1).ok_or("its LinearizationTable is empty")?;
        let linear = |code: &u16| table[usize::from(*code).min(last)].min(u64::from(u16::MAX));
        codes.iter_mut().for_each(|code| *code = linear(code) as u16);
    }
    // Masked photosites lie around the active ones, from which the filters count.
    let area = all(tags::ACTIVE_AREA)?.unwrap_or_else(|| vec![0, 0, height as u64, width as u64]);
    let [top, left, bottom, right] = area[..] else {
        return Err("its active area has other than four borders".to_owned());
    };
    if top >= bottom || left >= right || bottom > height as u64 || right > width as u64 {
        return Err(format!(
            "its active area, {left},{top} to {right},{bottom}, is not within its {width} x {height} pixels"
        ));
    }
    let [top, left, bottom, right] = [top, left, bottom, right].map(|border| border as usize);
    let rows = codes.chunks_exact(width).skip(top).take(bottom - top);
    let codes = rows.flat_map(|row| &row[left..right]).copied().collect();
    Ok(RawCodes { size: [right - left, bottom - top], codes, filters, bits })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(little: bool, compression: u16) -> Vec<u8> {
        file_with(little, compression, None)
    }

    /// Returns a file of 2 x 2 pixels with its mosaic in a directory below the first, and one more entry: a tag, a type
    /// of one byte an element, and four elements.
    fn file_with(little: bool, compression: u16, more: Option<(u16, [u8; 4])>) -> Vec<u8> {
        let short = |value: u16| if little { value.to_le_bytes() } else { value.to_be_bytes() };
        let long = |value: u32| if little { value.to_le_bytes() } else { value.to_be_bytes() };
        let mut bytes = if little { b"II".to_vec() } else { b"MM".to_vec() };
        bytes.extend(short(42));
        bytes.extend(long(8));
        // One entry: the directory of the mosaic.
        bytes.extend(short(1));
        let entry = |tag: u16, type_: u16, count: u32, value: [u8; 4]| {
            [&short(tag)[..], &short(type_), &long(count), &value].concat()
        };
        bytes.extend(entry(tags::SUB_DIRECTORIES, 4, 1, long(26)));
        bytes.extend(long(0));
        let number = |value: u16| [short(value), [0; 2]].concat().try_into().unwrap();
        let count = 9 + usize::from(more.is_some()) as u32;
        let mut entries = vec![
            entry(tags::WIDTH, 3, 1, number(2)),
            entry(tags::HEIGHT, 3, 1, number(2)),
            entry(tags::BITS, 3, 1, number(16)),
            entry(tags::COMPRESSION, 3, 1, number(compression)),
            entry(tags::PHOTOMETRIC, 3, 1, number(32803)),
            entry(tags::STRIP_OFFSETS, 4, 1, long(26 + 2 + count * 12)),
            entry(tags::STRIP_BYTES, 4, 1, long(8)),
            entry(tags::CFA_SIZE, 3, 2, [short(2), short(2)].concat().try_into().unwrap()),
            entry(tags::CFA_PATTERN, 1, 4, [1, 2, 0, 1]),
        ];
        entries.extend(more.map(|(tag, elements)| entry(tag, 1, 4, elements)));
        bytes.extend(short(entries.len() as u16));
        bytes.extend(entries.concat());
        [7_u16, 4095, 65535, 0].iter().for_each(|&code| bytes.extend(short(code)));
        bytes
    }

    #[test]
    fn mosaics_below_the_first_directory_are_read_in_both_orders_of_bytes() {
        for little in [true, false] {
            let found = read_mosaic(&file(little, 1)).unwrap();
            let expected = RawCodes {
                size: [2, 2],
                codes: vec![7, 4095, 65535, 0],
                filters: Some([1, 2, 0, 1]),
                bits: 16,
            };
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn masked_photosites_are_left_out_and_tables_applied() {
        let found =
            read_mosaic(&file_with(true, 1, Some((tags::ACTIVE_AREA, [1, 0, 2, 2])))).unwrap();
        assert_eq!((found.size, &found.codes[..]), ([2, 1], &[65535, 0][..]));
        for area in [[0, 0, 3, 2], [1, 0, 1, 2], [0, 2, 2, 1]] {
            let refused = read_mosaic(&file_with(false, 1, Some((tags::ACTIVE_AREA, area))));
            assert!(refused.unwrap_err().contains("is not within its 2 x 2 pixels"));
        }
        let curved =
            read_mosaic(&file_with(true, 1, Some((tags::LINEARIZATION_TABLE, [0, 1, 2, 3]))));
        assert_eq!(curved.unwrap().codes, [3, 3, 3, 0]);
    }

    #[test]
    fn broken_files_are_refused() {
        assert!(read_mosaic(&file(true, 8)).unwrap_err().contains("compressed by the method 8"));
        assert!(read_mosaic(&file(true, 7)).unwrap_err().contains("found no lossless JPEG"));
        let whole = file(false, 1);
        for length in 0..whole.len() {
            assert!(read_mosaic(&whole[..length]).is_err(), "{length}");
        }
        // Any byte may be wrong: no panic, and no endless search.
        for i in 0..whole.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff] {
                let mut broken = whole.clone();
                broken[i] = value;
                let _ = read_mosaic(&broken);
            }
        }
        // A directory that refers to itself.
        let mut looped = file(true, 1);
        looped[18..22].copy_from_slice(&8_u32.to_le_bytes());
        assert!(read_mosaic(&looped).unwrap_err().contains("no raw data"));
    }
}
