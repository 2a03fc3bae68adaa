//! Dispersion formulas.

use super::table;

/// A dispersion formula, with L the wavelength (um).
#[derive(Clone, Debug, PartialEq)]
pub enum Formula {
    /// n^2 = a + the sum of b L^2 / (L^2 - c), with c in um^2.
    Sellmeier {
        /// Constant; 1 in Sellmeier's own form.
        a: f64,
        /// Pairs of b and c.
        terms: Box<[[f64; 2]]>,
    },
    /// n^2 = a0 + a1 L^2 + a2 L^-2 + a3 L^-4 + a4 L^-6 + a5 L^-8, also called Laurent series.
    Schott([f64; 6]),
    /// n^2 = the sum of a L^p and of b L^q / (L^2 - c): the "extended" polynomials, and resonances
    /// beside them.
    General {
        /// Pairs of a and p.
        powers: Box<[[f64; 2]]>,
        /// Triples of b, q and c.
        resonances: Box<[[f64; 3]]>,
    },
    /// n = the sum of a L^p: the formulas of Cauchy, and of Conrady with p = 0, -1 and -3.5.
    Cauchy(Box<[[f64; 2]]>),
    /// n = A + B D + C D^2 + E L^2 + F L^4 + G L^6 with D = 1 / (L^2 - 0.028) (Herzberger 1959).
    Herzberger([f64; 6]),
    /// n = n0 + the sum of v_i w^i, i from 1, with w = d / (1 + 2.5 d) and d = L - L0 (Buchdahl,
    /// "Optical Aberration Coefficients", 1968; 2.5 by Robb and Mercado 1983, Appl. Opt. 22, 1198).
    Buchdahl {
        /// Reference wavelength L0 (um) and the index n0 there.
        origin: [f64; 2],
        /// Coefficients v_1, v_2 and so on.
        v: Box<[f64]>,
    },
    /// Pairs of wavelength (nm), increasing, and index. Between them the index is interpolated by a
    /// cubic in the logarithm of L through the four nearest.
    Samples(Box<[[f64; 2]]>),
}

impl Formula {
    /// Returns the index at a wavelength (nm). It is not a number where the formula has no value.
    pub fn index(&self, nm: f64) -> f64 {
        let micrometres = nm / 1000.0;
        let square = micrometres * micrometres;
        match self {
            Self::Sellmeier { a, terms } => {
                (a + terms.iter().map(|[b, c]| b * square / (square - c)).sum::<f64>()).sqrt()
            }
            Self::Schott([a0, a1, a2, a3, a4, a5]) => {
                let inverse = square.recip();
                let tail = a2 + inverse * (a3 + inverse * (a4 + inverse * a5));
                (a0 + a1 * square + inverse * tail).sqrt()
            }
            Self::General { powers, resonances } => {
                let resonance = |[b, q, c]: &[f64; 3]| b * power(micrometres, *q) / (square - c);
                (polynomial(powers, micrometres) + resonances.iter().map(resonance).sum::<f64>())
                    .sqrt()
            }
            Self::Cauchy(powers) => polynomial(powers, micrometres),
            Self::Herzberger([a, b, c, e, f, g]) => {
                let d = (square - 0.028).recip();
                a + d * (b + d * c) + square * (e + square * (f + square * g))
            }
            Self::Buchdahl { origin: [l0, n0], v } => {
                let w = chromatic_coordinate(micrometres - l0);
                n0 + w * v.iter().rev().fold(0.0, |sum, v| sum * w + v)
            }
            Self::Samples(entries) => table::cubic(entries, nm),
        }
    }
}

/// Returns Buchdahl's chromatic coordinate of a distance from the reference wavelength (um).
pub(super) fn chromatic_coordinate(distance: f64) -> f64 {
    distance / (1.0 + 2.5 * distance)
}

fn polynomial(terms: &[[f64; 2]], micrometres: f64) -> f64 {
    terms.iter().map(|&[a, p]| a * power(micrometres, p)).sum()
}

fn power(base: f64, exponent: f64) -> f64 {
    match exponent.fract() == 0.0 && exponent.abs() < 64.0 {
        true => base.powi(exponent as i32),
        false => base.powf(exponent),
    }
}
