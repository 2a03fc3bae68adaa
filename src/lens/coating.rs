//! Coatings, and what a surface lets through: the share of unpolarised light, by angle.
//!
//! With n and n' the indices on both sides, xi = n cos(theta), xi' = n' cos(theta') and the
//! admittances y = xi for light that swings across the plane of incidence and y = n^2 / xi for
//! light that swings in it:
//!
//! ```text
//! bare     T = 4 y y' / (y + y')^2                                           (Fresnel 1823)
//! a layer  T = 4 y y' / ((y + y')^2 cos^2 b + (y y' / y1 + y1)^2 sin^2 b)
//!          b = (pi / 2) (tuned / wavelength) cos(theta1) for a quarter wave
//! ```
//!
//! (Born & Wolf, Principles of Optics, 1999, eqs. 1.5.21 and 1.6.57; Macleod, Thin-Film Optical
//! Filters, 2010, sec. 2.6). Only square roots that refraction takes anyway, and no difference of
//! like numbers. Unpolarised is the mean of both; that a lens polarises light a little from
//! surface to surface is left out. Both directions of a surface have the same T.

use crate::lanes::Real;

/// What a surface is coated with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coating {
    /// Nothing: bare glass.
    #[default]
    Bare,
    /// A quarter wave of magnesium fluoride, n = [`MGF2`], tuned to [`TUNED`] at normal incidence.
    Mgf2,
    /// An ideal coat of many layers for all wavelengths: it reflects [`BROADBAND`] at normal
    /// incidence and all at grazing, between them by bare glass's own rise: R = R0 + (1 - R0) F
    /// with F = (R_bare - R_bare0) / (1 - R_bare0), the form of Schlick 1994, eq. 15. It is our
    /// model, not a product's: those differ.
    Broadband,
    /// What does not exist: nothing is lost.
    Perfect,
}

/// Index of a layer of magnesium fluoride, near 550 nm (Dodge 1984, ordinary ray, rounded).
pub const MGF2: f64 = 1.38;
/// The wavelength that the layer is a quarter of, nm.
pub const TUNED: f64 = 550.0;
/// What the ideal broadband coating reflects at normal incidence.
pub const BROADBAND: f64 = 0.0025;
/// The shortest wavelength, nm, at which a layer's phase stays inside the series for its cosine.
const SHORTEST: f64 = TUNED / 2.0;

impl Coating {
    /// What files and the command line call them.
    pub const NAMES: [&str; 4] = ["none", "mgf2", "broadband", "perfect"];

    /// The coating of a name in capitals or not.
    pub fn named(name: &str) -> Option<Self> {
        let place = Self::NAMES.iter().position(|known| known.eq_ignore_ascii_case(name))?;
        Some([Self::Bare, Self::Mgf2, Self::Broadband, Self::Perfect][place])
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Whether a layer belongs between two media: only where one of them is thinner than the
    /// layer, as air is. Cemented faces have none.
    pub fn fits([n, after]: [f64; 2]) -> bool {
        n != after && n.min(after) < MGF2
    }

    /// The share of unpolarised light of a wavelength, nm, that gets from an index to the next
    /// at an angle to the normal, by its cosine before the surface; 0 where reflection is total.
    pub fn transmittance(self, indices: [f64; 2], cos: f64, nm: f64) -> f64 {
        let xi2 = (indices[0] * cos).powi(2);
        if xi2 + (indices[1].powi(2) - indices[0].powi(2)) <= 0.0 {
            return 0.0;
        }
        Coat::new::<f64>(self, indices, nm).transmittance::<f64>(xi2)
    }
}

/// The coating of one surface, ready for a kernel. Indices are on the sides that rays come from
/// and go to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coat<T> {
    /// Nothing is lost.
    Clear,
    /// Bare glass, or what follows it.
    Face(Face<T>),
    /// One thin layer.
    Layer(Layer<T>),
}

/// A border between two media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face<T> {
    /// n^2, n'^2, and their difference.
    n2: T,
    after2: T,
    n2_step: T,
    /// What comes through at normal incidence, over what bare glass lets through there.
    gain: T,
}

/// A quarter-wave layer between two media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer<T> {
    face: Face<T>,
    /// n1^2 and n1^2 - n^2.
    layer2: T,
    layer2_step: T,
    /// Phase over n1 cos(theta1).
    phase: T,
}

impl<T: Copy> Coat<T> {
    /// A coating between two indices, for light of one wavelength, nm: exact to 1e-6 from
    /// 275 to 2000.
    pub fn new<R: Real<Scalar = T>>(coating: Coating, [n, after]: [f64; 2], nm: f64) -> Self {
        if n == after || coating == Coating::Perfect {
            return Self::Clear;
        }
        let bare = 4.0 * n * after / (n + after).powi(2);
        let gain = match coating {
            Coating::Broadband if Coating::fits([n, after]) => (1.0 - BROADBAND).max(bare) / bare,
            _ => 1.0,
        };
        let (n2, after2) = (n * n, after * after);
        let face = Face {
            n2: R::scalar(n2),
            after2: R::scalar(after2),
            n2_step: R::scalar(after2 - n2),
            gain: R::scalar(gain),
        };
        if coating != Coating::Mgf2 || !Coating::fits([n, after]) {
            return Self::Face(face);
        }
        let per_wave = TUNED / nm.max(SHORTEST);
        Self::Layer(Layer {
            face,
            layer2: R::scalar(MGF2 * MGF2),
            layer2_step: R::scalar(MGF2 * MGF2 - n2),
            phase: R::scalar(std::f64::consts::FRAC_PI_2 * per_wave / MGF2),
        })
    }

    /// The share that comes through, by (n cos(theta))^2; not a number where reflection is total.
    #[inline(always)]
    pub fn transmittance<R: Real<Scalar = T>>(&self, xi2: R) -> R {
        match self {
            Self::Clear => R::constant(1.0),
            Self::Face(face) => face.transmittance(xi2),
            Self::Layer(layer) => layer.transmittance(xi2),
        }
    }
}

impl<T: Copy> Coat<T> {
    /// The share that is reflected; all of it where no light can go on.
    #[inline(always)]
    pub fn reflectance<R: Real<Scalar = T>>(&self, xi2: R) -> R {
        let through = self.transmittance::<R>(xi2);
        R::select(through.same(through), R::constant(1.0) - through, R::constant(1.0))
    }
}

impl<T: Copy> Face<T> {
    /// The square roots that refraction takes: n cos(theta) and n' cos(theta').
    #[inline(always)]
    fn roots<R: Real<Scalar = T>>(&self, xi2: R) -> [R; 2] {
        [xi2.sqrt(), (xi2 + R::splat(self.n2_step)).sqrt()]
    }

    /// Both polarisations over one denominator.
    #[inline(always)]
    fn transmittance<R: Real<Scalar = T>>(&self, xi2: R) -> R {
        let [xi, after] = self.roots::<R>(xi2);
        let (n2, after2) = (R::splat(self.n2), R::splat(self.after2));
        let across = xi + after;
        let along = after2.mul_add(xi, n2 * after);
        mean(xi * after, across.square(), along.square(), n2 * after2, R::splat(self.gain))
    }
}

impl<T: Copy> Layer<T> {
    #[inline(always)]
    fn transmittance<R: Real<Scalar = T>>(&self, xi2: R) -> R {
        let Self { face, layer2, layer2_step, phase } = self;
        let [xi, after] = face.roots::<R>(xi2);
        let (n2, after2, layer2) = (R::splat(face.n2), R::splat(face.after2), R::splat(*layer2));
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

/// The mean of 4 xi xi' / across and 4 n^2 n'^2 xi xi' / along, times a factor; not over 1.
#[inline(always)]
fn mean<R: Real>(both: R, across: R, along: R, n4: R, gain: R) -> R {
    let sum = n4.mul_add(across, along);
    let share = R::constant(2.0) * both * sum / (across * along);
    // In this order what is no number stays none.
    R::constant(1.0).min(share * gain)
}

/// The sine of an angle of at most a right one: Taylor's series, off by less than 6e-8.
#[inline(always)]
fn sine<R: Real>(angle: R) -> R {
    let a2 = angle.square();
    let mut sum = R::constant(-1.0 / 39_916_800.0);
    for term in [1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0] {
        sum = sum.mul_add(a2, R::constant(term));
    }
    sum * angle
}
