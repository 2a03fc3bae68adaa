//! Read context: the memory budget that readers share, and the log of the files that they read.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use flate2::read::MultiGzDecoder;

use super::foreign::{refuse_placeholder, refuse_placeholder_file};
use super::{ByteSize, FileLog, ReadError};

/// Largest content of a pipe, whose size is not known (bytes).
const MAX_PIPE: u64 = 1 << 28;
/// Limit of the content of a gzip file: bytes of any file, and more for each of its packed bytes.
/// Scenes grow three to ten times.
const MAX_UNPACKED: u64 = 1 << 24;
const MAX_UNPACKED_RATIO: u64 = 100;

/// Memory budget and file log of the readers of input files.
///
/// Files declare sizes before their data follows. A reader checks each declared size against the
/// budget before it allocates, so that a scene that is too large is refused early, even if only the
/// sum of many files is too large. The log is the list of inputs on which a picture depends.
///
/// It also carries the paths of the glass catalogues that the user names, which readers of lenses need.
///
/// Clones share all. The default has no limit and no catalogue.
#[derive(Clone, Debug, Default)]
pub struct ReadContext {
    budget: Arc<Budget>,
    files: Arc<Mutex<FileLog>>,
    approximate: bool,
    catalogues: Arc<[PathBuf]>,
}

/// Bytes that readers may claim in all, and bytes that they have claimed.
#[derive(Debug)]
struct Budget {
    limit: u64,
    claimed: AtomicU64,
    stopped: AtomicBool,
}

impl Default for Budget {
    fn default() -> Self {
        Self { limit: u64::MAX, claimed: AtomicU64::new(0), stopped: AtomicBool::new(false) }
    }
}

impl Budget {
    fn check(&self, claimed: u64, bytes: u64) -> Result<(), String> {
        if self.stopped.load(Ordering::Relaxed) {
            return Err("reading was stopped".to_owned());
        }
        if claimed.saturating_add(bytes) <= self.limit {
            return Ok(());
        }
        let before = match claimed {
            0 => String::new(),
            _ => format!(" beside the {} read before", ByteSize(claimed)),
        };
        let limit = ByteSize(self.limit);
        Err(format!("it takes {} of memory{before}, and there are {limit}", ByteSize(bytes)))
    }
}

impl ReadContext {
    /// Creates a context whose readers may claim this many bytes in all.
    pub fn with_memory(limit: u64) -> Self {
        let budget = Budget { limit, ..Budget::default() };
        Self { budget: Arc::new(budget), ..Self::default() }
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

    /// Returns the paths of the glass catalogues.
    pub fn catalogues(&self) -> &[PathBuf] {
        &self.catalogues
    }

    /// Returns a context for data that is dropped after use: its readers may claim what is left of
    /// this budget, but those claims do not count here. Its log is empty.
    #[must_use]
    pub fn temporary(&self) -> Self {
        let claimed = AtomicU64::new(self.budget.claimed.load(Ordering::Relaxed));
        let stopped = AtomicBool::new(self.budget.stopped.load(Ordering::Relaxed));
        let budget = Budget { limit: self.budget.limit, claimed, stopped };
        let (catalogues, approximate) = (self.catalogues.clone(), self.approximate);
        Self { budget: Arc::new(budget), files: Arc::default(), catalogues, approximate }
    }

    /// Stops the readers of this context: the next file or allocation is an error.
    pub fn stop(&self) {
        self.budget.stopped.store(true, Ordering::Relaxed);
    }

    /// Returns the files read so far.
    pub fn files(&self) -> FileLog {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Returns the content of a file, unpacked if it is gzipped, and logs it.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, does not end, unpacks to more than 100 times its
    /// size, or is a pointer of Git LFS or a web page.
    pub fn bytes(&self, path: &Path) -> Result<Vec<u8>, ReadError> {
        let read = || {
            let file = open(path)?;
            let length = file.metadata()?.len();
            self.check(length)
                .map_err(|found| io::Error::new(io::ErrorKind::OutOfMemory, found))?;
            let packed = read_to_end(file, length.max(MAX_PIPE))?;
            self.log(path, &packed);
            refuse_placeholder(&packed)?;
            if !packed.starts_with(&[0x1f, 0x8b]) {
                return Ok(packed);
            }
            let most = MAX_UNPACKED + MAX_UNPACKED_RATIO * packed.len() as u64;
            read_to_end(MultiGzDecoder::new(&packed[..]), most)
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
    pub(crate) fn log(&self, path: &Path, content: &[u8]) {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).add(path, Some(content));
    }

    /// Returns an error if an allocation is larger than the rest of the budget. Claims nothing.
    pub(crate) fn check(&self, bytes: u64) -> Result<(), String> {
        self.budget.check(self.budget.claimed.load(Ordering::Relaxed), bytes)
    }

    /// Claims bytes, or returns an error if they are more than the rest of the budget.
    pub(crate) fn claim(&self, bytes: u64) -> Result<(), String> {
        let mut granted = Ok(());
        let add = |claimed: u64| {
            granted = self.budget.check(claimed, bytes);
            granted.is_ok().then(|| claimed + bytes)
        };
        let _ = self.budget.claimed.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add);
        granted
    }
}

/// Returns an error for a pipe or a device, which a reader cannot open more than once.
pub(crate) fn check_seekable(path: &Path) -> io::Result<()> {
    if fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Err(io::Error::other("it is a pipe or a device; expected a file"));
    }
    Ok(())
}

/// Opens a file or a pipe as input. A device may have no end, or wait for the keyboard.
///
/// # Errors
/// Returns an error if the file cannot be opened or is a device.
pub fn open(path: &Path) -> io::Result<File> {
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

fn read_to_end(from: impl Read, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(most + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > most {
        true => Err(io::Error::other("it does not end")),
        false => Ok(bytes),
    }
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
        temporary.claim(4).unwrap();
        assert!(temporary.claim(1).is_err());
        context.claim(4).unwrap();
        let refusal = context.check(1).unwrap_err();
        assert!(refusal.contains("beside the 10"), "{refusal}");
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
