//! Node of the light tree: eight light bounds, whose importance is computed at once.

use super::super::reception::Reception;
use super::bounds::LightBounds;
use petzval_base::lanes::vector::{splat, sub};
use petzval_base::lanes::{Real, f32x8};

/// A node of the light tree: the bounds of up to eight children, evaluated at once. Missing
/// children have an intensity of 0.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(in crate::light) struct LightNode {
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
    pub(in crate::light) parent: u32,
    /// Number of children; they come first.
    count: u32,
}

/// Bit that marks an emitter in `children`.
const EMITTER_BIT: u32 = 1 << 31;
/// Widening of the cones [rad]: more than the rounding of a direction.
const CONE_SLACK: f32 = 2e-4;
/// Slack of the cosine at the receiver: more than its rounding.
const RECEIVER_SLACK: f32 = 5e-4;
/// Least squared distance, so that no importance overflows.
const MIN_DISTANCE2: f32 = 1e-30;

/// A child of a light tree's node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::light) enum LightChild {
    /// Index of a node.
    Node(u32),
    /// Index of an emitter.
    Emitter(u32),
}

impl LightNode {
    /// A node without children.
    pub(in crate::light) const EMPTY: Self = Self {
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
        count: 0,
    };

    /// Sets one of the eight children.
    pub(in crate::light) fn set_child(
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
        self.count = self.count.max(i as u32 + 1);
        self.children[i] = match child {
            LightChild::Node(index) => index,
            LightChild::Emitter(index) => index | EMITTER_BIT,
        };
    }

    /// Returns one of the eight children.
    pub(in crate::light) fn child(&self, i: usize) -> LightChild {
        match self.children[i] {
            index if index & EMITTER_BIT == 0 => LightChild::Node(index),
            index => LightChild::Emitter(index & !EMITTER_BIT),
        }
    }

    /// Returns the child of an index in every lane.
    #[inline(always)]
    fn bounds<R: Real<Scalar = f32>>(&self, i: usize) -> ChildBounds<R> {
        let Self { centre, axis, .. } = self;
        ChildBounds {
            centre: splat([centre[0][i], centre[1][i], centre[2][i]]),
            radius2: R::splat(self.radius2[i]),
            intensity: R::splat(self.intensity[i]),
            axis: splat([axis[0][i], axis[1][i], axis[2][i]]),
            cos_spread: R::splat(self.cos_spread[i]),
            sin_spread: R::splat(self.sin_spread[i]),
            cos_emission: R::splat(self.cos_emission[i]),
            two_sided: R::splat(self.two_sided[i]),
        }
    }

    /// Returns the importance of one child for the receivers of a packet.
    #[inline(always)]
    pub(in crate::light) fn importance_of<R: Real<Scalar = f32>>(
        &self,
        i: usize,
        receiver: &Receiver<R>,
    ) -> R {
        self.bounds::<R>(i).importance(receiver)
    }

    /// Returns the importance of every child for one receiver.
    #[inline(always)]
    pub(in crate::light) fn importance(&self, receiver: &Receiver<f32>) -> [f32; 8] {
        let load = |column: &[f32; 8]| <f32x8 as Real>::load(column);
        let [x, y, z] = &self.centre;
        let [ax, ay, az] = &self.axis;
        let children = ChildBounds {
            centre: [load(x), load(y), load(z)],
            radius2: load(&self.radius2),
            intensity: load(&self.intensity),
            axis: [load(ax), load(ay), load(az)],
            cos_spread: load(&self.cos_spread),
            sin_spread: load(&self.sin_spread),
            cos_emission: load(&self.cos_emission),
            two_sided: load(&self.two_sided),
        };
        let mut importance = [0.0; 8];
        children.importance(&receiver.splat()).store(&mut importance);
        importance
    }

    /// Returns the number of children.
    #[inline(always)]
    pub(in crate::light) fn len(&self) -> usize {
        self.count as usize
    }
}

/// Points that receive light, one per lane.
#[derive(Clone, Copy, Debug)]
pub(in crate::light) struct Receiver<R> {
    /// Position.
    pub(in crate::light) position: [R; 3],
    /// How the surface there receives light.
    pub(in crate::light) reception: Reception<R>,
}

impl Receiver<f32> {
    /// Returns the point in every lane.
    #[inline(always)]
    fn splat<R: Real<Scalar = f32>>(&self) -> Receiver<R> {
        Receiver { position: splat(self.position), reception: self.reception.splat() }
    }
}

/// Bounds of a child in every lane, or of all children; see [`LightNode`].
struct ChildBounds<R> {
    centre: [R; 3],
    radius2: R,
    intensity: R,
    axis: [R; 3],
    cos_spread: R,
    sin_spread: R,
    cos_emission: R,
    two_sided: R,
}

impl<R: Real<Scalar = f32>> ChildBounds<R> {
    /// Returns an upper bound on the contribution of the child to a point, up to a common factor
    /// (pbrt-v4, `LightBounds::Importance`). It is 0 only for children that cannot contribute.
    #[inline(always)]
    fn importance(&self, receiver: &Receiver<R>) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let [x, y, z] = sub(receiver.position, self.centre);
        let [ax, ay, az] = self.axis;
        let (d2, r2) = (x * x + y * y + z * z, self.radius2);
        // The distance counts as at least the radius of the bounding sphere.
        let value = self.intensity / d2.max(r2).max(R::splat(MIN_DISTANCE2));
        let inverse = one / d2.sqrt();
        let sine = |cos: R| (one - cos * cos).max(zero).sqrt();
        let forward = (ax * x + ay * y + az * z) * inverse;
        let two_sided = zero.lt(self.two_sided);
        let cos_w = R::select(two_sided, forward.abs(), forward);
        let sin_w = sine(cos_w);
        // Subscripts: w is the angle between the axis and the direction to the point, o the half
        // angle of the normals, x = max(w - o, 0), b the half angle that the sphere subtends, and
        // r the angle between the receiver's normal and the direction to the centre.
        let (cos_o, sin_o) = (self.cos_spread, self.sin_spread);
        let normal = cos_o.le(cos_w);
        let cos_x = R::select(normal, one, cos_w * cos_o + sin_w * sin_o);
        let sin_x = R::select(normal, zero, sin_w * cos_o - cos_w * sin_o);
        let sin2_b = r2 / d2;
        let (sin_b, cos_b) = (sin2_b.sqrt(), (one - sin2_b).sqrt());
        let nearest = cos_x * cos_b + sin_x * sin_b;
        let cos = R::select(cos_b.le(cos_x), one, nearest);
        let seen = self.cos_emission.lt(cos);
        let Reception { facing: [nx, ny, nz], lobe } = receiver.reception;
        let cos_r = -(nx * x + ny * y + nz * z) * inverse;
        let one_sided = zero.lt(nx.abs().max(ny.abs()).max(nz.abs()));
        let brightest = cos_r * cos_b + sine(cos_r) * sin_b + R::splat(RECEIVER_SLACK);
        let received = R::select(cos_b.le(cos_r), one, brightest.max(zero));
        let mut received = R::select(one_sided, received, one);
        let mut within = one;
        if let Some(lobe) = lobe {
            let towards = [x, y, z].map(|d| -d * inverse);
            let glossy = lobe.reflection([nx, ny, nz], towards, cos_r, sin2_b);
            let above = zero.lt(received);
            received = R::select(above, lobe.blend(received, glossy), zero);
            // Lights all around widen the lobe to the whole hemisphere.
            within = lobe.blend(one, R::splat(0.5));
        }
        let outside = R::select(seen, value * cos.max(zero) * received, zero);
        R::select(d2.le(r2), value * within, outside)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::super::reception::GlossyLobe;
    use super::super::cone::Cone;
    use super::*;

    /// A point of a surface that scatters widely.
    fn receiver(position: [f32; 3], facing: [f32; 3]) -> Receiver<f32> {
        Receiver { position, reception: Vec3::from(facing).into() }
    }

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
        let at = |x: f32, z: f32| node.importance(&receiver([x, 0.0, z], [0.0; 3]));
        let [behind, in_front] = [-5.0, 5.0].map(|z| at(0.0, z));
        assert_eq!(behind[0], 0.0);
        assert_eq!(in_front[0], 1.0 / 25.0);
        assert_eq!([behind[5], in_front[5]], [in_front[0]; 2]);
        assert!(at(1e6, 1e-3)[0] > 0.0);
        assert_eq!(in_front[1..5], [0.0; 4]);
        for i in 0..6 {
            let wide = receiver([1.0, 2.0, 3.0], [0.0, 0.6, -0.8]);
            for lobe in [None, GlossyLobe::new([0.0, 0.0, -1.0], 0.01, 0.7)] {
                let mut receiver = wide;
                receiver.reception.lobe = lobe;
                let expected = node.importance(&receiver)[i];
                let lanes = node.importance_of::<f32x8>(i, &receiver.splat());
                assert_eq!(lanes.to_array(), [expected; 8]);
                assert_eq!(node.importance_of::<f32>(i, &receiver), expected);
            }
        }
    }

    #[test]
    fn lights_below_the_horizon_of_a_receiver_have_no_importance() {
        let bounds = LightBounds {
            low: Vec3::new(-1.0, -1.0, 4.0),
            high: Vec3::new(1.0, 1.0, 4.0),
            normals: Cone::ALL,
            cos_emission: 0.0,
            intensity: 1.0,
            two_sided: false,
        };
        let mut node = LightNode::EMPTY;
        node.set_child(0, &bounds, LightChild::Emitter(0));
        let facing = |facing: [f32; 3]| node.importance(&receiver([0.0; 3], facing))[0];
        assert_eq!(facing([0.0, 0.0, -1.0]), 0.0);
        assert_eq!(facing([0.0, 0.0, 1.0]), facing([0.0; 3]));
        // A part of the light is above the horizon.
        assert!(facing([0.8, 0.0, -0.3]) > 0.0);
        assert!(facing([1.0, 0.0, 0.0]) < facing([0.8, 0.0, 0.6]));
    }
}
