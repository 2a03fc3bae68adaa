//! Files of an analysis: a table of the trials, and one of its lenses.

use std::io::Write as _;

use petzval_base::io::OutputFile;

use super::super::convert::save;
use super::ToleranceArguments;
use super::sample::ToleranceSample;
use super::table::limits;
use crate::cli::Failure;

/// Writes figures and deviations of each trial, with all digits.
pub(super) fn write_csv(file: &OutputFile, sample: &ToleranceSample) -> Result<(), Failure> {
    let analysis = &sample.analysis;
    let mut head = vec!["trial".to_owned(), "spot_mm".to_owned(), "mtf".to_owned()];
    head.push("film_movement_mm".to_owned());
    for field in analysis.fields() {
        head.extend(["spot_mm", "mtf_x", "mtf_y"].map(|name| format!("{name} at {field:.4}")));
    }
    for parameter in &analysis.parameters {
        let name = format!("{parameter} ({})", parameter.kind.unit());
        head.push(name.trim_end_matches(" ()").to_owned());
    }
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(&head)?;
    for (number, trial) in sample.trials.iter().enumerate() {
        let figures = &trial.figures;
        let mut row = vec![number.to_string()];
        let mut put = |value: f64| row.push(format!("{value:?}"));
        [figures.spot(), figures.modulation(), figures.defocus].into_iter().for_each(&mut put);
        for (spot, [x, y]) in figures.spots.iter().zip(&figures.modulations) {
            [*spot, *x, *y].into_iter().for_each(&mut put);
        }
        trial.deviations.iter().copied().for_each(&mut put);
        writer.write_record(&row)?;
    }
    let bytes = writer.into_inner().map_err(|error| error.to_string())?;
    file.write(|file| file.write_all(&bytes))
        .map_err(|error| format!("cannot write the table {}: {error}", file.display()))?;
    Ok(())
}

/// Writes the lens of the rank that the arguments name, and says where its film is.
pub(super) fn write_lens(
    file: &OutputFile,
    source: &str,
    sample: &ToleranceSample,
    arguments: &ToleranceArguments,
) -> Result<(), Failure> {
    let rank = arguments.worst;
    let number = sample.ranked[rank as usize - 1];
    let trial = &sample.trials[number];
    let mut lens = sample.analysis.lens(trial);
    lens.name = format!("{}, trial {number} of seed {}", lens.name, arguments.seed);
    lens.source = Some(format!(
        "number {rank} from the worst of {} trials of {source}; tolerances: {}",
        sample.trials.len(),
        limits(&arguments.limits())
    ));
    save(file, &lens)?;
    say!(
        "petzval: {}: trial {number}, spot {:.2} um, MTF {:.3}, film {:.4} mm behind the rear vertex",
        file.display(),
        1e3 * trial.figures.spot(),
        trial.figures.modulation(),
        lens.design.film_distance.unwrap_or(f64::NAN)
    );
    Ok(())
}
