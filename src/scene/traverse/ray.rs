//! A ray made ready for boxes and triangles.

/// A ray with what its tests share.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::scene) struct Prepared {
    /// Where it starts.
    pub(in crate::scene) origin: [f32; 3],
    /// Where it goes.
    pub(in crate::scene) direction: [f32; 3],
    /// A plane p of an axis is entered at p * near[0] + near[1], and left at p * far[0] + far[1].
    pub(super) near: [[f32; 2]; 3],
    pub(super) far: [[f32; 2]; 3],
    /// 1 where the ray goes down an axis: the index of its near sides.
    pub(super) backward: [usize; 3],
    /// The axes in the order in which the last is the one the ray goes along most.
    pub(super) axes: [usize; 3],
    /// Shear and scale that turn the ray into +z.
    pub(super) shear: [f32; 3],
}

/// The largest inverse of a direction. A slab parallel to the ray is neither entered nor left:
/// its distances are huge, but their products are numbers for all coordinates below 1e18.
const PARALLEL: f32 = 1e20;

/// Rays that start farther out than this, on any axis, meet nothing: their products with
/// [`PARALLEL`] would not be numbers, and boxes that are not there would count as hit.
const FARTHEST: f32 = 1e18;

/// How much later than computed a box may be left: two roundings on either side, of the inverse
/// and of the sum (Ize 2013, "Robust BVH ray traversal").
const LATER: f32 = 1.000_000_5;

/// The share of origin / direction by which boxes are entered sooner and left later: the
/// product is rounded, and the slack that is added to it.
const SOONER: f32 = 2.0 * f32::EPSILON;

impl Prepared {
    /// `None` for a ray that meets nothing: one of numbers that are none, or from too far out.
    #[inline(always)]
    pub(in crate::scene) fn new(origin: [f32; 3], direction: [f32; 3]) -> Option<Self> {
        let sum = direction.iter().fold(0.0, |sum, v| sum + v * 0.0);
        let near = origin.iter().all(|v| v.abs() <= FARTHEST);
        if sum != 0.0 || !near {
            return None;
        }
        let magnitude = direction.map(f32::abs);
        let z = if magnitude[0] > magnitude[1] {
            if magnitude[0] > magnitude[2] { 0 } else { 2 }
        } else if magnitude[1] > magnitude[2] {
            1
        } else {
            2
        };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let scale = 1.0 / direction[z];
        let inverse = direction.map(|d| (1.0 / d).clamp(-PARALLEL, PARALLEL));
        let (mut near, mut far) = ([[0.0; 2]; 3], [[0.0; 2]; 3]);
        for axis in 0..3 {
            let start = origin[axis] * inverse[axis];
            let slack = start.abs() * SOONER;
            near[axis] = [inverse[axis], -(start + slack)];
            far[axis] = [inverse[axis] * LATER, (slack - start) * LATER];
        }
        Some(Self {
            origin,
            direction,
            near,
            far,
            backward: inverse.map(|d| usize::from(d.is_sign_negative())),
            axes,
            shear: [direction[axes[0]] * scale, direction[axes[1]] * scale, scale],
        })
    }

    /// In which of the eight octants it goes.
    #[inline(always)]
    pub(in crate::scene) fn octant(&self) -> usize {
        let [x, y, z] = self.backward;
        x + 2 * y + 4 * z
    }
}
