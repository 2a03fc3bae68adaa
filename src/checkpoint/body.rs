//! Numbers of a body, one after another, with a checksum over all of them.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Take, Write};

use crc32fast::Hasher;

use super::{array, wrong};

/// Bytes that go to the system, and to the checksum, at once.
const CHUNK: usize = 1 << 18;
/// No tile has had more samples than this.
const MOST: u64 = 1 << 40;
/// No sum of samples, or of their squares, is larger: samples are 32-bit floats. What is added up
/// of these is finite still.
const LARGEST: f64 = 1e100;

/// What passes through it is counted and goes into a checksum.
struct Summed<T> {
    inner: T,
    checksum: Hasher,
    length: u64,
}

impl<T> Summed<T> {
    fn new(inner: T) -> Self {
        Self { inner, checksum: Hasher::new(), length: 0 }
    }

    fn pass(&mut self, bytes: &[u8]) {
        self.checksum.update(bytes);
        self.length += bytes.len() as u64;
    }
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.inner.write(bytes)?;
        self.pass(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<R: Read> Read for Summed<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(bytes)?;
        self.pass(&bytes[..count]);
        Ok(count)
    }
}

/// Takes a body to its file.
pub struct Writer<'a>(BufWriter<Summed<&'a mut File>>);

impl<'a> Writer<'a> {
    pub(super) fn new(file: &'a mut File) -> Self {
        Self(BufWriter::with_capacity(CHUNK, Summed::new(file)))
    }

    /// The length and the checksum of what was written.
    pub(super) fn finish(self) -> io::Result<(u64, u32)> {
        let Summed { checksum, length, .. } = self.0.into_inner().map_err(|e| e.into_error())?;
        Ok((length, checksum.finalize()))
    }

    pub(crate) fn u32(&mut self, value: u32) -> io::Result<()> {
        self.0.write_all(&value.to_le_bytes())
    }

    pub(crate) fn u64(&mut self, value: u64) -> io::Result<()> {
        self.0.write_all(&value.to_le_bytes())
    }

    pub(crate) fn numbers(&mut self, values: &[f64]) -> io::Result<()> {
        values.iter().try_for_each(|value| self.0.write_all(&value.to_le_bytes()))
    }

    pub(crate) fn sums(&mut self, sums: &[[f64; 3]]) -> io::Result<()> {
        self.numbers(sums.as_flattened())
    }
}

/// Takes a body from its file. Whatever is wrong has the kind [`io::ErrorKind::InvalidData`].
pub struct Reader(BufReader<Summed<Take<File>>>);

impl Reader {
    pub(super) fn new(file: File, length: u64) -> Self {
        Self(BufReader::with_capacity(CHUNK, Summed::new(file.take(length))))
    }

    /// All must have been read, and be as it was written.
    pub(super) fn finish(self) -> io::Result<()> {
        if !self.0.buffer().is_empty() || self.0.get_ref().inner.limit() > 0 {
            return Err(wrong("it is damaged: it holds more than this picture has"));
        }
        let Summed { inner, checksum, .. } = self.0.into_inner();
        match checksum.finalize() == u32::from_le_bytes(array(&mut inner.into_inner())?) {
            true => Ok(()),
            false => Err(wrong("it is damaged: the checksum of its sums is wrong")),
        }
    }

    pub(crate) fn u32(&mut self) -> io::Result<u32> {
        array(&mut self.0).map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> io::Result<u64> {
        array(&mut self.0).map(u64::from_le_bytes)
    }

    /// A number from 0 to before an end.
    pub(crate) fn below(&mut self, end: usize, what: &str) -> io::Result<usize> {
        let number = self.u32()?;
        let sound = |number: &usize| *number < end;
        let refuse = || wrong(format!("it is damaged: {number} {what} of {end}"));
        usize::try_from(number).ok().filter(sound).ok_or_else(refuse)
    }

    /// A count of a tile's samples.
    pub(crate) fn count(&mut self) -> io::Result<u64> {
        match self.u64()? {
            count if count <= MOST => Ok(count),
            count => Err(wrong(format!("it is damaged: {count} samples of a tile"))),
        }
    }

    /// A sum, to be added to another. A picture must never hold what is no number.
    pub(crate) fn add(&mut self, to: &mut f64) -> io::Result<()> {
        let value = f64::from_le_bytes(array(&mut self.0)?);
        if value.is_nan() || value.abs() > LARGEST {
            return Err(wrong(format!("it is damaged: {value} is no sum of samples")));
        }
        *to += value;
        Ok(())
    }

    pub(crate) fn add_numbers(&mut self, to: &mut [f64]) -> io::Result<()> {
        to.iter_mut().try_for_each(|to| self.add(to))
    }

    pub(crate) fn add_sums(&mut self, to: &mut [[f64; 3]]) -> io::Result<()> {
        self.add_numbers(to.as_flattened_mut())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Seek;

    use super::*;

    /// A body with these numbers, as it is read.
    fn body(fill: impl FnOnce(&mut Writer) -> io::Result<()>) -> Reader {
        let mut file = tempfile::tempfile().unwrap();
        let mut writer = Writer::new(&mut file);
        fill(&mut writer).unwrap();
        let (length, checksum) = writer.finish().unwrap();
        file.write_all(&checksum.to_le_bytes()).unwrap();
        file.rewind().unwrap();
        Reader::new(file, length)
    }

    #[test]
    fn sums_are_added_and_none_makes_them_infinite() {
        let mut sums = [1.0, 2.0];
        let mut good = body(|to| to.numbers(&[LARGEST, -0.5]));
        good.add_numbers(&mut sums).unwrap();
        good.finish().unwrap();
        assert_eq!(sums, [LARGEST, 1.5]);
        for bad in [f64::NAN, f64::INFINITY, 1e308, -1e308] {
            let error = body(|to| to.numbers(&[bad])).add(&mut 0.0).unwrap_err();
            assert!(error.to_string().contains("no sum of samples"), "{error}");
        }
    }

    #[test]
    fn counts_can_be_added_up() {
        assert_eq!(body(|to| to.u64(MOST)).count().unwrap(), MOST);
        for bad in [MOST + 1, u64::MAX] {
            assert!(body(|to| to.u64(bad)).count().is_err());
        }
    }
}
