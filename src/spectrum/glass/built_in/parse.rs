//! Reader of the text of built-in glasses.
//!
//! A line is a glass: its name ("*" before it marks a widespread one, "Maker/" one of another maker), nd and Vd as published ("-" for
//! none), the range (um), the letter of the formula, and its coefficients. "#" begins a comment.

use std::str::FromStr as _;

use crate::glass::model::model_formula;
use crate::glass::{Absorption, CatalogueGlass, Formula};

/// Returns the glasses of a text, and whether each is widespread. Lines that are not glasses are left
/// out; a test makes sure that there are none.
pub(super) fn table(
    maker: &'static str,
    text: &'static str,
) -> impl Iterator<Item = (CatalogueGlass, bool)> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.filter_map(move |line| glass(maker, line))
}

fn glass(maker: &'static str, line: &'static str) -> Option<(CatalogueGlass, bool)> {
    let mut words = line.split_ascii_whitespace();
    let name = words.next()?;
    let (name, common) = match name.strip_prefix('*') {
        Some(name) => (name, true),
        None => (name, false),
    };
    let (maker, name) = name.split_once('/').unwrap_or((maker, name));
    let [nd, vd] = [words.next()?, words.next()?].map(|word| f64::from_str(word).ok());
    let [low, high] = [words.next()?, words.next()?].map(f64::from_str);
    let letter = words.next()?;
    let numbers = words.map(f64::from_str).collect::<Result<Vec<f64>, _>>().ok()?;
    let glass = CatalogueGlass {
        name: name.into(),
        maker: maker.into(),
        published: nd.zip(vd).map(|(nd, vd)| [nd, vd]),
        formula: match (letter, nd, vd) {
            ("M", Some(nd), Some(vd)) => model_formula(nd, vd, 0.0),
            _ => formula(letter, &numbers)?,
        },
        range: [low.ok()? * 1000.0, high.ok()? * 1000.0],
        absorption: Absorption::default(),
    };
    Some((glass, common))
}

fn formula(letter: &str, numbers: &[f64]) -> Option<Formula> {
    let pairs = |numbers: &[f64]| -> Box<[[f64; 2]]> { numbers.as_chunks::<2>().0.into() };
    Some(match letter {
        // Sellmeier: b and c.
        "S" => Formula::Sellmeier { a: 1.0, terms: pairs(numbers) },
        // Sellmeier with a constant before b and c.
        "A" => Formula::Sellmeier { a: *numbers.first()?, terms: pairs(&numbers[1..]) },
        // Sellmeier: b and the root of c.
        "Q" => {
            let terms = pairs(numbers).iter().map(|[b, root]| [*b, root * root]).collect();
            Formula::Sellmeier { a: 1.0, terms }
        }
        // Schott's polynomial.
        "P" => Formula::Schott(numbers.try_into().ok()?),
        // Factors and powers of a polynomial.
        "G" => Formula::General { powers: pairs(numbers), resonances: Box::default() },
        // Factors and powers of Cauchy's formula.
        "C" => Formula::Cauchy(pairs(numbers)),
        // Formula 4 of the database: a constant, two resonances b L^p / (L^2 - d^e), and powers.
        "R" => {
            let (head, powers) = numbers.split_at_checked(9)?;
            let resonance = |i: usize| [head[i], head[i + 1], head[i + 2].powf(head[i + 3])];
            Formula::General {
                powers: [[head[0], 0.0]].into_iter().chain(pairs(powers)).collect(),
                resonances: Box::new([resonance(1), resonance(5)]),
            }
        }
        // Wavelengths (um) and indices.
        "T" => {
            Formula::Samples(numbers.as_chunks().0.iter().map(|[l, n]| [l * 1000.0, *n]).collect())
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::super::TABLES;
    use super::*;

    #[test]
    fn every_line_is_a_glass() {
        for (maker, text) in TABLES {
            for line in text.lines().filter(|line| !line.starts_with('#')) {
                assert!(glass(maker, line).is_some(), "{maker}: {line}");
            }
        }
    }
}
