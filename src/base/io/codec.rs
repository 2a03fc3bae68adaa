//! Binary codec for sums of samples: little-endian numbers, followed by a CRC-32 of all of them.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Take, Write};

use crc32fast::Hasher;

/// Size of the buffer between the codec and its file (bytes).
const BUFFER: usize = 1 << 18;
/// Largest number of samples of a tile.
const MAX_COUNT: u64 = 1 << 40;
/// Largest magnitude of a sum of samples or of their squares. Samples are 32-bit floats, so no sound
/// sum reaches it, and sums of such sums stay finite.
const MAX_SUM: f64 = 1e100;

/// Wrapper that counts the bytes that pass through it and computes their checksum.
struct Checksummed<T> {
    inner: T,
    checksum: Hasher,
    length: u64,
}

impl<T> Checksummed<T> {
    fn new(inner: T) -> Self {
        Self { inner, checksum: Hasher::new(), length: 0 }
    }

    fn count(&mut self, bytes: &[u8]) {
        self.checksum.update(bytes);
        self.length += bytes.len() as u64;
    }
}

impl<W: Write> Write for Checksummed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.inner.write(bytes)?;
        self.count(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<R: Read> Read for Checksummed<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(bytes)?;
        self.count(&bytes[..count]);
        Ok(count)
    }
}

/// Writes numbers to a file and computes their checksum.
pub struct ChecksumWriter<'a>(BufWriter<Checksummed<&'a mut File>>);

impl<'a> ChecksumWriter<'a> {
    /// Returns a writer of numbers at the position of the file.
    pub fn new(file: &'a mut File) -> Self {
        Self(BufWriter::with_capacity(BUFFER, Checksummed::new(file)))
    }

    /// Flushes the buffer. Returns the number of bytes written and their checksum.
    pub fn finish(self) -> io::Result<(u64, u32)> {
        let Checksummed { checksum, length, .. } =
            self.0.into_inner().map_err(|e| e.into_error())?;
        Ok((length, checksum.finalize()))
    }

    /// Writes an integer.
    pub fn u32(&mut self, value: u32) -> io::Result<()> {
        self.0.write_all(&value.to_le_bytes())
    }

    /// Writes an integer.
    pub fn u64(&mut self, value: u64) -> io::Result<()> {
        self.0.write_all(&value.to_le_bytes())
    }

    /// Writes numbers.
    pub fn numbers(&mut self, values: &[f64]) -> io::Result<()> {
        values.iter().try_for_each(|value| self.0.write_all(&value.to_le_bytes()))
    }

    /// Writes numbers in threes.
    pub fn triples(&mut self, triples: &[[f64; 3]]) -> io::Result<()> {
        self.numbers(triples.as_flattened())
    }
}

/// Reads numbers from a file and checks that they can be sums and counts of samples.
///
/// An error about the content has the kind [`io::ErrorKind::InvalidData`].
pub struct ChecksumReader(BufReader<Checksummed<Take<File>>>);

impl ChecksumReader {
    /// Returns a reader of the next `length` bytes of a file.
    pub fn new(file: File, length: u64) -> Self {
        Self(BufReader::with_capacity(BUFFER, Checksummed::new(file.take(length))))
    }

    /// Compares the checksum that follows the numbers.
    ///
    /// # Errors
    /// Returns an error if numbers are left over or the checksum differs.
    pub fn finish(self) -> io::Result<()> {
        if !self.0.buffer().is_empty() || self.0.get_ref().inner.limit() > 0 {
            return Err(invalid_data("it is damaged: it holds more than this picture has"));
        }
        let Checksummed { inner, checksum, .. } = self.0.into_inner();
        match checksum.finalize() == u32::from_le_bytes(read_array(&mut inner.into_inner())?) {
            true => Ok(()),
            false => Err(invalid_data("it is damaged: the checksum of its sums is wrong")),
        }
    }

    /// Reads an integer.
    pub fn u32(&mut self) -> io::Result<u32> {
        read_array(&mut self.0).map(u32::from_le_bytes)
    }

    /// Reads an integer.
    pub fn u64(&mut self) -> io::Result<u64> {
        read_array(&mut self.0).map(u64::from_le_bytes)
    }

    /// Reads an integer in `0..end`; `what` names it in the error.
    pub fn below(&mut self, end: usize, what: &str) -> io::Result<usize> {
        let number = self.u32()?;
        let sound = |number: &usize| *number < end;
        let refuse = || invalid_data(format!("it is damaged: {number} {what} of {end}"));
        usize::try_from(number).ok().filter(sound).ok_or_else(refuse)
    }

    /// Reads a number of samples of a tile.
    pub fn count(&mut self) -> io::Result<u64> {
        match self.u64()? {
            count if count <= MAX_COUNT => Ok(count),
            count => Err(invalid_data(format!("it is damaged: {count} samples of a tile"))),
        }
    }

    /// Reads a sum and adds it to `to`. Refuses NaN and infinity, which would spoil the picture.
    pub fn add_number(&mut self, to: &mut f64) -> io::Result<()> {
        let value = f64::from_le_bytes(read_array(&mut self.0)?);
        if value.is_nan() || value.abs() > MAX_SUM {
            return Err(invalid_data(format!("it is damaged: {value} is no sum of samples")));
        }
        *to += value;
        Ok(())
    }

    /// Reads sums and adds them to `to`, as [`Self::add_number`].
    pub fn add_numbers(&mut self, to: &mut [f64]) -> io::Result<()> {
        to.iter_mut().try_for_each(|to| self.add_number(to))
    }

    /// Reads sums in threes and adds them to `to`, as [`Self::add_number`].
    pub fn add_triples(&mut self, to: &mut [[f64; 3]]) -> io::Result<()> {
        self.add_numbers(to.as_flattened_mut())
    }
}

/// Returns an error about the content of a file.
pub fn invalid_data(found: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, found.into())
}

/// Reads `N` bytes.
///
/// # Errors
/// Returns an error if the file ends before.
pub fn read_array<const N: usize>(from: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    from.read_exact(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::io::Seek;

    use super::*;

    /// Returns a reader of a file that `fill` has written.
    fn written(fill: impl FnOnce(&mut ChecksumWriter) -> io::Result<()>) -> ChecksumReader {
        let mut file = tempfile::tempfile().unwrap();
        let mut writer = ChecksumWriter::new(&mut file);
        fill(&mut writer).unwrap();
        let (length, checksum) = writer.finish().unwrap();
        file.write_all(&checksum.to_le_bytes()).unwrap();
        file.rewind().unwrap();
        ChecksumReader::new(file, length)
    }

    #[test]
    fn finite_sums_are_added_and_others_are_refused() {
        let mut sums = [1.0, 2.0];
        let mut good = written(|to| to.numbers(&[MAX_SUM, -0.5]));
        good.add_numbers(&mut sums).unwrap();
        good.finish().unwrap();
        assert_eq!(sums, [MAX_SUM, 1.5]);
        for bad in [f64::NAN, f64::INFINITY, 1e308, -1e308] {
            let error = written(|to| to.numbers(&[bad])).add_number(&mut 0.0).unwrap_err();
            assert!(error.to_string().contains("no sum of samples"), "{error}");
        }
    }

    #[test]
    fn counts_beyond_the_limit_are_refused() {
        assert_eq!(written(|to| to.u64(MAX_COUNT)).count().unwrap(), MAX_COUNT);
        for bad in [MAX_COUNT + 1, u64::MAX] {
            assert!(written(|to| to.u64(bad)).count().is_err());
        }
    }
}
