//! Lights of the extension KHR_lights_punctual: point, spot and directional.

use glam::{DAffine3, DMat3, DVec3};

use super::document::Document;
use super::schema::Light as LightJson;
use crate::pbrt::SceneError;
use petzval_scene::{IntensityDistribution, Light, PointLight};

/// Returns the lights of a document.
pub(super) fn lights(document: &Document) -> &[LightJson] {
    let extensions = document.root.extensions.as_ref();
    extensions.and_then(|all| all.lights.as_ref()).map_or(&[], |all| &all.lights)
}

/// Reads a light at a node. Candela become radiant intensity and lux irradiance as they are.
pub(super) fn read_light(
    document: &Document,
    index: usize,
    world_from_node: &DAffine3,
    named_at: &str,
) -> Result<Light, SceneError> {
    let light = document.entry(lights(document), index, "lights", named_at)?;
    let element = format!("extensions/KHR_lights_punctual/lights/{index}");
    let strength = light.color.map(|c| c * light.intensity);
    if !strength.iter().all(|s| s.is_finite() && *s >= 0.0) {
        let found = format!("an intensity of {strength:?}");
        return Err(document.error(&element, found, "expected 0 or more"));
    }
    if light.range.is_some() {
        let message = "the range of a light is not read: its light reaches everywhere";
        document.warn(&element, message);
    }
    // Lights shine along -z of their node.
    let towards = world_from_node.transform_vector3(DVec3::Z).normalize_or(DVec3::Z);
    let at_point = |distribution: IntensityDistribution| {
        let x = towards.any_orthonormal_vector();
        // Light space, whose +z is the direction of the light.
        let world_from_light = DMat3::from_cols(x, x.cross(towards), -towards);
        Light::Point(PointLight {
            position: world_from_node.translation.as_vec3(),
            light_from_world: world_from_light.transpose().as_mat3(),
            intensity: strength.into(),
            distribution,
        })
    };
    match &light.kind[..] {
        "directional" => {
            Ok(Light::Distant { towards: towards.as_vec3(), irradiance: strength.into() })
        }
        "point" => Ok(at_point(IntensityDistribution::Isotropic)),
        "spot" => {
            let spot = light.spot.as_ref();
            let inner = spot.map_or(0.0, |spot| spot.inner_cone_angle);
            let outer = spot.map_or(std::f32::consts::FRAC_PI_4, |spot| spot.outer_cone_angle);
            if !(0.0..=outer).contains(&inner) || outer > std::f32::consts::FRAC_PI_2 {
                let found = format!("cone angles of {inner} and {outer}");
                let expected = "expected 0 <= innerConeAngle <= outerConeAngle <= pi/2";
                return Err(document.error(&format!("{element}/spot"), found, expected));
            }
            let cosines = [outer.cos(), inner.cos()];
            Ok(at_point(IntensityDistribution::Spot { cosines }))
        }
        _ => {
            let expected = "expected directional, point or spot";
            let element = format!("{element}/type");
            Err(document.error(&element, "a light of an unknown type", expected))
        }
    }
}
