//! Parts of a lens report: figures, tables and plots of an analysis.

use serde_json::{Map, Value, json};

use super::missing::Absence;
use super::picture::SectionPicture;
use crate::number::tidy;
use crate::plot::Plot;

/// Failure of an analysis, or of a file of it.
pub(super) type ReportFailure = Box<dyn std::error::Error + Send + Sync>;

/// Name of the column of the wavelength.
pub(super) const WAVELENGTH_COLUMN: &str = "wavelength_nm";

/// Rows from which a table is bulk: rays of spots, samples of images.
const BULK: usize = 5000;

/// Figures, tables and plots of an analysis.
#[derive(Debug, Default)]
pub struct ReportSection {
    /// Name on the command line and of the files.
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    /// Meaning of the figures: signs, references, units.
    pub(super) note: String,
    /// Single figures: name, value and unit.
    pub(super) figures: Vec<(String, f64, &'static str)>,
    pub(super) tables: Vec<Table>,
    pub(super) plots: Vec<Plot>,
    pub(super) pictures: Vec<SectionPicture>,
    /// Reasons for which columns or figures may lack numbers.
    pub(super) absences: Vec<Absence>,
    /// Sentences on numbers that are not there, and whether each is usual.
    pub(super) missing: Vec<(String, bool)>,
}

/// A table of numbers.
#[derive(Debug, Default)]
pub(super) struct Table {
    /// Name in files; the only table of a section has none.
    pub name: String,
    /// Names of the columns, with units.
    pub columns: Vec<String>,
    /// Rows; a number that does not exist is NaN, and the section says why.
    pub rows: Vec<Vec<f64>>,
    /// Columns of words behind the numbers: their names and cells.
    pub words: Vec<(&'static str, Vec<String>)>,
    /// Whether the page shows the table; long ones are only in the files.
    pub shown: bool,
}

impl Table {
    pub fn new(name: impl Into<String>, columns: &[&str], rows: Vec<Vec<f64>>) -> Self {
        let columns = columns.iter().map(|column| (*column).to_owned()).collect();
        Self { name: name.into(), columns, rows, words: Vec::new(), shown: false }
    }

    pub fn shown(self) -> Self {
        Self { shown: true, ..self }
    }

    /// Returns the table as CSV, with 15 digits; cells of numbers that do not exist are empty.
    ///
    /// # Errors
    /// Returns an error if a row has not as many cells as the table has columns.
    pub fn csv(&self) -> Result<Vec<u8>, ReportFailure> {
        let mut file = csv::Writer::from_writer(Vec::new());
        let names = self.words.iter().map(|(name, _)| *name);
        file.write_record(self.columns.iter().map(String::as_str).chain(names))?;
        let cell =
            |value: &f64| if value.is_nan() { String::new() } else { tidy(*value).to_string() };
        for (i, row) in self.rows.iter().enumerate() {
            let words = self.words.iter().map(|(_, cells)| cells[i].clone());
            file.write_record(row.iter().map(cell).chain(words))?;
        }
        Ok(file.into_inner()?)
    }
}

/// Returns a JSON number, or null if it is not finite.
pub(super) fn number(value: f64) -> Value {
    if value.is_finite() { json!(tidy(value)) } else { Value::Null }
}

impl ReportSection {
    /// Returns the section as JSON: its figures by name, its tables by columns and rows, and the
    /// reasons for numbers that are null. Bulk
    /// tables are there only if `bulk` is true.
    pub fn json(&self, bulk: bool) -> Value {
        let mut figures = Map::new();
        for (name, value, unit) in &self.figures {
            figures.insert(name.clone(), json!({ "value": number(*value), "unit": unit }));
        }
        let tables: Vec<Value> = self
            .tables
            .iter()
            .filter(|table| bulk || table.rows.len() <= BULK)
            .map(|table| {
                let words = |i: usize| table.words.iter().map(move |(_, cells)| json!(cells[i]));
                let rows: Vec<Vec<Value>> = table
                    .rows
                    .iter()
                    .enumerate()
                    .map(|(i, row)| row.iter().copied().map(number).chain(words(i)).collect())
                    .collect();
                let names = table.words.iter().map(|(name, _)| *name);
                let columns: Vec<&str> =
                    table.columns.iter().map(String::as_str).chain(names).collect();
                json!({ "name": table.name, "columns": columns, "rows": rows })
            })
            .collect();
        let missing: Vec<&str> = self.missing.iter().map(|(text, _)| text.as_str()).collect();
        json!({
            "analysis": self.name,
            "title": self.title,
            "note": self.note,
            "figures": figures,
            "tables": tables,
            "missing": missing,
        })
    }
}
