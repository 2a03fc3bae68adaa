//! Media of a Zemax file: `GLAS` and the catalogues they come from.

use petzval_lens::Row;
use petzval_spectrum::{C_LINE, CatalogueGlass, D_LINE, F_LINE, Glass, GlassLibrary, GlassMatch};

/// Abbe numbers of model glasses.
const ABBE: std::ops::RangeInclusive<f64> = 2.0..=1000.0;

/// Names of media, and what their names leave out.
pub(super) struct GlassWriter {
    library: GlassLibrary,
    /// Glasses so far, by the name in the file.
    named: Vec<(String, CatalogueGlass)>,
    /// Catalogues of the named glasses.
    pub makers: Vec<String>,
    /// Media that the file describes by fewer figures.
    pub notes: Vec<String>,
}

impl GlassWriter {
    pub fn new() -> Self {
        Self {
            library: GlassLibrary::built_in(),
            named: Vec::new(),
            makers: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Returns the line of the medium behind a surface; empty for air.
    pub fn line(&mut self, number: usize, row: &Row) -> String {
        if row.mirror {
            return "  GLAS MIRROR 0 0 1.5 40.0 0.0 0 0 0 0.0 0.0\n".to_owned();
        }
        let (name, kind, [nd, vd, dpgf]) = match &row.glass {
            Glass::Constant if row.index == 1.0 => return String::new(),
            Glass::Constant => ("___BLANK".to_owned(), 1, [row.index, 0.0, 0.0]),
            Glass::Catalogue(glass) => match (model_figures(glass, &row.glass), self.name(glass)) {
                (Some(figures), _) => ("___BLANK".to_owned(), 1, figures),
                (None, Some(name)) => {
                    let [nd, vd] = figures(row).unwrap_or([row.index, 0.0]);
                    (name, 0, [nd, vd, 0.0])
                }
                (None, None) => self.model(number, row),
            },
            _ => self.model(number, row),
        };
        format!("  GLAS {name} {kind} 0 {nd:?} {vd:?} {dpgf:?} 0 0 0 0.0 0.0\n")
    }

    /// Returns the name of a glass of a catalogue.
    fn name(&mut self, glass: &CatalogueGlass) -> Option<String> {
        if glass.maker.is_empty() && glass.published.is_none() && glass.name.contains(' ') {
            return None;
        }
        let whole = glass.full_name().replace(' ', "_");
        let maker: String = glass.maker.to_uppercase().split_whitespace().collect();
        let before = self.makers.clone();
        let mut with_maker = before.clone();
        if !maker.is_empty() && !with_maker.contains(&maker) {
            with_maker.push(maker);
        }
        let own = glass.name.as_ref();
        for (name, makers) in [(own, &with_maker), (own, &before), (whole.as_str(), &before)] {
            let one_word = !name.is_empty() && !name.contains(char::is_whitespace);
            let earlier = self.named.iter().all(|(name, glass)| self.finds(name, makers, glass));
            if one_word && earlier && self.finds(name, makers, glass) {
                let (name, makers) = (name.to_owned(), makers.clone());
                self.named.push((name.clone(), glass.clone()));
                self.makers = makers;
                return Some(name);
            }
        }
        if glass.maker.is_empty() || own.contains(char::is_whitespace) || self.is_taken(own) {
            return None;
        }
        let note = format!(
            "the glass {} is of no built-in catalogue: reading the file needs 'catalogue'",
            glass.full_name()
        );
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
        Some(own.to_owned())
    }

    /// Returns whether a name stands for a glass.
    fn finds(&self, name: &str, makers: &[String], glass: &CatalogueGlass) -> bool {
        let makers: Vec<&str> = makers.iter().map(String::as_str).collect();
        let found = self.library.resolve(name, &makers);
        matches!(&found, Some(GlassMatch { glass: Glass::Catalogue(found), substitution: None, .. })
            if **found == *glass)
    }

    /// Returns whether a name stands for some glass of the library.
    fn is_taken(&self, name: &str) -> bool {
        self.library.resolve(name, &[]).is_some()
    }

    /// Returns a medium as an index and an Abbe number, and notes what this leaves out.
    fn model(&mut self, number: usize, row: &Row) -> (String, u32, [f64; 3]) {
        let [nd, vd] = figures(row).unwrap_or([row.index, 0.0]);
        let instead = match vd {
            0.0 => format!("the constant index {nd}"),
            _ => format!("a model glass of index {nd} and Abbe number {vd}"),
        };
        self.notes.push(format!("behind surface {number}, {} is written as {instead}", row.glass));
        ("___BLANK".to_owned(), 1, [nd, vd, 0.0])
    }
}

/// Returns the index at the d line and the Abbe number of a medium that is known there.
fn figures(row: &Row) -> Option<[f64; 2]> {
    if let Glass::Abbe { nd, vd } = row.glass {
        return ABBE.contains(&vd).then_some([nd, vd]);
    }
    let index = |nm: f64| row.glass.index(row.index, nm).ok();
    let nd = index(D_LINE)?;
    let vd = (nd - 1.0) / (index(F_LINE)? - index(C_LINE)?);
    ABBE.contains(&vd).then_some([nd, vd])
}

/// Returns index, Abbe number and deviation of the partial dispersion of a model glass.
fn model_figures(named: &CatalogueGlass, glass: &Glass) -> Option<[f64; 3]> {
    let (nd, vd) = named.name.strip_prefix("model ")?.split_once(':')?;
    let (nd, vd) = (nd.parse().ok()?, vd.parse().ok()?);
    let partial = named.partial_dispersion() - (0.6438 - 0.001_682 * vd);
    // The shortest number of digits that gives the same glass.
    (0..=17)
        .filter_map(|digits| format!("{partial:.digits$}").parse::<f64>().ok())
        .chain([partial])
        .map(|dpgf| [nd, vd, dpgf + 0.0])
        .find(|&[nd, vd, dpgf]| Glass::model(nd, vd, dpgf) == *glass)
}
