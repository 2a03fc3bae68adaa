//! Model glasses: media that a lens file describes by a few figures.

use std::sync::Arc;

use super::formula::chromatic_coordinate;
use super::{Absorption, C_LINE, CatalogueGlass, D_LINE, F_LINE, Formula, G_LINE, Glass, MODEL};

/// Range of model glasses (nm): from the i line to the t line of mercury.
const RANGE: [f64; 2] = [365.0, 1014.0];

impl Glass {
    /// Returns a model glass of an index at the d line, an Abbe number Vd and the deviation dPgF of
    /// its partial dispersion from the normal line (0 if the file states none).
    ///
    /// Buchdahl's formula of two terms meets nF - nC and PgF = (ng - nF) / (nF - nC) =
    /// 0.6438 - 0.001682 Vd + dPgF (Schott, TIE-29).
    pub fn model(nd: f64, vd: f64, dpgf: f64) -> Self {
        Self::formula(format!("model {nd}:{vd}"), model_formula(nd, vd, dpgf), Some(RANGE))
    }

    /// Returns a glass that a lens file defines by a formula over a range (nm); without one, from
    /// 350 to 1100 nm.
    pub fn formula(name: impl Into<String>, formula: Formula, range: Option<[f64; 2]>) -> Self {
        Self::Catalogue(Arc::new(CatalogueGlass {
            name: name.into().into(),
            maker: "".into(),
            published: None,
            formula,
            range: range.unwrap_or(MODEL),
            absorption: Absorption::default(),
        }))
    }

    /// Returns a glass that a lens file defines by pairs of wavelength (nm) and index, in any order.
    ///
    /// Four or more are interpolated, from the first to the last. Fewer are the lines of a glass,
    /// through which Buchdahl's formula goes; it is used from 350 to 1100 nm. Returns `None` if there
    /// is no pair, if one is not positive, or if two have one wavelength.
    pub fn samples(name: impl Into<String>, pairs: &[[f64; 2]]) -> Option<Self> {
        let mut pairs = pairs.to_vec();
        pairs.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let positive = |x: &f64| x.is_finite() && *x > 0.0;
        let sound = pairs.iter().flatten().all(positive);
        if !sound || pairs.windows(2).any(|pair| pair[0][0] == pair[1][0]) {
            return None;
        }
        let [first, .., last] = pairs[..] else {
            let [[_, index]] = pairs[..] else { return None };
            return Some(Self::formula(name, Formula::Cauchy(Box::new([[index, 0.0]])), None));
        };
        if pairs.len() >= 4 {
            let range = [first[0], last[0]];
            return Some(Self::formula(name, Formula::Samples(pairs.into()), Some(range)));
        }
        // Newton's divided differences about the line in the middle.
        let [middle, n0] = pairs[1];
        let w = |[nm, _]: [f64; 2]| chromatic_coordinate((nm - middle) / 1000.0);
        let slope = |at: [f64; 2]| (at[1] - n0) / w(at);
        let low = slope(first);
        let v = match pairs.len() {
            2 => vec![low],
            _ => {
                let v2 = (slope(last) - low) / (w(last) - w(first));
                vec![low - v2 * w(first), v2]
            }
        };
        let origin = [middle / 1000.0, n0];
        Some(Self::formula(name, Formula::Buchdahl { origin, v: v.into() }, None))
    }
}

/// Returns the formula of [`Glass::model`].
pub(super) fn model_formula(nd: f64, vd: f64, dpgf: f64) -> Formula {
    let w = |nm: f64| chromatic_coordinate((nm - D_LINE) / 1000.0);
    let [g, blue, red] = [G_LINE, F_LINE, C_LINE].map(w);
    let spread = (nd - 1.0) / vd;
    let partial = (0.6438 - 0.001_682 * vd + dpgf) * spread;
    // spread = v1 a + v2 b; partial = v1 c + v2 d.
    let (a, b) = (blue - red, blue * blue - red * red);
    let (c, d) = (g - blue, g * g - blue * blue);
    let determinant = a * d - b * c;
    let v1 = (spread * d - partial * b) / determinant;
    let v2 = (partial * a - spread * c) / determinant;
    let origin = [D_LINE / 1000.0, nd];
    Formula::Buchdahl { origin, v: Box::new([v1, v2]) }
}

#[cfg(test)]
mod tests {
    use super::super::GlassLibrary;
    use super::*;

    #[test]
    fn a_model_has_its_abbe_number_and_partial_dispersion() {
        for (nd, vd, dpgf) in
            [(1.5168, 64.17, -0.0009), (1.80518, 25.43, 0.0092), (1.6134, 44.5, 0.0)]
        {
            let glass = Glass::model(nd, vd, dpgf);
            let index = |nm: f64| glass.index(0.0, nm).unwrap();
            let spread = index(F_LINE) - index(C_LINE);
            assert_eq!(index(D_LINE), nd);
            assert!(((nd - 1.0) / spread - vd).abs() < 1e-9);
            let partial = (index(G_LINE) - index(F_LINE)) / spread;
            assert!((partial - (0.6438 - 0.001_682 * vd + dpgf)).abs() < 1e-12);
        }
    }

    #[test]
    fn samples_of_any_number_are_met_exactly() {
        let real = super::super::find_glass("N-SF6").unwrap();
        let lines = [C_LINE, D_LINE, F_LINE, 435.8, 1060.0].map(|nm| [nm, real.index(nm)]);
        for count in 1..=lines.len() {
            let glass = Glass::samples("six", &lines[..count]).unwrap();
            for [nm, n] in &lines[..count] {
                assert!((glass.index(0.0, *nm).unwrap() - n).abs() < 1e-12, "{count} at {nm}");
            }
        }
        let three = Glass::samples("six", &lines[..3]).unwrap();
        assert!((three.index(0.0, 435.8).unwrap() - lines[3][1]).abs() < 5e-4);
        for bad in [&[][..], &[[500.0, 1.5], [500.0, 1.6]], &[[-1.0, 1.5]], &[[500.0, f64::NAN]]] {
            assert_eq!(Glass::samples("bad", bad), None);
        }
    }

    #[test]
    fn a_model_stays_near_the_glasses_of_the_catalogues() {
        let mut errors = Vec::new();
        for real in GlassLibrary::built_in().glasses() {
            if !real.covers(400.0) || !real.covers(1014.0) || real.nd() < 1.3 {
                continue;
            }
            let model = Glass::model(real.nd(), real.vd(), 0.0);
            let off = |nm: f64| (model.index(0.0, nm).unwrap() - real.index(nm)).abs();
            errors.push([off(404.66), off(706.52), off(1013.98)]);
        }
        let median = |i: usize| {
            let mut of: Vec<f64> = errors.iter().map(|error| error[i]).collect();
            of.sort_by(f64::total_cmp);
            of[of.len() / 2]
        };
        assert!(errors.len() > 1000, "{}", errors.len());
        let [h, r, t] = [0, 1, 2].map(median);
        assert!(h < 3e-4 && r < 1e-4 && t < 3e-3, "{h} {r} {t}");
    }
}
