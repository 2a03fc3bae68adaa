//! Lens drawer: the lenses that can be put on the camera, with their sections.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use petzval_lens::{Paraxial, RealRayFocus};
use petzval_lens_formats::read;
use petzval_scene_formats::pbrt::{CameraSpec, Description, RealisticSpec};
use serde_json::{Value, json};

use crate::cli::Failure;
use petzval_report::lens_drawing::draw_small;

/// Extensions of lens files. Files of other kinds in the folder are left out.
const EXTENSIONS: [&str; 7] = ["dat", "toml", "zmx", "seq", "len", "json", "fx"];

/// Largest number of lenses in the drawer.
const MAX_LENSES: usize = 500;

/// Lens files, each read when it is first shown.
pub(super) struct LensDrawer {
    lenses: Vec<(PathBuf, OnceLock<Option<LensCard>>)>,
    /// Half the diagonal of the film (mm).
    film_radius: f64,
    /// The lens file of the scene.
    own: Option<PathBuf>,
}

/// Entry of the drawer: a lens with its facts and its section drawing.
struct LensCard {
    facts: Value,
    section: String,
}

impl LensDrawer {
    /// Returns the lenses in the folder of the scene's lens and in others. A camera without a lens
    /// file takes none.
    pub fn new(description: &Description, folders: &[PathBuf]) -> Result<Self, Failure> {
        let CameraSpec::Realistic(spec) = &description.camera else {
            return Ok(Self { lenses: Vec::new(), film_radius: 0.0, own: None });
        };
        let (own, diagonal) = match spec {
            RealisticSpec::V4 { lens, .. } => (lens, description.film.diagonal),
            RealisticSpec::V2 { lens, film_diagonal, .. } => (lens, *film_diagonal),
        };
        let mut paths = BTreeSet::from([own.clone()]);
        let parent = own.parent().filter(|parent| !parent.as_os_str().is_empty());
        // Without it, the lens itself is in the drawer; its error comes with the picture.
        paths.extend(lens_files(parent.unwrap_or(Path::new("."))).unwrap_or_default());
        for folder in folders {
            let found = lens_files(folder).map_err(|error| {
                format!("--lenses {}: {error}; expected a folder of lens files", folder.display())
            })?;
            paths.extend(found);
        }
        let lenses = paths.into_iter().take(MAX_LENSES).map(|path| (path, OnceLock::new()));
        Ok(Self { lenses: lenses.collect(), film_radius: diagonal / 2.0, own: Some(own.clone()) })
    }

    /// Returns whether a lens is in the drawer.
    pub fn holds(&self, path: &str) -> bool {
        self.lenses.iter().any(|(lens, _)| lens.to_str() == Some(path))
    }

    /// Returns the list of lenses that can be read.
    pub fn list(&self) -> Value {
        let lens = |(number, (path, _)): (usize, &(PathBuf, _))| {
            let mut facts = self.card(number)?.facts.clone();
            facts["section"] = json!(format!("section/{number}.svg"));
            facts["path"] = json!(path.to_str()?);
            facts["scene"] = json!(self.own.as_ref() == Some(path));
            Some(facts)
        };
        self.lenses.iter().enumerate().filter_map(lens).collect()
    }

    /// Returns the drawing of a lens, as SVG.
    pub fn section(&self, number: usize) -> Option<&str> {
        Some(&self.card(number)?.section)
    }

    fn card(&self, number: usize) -> Option<&LensCard> {
        let (path, card) = self.lenses.get(number)?;
        let card = card.get_or_init(|| {
            let lens = read(path).ok()?;
            let focus = RealRayFocus::new(&lens);
            let film = focus.film_distance(f64::INFINITY).ok();
            let facts = json!({
                "file": path.file_name()?.to_str()?,
                "name": lens.name,
                "focal_length": Paraxial::new(&lens).focal_length,
                "f_number": focus.f_number(),
                "zoom": lens.zoom_range(),
            });
            Some(LensCard { facts, section: draw_small(&lens, film, self.film_radius) })
        });
        card.as_ref()
    }
}

/// Returns the lens files of a folder.
fn lens_files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let is_lens = |path: &PathBuf| {
        let extension = path.extension().and_then(|extension| extension.to_str());
        extension.is_some_and(|found| EXTENSIONS.contains(&found)) && path.is_file()
    };
    let paths = fs::read_dir(folder)?.filter_map(|entry| Some(entry.ok()?.path()));
    Ok(paths.filter(is_lens).collect())
}
