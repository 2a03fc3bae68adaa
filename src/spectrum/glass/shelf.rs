//! Glasses in the order of their catalogues, with an index of their names.

use std::collections::HashMap;
use std::sync::Arc;

use super::CatalogueGlass;

/// Glasses in the order of their catalogues, with an index of their names.
#[derive(Debug, Default)]
pub(super) struct Shelf {
    glasses: Vec<Arc<CatalogueGlass>>,
    /// Positions of the glasses by bare name.
    by_name: HashMap<String, Vec<usize>>,
    /// Bare names of the makers.
    makers: Vec<String>,
}

impl Shelf {
    pub fn new(glasses: Vec<Arc<CatalogueGlass>>) -> Self {
        let (mut by_name, mut makers) = (HashMap::<String, Vec<usize>>::new(), Vec::new());
        for (i, glass) in glasses.iter().enumerate() {
            by_name.entry(bare(&glass.name)).or_default().push(i);
            let maker = bare(&glass.maker);
            if !maker.is_empty() && !makers.contains(&maker) {
                makers.push(maker);
            }
        }
        Self { glasses, by_name, makers }
    }

    pub fn glasses(&self) -> &[Arc<CatalogueGlass>] {
        &self.glasses
    }

    /// Returns the glasses of a bare name, in the order of the catalogues.
    pub fn named(&self, name: &str) -> impl Iterator<Item = &Arc<CatalogueGlass>> {
        self.by_name.get(name).into_iter().flatten().map(|&i| &self.glasses[i])
    }

    /// Returns whether a bare word is the name of a maker or of a catalogue of theirs.
    pub fn is_maker(&self, word: &str) -> bool {
        CATALOGUES.contains(&word) || self.makers.iter().any(|maker| word.starts_with(maker))
    }
}

/// Names of Zemax's and CODE V's catalogues that hold materials of several makers or of one that has
/// another name here.
const CATALOGUES: &[&str] =
    &["NIKON", "MISC", "INFRARED", "PLASTIC", "PLASTICS", "SPECIAL", "ZEON"];

/// Returns whether a maker or catalogue of a lens file may be that of a glass: "SCHOTT_2000" is
/// Schott, Nikon's glasses are Hikari's, and materials of several makers are in any catalogue.
pub(super) fn is_of(glass: &CatalogueGlass, maker: &str) -> bool {
    let (own, asked) = (bare(&glass.maker), bare(maker));
    own.is_empty()
        || asked.starts_with(&own)
        || (own == "HIKARI" && asked.starts_with("NIKON"))
        || (asked == "INFRARED" && INFRARED.contains(&own.as_str()))
}

/// Makers of infrared materials.
const INFRARED: [&str; 4] = ["AMI", "VITRON", "LIGHTPATH", "SCHOTT"];

/// Returns a name in upper case without blanks, quotes, "-" and "_".
pub(super) fn bare(name: &str) -> String {
    let kept = name.chars().filter(|c| !c.is_whitespace() && !"-_'\"".contains(*c));
    kept.flat_map(char::to_uppercase).collect()
}
