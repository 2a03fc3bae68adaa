//! Folders of outputs, which a command makes where there are none.

use std::collections::HashSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::Failure;
use super::outputs::check_writable;

/// Folders that were made. Those that nothing was put into go with it.
#[derive(Default)]
pub(super) struct Folders(Vec<PathBuf>);

impl Folders {
    /// Makes what is missing of the folders of these pictures, and sees whether they can be written to.
    pub fn of(pictures: &[PathBuf]) -> Result<Self, Failure> {
        let (mut folders, mut seen) = (Self::default(), HashSet::new());
        for picture in pictures {
            let folder = picture.parent().unwrap_or(Path::new(""));
            if seen.insert(folder) {
                let made = folders.make(folder);
                made.map_err(|error| format!("cannot write {}: {error}", picture.display()))?;
                check_writable(picture, "-o")?;
            }
        }
        Ok(folders)
    }

    /// Makes a folder, and those that it is in.
    pub fn make(&mut self, folder: &Path) -> io::Result<()> {
        let missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let missing: Vec<&Path> = folder.ancestors().take_while(missing).collect();
        for folder in missing.into_iter().rev() {
            // Another machine's sweep may make it, too.
            fs::create_dir_all(folder)?;
            self.0.push(folder.to_owned());
        }
        Ok(())
    }
}

impl Drop for Folders {
    fn drop(&mut self) {
        for folder in self.0.iter().rev() {
            // Not where there is something in it.
            let _ = fs::remove_dir(folder);
        }
    }
}
