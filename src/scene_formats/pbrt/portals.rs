//! Portals of infinite lights: `"point3 portal"` with the four corners of a rectangle.

use std::sync::Arc;

use glam::{DVec3, Mat3, Vec3};

use super::SceneError;
use super::lights::{sky_radiance, unframed};
use super::params::Params;
use petzval_image::Picture;
use petzval_scene::{Light, Portal, SkyImage, SkyLayout};
use petzval_spectrum::Colour;

/// Reads the corners of a portal, if it is given: world space, whatever the transform.
pub(super) fn portal_corners(params: &Params) -> Result<Option<[Vec3; 4]>, SceneError> {
    let Some(numbers) = params.numbers("portal", &["point3", "point"])? else { return Ok(None) };
    let (corners, rest) = numbers.as_chunks::<3>();
    match corners {
        [a, b, c, d] if rest.is_empty() => {
            Ok(Some([a, b, c, d].map(|corner| DVec3::from_array(*corner).as_vec3())))
        }
        _ => {
            let found = format!("a portal of {} numbers", numbers.len());
            Err(params.refuse("portal", found, "expected the four corners of a rectangle"))
        }
    }
}

/// Makes an infinite light behind a portal.
pub(super) fn portal(
    params: &Params,
    corners: [Vec3; 4],
    picture: Option<Arc<Picture>>,
    light_from_world: Mat3,
    strength: Colour,
) -> Result<Light, SceneError> {
    let uniform = || Arc::new(Picture { size: [1, 1], pixels: vec![[1.0; 3]] });
    let picture = picture.unwrap_or_else(uniform);
    let [width, height] = picture.size;
    if width != height {
        let found = format!("a sky of {width} x {height} pixels with a portal");
        let expected = "expected a square of all directions (equal-area octahedral), as pbrt's \
                        imgtool makeequiarea writes";
        return Err(params.refuse("filename", found, expected));
    }
    let illuminance = || {
        let map = unframed(picture.clone(), true);
        let sky = SkyImage::new(map, light_from_world, SkyLayout::EqualArea);
        sky.map_or(f32::NAN, |sky| sky.illuminance())
    };
    let radiance = sky_radiance(params, strength, illuminance)?;
    match Portal::new(corners, &picture, light_from_world, radiance) {
        Ok(portal) => Ok(Light::Portal(Box::new(portal))),
        Err(error) => {
            let expected = "expected the corners of a rectangle, counted around it";
            Err(params.refuse("portal", error.to_string(), expected))
        }
    }
}
