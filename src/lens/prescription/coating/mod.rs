//! Coatings, and the transmittance of a surface for unpolarised light by angle.
//!
//! With n and n' the indices on both sides, xi = n cos(theta), xi' = n' cos(theta') and the
//! admittances y = xi for light polarised across the plane of incidence (s) and y = n^2 / xi for
//! light polarised in it (p):
//!
//! ```text
//! bare     T = 4 y y' / (y + y')^2                                           (Fresnel 1823)
//! a layer  T = 4 y y' / ((y + y')^2 cos^2 b + (y y' / y1 + y1)^2 sin^2 b)
//!          b = (pi / 2) (tuned / wavelength) cos(theta1) for a quarter wave
//! ```
//!
//! (Born & Wolf, Principles of Optics, 1999, eqs. 1.5.21 and 1.6.57; Macleod, Thin-Film Optical
//! Filters, 2010, sec. 2.6). The formulas need only square roots that refraction takes anyway, and
//! no difference of similar numbers. Several layers are in [`LayerStack`]. Unpolarised light has the mean of both; the small polarisation
//! that light acquires from surface to surface is neglected. T is the same in both directions.

mod layer_stack;

pub use layer_stack::{CoatingLayer, LayerStack, StackModel};

use petzval_base::lanes::Real;

/// Coating of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Coating {
    /// Bare glass.
    #[default]
    Bare,
    /// A quarter wave of magnesium fluoride, n = [`MGF2_INDEX`], for [`DESIGN_WAVELENGTH`] at
    /// normal incidence.
    Mgf2,
    /// An ideal multilayer coating for all wavelengths. It reflects [`BROADBAND_REFLECTANCE`] at
    /// normal incidence and everything at grazing incidence. In between it rises as bare glass
    /// does: R = R0 + (1 - R0) F with F = (R_bare - R_bare0) / (1 - R_bare0), the form of Schlick
    /// 1994, eq. 15. It models no particular product; those differ.
    Broadband,
    /// A lossless surface, which does not exist.
    Perfect,
    /// Films of stated materials and thicknesses.
    Stack(LayerStack),
}

/// Coating that a lens has if nothing names one: a layer of magnesium fluoride, as on nearly all
/// lenses since the middle of the twentieth century.
pub const ASSUMED_COATING: Coating = Coating::Mgf2;

/// Refractive index of magnesium fluoride near 550 nm (Dodge 1984, ordinary ray, rounded).
pub const MGF2_INDEX: f64 = 1.38;
/// Wavelength of which the layer is a quarter (nm).
pub const DESIGN_WAVELENGTH: f64 = 550.0;
/// Reflectance of the ideal broadband coating at normal incidence.
pub const BROADBAND_REFLECTANCE: f64 = 0.0025;
/// Shortest wavelength at which the phase of a layer is in the range of the series for its cosine
/// (nm).
const SHORTEST: f64 = DESIGN_WAVELENGTH / 2.0;

impl Coating {
    /// Names of the coatings that need no definition, in files and on the command line.
    pub const NAMES: [&str; 4] = ["none", "mgf2", "broadband", "perfect"];

    /// Returns the coating of one of [`Self::NAMES`], ignoring case.
    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::Bare, Self::Mgf2, Self::Broadband, Self::Perfect];
        all.into_iter().find(|coating| coating.name().eq_ignore_ascii_case(name))
    }

    /// Returns its name.
    pub fn name(&self) -> &str {
        match self {
            Self::Bare => Self::NAMES[0],
            Self::Mgf2 => Self::NAMES[1],
            Self::Broadband => Self::NAMES[2],
            Self::Perfect => Self::NAMES[3],
            Self::Stack(stack) => &stack.name,
        }
    }

    /// Returns whether its transmittance depends on the wavelength, beyond the dispersion of the glass.
    pub fn is_coloured(&self) -> bool {
        matches!(self, Self::Mgf2 | Self::Stack(_))
    }

    /// Returns the number of films of a stack; 0 for coatings that need none.
    pub fn layers(&self) -> u32 {
        match self {
            Self::Stack(stack) => stack.layers.len() as u32,
            _ => 0,
        }
    }

    /// Returns whether a surface between two indices can be coated: one of them, as that of air,
    /// must be below that of the layer. Cemented surfaces are not coated.
    pub fn applies_to([n, after]: [f64; 2]) -> bool {
        n != after && n.min(after) < MGF2_INDEX
    }

    /// Returns the transmittance for unpolarised light from one index to the next, by the cosine of
    /// the angle of incidence and the wavelength (nm); 0 for total reflection.
    pub fn transmittance(&self, indices: [f64; 2], cos: f64, nm: f64) -> f64 {
        let xi2 = (indices[0] * cos).powi(2);
        if xi2 + (indices[1].powi(2) - indices[0].powi(2)) <= 0.0 {
            return 0.0;
        }
        CoatingModel::new::<f64>(self, indices, nm).transmittance::<f64>(xi2)
    }
}

/// Coating of one surface, ready for a kernel. Indices are in the direction of travel.
#[derive(Clone, Debug, PartialEq)]
pub enum CoatingModel<T> {
    /// No losses.
    Lossless,
    /// Bare glass, or a coating whose reflectance follows that of bare glass.
    Bare(BareInterface<T>),
    /// One quarter-wave layer.
    QuarterWave(QuarterWaveLayer<T>),
    /// Several layers.
    Stack(StackModel<T>),
}

/// An interface between two media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BareInterface<T> {
    /// n^2.
    n2: T,
    /// n'^2.
    after2: T,
    /// n'^2 - n^2.
    n2_step: T,
    /// Transmittance at normal incidence over that of bare glass.
    gain: T,
}

/// A quarter-wave layer between two media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuarterWaveLayer<T> {
    interface: BareInterface<T>,
    /// n1^2.
    layer2: T,
    /// n1^2 - n^2.
    layer2_step: T,
    /// Phase b over n1 cos(theta1).
    phase: T,
}

impl<T: Copy> CoatingModel<T> {
    /// Prepares a coating between two indices for one wavelength (nm). The layer is exact to 1e-6
    /// from 275 to 2000 nm.
    pub fn new<R: Real<Scalar = T>>(coating: &Coating, [n, after]: [f64; 2], nm: f64) -> Self {
        if n == after || *coating == Coating::Perfect {
            return Self::Lossless;
        }
        let bare = 4.0 * n * after / (n + after).powi(2);
        let gain = match coating {
            Coating::Broadband if Coating::applies_to([n, after]) => {
                (1.0 - BROADBAND_REFLECTANCE).max(bare) / bare
            }
            _ => 1.0,
        };
        let (n2, after2) = (n * n, after * after);
        let interface = BareInterface {
            n2: R::from_f64(n2),
            after2: R::from_f64(after2),
            n2_step: R::from_f64(after2 - n2),
            gain: R::from_f64(gain),
        };
        match coating {
            _ if !Coating::applies_to([n, after]) => return Self::Bare(interface),
            Coating::Mgf2 => (),
            Coating::Stack(stack) => {
                return Self::Stack(StackModel::new::<R>(stack, interface, [n, after], nm));
            }
            _ => return Self::Bare(interface),
        }
        let per_wave = DESIGN_WAVELENGTH / nm.max(SHORTEST);
        Self::QuarterWave(QuarterWaveLayer {
            interface,
            layer2: R::from_f64(MGF2_INDEX * MGF2_INDEX),
            layer2_step: R::from_f64(MGF2_INDEX * MGF2_INDEX - n2),
            phase: R::from_f64(std::f64::consts::FRAC_PI_2 * per_wave / MGF2_INDEX),
        })
    }

    /// Returns the transmittance by xi^2 = (n cos(theta))^2; NaN for total reflection.
    #[inline(always)]
    pub fn transmittance<R: Real<Scalar = T>>(&self, xi2: R) -> R {
        match self {
            Self::Lossless => R::constant(1.0),
            Self::Bare(interface) => interface.transmittance(xi2),
            Self::QuarterWave(layer) => layer.transmittance(xi2),
            Self::Stack(stack) => stack.transmittance(xi2),
        }
    }

    /// Returns the reflectance by xi^2; 1 for total reflection.
    #[inline(always)]
    pub fn reflectance<R: Real<Scalar = T>>(&self, xi2: R) -> R {
        let through = self.transmittance::<R>(xi2);
        R::select(through.equals(through), R::constant(1.0) - through, R::constant(1.0))
    }
}

impl<T: Copy> BareInterface<T> {
    /// Returns the square roots that refraction takes: xi = n cos(theta) and xi' = n' cos(theta').
    #[inline(always)]
    fn roots<R: Real<Scalar = T>>(&self, xi2: R) -> [R; 2] {
        [xi2.sqrt(), (xi2 + R::splat(self.n2_step)).sqrt()]
    }

    #[inline(always)]
    fn transmittance<R: Real<Scalar = T>>(&self, xi2: R) -> R {
        let [xi, after] = self.roots::<R>(xi2);
        let (n2, after2) = (R::splat(self.n2), R::splat(self.after2));
        let across = xi + after;
        let along = after2.mul_add(xi, n2 * after);
        mean(xi * after, across.square(), along.square(), n2 * after2, R::splat(self.gain))
    }
}

impl<T: Copy> QuarterWaveLayer<T> {
    #[inline(always)]
    fn transmittance<R: Real<Scalar = T>>(&self, xi2: R) -> R {
        let Self { interface, layer2, layer2_step, phase } = self;
        let [xi, after] = interface.roots::<R>(xi2);
        let (n2, after2, layer2) =
            (R::splat(interface.n2), R::splat(interface.after2), R::splat(*layer2));
        let inside = (xi2 + R::splat(*layer2_step)).sqrt();
        let cos = sine(R::constant(std::f64::consts::FRAC_PI_2) - inside * R::splat(*phase));
        let cos2 = cos.square();
        let sin2 = R::constant(1.0) - cos2;
        let (both, n4) = (xi * after, n2 * after2);
        let per_inside = R::constant(1.0) / inside;
        let across = xi + after;
        let across_layer = both.mul_add(per_inside, inside);
        let along = after2.mul_add(xi, n2 * after);
        let along_layer = (n4 / layer2).mul_add(inside, layer2 * both * per_inside);
        let across = across.square().mul_add(cos2, across_layer.square() * sin2);
        let along = along.square().mul_add(cos2, along_layer.square() * sin2);
        mean(both, across, along, n4, R::constant(1.0))
    }
}

/// Returns the mean of 4 xi xi' / across and 4 n^2 n'^2 xi xi' / along, times a gain, at most 1;
/// with both polarisations over one denominator.
#[inline(always)]
fn mean<R: Real>(both: R, across: R, along: R, n4: R, gain: R) -> R {
    let sum = n4.mul_add(across, along);
    let share = R::constant(2.0) * both * sum / (across * along);
    // `min` in this order keeps a NaN.
    R::constant(1.0).min(share * gain)
}

/// Returns the sine of an angle from -pi/2 to pi/2 by its Taylor series, with an error below 6e-8.
#[inline(always)]
fn sine<R: Real>(angle: R) -> R {
    let a2 = angle.square();
    let mut sum = R::constant(-1.0 / 39_916_800.0);
    for term in [1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0] {
        sum = sum.mul_add(a2, R::constant(term));
    }
    sum * angle
}
