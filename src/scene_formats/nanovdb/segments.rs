//! Segments of a NanoVDB file: the grids that it holds, and their contents.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::ZlibDecoder;

use petzval_base::io::HeldMemory;

/// "NanoVDB0" in ASCII.
const MAGIC: u64 = 0x3042_4456_6f6e_614e;
/// The version of the format whose layout this reader knows.
const MAJOR_VERSION: u32 = 32;
/// The type of grids of f32.
const FLOAT: u32 = 1;

/// A grid of a file.
pub(super) struct GridEntry<'a> {
    pub(super) name: &'a [u8],
    kind: u32,
    codec: u16,
    size: u64,
    stored: &'a [u8],
}

/// A position in a file. Reading moves it on.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: u64) -> Result<&'a [u8], String> {
        let count = usize::try_from(count).map_err(|_| self.cut())?;
        let end = self.at.checked_add(count).ok_or_else(|| self.cut())?;
        let taken = self.bytes.get(self.at..end).ok_or_else(|| self.cut())?;
        self.at = end;
        Ok(taken)
    }

    fn cut(&self) -> String {
        format!("the file is cut short: it ends at byte {}", self.bytes.len())
    }
}

/// Returns the number at an offset of a block that is long enough.
fn u64_at(block: &[u8], at: usize) -> u64 {
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&block[at..at + 8]);
    u64::from_le_bytes(bytes)
}

fn u32_at(block: &[u8], at: usize) -> u32 {
    (u64_at(&[&block[at..at + 4], &[0; 4]].concat(), 0)) as u32
}

/// Returns the grids of a file.
pub(super) fn entries(bytes: &[u8]) -> Result<Vec<GridEntry<'_>>, String> {
    /// Bytes of a segment's header, and of the metadata of a grid without its name.
    const HEADER: u64 = 16;
    const METADATA: u64 = 176;
    let mut cursor = Cursor { bytes, at: 0 };
    let mut entries = Vec::new();
    while cursor.at < bytes.len() {
        let header = cursor.take(HEADER)?;
        if u64_at(header, 0) != MAGIC {
            return Err(match cursor.at {
                16 => "it is not a NanoVDB file: expected one that begins with \"NanoVDB0\""
                    .to_owned(),
                end => format!("no segment of grids at byte {}", end - 16),
            });
        }
        let version = u32_at(header, 8) >> 21;
        if version != MAJOR_VERSION {
            return Err(format!(
                "version {version} of NanoVDB; expected {MAJOR_VERSION}: convert it with a current \
                 nanovdb_convert"
            ));
        }
        let (grids, codec) = (u32_at(header, 12) & 0xffff, (u32_at(header, 12) >> 16) as u16);
        let first = entries.len();
        let mut stored = Vec::new();
        for _ in 0..grids {
            let metadata = cursor.take(METADATA)?;
            let name = cursor.take(u64::from(u32_at(metadata, 136)))?;
            stored.push(u64_at(metadata, 8));
            entries.push(GridEntry {
                name: name.strip_suffix(&[0]).unwrap_or(name),
                kind: u32_at(metadata, 32),
                codec,
                size: u64_at(metadata, 0),
                stored: &[],
            });
        }
        for (entry, stored) in entries[first..].iter_mut().zip(stored) {
            entry.stored = cursor.take(stored)?;
        }
    }
    Ok(entries)
}

impl<'a> GridEntry<'a> {
    /// Returns the tree of the grid, unpacked. Its memory is added to `held`.
    pub(super) fn content(&self, held: &mut HeldMemory) -> Result<Cow<'a, [u8]>, String> {
        let name = String::from_utf8_lossy(self.name);
        if self.kind != FLOAT {
            return Err(format!(
                "the grid \"{name}\" has values of type {}; expected 1: numbers of 32 bits",
                self.kind
            ));
        }
        match self.codec {
            0 => Ok(Cow::Borrowed(self.stored)),
            1 => {
                let packed = self.stored.get(8..).unwrap_or_default();
                // Deflate packs a byte into a 1032nd at best.
                let most = packed.len() as u64 * 1032;
                if self.size > most {
                    let (packed, size) = (packed.len(), self.size);
                    return Err(format!(
                        "the grid \"{name}\" cannot be unpacked: {packed} bytes do not hold {size}"
                    ));
                }
                held.add(self.size)?;
                let mut unpacked = Vec::new();
                // Memory grows with what is there, not with what is declared.
                let most = self.size.saturating_add(1);
                let read = ZlibDecoder::new(packed).take(most).read_to_end(&mut unpacked);
                match read {
                    Ok(_) if unpacked.len() as u64 == self.size => Ok(Cow::Owned(unpacked)),
                    Ok(_) => Err(format!("the grid \"{name}\" does not unpack to its size")),
                    Err(source) => Err(format!("the grid \"{name}\" cannot be unpacked: {source}")),
                }
            }
            2 => Err(format!(
                "the grid \"{name}\" is compressed with Blosc; convert it with nanovdb_convert --zip"
            )),
            codec => Err(format!("the grid \"{name}\" is compressed in an unknown way, {codec}")),
        }
    }
}
