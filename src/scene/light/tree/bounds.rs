//! Light bounds: position, emission cone and intensity of a group of lights (Conty Estevez & Kulla
//! 2018, "Importance sampling of many lights with adaptive tree splitting").

use glam::Vec3;

use super::cone::Cone;

/// Bounds of one light or of a group of lights, from which the tree is built.
#[derive(Clone, Copy, Debug)]
pub(in crate::light) struct LightBounds {
    /// Lowest and highest corner of a box around the lights, world space.
    pub(in crate::light) low: Vec3,
    pub(in crate::light) high: Vec3,
    /// Cone around the normals.
    pub(in crate::light) normals: Cone,
    /// Cosine of the largest angle from a normal at which light is emitted.
    pub(in crate::light) cos_emission: f32,
    /// Largest intensity in any direction [W/sr].
    pub(in crate::light) intensity: f32,
    /// Whether light is also emitted against the normals.
    pub(in crate::light) two_sided: bool,
}

impl LightBounds {
    /// Returns the bounds of both groups together.
    pub(in crate::light) fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            normals: self.normals.union(other.normals),
            cos_emission: self.cos_emission.min(other.cos_emission),
            intensity: self.intensity + other.intensity,
            two_sided: self.two_sided || other.two_sided,
        }
    }

    /// Returns the centre of the box.
    pub(in crate::light) fn centre(&self) -> Vec3 {
        self.low * 0.5 + self.high * 0.5
    }
}
