//! Multi-configuration operands of a Zemax file.

use std::fmt::Write as _;

use super::{INFINITE, Space};
use petzval_lens::Prescription;
use petzval_lens::{Configuration, Quantity};

/// Writes the states of a lens; empty for a lens with one. `spaces` gives the surface behind each row,
/// `by_f_number` whether the file opens the stop to an f-number.
pub(super) fn write(
    lens: &Prescription,
    spaces: &[Space],
    by_f_number: bool,
    notes: &mut Vec<String>,
) -> String {
    let states = &lens.design.configurations;
    if states.len() < 2 {
        if !states.is_empty() {
            notes.push("a .zmx file has no single state beside the lens; it is not written".into());
        }
        return String::new();
    }
    let mut text = format!("MNUM {} 1\n", states.len());
    let mut operand = |keyword: &str, surface: usize, values: Vec<f64>| {
        for (number, value) in (1..).zip(values) {
            let _ = writeln!(text, "{keyword} {surface} {number} {value:?} 0 0 1 1 0 0 0.0 \"\"");
        }
    };
    if states.iter().any(|state| state.object_distance.is_some()) {
        let own = lens.design.object_distance;
        let near = |state: &Configuration| {
            let distance = state.object_distance.or(own).unwrap_or(f64::INFINITY);
            if distance.abs() < INFINITE { distance } else { 1e10 }
        };
        operand("THIC", 0, states.iter().map(near).collect());
    }
    let last = lens.rows.len() - 1;
    let travel = lens.travel_before(lens.rows.len());
    for (i, row) in lens.rows.iter().enumerate() {
        let Space { surface, thickness } = spaces[i];
        for (quantity, stated) in [
            (Quantity::Thickness, row.thickness),
            (Quantity::Curvature, row.curvature()),
            (Quantity::Diameter, row.diameter),
        ] {
            let value = |state: &Configuration| {
                let own = |s: &&_| same(s, i, quantity);
                state.settings.iter().find(own).map(|setting| setting.value)
            };
            if i == last && quantity == Quantity::Thickness
                || states.iter().all(|state| value(state).is_none())
            {
                continue;
            }
            let values = states.iter().map(|state| value(state).unwrap_or(stated));
            match quantity {
                // A part of the space may stand behind a coordinate break.
                Quantity::Thickness if thickness != stated => {
                    operand("THIC", surface, values.map(|v| thickness + (v - stated)).collect());
                }
                Quantity::Thickness => operand("THIC", surface, values.collect()),
                Quantity::Curvature => operand("CRVT", surface, values.collect()),
                Quantity::Diameter => operand("SDIA", surface, values.map(|v| v / 2.0).collect()),
            }
        }
    }
    if states.iter().any(|state| state.film_distance.is_some()) {
        let Space { surface, thickness } = spaces[last];
        let stated = lens.design.film_distance.unwrap_or(0.0);
        let place = |state: &Configuration| {
            let film = state.film_distance.unwrap_or(stated);
            if thickness == travel * stated {
                travel * film
            } else {
                thickness + travel * (film - stated)
            }
        };
        operand("THIC", surface, states.iter().map(place).collect());
    }
    let f_numbers = states.iter().filter(|state| state.f_number.is_some()).count();
    if by_f_number && f_numbers > 0 {
        let own = lens.stated_f_number.unwrap_or_default();
        let numbers = states.iter().map(|state| state.f_number.unwrap_or(own));
        operand("APER", 0, numbers.collect());
    } else if f_numbers > 0 {
        notes.push("the f-numbers of the states are not written".into());
    }
    if states.iter().any(|state| state.focal_length.is_some() || state.magnification.is_some()) {
        notes.push(
            "the stated focal lengths and magnifications of the states are not written".into(),
        );
    }
    let numbered =
        (1..).zip(states).all(|(number, state): (usize, _)| state.name == number.to_string());
    if !numbered && states.iter().any(|state| !state.name.is_empty()) {
        notes.push("the names of the states are not written; they are numbered".into());
    }
    text
}

pub fn same(setting: &petzval_lens::Setting, row: usize, quantity: Quantity) -> bool {
    (setting.row, setting.quantity) == (row, quantity)
}
