//! Flags of a path: what it has met before its present ray.

use std::ops::{BitAnd, BitOr};

use bytemuck::{Pod, Zeroable, cast_slice, cast_slice_mut};

use super::Column;
use super::column::pack;
use crate::lanes::{Real, Word};

/// Flags of a path at a ray that left a surface or a medium, or of the paths of a packet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct PathFlags<W = u32>(W);

impl PathFlags {
    /// No flag.
    pub const NONE: Self = Self(0);
    /// No other technique could have sampled the direction of the ray, and it has no density: a mirror,
    /// clear glass or an interface sent it on, or it has walked through the medium below a surface.
    /// Light that it finds has the weight 1.
    pub const SPECULAR: Self = Self(1);
    /// The path has met a surface or a medium that scatters other than a mirror or clear glass does.
    pub const SCATTERED: Self = Self(2);
    /// The first surface of the path receives the caustics that light paths find.
    pub const FROM_RECEIVER: Self = Self(4);
    /// The path has met glass that disperses, and goes on with one wavelength.
    pub const ONE_WAVELENGTH: Self = Self(8);
    /// The flags that a path keeps from ray to ray.
    pub const INHERITED: Self =
        Self(Self::SCATTERED.0 | Self::FROM_RECEIVER.0 | Self::ONE_WAVELENGTH.0);

    /// Returns whether all these flags are set.
    #[inline(always)]
    pub const fn contains(self, flags: Self) -> bool {
        self.0 & flags.0 == flags.0
    }
}

impl<W: Word> PathFlags<W> {
    /// Returns the same flags in every lane.
    #[inline(always)]
    pub fn splat(flags: PathFlags) -> Self {
        Self(W::splat(flags.0))
    }

    /// Returns `yes` in the lanes of a mask, and `no` elsewhere.
    #[inline(always)]
    pub fn select<R: Real<Word = W>>(mask: R::Mask, yes: PathFlags, no: PathFlags) -> Self {
        let [yes, no] = [yes, no].map(|flags| R::from_word(W::splat(flags.0)));
        Self(R::select(mask, yes, no).to_word())
    }

    /// Loads the first flags of a slice, as many as there are lanes.
    #[inline(always)]
    pub fn load(from: &[PathFlags]) -> Self {
        Self(W::load(cast_slice(from)))
    }

    /// Stores the flags in the first entries of a slice, as many as there are lanes.
    #[inline(always)]
    pub fn store(self, to: &mut [PathFlags]) {
        self.0.store(cast_slice_mut(to));
    }
}

impl<W: BitAnd<Output = W>> BitAnd for PathFlags<W> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl<W: BitOr<Output = W>> BitOr for PathFlags<W> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl<const N: usize> Column<PathFlags, N> {
    /// Stores the lanes of a set as [`Column::pack`] of numbers does.
    #[inline(always)]
    pub fn pack_flags<R: Real<Scalar = f32>>(
        &mut self,
        first: usize,
        lanes: u32,
        from: PathFlags<R::Word>,
    ) {
        let column: &mut [f32] = cast_slice_mut(&mut self[..]);
        pack(column, first, lanes, R::from_word(from.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::f32x8;
    use crate::rays::WAVE_SIZE;

    #[test]
    fn flags_of_a_packet_are_those_of_its_lanes() {
        let values = [0.0, 2.0, 1.0, 3.0, 0.0, 9.0, 1.0, 1.5];
        let mask = <f32x8 as Real>::load(&values).lt(<f32x8 as Real>::splat(1.25));
        let (yes, no) = (PathFlags::SPECULAR, PathFlags::SCATTERED);
        let after = PathFlags::splat(PathFlags::FROM_RECEIVER);
        let packet = PathFlags::select::<f32x8>(mask, yes, no) | after;
        let mut stored = [PathFlags::NONE; 8];
        packet.store(&mut stored);
        let expected = values.map(|v| if v < 1.25 { yes } else { no } | PathFlags::FROM_RECEIVER);
        assert_eq!(stored, expected);
        let kept = PathFlags::load(&stored) & PathFlags::splat(PathFlags::SCATTERED);
        let mut column = Column::<PathFlags>::default();
        for first in [3, WAVE_SIZE - 3] {
            column.pack_flags::<f32x8>(first, 0b1000_0110, kept);
            let packed = [1, 2, 7].map(|lane| expected[lane] & PathFlags::SCATTERED);
            assert_eq!(column[first..first + 3], packed);
        }
    }

    #[test]
    fn flags_contain_their_parts_only() {
        let both = PathFlags::SPECULAR | PathFlags::FROM_RECEIVER;
        assert!(both.contains(PathFlags::SPECULAR) && both.contains(both));
        assert!(!both.contains(PathFlags::SCATTERED) && !PathFlags::SPECULAR.contains(both));
    }
}
