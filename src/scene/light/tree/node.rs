//! Node of the light tree: eight light bounds, whose importance is computed at once.

use glam::Vec3;

use super::bounds::LightBounds;
use crate::lanes::{Real, f32x8};

/// A node of the light tree: the bounds of up to eight children, evaluated at once. Missing
/// children have an intensity of 0.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(in crate::scene::light) struct LightNode {
    centre: [[f32; 8]; 3],
    /// Squared radii of spheres around the children.
    radius2: [f32; 8],
    intensity: [f32; 8],
    /// Axes of the cones around the normals, then cosines and sines of their half angles.
    axis: [[f32; 8]; 3],
    cos_spread: [f32; 8],
    sin_spread: [f32; 8],
    cos_emission: [f32; 8],
    /// 1 for children that also emit against the normals, otherwise 0.
    two_sided: [f32; 8],
    children: [u32; 8],
    /// Slot of this node: eight times the index of its parent, plus its index among the children.
    pub(in crate::scene::light) parent: u32,
}

/// Bit that marks an emitter in `children`.
const EMITTER_BIT: u32 = 1 << 31;
/// Widening of the cones [rad]: more than the rounding of a direction.
const CONE_SLACK: f32 = 2e-4;
/// Least squared distance, so that no importance overflows.
const MIN_DISTANCE2: f32 = 1e-30;

/// A child of a light tree's node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene::light) enum LightChild {
    /// Index of a node.
    Node(u32),
    /// Index of an emitter.
    Emitter(u32),
}

impl LightNode {
    /// A node without children.
    pub(in crate::scene::light) const EMPTY: Self = Self {
        centre: [[0.0; 8]; 3],
        radius2: [0.0; 8],
        intensity: [0.0; 8],
        axis: [[0.0; 8]; 3],
        cos_spread: [-1.0; 8],
        sin_spread: [0.0; 8],
        cos_emission: [0.0; 8],
        two_sided: [0.0; 8],
        children: [EMITTER_BIT; 8],
        parent: 0,
    };

    /// Sets one of the eight children.
    pub(in crate::scene::light) fn set_child(
        &mut self,
        i: usize,
        bounds: &LightBounds,
        child: LightChild,
    ) {
        let centre = bounds.centre();
        // The centre is rounded, so it may be nearer to one of the corners.
        let reach = (bounds.high - centre).max(centre - bounds.low);
        let spread = (bounds.normals.angle + CONE_SLACK).min(std::f32::consts::PI);
        for axis in 0..3 {
            self.centre[axis][i] = centre[axis];
            self.axis[axis][i] = bounds.normals.axis[axis];
        }
        self.radius2[i] = reach.length_squared() * (1.0 + 8.0 * f32::EPSILON);
        self.intensity[i] = bounds.intensity;
        (self.sin_spread[i], self.cos_spread[i]) = spread.sin_cos();
        self.cos_emission[i] = bounds.cos_emission;
        self.two_sided[i] = if bounds.two_sided { 1.0 } else { 0.0 };
        self.children[i] = match child {
            LightChild::Node(index) => index,
            LightChild::Emitter(index) => index | EMITTER_BIT,
        };
    }

    /// Returns one of the eight children.
    pub(in crate::scene::light) fn child(&self, i: usize) -> LightChild {
        match self.children[i] {
            index if index & EMITTER_BIT == 0 => LightChild::Node(index),
            index => LightChild::Emitter(index & !EMITTER_BIT),
        }
    }

    /// Returns an upper bound on the contribution of each child to a point, up to a common factor
    /// (pbrt-v4, `LightBounds::Importance`, without the cosine at the point). It is 0 only for
    /// children that cannot contribute.
    #[inline(always)]
    pub(in crate::scene::light) fn importance(&self, p: Vec3) -> [f32; 8] {
        let splat = |number: f32| f32x8::splat(number);
        let load = |column: &[f32; 8]| <f32x8 as Real>::load(column);
        let [x, y, z] = [0, 1, 2].map(|axis| splat(p[axis]) - load(&self.centre[axis]));
        let [ax, ay, az] = [0, 1, 2].map(|axis| load(&self.axis[axis]));
        let (zero, one) = (splat(0.0), splat(1.0));
        let (d2, r2) = (x * x + y * y + z * z, load(&self.radius2));
        // The distance counts as at least the radius of the bounding sphere.
        let value = load(&self.intensity) / Real::max(Real::max(d2, r2), splat(MIN_DISTANCE2));
        let sine = |cos: f32x8| Real::sqrt(Real::max(one - cos * cos, zero));
        let forward = (ax * x + ay * y + az * z) / Real::sqrt(d2);
        let two_sided = zero.lt(load(&self.two_sided));
        let cos_w = <f32x8 as Real>::select(two_sided, Real::abs(forward), forward);
        let sin_w = sine(cos_w);
        // Subscripts: w is the angle between the axis and the direction to the point, o the half
        // angle of the normals, x = max(w - o, 0), and b the half angle that the sphere subtends.
        let (cos_o, sin_o) = (load(&self.cos_spread), load(&self.sin_spread));
        let normal = cos_o.le(cos_w);
        let cos_x = <f32x8 as Real>::select(normal, one, cos_w * cos_o + sin_w * sin_o);
        let sin_x = <f32x8 as Real>::select(normal, zero, sin_w * cos_o - cos_w * sin_o);
        let sin2_b = r2 / d2;
        let (sin_b, cos_b) = (Real::sqrt(sin2_b), Real::sqrt(one - sin2_b));
        let nearest = cos_x * cos_b + sin_x * sin_b;
        let cos = <f32x8 as Real>::select(cos_b.le(cos_x), one, nearest);
        let seen = load(&self.cos_emission).lt(cos);
        let outside = <f32x8 as Real>::select(seen, value * Real::max(cos, zero), zero);
        let mut importance = [0.0; 8];
        <f32x8 as Real>::select(d2.le(r2), value, outside).store(&mut importance);
        importance
    }
}

#[cfg(test)]
mod tests {
    use super::super::cone::Cone;
    use super::*;

    #[test]
    fn importance_is_zero_behind_a_one_sided_light_and_positive_in_front() {
        let bounds = LightBounds {
            low: Vec3::new(-1.0, -1.0, 0.0),
            high: Vec3::new(1.0, 1.0, 0.0),
            normals: Cone::from_direction(Vec3::Z),
            cos_emission: 0.0,
            intensity: 1.0,
            two_sided: false,
        };
        let mut node = LightNode::EMPTY;
        node.set_child(0, &bounds, LightChild::Emitter(0));
        node.set_child(5, &LightBounds { two_sided: true, ..bounds }, LightChild::Emitter(1));
        let [behind, in_front] = [-5.0, 5.0].map(|z| node.importance(Vec3::new(0.0, 0.0, z)));
        assert_eq!(behind[0], 0.0);
        assert_eq!(in_front[0], 1.0 / 25.0);
        assert_eq!([behind[5], in_front[5]], [in_front[0]; 2]);
        assert!(node.importance(Vec3::new(1e6, 0.0, 1e-3))[0] > 0.0);
        assert_eq!(in_front[1..5], [0.0; 4]);
    }
}
