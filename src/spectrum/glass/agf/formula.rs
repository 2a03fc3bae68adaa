//! The thirteen dispersion formulas of Zemax (OpticStudio manual, "Glass dispersion formulas").

use crate::glass::Formula;

/// Returns the formula of a number from 1 to 13 with its ten coefficients.
pub(super) fn formula(number: u32, c: &[f64]) -> Formula {
    let at = |i: usize| c.get(i).copied().unwrap_or(0.0);
    let first = || std::array::from_fn::<f64, 6, _>(at);
    match number {
        1 => Formula::Schott(first()),
        2 => sellmeier(1.0, c, 3),
        3 => Formula::Herzberger(first()),
        4 => general(
            &[[1.0 + at(0), 0.0]],
            &[[at(1), 2.0, at(2) * at(2)], [at(3), 0.0, at(4) * at(4)]],
        ),
        5 => Formula::Cauchy(Box::new([[at(0), 0.0], [at(1), -1.0], [at(2), -3.5]])),
        6 => sellmeier(1.0, c, 4),
        7 => general(&[[at(0), 0.0], [-at(3), 2.0]], &[[at(1), 0.0, at(2)]]),
        8 => general(&[[at(0), 0.0], [-at(3), 2.0]], &[[at(1), 2.0, at(2)]]),
        9 => sellmeier(at(0), c.get(1..).unwrap_or_default(), 2),
        10 => extended(c, &[0.0, 2.0, -2.0, -4.0, -6.0, -8.0, -10.0, -12.0]),
        11 => sellmeier(1.0, c, 5),
        12 => extended(c, &[0.0, 2.0, -2.0, -4.0, -6.0, -8.0, 4.0, 6.0]),
        _ => extended(c, &[0.0, 2.0, 4.0, -2.0, -4.0, -6.0, -8.0, -10.0, -12.0]),
    }
}

fn sellmeier(a: f64, c: &[f64], count: usize) -> Formula {
    let terms = c.as_chunks::<2>().0.iter().take(count).filter(|[b, _]| *b != 0.0);
    Formula::Sellmeier { a, terms: terms.copied().collect() }
}

fn extended(c: &[f64], powers: &[f64]) -> Formula {
    let terms: Vec<[f64; 2]> = c.iter().zip(powers).map(|(a, p)| [*a, *p]).collect();
    general(&terms, &[])
}

fn general(powers: &[[f64; 2]], resonances: &[[f64; 3]]) -> Formula {
    Formula::General {
        powers: powers.iter().filter(|[a, _]| *a != 0.0).copied().collect(),
        resonances: resonances.iter().filter(|[b, ..]| *b != 0.0).copied().collect(),
    }
}
