//! What moves: copies of objects whose place depends on time, apart from the world that stands
//! still. Rays meet the two in stages of their own, and where nothing moves there is only one.

use std::sync::{Arc, PoisonError};

use glam::{Affine3A, Vec3};

use super::intersect::inside;
use super::traverse::{Beyond, Nearest, Prepared, TraversalStack, near, walk};
use super::tree::{Child, Code, Part, Parts, Tree};
use super::{Instance, Scene, rounded_out, single};
use crate::lanes::Real;
use crate::motion::Motion;
use crate::rays::{Column, Hit, HitBatch, Ray, RayBatch};

/// A copy of an object that moves.
#[derive(Clone, Debug)]
pub struct Mover {
    /// Which object.
    pub object: u32,
    /// Object space to world space.
    pub motion: Motion,
}

/// All that move, and trees of the boxes that they pass: each for a part of the exposure, so that
/// few rays come near to what was there at another time.
#[derive(Clone, Debug, Default)]
pub(super) struct Movers {
    pub(super) all: Arc<[Mover]>,
    trees: Arc<[Tree]>,
    /// When the first part begins and the last one ends, and how many there are in a unit of the
    /// share.
    range: [f64; 2],
    per_share: f64,
}

/// A moving scene that was stopped.
#[derive(Debug)]
pub(super) struct Still {
    /// At which share of its motion.
    share: f64,
    instances: Arc<[Instance]>,
    world: Arc<Tree>,
}

/// Parts of an exposure.
const MOST_PARTS: usize = 16;
/// Boxes in all trees, unless one alone has more.
const MOST_BOXES: usize = 1 << 16;
/// What parts overlap, in shares of one and of the time itself: times of rays are rounded.
const OVERLAP: f64 = 1e-6;

impl Movers {
    /// For times between two shares of the motion.
    pub(super) fn new(
        all: impl Into<Arc<[Mover]>>,
        objects: &[Tree],
        [from, to]: [f64; 2],
    ) -> Self {
        let all = all.into();
        if all.is_empty() {
            return Self::default();
        }
        let parts = (MOST_BOXES / all.len()).clamp(1, MOST_PARTS);
        let width = (to - from) / parts as f64;
        let slack = OVERLAP * (width + from.abs().max(to.abs()));
        let trees = (0..parts).map(|part| {
            let start = from + width * part as f64;
            let range = [start - slack, start + width + slack];
            tree(&all, objects, range)
        });
        let trees = trees.collect();
        let per_share = if width > 0.0 { 1.0 / width } else { 0.0 };
        Self { trees, range: [from, to], per_share, all }
    }

    /// The tree of a time.
    #[inline(always)]
    fn tree(&self, time: f32) -> &Tree {
        let part = (f64::from(time) - self.range[0]) * self.per_share;
        &self.trees[(part as usize).min(self.trees.len() - 1)]
    }

    pub(super) fn bounds(&self) -> Option<[Vec3; 2]> {
        let both =
            |[low, high]: [Vec3; 2], [least, most]: [Vec3; 2]| [low.min(least), high.max(most)];
        self.trees.iter().filter_map(|tree| tree.bounds).reduce(both)
    }

    pub(super) fn pending(&self) -> usize {
        self.trees.iter().map(|tree| tree.pending).max().unwrap_or(0)
    }

    pub(super) fn bytes(&self) -> usize {
        self.trees.iter().map(Tree::bytes).sum::<usize>() + size_of_val(&self.all[..])
    }
}

/// The boxes that things pass between two shares of the motion.
fn tree(all: &[Mover], objects: &[Tree], range: [f64; 2]) -> Tree {
    let mut parts = Parts::default();
    for (number, mover) in all.iter().enumerate() {
        let Some([low, high]) = objects[mover.object as usize].bounds else { continue };
        let swept = mover.motion.sweep([low.as_dvec3(), high.as_dvec3()], range);
        parts.push(Part::Instance(number as u32, rounded_out(swept)));
    }
    Tree::new(&parts)
}

impl Scene {
    /// What moves.
    pub fn movers(&self) -> &[Mover] {
        &self.movers.all
    }

    /// What moves, each with the box around its object: lowest and highest corner, object space.
    pub fn moving_boxes(&self) -> impl Iterator<Item = ([Vec3; 2], &Motion)> {
        let bounds = |mover: &Mover| self.objects[mover.object as usize].bounds;
        self.movers.all.iter().filter_map(move |mover| Some((bounds(mover)?, &mover.motion)))
    }

    /// Makes the scene ready for times between two shares of its motion; a new one is from 0 to 1.
    pub fn expose(&mut self, range: [f64; 2]) {
        if range != self.movers.range {
            self.movers = Movers::new(self.movers.all.clone(), &self.objects, range);
        }
    }

    /// Stops everything at a share of its motion: nothing moves any more.
    pub fn freeze(&mut self, share: f64) {
        if self.movers.all.is_empty() {
            return;
        }
        let known = self.still.clone();
        let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
        let still = match known.take().filter(|still| still.share == share) {
            Some(still) => still,
            None => {
                let stopped = |mover: &Mover| Instance::new(mover.object, &mover.motion.at(share));
                let stopped = self.movers.all.iter().map(stopped);
                let instances: Arc<[Instance]> =
                    self.instances.iter().copied().chain(stopped).collect();
                let world = Arc::new(self.grow(&instances));
                Still { share, instances, world }
            }
        };
        (self.instances, self.world) = (still.instances.clone(), still.world.clone());
        self.movers = Movers::default();
        *known = Some(still);
    }

    /// Where an instance stands, at a time where it moves: object space to world space and back.
    pub(super) fn pose(&self, instance: u32, time: f32) -> [Affine3A; 2] {
        if let Some(Instance { world_from_object, object_from_world, .. }) =
            self.instances.get(instance as usize)
        {
            return [*world_from_object, *object_from_world];
        }
        let mover = &self.movers.all[instance as usize - self.instances.len()];
        let pose = mover.motion.at(f64::from(time));
        [single(&pose), single(&pose.inverse())]
    }

    /// Whether a ray of a wave comes near to what moves, at any time.
    pub fn comes_near(&self, rays: &RayBatch, ray: usize) -> bool {
        self.movers.bounds().is_some_and(|bounds| near::<f32>(rays, ray, bounds) != 0)
    }

    /// The nearest hits of rays, nearer ones on moving things put in the place of those that
    /// [`Self::intersect`] has found: a stage. The time of a ray is found by its slot.
    pub fn intersect_moving<R: Real<Scalar = f32>>(
        &self,
        rays: &RayBatch,
        times: &Column<f32>,
        hits: &mut HitBatch,
        stack: &mut TraversalStack,
    ) {
        let Some(bounds) = self.movers.bounds() else { return };
        let pending = self.room(stack);
        for first in (0..rays.len).step_by(R::LANES) {
            let mut left = near::<R>(rays, first, bounds);
            while left != 0 {
                let i = first + left.trailing_zeros() as usize;
                left &= left - 1;
                if i >= rays.len {
                    break;
                }
                let time = times[rays.slot[i] as usize];
                if let Some(hit) = self.meet::<R, false>(&rays.ray(i), time, hits[i].t, pending) {
                    hits[i] = hit;
                }
            }
        }
    }

    /// Takes those shadow rays out that end at moving things: a stage before [`Self::occlude`].
    pub fn occlude_moving<R: Real<Scalar = f32>>(
        &self,
        rays: &mut RayBatch,
        times: &Column<f32>,
        stack: &mut TraversalStack,
    ) {
        let Some(bounds) = self.movers.bounds() else { return };
        let (len, pending) = (rays.len, self.room(stack));
        rays.len = 0;
        for first in (0..len).step_by(R::LANES) {
            // Before rays move to the front, which is never beyond this packet.
            let near = near::<R>(rays, first, bounds);
            for i in first..len.min(first + R::LANES) {
                let (ray, slot) = (rays.ray(i), rays.slot[i]);
                let met = near >> (i - first) & 1 == 1
                    && self
                        .meet::<R, true>(&ray, times[slot as usize], ray.t_max, pending)
                        .is_some();
                if !met {
                    rays.push(ray, rays.carried(i), slot);
                }
            }
        }
    }

    /// The nearest hit of one ray at a time, on what moves and what does not.
    pub fn closest_at<R: Real<Scalar = f32>>(
        &self,
        ray: &Ray,
        time: f32,
        stack: &mut TraversalStack,
    ) -> Hit {
        let still = self.closest::<R>(ray, stack);
        let pending = self.room(stack);
        self.meet::<R, false>(ray, time, still.t, pending).unwrap_or(still)
    }

    /// The nearest hit on a moving thing, or with `ANY` some hit, before a distance.
    fn meet<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        ray: &Ray,
        time: f32,
        t_max: f32,
        pending: &mut [u64],
    ) -> Option<Hit> {
        if self.movers.all.is_empty() {
            return None;
        }
        let ray = Prepared::new(ray.origin, ray.direction)?;
        let mut nearest = Nearest::new(t_max);
        let moment = Moment { scene: self, time };
        let tree = self.movers.tree(time);
        walk::<R, ANY>(tree, &moment, Code::ROOT, &ray, &mut nearest, pending)
            .then(|| Hit { time, ..nearest.hit(tree) })
    }
}

/// The scene as it is at a time.
struct Moment<'a> {
    scene: &'a Scene,
    time: f32,
}

impl Beyond for Moment<'_> {
    #[inline(never)]
    fn meet<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        child: Child,
        ray: &Prepared,
        nearest: &mut Nearest,
        pending: &mut [u64],
    ) -> bool {
        let (scene, Child::Instance(number)) = (self.scene, child) else { return false };
        let mover = &scene.movers.all[number as usize];
        let tree: &Tree = &scene.objects[mover.object as usize];
        let pose = mover.motion.at(f64::from(self.time));
        let Some(ray) = inside(ray, &single(&pose.inverse())) else { return false };
        let mut inner = Nearest::new(nearest.t);
        let met = walk::<R, ANY>(tree, scene, Code::ROOT, &ray, &mut inner, pending);
        if met {
            let instance = scene.instances.len() as u32 + number;
            nearest.replace(&Hit { instance, ..inner.hit(tree) });
        }
        met
    }

    fn solid(&self, _ray: &Prepared, _name: [u32; 2], _weights: [f32; 2]) -> bool {
        // Its tree holds instances alone.
        true
    }
}
