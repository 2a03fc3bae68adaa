//! Checks of output files before any work, and the folders that they need.
//!
//! Neither a long render nor a file that the command reads may be lost at the end.

use std::collections::HashSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use petzval::io::resolve_links;
use petzval::io::{FileIdentities, FileLog};

use super::Failure;

/// Checks that a file can be written. `option` is the one that names another.
///
/// # Errors
/// Returns an error if the name is that of a folder or its folder cannot be written to.
pub(super) fn check_writable(output: &Path, option: &str) -> Result<(), Failure> {
    if output.is_dir() {
        return Err(format!("{} is a folder; name a file in it", output.display()).into());
    }
    let write = || {
        let file = resolve_links(output)?;
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        tempfile::tempfile_in(folder.unwrap_or(Path::new(".")))
    };
    match write() {
        Ok(_) => Ok(()),
        Err(error) => Err(format!(
            "cannot write {}: {error}; name another file with {option}",
            output.display()
        )
        .into()),
    }
}

/// Checks that no output is an input, under whatever name it was read. Every command that writes
/// calls this with all names that it may write to. `option` is the one that gives other names.
///
/// # Errors
/// Returns an error if an output is an input.
pub(super) fn check_distinct<P: AsRef<Path>>(
    outputs: impl IntoIterator<Item = P>,
    option: &str,
    inputs: &FileLog,
) -> Result<(), Failure> {
    let inputs = FileIdentities::of(inputs);
    for output in outputs {
        let output = output.as_ref();
        if let Some(input) = inputs.find(output) {
            return Err(format!(
                "cannot write {}: it is the same file as {}, an input of this command; name \
                 another file with {option}",
                output.display(),
                input.display()
            )
            .into());
        }
    }
    Ok(())
}

/// Folders that this command created. Those that are still empty are removed on drop.
#[derive(Default)]
pub(super) struct CreatedFolders(Vec<PathBuf>);

impl CreatedFolders {
    /// Creates the missing folders of these pictures, and checks that the pictures can be written.
    pub fn for_pictures(pictures: &[PathBuf]) -> Result<Self, Failure> {
        let (mut folders, mut seen) = (Self::default(), HashSet::new());
        for picture in pictures {
            let folder = picture.parent().unwrap_or(Path::new(""));
            if seen.insert(folder) {
                let made = folders.create(folder);
                made.map_err(|error| format!("cannot write {}: {error}", picture.display()))?;
                check_writable(picture, "-o")?;
            }
        }
        Ok(folders)
    }

    /// Creates a folder and its missing parents.
    pub fn create(&mut self, folder: &Path) -> io::Result<()> {
        let missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let missing: Vec<&Path> = folder.ancestors().take_while(missing).collect();
        for folder in missing.into_iter().rev() {
            // Another machine's sweep may create it at the same time.
            fs::create_dir_all(folder)?;
            self.0.push(folder.to_owned());
        }
        Ok(())
    }
}

impl Drop for CreatedFolders {
    fn drop(&mut self) {
        for folder in self.0.iter().rev() {
            // Fails if there is something in it.
            let _ = fs::remove_dir(folder);
        }
    }
}
