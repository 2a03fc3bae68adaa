//! States of zoom and focus: the columns of `[variable distances]`.

use super::sections::{Cell, Sections, number};
use crate::text::Line;
use petzval_base::io::excerpt;
use petzval_lens::LensError;
use petzval_lens::system::SequentialSystem;
use petzval_lens::{Configuration, Quantity, Setting};

/// Greatest number of states, and of named values; more are not those of a lens.
const MOST: usize = 200;

/// A named line of values, one for each state.
struct Variable<'a> {
    name: &'a str,
    line: Line<'a>,
    values: Vec<Cell<'a>>,
}

/// The named values of every state.
pub(super) struct States<'a> {
    variables: Vec<Variable<'a>>,
    count: usize,
}

impl<'a> States<'a> {
    /// Reads the constants and the variable distances.
    ///
    /// # Errors
    /// Returns an error if there are too many states.
    pub fn read(sections: &Sections<'a>) -> Result<Self, LensError> {
        let mut variables = Vec::new();
        let mut count = 1;
        for section in ["variable distances", "constants"] {
            for (line, cells) in sections.rows(section) {
                let end =
                    cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
                let expected = "expected the states of zoom and focus of one lens";
                if end > MOST {
                    return Err(line.error(cells[0], format!("{end} columns"), expected));
                }
                if variables.len() == MOST {
                    return Err(line.error(cells[0], "more than 200 named values", expected));
                }
                let values: Vec<Cell<'a>> = cells[1..end.max(1)].to_vec();
                let is_distance = distance_number(cells[0]).is_some() || cells[0] == "Bf";
                if section == "variable distances"
                    && (is_distance || ["Focal Length", "Magnification"].contains(&cells[0]))
                {
                    count = count.max(values.len());
                }
                variables.push(Variable { name: cells[0], line: *line, values });
            }
        }
        Ok(Self { variables, count })
    }

    fn find(&self, name: &str) -> Option<&Variable<'a>> {
        self.variables.iter().find(|variable| variable.name.eq_ignore_ascii_case(name))
    }

    /// Returns a value of a state, if it is stated. A variable of one value has it in all states.
    ///
    /// # Errors
    /// Returns an error if the cell is no number.
    pub fn value(&self, name: &str, state: usize) -> Result<Option<f64>, LensError> {
        let Some(variable) = self.find(name) else { return Ok(None) };
        let cell = match variable.values[..] {
            [only] => only,
            _ => variable.values.get(state).copied().unwrap_or_default(),
        };
        match cell.to_ascii_lowercase().as_str() {
            "" | "undefined" | "na" | "n/a" | "nan" => Ok(None),
            "infinity" | "inf" | "∞" => Ok(Some(f64::INFINITY)),
            _ => number(&variable.line, cell).map(Some),
        }
    }

    /// Returns the thickness of a cell in the first state: a number, or the value of a name.
    ///
    /// # Errors
    /// Returns an error if it is neither, or infinite.
    pub fn thickness(&self, line: &Line<'_>, cell: Cell<'_>) -> Result<f64, LensError> {
        if !is_name(cell) {
            return if cell.is_empty() { Ok(0.0) } else { number(line, cell) };
        }
        if self.find(cell).is_none() {
            let found = format!("a thickness \"{}\" without a value", excerpt(cell));
            let expected = "expected a number, or a name from [variable distances] or [constants]";
            return Err(line.error(cell, found, expected));
        }
        match self.value(cell, 0)? {
            Some(value) if value.is_finite() => Ok(value),
            // Without a stated distance to the film the lens is focused.
            None if cell.eq_ignore_ascii_case("bf") => Ok(0.0),
            _ => {
                let found = format!("{} has no value in the first state", excerpt(cell));
                Err(line.error(cell, found, "expected a distance in [variable distances]"))
            }
        }
    }

    /// Adds the states to a system whose surfaces are complete.
    ///
    /// # Errors
    /// Returns an error if a value is no number.
    pub fn configure(
        &self,
        sections: &Sections<'_>,
        system: &mut SequentialSystem,
    ) -> Result<(), LensError> {
        if self.count < 2 {
            return Ok(());
        }
        let names: Vec<(usize, Cell<'_>)> = sections
            .rows("lens data")
            .filter(|(_, cells)| cells.len() >= 2)
            .enumerate()
            .filter_map(|(i, (_, cells))| cells.get(2).map(|&cell| (i, cell)))
            .filter(|(_, cell)| is_name(cell))
            .collect();
        let stop = system.surfaces.iter().position(|surface| surface.row.stop);
        for state in 0..self.count {
            let mut settings = Vec::new();
            let mut missing = Vec::new();
            for &(row, name) in &names {
                match self.value(name, state)? {
                    Some(value) if value.is_finite() => {
                        settings.push(Setting { row, quantity: Quantity::Thickness, value });
                    }
                    _ if name.eq_ignore_ascii_case("bf") => {}
                    _ => missing.push(name),
                }
            }
            if !missing.is_empty() {
                let names = missing.join(", ");
                system.design.notes.push(format!(
                    "state {} of {} is left out: the file gives it no {names}",
                    state + 1,
                    self.count
                ));
                continue;
            }
            if let (Some(row), Some(value)) = (stop, self.value("Aperture Diameter", state)?)
                && value > 0.0
                && value.is_finite()
            {
                settings.push(Setting { row, quantity: Quantity::Diameter, value });
            }
            system.design.configurations.push(Configuration {
                name: String::new(),
                focal_length: self.value("Focal Length", state)?,
                f_number: self.value("F-Number", state)?,
                object_distance: self.value("d0", state)?,
                magnification: self.value("Magnification", state)?,
                film_distance: None,
                settings,
            });
        }
        Ok(())
    }
}

/// Whether a thickness is a name and not a number.
fn is_name(cell: &str) -> bool {
    cell.starts_with(|first: char| first.is_alphabetic())
}

/// Number of the distance in a name such as "d12".
fn distance_number(name: &str) -> Option<u32> {
    name.strip_prefix(['d', 'D'])?.parse().ok()
}
