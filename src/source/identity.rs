//! Identity of files: whether two names stand for the same file.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::Files;

/// Files that were read, by identity: by device and inode, which hard links share, and by the path
/// without symbolic links, where a system has no inodes or a network file system changes them.
#[derive(Clone, Debug, Default)]
pub struct Identities<'a> {
    inodes: HashMap<[u64; 2], &'a Path>,
    paths: HashMap<PathBuf, &'a Path>,
}

impl<'a> Identities<'a> {
    /// The identities of these files. A file that is gone has none.
    pub fn of(files: &'a Files) -> Self {
        let mut identities = Self::default();
        for (path, _) in files.iter() {
            if let Some(inode) = inode(path) {
                identities.inodes.entry(inode).or_insert(path);
            }
            if let Ok(real) = fs::canonicalize(path) {
                identities.paths.entry(real).or_insert(path);
            }
        }
        identities
    }

    /// The name under which the file was read that this name stands for, too.
    pub fn find(&self, path: &Path) -> Option<&'a Path> {
        let by_inode = inode(path).and_then(|inode| self.inodes.get(&inode));
        let by_path = || self.paths.get(&fs::canonicalize(path).ok()?);
        by_inode.or_else(by_path).copied()
    }
}

/// Device and inode of the file behind all symbolic links.
#[cfg(unix)]
fn inode(path: &Path) -> Option<[u64; 2]> {
    use std::os::unix::fs::MetadataExt;
    let found = fs::metadata(path).ok()?;
    Some([found.dev(), found.ino()])
}

#[cfg(not(unix))]
fn inode(_: &Path) -> Option<[u64; 2]> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::{reading, register};

    #[test]
    fn every_name_of_a_file_stands_for_it_and_a_copy_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "x").unwrap();
        fs::write(path("copy"), "x").unwrap();
        fs::create_dir(path("sub")).unwrap();
        fs::hard_link(path("a"), path("hard")).unwrap();
        let (_, files) = reading(|| register(&path("a")));
        let identities = Identities::of(&files);
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
