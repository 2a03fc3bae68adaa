//! Precomputed terms of the box and triangle tests of a ray.

use petzval_base::lanes::Real;
use petzval_base::rays::Ray;

/// Terms that the box and triangle tests of rays share.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayTerms<R> {
    /// By axis: a ray enters the slab side at coordinate p at distance p * entry[0] + entry[1], and
    /// leaves it at p * exit[0] + exit[1].
    pub(super) entry: [[R; 2]; 3],
    pub(super) exit: [[R; 2]; 3],
    /// Axis of the largest component of the direction: 0, 1 or 2.
    pub(super) largest: R,
    /// Shear in the two axes that follow the largest, and scale of the largest, that map the
    /// direction to +z.
    pub(super) shear: [R; 3],
}

/// A single ray with the terms of its tests, as in [`RayTerms`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TraversalRay {
    /// Origin.
    pub(crate) origin: [f32; 3],
    /// Direction, of any length.
    pub(crate) direction: [f32; 3],
    pub(super) entry: [[f32; 2]; 3],
    pub(super) exit: [[f32; 2]; 3],
    /// 1 if the direction is negative on an axis: the index of the near sides of boxes.
    pub(super) backward: [usize; 3],
    /// Axes, rotated so that the largest component of the direction comes last.
    pub(super) axes: [usize; 3],
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

impl<R: Real<Scalar = f32>> RayTerms<R> {
    /// Returns the terms of rays whose directions are finite.
    #[inline(always)]
    pub(super) fn new(origin: [R; 3], direction: [R; 3]) -> Self {
        let one = R::constant(1.0);
        let (zero, limit) = (R::constant(0.0), R::splat(MAX_INVERSE));
        let [x, y, z] = direction;
        let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
        let x_first = ay.lt(ax);
        let (is_x, is_y) = (x_first & az.lt(ax), !x_first & az.lt(ay));
        let pick = |x: R, y: R, z: R| R::select(is_x, x, R::select(is_y, y, z));
        let scale = one / pick(x, y, z);
        let (mut entry, mut exit) = ([[zero; 2]; 3], [[zero; 2]; 3]);
        for axis in 0..3 {
            let inverse = (one / direction[axis]).max(-limit).min(limit);
            let start = origin[axis] * inverse;
            let slack = start.abs() * R::splat(ENTRY_SLACK);
            let factor = R::splat(EXIT_FACTOR);
            entry[axis] = [inverse, -(start + slack)];
            exit[axis] = [inverse * factor, (slack - start) * factor];
        }
        Self {
            entry,
            exit,
            largest: pick(zero, one, one + one),
            shear: [pick(y, z, x) * scale, pick(z, x, y) * scale, scale],
        }
    }
}

impl TraversalRay {
    /// Prepares a ray. Returns `None` if it [cannot hit anything](can_hit).
    #[inline(always)]
    pub(crate) fn new(origin: [f32; 3], direction: [f32; 3]) -> Option<Self> {
        can_hit(origin, direction)
            .then(|| Self::from_terms(origin, direction, RayTerms::<f32>::new(origin, direction)))
    }

    /// Joins a ray and its terms.
    #[inline(always)]
    pub(super) fn from_terms(origin: [f32; 3], direction: [f32; 3], terms: RayTerms<f32>) -> Self {
        let RayTerms { entry, exit, largest, shear } = terms;
        let backward = backward(octant(direction));
        let z = largest as usize;
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        Self { origin, direction, entry, exit, backward, axes, shear }
    }
}

/// Returns whether a ray can hit anything: its direction is finite, and its origin is not farther
/// out than [`MAX_ORIGIN`].
#[inline(always)]
fn can_hit(origin: [f32; 3], direction: [f32; 3]) -> bool {
    let sum = direction.iter().fold(0.0, |sum, v| sum + v * 0.0);
    let in_range = origin.iter().all(|v| v.abs() <= MAX_ORIGIN);
    sum == 0.0 && in_range
}

/// Returns the octant of a direction, 0 to 7.
#[inline(always)]
fn octant(direction: [f32; 3]) -> usize {
    let [x, y, z] = direction.map(|v| usize::from(v.is_sign_negative()));
    x + 2 * y + 4 * z
}

/// Returns 1 for each axis on which directions of an octant are negative: the index of the near
/// sides of boxes.
#[inline(always)]
pub(super) fn backward(octant: usize) -> [usize; 3] {
    [octant & 1, octant >> 1 & 1, octant >> 2 & 1]
}

/// Rays of one octant that wait until there are enough for a packet.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RayQueue {
    /// Number of rays.
    pub(crate) len: usize,
    /// Index of each ray in its wave.
    pub(crate) index: [u32; 8],
    pub(super) octant: usize,
    /// By axis and ray.
    pub(super) origin: [[f32; 8]; 3],
    pub(super) direction: [[f32; 8]; 3],
    /// Ends of the rays.
    pub(super) t_max: [f32; 8],
}

impl RayQueue {
    /// Adds a ray to the queue of its octant, unless it [cannot hit anything](can_hit). Returns the
    /// queue if it is full now; it takes no more rays until its length is 0.
    #[inline(always)]
    pub(crate) fn push<'a>(
        queues: &'a mut [Self; 8],
        ray: &Ray,
        index: usize,
    ) -> Option<&'a mut Self> {
        if !can_hit(ray.origin, ray.direction) {
            return None;
        }
        let octant = octant(ray.direction);
        let queue = &mut queues[octant];
        let lane = queue.len & 7;
        for axis in 0..3 {
            queue.origin[axis][lane] = ray.origin[axis];
            queue.direction[axis][lane] = ray.direction[axis];
        }
        queue.t_max[lane] = ray.t_max;
        queue.index[lane] = index as u32;
        (queue.len, queue.octant) = (lane + 1, octant);
        (queue.len == 8).then_some(queue)
    }
}
