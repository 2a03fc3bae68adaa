//! Output files: the one way to write a file, which refuses inputs.

#![allow(clippy::disallowed_methods, reason = "the owner of outputs")]

use std::collections::HashMap;
use std::fs::{self, File};
use std::io;
use std::path::{Component, Display, Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::identity::FileIdentities;
use super::replace::{folder, persist, remove_stale, resolve_links};
use super::{FileLog, path_excerpt};

/// A file that cannot be an output.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// It is an input, perhaps under another name.
    #[error(
        "cannot write {}: it is the same file as {}, an input",
        path_excerpt(path),
        path_excerpt(input)
    )]
    Input {
        /// The output.
        path: PathBuf,
        /// The name under which the file was read.
        input: PathBuf,
    },
    /// It is also another output.
    #[error(
        "cannot write {}: it is the same file as {}, another output",
        path_excerpt(path),
        path_excerpt(other)
    )]
    Output {
        /// The output.
        path: PathBuf,
        /// The name of the other output.
        other: PathBuf,
    },
}

/// The outputs of a command, beside the inputs that they must not replace.
///
/// Clones share all.
#[derive(Clone, Debug)]
pub struct Outputs(Arc<Mutex<KnownFiles>>);

#[derive(Debug, Default)]
struct KnownFiles {
    inputs: FileIdentities,
    /// The names of the outputs by their places.
    outputs: HashMap<PathBuf, PathBuf>,
}

/// A file that may be written: it is none of the inputs, under whatever name they were read.
///
/// There is no other way to write a file. It is checked when it is named, to refuse early, and again
/// when it is written, as links and inputs may have changed.
#[derive(Clone, Debug)]
pub struct OutputFile {
    path: PathBuf,
    known: Outputs,
    only_new: bool,
}

impl Outputs {
    /// Returns the outputs of a command with these inputs.
    pub fn beside(inputs: &FileLog) -> Self {
        let outputs = Self::without_inputs();
        outputs.protect(inputs);
        outputs
    }

    /// Returns the outputs of a program that has read no file.
    pub fn without_inputs() -> Self {
        Self(Arc::default())
    }

    /// Adds inputs. Outputs that are claimed already refuse to be written over them.
    pub fn protect(&self, inputs: &FileLog) {
        let mut known = self.known();
        inputs.iter().for_each(|(path, _)| known.inputs.add(path));
    }

    /// Names an output.
    ///
    /// # Errors
    /// Returns an error if it is an input or another output.
    pub fn claim(&self, path: impl Into<PathBuf>) -> Result<OutputFile, OutputError> {
        let file = self.file(path)?;
        let mut known = self.known();
        match known.outputs.insert(place(&file.path), file.path.clone()) {
            Some(other) => Err(OutputError::Output { path: file.path, other }),
            None => Ok(file),
        }
    }

    fn file(&self, path: impl Into<PathBuf>) -> Result<OutputFile, OutputError> {
        let file = OutputFile { path: path.into(), known: self.clone(), only_new: false };
        file.check().map(|()| file)
    }

    fn known(&self) -> MutexGuard<'_, KnownFiles> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl OutputFile {
    /// Returns the only output of a program with these inputs.
    ///
    /// # Errors
    /// Returns an error if it is an input.
    pub fn new(path: impl Into<PathBuf>, inputs: &FileLog) -> Result<Self, OutputError> {
        Outputs::beside(inputs).claim(path)
    }

    /// Returns an output with another name beside the same inputs.
    ///
    /// # Errors
    /// Returns an error if it is an input.
    pub fn renamed(&self, path: impl Into<PathBuf>) -> Result<Self, OutputError> {
        let file = self.known.file(path)?;
        Ok(Self { only_new: self.only_new, ..file })
    }

    /// Returns the output, which then replaces no file.
    #[must_use]
    pub fn only_new(self) -> Self {
        Self { only_new: true, ..self }
    }

    /// Returns the path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the path for a message.
    pub fn display(&self) -> Display<'_> {
        self.path.display()
    }

    /// Writes the file under a temporary name in the same folder, then renames it. The name holds
    /// either the complete new file or the previous one, even if the program or the machine stops. A
    /// symbolic link stays, and its target is replaced.
    ///
    /// # Errors
    /// Returns an error if the file is an input, is there although it must be new, or cannot be
    /// written. The previous file is then unchanged, and no temporary file is left.
    pub fn write(&self, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
        if self.only_new && self.path.symlink_metadata().is_ok() {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        // Links and inputs may change while the content is computed.
        persist(&self.resolved()?, fill, self.only_new, || self.check().map_err(same))
    }

    /// Opens the file to read it and to write more at its end. It is created if it is missing.
    ///
    /// # Errors
    /// Returns an error if the file is an input or cannot be opened.
    pub fn open_to_extend(&self) -> io::Result<File> {
        let path = self.resolved()?;
        File::options().create(true).read(true).write(true).truncate(false).open(path)
    }

    /// Removes the file. A link stays.
    ///
    /// # Errors
    /// Returns an error if the file is an input or cannot be removed.
    pub fn remove(&self) -> io::Result<()> {
        self.resolved().and_then(fs::remove_file)
    }

    /// Removes the temporary files that killed programs left when they wrote this file.
    pub fn remove_stale(&self) {
        remove_stale(&self.path);
    }

    fn resolved(&self) -> io::Result<PathBuf> {
        self.check().map_err(same)?;
        resolve_links(&self.path)
    }

    fn check(&self) -> Result<(), OutputError> {
        match self.known.known().inputs.find(&self.path) {
            Some(input) => {
                let (path, input) = (self.path.clone(), input.to_owned());
                Err(OutputError::Input { path, input })
            }
            None => Ok(()),
        }
    }
}

/// Returns the error of a write without the name of the output, which its caller adds.
fn same(error: OutputError) -> io::Error {
    let (OutputError::Input { input, .. } | OutputError::Output { other: input, .. }) = &error;
    io::Error::other(format!("it is the same file as {}, an input", path_excerpt(input)))
}

/// Returns the place of a file, which need not exist: the same for all names of one place.
fn place(path: &Path) -> PathBuf {
    let path = resolve_links(path).unwrap_or_else(|_| path.to_owned());
    if let Ok(real) = fs::canonicalize(&path) {
        return real;
    }
    let parent = match path.parent() {
        // Its folder may be missing, too.
        Some(parent) if parent != Path::new("") && path.file_name().is_some() => place(parent),
        _ => fs::canonicalize(folder(&path)).unwrap_or_default(),
    };
    let name = path.components().next_back().unwrap_or(Component::CurDir);
    match cfg!(any(windows, target_os = "macos")) {
        true => parent.join(name.as_os_str().to_ascii_lowercase()),
        false => parent.join(name),
    }
}

/// Checks that a file can be written, by a temporary file beside it.
///
/// # Errors
/// Returns an error if the path is a folder, or if the folder of the file cannot be written to.
pub fn check_writable(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    tempfile::tempfile_in(folder(&resolve_links(path)?)).map(drop)
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    fn folder_with_input() -> (tempfile::TempDir, FileLog) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "an input").unwrap();
        let mut inputs = FileLog::default();
        inputs.add(&path, None);
        (folder, inputs)
    }

    #[test]
    fn an_input_is_no_output_under_any_name() {
        let (folder, inputs) = folder_with_input();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("sub")).unwrap();
        fs::hard_link(path("a"), path("hard")).unwrap();
        let mut names = vec!["a", "./a", "sub/../a", "hard"];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("sub/../a", path("soft")).unwrap();
            names.push("soft");
        }
        for name in names {
            let refused = Outputs::beside(&inputs).claim(path(name)).unwrap_err().to_string();
            assert!(refused.contains("an input"), "{name}: {refused}");
        }
        OutputFile::new(path("b"), &inputs).unwrap();
    }

    #[test]
    fn what_becomes_an_input_after_the_claim_is_not_written() {
        let (folder, inputs) = folder_with_input();
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        let outputs = Outputs::without_inputs();
        let (late, link) = (outputs.claim(&a).unwrap(), outputs.claim(&b).unwrap());
        outputs.protect(&inputs);
        fs::hard_link(&a, &b).unwrap();
        for file in [&late, &link] {
            let refused = file.write(|file| file.write_all(b"new")).unwrap_err().to_string();
            assert!(refused.contains("an input"), "{refused}");
            assert!(file.remove().is_err() && file.open_to_extend().is_err());
        }
        fs::remove_file(&b).unwrap();
        // The link appears while the content is made.
        assert!(link.write(|_| fs::hard_link(&a, &b)).is_err());
        assert_eq!(fs::read(&a).unwrap(), b"an input");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 2, "nothing is left over");
    }

    #[test]
    fn two_outputs_are_two_files() {
        let (folder, inputs) = folder_with_input();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("sub")).unwrap();
        let outputs = Outputs::beside(&inputs);
        for name in ["x", "new/x", "new/y"] {
            outputs.claim(path(name)).unwrap();
        }
        for name in ["x", "./x", "sub/../x", "new/./x"] {
            let refused = outputs.claim(path(name)).unwrap_err().to_string();
            assert!(refused.contains("another output"), "{name}: {refused}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("x", path("soft")).unwrap();
            assert!(outputs.claim(path("soft")).is_err());
        }
    }

    #[test]
    fn a_new_file_replaces_none() {
        let (folder, inputs) = folder_with_input();
        let path = folder.path().join("b");
        let file = OutputFile::new(&path, &inputs).unwrap().only_new();
        let written = file.write(|file| {
            fs::write(&path, "another's")?;
            file.write_all(b"ours")
        });
        assert_eq!(written.unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read(&path).unwrap(), b"another's");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 2, "nothing is left over");
        fs::remove_file(&path).unwrap();
        file.write(|file| file.write_all(b"ours")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"ours");
        assert!(file.write(|_| Ok(())).is_err());
    }
}
