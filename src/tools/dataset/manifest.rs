//! The list of finished pairs: JSON lines, a row for each.
//!
//! A pair counts once its row is written, which happens after all its files are. A shard has a file
//! of its own, so that no two processes write to one; all files of the folder are read.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use super::DatasetError;
use petzval_base::io::{OutputFile, Outputs, check_writable};

/// The data of one pair and its files, as an object of JSON.
#[derive(Clone, Debug)]
pub struct ManifestRow(pub(super) Map<String, Value>);

/// The finished pairs of a folder.
#[derive(Debug)]
pub struct Manifest {
    /// The file that new rows are written to. It is created with its first row.
    pub path: PathBuf,
    output: OutputFile,
    file: Option<File>,
    folder: PathBuf,
    digest: String,
    done: BTreeSet<u32>,
}

impl Manifest {
    /// Reads the manifests of a folder, and names that of a shard, numbered from 1, to write to.
    /// `digest` is that of the specification.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read or written, if the manifest is an input, or if a row
    /// is of another specification.
    pub fn open(
        folder: &Path,
        digest: &str,
        [index, count]: [u32; 2],
        outputs: &Outputs,
    ) -> Result<Self, DatasetError> {
        let name = match count {
            1 => "manifest.jsonl".to_owned(),
            _ => format!("manifest.{index:05}-of-{count:05}.jsonl"),
        };
        let path = folder.join(name);
        let output = outputs.claim(&path)?;
        let mut done = BTreeSet::new();
        let entries = fs::read_dir(folder).map_err(DatasetError::io("read", folder))?;
        for entry in entries {
            let entry = entry.map_err(DatasetError::io("read", folder))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with("manifest.") && name.ends_with(".jsonl") {
                read_rows(&entry.path(), folder, digest, &mut done)?;
            }
        }
        check_writable(&path).map_err(DatasetError::io("write", &path))?;
        let (folder, digest) = (folder.to_owned(), digest.to_owned());
        Ok(Self { path, output, file: None, folder, digest, done })
    }

    /// Creates the file, or opens it behind its last whole row.
    ///
    /// # Errors
    /// Returns an error if it cannot be written.
    pub fn create(&mut self) -> Result<(), DatasetError> {
        if self.file.is_none() {
            let open = || {
                let mut file = self.output.open_to_extend()?;
                // A killed process may have left the beginning of a row.
                let mut text = Vec::new();
                file.read_to_end(&mut text)?;
                let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
                file.set_len(whole as u64)?;
                file.seek(SeekFrom::Start(whole as u64)).map(|_| file)
            };
            self.file = Some(open().map_err(DatasetError::io("write", &self.path))?);
        }
        Ok(())
    }

    /// Returns whether a pair is finished.
    pub fn has(&self, pair: u32) -> bool {
        self.done.contains(&pair)
    }

    /// Returns the number of finished pairs.
    pub fn len(&self) -> usize {
        self.done.len()
    }

    /// Returns whether no pair is finished.
    pub fn is_empty(&self) -> bool {
        self.done.is_empty()
    }

    /// Returns the folder of the data set.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Adds the row of a pair whose files are written.
    ///
    /// # Errors
    /// Returns an error if it cannot be written.
    pub fn add(&mut self, pair: u32, row: ManifestRow) -> Result<(), DatasetError> {
        let ManifestRow(mut row) = row;
        row.insert("spec".to_owned(), Value::String(self.digest.clone()));
        row.insert("petzval".to_owned(), Value::String(env!("CARGO_PKG_VERSION").to_owned()));
        let mut line = Value::Object(row).to_string();
        line.push('\n');
        self.create()?;
        if let Some(file) = &mut self.file {
            let written = file.write_all(line.as_bytes()).and_then(|()| file.sync_data());
            written.map_err(DatasetError::io("write", &self.path))?;
        }
        self.done.insert(pair);
        Ok(())
    }
}

/// Adds the pairs of a manifest whose files are there.
fn read_rows(
    path: &Path,
    folder: &Path,
    digest: &str,
    done: &mut BTreeSet<u32>,
) -> Result<(), DatasetError> {
    let text = fs::read_to_string(path).map_err(DatasetError::io("read", path))?;
    for (number, line) in text.split_inclusive('\n').enumerate() {
        if !line.ends_with('\n') {
            // The row was not finished.
            break;
        }
        let problem = |problem: &str| DatasetError::Manifest {
            path: path.to_owned(),
            line: number + 1,
            problem: problem.to_owned(),
        };
        let row: Map<String, Value> = serde_json::from_str(line)
            .map_err(|error| problem(&format!("this is no row of a data set: {error}")))?;
        let pair =
            row.get("pair").and_then(Value::as_u64).and_then(|pair| u32::try_from(pair).ok());
        let pair = pair.ok_or_else(|| problem("this row has no number \"pair\""))?;
        if row.get("spec").and_then(Value::as_str) != Some(digest) {
            return Err(problem(
                "this row is of another specification; choose another folder, or remove this one",
            ));
        }
        let files = row.get("files").and_then(Value::as_object);
        let whole = files.is_some_and(|files| files.values().all(|file| is_whole(folder, file)));
        if whole {
            done.insert(pair);
        }
    }
    Ok(())
}

/// Returns whether a file of a row is there with its size.
fn is_whole(folder: &Path, file: &Value) -> bool {
    let name = file.get("file").and_then(Value::as_str);
    let bytes = file.get("bytes").and_then(Value::as_u64);
    name.and_then(|name| folder.join(name).metadata().ok()).map(|found| found.len()) == bytes
}

/// Returns the name of a file in its folder.
pub(super) fn relative(folder: &Path, path: &Path) -> String {
    path.strip_prefix(folder).unwrap_or(path).to_string_lossy().into_owned()
}
