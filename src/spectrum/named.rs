//! Spectra by the names that pbrt-v4 gives them.

use super::material::MATERIALS;
use super::{Spectrum, VISIBLE, illuminant};
use crate::lens::catalogue;

/// pbrt-v4's glasses and the makers' names for what it means by them. It has the modern ones, and
/// called three of them by halves of their names for some years.
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

/// The spectrum of a name: an illuminant of luminance 1 ("stdillum-D65"), the index of a glass
/// ("glass-BK7"), or the index or extinction coefficient of a metal ("metal-Cu-eta", "metal-Cu-k").
pub fn named(name: &str) -> Option<Spectrum> {
    illuminant::illuminant(name).or_else(|| glass(name)).or_else(|| material(name))
}

/// Every name that [`named`] knows.
pub fn names() -> Vec<String> {
    let materials =
        MATERIALS.iter().flat_map(|(name, _)| ["eta", "k"].map(|of| format!("{name}-{of}")));
    let others = illuminant::NAMES.into_iter().chain(GLASSES.into_iter().map(|(name, _)| name));
    others.map(str::to_owned).chain(materials).collect()
}

fn glass(name: &str) -> Option<Spectrum> {
    let (_, listed) = GLASSES.iter().find(|(known, _)| *known == name)?;
    let glass = catalogue(listed)?;
    let nms = (VISIBLE[0]..=VISIBLE[1]).step_by(2).map(f64::from);
    Some(Spectrum::tabulated(nms.map(|nm| [nm, glass.index(nm)])))
}

fn material(name: &str) -> Option<Spectrum> {
    let (of, column) = match name.strip_suffix("-eta") {
        Some(of) => (of, 1),
        None => (name.strip_suffix("-k")?, 2),
    };
    let (_, rows) = MATERIALS.iter().find(|(known, _)| *known == of)?;
    Some(Spectrum::tabulated(rows.iter().map(|row| [row[0], row[column]])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lens::D_LINE;

    #[test]
    fn every_name_has_its_spectrum() {
        for name in names() {
            let spectrum = named(&name).unwrap();
            let Spectrum::Samples(samples) = &spectrum else { panic!("{name}") };
            assert!(samples.is_sorted_by(|a, b| a[0] < b[0]), "{name}");
            assert!(samples[0][0] <= 380.0 && samples[samples.len() - 1][0] >= 760.0, "{name}");
        }
        assert_eq!(named("metal-Cu"), None);
        assert_eq!(named("stdillum-F13"), None);
        assert_eq!(named("stdillum-F0"), None);
    }

    #[test]
    fn glasses_have_their_published_indices() {
        let published = [("glass-BK7", 1.51680), ("glass-BAF10", 1.67003), ("glass-F11", 1.78472)];
        for (name, nd) in published {
            let found = named(name).unwrap().index_at(D_LINE);
            assert!((found - nd).abs() < 2e-5, "{name}: {found}");
        }
    }
}
