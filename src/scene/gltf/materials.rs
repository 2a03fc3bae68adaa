//! Materials: metallic-roughness surfaces with the extensions ior, specular, transmission, volume,
//! clearcoat and emissive strength.

use std::collections::HashMap;
use std::sync::Arc;

use gltf_json::material::{AlphaMode, Material as MaterialJson, NormalTexture};
use gltf_json::validation::Checked;
use serde::Deserialize;

use super::document::Document;
use super::images::{Channels, Images};
use super::material_extensions::{self, Clearcoat, MaterialExtension, Specular};
use super::textures::{TextureUse, image_map, image_texture};
use crate::io::image::Transfer;
use crate::scene::pbrt::SceneError;
use crate::scene::{
    Emission, Homogeneous, ImageMap, Material, MaterialModel, Medium, MediumInterface,
    MetallicRoughnessSurface, Roughness, SceneBuilder, Texture, VACUUM,
};

/// Refractive index without the extension ior.
const DEFAULT_IOR: f32 = 1.5;

/// A material as shapes use it.
#[derive(Clone, Debug)]
pub(super) struct ShapeMaterial {
    pub material: u32,
    pub emission: Option<Emission>,
    pub alpha: Option<Texture>,
    pub interface: Option<MediumInterface>,
    /// The set of texture coordinates.
    pub uv_set: u32,
    /// Whether it has a normal map, so that the tangents of meshes matter.
    pub normal_map: bool,
}

/// Variant of a material that a mesh needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Variant {
    /// Whether the y axis of its normal map points the other way, for meshes whose texture
    /// coordinates are mirrored.
    pub mirrored: bool,
    /// Whether the colours of vertices multiply its base colour.
    pub coloured: bool,
}

/// The materials that are made so far, by index and variant. The material of primitives that name
/// none has no index.
#[derive(Default)]
pub(super) struct Materials {
    made: HashMap<(Option<usize>, Variant), ShapeMaterial>,
    images: Images,
}

/// The reflection of a dielectric.
struct DielectricReflection {
    strength: Texture,
    colour: Texture,
}

/// Returns the product of two textures; a factor of 1 is left out.
fn product(one: Texture, other: Texture) -> Texture {
    match one {
        Texture::Constant([1.0, 1.0, 1.0]) => other,
        one => Texture::Scale(Arc::new(one), Arc::new(other)),
    }
}

impl Materials {
    /// Returns a variant of a material.
    pub fn surface(
        &mut self,
        document: &Document,
        builder: &mut SceneBuilder,
        index: Option<usize>,
        variant: Variant,
        named_at: &str,
    ) -> Result<ShapeMaterial, SceneError> {
        if let Some(surface) = self.made.get(&(index, variant)) {
            return Ok(surface.clone());
        }
        let default = MaterialJson::default();
        let json = match index {
            Some(index) => {
                document.entry(&document.root.materials, index, "materials", named_at)?
            }
            None => &default,
        };
        let element = format!("materials/{}", index.unwrap_or(0));
        let images = &mut self.images;
        let uv_sets = Vec::new();
        let mut reader =
            MaterialReader { document, builder, images, json, element, variant, uv_sets };
        let surface = reader.surface()?;
        self.made.insert((index, variant), surface.clone());
        Ok(surface)
    }
}

/// Reads one material.
struct MaterialReader<'a> {
    document: &'a Document,
    builder: &'a mut SceneBuilder,
    images: &'a mut Images,
    json: &'a MaterialJson,
    element: String,
    variant: Variant,
    /// Sets of texture coordinates of the textures that were read.
    uv_sets: Vec<u32>,
}

impl MaterialReader<'_> {
    fn surface(&mut self) -> Result<ShapeMaterial, SceneError> {
        let normal_map = match &self.json.normal_texture {
            Some(texture) => Some(self.normal_map(texture)?),
            None => None,
        };
        let has_normal_map = normal_map.is_some();
        let transmits = self.transmission()?;
        let material = self.layers(normal_map, transmits.as_ref())?;
        let (emission, alpha) = (self.emission()?, self.alpha()?);
        Ok(ShapeMaterial {
            material,
            emission,
            alpha,
            interface: transmits.is_some().then(|| self.interior()).flatten(),
            uv_set: self.uv_set(),
            normal_map: has_normal_map,
        })
    }

    /// Returns the index of the material: a metal and a dielectric below a clear coat. Light passes
    /// through a share of the dielectric.
    fn layers(
        &mut self,
        normal_map: Option<ImageMap>,
        transmits: Option<&Texture>,
    ) -> Result<u32, SceneError> {
        let pbr = &self.json.pbr_metallic_roughness;
        let extensions = self.json.extensions.as_ref();
        if extensions.is_some_and(|extensions| extensions.unlit.is_some()) {
            let message = "an unlit material is read as one that light falls on";
            self.document.warn(&self.element, message);
        }
        let [r, g, b, _] = pbr.base_color_factor.0;
        let base_colour = self.base_colour([r, g, b])?;
        let roughness = self.roughness(
            pbr.roughness_factor.0,
            pbr.metallic_roughness_texture.as_ref(),
            "pbrMetallicRoughness/metallicRoughnessTexture",
        )?;
        let metallic = match &pbr.metallic_roughness_texture {
            Some(info) => {
                let channels = Channels::Single(2, Transfer::Linear);
                let at = "pbrMetallicRoughness/metallicRoughnessTexture";
                self.texture(info, at, channels, pbr.metallic_factor.0)?
            }
            None => Texture::Constant([pbr.metallic_factor.0; 3]),
        };
        let eta = self.ior()?;
        let DielectricReflection { strength: specular, colour: specular_colour } =
            self.specular()?;
        let (coat_coverage, coat_roughness) = self.clearcoat()?;
        let surface = MetallicRoughnessSurface {
            base_colour,
            metallic,
            roughness,
            eta,
            specular,
            specular_colour,
            coat_coverage,
            coat_roughness,
        };
        let Some(share) = transmits else {
            return Ok(self.add(MaterialModel::MetallicRoughness(Box::new(surface)), normal_map));
        };
        // Only the dielectric lets light through.
        let constant = |share: f32| Texture::Constant([share; 3]);
        let glass = self.glass(eta, &surface);
        let [opaque, metal] = [0.0, 1.0].map(|metallic| {
            let part = MetallicRoughnessSurface { metallic: constant(metallic), ..surface.clone() };
            self.add(MaterialModel::MetallicRoughness(Box::new(part)), normal_map.clone())
        });
        let glass = self.add(glass, normal_map);
        let dielectric = self.mix(share, opaque, glass);
        Ok(self.mix(&surface.metallic, dielectric, metal))
    }

    fn add(&mut self, model: MaterialModel, normal_map: Option<ImageMap>) -> u32 {
        self.builder.add_material(Material { normal_map, ..Material::new(model) })
    }

    /// Returns the mixture of two materials, or one of them if the other has no share.
    fn mix(&mut self, amount: &Texture, first: u32, second: u32) -> u32 {
        match amount {
            Texture::Constant([share, ..]) if *share <= 0.0 => first,
            Texture::Constant([share, ..]) if *share >= 1.0 => second,
            amount => self.builder.add_material(Material::new(MaterialModel::Mix {
                materials: [first, second],
                amount: amount.clone(),
            })),
        }
    }

    /// Returns the glass of a surface that transmits light: a sheet unless it has a thickness.
    /// Its base colour tints what passes through each of its faces.
    fn glass(&self, eta: f32, surface: &MetallicRoughnessSurface) -> MaterialModel {
        let MetallicRoughnessSurface { roughness, base_colour: tint, .. } = surface;
        if self.has_volume() {
            let roughness = roughness.clone();
            return match tint {
                Texture::Constant([1.0, 1.0, 1.0]) => MaterialModel::Dielectric { eta, roughness },
                tint => MaterialModel::TintedDielectric { eta, roughness, tint: tint.clone() },
            };
        }
        if !matches!(roughness.uv[0], Texture::Constant([0.0, ..])) {
            let message = "a rough sheet without thickness is clear: give it KHR_materials_volume";
            self.document.warn(&self.element, message);
        }
        MaterialModel::ThinDielectric { eta, tint: tint.clone() }
    }

    fn has_volume(&self) -> bool {
        let volume = self.json.extensions.as_ref().and_then(|all| all.volume.as_ref());
        volume.is_some_and(|volume| volume.thickness_factor.0 > 0.0)
    }

    /// Returns the medium inside, if the surface bounds a volume.
    fn interior(&mut self) -> Option<MediumInterface> {
        if !self.has_volume() {
            return None;
        }
        let volume = self.json.extensions.as_ref()?.volume.as_ref()?;
        let distance = volume.attenuation_distance.0;
        let colour = volume.attenuation_color.0;
        let absorption =
            colour.map(|c| (-c.clamp(1e-6, 1.0).ln() / distance.max(f32::MIN_POSITIVE)).max(0.0));
        if absorption.iter().all(|&a| a == 0.0 || !a.is_finite()) {
            return None;
        }
        let medium = Homogeneous { absorption, scattering: [0.0; 3], emission: [0.0; 3] };
        let inside = self.builder.add_medium(Medium::homogeneous(medium, 0.0));
        Some(MediumInterface { inside, outside: VACUUM })
    }

    /// Returns the share of the light that the dielectric transmits, if any.
    fn transmission(&mut self) -> Result<Option<Texture>, SceneError> {
        let extensions = self.json.extensions.as_ref();
        let Some(transmission) = extensions.and_then(|all| all.transmission.as_ref()) else {
            return Ok(None);
        };
        let factor = transmission.transmission_factor.0;
        if factor <= 0.0 {
            return Ok(None);
        }
        if extensions.is_some_and(|all| all.others.contains_key(Specular::NAME)) {
            let message = "KHR_materials_specular does not change the reflection of what transmits \
                           light";
            self.document.warn(&self.element, message);
        }
        let Some(info) = &transmission.transmission_texture else {
            return Ok(Some(Texture::Constant([factor; 3])));
        };
        let at = "extensions/KHR_materials_transmission/transmissionTexture";
        self.texture(info, at, Channels::Single(0, Transfer::Linear), factor).map(Some)
    }

    fn ior(&self) -> Result<f32, SceneError> {
        let extensions = self.json.extensions.as_ref();
        let Some(ior) = extensions.and_then(|all| all.ior.as_ref()).map(|ior| ior.ior.0) else {
            return Ok(DEFAULT_IOR);
        };
        match ior {
            // A surface of index 0 reflects everything, by the extension.
            0.0 => Ok(1e4),
            1.0..=1e4 => Ok(ior),
            _ => {
                let element = format!("{}/extensions/KHR_materials_ior/ior", self.element);
                let found = format!("an index of {ior}");
                Err(self.document.error(&element, found, "expected 1 or more, or 0"))
            }
        }
    }

    /// Reads an extension of the material.
    fn extension<E: MaterialExtension>(&self) -> Result<Option<E>, SceneError> {
        material_extensions::read(self.document, self.json, &self.element)
    }

    /// Returns the coverage and the roughness of the clear coat.
    fn clearcoat(&mut self) -> Result<(Texture, Roughness), SceneError> {
        let Some(coat) = self.extension::<Clearcoat>()? else {
            return Ok((Texture::Constant([0.0; 3]), Roughness::smooth()));
        };
        let name = Clearcoat::NAME;
        if coat.clearcoat_normal_texture.is_some() {
            let element = format!("{}/extensions/{name}/clearcoatNormalTexture", self.element);
            self.document.warn(&element, "the normal map of a clear coat is not read");
        }
        let coverage = match &coat.clearcoat_texture {
            Some(info) => {
                let at = format!("extensions/{name}/clearcoatTexture");
                let channels = Channels::Single(0, Transfer::Linear);
                self.texture(info, &at, channels, coat.clearcoat_factor)?
            }
            None => Texture::Constant([coat.clearcoat_factor; 3]),
        };
        let roughness = self.roughness(
            coat.clearcoat_roughness_factor,
            coat.clearcoat_roughness_texture.as_ref(),
            &format!("extensions/{name}/clearcoatRoughnessTexture"),
        )?;
        Ok((coverage, roughness))
    }

    /// Returns the roughness of microfacets: alpha is the square of glTF's roughness. The texture
    /// holds it in its green channel.
    fn roughness(
        &mut self,
        factor: f32,
        texture: Option<&gltf_json::texture::Info>,
        at: &str,
    ) -> Result<Roughness, SceneError> {
        let scale = factor * factor;
        let alpha = match texture {
            Some(info) => {
                self.texture(info, at, Channels::Single(1, Transfer::Gamma(2.0)), scale)?
            }
            None => Texture::Constant([scale; 3]),
        };
        Ok(Roughness { uv: [alpha.clone(), alpha], remap: false })
    }

    /// Returns the base colour: its texture times its factor and the colour of the vertices.
    fn base_colour(&mut self, factor: [f32; 3]) -> Result<Texture, SceneError> {
        let info = self.json.pbr_metallic_roughness.base_color_texture.as_ref();
        let colour = self.colour(factor, info, "pbrMetallicRoughness/baseColorTexture")?;
        Ok(match self.variant.coloured {
            true => product(colour, Texture::VertexColour),
            false => colour,
        })
    }

    /// Returns a colour: its texture, if there is one, times its factor.
    fn colour(
        &mut self,
        factor: [f32; 3],
        texture: Option<&gltf_json::texture::Info>,
        at: &str,
    ) -> Result<Texture, SceneError> {
        let Some(info) = texture else { return Ok(Texture::Constant(factor)) };
        Ok(product(Texture::Constant(factor), self.texture(info, at, Channels::Colour, 1.0)?))
    }

    /// Returns strength and colour of the reflection of the dielectric.
    fn specular(&mut self) -> Result<DielectricReflection, SceneError> {
        let json = self.extension::<Specular>()?.unwrap_or_default();
        let name = Specular::NAME;
        let strength = match &json.specular_texture {
            Some(info) => {
                let at = format!("extensions/{name}/specularTexture");
                self.texture(
                    info,
                    &at,
                    Channels::Single(3, Transfer::Linear),
                    json.specular_factor,
                )?
            }
            None => Texture::Constant([json.specular_factor; 3]),
        };
        let at = format!("extensions/{name}/specularColorTexture");
        let texture = json.specular_color_texture.as_ref();
        Ok(DielectricReflection {
            strength,
            colour: self.colour(json.specular_color_factor, texture, &at)?,
        })
    }

    fn texture(
        &mut self,
        info: &gltf_json::texture::Info,
        at: &str,
        channels: Channels,
        scale: f32,
    ) -> Result<Texture, SceneError> {
        let texture = TextureUse::new(info, format!("{}/{at}", self.element));
        self.uv_sets.push(texture.set());
        image_texture(self.document, self.images, &texture, channels, scale)
    }

    fn emission(&mut self) -> Result<Option<Emission>, SceneError> {
        let extensions = self.json.extensions.as_ref();
        let strength = extensions
            .and_then(|all| all.emissive_strength.as_ref())
            .map_or(1.0, |extension| extension.emissive_strength.0);
        let radiance = self.json.emissive_factor.0.map(|factor| factor * strength);
        if !radiance.iter().all(|r| r.is_finite() && *r >= 0.0) {
            let element = format!("{}/emissiveFactor", self.element);
            let found = format!("a radiance of {radiance:?}");
            return Err(self.document.error(&element, found, "expected 0 or more"));
        }
        if radiance == [0.0; 3] {
            return Ok(None);
        }
        let image = match &self.json.emissive_texture {
            Some(info) => {
                let texture = TextureUse::new(info, format!("{}/emissiveTexture", self.element));
                self.uv_sets.push(texture.set());
                Some(image_map(self.document, self.images, &texture, false, |colour| colour)?)
            }
            None => None,
        };
        let two_sided = self.json.double_sided;
        Ok(Some(Emission { image, two_sided, ..Emission::uniform(radiance) }))
    }

    fn alpha(&mut self) -> Result<Option<Texture>, SceneError> {
        let pbr = &self.json.pbr_metallic_roughness;
        let factor = pbr.base_color_factor.0[3];
        let cutoff = self.json.alpha_cutoff.unwrap_or_default().0;
        let channels = match self.json.alpha_mode {
            Checked::Valid(AlphaMode::Opaque) => return Ok(None),
            Checked::Valid(AlphaMode::Mask) => Channels::Mask { factor, cutoff },
            Checked::Valid(AlphaMode::Blend) => Channels::Alpha,
            Checked::Invalid => {
                let element = format!("{}/alphaMode", self.element);
                let expected = "expected OPAQUE, MASK or BLEND";
                return Err(self.document.error(&element, "an unknown alpha mode", expected));
            }
        };
        let masked = matches!(channels, Channels::Mask { .. });
        // A mask is a threshold of the texture's opacity, without that of the vertices.
        let coloured = self.variant.coloured && !masked;
        let alpha = self.opacity(channels, masked, factor, cutoff)?;
        Ok(Some(if coloured { product(alpha, Texture::VertexOpacity) } else { alpha }))
    }

    /// Returns the opacity of the base colour, or where it is at least the cutoff.
    fn opacity(
        &mut self,
        channels: Channels,
        masked: bool,
        factor: f32,
        cutoff: f32,
    ) -> Result<Texture, SceneError> {
        let pbr = &self.json.pbr_metallic_roughness;
        let Some(info) = &pbr.base_color_texture else {
            let alpha = if masked { f32::from(factor >= cutoff) } else { factor };
            return Ok(Texture::Constant([alpha; 3]));
        };
        let scale = if masked { 1.0 } else { factor };
        self.texture(info, "pbrMetallicRoughness/baseColorTexture", channels, scale)
    }

    fn normal_map(&mut self, texture: &NormalTexture) -> Result<ImageMap, SceneError> {
        let extensions = texture.extensions.as_ref();
        let element = format!("{}/normalTexture", self.element);
        let transform = extensions.and_then(|all| all.others.get("KHR_texture_transform"));
        let transform = transform.and_then(|value| Deserialize::deserialize(value).ok());
        let used = TextureUse {
            index: texture.index,
            tex_coord: texture.tex_coord,
            transform: transform.as_ref(),
            element,
        };
        self.uv_sets.push(used.set());
        let along = [
            texture.scale,
            if self.variant.mirrored { -texture.scale } else { texture.scale },
            1.0,
        ];
        let change = |signal: [f32; 3]| {
            let tilted: [f32; 3] = std::array::from_fn(|i| (2.0 * signal[i] - 1.0) * along[i]);
            let length = tilted.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-6);
            tilted.map(|x| (x / length + 1.0) / 2.0)
        };
        image_map(self.document, self.images, &used, true, change)
    }

    /// Returns the set of texture coordinates of the base colour, or else of the first texture.
    fn uv_set(&self) -> u32 {
        let base = self.json.pbr_metallic_roughness.base_color_texture.as_ref();
        let base = base.map(|info| TextureUse::new(info, String::new()).set());
        let first = base.or(self.uv_sets.first().copied()).unwrap_or(0);
        if self.uv_sets.iter().any(|&set| set != first) {
            let message = format!(
                "a material reads one set of texture coordinates: all its textures use set {first}"
            );
            self.document.warn(&self.element, &message);
        }
        first
    }
}
