//! Readers of lenses in JSON, told apart by their members.

mod deeplens;
mod geopter;
mod iset;
mod lentil;
mod optiland;
mod parser;
mod rayoptics;
mod value;

use std::path::Path;

use self::value::Json;
use super::report::ReadReport;
use petzval_base::io::ReadContext;
use petzval_lens::LensError;
use petzval_lens::Prescription;

/// Parses a text. `entry` chooses a lens of a file that holds many, by its key or name.
///
/// # Errors
/// Returns an error with line and column if the text is no JSON, is of an unknown program, or
/// describes no lens.
pub(super) fn parse(
    path: &Path,
    text: &str,
    entry: Option<&str>,
    context: &ReadContext,
) -> Result<Prescription, LensError> {
    let json = parser::parse(path, text)?;
    let mut left_out = ReadReport::new(context);
    let is_lens = |value: &Json<'_>| lentil::elements(value).is_some();
    let is_list = json.members().iter().any(|(_, value)| is_lens(value));
    if let (Some(entry), false) = (entry, is_list) {
        let found = format!("\"{entry}\" is asked for, and the file holds one lens");
        return Err(json.error(found, "leave out what follows the #"));
    }
    if is_list {
        lentil::read(path, &json, entry, &mut left_out)
    } else if is_lens(&json) {
        lentil::read_lens(path, "", &json, &mut left_out)
    } else if let Some(model) = json.get("optical_model") {
        rayoptics::read(path, model, &mut left_out)
    } else if json.get("surface_group").is_some() {
        optiland::read(path, &json, &mut left_out)
    } else if let Some(assembly) = json.get("Assembly") {
        geopter::read(path, &json, assembly, &mut left_out)
    } else if let Some(surfaces) = json.get("surfaces") {
        let of_deeplens = |surface: &Json<'_>| {
            surface.any(&["d_next", "mat2", "mat1"]).is_some() && surface.get("ior").is_none()
        };
        match surfaces.list()?.iter().any(of_deeplens) {
            true => deeplens::read(path, &json, surfaces, &mut left_out),
            false => iset::read(path, &json, surfaces, &mut left_out),
        }
    } else {
        Err(json.error(
            "JSON without a lens",
            "expected a file of ISET or DeepLens (\"surfaces\"), optiland (\"surface_group\"), \
             rayoptics (\"optical_model\"), geopter (\"Assembly\") or lentil (\"optical-elements-patent\")",
        ))
    }
}
