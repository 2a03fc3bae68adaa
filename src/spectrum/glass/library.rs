//! Glass library: the built-in glasses, and the catalogues that the user names.

use std::path::Path;
use std::sync::Arc;

use super::{
    CatalogueGlass, Glass, GlassError, agf, built_in, code, shelf::Shelf, shelf::bare, spelling,
};
use petzval_base::io::{ReadContext, nearest_word};

/// The built-in glasses, and the catalogues that the user names. Clones share them.
#[derive(Clone, Debug)]
pub struct GlassLibrary {
    shelf: Arc<Shelf>,
    /// Bare names of glasses of the user's catalogues whose lines are invalid, and their faults.
    faults: Arc<Vec<(String, String)>>,
}

/// The medium of a name or a code in a lens file.
#[derive(Clone, Debug, PartialEq)]
pub struct GlassMatch {
    /// The medium.
    pub glass: Glass,
    /// A sentence that names both glasses if the medium is not exactly the one that was asked for;
    /// a reader of lenses reports it as a warning.
    pub substitution: Option<String>,
    /// A sentence that names the other makers if glasses of several have this name, their indices
    /// differ, and neither the name nor a preference says which is meant.
    pub ambiguity: Option<String>,
}

impl GlassMatch {
    /// Returns what a reader of lenses reports about the match.
    pub fn warnings(self) -> impl Iterator<Item = String> {
        self.substitution.into_iter().chain(self.ambiguity)
    }
}

impl GlassLibrary {
    /// Returns the library of the built-in glasses.
    pub fn built_in() -> Self {
        built_in::library()
    }

    pub(super) fn new(glasses: Vec<Arc<CatalogueGlass>>) -> Self {
        Self { shelf: Arc::new(Shelf::new(glasses)), faults: Arc::default() }
    }

    /// Returns the built-in glasses with the catalogues of a context. Those that are packed with a lens come
    /// before the built-in ones, and those that the user names before both.
    ///
    /// # Errors
    /// Returns an error if a catalogue cannot be read, with the line.
    pub fn for_context(context: &ReadContext) -> Result<Self, GlassError> {
        // A catalogue of an archive without a valid glass has nothing to add.
        let packed = context.packed_catalogues().iter().rev();
        let own = packed.fold(Self::built_in(), |library, (path, bytes)| {
            match agf::parse_all(path, bytes) {
                Ok(catalogue) => library.with(catalogue),
                Err(_) => library,
            }
        });
        let named = context.catalogues().iter();
        named.rev().try_fold(own, |library, path| library.with_catalogue(path, context))
    }

    /// Adds the glasses of an AGF file (Zemax), or of all such files of a folder, and logs the files.
    /// They come before the built-in ones. A glass whose lines are invalid is left out;
    /// [`Self::fault`] says why.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read or has no valid glass, with the line.
    pub fn with_catalogue(self, path: &Path, context: &ReadContext) -> Result<Self, GlassError> {
        Ok(self.with(agf::read(path, context)?))
    }

    fn with(self, agf::Catalogue { mut glasses, faulty }: agf::Catalogue) -> Self {
        glasses.extend(self.glasses().cloned());
        let faults = faulty.iter().map(|glass| (bare(&glass.name), glass.error.to_string()));
        let faults = faults.chain(self.faults.iter().cloned()).collect();
        Self { faults: Arc::new(faults), ..Self::new(glasses) }
    }

    /// Returns why a glass of the user's catalogues cannot be used, if its lines are invalid.
    pub fn fault(&self, name: &str) -> Option<&str> {
        let name = bare(name);
        let fault = self.faults.iter().find(|(faulty, _)| *faulty == name);
        fault.map(|(_, fault)| fault.as_str())
    }

    /// Returns the glasses, those of user's catalogues first.
    pub fn glasses(&self) -> impl Iterator<Item = &Arc<CatalogueGlass>> {
        self.shelf.glasses().iter()
    }

    /// Returns the glass of a name: of the preferred makers or catalogues (in their order) if they
    /// have it, else of any.
    ///
    /// Case, blanks, "-" and "_" do not count, and the maker may stand before or behind the name:
    /// "N-BK7", "NBK7", "SCHOTT_N-BK7", "N-BK7_SCHOTT" and "N-BK7 (Schott)" are one glass. "BK7" is
    /// another: if only its successor is known, the match says so.
    pub fn find(&self, name: &str, makers: &[&str]) -> Option<GlassMatch> {
        spelling::find(&self.shelf, name, makers)
    }

    /// Returns the glass of a number: a six-digit code with or without a maker ("517642",
    /// "517642.SCHOTT"), CODE V's fictitious glasses ("620.603", "517000.642000") or index and Abbe
    /// number ("1.5168:64.17"). The glass is the nearest one of the maker, if it is named, else a
    /// model.
    pub fn by_code(&self, code: &str) -> Option<GlassMatch> {
        code::by_code(&self.shelf, code)
    }

    /// Returns the glass of a name or, failing that, of a number.
    pub fn resolve(&self, text: &str, makers: &[&str]) -> Option<GlassMatch> {
        self.find(text, makers).or_else(|| self.by_code(text))
    }

    /// Returns the name of a similar spelling.
    pub fn suggest(&self, name: &str) -> Option<&str> {
        let bare = name.trim().rsplit(char::is_whitespace).next().unwrap_or_default();
        nearest_word(bare, self.shelf.glasses().iter().map(|glass| &*glass.name))
    }
}

impl Default for GlassLibrary {
    fn default() -> Self {
        Self::built_in()
    }
}

/// Returns the built-in glass of a name, in any spelling of [`GlassLibrary::find`]. One glass is
/// never taken for another: "BK7" is not "N-BK7".
pub fn find_glass(name: &str) -> Option<Arc<CatalogueGlass>> {
    match GlassLibrary::built_in().find(name, &[])? {
        GlassMatch { glass: Glass::Catalogue(glass), substitution: None, .. } => Some(glass),
        _ => None,
    }
}

/// Returns the built-in glass that an unknown name may mean: its lead-free successor, or one of
/// similar spelling.
pub fn suggest_glass(name: &str) -> Option<String> {
    let library = GlassLibrary::built_in();
    match library.find(name, &[]) {
        Some(GlassMatch { glass: Glass::Catalogue(glass), .. }) => Some(glass.name.to_string()),
        _ => library.suggest(name).map(str::to_owned),
    }
}
