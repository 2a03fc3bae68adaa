//! Lights that are no shapes, from their parameters.

use std::path::Path;

use glam::{DAffine3, DVec3, Mat3};

use super::colour::Meaning;
use super::params::Params;
use super::textures::Library;
use super::{Dialect, SceneError};
use crate::scene::{ImageMap, Light, Mapping, Sky, SkyImage, SkyLayout, Wrap};

impl Library {
    /// Makes a light that is no shape.
    pub(super) fn light(
        &mut self,
        name: &str,
        params: &Params,
        ctm: &DAffine3,
        dialect: Dialect,
        folder: &Path,
    ) -> Result<Light, SceneError> {
        let scale = params.scale()?;
        let scaled = |name: &str| -> Result<[f32; 3], SceneError> {
            let colour = params.colour(name, Meaning::Light)?.unwrap_or([1.0; 3]);
            Ok([0, 1, 2].map(|i| colour[i] * scale[i]))
        };
        let point = |name: &str, default: [f64; 3]| -> Result<DVec3, SceneError> {
            Ok(DVec3::from_array(params.triple(name)?.unwrap_or(default)))
        };
        Ok(match name {
            "point" => Light::Point {
                position: ctm.transform_point3(point("from", [0.0; 3])?).as_vec3(),
                intensity: scaled("I")?,
            },
            "distant" => {
                let towards = point("from", [0.0; 3])? - point("to", [0.0, 0.0, 1.0])?;
                let towards = ctm.transform_vector3(towards).try_normalize().ok_or_else(|| {
                    params.refuse("to", "a distant light from nowhere", "from and to must differ")
                })?;
                Light::Distant { towards: towards.as_vec3(), irradiance: scaled("L")? }
            }
            _ => {
                let radiance = scaled("L")?;
                let file = if params.find("filename").is_some() { "filename" } else { "mapname" };
                let picture = self.picture(params, file, folder, true)?;
                let image = picture.map(|picture| {
                    let flat = picture.size[0] != picture.size[1];
                    let layout = match dialect {
                        Dialect::V4 if !flat => SkyLayout::EqualArea,
                        _ => SkyLayout::Equirectangular,
                    };
                    let linear = ctm.matrix3.inverse().to_cols_array().map(|v| v as f32);
                    SkyImage {
                        map: ImageMap {
                            picture,
                            mapping: Mapping::default(),
                            wrap: Wrap::Clamp,
                            top_down: true,
                            scale: 1.0,
                            invert: false,
                        },
                        light_from_world: Mat3::from_cols_array(&linear),
                        layout,
                    }
                });
                Light::Infinite(Sky { radiance, image })
            }
        })
    }
}
