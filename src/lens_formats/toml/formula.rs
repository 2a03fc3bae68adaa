//! Glass with a dispersion formula of its own: the key `formula`.

use std::borrow::Cow;
use std::sync::Arc;

use super::value::Section;
use petzval_lens::LensError;
use petzval_spectrum::{Absorption, CatalogueGlass, Formula, Glass, InternalTransmittance};

const KEYS: [&str; 9] = [
    "kind",
    "name",
    "maker",
    "coefficients",
    "powers",
    "resonances",
    "range",
    "published",
    "transmittance",
];
const KINDS: &str = "sellmeier, schott, general, cauchy, herzberger, buchdahl, samples";

/// Most coefficients of a formula.
const MAX_COEFFICIENTS: usize = 2000;

/// Reads the glass of a surface by its formula, if it states one.
pub(super) fn read(section: &Section) -> Result<Option<Glass>, LensError> {
    let expected = "expected [[surface.formula]] with kind, coefficients and range, once";
    let tables = section.tables("formula", expected)?;
    let [table] = &tables[..] else {
        return match tables.is_empty() {
            true => Ok(None),
            false => Err(section.error("formula", "several formulas", expected)),
        };
    };
    table.reject_unknown_keys(&KEYS)?;
    let numbers = |key: &str| table.number_list(key, MAX_COEFFICIENTS);
    let grouped = |key: &str, size: usize| -> Result<Vec<f64>, LensError> {
        let all = numbers(key)?;
        match all.len() % size {
            0 => Ok(all),
            _ => {
                let found = format!("{} numbers in {key}", all.len());
                Err(table.error(key, found, format!("expected groups of {size}")))
            }
        }
    };
    let six = || -> Result<[f64; 6], LensError> {
        let all = numbers("coefficients")?;
        <[f64; 6]>::try_from(&all[..]).map_err(|_| {
            let found = format!("{} coefficients", all.len());
            table.error("coefficients", found, "expected six")
        })
    };
    let pairs = |all: &[f64]| all.chunks_exact(2).map(|v| [v[0], v[1]]).collect::<Box<[_]>>();
    let first = |all: &[f64], count: usize| match all.len() >= count {
        true => Ok(()),
        false => {
            let found = format!("{} coefficients", all.len());
            Err(table.error("coefficients", found, format!("expected {count} or more")))
        }
    };
    let formula = match table.string("kind")?.unwrap_or_default() {
        "sellmeier" => {
            let all = numbers("coefficients")?;
            first(&all, 3)?;
            Formula::Sellmeier { a: all[0], terms: pairs(&all[1..]) }
        }
        "schott" => Formula::Schott(six()?),
        "general" => {
            let resonances = grouped("resonances", 3)?;
            Formula::General {
                powers: pairs(&grouped("powers", 2)?),
                resonances: resonances.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect(),
            }
        }
        "cauchy" => Formula::Cauchy(pairs(&grouped("coefficients", 2)?)),
        "herzberger" => Formula::Herzberger(six()?),
        "buchdahl" => {
            let all = numbers("coefficients")?;
            first(&all, 2)?;
            Formula::Buchdahl { origin: [all[0], all[1]], v: all[2..].into() }
        }
        "samples" => {
            let samples = pairs(&grouped("coefficients", 2)?);
            if samples.is_empty() || !samples.is_sorted_by(|a, b| a[0] < b[0]) {
                let found = "samples that do not rise";
                let expected = "expected pairs of wavelength (nm) and index, in order";
                return Err(table.error("coefficients", found, expected));
            }
            Formula::Samples(samples)
        }
        other => {
            let found = format!("formula of kind \"{}\"", petzval_base::io::excerpt(other));
            return Err(table.error("kind", found, format!("expected {KINDS}")));
        }
    };
    let Some((_, range)) = table.number_pair("range", "expected range = [shortest, longest]")?
    else {
        let expected = "expected range = [shortest, longest], nm";
        return Err(table.error("range", "a formula without range", expected));
    };
    let text = |key: &str| -> Result<Cow<'static, str>, LensError> {
        Ok(Cow::Owned(table.string(key)?.unwrap_or_default().to_owned()))
    };
    let published = table.number_pair("published", "expected published = [nd, Vd]")?;
    let measured = grouped("transmittance", 3)?
        .chunks_exact(3)
        .map(|v| InternalTransmittance { nm: v[0], share: v[1], thickness: v[2] })
        .collect::<Vec<_>>();
    if let Some(InternalTransmittance { nm, share, thickness }) =
        measured.iter().find(|entry| !entry.is_valid())
    {
        let found = format!("the share {share} of {thickness} mm at {nm} nm");
        let expected = "expected wavelengths (nm), shares from 0 to 1 and thicknesses (mm)";
        return Err(table.error("transmittance", found, expected));
    }
    Ok(Some(Glass::Catalogue(Arc::new(CatalogueGlass {
        name: text("name")?,
        maker: text("maker")?,
        published: published.map(|(_, pair)| pair),
        formula,
        range,
        absorption: Absorption::new(measured),
    }))))
}

/// Writes the table of a glass.
pub(super) fn write(glass: &CatalogueGlass, text: &mut String) {
    let flat = |pairs: &[[f64; 2]]| pairs.concat();
    let list = |key: &str, numbers: &[f64]| format!("{key} = {numbers:?}\n");
    let (kind, body) = match &glass.formula {
        Formula::Sellmeier { a, terms } => {
            let all = [&[*a][..], &flat(terms)[..]].concat();
            ("sellmeier", list("coefficients", &all))
        }
        Formula::Schott(all) => ("schott", list("coefficients", all)),
        Formula::General { powers, resonances } => {
            let resonances = list("resonances", &resonances.concat());
            ("general", list("powers", &flat(powers)) + &resonances)
        }
        Formula::Cauchy(pairs) => ("cauchy", list("coefficients", &flat(pairs))),
        Formula::Herzberger(all) => ("herzberger", list("coefficients", all)),
        Formula::Buchdahl { origin, v } => {
            ("buchdahl", list("coefficients", &[&origin[..], &v[..]].concat()))
        }
        Formula::Samples(pairs) => ("samples", list("coefficients", &flat(pairs))),
    };
    text.push_str("[[surface.formula]]\n");
    for (key, value) in [("kind", kind), ("name", &glass.name), ("maker", &glass.maker)] {
        if !value.is_empty() {
            text.push_str(&format!("{key} = {value:?}\n"));
        }
    }
    text.push_str(&body);
    text.push_str(&list("range", &glass.range));
    if let Some(published) = &glass.published {
        text.push_str(&list("published", published));
    }
    let measured = glass.absorption.measured();
    if !measured.is_empty() {
        let entry = |entry: &InternalTransmittance| [entry.nm, entry.share, entry.thickness];
        let all: Vec<f64> = measured.iter().flat_map(entry).collect();
        text.push_str(&list("transmittance", &all));
    }
}
