//! Names of files to write, looked at before any work: nothing may be lost at the end, neither a
//! long render nor a file that the command reads.

use std::path::Path;

use petzval::image::target;
use petzval::source::{Files, Identities};

use super::Failure;

/// Refuses a name that nothing can be written to. `option` is the one that gives another.
pub(super) fn check_writable(output: &Path, option: &str) -> Result<(), Failure> {
    if output.is_dir() {
        return Err(format!("{} is a folder; name a file in it", output.display()).into());
    }
    let write = || {
        let file = target(output)?;
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

/// Refuses names that stand for an input, under whatever name it was read. Every command that writes
/// calls this with all names that it may write to. `option` is the one that gives other names.
pub(super) fn check_distinct<P: AsRef<Path>>(
    outputs: impl IntoIterator<Item = P>,
    option: &str,
    inputs: &Files,
) -> Result<(), Failure> {
    let inputs = Identities::of(inputs);
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
