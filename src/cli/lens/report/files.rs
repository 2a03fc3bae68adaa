//! Files of a report: JSON, CSV, SVG, PNG and the page.

use std::io::Write as _;
use std::path::Path;

use petzval_base::io::Outputs;

use super::inputs::ReportInputs;
use super::page::page;
use super::section::ReportSection;
use crate::cli::Failure;
use crate::cli::outputs::CreatedFolders;

/// Writes all files of a report to a folder, which is created, and returns their number.
///
/// # Errors
/// Returns an error if a file cannot be written, or, before any is, if one is an input.
pub(super) fn write(
    folder: &Path,
    inputs: &ReportInputs,
    sections: &[ReportSection],
    outputs: &Outputs,
) -> Result<usize, Failure> {
    let mut files = Vec::new();
    let mut put = |name: &str, bytes: &[u8]| -> Result<(), Failure> {
        let file = outputs.claim(folder.join(name));
        let file = file.map_err(|error| format!("{error}; name another folder with -o"))?;
        files.push((file, bytes.to_owned()));
        Ok(())
    };
    let values: Vec<_> = sections.iter().map(|section| section.json(false)).collect();
    let text = format!("{:#}\n", serde_json::Value::Array(values));
    put("report.json", text.as_bytes())?;
    for section in sections {
        let named = |part: &str, extension: &str| match part.is_empty() {
            true => format!("{}.{extension}", section.name),
            false => format!("{}-{part}.{extension}", section.name),
        };
        for table in &section.tables {
            put(&named(&table.name, "csv"), &table.csv()?)?;
        }
        for plot in &section.plots {
            put(&named(&plot.name, "svg"), plot.file().as_bytes())?;
        }
        for picture in &section.pictures {
            put(&named(&picture.name, "png"), &picture.png)?;
        }
    }
    put("index.html", page(inputs, sections).as_bytes())?;
    let mut folders = CreatedFolders::default();
    folders
        .create(folder)
        .map_err(|error| format!("cannot create the folder {}: {error}", folder.display()))?;
    for (file, bytes) in &files {
        file.write(|file| file.write_all(bytes))
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(files.len())
}
