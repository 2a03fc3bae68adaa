//! What is known of a group of lights without looking at each: where it is, which way it
//! shines and how strongly, and what it is worth to a point (Conty Estevez & Kulla 2018,
//! "Importance sampling of many lights with adaptive tree splitting").

use glam::Vec3;

use super::cone::Cone;

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

/// A group in 32 bytes: half a cache line, for it is always compared with its sibling.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(super) struct Group {
    centre: [f32; 3],
    /// Of a sphere around it.
    radius: f32,
    intensity: f32,
    /// The axis of its normals on an octahedron (Meyer et al. 2010).
    axis: [i16; 2],
    /// Cosines of the spread of the normals and of the angle beyond, rounded to the wider side.
    cosines: [i16; 2],
    /// A pair or, with [`LEAF`], an emitter; with [`TWO_SIDED`] it shines backwards as well.
    code: u32,
}

const LEAF: u32 = 1 << 31;
const TWO_SIDED: u32 = 1 << 30;
/// The step of the numbers from -1 to 1 in 16 bits.
const STEP: f32 = 1.0 / 32767.0;
/// Radians that the spread is widened by: more than the axis may turn by rounding.
const TURN: f32 = 2e-4;
/// The least square of a distance: no importance overflows.
const LEAST: f32 = 1e-30;

/// What a group is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Two groups, by their place.
    Pair(u32),
    /// One emitter.
    Emitter(u32),
}

impl Group {
    pub(super) fn new(bounds: &Bounds, part: Part) -> Self {
        let code = match part {
            Part::Pair(i) => i,
            Part::Emitter(i) => i | LEAF,
        };
        let centre = bounds.middle();
        // The middle is rounded: it may be nearer to one corner.
        let reach = (bounds.high - centre).max(centre - bounds.low);
        let radius = reach.length() * (1.0 + 4.0 * f32::EPSILON);
        let down = |cos: f32| (cos / STEP).floor().clamp(-32767.0, 32767.0) as i16;
        let spread = (bounds.normals.angle + TURN).min(std::f32::consts::PI);
        Self {
            centre: centre.to_array(),
            radius,
            intensity: bounds.intensity,
            axis: octahedron(bounds.normals.axis),
            cosines: [down(spread.cos()), down(bounds.cos_beyond)],
            code: code | if bounds.two_sided { TWO_SIDED } else { 0 },
        }
    }

    #[inline(always)]
    pub(super) fn part(&self) -> Part {
        let place = self.code & !(LEAF | TWO_SIDED);
        if self.code & LEAF == 0 { Part::Pair(place) } else { Part::Emitter(place) }
    }

    /// A bound on what it contributes to a point, up to a factor that all groups share: pbrt-v4,
    /// `LightBounds::Importance` without the cosine at the point. Never 0 where it contributes.
    #[inline(always)]
    pub(super) fn importance(&self, p: Vec3) -> f32 {
        let v = p - Vec3::from(self.centre);
        let (d2, r2) = (v.length_squared(), self.radius * self.radius);
        // What is nearer than its own size is no nearer.
        let value = self.intensity / d2.max(r2).max(LEAST);
        if d2 <= r2 {
            return value;
        }
        let axis = direction(self.axis);
        let [cos_o, cos_e] = self.cosines.map(|c| f32::from(c) * STEP);
        let mut cos_w = axis.dot(v) / (axis.length_squared() * d2).sqrt();
        if self.code & TWO_SIDED != 0 {
            cos_w = cos_w.abs();
        }
        let sin = |cos: f32| (1.0 - cos * cos).max(0.0).sqrt();
        // The angle to the nearest normal, then to the nearest point of the sphere around it.
        let (mut cos, mut sin_x) = (1.0, 0.0);
        if cos_w < cos_o {
            let (sin_w, sin_o) = (sin(cos_w), sin(cos_o));
            (cos, sin_x) = (cos_w * cos_o + sin_w * sin_o, sin_w * cos_o - cos_w * sin_o);
        }
        let sin2_b = r2 / d2;
        let cos_b = (1.0 - sin2_b).sqrt();
        cos = if cos >= cos_b { 1.0 } else { cos * cos_b + sin_x * sin2_b.sqrt() };
        if cos > cos_e { value * cos.max(0.0) } else { 0.0 }
    }
}

/// A unit vector on the octahedron, unfolded to a square.
fn octahedron(axis: Vec3) -> [i16; 2] {
    let v = axis / axis.abs().element_sum();
    let fold = |a: f32, b: f32| if v.z < 0.0 { (1.0 - b.abs()).copysign(a) } else { a };
    [fold(v.x, v.y), fold(v.y, v.x)].map(|c| (c / STEP).round() as i16)
}

/// The vector, not of unit length, of a point of the octahedron.
#[inline(always)]
fn direction(octahedron: [i16; 2]) -> Vec3 {
    let [x, y] = octahedron.map(|c| f32::from(c) * STEP);
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    Vec3::new(x - fold.copysign(x), y - fold.copysign(y), z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rounded_axis_turns_less_than_the_spread_is_widened() {
        for i in 0..100_000u32 {
            let z = 1.0 - (i as f32 + 0.5) / 50_000.0;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let axis = Vec3::new(r * cos, r * sin, z).normalize();
            let back = direction(octahedron(axis)).normalize();
            assert!(back.cross(axis).length() < TURN, "{axis} became {back}");
            assert!(back.dot(axis) > 0.0);
        }
    }

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
        let group = Group::new(&bounds, Part::Emitter(0));
        assert_eq!(group.importance(Vec3::new(0.0, 0.0, -5.0)), 0.0);
        assert!(group.importance(Vec3::new(1e6, 0.0, 1e-3)) > 0.0);
        let both = Group::new(&Bounds { two_sided: true, ..bounds }, Part::Emitter(0));
        assert_eq!(
            both.importance(Vec3::new(0.0, 0.0, -5.0)),
            both.importance(Vec3::new(0.0, 0.0, 5.0))
        );
    }
}
