//! Materials: metallic-roughness surfaces, what they emit, and one record of each that is made.

use std::collections::HashMap;

use super::document::Document;
use super::images::{Channels, Images};
use super::material_extensions::DielectricReflection;
use super::schema::Material as MaterialJson;
use super::textures::{TextureUse, image_map};
use crate::pbrt::SceneError;
use petzval_image::Transfer;
use petzval_scene::{
    Emission, ImageMap, Material, MaterialModel, MediumInterface, MetallicRoughnessSurface,
    SceneBuilder, Texture,
};

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
pub(super) struct MaterialReader<'a> {
    pub document: &'a Document,
    pub builder: &'a mut SceneBuilder,
    pub images: &'a mut Images,
    pub json: &'a MaterialJson,
    pub element: String,
    pub variant: Variant,
    /// Sets of texture coordinates of the textures that were read.
    pub uv_sets: Vec<u32>,
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
        if let Some(name) = &self.json.name {
            self.builder.name_material(material, name);
        }
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
        let [r, g, b, _] = pbr.base_color_factor;
        let base_colour = self.base_colour([r, g, b])?;
        let roughness = self.roughness(
            pbr.roughness_factor,
            pbr.metallic_roughness_texture.as_ref(),
            "pbrMetallicRoughness/metallicRoughnessTexture",
        )?;
        let metallic = match &pbr.metallic_roughness_texture {
            Some(info) => {
                let channels = Channels::Single(2, Transfer::Linear);
                let at = "pbrMetallicRoughness/metallicRoughnessTexture";
                self.texture(info, at, channels, pbr.metallic_factor)?
            }
            None => Texture::Constant([pbr.metallic_factor; 3]),
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

    fn emission(&mut self) -> Result<Option<Emission>, SceneError> {
        let extensions = self.json.extensions.as_ref();
        let strength = extensions
            .and_then(|all| all.emissive_strength.as_ref())
            .map_or(1.0, |extension| extension.emissive_strength);
        let radiance = self.json.emissive_factor.map(|factor| factor * strength);
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
                Some(
                    image_map(self.document, self.images, &texture, false, |colour| colour)?.into(),
                )
            }
            None => None,
        };
        let two_sided = self.json.double_sided;
        Ok(Some(Emission { image, two_sided, ..Emission::uniform(radiance) }))
    }
}
