//! The effects, and who decides about them.

use std::str::FromStr;

/// What a picture may need beyond rays of one wavelength through a still, perfect camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Effect {
    /// Glass bends blue light more than red.
    Dispersion,
    /// Surfaces of glass mirror a part of the light.
    Fresnel,
    /// Light that was mirrored twice inside the lens.
    Ghosts,
    /// The shape of the stop.
    Iris,
    /// Light bends at the stop.
    Diffraction,
    /// Things or the camera move while the shutter is open.
    Motion,
    /// Rows of the sensor are read one after another.
    RollingShutter,
    /// Noise, full wells and steps of the sensor.
    Sensor,
    /// The film or an element stands askew.
    TiltShift,
}

impl Effect {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Dispersion,
        Self::Fresnel,
        Self::Ghosts,
        Self::Iris,
        Self::Diffraction,
        Self::Motion,
        Self::RollingShutter,
        Self::Sensor,
        Self::TiltShift,
    ];

    /// Its name on the command line and in reports.
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
        }
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

/// Who decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// What the scene file says, or does not.
    Scene,
    /// What the lens file says, or does not.
    Lens,
    /// The command line.
    Flag,
}

impl By {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Lens => "lens",
            Self::Flag => "flag",
        }
    }
}
