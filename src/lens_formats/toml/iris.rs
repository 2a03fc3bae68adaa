//! Opening of the stop: `blades`, `rotation`, `curvature`, `aperture`.

use std::path::Path;

use super::value::Section;
use petzval_base::io::{ReadContext, excerpt, hint};
use petzval_lens::LensError;
use petzval_lens::MASK_NAMES;
use petzval_lens::{ApertureMask, Iris};

/// Reads the shape of the opening; surfaces other than the stop are round.
pub(super) fn read(section: &Section, stop: bool) -> Result<Iris, LensError> {
    for key in ["blades", "rotation", "curvature", "aperture"] {
        if section.has(key) && !stop {
            let found = format!("{key} on a surface that is not the stop");
            return Err(section.error(key, found, "only a surface with stop = true has it"));
        }
    }
    for key in ["rotation", "curvature"] {
        if section.has(key) && !section.has("blades") {
            let found = format!("{key} without blades");
            return Err(section.error(key, found, "expected blades = 3 to 64 beside it"));
        }
    }
    if section.has("blades") && section.has("aperture") {
        return Err(section.error("aperture", "aperture beside blades", "a stop has one of them"));
    }
    let Some(blades) = section.number("blades")? else {
        return section.string("aperture")?.map_or(Ok(Iris::Round), |name| by_name(section, name));
    };
    if !(3.0..=64.0).contains(&blades) || blades.fract() != 0.0 {
        let found = format!("blades is {blades}");
        return Err(section.error("blades", found, "expected a whole number from 3 to 64"));
    }
    let rotation = section.finite("rotation")?.unwrap_or(0.0);
    let curvature = section.number("curvature")?.unwrap_or(0.0);
    if !(0.0..=1.0).contains(&curvature) {
        let found = format!("curvature is {curvature}");
        let expected = "expected 0 (straight blades) to 1 (a circle)";
        return Err(section.error("curvature", found, expected));
    }
    Ok(Iris::Blades { count: blades as u32, rotation, curvature })
}

/// Returns an opening by its name or from a picture.
fn by_name(section: &Section, name: &str) -> Result<Iris, LensError> {
    if name == "circular" {
        return Ok(Iris::Round);
    }
    if let Some(mask) = ApertureMask::named(name) {
        return Ok(Iris::Mask(mask));
    }
    let folder = section.source.path.parent().unwrap_or(Path::new(""));
    let known = MASK_NAMES.iter().copied().chain(["circular"]);
    let unknown = || {
        let found = format!("aperture is \"{}\"{}", excerpt(name), hint(name, known));
        let names = MASK_NAMES.join(", ");
        (found, format!("expected circular, {names}, or the path of a picture"))
    };
    by_picture(&folder.join(name), section.source.context).map(Iris::Mask).map_err(|problem| {
        let (found, expected) =
            problem.map_or_else(unknown, |found| (found, "expected a square picture".to_owned()));
        section.error("aperture", found, expected)
    })
}

/// Reads an opening from a picture. Returns what is wrong with it, or `None` if it is no picture.
#[cfg(feature = "pictures")]
fn by_picture(path: &Path, context: &ReadContext) -> Result<ApertureMask, Option<String>> {
    use petzval_image::ImageError;

    crate::mask_file::read_mask(path, context).map_err(|error| match error {
        ImageError::Format { .. } => None,
        other => Some(other.to_string()),
    })
}

/// Refuses pictures, which this build does not read.
#[cfg(not(feature = "pictures"))]
fn by_picture(path: &Path, _: &ReadContext) -> Result<ApertureMask, Option<String>> {
    let found = "it is a picture, and this program reads none (feature \"pictures\" of petzval-lens-formats)";
    Err(path.is_file().then(|| found.to_owned()))
}
