//! Hits of rays.

use std::ops::{Deref, DerefMut};

use super::WAVE_SIZE;

/// [`Hit::shape`] of a miss, and [`Hit::instance`] of a shape that is not instanced.
pub const NO_INDEX: u32 = u32::MAX;

/// End of a ray: its nearest intersection, or a collision in a medium before.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// Distance in multiples of the direction of the ray.
    pub t: f32,
    /// Barycentric weight of the second vertex of the triangle.
    pub u: f32,
    /// Barycentric weight of the third vertex of the triangle.
    pub v: f32,
    /// Index of the shape in the scene, or [`NO_INDEX`].
    pub shape: u32,
    /// Index of the triangle in the shape.
    pub primitive: u32,
    /// Index of the instance in the scene, or [`NO_INDEX`] for a shape that is not instanced.
    /// Moving instances follow static ones.
    pub instance: u32,
    /// Time as a fraction of the motion; 0 for static shapes.
    pub time: f32,
}

impl Hit {
    /// [`Self::shape`] of a ray that scatters in a medium, whose index is [`Self::primitive`].
    pub const IN_MEDIUM: u32 = NO_INDEX - 1;

    /// End of a ray that a medium absorbs.
    pub const ABSORBED: Self = Self { shape: Self::IN_MEDIUM, ..Self::MISS };

    /// No intersection.
    pub const MISS: Self = Self {
        t: f32::INFINITY,
        u: 0.0,
        v: 0.0,
        shape: NO_INDEX,
        primitive: NO_INDEX,
        instance: NO_INDEX,
        time: 0.0,
    };
}

/// Hits of the rays of a [`RayBatch`](super::RayBatch), in the same order.
#[derive(Clone, Debug)]
pub struct HitBatch(Box<[Hit; WAVE_SIZE]>);

impl Default for HitBatch {
    fn default() -> Self {
        Self(Box::new([Hit::MISS; WAVE_SIZE]))
    }
}

impl Deref for HitBatch {
    type Target = [Hit; WAVE_SIZE];
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for HitBatch {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}
