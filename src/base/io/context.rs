//! Read context: the memory budget that readers share, and the log of the files that they read.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use flate2::read::MultiGzDecoder;

use super::budget::{HeldMemory, MemoryBudget};
use super::foreign::{refuse_placeholder, refuse_placeholder_file};
use super::{ByteSize, ContentDigest, FileLog, ReadError};

/// Largest content of a pipe, whose size is not known (bytes).
const MAX_PIPE: u64 = 1 << 28;
/// Limit of the content of a gzip file: bytes of any file, and more for each of its packed bytes.
/// Scenes grow three to ten times.
const MAX_UNPACKED: u64 = 1 << 24;
const MAX_UNPACKED_RATIO: u64 = 100;

/// Memory budget and file log of the readers of input files.
///
/// Files declare sizes before their data follows. A reader claims what it is about to allocate, so that
/// a scene that is too large is refused early, even if only the sum of many files is too large. What a
/// reader needs for a time only is returned after use. The log is the list of inputs on which a picture
/// depends.
///
/// It also carries the paths of the glass catalogues that the user names, which readers of lenses need, and
/// the content of a lens file that is in memory.
///
/// Clones share all. The default has the memory of the machine, or of the group that limits the
/// process, and no catalogue.
#[derive(Clone, Debug, Default)]
pub struct ReadContext {
    budget: Arc<MemoryBudget>,
    files: Arc<Mutex<FileLog>>,
    approximate: bool,
    catalogues: Arc<[PathBuf]>,
    /// Glass catalogues that are packed with a lens: their names and contents.
    packed_catalogues: Arc<[(PathBuf, Vec<u8>)]>,
    /// A lens file that is in memory: its name and its content.
    lens: Option<(PathBuf, Arc<[u8]>)>,
}

impl ReadContext {
    /// Creates a context whose readers may claim this many bytes in all.
    pub fn with_memory(limit: u64) -> Self {
        Self { budget: Arc::new(MemoryBudget::new(limit)), ..Self::default() }
    }

    /// Returns the context with leave to replace what cannot be simulated by something near, with a
    /// warning, where readers otherwise return an error.
    #[must_use]
    pub fn approximating(self, approximate: bool) -> Self {
        Self { approximate, ..self }
    }

    /// Returns whether readers may replace what cannot be simulated.
    pub fn approximates(&self) -> bool {
        self.approximate
    }

    /// Returns the context with glass catalogues: AGF files, or folders of them.
    #[must_use]
    pub fn with_catalogues(self, paths: impl IntoIterator<Item = PathBuf>) -> Self {
        Self { catalogues: paths.into_iter().collect(), ..self }
    }

    /// Returns the context with glass catalogues that are packed with a lens: their names and contents.
    #[must_use]
    pub fn with_packed_catalogues(self, packed: Vec<(PathBuf, Vec<u8>)>) -> Self {
        Self { packed_catalogues: packed.into(), ..self }
    }

    /// Returns the glass catalogues that are packed with a lens: their names and contents.
    pub fn packed_catalogues(&self) -> &[(PathBuf, Vec<u8>)] {
        &self.packed_catalogues
    }

    /// Returns the context with a lens file that is in memory, in place of an earlier one. Readers of
    /// lenses find it by its name, which need not be that of a file.
    #[must_use]
    pub fn with_lens(self, name: PathBuf, content: impl Into<Arc<[u8]>>) -> Self {
        Self { lens: Some((name, content.into())), ..self }
    }

    /// Opens a lens file, or the one in memory if it has this name.
    ///
    /// # Errors
    /// Returns an error if the file cannot be opened or is a device.
    pub fn open_lens(&self, path: &Path) -> io::Result<Box<dyn Read + '_>> {
        match &self.lens {
            Some((name, content)) if name == path => Ok(Box::new(&content[..])),
            _ => Ok(Box::new(open(path)?)),
        }
    }

    /// Returns the paths of the glass catalogues.
    pub fn catalogues(&self) -> &[PathBuf] {
        &self.catalogues
    }

    /// Returns a context for data that is dropped after use: its readers may claim what is left of
    /// this budget, and their claims return when the last of its clones is dropped. Its log is empty.
    #[must_use]
    pub fn temporary(&self) -> Self {
        let budget = MemoryBudget::part_of(Arc::clone(&self.budget));
        Self { budget: Arc::new(budget), files: Arc::default(), ..self.clone() }
    }

    /// Stops the readers of this context: the next file or allocation is an error.
    pub fn stop(&self) {
        self.budget.stop();
    }

    /// Returns the files read so far.
    pub fn files(&self) -> FileLog {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Returns the content of a file, unpacked if it is gzipped, and logs it.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, does not end, exceeds the memory budget, unpacks
    /// to more than 100 times its size, or is a pointer of Git LFS or a web page.
    pub fn bytes(&self, path: &Path) -> Result<Vec<u8>, ReadError> {
        let exceeds = |found| io::Error::new(io::ErrorKind::OutOfMemory, found);
        let read = || {
            let file = open(path)?;
            let length = file.metadata()?.len();
            let mut held = self.hold(length).map_err(exceeds)?;
            let packed = read_to_end(file, length.max(MAX_PIPE), length + self.budget.left())?;
            held.add((packed.len() as u64).saturating_sub(length)).map_err(exceeds)?;
            self.log(path, &packed);
            refuse_placeholder(&packed)?;
            if !packed.starts_with(&[0x1f, 0x8b]) {
                return Ok(packed);
            }
            let most = MAX_UNPACKED + MAX_UNPACKED_RATIO * packed.len() as u64;
            read_to_end(MultiGzDecoder::new(&packed[..]), most, self.budget.left())
        };
        read().map_err(|source| ReadError { path: path.to_owned(), source })
    }

    /// Logs a file whose reader opens it itself, perhaps more than once.
    ///
    /// # Errors
    /// Returns an error if the path is a pipe, which can be read only once, or a device, or if the
    /// file is a pointer of Git LFS or a web page.
    pub fn register(&self, path: &Path) -> io::Result<()> {
        check_seekable(path)?;
        refuse_placeholder_file(path)?;
        self.files.lock().unwrap_or_else(PoisonError::into_inner).add(path, None);
        Ok(())
    }

    /// Logs a file and its content.
    pub fn log(&self, path: &Path, content: &[u8]) {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).add(path, Some(content));
    }

    /// Logs input that is no file, by a name and the digest of its content.
    pub fn log_digest(&self, name: &Path, digest: &ContentDigest) {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).add_digest(name, digest);
    }

    /// Claims bytes for a time, or returns an error if they are more than the rest of the budget.
    pub fn hold(&self, bytes: u64) -> Result<HeldMemory, String> {
        HeldMemory::claim(&self.budget, bytes)
    }

    /// Claims bytes, or returns an error if they are more than the rest of the budget.
    pub fn claim(&self, bytes: u64) -> Result<(), String> {
        self.budget.claim(bytes)
    }
}

/// Returns an error for a pipe or a device, which a reader cannot open more than once.
pub fn check_seekable(path: &Path) -> io::Result<()> {
    if fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Err(io::Error::other("it is a pipe or a device; expected a file"));
    }
    Ok(())
}

/// Opens a file or a pipe as input. A device may have no end, or wait for the keyboard.
///
/// # Errors
/// Returns an error if the file cannot be opened or is a device.
fn open(path: &Path) -> io::Result<File> {
    let file = File::open(path)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = file.metadata()?.file_type();
        if kind.is_char_device() || kind.is_block_device() {
            return Err(io::Error::other("it is a device; expected a file or a pipe"));
        }
    }
    Ok(file)
}

/// Reads all bytes: at most `most`, and what there is memory for.
fn read_to_end(from: impl Read, most: u64, memory: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(most.min(memory).saturating_add(1)).read_to_end(&mut bytes)?;
    let length = bytes.len() as u64;
    if length > most {
        return Err(io::Error::other("it does not end"));
    }
    if length > memory {
        let found = format!("it takes more memory than the {} that are left", ByteSize(memory));
        return Err(io::Error::new(io::ErrorKind::OutOfMemory, found));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_share_the_budget_and_temporary_contexts_give_it_back() {
        let context = ReadContext::with_memory(10);
        context.clone().claim(6).unwrap();
        assert!(context.claim(5).is_err());
        let temporary = context.temporary();
        temporary.clone().claim(4).unwrap();
        assert!(temporary.claim(1).is_err() && context.claim(1).is_err());
        drop(temporary);
        context.claim(4).unwrap();
        let refusal = context.claim(1).unwrap_err();
        assert!(refusal.contains("beside the 10"), "{refusal}");
    }

    #[test]
    fn held_memory_returns_unless_it_is_kept() {
        let context = ReadContext::with_memory(10);
        let mut held = context.hold(6).unwrap();
        held.add(2).unwrap();
        assert!(held.add(3).is_err() && context.hold(3).is_err());
        held.keep(5).unwrap();
        assert!(context.hold(6).is_err());
        drop(context.hold(5).unwrap());
        // More may be kept than was held.
        context.hold(1).unwrap().keep(4).unwrap();
        assert!(context.hold(1).unwrap().keep(2).is_err());
        assert!(context.claim(u64::MAX).is_err());
        context.claim(1).unwrap();
    }

    #[test]
    fn files_pipes_and_packed_files_stay_within_the_budget() {
        use std::io::Write;
        let folder = tempfile::tempdir().unwrap();
        let [plain, packed] = ["a", "a.gz"].map(|name| folder.path().join(name));
        fs::write(&plain, vec![b'x'; 5000]).unwrap();
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        gz.write_all(&vec![b'x'; 1_000_000]).unwrap();
        fs::write(&packed, gz.finish().unwrap()).unwrap();
        let small = ReadContext::with_memory(4000);
        for path in [&plain, &packed] {
            let refusal = small.bytes(path).unwrap_err().to_string();
            assert!(refusal.contains("memory"), "{refusal}");
        }
        // What is read for a time returns.
        let larger = ReadContext::with_memory(1_100_000);
        for _ in 0..3 {
            assert_eq!(larger.bytes(&packed).unwrap().len(), 1_000_000);
        }
        larger.claim(1_100_000).unwrap();
    }

    #[test]
    fn a_stopped_context_reads_and_claims_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "x").unwrap();
        let context = ReadContext::default();
        let clone = context.clone();
        assert!(clone.bytes(&path).is_ok() && clone.claim(1).is_ok());
        context.stop();
        assert!(clone.claim(1).is_err() && clone.temporary().claim(1).is_err());
        assert!(clone.bytes(&path).unwrap_err().to_string().contains("reading was stopped"));
    }

    #[test]
    fn threads_write_one_log_and_temporary_contexts_their_own() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b, c] = ["a", "b", "c"].map(|name| folder.path().join(name));
        for path in [&a, &b, &c] {
            fs::write(path, "x").unwrap();
        }
        let context = ReadContext::default();
        context.bytes(&a).unwrap();
        let temporary = context.temporary();
        temporary.bytes(&b).unwrap();
        std::thread::scope(|scope| scope.spawn(|| context.register(&c)).join().unwrap()).unwrap();
        let names =
            |files: &FileLog| files.iter().map(|(path, _)| path.to_owned()).collect::<Vec<_>>();
        assert_eq!(names(&context.files()), [a, c]);
        assert_eq!(names(&temporary.files()), [b]);
        let mut all = context.files();
        all.join(temporary.files());
        all.fill_digests().unwrap();
        let expected = blake3::hash(b"x").to_hex();
        assert!(all.iter().all(|(_, digest)| digest == Some(expected.as_str())));
    }
}
