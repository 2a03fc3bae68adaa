//! The nearest triangle so far.

use super::Beyond;
use super::ray::Prepared;
use super::triangles::{ahead, triangles};
use crate::lanes::Real;
use crate::rays::{Hit, NONE};
use crate::scene::tree::Tree;

/// The nearest hit on the way through a tree. Whose triangle it is, is looked up at the end.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Nearest {
    /// Distance, or where the ray ends.
    pub(in crate::scene) t: f32,
    /// Barycentric weights of the second and the third corner.
    pub(super) weights: [f32; 2],
    /// Packet and lane, or [`NONE`].
    pub(super) place: u32,
    /// What was hit if it is no triangle of this tree: shape, primitive and instance.
    pub(in crate::scene) other: [u32; 3],
}

impl Nearest {
    /// Nothing yet, on a ray that ends at a distance.
    #[inline(always)]
    pub(in crate::scene) fn new(t_max: f32) -> Self {
        Self { t: t_max, weights: [0.0; 2], place: NONE, other: [NONE; 3] }
    }

    /// What the walk through a tree of the world has found.
    #[inline(always)]
    pub(in crate::scene) fn hit(&self, tree: &Tree) -> Hit {
        let [shape, primitive, instance] = match self.place {
            NONE => self.other,
            place => {
                let [shape, primitive] = name(tree, place);
                [shape, primitive, NONE]
            }
        };
        let [u, v] = self.weights;
        Hit { t: self.t, u, v, shape, primitive, instance, ..Hit::MISS }
    }

    /// Takes over a hit that is no triangle of this tree.
    #[inline(always)]
    pub(in crate::scene) fn replace(&mut self, hit: &Hit) {
        self.t = hit.t;
        self.weights = [hit.u, hit.v];
        self.place = NONE;
        self.other = [hit.shape, hit.primitive, hit.instance];
    }
}

/// Shape and triangle at a place.
#[inline(always)]
fn name(tree: &Tree, place: u32) -> [u32; 2] {
    tree.names[place as usize / 8].0[place as usize % 8]
}

/// One ray against a packet. Answers whether the nearest hit is a new one.
#[inline(always)]
pub(super) fn packet<R: Real<Scalar = f32>, const ANY: bool>(
    tree: &Tree,
    number: u32,
    ray: &Prepared,
    nearest: &mut Nearest,
) -> bool {
    let packet = &tree.packets[number as usize];
    let met = triangles::<R>(packet, ray, nearest.t);
    let (mut mask, mut found) = (met.mask, false);
    while mask != 0 {
        let lane = mask.trailing_zeros();
        mask &= mask - 1;
        let t = met.distance(lane as usize);
        let place = number * 8 + lane;
        if comes_before(tree, t, place, nearest) && ahead(packet, lane as usize, ray, t) {
            if ANY {
                return true;
            }
            (nearest.t, nearest.place) = (t, place);
            nearest.weights = met.weights(lane as usize);
            found = true;
        }
    }
    found
}

/// Whether a triangle is nearer than the nearest so far. Of two at the same distance it is the
/// one with the lower name: the order in which a tree is walked makes no difference.
#[inline(always)]
fn comes_before(tree: &Tree, t: f32, place: u32, nearest: &Nearest) -> bool {
    t < nearest.t
        || t == nearest.t && nearest.place != NONE && name(tree, place) < name(tree, nearest.place)
}

/// As [`packet`], for triangles with holes.
#[cold]
#[inline(never)]
pub(super) fn cutouts<R: Real<Scalar = f32>>(
    tree: &Tree,
    number: u32,
    beyond: &impl Beyond,
    ray: &Prepared,
    nearest: &mut Nearest,
) -> bool {
    let packet = &tree.packets[number as usize];
    let met = triangles::<R>(packet, ray, nearest.t);
    let (mut mask, mut found) = (met.mask, false);
    while mask != 0 {
        let lane = mask.trailing_zeros();
        mask &= mask - 1;
        let (t, weights) = (met.distance(lane as usize), met.weights(lane as usize));
        let place = number * 8 + lane;
        if comes_before(tree, t, place, nearest)
            && ahead(packet, lane as usize, ray, t)
            && beyond.solid(ray, name(tree, place), weights)
        {
            (nearest.t, nearest.place, nearest.weights) = (t, place, weights);
            found = true;
        }
    }
    found
}
