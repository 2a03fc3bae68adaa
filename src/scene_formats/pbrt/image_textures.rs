//! Image textures: wrap mode, filter and transfer function.

use super::params::Params;
use super::texture_library::TextureLibrary;
use super::textures::TextureDirective;
use super::{Dialect, SceneError};
use petzval_image::Transfer;
use petzval_scene::{ImageTexture, TextureFilter, Wrap};

impl TextureLibrary {
    pub(super) fn image_texture(
        &mut self,
        directive: &TextureDirective,
    ) -> Result<ImageTexture, SceneError> {
        let params = &directive.params;
        let transfer = transfer_function(params)?;
        let Some(picture) = self.image_files.request(params, "filename", transfer)? else {
            let found = "an imagemap without \"string filename\"";
            return Err(params.refuse("filename", found, "expected the name of a picture"));
        };
        let wrap = match params.text("wrap")? {
            None | Some("repeat") => Wrap::Repeat,
            Some("clamp") => Wrap::Clamp,
            Some("black") => Wrap::Black,
            Some("octahedralsphere") => Wrap::OctahedralSphere,
            Some(other) => {
                let found = format!("the wrap mode \"{other}\"");
                let expected = "expected repeat, clamp, black or octahedralsphere";
                return Err(params.refuse("wrap", found, expected));
            }
        };
        let trilinear = params.boolean("trilinear")?;
        let filter = match params.text("filter")? {
            // EWA is the default of pbrt-v2. The trilinear filter is its substitute, unless
            // `maxanisotropy` is given.
            None if directive.dialect == Dialect::V2 || trilinear == Some(true) => {
                TextureFilter::Trilinear
            }
            None | Some("bilinear") => TextureFilter::Bilinear,
            Some("point") => TextureFilter::Point,
            Some("trilinear") => TextureFilter::Trilinear,
            Some("EWA" | "ewa") => TextureFilter::Trilinear,
            Some(other) => {
                let found = format!("the filter \"{other}\"");
                let expected = "expected point, bilinear, trilinear or EWA";
                return Err(params.refuse("filter", found, expected));
            }
        };
        let ewa = match params.text("filter")? {
            Some(name) => matches!(name, "EWA" | "ewa"),
            None => {
                directive.dialect == Dialect::V2
                    && trilinear != Some(true)
                    && params.find("maxanisotropy").is_some()
            }
        };
        let max_anisotropy = if ewa { Some(max_anisotropy(params)?) } else { None };
        Ok(ImageTexture {
            picture,
            mapping: directive.mapping()?,
            wrap,
            filter,
            max_anisotropy,
            top_down: directive.dialect == Dialect::V2,
            scale: params.float("scale", 1.0)? as f32,
            invert: params.boolean("invert")?.unwrap_or(false),
        })
    }
}

/// Reads the largest anisotropy of the filter EWA.
fn max_anisotropy(params: &Params) -> Result<f32, SceneError> {
    // An ellipse has four texels for each unit of anisotropy, or more.
    const LARGEST: f64 = 1024.0;
    let value = params.float("maxanisotropy", 8.0)?;
    if !(1.0..=LARGEST).contains(&value) {
        let found = format!("a ratio of {value}");
        let expected = format!("expected 1 to {LARGEST}");
        return Err(params.refuse("maxanisotropy", found, expected));
    }
    Ok(value as f32)
}

/// Reads the transfer function of a PNG or TIFF.
fn transfer_function(params: &Params) -> Result<Transfer, SceneError> {
    let gamma = |name: &str, gamma: f64| match gamma > 0.0 && gamma.is_finite() {
        true if gamma == 1.0 => Ok(Transfer::Linear),
        true => Ok(Transfer::Gamma(gamma as f32)),
        false => Err(params.refuse(name, format!("a gamma of {gamma}"), "expected more than 0")),
    };
    match params.text("encoding")? {
        Some("sRGB") => Ok(Transfer::Srgb),
        Some("linear") => Ok(Transfer::Linear),
        Some(other) => match other.strip_prefix("gamma ").map(|rest| rest.trim().parse::<f64>()) {
            Some(Ok(power)) => gamma("encoding", power),
            _ => {
                let found = format!("the encoding \"{other}\"");
                Err(params.refuse("encoding", found, "expected sRGB, linear or \"gamma 2.2\""))
            }
        },
        // Before pbrt-v4, `gamma` is a power, or a boolean that means sRGB.
        None => match params.find("gamma") {
            None => Ok(Transfer::Srgb),
            Some(param) if param.kind == "bool" => match params.boolean("gamma")? {
                Some(false) => Ok(Transfer::Linear),
                _ => Ok(Transfer::Srgb),
            },
            Some(_) => gamma("gamma", params.float("gamma", 1.0)?),
        },
    }
}
