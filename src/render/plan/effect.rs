//! Effects that a plan decides about.

use std::fmt;
use std::str::FromStr;

/// Effect beyond rays of one wavelength through an ideal camera at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Effect {
    /// Dispersion: the refractive index depends on the wavelength.
    Dispersion,
    /// Fresnel losses: surfaces of the lens reflect a part of the light.
    Fresnel,
    /// Ghosts: light that is reflected twice inside the lens.
    Ghosts,
    /// The shape of the stop.
    Iris,
    /// Diffraction at the stop.
    Diffraction,
    /// Motion blur: objects or the camera move while the shutter is open.
    Motion,
    /// Rolling shutter: the rows of the sensor are read one after another.
    RollingShutter,
    /// Noise, saturation and quantization of the sensor.
    Sensor,
    /// Tilt and shift of the film, and decentred or tilted lens elements.
    TiltShift,
    /// Participating media, such as fog, smoke and clouds.
    Media,
    /// Spectra: paths carry wavelengths in place of red, green and blue.
    Spectra,
}

impl Effect {
    /// All effects.
    pub const ALL: [Self; 11] = [
        Self::Dispersion,
        Self::Fresnel,
        Self::Ghosts,
        Self::Iris,
        Self::Diffraction,
        Self::Motion,
        Self::RollingShutter,
        Self::Sensor,
        Self::TiltShift,
        Self::Media,
        Self::Spectra,
    ];

    /// Returns the name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dispersion => "dispersion",
            Self::Fresnel => "fresnel",
            Self::Ghosts => "ghosts",
            Self::Iris => "iris",
            Self::Diffraction => "diffraction",
            Self::Motion => "motion",
            Self::RollingShutter => "rolling_shutter",
            Self::Sensor => "sensor",
            Self::TiltShift => "tilt_shift",
            Self::Media => "media",
            Self::Spectra => "spectra",
        }
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Effect {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|effect| effect.name() == name).ok_or_else(|| {
            let known = Self::ALL.map(Self::name).join(", ");
            format!("no effect \"{name}\"; expected one of {known}")
        })
    }
}

/// Source of a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecidedBy {
    /// The scene file.
    Scene,
    /// The lens file.
    Lens,
    /// The command line.
    Flag,
}

impl DecidedBy {
    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Lens => "lens",
            Self::Flag => "flag",
        }
    }
}
