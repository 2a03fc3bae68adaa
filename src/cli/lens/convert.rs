//! `petzval lens convert`: writes a lens file in another format.

use std::io::Write as _;
use std::path::PathBuf;

use petzval_base::io::{OutputFile, ReadContext};
use petzval_lens::Prescription;
use petzval_lens_formats::write_lens;

use crate::cli::arguments::lens_file::LensFileArguments;
use crate::cli::outputs::claim;
use crate::cli::{Failure, Outcome, message};

/// Arguments of `petzval lens convert`.
#[derive(Debug, clap::Args)]
pub(super) struct ConvertArguments {
    /// Lens file of any format that petzval reads
    lens: PathBuf,
    /// File to write
    ///
    /// .toml holds everything, .zmx (Zemax) all but coatings and some dispersion, .dat centred
    /// spheres without dispersion
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    file: LensFileArguments,
}

pub(super) fn run(arguments: &ConvertArguments) -> Result<Outcome, Failure> {
    let context = ReadContext::default();
    let lens = arguments.file.options().read(&arguments.lens, &context)?;
    super::warn_of_notes(&arguments.lens, &lens);
    let output = claim(&arguments.file.outputs(&context.files()), &arguments.output, "--output")?;
    save(&output, &lens)?;
    Ok(Outcome::Done)
}

/// Writes a lens file in the format of its name. Warns of what the format does not hold.
///
/// # Errors
/// Returns an error if the format cannot hold the lens, or the file cannot be written.
pub(super) fn save(output: &OutputFile, lens: &Prescription) -> Result<(), Failure> {
    let written = write_lens(output.path(), lens)?;
    message::file_warnings(output.path(), &written.notes);
    output
        .write(|file| file.write_all(written.text.as_bytes()))
        .map_err(|error| format!("cannot write the lens {}: {error}", output.display()))?;
    Ok(())
}
