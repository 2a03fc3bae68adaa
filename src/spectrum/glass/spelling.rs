//! Glasses by name, in the spellings of lens files.

use std::sync::Arc;

use super::shelf::{Shelf, bare, is_of};
use super::{CatalogueGlass, Glass, GlassMatch};

/// Other names of materials, bare.
const ALIASES: &[(&str, &str)] = &[
    ("FUSEDSILICA", "FSILICA"),
    ("SILICA", "FSILICA"),
    ("SIO2", "FSILICA"),
    ("FS", "FSILICA"),
    ("CALCIUMFLUORIDE", "CAF2"),
    ("FLUORITE", "CAF2"),
    ("ACRYLIC", "PMMA"),
    ("POLYCARBONATE", "POLYCARB"),
    ("POLYCARBO", "POLYCARB"),
    ("PC", "POLYCARB"),
    ("POLYSTYRENE", "POLYSTYR"),
    ("PS", "POLYSTYR"),
    ("STYRENE", "POLYSTYR"),
    ("COC", "TOPAS5013"),
    ("TOPAS", "TOPAS5013"),
    ("APL5014CL", "APL5014"),
    ("EP5000F", "EP5000"),
    ("ZEONEXE48R", "E48R"),
    ("GE", "GERMANIUM"),
    ("SI", "SILICON"),
    ("ZNS", "ZNSBROAD"),
    ("CLEARTRAN", "ZNSBROAD"),
    ("AL2O3", "SAPPHIRE"),
];

/// Leaded or earlier glasses and their successors differ by such a prefix of the bare name.
const SUCCESSOR_PREFIXES: &[&str] = &["N", "S", "J", "H", "E", "K", "P", "L", "D", "M"];
/// Suffixes of glasses of the same index as the one without: high transmittance.
const GRADES: &[&str] = &["HTULTRA", "HTI", "HT", "HS", "GTI", "GT"];
/// Suffixes of glasses that were molded, which lowers the index.
const MOLDED: &[&str] = &["MOLD", "(M)", "M"];
/// Suffixes of versions of a glass.
const VERSIONS: &[&str] = &["A", "B", "C", "D", "G", "H", "L", "N", "R", "V", "W", "Y"];

/// Returns the glass of a name; see [`super::GlassLibrary::find`].
pub(super) fn find(shelf: &Shelf, name: &str, makers: &[&str]) -> Option<GlassMatch> {
    let (key, maker) = split_maker(shelf, name);
    // A maker that the name states excludes others; one that the file prefers only comes first.
    let stated: Vec<&str> = maker.as_deref().into_iter().collect();
    let preferred = [&stated, makers].concat();
    let exact = |key: &str| choose(shelf, name, key, &stated, &preferred);
    let whole = bare(name);
    let found = |glass: Arc<CatalogueGlass>, key: &str, stated: &[&str]| {
        let ambiguity = ambiguity(shelf, &glass, key, stated, &preferred);
        let glass = Glass::Catalogue(glass);
        Some(GlassMatch { glass, substitution: None, ambiguity })
    };
    if let Some(glass) = choose(shelf, name, &whole, &[], makers) {
        return found(glass, &whole, &[]);
    }
    if let Some(glass) = exact(&key) {
        return found(glass, &key, &stated);
    }
    let alias = ALIASES.iter().find(|(alias, _)| *alias == key).map(|(_, listed)| *listed);
    if let Some(glass) = alias.and_then(|listed| choose(shelf, name, listed, &[], makers)) {
        let glass = Glass::Catalogue(glass);
        return Some(GlassMatch { glass, substitution: None, ambiguity: None });
    }
    let (glass, relation) = relative(&key, exact)?;
    let asked = name.trim().trim_matches(['\'', '"']);
    let substitution = format!(
        "no catalogue has the glass {asked}: {relation} {} stands in for it",
        glass.full_name()
    );
    let (glass, substitution) = (Glass::Catalogue(glass), Some(substitution));
    Some(GlassMatch { glass, substitution, ambiguity: None })
}

/// Difference of nd, and that of Vd, from which two glasses of one name are two glasses: catalogues
/// of different years round and melt a little differently.
const DIFFERENT: [f64; 2] = [2e-4, 0.3];

/// Returns a sentence about other glasses of the name of a chosen one, if nothing says which is meant.
fn ambiguity(
    shelf: &Shelf,
    chosen: &CatalogueGlass,
    key: &str,
    stated: &[&str],
    preferred: &[&str],
) -> Option<String> {
    let is_meant = |glass: &CatalogueGlass| {
        preferred.iter().any(|maker| !glass.maker.is_empty() && is_of(glass, maker))
    };
    if is_meant(chosen) {
        return None;
    }
    let differs = |glass: &CatalogueGlass| {
        (glass.nd() - chosen.nd()).abs() > DIFFERENT[0]
            || (glass.vd() - chosen.vd()).abs() > DIFFERENT[1]
    };
    let described = |glass: &CatalogueGlass| {
        format!("{} (nd {:.5}, Vd {:.2})", glass.full_name(), glass.nd(), glass.vd())
    };
    let mut others: Vec<String> = shelf
        .named(key)
        .filter(|glass| stated.iter().all(|maker| is_of(glass, maker)))
        .filter(|glass| glass.maker != chosen.maker && differs(glass))
        .map(|glass| described(glass))
        .collect();
    others.dedup();
    (!others.is_empty()).then(|| {
        format!(
            "several makers have a glass {}: {} is used, and not {}; write the maker beside the name \
             to choose, as in \"{}\"",
            chosen.name,
            described(chosen),
            others.join(" or "),
            chosen.full_name()
        )
    })
}

/// Returns the glass of a bare name that a name means best: spelled in the same way, then of the
/// preferred makers in their order, then the first.
fn choose(
    shelf: &Shelf,
    name: &str,
    key: &str,
    stated: &[&str],
    preferred: &[&str],
) -> Option<Arc<CatalogueGlass>> {
    let rank = |glass: &CatalogueGlass| {
        let spelled = name.trim().eq_ignore_ascii_case(&glass.name);
        let place =
            preferred.iter().position(|maker| !glass.maker.is_empty() && is_of(glass, maker));
        (!spelled, place.unwrap_or(usize::MAX))
    };
    let same = shelf.named(key).filter(|glass| stated.iter().all(|maker| is_of(glass, maker)));
    same.min_by_key(|glass| rank(glass)).cloned()
}

/// Returns the bare name of a glass, and the maker that stands before or behind it.
fn split_maker(shelf: &Shelf, name: &str) -> (String, Option<String>) {
    let name = name.trim().trim_matches(['\'', '"']);
    let separators = |c: char| c.is_whitespace() || "_(./:,".contains(c);
    for (at, mark) in name.match_indices(separators) {
        let (before, behind) = (bare(&name[..at]), bare(&name[at + mark.len()..]));
        let behind = behind.trim_end_matches(')').to_owned();
        if shelf.is_maker(&behind) && !before.is_empty() {
            return (before.trim_end_matches('(').to_owned(), Some(behind));
        }
        if shelf.is_maker(&before) && !behind.is_empty() {
            return (bare(&name[at + mark.len()..]), Some(before));
        }
    }
    (bare(name), None)
}

/// Returns the nearest relative of a glass that is not listed, and the relation.
fn relative(
    key: &str,
    find: impl Fn(&str) -> Option<Arc<CatalogueGlass>>,
) -> Option<(Arc<CatalogueGlass>, &'static str)> {
    if key.len() < 2 {
        return None;
    }
    let without =
        |suffixes: &[&str]| suffixes.iter().filter_map(|end| key.strip_suffix(end)).find_map(&find);
    let is_digit = |name: &str| name.ends_with(|c: char| c.is_ascii_digit());
    if let Some(glass) = without(GRADES) {
        return Some((glass, "the grade of the same index"));
    }
    if let Some(glass) = without(MOLDED) {
        return Some((glass, "the glass before it is molded,"));
    }
    let successor = || SUCCESSOR_PREFIXES.iter().find_map(|prefix| find(&format!("{prefix}{key}")));
    if let Some(glass) = successor() {
        return Some((glass, "its successor"));
    }
    let other = || {
        let longer = || VERSIONS.iter().find_map(|suffix| find(&format!("{key}{suffix}")));
        let shorter = || {
            let bases = VERSIONS.iter().filter_map(|suffix| key.strip_suffix(suffix));
            bases.filter(|base| is_digit(base)).find_map(&find)
        };
        is_digit(key).then(longer).flatten().or_else(shorter)
    };
    other().map(|glass| (glass, "another version,"))
}

#[cfg(test)]
mod tests {
    use super::super::GlassLibrary;

    fn found(name: &str, makers: &[&str]) -> Option<(String, bool)> {
        let found = GlassLibrary::built_in().find(name, makers)?;
        Some((found.glass.to_string(), found.substitution.is_some()))
    }

    #[test]
    fn names_are_found_in_all_spellings() {
        for name in [
            "N-BK7",
            "n-bk7",
            "NBK7",
            "N_BK7",
            "SCHOTT N-BK7",
            "SCHOTT_N-BK7",
            " schott  n-bk7 ",
            "N-BK7_SCHOTT",
            "NBK7_Schott",
            "N-BK7 (Schott)",
            "N-BK7 Schott",
            "'N-BK7'",
            "NBK7.SCHOTT",
        ] {
            assert_eq!(found(name, &[]), Some(("Schott N-BK7".to_owned(), false)), "{name:?}");
        }
        for (name, expected) in [
            ("fused silica", "F_SILICA"),
            ("FusedSilica", "F_SILICA"),
            ("Germanium", "GERMANIUM"),
            ("H-K9L", "CDGM H-K9L"),
            ("J-BK7A", "Hikari J-BK7A"),
            ("K-SFLD6", "Sumita K-SFLD6"),
            ("S-LAH64", "Ohara S-LAH64"),
            ("SLAH64", "Ohara S-LAH64"),
            ("CaF2", "CAF2"),
            ("J-LASF017_NIKON", "Hikari J-LASF017"),
            ("BK7", "Schott BK7"),
            ("SF6", "Schott SF6"),
        ] {
            assert_eq!(found(name, &[]), Some((expected.to_owned(), false)), "{name:?}");
        }
        for name in
            ["Ohara N-BK7", "", " ", "_", "no such glass", "AIR", "N-BK7_", "(", "é", "Schott"]
        {
            let expected = (name == "N-BK7_").then(|| ("Schott N-BK7".to_owned(), false));
            assert_eq!(found(name, &[]), expected, "{name:?}");
        }
    }

    #[test]
    fn preferred_makers_come_first_but_do_not_exclude_others() {
        assert_eq!(found("F2", &[]), Some(("Schott F2".to_owned(), false)));
        assert_eq!(found("F2", &["CDGM"]), Some(("CDGM F2".to_owned(), false)));
        assert_eq!(found("F2", &["OHARA", "HIKARI"]), Some(("Hikari F2".to_owned(), false)));
        assert_eq!(found("N-BK7", &["CDGM"]), Some(("Schott N-BK7".to_owned(), false)));
    }

    #[test]
    fn a_substitute_is_declared() {
        for (name, expected) in [
            ("LAK22", "Schott N-LAK22"),
            ("LASF44", "Schott N-LASF44"),
            ("N-SK16HT", "Schott N-SK16"),
            ("E48", "E48R"),
        ] {
            let (found, substituted) = found(name, &[]).unwrap_or_else(|| panic!("{name}"));
            assert!(found == expected && substituted, "{name}: {found}");
        }
    }

    #[test]
    fn every_glass_is_found_by_its_own_name_and_its_makers() {
        for glass in GlassLibrary::built_in().glasses() {
            let full = found(&glass.full_name(), &[]);
            assert_eq!(full, Some((glass.full_name(), false)), "{}", glass.full_name());
            let by_maker = found(&glass.name, &[&glass.maker]);
            assert_eq!(by_maker, Some((glass.full_name(), false)), "{}", glass.full_name());
        }
    }
}
