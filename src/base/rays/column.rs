//! Columns: one quantity of every ray of a wave.

use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};

use crate::lanes::{Real, pack_order};

/// Largest number of rays in a wave. It is a multiple of the lanes, small enough for the caches,
/// and makes a column an odd number of cache lines: columns of 1024 all begin in the same set of an
/// 8-way L1 cache and evict each other, which made the lens stage twice as slow.
pub const WAVE_SIZE: usize = 1008;

/// One quantity of every ray of a wave.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Column<T, const N: usize = WAVE_SIZE>([T; N]);

/// Largest number of groups into which a stage sorts a wave.
pub const MAX_GROUPS: usize = 16;

/// Entries of a column of sorted rays: every group begins at a whole packet. This is an odd number
/// of cache lines as well, see [`WAVE_SIZE`].
const SORTED_SIZE: usize = WAVE_SIZE + 8 * MAX_GROUPS;

/// One quantity of the rays of a wave, sorted into groups with gaps between them.
pub type SortedColumn<T> = Column<T, SORTED_SIZE>;

impl<T: Zeroable, const N: usize> Default for Column<T, N> {
    fn default() -> Self {
        Self(std::array::from_fn(|_| T::zeroed()))
    }
}

impl<T, const N: usize> Deref for Column<T, N> {
    type Target = [T; N];
    #[inline(always)]
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<T, const N: usize> DerefMut for Column<T, N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl<T, const N: usize> AsRef<[T]> for Column<T, N> {
    #[inline(always)]
    fn as_ref(&self) -> &[T] {
        &self.0
    }
}

impl<T, const N: usize> AsMut<[T]> for Column<T, N> {
    #[inline(always)]
    fn as_mut(&mut self) -> &mut [T] {
        &mut self.0
    }
}

impl<T: Pod, const N: usize> Column<T, N> {
    /// Returns the packets that cover the first `rays` entries; the last one may extend past them.
    #[inline(always)]
    pub fn packets<R: Real<Scalar = T>>(&self, rays: usize) -> &[R] {
        &bytemuck::cast_slice(&self.0[..])[..packet_count::<R>(rays)]
    }

    /// Returns the same packets as [`Column::packets`] for writing.
    #[inline(always)]
    pub fn packets_mut<R: Real<Scalar = T>>(&mut self, rays: usize) -> &mut [R] {
        &mut bytemuck::cast_slice_mut(&mut self.0[..])[..packet_count::<R>(rays)]
    }
}

impl<const N: usize> Column<f32, N> {
    /// Stores the lanes of a set, given as bits, one after the other from an entry on. May write
    /// into the seven entries behind them.
    #[inline(always)]
    pub fn pack<R: Real<Scalar = f32>>(&mut self, first: usize, lanes: u32, from: R) {
        pack(&mut self.0, first, lanes, from);
    }
}

/// Stores the lanes of a set, given as bits, in a column: one after the other from an entry on.
#[inline(always)]
pub(super) fn pack<R: Real<Scalar = f32>>(to: &mut [f32], first: usize, lanes: u32, from: R) {
    let packed = from.permute(pack_order(lanes));
    if first + R::LANES <= to.len() {
        packed.store(&mut to[first..]);
        return;
    }
    let mut values = [0.0; 8];
    packed.store(&mut values);
    let count = lanes.count_ones() as usize;
    to[first..first + count].copy_from_slice(&values[..count]);
}

/// Returns the number of packets that hold this many rays.
#[inline(always)]
pub fn packet_count<R: Real>(rays: usize) -> usize {
    rays.div_ceil(R::LANES)
}
