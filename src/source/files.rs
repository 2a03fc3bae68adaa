//! Which files something was made of.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::Unreadable;

/// Files that were read as input, and a digest of each (BLAKE3): of what was read, where all of it
/// was at once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Files(BTreeMap<PathBuf, Option<String>>);

thread_local! {
    /// What the innermost [`reading`] of this thread has read so far. Readers call readers of other
    /// kinds; this is the one thing that all of them know.
    static OPEN: RefCell<Option<Files>> = const { RefCell::new(None) };
}

/// Reads, and answers with the files that were read meanwhile, by this thread. What it leaves to other
/// threads they read by a `reading` of their own, whose files are [noted](Files::noted) here.
pub fn reading<T>(read: impl FnOnce() -> T) -> (T, Files) {
    let around = OPEN.replace(Some(Files::default()));
    let answer = read();
    (answer, OPEN.replace(around).unwrap_or_default())
}

/// Notes a file, and what all of it holds where that is known.
pub(super) fn add(path: &Path, content: Option<&[u8]>) {
    OPEN.with_borrow_mut(|open| {
        let Some(Files(list)) = open else { return };
        let entry = list.entry(path.to_owned()).or_default();
        if let Some(content) = content {
            *entry = Some(blake3::hash(content).to_hex().to_string());
        }
    });
}

impl Files {
    /// Adds others.
    pub fn join(&mut self, others: Self) {
        for (path, digest) in others.0 {
            let entry = self.0.entry(path).or_default();
            *entry = digest.or(entry.take());
        }
    }

    /// Counts them as read by the [`reading`] of this thread.
    pub fn noted(self) {
        OPEN.with_borrow_mut(|open| {
            if let Some(open) = open {
                open.join(self);
            }
        });
    }

    /// Makes the digests that are not known yet, of what the files hold now.
    ///
    /// # Errors
    /// Where a file cannot be read again.
    pub fn digest(&mut self) -> Result<(), Unreadable> {
        for (path, known) in &mut self.0 {
            if known.is_none() {
                let source = |source| Unreadable { path: path.clone(), source };
                *known = Some(digest(path).map_err(source)?);
            }
        }
        Ok(())
    }

    /// The files, each with its digest where that is known.
    pub fn iter(&self) -> impl Iterator<Item = (&Path, Option<&str>)> {
        self.0.iter().map(|(path, digest)| (path.as_path(), digest.as_deref()))
    }
}

/// A digest of a file's content (BLAKE3).
///
/// # Errors
/// Where it cannot be read.
pub fn digest(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(File::open(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::{bytes, register};

    fn names(files: &Files) -> Vec<String> {
        let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
        files.iter().filter_map(|(path, _)| name(path)).collect()
    }

    #[test]
    fn every_reading_knows_its_own_files() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b, c] = ["a", "b", "c"].map(|name| folder.path().join(name));
        for path in [&a, &b, &c] {
            std::fs::write(path, "x").unwrap();
        }
        let (inner, outer) = reading(|| {
            bytes(&a).unwrap();
            let (_, inner) = reading(|| bytes(&b));
            let elsewhere = std::thread::spawn(move || reading(|| register(&c)).1);
            elsewhere.join().unwrap().noted();
            inner
        });
        assert_eq!(names(&inner), ["b"]);
        assert_eq!(names(&outer), ["a", "c"]);
        let mut all = outer;
        all.join(inner);
        assert_eq!(names(&all), ["a", "b", "c"]);
        all.digest().unwrap();
        let expected = blake3::hash(b"x").to_hex();
        assert!(all.iter().all(|(_, digest)| digest == Some(expected.as_str())));
    }
}
