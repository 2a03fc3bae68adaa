//! Report of a sweep: the contact sheet and the table of its pictures.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use petzval_base::io::{OutputFile, ReadContext};
use petzval_image::{
    DisplayExposure, EncodingOptions, Note, Notes, Picture, PictureWindow, Transfer,
};

use super::plan::SweepPlan;
use super::table::{self, Entry, TableRow};
use crate::cli::Failure;
use crate::cli::arguments::argv::shell_line;
use petzval_report::contact_sheet::ContactSheet;

/// Least time between two writes, as a multiple of the time of a write.
const WRITE_INTERVAL: u32 = 50;

/// The contact sheet and the table, with the pictures on them.
pub(super) struct SweepReport {
    context: ReadContext,
    pub sheet_file: OutputFile,
    pub table: OutputFile,
    sheet: ContactSheet,
    exposure: DisplayExposure,
    notes: Notes,
    options: Vec<String>,
    /// Finished pictures, by number.
    rows: BTreeMap<usize, Entry>,
    /// Pictures of an earlier sweep that are to be rendered again, by number.
    before: BTreeMap<usize, Entry>,
    /// Lines of the table about other pictures.
    others: Vec<Entry>,
    /// Time of the last write.
    written: Instant,
    /// Duration of the last write.
    write_time: Duration,
}

impl SweepReport {
    /// Creates a report without pictures. `size` is the size of a picture (pixels), `argv` the
    /// command line of the sweep.
    pub fn new(
        title: String,
        plan: &SweepPlan,
        [sheet_file, table]: [OutputFile; 2],
        size: [u32; 2],
        exposure: DisplayExposure,
        argv: &[String],
        context: &ReadContext,
    ) -> Self {
        let options = plan.axes.iter().map(|axis| axis.name.clone()).collect();
        let notes = vec![
            ("Title", Note::Text(format!("Contact sheet: {title}"))),
            ("software", Note::Text(format!("petzval {}", env!("CARGO_PKG_VERSION")))),
            ("commandLine", Note::Text(shell_line(argv))),
        ];
        let sheet = ContactSheet::new(title, plan.sheet_axes(), size);
        Self {
            context: context.clone(),
            sheet_file,
            table,
            sheet,
            exposure,
            notes,
            options,
            rows: BTreeMap::new(),
            before: BTreeMap::new(),
            others: Vec::new(),
            written: Instant::now(),
            write_time: Duration::ZERO,
        }
    }

    /// Reads the existing table. Returns its lines about these pictures, by number.
    pub fn read(&mut self, names: &[PathBuf]) -> Result<Vec<(usize, TableRow)>, Failure> {
        let entries = table::read(self.table.path(), &self.options)?;
        let numbers: HashMap<String, usize> = names
            .iter()
            .enumerate()
            .map(|(number, name)| (self.name_in_table(name), number))
            .collect();
        for entry in entries {
            match numbers.get(&entry.name) {
                Some(&number) => drop(self.before.insert(number, entry)),
                None => self.others.push(entry),
            }
        }
        Ok(self.before.iter().map(|(&number, entry)| (number, entry.row.clone())).collect())
    }

    /// Returns a picture's name in the table.
    fn name_in_table(&self, picture: &Path) -> String {
        table::relative_name(self.table.path().parent().unwrap_or(Path::new("")), picture)
    }

    /// Returns the line of a finished picture.
    pub fn row(&self, number: usize) -> Option<&TableRow> {
        self.rows.get(&number).map(|entry| &entry.row)
    }

    /// Returns the number of finished pictures.
    pub fn done(&self) -> usize {
        self.rows.len()
    }

    /// Adds a finished picture.
    pub fn add(&mut self, number: usize, name: &Path, values: &[&str], row: TableRow) {
        if self.sheet.shows(number) {
            // Only the thumbnail stays in memory.
            match Picture::read_with(name, Transfer::Srgb, &self.context.temporary()) {
                Ok(picture) => self.sheet.put(number, &picture),
                Err(error) => say!("petzval: warning: {error}; its place on the sheet stays empty"),
            }
        }
        let values = values.iter().map(|&value| value.to_owned()).collect();
        self.before.remove(&number);
        let name = self.name_in_table(name);
        self.rows.insert(number, Entry { name, values, row });
    }

    /// Removes a picture that is to be rendered again.
    pub fn remove(&mut self, number: usize) {
        let entry = self.rows.remove(&number);
        self.before.extend(entry.map(|entry| (number, entry)));
        self.sheet.remove(number);
    }

    /// Writes the report if writing takes little of the time.
    pub fn write_if_due(&mut self) {
        if self.written.elapsed() >= self.write_time * WRITE_INTERVAL
            && let Err(error) = self.write()
        {
            say!("petzval: warning: {error}; the sweep continues");
        }
    }

    /// Writes the contact sheet and the table.
    pub fn write(&mut self) -> Result<(), Failure> {
        let begun = Instant::now();
        let own: BTreeMap<_, _> = self.before.iter().chain(&self.rows).collect();
        let entries = own.into_values().chain(&self.others);
        let written = table::write(&self.table, &self.options, entries);
        written.map_err(|error| format!("cannot write {}: {error}", self.table.display()))?;
        let sheet = self.sheet.draw(self.exposure)?;
        let frame = sheet.size.map(|n| n as u32);
        let window = PictureWindow { origin: [0, 0], frame };
        sheet.write(&self.sheet_file, window, EncodingOptions::default(), &self.notes)?;
        (self.written, self.write_time) = (Instant::now(), begun.elapsed());
        Ok(())
    }
}
