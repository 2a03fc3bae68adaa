//! Checks of output files before any work, and the folders that they need.
//!
//! Neither a long render nor a file that the command reads may be lost at the end.

use std::collections::HashSet;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use petzval_base::io::{OutputFile, Outputs};

use super::Failure;

/// Checks that a file can be written. `option` is the one that names another.
///
/// # Errors
/// Returns an error if the name is that of a folder or its folder cannot be written to.
pub(super) fn check_writable(output: &Path, option: &str) -> Result<(), Failure> {
    let shown = output.display();
    if output.is_dir() {
        return Err(format!("{shown} is a folder; name a file in it").into());
    }
    petzval_base::io::check_writable(output)
        .map_err(|error| format!("cannot write {shown}: {error}; name another file with {option}"))
        .map_err(Failure::from)
}

/// Names an output, which is neither an input, under whatever name it was read, nor another output.
/// `option` is the one that gives another name.
///
/// # Errors
/// Returns an error if the output is refused.
pub(super) fn claim(
    outputs: &Outputs,
    output: impl Into<PathBuf>,
    option: &str,
) -> Result<OutputFile, Failure> {
    let claimed = outputs.claim(output);
    claimed.map_err(|error| format!("{error}; name another file with {option}").into())
}

/// Names an output as [`claim`] does, and checks that it can be written.
///
/// # Errors
/// Returns an error if the output is refused or cannot be written.
pub(super) fn claim_writable(
    outputs: &Outputs,
    output: &Path,
    option: &str,
) -> Result<OutputFile, Failure> {
    let file = claim(outputs, output, option)?;
    check_writable(output, option).map(|()| file)
}

/// Writes a text to the file of an option.
///
/// # Errors
/// As [`claim_writable`].
pub(super) fn write_text(
    outputs: &Outputs,
    path: &Path,
    option: &str,
    text: &str,
) -> Result<(), Failure> {
    let file = claim_writable(outputs, path, option)?;
    file.write(|file| file.write_all(text.as_bytes()))
        .map_err(|error| format!("cannot write {}: {error}", file.display()).into())
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
        match folder.as_os_str().is_empty() || folder.is_dir() {
            true => Ok(()),
            false => Err(io::ErrorKind::NotADirectory.into()),
        }
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
