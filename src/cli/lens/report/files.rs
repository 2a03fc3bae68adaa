//! Files of a report: JSON, CSV, SVG, PNG and the page.

use std::io::Write as _;
use std::path::Path;

use petzval::io::replace_file;

use super::inputs::ReportInputs;
use super::page::page;
use super::section::ReportSection;
use crate::cli::Failure;

/// Writes all files of a report to a folder, which is created, and returns their number.
///
/// # Errors
/// Returns an error if a file cannot be written.
pub(super) fn write(
    folder: &Path,
    inputs: &ReportInputs,
    sections: &[ReportSection],
) -> Result<usize, Failure> {
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot create the folder {}: {error}", folder.display()))?;
    let mut count = 0;
    let mut put = |name: &str, bytes: &[u8]| -> Result<(), Failure> {
        let path = folder.join(name);
        replace_file(&path, |file| file.write_all(bytes))
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
        count += 1;
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
    Ok(count)
}
