//! Numbers and entries of a TIFF file (TIFF 6.0, 1992, section 2).

use super::tags;

/// Numbers of a TIFF file in its order of bytes.
pub(super) struct Numbers<'a> {
    pub bytes: &'a [u8],
    little: bool,
}

impl<'a> Numbers<'a> {
    /// Returns the numbers of a file, whose first two bytes tell the order of bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, little: bytes.starts_with(b"II") }
    }

    /// Returns the place of the first directory, or `None` for a file that is no TIFF with addresses of 32 bits.
    pub fn first_directory(&self) -> Option<usize> {
        let is_tiff = self.at(2, 2) == Some(42) && (self.little || self.bytes.starts_with(b"MM"));
        self.at(4, 4).filter(|_| is_tiff).map(|place| place as usize)
    }

    /// Returns the number of two bytes.
    pub fn short(&self, bytes: [u8; 2]) -> u16 {
        if self.little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) }
    }

    /// Returns the whole number of this many bytes at a place.
    pub fn at(&self, place: usize, bytes: usize) -> Option<u64> {
        let found = self.bytes.get(place..place.checked_add(bytes)?)?;
        let add = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
        Some(if self.little { found.iter().rev().fold(0, add) } else { found.iter().fold(0, add) })
    }

    /// Returns the place of an entry.
    fn place(&self, directory: usize, tag: u16) -> Option<usize> {
        let entries = self.at(directory, 2)? as usize;
        (0..entries)
            .map(|i| directory + 2 + 12 * i)
            .find(|&entry| self.at(entry, 2) == Some(u64::from(tag)))
    }

    /// Returns type, place and number of the elements of an entry.
    fn elements(
        &self,
        entry: usize,
        size_of: impl Fn(u64) -> Option<usize>,
    ) -> Option<(u64, usize, usize)> {
        let kind = self.at(entry + 2, 2)?;
        let count = usize::try_from(self.at(entry + 4, 4)?).ok()?;
        let length = count.checked_mul(size_of(kind)?);
        let length = length.filter(|&length| length <= self.bytes.len())?;
        let from = if length <= 4 { entry + 8 } else { self.at(entry + 8, 4)? as usize };
        Some((kind, from, count))
    }

    /// Returns what a reader makes of an entry; none without the entry.
    fn read<T>(
        &self,
        directory: usize,
        tag: u16,
        read: impl Fn(usize) -> Option<T>,
    ) -> Result<Option<T>, String> {
        let Some(entry) = self.place(directory, tag) else { return Ok(None) };
        let cut_off = || {
            format!("its {} is cut off or of another type; expected that of DNG", tags::name(tag))
        };
        read(entry).map(Some).ok_or_else(cut_off)
    }

    /// Returns the bytes of an entry of bytes, text or undefined ones; none without the entry.
    ///
    /// # Errors
    /// Returns what was found if the entry is cut off or of another type.
    pub fn blob(&self, directory: usize, tag: u16) -> Result<Option<&'a [u8]>, String> {
        let one = |kind| matches!(kind, 1 | 2 | 7).then_some(1);
        self.read(directory, tag, |entry| {
            let (_, from, count) = self.elements(entry, one)?;
            self.bytes.get(from..from.checked_add(count)?)
        })
    }

    /// Returns the whole numbers of an entry; none without the entry.
    ///
    /// # Errors
    /// As [`Self::blob`].
    pub fn entry(&self, directory: usize, tag: u16) -> Result<Option<Vec<u64>>, String> {
        self.read(directory, tag, |entry| {
            let (kind, from, count) = self.elements(entry, whole_size)?;
            let size = whole_size(kind)?;
            (0..count).map(|i| self.at(from + size * i, size)).collect()
        })
    }

    /// Returns the first whole number of an entry; none without the entry.
    ///
    /// # Errors
    /// As [`Self::blob`].
    pub fn first(&self, directory: usize, tag: u16) -> Result<Option<u64>, String> {
        Ok(self.entry(directory, tag)?.and_then(|found| found.first().copied()))
    }

    /// Returns the numbers of an entry, whole ones, fractions or floats; none without the entry.
    ///
    /// # Errors
    /// As [`Self::blob`], and if a number is not finite.
    pub fn reals(&self, directory: usize, tag: u16) -> Result<Option<Vec<f64>>, String> {
        let reals = self.read(directory, tag, |entry| self.reals_at(entry))?;
        match reals.iter().flatten().find(|real| !real.is_finite()) {
            None => Ok(reals),
            Some(real) => Err(format!(
                "its {} has the number {real}; expected finite numbers",
                tags::name(tag)
            )),
        }
    }

    fn reals_at(&self, entry: usize) -> Option<Vec<f64>> {
        let size_of = |kind| match kind {
            5 | 10 | 12 => Some(8),
            9 | 11 => Some(4),
            8 => Some(2),
            6 => Some(1),
            _ => whole_size(kind),
        };
        let (kind, from, count) = self.elements(entry, size_of)?;
        let size = size_of(kind)?;
        let number = |i: usize| {
            let place = from + size * i;
            let signed = |place| self.at(place, 4).map(|bits| f64::from(bits as u32 as i32));
            Some(match kind {
                5 => self.at(place, 4)? as f64 / self.at(place + 4, 4)? as f64,
                6 => f64::from(self.at(place, 1)? as u8 as i8),
                8 => f64::from(self.at(place, 2)? as u16 as i16),
                9 => signed(place)?,
                10 => signed(place)? / signed(place + 4)?,
                11 => f64::from(f32::from_bits(self.at(place, 4)? as u32)),
                12 => f64::from_bits(self.at(place, 8)?),
                _ => self.at(place, size)? as f64,
            })
        };
        (0..count).map(number).collect()
    }
}

/// Returns the bytes of a whole number without a sign of this type.
fn whole_size(kind: u64) -> Option<usize> {
    match kind {
        1 | 7 => Some(1),
        3 => Some(2),
        4 | 13 => Some(4),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a big-endian file of one directory with one entry, whose elements follow it.
    fn file(kind: u16, count: u32, elements: &[u8]) -> Vec<u8> {
        let mut bytes = b"MM\0\x2a\0\0\0\x08\0\x01\x01\0".to_vec();
        bytes.extend(kind.to_be_bytes());
        bytes.extend(count.to_be_bytes());
        bytes.extend(22_u32.to_be_bytes());
        bytes.extend(elements);
        bytes
    }

    #[test]
    fn fractions_and_floats_are_read_with_their_sign() {
        let read = |kind, count, elements: &[u8]| {
            let bytes = file(kind, count, elements);
            let numbers = Numbers::new(&bytes);
            numbers.reals(numbers.first_directory().unwrap(), 256)
        };
        let longs = |numbers: [i32; 4]| numbers.map(i32::to_be_bytes).concat();
        assert_eq!(read(5, 2, &longs([3, 4, 7, 2])), Ok(Some(vec![0.75, 3.5])));
        assert_eq!(read(10, 2, &longs([-3, 4, 7, 2])), Ok(Some(vec![-0.75, 3.5])));
        assert_eq!(read(12, 1, &(-2.5_f64).to_be_bytes()), Ok(Some(vec![-2.5])));
        assert_eq!(read(11, 2, &[1.5_f32.to_be_bytes(); 2].concat()), Ok(Some(vec![1.5; 2])));
        assert_eq!(read(3, 3, &[0, 7, 1, 0, 0, 9]), Ok(Some(vec![7.0, 256.0, 9.0])));
        assert_eq!(read(9, 2, &longs([-3, 4, 7, 2])), Ok(Some(vec![-3.0, 4.0])));
        assert!(read(5, 3, &longs([3, 4, 7, 2])).unwrap_err().contains("its entry 256 is cut off"));
        assert!(read(2, 4, b"text").unwrap_err().contains("of another type"));
        assert!(read(5, 1, &[0; 8]).unwrap_err().contains("expected finite numbers"));
        let cut = file(7, 9, b"bytes");
        assert!(Numbers::new(&cut).blob(8, 256).unwrap_err().contains("is cut off"));
        assert!(Numbers::new(&cut).entry(8, 256).unwrap_err().contains("is cut off"));
        let bytes = file(3, 1, &[]);
        assert_eq!(Numbers::new(&bytes).reals(8, 257), Ok(None));
    }
}
