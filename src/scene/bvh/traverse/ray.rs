//! Ray with the precomputed terms of its box and triangle tests.

/// A ray with the terms that its box and triangle tests share.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::scene) struct TraversalRay {
    /// Origin.
    pub(in crate::scene) origin: [f32; 3],
    /// Direction, of any length.
    pub(in crate::scene) direction: [f32; 3],
    /// By axis: the ray enters the slab side at coordinate p at distance p * entry[0] + entry[1],
    /// and leaves it at p * exit[0] + exit[1].
    pub(super) entry: [[f32; 2]; 3],
    pub(super) exit: [[f32; 2]; 3],
    /// 1 if the direction is negative on an axis: the index of the near sides of boxes.
    pub(super) backward: [usize; 3],
    /// Axes, rotated so that the largest component of the direction comes last.
    pub(super) axes: [usize; 3],
    /// Shear in x and y, and scale of z, that map the direction to +z.
    pub(super) shear: [f32; 3],
}

/// Largest inverse of a component of the direction. The distances to a slab parallel to the ray are
/// huge, but finite for all coordinates below 1e18.
const MAX_INVERSE: f32 = 1e20;

/// Largest coordinate of an origin. Rays that start farther out hit nothing: their products with
/// [`MAX_INVERSE`] would overflow, and missing boxes would count as hit.
const MAX_ORIGIN: f32 = 1e18;

/// Factor of the exit distances: covers two roundings on either side, of the inverse and of the
/// sum (Ize 2013, "Robust BVH ray traversal").
const EXIT_FACTOR: f32 = 1.000_000_5;

/// Slack of entry and exit distances relative to origin / direction: covers the rounding of this
/// product and of the slack's sum with it.
const ENTRY_SLACK: f32 = 2.0 * f32::EPSILON;

impl TraversalRay {
    /// Prepares a ray. Returns `None` if the ray can hit nothing, because a number is not finite or
    /// its origin is farther out than [`MAX_ORIGIN`].
    #[inline(always)]
    pub(in crate::scene) fn new(origin: [f32; 3], direction: [f32; 3]) -> Option<Self> {
        let sum = direction.iter().fold(0.0, |sum, v| sum + v * 0.0);
        let in_range = origin.iter().all(|v| v.abs() <= MAX_ORIGIN);
        if sum != 0.0 || !in_range {
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
        let inverse = direction.map(|d| (1.0 / d).clamp(-MAX_INVERSE, MAX_INVERSE));
        let (mut near, mut far) = ([[0.0; 2]; 3], [[0.0; 2]; 3]);
        for axis in 0..3 {
            let start = origin[axis] * inverse[axis];
            let slack = start.abs() * ENTRY_SLACK;
            near[axis] = [inverse[axis], -(start + slack)];
            far[axis] = [inverse[axis] * EXIT_FACTOR, (slack - start) * EXIT_FACTOR];
        }
        Some(Self {
            origin,
            direction,
            entry: near,
            exit: far,
            backward: inverse.map(|d| usize::from(d.is_sign_negative())),
            axes,
            shear: [direction[axes[0]] * scale, direction[axes[1]] * scale, scale],
        })
    }

    /// Returns the octant of the direction, 0 to 7.
    #[inline(always)]
    pub(in crate::scene) fn octant(&self) -> usize {
        let [x, y, z] = self.backward;
        x + 2 * y + 4 * z
    }
}
