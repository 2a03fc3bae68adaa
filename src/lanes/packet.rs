//! Eight lanes of `f32`. This is the only file that uses operations of the `wide` crate.

use wide::{f32x8, u32x8};

use super::Real;

impl Real for f32x8 {
    type Scalar = f32;
    type Mask = f32x8;
    const LANES: usize = 8;
    const EPSILON: f64 = f32::EPSILON as f64 / 2.0;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        f32x8::splat(value)
    }
    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        let mut lanes = [0.0; 8];
        lanes.copy_from_slice(&from[..8]);
        f32x8::new(lanes)
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        to[..8].copy_from_slice(&self.to_array());
    }
    #[inline(always)]
    fn permute(self, order: &[u32; 8]) -> Self {
        bytemuck::cast(bytemuck::cast::<Self, u32x8>(self).shuffle(u32x8::new(*order)))
    }
    #[inline(always)]
    fn transpose(rows: &[[f32; 8]]) -> [Self; 8] {
        let mut packets = [f32x8::ZERO; 8];
        for (packet, row) in packets.iter_mut().zip(&rows[..8]) {
            *packet = f32x8::new(*row);
        }
        f32x8::transpose(packets)
    }
    #[inline(always)]
    fn from_f64(value: f64) -> f32 {
        value as f32
    }
    #[inline(always)]
    fn to_f64(value: f32) -> f64 {
        f64::from(value)
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        if cfg!(target_feature = "fma") {
            f32x8::mul_add(self, factor, term)
        } else {
            self * factor + term
        }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32x8::sqrt(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.fast_min(other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.fast_max(other)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32x8::abs(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self {
        self.simd_lt(other)
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self {
        self.simd_le(other)
    }
    #[inline(always)]
    fn equals(self, other: Self) -> Self {
        self.simd_eq(other)
    }
    #[inline(always)]
    fn select(mask: Self, yes: Self, no: Self) -> Self {
        wide::f32x8::select(mask, yes, no)
    }
    #[inline(always)]
    fn bits(mask: Self) -> u32 {
        mask.to_bitmask()
    }
}
