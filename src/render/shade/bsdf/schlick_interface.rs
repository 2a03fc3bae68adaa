//! Reflecting interface of microfacets with Schlick's reflectance, and its albedo.

use std::sync::LazyLock;

use super::microfacet::Microfacets;
use petzval_base::lanes::vector::{dot, negate, scale, scale_add, select, z_axis};
use petzval_base::lanes::{Real, f32x8};

/// Entries of the table along the cosine, and along the square root of alpha.
const COSINES: usize = 64;
const ROUGHNESSES: usize = 48;
/// Visible normals of an entry; a multiple of 8.
const NORMALS: usize = 1024;

/// An interface of microfacets, smooth or rough, the same from both sides. It reflects the share
/// F0 + (1 - F0) (1 - cos)^5 of the light (Schlick 1994, eq. 15).
///
/// Its albedo is linear in F0, so that one table of two integrals serves all refractive indices.
#[derive(Clone, Copy, Debug)]
pub(super) struct SchlickInterface<R: Real> {
    facets: Microfacets<R>,
    /// Place in the table along the square root of alpha.
    row: R,
}

/// Reflection from one direction to another, for any F0.
#[derive(Clone, Copy)]
pub(super) struct Reflection<R> {
    /// f |cos wi| over the reflectance.
    factor: R,
    cos: R,
    /// Density of [`SchlickInterface::sample`].
    pub pdf: R,
}

impl<R: Real<Scalar = f32>> Reflection<R> {
    /// Returns f |cos wi| of an interface of this reflectance at normal and at grazing incidence.
    #[inline(always)]
    pub fn value(&self, f0: R, f90: R) -> R {
        self.factor * SchlickInterface::fresnel(self.cos, f0, f90)
    }
}

/// Integrals of G2 / G1 over the visible normals: by itself, and times (1 - cos)^5.
type Integrals = [f32; 2];

struct Table {
    /// By roughness, then by cosine.
    towards: Vec<[Integrals; COSINES]>,
    /// The mean over all directions, weighted by the cosine, by roughness.
    mean: Vec<Integrals>,
}

static TABLE: LazyLock<Table> = LazyLock::new(Table::new);

impl Table {
    fn new() -> Self {
        let towards: Vec<[Integrals; COSINES]> = (0..ROUGHNESSES)
            .map(|row| {
                let alpha = (row as f32 / (ROUGHNESSES - 1) as f32).powi(2);
                std::array::from_fn(|column| integrals(alpha, column as f32 / (COSINES - 1) as f32))
            })
            .collect();
        let mean = towards.iter().map(|row| [0, 1].map(|part| mean(row, part))).collect();
        Self { towards, mean }
    }
}

/// Returns the mean of a piecewise linear function of the cosine, weighted by twice the cosine.
fn mean(row: &[Integrals; COSINES], part: usize) -> f32 {
    let step = 1.0 / (COSINES - 1) as f32;
    let piece = |(i, pair): (usize, &[Integrals])| {
        let [low, high] = [pair[0][part], pair[1][part]];
        let start = i as f32 * step;
        // The integral of 2 c (low + (high - low) (c - start) / step) over the step.
        step * (start * (low + high) + step * (low + 2.0 * high) / 3.0)
    };
    row.windows(2).enumerate().map(piece).sum()
}

fn integrals(alpha: f32, cos: f32) -> Integrals {
    // The limit of grazing light.
    let cos = cos.max(1e-4);
    if Microfacets::new([alpha; 2]).smooth {
        return [1.0, (1.0 - cos).powi(5)];
    }
    let facets = Microfacets::new([f32x8::splat(alpha); 2]);
    let wo = [(1.0 - cos * cos).sqrt(), 0.0, cos].map(f32x8::splat);
    let (zero, one) = (f32x8::splat(0.0), f32x8::splat(1.0));
    let o = facets.stretch(wo);
    let mut sums = [zero; 2];
    // A low-discrepancy sequence (Roberts 2018, "The unreasonable effectiveness of quasirandom
    // sequences"), because reflections below the horizon cut the integrand off.
    let numbers = |first: usize, step: f64| {
        let number = |i: usize| (((first + i) as f64 + 0.5) * step).fract() as f32;
        f32x8::load(&std::array::from_fn::<f32, 8, _>(number))
    };
    for first in (0..NORMALS).step_by(8) {
        let u = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2].map(|step| numbers(first, step));
        let m = facets.sample_visible_normal(wo, u);
        let along = dot(wo, m);
        let wi = scale_add(m, f32x8::splat(2.0) * along, negate(wo));
        let unshadowed =
            Microfacets::g_over_cos(o, facets.stretch(wi)) / Microfacets::g1_over_cos(o);
        let passes = f32x8::select(zero.lt(wi[2]), unshadowed, zero);
        let away = (one - along).max(zero);
        sums[0] += passes;
        sums[1] += passes * away.square().square() * away;
    }
    sums.map(|sum| sum.to_array().iter().sum::<f32>() / NORMALS as f32)
}

/// Returns the entry of a column at a place, by linear interpolation, as the two entries and the
/// weight of the second.
fn between(at: f32, entries: usize) -> (usize, f32) {
    let low = (at as usize).min(entries - 2);
    (low, (at - low as f32).clamp(0.0, 1.0))
}

fn blend(a: Integrals, b: Integrals, weight: f32) -> Integrals {
    [0, 1].map(|i| a[i] + (b[i] - a[i]) * weight)
}

impl<R: Real<Scalar = f32>> SchlickInterface<R> {
    /// An interface of roughness `alpha`.
    #[inline(always)]
    pub fn new(alpha: R) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let row = alpha.max(zero).min(one).sqrt() * R::splat((ROUGHNESSES - 1) as f32);
        Self { facets: Microfacets::new([alpha; 2]), row }
    }

    /// Returns the lanes in which the interface counts as smooth.
    #[inline(always)]
    pub fn smooth(&self) -> R::Mask {
        self.facets.smooth
    }

    /// Returns the share of light that is reflected, given its share at normal and at grazing
    /// incidence.
    #[inline(always)]
    pub fn fresnel(cos: R, f0: R, f90: R) -> R {
        let one = R::splat(1.0);
        let away = (one - cos).max(R::splat(0.0));
        let fifth = away.square().square() * away;
        (f90 - f0).mul_add(fifth, f0)
    }

    /// Returns the reflection from `wi` to `wo`; 0 for a smooth interface.
    #[inline(always)]
    pub fn reflection(&self, wo: [R; 3], wi: [R; 3]) -> Reflection<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let half = scale_add(wi, one, wo);
        let length2 = dot(half, half);
        let rough = zero.lt(wo[2] * wi[2]) & zero.lt(length2) & !self.facets.smooth;
        let m = scale(half, one / R::select(rough, length2, one).sqrt());
        let (o, i) = (self.facets.stretch(wo), self.facets.stretch(wi));
        let quarter = self.facets.distribution(m) * R::splat(0.25);
        Reflection {
            factor: R::select(rough, quarter * Microfacets::g_over_cos(o, i), zero),
            cos: dot(wo, m).abs(),
            pdf: R::select(rough, quarter * Microfacets::g1_over_cos(o), zero),
        }
    }

    /// Samples a reflected direction, which may point into the surface.
    #[inline(always)]
    pub fn sample(&self, wo: [R; 3], u: [R; 2]) -> [R; 3] {
        let m = self.facets.sample_visible_normal(wo, u);
        let m = select(self.facets.smooth, z_axis(), m);
        scale_add(m, R::splat(2.0) * dot(wo, m), negate(wo))
    }

    /// Returns the share that is reflected of the light from a direction, given its cosine.
    #[inline(always)]
    pub fn albedo(&self, cos: R, f0: R) -> R {
        let column = cos.min(R::splat(1.0)) * R::splat((COSINES - 1) as f32);
        self.look_up(column, f0, |row, column| {
            let (low, weight) = between(column, COSINES);
            let columns = &TABLE.towards[row];
            blend(columns[low], columns[low + 1], weight)
        })
    }

    /// Returns the mean of the albedo over all directions.
    #[inline(always)]
    pub fn mean_albedo(&self, f0: R) -> R {
        self.look_up(self.row, f0, |row, _| TABLE.mean[row])
    }

    /// Interpolates between the rows of a table, lane by lane.
    #[inline(always)]
    fn look_up(&self, column: R, f0: R, entry: impl Fn(usize, f32) -> Integrals) -> R {
        let (mut rows, mut columns, mut shares) = ([0.0; 8], [0.0; 8], [0.0; 8]);
        self.row.store(&mut rows);
        column.store(&mut columns);
        f0.store(&mut shares);
        let mut albedo = [0.0; 8];
        for lane in 0..R::LANES {
            let (low, weight) = between(rows[lane], ROUGHNESSES);
            let [whole, grazing] =
                blend(entry(low, columns[lane]), entry(low + 1, columns[lane]), weight);
            albedo[lane] = (whole - grazing).mul_add(shares[lane], grazing).min(0.999);
        }
        R::load(&albedo)
    }
}
