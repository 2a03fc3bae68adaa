//! What shows all pictures of a sweep: the contact sheet and the table.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use petzval::contact::Contact;
use petzval::image::{Encoding, Exposure, Note, Notes, Picture, Window};
use petzval::memory::budget;

use super::super::Failure;
use super::super::inputs::line;
use super::orders::Orders;
use super::table::{self, Entry, Row};

/// How many times as long as writing takes nothing is written.
const PATIENCE: u32 = 50;

/// The contact sheet and the table, and what is on them.
pub(super) struct Proofs {
    pub sheet: PathBuf,
    pub table: PathBuf,
    contact: Contact,
    exposure: Exposure,
    notes: Notes,
    options: Vec<String>,
    /// Of pictures that are finished, by number.
    rows: BTreeMap<usize, Entry>,
    /// What the table says of pictures until they are taken again, by number; and of others.
    before: BTreeMap<usize, Entry>,
    others: Vec<Entry>,
    /// When it was written last, and how long that took.
    written: Instant,
    took: Duration,
}

impl Proofs {
    /// Of no pictures yet. `size` is about that of each, pixels; `words` are the command.
    pub fn new(
        title: String,
        orders: &Orders,
        [sheet, table]: [PathBuf; 2],
        size: [u32; 2],
        exposure: Exposure,
        words: &[String],
    ) -> Self {
        let options = orders.axes.iter().map(|axis| axis.name.clone()).collect();
        let notes = vec![
            ("Title", Note::Text(format!("Contact sheet: {title}"))),
            ("software", Note::Text(format!("petzval {}", env!("CARGO_PKG_VERSION")))),
            ("commandLine", Note::Text(line(words))),
        ];
        let contact = Contact::new(title, orders.shown(), size);
        Self {
            sheet,
            table,
            contact,
            exposure,
            notes,
            options,
            rows: BTreeMap::new(),
            before: BTreeMap::new(),
            others: Vec::new(),
            written: Instant::now(),
            took: Duration::ZERO,
        }
    }

    /// Reads the table that is there. Answers which of these pictures it knows, with what it says.
    pub fn read(&mut self, names: &[PathBuf]) -> Result<Vec<(usize, Row)>, Failure> {
        let entries = table::read(&self.table, &self.options)?;
        let numbers: HashMap<String, usize> =
            names.iter().enumerate().map(|(number, name)| (self.named(name), number)).collect();
        for entry in entries {
            match numbers.get(&entry.0) {
                Some(&number) => drop(self.before.insert(number, entry)),
                None => self.others.push(entry),
            }
        }
        Ok(self.before.iter().map(|(&number, (_, _, row))| (number, row.clone())).collect())
    }

    /// A picture's name as the table has it.
    fn named(&self, picture: &Path) -> String {
        table::name(self.table.parent().unwrap_or(Path::new("")), picture)
    }

    /// What is known of a picture.
    pub fn row(&self, number: usize) -> Option<&Row> {
        self.rows.get(&number).map(|(_, _, row)| row)
    }

    /// How many pictures are finished.
    pub fn done(&self) -> usize {
        self.rows.len()
    }

    /// Adds a finished picture.
    pub fn put(&mut self, number: usize, name: &Path, values: &[&str], row: Row) {
        if self.contact.shows(number) {
            // Of the picture only its thumbnail stays.
            match budget::lent(|| Picture::read(name, true)) {
                Ok(picture) => self.contact.put(number, &picture),
                Err(error) => say!("petzval: warning: {error}; its place on the sheet stays empty"),
            }
        }
        let values = values.iter().map(|&value| value.to_owned()).collect();
        self.before.remove(&number);
        self.rows.insert(number, (self.named(name), values, row));
    }

    /// Takes out a picture that is to be taken again.
    pub fn drop(&mut self, number: usize) {
        let entry = self.rows.remove(&number);
        self.before.extend(entry.map(|entry| (number, entry)));
        self.contact.remove(number);
    }

    /// Writes what there is, where that takes little of the time.
    pub fn keep(&mut self) {
        if self.written.elapsed() >= self.took * PATIENCE
            && let Err(error) = self.write()
        {
            say!("petzval: warning: {error}; the sweep goes on");
        }
    }

    /// Writes the contact sheet and the table.
    pub fn write(&mut self) -> Result<(), Failure> {
        let begun = Instant::now();
        let mine: BTreeMap<_, _> = self.before.iter().chain(&self.rows).collect();
        let entries = mine.into_values().chain(&self.others);
        let entries = entries.map(|(name, values, row)| (name, values, row));
        let written = table::write(&self.table, &self.options, entries);
        written.map_err(|error| format!("cannot write {}: {error}", self.table.display()))?;
        let sheet = self.contact.draw(self.exposure)?;
        let frame = sheet.size.map(|n| n as u32);
        let window = Window { origin: [0, 0], frame };
        sheet.write(&self.sheet, window, Encoding::default(), &self.notes)?;
        (self.written, self.took) = (Instant::now(), begun.elapsed());
        Ok(())
    }
}
