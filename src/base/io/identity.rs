//! Identity of files: whether two names stand for the same file.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The files that were read, by identity: by device and inode, which hard links share, and by the
/// canonical path, for systems without inodes and network file systems that change them.
#[derive(Debug, Default)]
pub(super) struct FileIdentities {
    inodes: HashMap<Inode, PathBuf>,
    paths: HashMap<PathBuf, PathBuf>,
}

/// A device and the number of an inode on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Inode {
    device: u64,
    number: u64,
}

impl FileIdentities {
    /// Adds a file. One that does not exist any more has no identity.
    pub fn add(&mut self, path: &Path) {
        if let Some(inode) = inode(path) {
            self.inodes.entry(inode).or_insert_with(|| path.to_owned());
        }
        if let Ok(real) = fs::canonicalize(path) {
            self.paths.entry(real).or_insert_with(|| path.to_owned());
        }
    }

    /// Returns the path under which a file was read, given any path of it.
    pub fn find(&self, path: &Path) -> Option<&Path> {
        let by_inode = inode(path).and_then(|inode| self.inodes.get(&inode));
        let by_path = || self.paths.get(&fs::canonicalize(path).ok()?);
        by_inode.or_else(by_path).map(PathBuf::as_path)
    }
}

/// Returns the inode of a file, following symbolic links.
#[cfg(unix)]
fn inode(path: &Path) -> Option<Inode> {
    use std::os::unix::fs::MetadataExt;
    let found = fs::metadata(path).ok()?;
    Some(Inode { device: found.dev(), number: found.ino() })
}

#[cfg(not(unix))]
fn inode(_: &Path) -> Option<Inode> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_path_of_a_file_identifies_it_and_that_of_a_copy_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "x").unwrap();
        fs::write(path("copy"), "x").unwrap();
        fs::create_dir(path("sub")).unwrap();
        fs::hard_link(path("a"), path("hard")).unwrap();
        let mut identities = FileIdentities::default();
        identities.add(&path("a"));
        let mut names = vec!["a", "sub/../a", "hard"];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("sub/../a", path("soft")).unwrap();
            names.push("soft");
        }
        for name in names {
            assert_eq!(identities.find(&path(name)), Some(path("a").as_path()), "{name}");
        }
        for name in ["copy", "gone", "sub"] {
            assert_eq!(identities.find(&path(name)), None, "{name}");
        }
    }
}
