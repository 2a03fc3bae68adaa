//! Saved scene: the scene file with the camera as it is set, and the command for the rest.

use std::fs;
use std::io::Write as _;
use std::path::{Component, Path, PathBuf};

use petzval_base::io::{FileLog, Location, OutputFile};
use petzval_lens::{Camera, LensModel, RealLens};
use petzval_scene_formats::gltf;
use petzval_scene_formats::pbrt::{
    CameraEdit, CameraSpec, CameraValue, Description, RealisticSpec,
};

use super::file_name::new_file;
use super::settings::ViewSettings;
use crate::cli::arguments::argv::shell_line;

/// Distance for a focus at infinity, for which scene files have no number (m).
const FAR: f64 = 1e12;

/// Writes scene files into the folder of the scene.
pub(super) struct SceneSaver {
    scene: PathBuf,
    camera_at: Location,
    files: FileLog,
    /// Whether the scene gives the film's distance instead of the focus, as in pbrt-v2; `None`
    /// without a lens file.
    by_film: Option<bool>,
}

/// A scene that was saved.
pub(super) struct SavedScene {
    pub file: PathBuf,
    /// The command that renders it.
    pub command: String,
}

impl SceneSaver {
    pub fn new(scene: &Path, description: &Description) -> Self {
        let by_film = match &description.camera {
            CameraSpec::Realistic(spec) => Some(matches!(spec, RealisticSpec::V2 { .. })),
            _ => None,
        };
        let (camera_at, files) = (description.camera_at.clone(), description.files.clone());
        Self { scene: scene.to_owned(), camera_at, files, by_film }
    }

    fn folder(&self) -> &Path {
        let parent = self.scene.parent().filter(|parent| !parent.as_os_str().is_empty());
        parent.unwrap_or(Path::new("."))
    }

    /// Saves the scene with the lens, focus, stop, film pose and place of the camera. `focus` is the
    /// distance in focus (m).
    ///
    /// # Errors
    /// Returns a message if the name is refused or taken, if another file than the scene itself holds
    /// the camera, or if the file cannot be written.
    pub fn save(
        &self,
        name: &str,
        settings: &ViewSettings,
        camera: &Camera,
        focus: Option<f64>,
    ) -> Result<SavedScene, String> {
        if gltf::is_gltf(&self.scene) {
            let scene = self.scene.display();
            return Err(format!("{scene} is glTF, which holds no lens. Save the command instead"));
        }
        let file = new_file(self.folder(), name, &["pbrt"])?;
        let text = fs::read(&self.scene).map_err(|error| self.failed(&error))?;
        let (edit, written) = self.edit(settings, camera, focus)?;
        let edited = edit.apply(&text, &self.camera_at).map_err(|error| self.failed(&error))?;
        let edited = edited.ok_or_else(|| {
            format!(
                "{} does not name its camera itself; {} does. Save the command instead",
                self.scene.display(),
                self.camera_at.file.display()
            )
        })?;
        let command = shell_line(&settings.of_scene(&file, &written));
        let name = self.scene.file_name().unwrap_or_default().to_string_lossy();
        let head = format!(
            "# {} with the camera of petzval view. The rest of the settings:\n# {}\n",
            one_line(&name),
            one_line(&command)
        );
        let output = OutputFile::new(&file, &self.files).map_err(|error| error.to_string())?;
        // It does not follow a link, and leaves a file that has come in between alone.
        let write = |to: &mut fs::File| {
            to.write_all(head.as_bytes())?;
            to.write_all(&edited)
        };
        output.only_new().write(write).map_err(|error| format!("{}: {error}", file.display()))?;
        Ok(SavedScene { file, command })
    }

    fn failed(&self, error: &dyn std::fmt::Display) -> String {
        format!("{}: {error}", self.scene.display())
    }

    /// Returns the edit of the camera, and the options that it replaces.
    fn edit(
        &self,
        settings: &ViewSettings,
        camera: &Camera,
        focus: Option<f64>,
    ) -> Result<(CameraEdit, Vec<&'static str>), String> {
        let mut edit = CameraEdit::default();
        let mut written = vec!["look-at"];
        if settings.value("look-at").is_some() {
            edit.world_from_camera = Some(camera.world_from_camera);
        }
        let (Some(by_film), LensModel::Real(lens)) = (self.by_film, &camera.model) else {
            return Ok((edit, written));
        };
        let [file, aperture] = match by_film {
            true => ["specfile", "aperture_diameter"],
            false => ["lensfile", "aperturediameter"],
        };
        let mut put = |option: &'static str, name: &'static str, value: CameraValue| {
            edit.parameters.push((name, value));
            written.push(option);
        };
        if let Some(path) = settings.value("lens") {
            put("lens", file, CameraValue::Text(relative(self.folder(), Path::new(path))?));
        }
        if settings.value("fstop").is_some() {
            put("fstop", aperture, CameraValue::Number(stop_diameter(lens)));
        }
        match settings.value("focus") {
            Some(_) if by_film => {
                put("focus", "filmdistance", CameraValue::Number(lens.film_distance));
            }
            Some(given) => {
                let distance = given.parse().ok().or(focus).filter(|m| m.is_finite());
                put("focus", "focusdistance", CameraValue::Number(distance.unwrap_or(FAR)));
            }
            None => {}
        }
        for (option, name) in [("film-shift", "filmshift"), ("film-tilt", "filmtilt")] {
            let numbers = settings.value(option).and_then(|text| text.split_once(','));
            if let Some((x, y)) = numbers
                && let (Ok(x), Ok(y)) = (x.trim().parse(), y.trim().parse())
            {
                put(option, name, CameraValue::Pair([x, y]));
            }
        }
        Ok((edit, written))
    }
}

/// Returns text that stays in the comment of a line: control characters become blanks.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn stop_diameter(lens: &RealLens) -> f64 {
    lens.prescription.rows[lens.prescription.stop()].diameter
}

/// Returns the path of a file as seen from a folder.
fn relative(folder: &Path, file: &Path) -> Result<String, String> {
    let whole =
        |path: &Path| path.canonicalize().map_err(|error| format!("{}: {error}", path.display()));
    let (folder, file) = (whole(folder)?, whole(file)?);
    let common = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(common).map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(file.components().skip(common)).collect();
    path.to_str().map(str::to_owned).ok_or_else(|| {
        format!("{}: a path that is not UTF-8 cannot stand in a scene", file.display())
    })
}
