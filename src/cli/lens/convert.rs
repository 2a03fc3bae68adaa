//! `petzval lens convert`: writes a lens file in another format.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use petzval::io::{ReadContext, replace_file};
use petzval::lens::{Prescription, write_lens};

use crate::cli::arguments::lens_file::LensFileArguments;
use crate::cli::outputs::check_distinct;
use crate::cli::{Failure, Outcome};

/// Arguments of `petzval lens convert`.
#[derive(Debug, clap::Args)]
pub(super) struct ConvertArguments {
    /// Lens file of any format that petzval reads
    lens: PathBuf,
    /// File to write: .toml holds everything, .zmx (Zemax) all but coatings and
    /// some dispersion, .dat centred spheres without dispersion
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    file: LensFileArguments,
}

pub(super) fn run(arguments: &ConvertArguments) -> Result<Outcome, Failure> {
    let context = ReadContext::default();
    let lens = arguments.file.options().read(&arguments.lens, &context)?;
    super::warn_of_notes(&arguments.lens, &lens);
    check_distinct([&arguments.output], "--output", &context.files())?;
    save(&arguments.output, &lens)?;
    Ok(Outcome::Done)
}

/// Writes a lens file in the format of its name. Warns of what the format does not hold.
///
/// # Errors
/// Returns an error if the format cannot hold the lens, or the file cannot be written.
pub(super) fn save(output: &Path, lens: &Prescription) -> Result<(), Failure> {
    let written = write_lens(output, lens)?;
    for note in &written.notes {
        say!("petzval: warning: {}: {note}", output.display());
    }
    replace_file(output, |file| file.write_all(written.text.as_bytes()))
        .map_err(|error| format!("cannot write the lens {}: {error}", output.display()))?;
    Ok(())
}
