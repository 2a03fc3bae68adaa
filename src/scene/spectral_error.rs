//! Error of RGB in place of spectra: the colours of surfaces under the lights of a scene.

use std::collections::HashSet;
use std::f32::consts::LN_2;

use petzval_spectrum::{
    BandSpectrum, Colour, ciede2000, fresnel, lab_from_srgb, uplift_reflectance,
};

use super::light::{Light, luminance};
use super::material::{Material, MaterialModel, Metal};
use super::material_colours::Quantity;
use super::medium::MediumColours;
use super::texture::{Texture, TexturePoint};
use super::{Scene, Sky};

/// Most lights, and most colours of surfaces, that are compared.
const MOST: usize = 48;

/// Largest errors of one reflection, calculated in RGB, over the lights and surfaces of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RgbErrors {
    /// That of a light and a surface of which at least one is given by wavelength.
    pub stated: RgbError,
    /// That of a light and a surface that are both given as RGB: the smooth spectra of which it is
    /// calculated are guesses.
    pub guessed: RgbError,
}

/// Error of one reflection, calculated in RGB.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RgbError {
    /// Difference of the colours (CIEDE2000), white being a white surface under the same light.
    pub difference: f64,
    /// Error of a channel, of the brightest one (percent).
    pub percent: f64,
    /// That channel: red, green or blue.
    pub channel: usize,
}

/// A colour in RGB, and by wavelength.
struct Seen {
    rgb: [f64; 3],
    spectrum: BandSpectrum,
    /// Whether the scene gives it by wavelength.
    is_stated: bool,
}

impl Scene {
    /// Returns whether bodies of glass in the scene disperse light: coats and skins of media show no
    /// fringes.
    pub fn disperses(&self) -> bool {
        let body = |material: &Material| {
            matches!(material.model, MaterialModel::Dielectric { dispersion: Some(_), .. })
        };
        self.materials.iter().any(body)
    }

    /// Returns the largest errors of one reflection, over at most 48 lights and 48 colours, and of as many media
    /// that are given by wavelength. The image of a sky counts by its mean, images of other lights as white.
    pub fn rgb_errors(&self) -> RgbErrors {
        // Under daylight, RGB is right by definition.
        let lights = self.lights.all.iter().filter(|light| !light.is_daylight());
        let lights: Vec<Seen> = lights.take(MOST).filter_map(Light::seen).collect();
        let mut worst = RgbErrors::default();
        if !lights.is_empty() {
            for surface in self.surface_colours() {
                lights.iter().for_each(|light| worst.add(light, &surface));
            }
        }
        // What a medium lets through is wrong in daylight too.
        let media = self.media.iter().filter_map(|medium| medium.colours.as_ref()?.seen());
        for medium in media.take(MOST) {
            lights.iter().chain(&[Seen::daylight()]).for_each(|light| worst.add(light, &medium));
        }
        worst
    }

    /// Returns different colours of surfaces.
    fn surface_colours(&self) -> Vec<Seen> {
        let materials = self.spectral_materials.as_ref().unwrap_or(&self.materials);
        let mut colours = Colours::default();
        for material in materials.iter() {
            colours.add_metal(material);
            colours.add_measured(material);
            material.model.with_colours(&mut |texture, quantity| {
                if quantity == Quantity::Reflectance {
                    texture.with_leaves(&mut |leaf| {
                        colours.add(leaf);
                        leaf.clone()
                    });
                }
                texture.clone()
            });
        }
        colours.all
    }
}

impl Seen {
    fn daylight() -> Self {
        let spectrum = BandSpectrum::from_bands(|_| 1.0);
        Self { rgb: [1.0; 3], spectrum, is_stated: false }
    }
}

impl RgbErrors {
    /// Adds the error of a surface under a light.
    fn add(&mut self, light: &Seen, surface: &Seen) {
        let of_kind = match light.is_stated || surface.is_stated {
            true => &mut self.stated,
            false => &mut self.guessed,
        };
        let error = RgbError::of(light, surface);
        if error.difference > of_kind.difference {
            *of_kind = error;
        }
    }
}

impl MediumColours {
    /// Returns the colour of a medium: the albedo if it scatters, or else what passes it where half of the
    /// light is left; `None` if it is clear.
    fn seen(&self) -> Option<Seen> {
        let Self { absorption, scattering, .. } = self;
        let mean = |colour: &Colour| colour.rgb.iter().sum::<f32>() / 3.0;
        let scatters = mean(scattering) > 0.0;
        let depth = LN_2 / mean(absorption);
        if !(depth > 0.0 && depth.is_finite()) {
            return None;
        }
        let value = |absorbed: f32, scattered: f32| match scatters {
            true if scattered > 0.0 => scattered / (absorbed + scattered),
            true => 0.0,
            false => (-absorbed * depth).exp(),
        };
        let rgb = [0, 1, 2].map(|c| f64::from(value(absorption.rgb[c], scattering.rgb[c])));
        let [absorbed, scattered] = [absorption, scattering].map(Colour::unbounded_spectrum);
        let of_band = |band: usize| value(absorbed.values()[band], scattered.values()[band]);
        Some(Seen { rgb, spectrum: BandSpectrum::from_bands(of_band), is_stated: true })
    }
}

impl RgbError {
    /// Returns the error of a surface under a light; none if it is dark.
    fn of(light: &Seen, surface: &Seen) -> Self {
        let exact = light.spectrum.times(&surface.spectrum).to_rgb();
        let rgb = [0, 1, 2].map(|c| light.rgb[c] * surface.rgb[c]);
        let brightest = exact.iter().fold(0.0f64, |a, &b| a.max(b));
        let difference = ciede2000(lab_from_srgb(rgb), lab_from_srgb(exact));
        if brightest <= 0.0 || difference.is_nan() {
            return Self::default();
        }
        let off = |c: usize| 100.0 * (rgb[c] - exact[c]).abs() / brightest;
        let channel = (0..3).max_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap_or(0);
        Self { difference, percent: off(channel), channel }
    }
}

/// Different colours.
#[derive(Default)]
struct Colours {
    all: Vec<Seen>,
    known: HashSet<[u32; 3]>,
}

impl Colours {
    /// Adds the colour of a constant, or that of an image on average.
    fn add(&mut self, leaf: &Texture) {
        let everywhere = TexturePoint { uv: [0.5; 2], footprint: 1.0, ..TexturePoint::default() };
        let rgb = match leaf {
            Texture::Constant(rgb) => *rgb,
            Texture::Spectrum(colour) => colour.rgb,
            Texture::Image(_) => leaf.colour::<f32>(&everywhere),
            _ => return,
        };
        if self.is_new(rgb) {
            let spectrum = match leaf {
                Texture::Spectrum(colour) => colour.spectrum().cloned(),
                _ => None,
            };
            let is_stated = spectrum.is_some();
            let spectrum = spectrum.unwrap_or_else(|| uplift_reflectance(rgb));
            self.all.push(Seen { rgb: rgb.map(f64::from), spectrum, is_stated });
        }
    }

    /// Adds a metal whose index is known by wavelength, as it reflects straight back.
    fn add_metal(&mut self, material: &Material) {
        let (MaterialModel::Conductor { metal, .. } | MaterialModel::CoatedConductor { metal, .. }) =
            &material.model
        else {
            return;
        };
        let Metal::Index { eta: Texture::Spectrum(eta), k: Texture::Spectrum(k), tint } = metal
        else {
            return;
        };
        let (Some(n), Some(extinction)) = (eta.spectrum(), k.spectrum()) else { return };
        let tint = tint.constant().unwrap_or([1.0; 3]);
        let reflected = |c: usize| fresnel(1.0, eta.rgb[c].into(), k.rgb[c].into());
        let rgb = [0, 1, 2].map(|c| f64::from(tint[c]) * reflected(c));
        if self.is_new(rgb.map(|c| c as f32)) {
            let value = |band: usize| {
                fresnel(1.0, n.values()[band].into(), extinction.values()[band].into()) as f32
            };
            let spectrum = BandSpectrum::from_bands(value);
            self.all.push(Seen { rgb, spectrum, is_stated: true });
        }
    }

    /// Adds the mean of a measured surface, half as bright as white: how bright it is depends on the
    /// direction.
    fn add_measured(&mut self, material: &Material) {
        let MaterialModel::Measured(surface) = &material.model else { return };
        let Some(mean) = surface.mean_spectrum() else { return };
        let brightest = mean.to_rgb().into_iter().fold(0.0, f64::max);
        if brightest <= 0.0 {
            return;
        }
        let spectrum = mean.scaled((0.5 / brightest) as f32);
        let rgb = spectrum.to_rgb();
        if self.is_new(rgb.map(|c| c as f32)) {
            self.all.push(Seen { rgb, spectrum, is_stated: true });
        }
    }

    fn is_new(&mut self, rgb: [f32; 3]) -> bool {
        let grey = rgb[0] == rgb[1] && rgb[1] == rgb[2];
        !grey && self.all.len() < MOST && self.known.insert(rgb.map(f32::to_bits))
    }
}

impl Light {
    /// Returns whether the light is daylight of any strength.
    fn is_daylight(&self) -> bool {
        let colour = self.emission();
        let [r, g, b] = colour.rgb;
        let even = |spectrum: &BandSpectrum| {
            let mean = spectrum.values().iter().sum::<f32>() / spectrum.values().len() as f32;
            spectrum.values().iter().all(|value| (value - mean).abs() <= 1e-2 * mean)
        };
        let image = matches!(self, Self::Infinite(sky) if sky.image.is_some());
        !image && r == g && g == b && colour.spectrum().is_none_or(even)
    }

    /// Returns its colour at luminance 1, that of an image on average; `None` if it is dark.
    fn seen(&self) -> Option<Seen> {
        let mut colour = self.emission().clone();
        if let Self::Infinite(Sky { image: Some(image), .. }) = self {
            let mean = image.mean_colour();
            colour = [0, 1, 2].map(|c| colour.rgb[c] * mean[c]).into();
        }
        let luminance = luminance(colour.rgb);
        let usable = luminance > 0.0 && luminance.is_finite();
        if !usable {
            return None;
        }
        let is_stated = colour.has_spectrum();
        let colour = colour.divided(luminance).into_light();
        let spectrum = colour.spectrum().cloned()?;
        Some(Seen { rgb: colour.rgb.map(f64::from), spectrum, is_stated })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::{Homogeneous, Medium, MediumModel};
    use crate::{IntensityDistribution, PointLight, SceneBuilder};
    use glam::{Mat3, Vec3};
    use petzval_spectrum::{Spectrum, colour_matching, named_spectrum, srgb_from_xyz};

    /// Returns the error of a surface of a pigment under a lamp.
    fn error(lamp: &Spectrum, pigment: &Spectrum) -> RgbError {
        let mut builder = SceneBuilder::default();
        let of = pigment.clone();
        let bands = move || BandSpectrum::of(|nm| of.at(nm));
        let reflectance = Colour::new(pigment.reflectance(), bands).into();
        builder.add_material(Material::new(MaterialModel::Diffuse { reflectance }));
        builder.add_light(Light::Point(PointLight {
            position: Vec3::ZERO,
            light_from_world: Mat3::IDENTITY,
            intensity: Colour::new(lamp.light(), {
                let lamp = lamp.clone();
                move || lamp.light_by_wavelength()
            }),
            distribution: IntensityDistribution::Isotropic,
        }));
        builder.build().expect("a small scene").rgb_errors().stated
    }

    /// Returns linear sRGB of an integral over the wavelength.
    fn integral(value: impl Fn(f64) -> f64) -> [f64; 3] {
        let mut xyz = [0.0; 3];
        for nm in (360..=830).map(f64::from) {
            (0..3).for_each(|c| xyz[c] += value(nm) * colour_matching(nm)[c]);
        }
        srgb_from_xyz(xyz)
    }

    #[test]
    fn a_fluorescent_lamp_needs_spectra_and_daylight_does_not() {
        let samples = vec![[400.0, 0.04], [580.0, 0.05], [600.0, 0.3], [620.0, 0.7], [700.0, 0.8]];
        let red = Spectrum::samples(samples).expect("in order");
        let named = |name: &str| named_spectrum(name).expect("a lamp");
        let lamp = named("stdillum-F2");
        let luminance = petzval_spectrum::luminosity_integral() * lamp.to_xyz()[1];
        let exact = integral(|nm| lamp.at(nm) * red.at(nm)).map(|c| c / luminance);
        let expected = 100.0 * (f64::from(lamp.light()[0] * red.reflectance()[0]) / exact[0] - 1.0);
        let found = error(&lamp, &red);
        assert_eq!(found.channel, 0);
        assert!((found.percent - expected).abs() < 0.5, "{found:?}, not {expected} %");
        assert!(expected > 20.0 && found.difference > 5.0, "{found:?}");
        let day = error(&named("stdillum-D65"), &red);
        assert!(day.difference < 0.01, "{day:?}");
    }

    #[test]
    fn a_dye_needs_spectra_even_in_daylight_and_grey_glass_does_not() {
        let error = |samples: Vec<[f64; 2]>| {
            let dye = Spectrum::samples(samples).expect("in order");
            let mut builder = SceneBuilder::default();
            let of = dye.clone();
            let absorption =
                Colour::new(dye.reflectance(), move || BandSpectrum::of(|nm| of.at(nm)));
            let colours = MediumColours::dark(absorption, [0.0; 3].into());
            let model = MediumModel::Homogeneous(Homogeneous::of(&colours));
            let medium = builder.add_medium(Medium::new(model, 0.0, colours.if_spectral()));
            builder.set_camera_medium(medium);
            builder.build().expect("a small scene").rgb_errors().stated
        };
        // Light of 500 nm is absorbed 20 times as much as light of 600 nm.
        let dye = [[400.0, 1.0], [500.0, 20.0], [550.0, 10.0], [600.0, 1.0], [700.0, 1.0]];
        let found = error(dye.to_vec());
        let of_light = |absorbed: f64, depth: f64| (-absorbed * depth).exp();
        let dye = Spectrum::samples(dye.to_vec()).expect("in order");
        let rgb = dye.reflectance().map(f64::from);
        let depth = std::f64::consts::LN_2 * 3.0 / rgb.iter().sum::<f64>();
        let daylight = named_spectrum("stdillum-D65").expect("a known spectrum");
        let white = integral(|nm| daylight.at(nm));
        let exact = integral(|nm| daylight.at(nm) * of_light(dye.at(nm), depth));
        let exact = [0, 1, 2].map(|c| exact[c] / white[c]);
        let brightest = exact.iter().fold(0.0f64, |a, &b| a.max(b));
        let off = |c: usize| 100.0 * (of_light(rgb[c], depth) - exact[c]).abs() / brightest;
        let expected = (0..3).map(off).fold(0.0, f64::max);
        assert!(expected > 5.0 && found.difference > 1.0, "{found:?}, {expected} %");
        assert!((found.percent - expected).abs() < 0.5, "{found:?}, not {expected} %");
        let grey = error(vec![[360.0, 3.0], [830.0, 3.0]]);
        assert!(grey.difference < 0.01, "{grey:?}");
    }

    /// A blue lamp before a green wall, both of which may be anything of that colour.
    #[test]
    fn colours_that_are_given_as_rgb_are_guesses() {
        let mut builder = SceneBuilder::default();
        let reflectance = Texture::Constant([0.1, 0.6, 0.2]);
        builder.add_material(Material::new(MaterialModel::Diffuse { reflectance }));
        builder.add_light(Light::Point(PointLight {
            position: Vec3::ZERO,
            light_from_world: Mat3::IDENTITY,
            intensity: [0.05, 0.2, 1.0].into(),
            distribution: IntensityDistribution::Isotropic,
        }));
        let errors = builder.build().expect("a small scene").rgb_errors();
        assert_eq!(errors.stated, RgbError::default());
        assert!(errors.guessed.difference > 1.0, "{errors:?}");
    }
}
