//! What is known of a group of lights without looking at each: where it is, which way it
//! shines and how strongly, and what it is worth to a point (Conty Estevez & Kulla 2018,
//! "Importance sampling of many lights with adaptive tree splitting").

use glam::Vec3;

use super::cone::Cone;
use crate::lanes::{Real, f32x8};

/// A group of lights, while the tree is built.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Corners of a box around it, world space.
    pub(super) low: Vec3,
    pub(super) high: Vec3,
    /// Where its normals point.
    pub(super) normals: Cone,
    /// Cosine of the angle about a normal up to which it shines.
    pub(super) cos_beyond: f32,
    /// The most that it sends in one direction, W / sr.
    pub(super) intensity: f32,
    /// Whether it shines backwards as well.
    pub(super) two_sided: bool,
}

impl Bounds {
    /// Both groups.
    pub(super) fn with(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            normals: self.normals.with(other.normals),
            cos_beyond: self.cos_beyond.min(other.cos_beyond),
            intensity: self.intensity + other.intensity,
            two_sided: self.two_sided || other.two_sided,
        }
    }

    pub(super) fn middle(&self) -> Vec3 {
        self.low * 0.5 + self.high * 0.5
    }
}

/// Eight groups, compared with each other at once. Missing ones have no intensity.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Groups {
    centre: [[f32; 8]; 3],
    /// Squared, of spheres around them.
    radius2: [f32; 8],
    intensity: [f32; 8],
    /// The axes of their normals, and how far the normals spread about them.
    axis: [[f32; 8]; 3],
    cos_spread: [f32; 8],
    sin_spread: [f32; 8],
    cos_beyond: [f32; 8],
    /// 1 for those that shine backwards as well.
    two_sided: [f32; 8],
    parts: [u32; 8],
    /// Where this one hangs: eight times the place of its parent and which of eight it is.
    pub(super) parent: u32,
}

/// The bit that marks an emitter.
const LEAF: u32 = 1 << 31;
/// Radians that the spread of normals is widened by: more than rounding turns a direction.
const TURN: f32 = 2e-4;
/// The least square of a distance: no importance overflows.
const LEAST: f32 = 1e-30;

/// What a group is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Eight groups, by their place.
    Groups(u32),
    /// One emitter.
    Emitter(u32),
}

impl Groups {
    /// No groups.
    pub(super) const EMPTY: Self = Self {
        centre: [[0.0; 8]; 3],
        radius2: [0.0; 8],
        intensity: [0.0; 8],
        axis: [[0.0; 8]; 3],
        cos_spread: [-1.0; 8],
        sin_spread: [0.0; 8],
        cos_beyond: [0.0; 8],
        two_sided: [0.0; 8],
        parts: [LEAF; 8],
        parent: 0,
    };

    /// Sets one of the eight.
    pub(super) fn set(&mut self, i: usize, bounds: &Bounds, part: Part) {
        let centre = bounds.middle();
        // The middle is rounded: it may be nearer to one corner.
        let reach = (bounds.high - centre).max(centre - bounds.low);
        let spread = (bounds.normals.angle + TURN).min(std::f32::consts::PI);
        for axis in 0..3 {
            self.centre[axis][i] = centre[axis];
            self.axis[axis][i] = bounds.normals.axis[axis];
        }
        self.radius2[i] = reach.length_squared() * (1.0 + 8.0 * f32::EPSILON);
        self.intensity[i] = bounds.intensity;
        (self.sin_spread[i], self.cos_spread[i]) = spread.sin_cos();
        self.cos_beyond[i] = bounds.cos_beyond;
        self.two_sided[i] = if bounds.two_sided { 1.0 } else { 0.0 };
        self.parts[i] = match part {
            Part::Groups(place) => place,
            Part::Emitter(index) => index | LEAF,
        };
    }

    /// What one of the eight is made of.
    pub(super) fn part(&self, i: usize) -> Part {
        match self.parts[i] {
            place if place & LEAF == 0 => Part::Groups(place),
            index => Part::Emitter(index & !LEAF),
        }
    }

    /// Bounds on what they contribute to a point, up to a factor that all groups share: pbrt-v4,
    /// `LightBounds::Importance` without the cosine at the point. Never 0 where they contribute.
    #[inline(always)]
    pub(super) fn importance(&self, p: Vec3) -> [f32; 8] {
        let all = |number: f32| f32x8::splat(number);
        let of = |column: &[f32; 8]| <f32x8 as Real>::load(column);
        let [x, y, z] = [0, 1, 2].map(|axis| all(p[axis]) - of(&self.centre[axis]));
        let [ax, ay, az] = [0, 1, 2].map(|axis| of(&self.axis[axis]));
        let (zero, one) = (all(0.0), all(1.0));
        let (d2, r2) = (x * x + y * y + z * z, of(&self.radius2));
        // What is nearer than its own size is no nearer.
        let value = of(&self.intensity) / Real::max(Real::max(d2, r2), all(LEAST));
        let sine = |cos: f32x8| Real::sqrt(Real::max(one - cos * cos, zero));
        let forward = (ax * x + ay * y + az * z) / Real::sqrt(d2);
        let two_sided = zero.lt(of(&self.two_sided));
        let cos_w = <f32x8 as Real>::select(two_sided, Real::abs(forward), forward);
        let sin_w = sine(cos_w);
        // The angle to the nearest normal, then to the nearest point of the sphere around.
        let (cos_o, sin_o) = (of(&self.cos_spread), of(&self.sin_spread));
        let normal = cos_o.le(cos_w);
        let cos_x = <f32x8 as Real>::select(normal, one, cos_w * cos_o + sin_w * sin_o);
        let sin_x = <f32x8 as Real>::select(normal, zero, sin_w * cos_o - cos_w * sin_o);
        let sin2_b = r2 / d2;
        let (sin_b, cos_b) = (Real::sqrt(sin2_b), Real::sqrt(one - sin2_b));
        let nearest = cos_x * cos_b + sin_x * sin_b;
        let cos = <f32x8 as Real>::select(cos_b.le(cos_x), one, nearest);
        let seen = of(&self.cos_beyond).lt(cos);
        let outside = <f32x8 as Real>::select(seen, value * Real::max(cos, zero), zero);
        let mut importance = [0.0; 8];
        <f32x8 as Real>::select(d2.le(r2), value, outside).store(&mut importance);
        importance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_is_worth_nothing_behind_it_and_something_wherever_it_is_seen() {
        let bounds = Bounds {
            low: Vec3::new(-1.0, -1.0, 0.0),
            high: Vec3::new(1.0, 1.0, 0.0),
            normals: Cone::along(Vec3::Z),
            cos_beyond: 0.0,
            intensity: 1.0,
            two_sided: false,
        };
        let mut groups = Groups::EMPTY;
        groups.set(0, &bounds, Part::Emitter(0));
        groups.set(5, &Bounds { two_sided: true, ..bounds }, Part::Emitter(1));
        let [behind, before] = [-5.0, 5.0].map(|z| groups.importance(Vec3::new(0.0, 0.0, z)));
        assert_eq!(behind[0], 0.0);
        assert_eq!(before[0], 1.0 / 25.0);
        assert_eq!([behind[5], before[5]], [before[0]; 2]);
        assert!(groups.importance(Vec3::new(1e6, 0.0, 1e-3))[0] > 0.0);
        assert_eq!(before[1..5], [0.0; 4]);
    }
}
