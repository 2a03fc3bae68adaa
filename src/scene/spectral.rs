//! Scenes by wavelength: the same shapes, and lights, materials and media at the wavelengths of a set.
//!
//! Colours of the scene file that are spectra keep them; those that are RGB become smooth spectra. Images,
//! vertex colours and colours at points of space are changed by a matrix when they are looked up.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use petzval_spectrum::{
    Colour, WAVELENGTH_SETS, WAVELENGTHS, bands_of_set, uplift_matrix, uplift_reflectance,
    uplift_unbounded,
};

use super::light::{IntensityDistribution, Light};
use super::material::{Material, MaterialModel};
use super::material_colours::Quantity;
use super::medium::{Medium, MediumSpectra};
use super::texture::{SolidPattern, Texture};
use super::{Lights, Scene};

/// Memory of a texture that a material of a set has alone (bytes).
const NODE_BYTES: usize = 2 * size_of::<Texture>() + 16;

/// A scene at the wavelengths of all sets. Each is made when it is first asked for; all share shapes,
/// images, grids and hierarchies.
#[derive(Clone, Debug)]
pub struct SpectralScene {
    /// The scene whose materials and lights have spectra.
    base: Scene,
    media: Vec<MediumSpectra>,
    /// Whether a surface disperses light, so that there is a scene for each hero of a set.
    disperses: bool,
    /// Whether one wavelength goes on behind every surface.
    one_wavelength: bool,
    /// By set, or by band.
    scenes: Box<[OnceLock<Scene>]>,
}

impl SpectralScene {
    /// Finds the spectra of all colours.
    pub fn new(scene: &Scene) -> Self {
        let mut known = HashMap::new();
        let materials = scene.spectral_materials.as_ref().unwrap_or(&scene.materials);
        let with_spectra = |material: &Material| material.with_spectra(&mut known);
        let base = Scene {
            materials: materials.iter().map(with_spectra).collect(),
            spectral_materials: None,
            lights: Arc::new(scene.lights.with_spectra()),
            ..scene.clone()
        };
        let media = scene.media.iter().map(MediumSpectra::of).collect();
        let disperses = base.materials.iter().any(|material| material.model.needs_hero());
        let count = if disperses { WAVELENGTHS } else { WAVELENGTH_SETS };
        let scenes = (0..count).map(|_| OnceLock::new()).collect();
        Self { base, media, disperses, one_wavelength: false, scenes }
    }

    /// Returns the scene for paths of which one wavelength goes on behind the first surface, whatever its
    /// material: a measure of what three that share a path are worth.
    pub fn with_one_wavelength(&self) -> Self {
        let scenes = (0..WAVELENGTHS).map(|_| OnceLock::new()).collect();
        Self { disperses: true, one_wavelength: true, scenes, ..self.clone() }
    }

    /// Returns whether a surface of the scene disperses light, so that paths need a hero among their wavelengths.
    pub fn disperses(&self) -> bool {
        self.disperses
    }

    /// Returns the memory that the scenes of all sets take in addition to what they share (bytes).
    pub fn bytes(&self) -> u64 {
        let Scene { materials, lights, .. } = &self.base;
        let textures =
            materials.iter().map(|material| material.model.texture_nodes()).sum::<usize>();
        let measured = |material: &Material| match &material.model {
            MaterialModel::Measured(surface) => surface.bytes_of_sets() as u64,
            _ => 0,
        };
        let measured: u64 = materials.iter().map(measured).sum();
        let media = self.base.media.iter().map(Medium::own_bytes).sum::<usize>();
        let one = size_of::<Scene>()
            + size_of_val(&materials[..])
            + size_of_val(&lights.all[..])
            + textures * NODE_BYTES
            + media;
        (self.scenes.len() * one) as u64 + measured
    }

    /// Returns the scene at the wavelengths of a set. `hero` is the channel that goes on behind glass that
    /// disperses.
    pub fn at(&self, set: usize, hero: usize) -> &Scene {
        let hero = if self.disperses { hero } else { 0 };
        self.scenes[bands_of_set(set)[hero]].get_or_init(|| {
            let Self { base, media, one_wavelength, .. } = self;
            let materials = base.materials.iter().map(|material| {
                let material = material.in_set(set, hero);
                let only_channel = one_wavelength.then_some(hero).or(material.only_channel);
                Material { only_channel, ..material }
            });
            let media = base.media.iter().zip(media);
            Scene {
                materials: materials.collect(),
                lights: Arc::new(base.lights.in_set(set)),
                media: media.map(|(medium, spectra)| medium.in_set(spectra, set, hero)).collect(),
                ..base.clone()
            }
        })
    }
}

/// Returns materials with RGB in place of spectra, as they are shaded without the effect, and the materials
/// as they were, if a colour has a spectrum.
pub(super) fn in_rgb(materials: Arc<[Material]>) -> (Arc<[Material]>, Option<Arc<[Material]>>) {
    match materials.iter().any(Material::has_spectrum) {
        true => (materials.iter().map(Material::in_rgb).collect(), Some(materials)),
        false => (materials, None),
    }
}

/// Colours of known spectra by the bits of their RGB.
type KnownSpectra = HashMap<([u32; 3], Quantity), Arc<Colour>>;

impl Material {
    /// Returns the material with spectra in place of constant RGB.
    fn with_spectra(&self, known: &mut KnownSpectra) -> Self {
        let mut map = |texture: &Texture, quantity: Quantity| {
            texture.with_leaves(&mut |leaf| match leaf {
                Texture::Constant(rgb) => {
                    let key = (rgb.map(f32::to_bits), quantity);
                    let rgb = *rgb;
                    let colour = known.entry(key).or_insert_with(|| {
                        Arc::new(Colour::new(rgb, move || match quantity {
                            Quantity::Reflectance => uplift_reflectance(rgb),
                            Quantity::Unbounded => uplift_unbounded(rgb),
                        }))
                    });
                    Texture::Spectrum(colour.clone())
                }
                other => other.clone(),
            })
        };
        Self { model: self.model.with_colours(&mut map), ..self.clone() }
    }

    /// Returns the material with RGB in place of spectra.
    fn in_rgb(&self) -> Self {
        let mut map = |texture: &Texture, _| {
            texture.with_leaves(&mut |leaf| match leaf {
                Texture::Spectrum(colour) => Texture::Constant(colour.rgb),
                other => other.clone(),
            })
        };
        let model = match &self.model {
            MaterialModel::Measured(surface) => MaterialModel::Measured(Arc::new(surface.in_rgb())),
            other => other.with_colours(&mut map),
        };
        Self { model, ..self.clone() }
    }

    /// Returns whether a colour of the material has a spectrum.
    fn has_spectrum(&self) -> bool {
        let mut any =
            matches!(&self.model, MaterialModel::Measured(surface) if surface.has_spectra());
        self.model.with_colours(&mut |texture, _| {
            texture.with_leaves(&mut |leaf| {
                any |= matches!(leaf, Texture::Spectrum(_));
                leaf.clone()
            })
        });
        any
    }

    /// Returns the material at the wavelengths of a set, with the index of the hero.
    fn in_set(&self, set: usize, hero: usize) -> Self {
        let matrix = Arc::new(uplift_matrix(set));
        let mut map = |texture: &Texture, _| {
            texture.with_leaves(&mut |leaf| match leaf {
                Texture::Spectrum(colour) => match colour.spectrum() {
                    Some(spectrum) => Texture::Constant(spectrum.in_set(set)),
                    None => Texture::Constant(colour.rgb),
                },
                Texture::Bilerp { mapping, corners } => Texture::Bilerp {
                    mapping: mapping.clone(),
                    corners: corners.map(|rgb| uplift_reflectance(rgb).in_set(set)),
                },
                coloured if coloured.is_coloured() => {
                    let (texture, matrix) = (Arc::new(coloured.clone()), matrix.clone());
                    Texture::Uplifted { texture, matrix }
                }
                grey => grey.clone(),
            })
        };
        let mut material = Self { model: self.model.with_colours(&mut map), ..self.clone() };
        if material.model.fix_index(set, hero) {
            material.only_channel = Some(hero);
        }
        if let MaterialModel::Measured(surface) = &material.model {
            match surface.in_set(set) {
                Some(surface) => material.model = MaterialModel::Measured(Arc::new(surface)),
                None => material.measured_uplift = Some(*matrix),
            }
        }
        material
    }
}

impl Texture {
    /// Returns whether a leaf may have other colours than grey.
    fn is_coloured(&self) -> bool {
        match self {
            Self::Image(image) => image.picture.get().is_none_or(|picture| picture.channels() > 2),
            Self::Solid(solid) => matches!(solid.pattern, SolidPattern::Marble { .. }),
            _ => true,
        }
    }
}

impl Lights {
    /// Returns the lights with spectra in place of constant RGB.
    fn with_spectra(&self) -> Self {
        self.with_emission(|light| {
            let colour = light.emission_mut();
            *colour = colour.clone().into_light();
        })
    }

    /// Returns the lights at the wavelengths of a set.
    fn in_set(&self, set: usize) -> Self {
        self.with_emission(|light| {
            let colour = light.emission_mut();
            *colour = colour.spectrum().map_or(colour.rgb, |bands| bands.in_set(set)).into();
            let matrix = Some(uplift_matrix(set));
            match light {
                Light::Area(area) => area.emission.uplift = matrix,
                Light::Point(point) => {
                    if let IntensityDistribution::Projection { uplift, .. } =
                        &mut point.distribution
                    {
                        *uplift = matrix;
                    }
                }
                Light::Distant { .. } => (),
                Light::Infinite(sky) => sky.uplift = matrix,
                Light::Portal(portal) => portal.set_uplift(matrix),
            }
        })
    }
}

impl Light {
    /// Returns the colour of its emission, or the factor of its image.
    pub(super) fn emission(&self) -> &Colour {
        match self {
            Self::Area(area) => &area.emission.radiance,
            Self::Point(point) => &point.intensity,
            Self::Distant { irradiance, .. } => irradiance,
            Self::Infinite(sky) => &sky.radiance,
            Self::Portal(portal) => portal.emission(),
        }
    }

    fn emission_mut(&mut self) -> &mut Colour {
        match self {
            Self::Area(area) => &mut area.emission.radiance,
            Self::Point(point) => &mut point.intensity,
            Self::Distant { irradiance, .. } => irradiance,
            Self::Infinite(sky) => &mut sky.radiance,
            Self::Portal(portal) => portal.radiance_mut(),
        }
    }
}
