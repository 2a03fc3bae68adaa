//! Files of a report: JSON, CSV, SVG, PNG and the page.

use super::inputs::ReportInputs;
use super::page::page;
use super::section::{ReportFailure, ReportSection};

/// Text of the page that the analyses do not give.
#[derive(Clone, Debug, Default)]
pub struct PageText {
    /// Notes of the reader of the lens file.
    pub notes: Vec<String>,
    /// Command that makes the report again.
    pub command: String,
}

/// A file of a report.
#[derive(Clone, Debug)]
pub struct ReportFile {
    /// Name in the folder of the report, such as "spot.svg".
    pub name: String,
    /// Its contents.
    pub bytes: Vec<u8>,
}

/// Returns all files of a report; the last is the page, "index.html".
pub(super) fn files(
    inputs: &ReportInputs,
    sections: &[ReportSection],
    text: &PageText,
) -> Result<Vec<ReportFile>, ReportFailure> {
    let mut files = Vec::new();
    let mut put = |name: String, bytes: Vec<u8>| files.push(ReportFile { name, bytes });
    let values: Vec<_> = sections.iter().map(|section| section.json(false)).collect();
    let json = format!("{:#}\n", serde_json::Value::Array(values));
    put("report.json".to_owned(), json.into_bytes());
    for section in sections {
        let named = |part: &str, extension: &str| match part.is_empty() {
            true => format!("{}.{extension}", section.name),
            false => format!("{}-{part}.{extension}", section.name),
        };
        for table in &section.tables {
            put(named(&table.name, "csv"), table.csv()?);
        }
        for plot in &section.plots {
            put(named(&plot.name, "svg"), plot.file().into_bytes());
        }
        for picture in &section.pictures {
            put(named(&picture.name, "png"), picture.png.clone());
        }
    }
    put("index.html".to_owned(), page(inputs, sections, text).into_bytes());
    Ok(files)
}
