//! Suggestions for misspelt words.

/// Returns the known word nearest to a misspelt one, if one is near enough.
pub fn nearest_word<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    let length = lower.chars().count();
    known
        .into_iter()
        // Bounds the cost of the distance, which is proportional to the product of both lengths.
        .filter(|candidate| candidate.len().abs_diff(length) <= 1 + candidate.len() / 4)
        .map(|candidate| {
            (strsim::damerau_levenshtein(&lower, &candidate.to_lowercase()), candidate)
        })
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len() / 4)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// Returns "; did you mean ...?" for a misspelt word, or an empty string.
pub fn hint<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest_word(word, known).map_or_else(String::new, |near| format!("; did you mean \"{near}\"?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typo_finds_its_word_and_nonsense_finds_none() {
        let known = ["sphere", "disk", "trianglemesh"];
        assert_eq!(nearest_word("spehre", known), Some("sphere"));
        assert_eq!(nearest_word("TriangleMesh", known), Some("trianglemesh"));
        assert_eq!(nearest_word("xyzzy", known), None);
    }
}
