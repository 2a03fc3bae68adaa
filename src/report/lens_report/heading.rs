//! Headings of tables, from the names of columns and figures in files.

/// Units at the ends of names, and how they are written.
const UNITS: [(&str, &str); 7] = [
    ("_per_mm2", "1/mm²"),
    ("_nm", "nm"),
    ("_um", "µm"),
    ("_mm", "mm"),
    ("_deg", "°"),
    ("_percent", "%"),
    ("_waves", "waves"),
];

/// Words that are not written as in names.
const WORDS: [(&str, &str); 20] = [
    ("rms", "RMS"),
    ("airy", "Airy"),
    ("lagrange", "Lagrange"),
    ("petzval", "Petzval"),
    ("strehl marechal", "Strehl ratio (Maréchal)"),
    ("strehl", "Strehl ratio"),
    ("noll", "Noll"),
    ("cos4", "cos⁴"),
    ("abbe", "Abbe"),
    ("f number", "f-number"),
    ("semi diameter", "semi-diameter"),
    ("f theta", "f-theta"),
    ("largest radius", "GEO radius"),
    ("s1", "S I"),
    ("s2", "S II"),
    ("s3", "S III"),
    ("s4", "S IV"),
    ("s5", "S V"),
    ("cl", "C L"),
    ("ct", "C T"),
];

/// Returns a name for people: `rms_radius_um` as "RMS radius (µm)".
pub(super) fn heading(name: &str) -> String {
    if let Some(rest) = name.strip_suffix("_per_mm")
        && let Some((word, frequency)) = rest.rsplit_once('_')
        && frequency.parse::<f64>().is_ok()
    {
        return format!("{word}, {frequency}/mm");
    }
    let unit = UNITS.iter().find_map(|(end, unit)| Some((name.strip_suffix(end)?, unit)));
    let (words, unit) = unit.map_or((name, None), |(words, unit)| (words, Some(unit)));
    let mut text = format!(" {} ", words.replace('_', " "));
    for (word, written) in WORDS {
        text = text.replace(&format!(" {word} "), &format!(" {written} "));
    }
    let text = text.trim();
    match unit {
        Some(unit) => format!("{text} ({unit})"),
        None => text.to_owned(),
    }
}

/// Returns a sentence on missing numbers with the names for people.
pub(super) fn in_words(sentence: &str) -> String {
    let Some((names, why)) = sentence.split_once(": ") else { return sentence.to_owned() };
    let names: Vec<String> = names
        .split(", ")
        .map(|name| if name.contains(' ') { name.to_owned() } else { heading(name) })
        .collect();
    format!("{}: {why}", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_columns_become_headings() {
        for (name, expected) in [
            ("rms_radius_um", "RMS radius (µm)"),
            ("s1_mm", "S I (mm)"),
            ("effective_focal_length_mm", "effective focal length (mm)"),
            ("paraxial_working_f_number", "paraxial working f-number"),
            ("field_deg", "field (°)"),
            ("tangential_40_per_mm", "tangential, 40/mm"),
            ("irradiance_per_mm2", "irradiance (1/mm²)"),
            ("f_theta_distortion_percent", "f-theta distortion (%)"),
            ("surface", "surface"),
        ] {
            assert_eq!(heading(name), expected);
        }
        let sentence = "limit_tangential, rms_um: no light of field 20 mm passes the lens.";
        let expected = "limit tangential, RMS (µm): no light of field 20 mm passes the lens.";
        assert_eq!(in_words(sentence), expected);
    }
}
