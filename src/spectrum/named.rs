//! Spectra by their names in pbrt-v4.

use super::glass::find_glass;
use super::index_tables::INDEX_TABLES;
use super::{Spectrum, VISIBLE, illuminant};

/// pbrt-v4's names of glasses, and the manufacturers' names. pbrt-v4 had the last three names,
/// which are incomplete, for some years.
const GLASSES: [(&str, &str); 10] = [
    ("glass-BK7", "N-BK7"),
    ("glass-BAF10", "N-BAF10"),
    ("glass-FK51A", "N-FK51A"),
    ("glass-LASF9", "N-LASF9"),
    ("glass-SF5", "N-SF5"),
    ("glass-SF10", "N-SF10"),
    ("glass-SF11", "N-SF11"),
    ("glass-F5", "N-SF5"),
    ("glass-F10", "N-SF10"),
    ("glass-F11", "N-SF11"),
];

/// Returns the spectrum of a name: an illuminant of luminance 1 ("stdillum-D65"), the index of a
/// glass ("glass-BK7"), or the index or extinction coefficient of a metal ("metal-Cu-eta",
/// "metal-Cu-k").
pub fn named_spectrum(name: &str) -> Option<Spectrum> {
    illuminant::illuminant(name).or_else(|| glass(name)).or_else(|| tabulated_index(name))
}

/// Returns every name that [`named_spectrum`] knows.
pub fn spectrum_names() -> Vec<String> {
    let materials =
        INDEX_TABLES.iter().flat_map(|(name, _)| ["eta", "k"].map(|part| format!("{name}-{part}")));
    let others = illuminant::NAMES.into_iter().chain(GLASSES.into_iter().map(|(name, _)| name));
    others.map(str::to_owned).chain(materials).collect()
}

fn glass(name: &str) -> Option<Spectrum> {
    let (_, listed) = GLASSES.iter().find(|(known, _)| *known == name)?;
    let glass = find_glass(listed)?;
    let nms = (VISIBLE[0]..=VISIBLE[1]).step_by(2).map(f64::from);
    Some(Spectrum::tabulated(nms.map(|nm| [nm, glass.formula.index(nm)])))
}

fn tabulated_index(name: &str) -> Option<Spectrum> {
    let (metal, column) = match name.strip_suffix("-eta") {
        Some(metal) => (metal, 1),
        None => (name.strip_suffix("-k")?, 2),
    };
    let (_, rows) = INDEX_TABLES.iter().find(|(known, _)| *known == metal)?;
    Some(Spectrum::tabulated(rows.iter().map(|row| [row[0], row[column]])))
}

#[cfg(test)]
mod tests {
    use super::super::glass::D_LINE;
    use super::*;

    #[test]
    fn every_name_has_its_spectrum() {
        for name in spectrum_names() {
            let spectrum = named_spectrum(&name).unwrap();
            let Spectrum::Samples(samples) = &spectrum else { panic!("{name}") };
            assert!(samples.is_sorted_by(|a, b| a[0] < b[0]), "{name}");
            assert!(samples[0][0] <= 380.0 && samples[samples.len() - 1][0] >= 760.0, "{name}");
        }
        assert_eq!(named_spectrum("metal-Cu"), None);
        assert_eq!(named_spectrum("stdillum-F13"), None);
        assert_eq!(named_spectrum("stdillum-F0"), None);
    }

    #[test]
    fn glasses_have_their_published_indices() {
        let published = [("glass-BK7", 1.51680), ("glass-BAF10", 1.67003), ("glass-F11", 1.78472)];
        for (name, nd) in published {
            let found = named_spectrum(name).unwrap().index_at(D_LINE);
            assert!((found - nd).abs() < 2e-5, "{name}: {found}");
        }
    }
}
