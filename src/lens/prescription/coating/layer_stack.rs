//! Stacks of thin films, by the transfer-matrix method.
//!
//! A film of index n1 and thickness d has xi1 = n1 cos(theta1), the phase b = 2 pi (d / wavelength) xi1
//! and the admittance y1 = xi1 for light polarised across the plane of incidence (s), n1^2 / xi1 for
//! light polarised in it (p). It takes the fields (B, C) behind it to those before it:
//!
//! ```text
//! B <- cos(b) B + (i / y1) sin(b) C
//! C <- i y1 sin(b) B + cos(b) C
//! ```
//!
//! From (B, C) = (1, y') in the last medium, T = 4 y y' / |y B + C|^2 (Abeles 1950; Macleod, Thin-Film
//! Optical Filters, 2010, eqs. 2.113 and 2.118). Films absorb nothing.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::{BareInterface, mean};
use petzval_base::lanes::Real;
use petzval_spectrum::Glass;

/// One film of a stack.
#[derive(Clone, Debug, PartialEq)]
pub struct CoatingLayer {
    /// Refractive index at the d line.
    pub index: f64,
    /// Dispersion. Beyond the range of its data, the index is that of the end of the range.
    pub glass: Glass,
    /// Thickness (nm).
    pub thickness: f64,
}

/// A stack of films on glass.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerStack {
    /// The name by which surfaces of a lens file refer to it.
    pub name: Arc<str>,
    /// The films, from air to glass.
    pub layers: Arc<[CoatingLayer]>,
}

impl LayerStack {
    /// Most films of a stack.
    pub const MAX_LAYERS: usize = 100;
    /// Largest thickness of a film (nm). The phase of thicker ones has few digits in f32.
    pub const MAX_THICKNESS: f64 = 20_000.0;
    /// Smallest index of a film: above that of water, so that light which enters the glass also enters
    /// the film.
    pub const MIN_INDEX: f64 = 1.34;
}

/// A stack between two media, ready for a kernel.
#[derive(Clone, Debug, PartialEq)]
pub struct StackModel<T> {
    interface: BareInterface<T>,
    /// The films, from the last that light meets to the first.
    films: Arc<[FilmModel<T>]>,
}

/// A film for one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FilmModel<T> {
    /// n1^2.
    index2: T,
    /// 1 / n1^2.
    per_index2: T,
    /// n1^2 - n^2, with n the index of the medium from which light comes.
    index2_step: T,
    /// Thickness over the wavelength.
    waves: T,
}

/// Smallest xi1^2. Only a film whose index is below that of both media has less.
const MIN_XI2: f64 = 1e-6;

impl<T: Copy> StackModel<T> {
    /// Prepares a stack for light from index `n` to index `after`, at a wavelength (nm). The side of the
    /// lower index is that of the air.
    pub(super) fn new<R: Real<Scalar = T>>(
        stack: &LayerStack,
        interface: BareInterface<T>,
        [n, after]: [f64; 2],
        nm: f64,
    ) -> Self {
        let film = |layer: &CoatingLayer| {
            let index = layer.glass.nearest_index(layer.index, nm);
            FilmModel {
                index2: R::from_f64(index * index),
                per_index2: R::from_f64((index * index).recip()),
                index2_step: R::from_f64(index * index - n * n),
                waves: R::from_f64(layer.thickness / nm),
            }
        };
        let films = match n < after {
            true => stack.layers.iter().rev().map(film).collect(),
            false => stack.layers.iter().map(film).collect(),
        };
        Self { interface, films }
    }

    #[inline(always)]
    pub(super) fn transmittance<R: Real<Scalar = T>>(&self, xi2: R) -> R {
        let [xi, after] = self.interface.roots::<R>(xi2);
        let (n2, after2) = (R::splat(self.interface.n2), R::splat(self.interface.after2));
        let zero = R::constant(0.0);
        let mut across = Fields { b: [R::constant(1.0), zero], c: [after, zero] };
        // Times xi' / n'^2, which may be 0.
        let mut along = Fields { b: [after, zero], c: [after2, zero] };
        for film in &self.films[..] {
            let inside2 = (xi2 + R::splat(film.index2_step)).max(R::constant(MIN_XI2));
            let inside = inside2.sqrt();
            let per_inside = R::constant(1.0) / inside;
            let [sin, cos] = sin_cos(inside * R::splat(film.waves));
            across = across.before(cos, sin * inside, sin * per_inside);
            along = along.before(
                cos,
                sin * R::splat(film.index2) * per_inside,
                sin * R::splat(film.per_index2) * inside,
            );
        }
        let across = across.power(xi, R::constant(1.0));
        let along = along.power(n2, xi);
        mean(xi * after, across, along, n2 * after2, R::constant(1.0))
    }
}

/// Electric and magnetic field along a film, each as real and imaginary part.
struct Fields<R> {
    b: [R; 2],
    c: [R; 2],
}

impl<R: Real> Fields<R> {
    /// Returns the fields before a film, by the cosine of its phase and the sine times and over its
    /// admittance.
    #[inline(always)]
    fn before(&self, cos: R, sin_y: R, sin_per_y: R) -> Self {
        let Self { b, c } = *self;
        Self {
            b: [cos * b[0] - sin_per_y * c[1], cos * b[1] + sin_per_y * c[0]],
            c: [cos * c[0] - sin_y * b[1], cos * c[1] + sin_y * b[0]],
        }
    }

    /// Returns |p B + q C|^2.
    #[inline(always)]
    fn power(&self, p: R, q: R) -> R {
        let part = |i: usize| p.mul_add(self.b[i], q * self.c[i]);
        part(0).square() + part(1).square()
    }
}

/// Returns sine and cosine of an angle in turns, not negative. The series has an error below 1e-13.
#[inline(always)]
fn sin_cos<R: Real>(turns: R) -> [R; 2] {
    // From -1/2 to 1/2.
    let rest = turns - (turns + R::constant(0.5)).floor();
    let size = rest.abs();
    let sin = sine(size.min(R::constant(0.5) - size));
    let sin = R::select(rest.lt(R::constant(0.0)), R::constant(0.0) - sin, sin);
    [sin, sine(R::constant(0.25) - size)]
}

/// Returns the sine of an angle from -1/4 to 1/4 turn by its Taylor series.
#[inline(always)]
fn sine<R: Real>(turns: R) -> R {
    let angle = turns * R::constant(TAU);
    let a2 = angle.square();
    // 1 / 19!, with alternating signs down to 1 / 1!.
    let mut term = -1.0 / 121_645_100_408_832_000.0;
    let mut sum = R::constant(term);
    for power in (1..=9).rev() {
        let power = f64::from(2 * power);
        term *= -power * (power + 1.0);
        sum = sum.mul_add(a2, R::constant(term));
    }
    sum * angle
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::lanes::f32x8;

    #[test]
    fn sines_of_turns_are_those_of_the_library() {
        for i in 0..4000 {
            let turns = f64::from(i) * 0.00537;
            let [sin, cos] = sin_cos::<f64>(turns);
            let (expected_sin, expected_cos) = (TAU * turns).sin_cos();
            assert!((sin - expected_sin).abs() < 1e-12, "{turns}: {sin}");
            assert!((cos - expected_cos).abs() < 1e-12, "{turns}: {cos}");
            let single = sin_cos::<f32>(turns as f32);
            let exact = (TAU * f64::from(turns as f32)).sin_cos();
            assert!((f64::from(single[0]) - exact.0).abs() < 4e-7, "{turns}: {single:?}");
            assert!((f64::from(single[1]) - exact.1).abs() < 4e-7, "{turns}: {single:?}");
            let lanes = sin_cos(<f32x8 as Real>::splat(turns as f32));
            let [mut s, mut c] = [[0.0f32; 8]; 2];
            lanes[0].store(&mut s);
            lanes[1].store(&mut c);
            assert_eq!([s[3], c[5]], single, "one lane and eight differ at {turns} turns");
        }
    }
}
