//! Animated instances: copies of objects whose pose depends on time.
//!
//! They have hierarchies apart from that of the static world. A scene without motion has none.

use std::sync::{Arc, PoisonError};

use glam::Vec3;

use super::bvh::{Bvh, PrimitiveGroup, PrimitiveList};
use super::transform::round_outward;
use super::world::build_world;
use super::{Instance, InstancePose, Scene};
use crate::motion::Motion;

/// A moving copy of an object.
#[derive(Clone, Debug)]
pub struct AnimatedInstance {
    /// Index of the object.
    pub object: u32,
    /// Object space to world space, by time.
    pub motion: Motion,
}

/// All animated instances, and hierarchies over the boxes that they sweep. Each hierarchy covers
/// one interval of the exposure, so few rays test an instance that was there at another time.
#[derive(Clone, Debug, Default)]
pub(super) struct AnimatedInstances {
    pub(super) all: Arc<[AnimatedInstance]>,
    bvhs: Arc<[Bvh]>,
    /// Start of the first interval and end of the last, as fractions of the motion.
    range: [f64; 2],
    /// Intervals per unit of time.
    intervals_per_unit: f64,
}

/// A scene whose motion was stopped at one time.
#[derive(Debug)]
pub(super) struct FrozenScene {
    /// Time, as a fraction of the motion.
    time: f64,
    instances: Arc<[Instance]>,
    world: Arc<Bvh>,
}

/// Most intervals of an exposure.
const MAX_INTERVALS: usize = 16;
/// Most boxes in all hierarchies together, unless a single one has more.
const MAX_BOXES: usize = 1 << 16;
/// Overlap of intervals, relative to their width plus the time itself: ray times are rounded.
const OVERLAP: f64 = 1e-6;

impl AnimatedInstances {
    /// Builds the hierarchies for times between two fractions of the motion.
    pub(super) fn new(
        all: impl Into<Arc<[AnimatedInstance]>>,
        objects: &[Bvh],
        [from, to]: [f64; 2],
    ) -> Self {
        let all = all.into();
        if all.is_empty() {
            return Self::default();
        }
        let intervals = (MAX_BOXES / all.len()).clamp(1, MAX_INTERVALS);
        let width = (to - from) / intervals as f64;
        let slack = OVERLAP * (width + from.abs().max(to.abs()));
        let bvhs = (0..intervals).map(|interval| {
            let start = from + width * interval as f64;
            let range = [start - slack, start + width + slack];
            build_swept_bvh(&all, objects, range)
        });
        let bvhs = bvhs.collect();
        let intervals_per_unit = if width > 0.0 { 1.0 / width } else { 0.0 };
        Self { bvhs, range: [from, to], intervals_per_unit, all }
    }

    /// Returns the hierarchy for a time.
    #[inline(always)]
    pub(super) fn bvh_at(&self, time: f32) -> &Bvh {
        let interval = (f64::from(time) - self.range[0]) * self.intervals_per_unit;
        &self.bvhs[(interval as usize).min(self.bvhs.len() - 1)]
    }

    pub(super) fn bounds(&self) -> Option<[Vec3; 2]> {
        let union =
            |[low, high]: [Vec3; 2], [least, most]: [Vec3; 2]| [low.min(least), high.max(most)];
        self.bvhs.iter().filter_map(|bvh| bvh.bounds).reduce(union)
    }

    pub(super) fn stack_size(&self) -> usize {
        self.bvhs.iter().map(|bvh| bvh.stack_size).max().unwrap_or(0)
    }

    pub(super) fn bytes(&self) -> usize {
        self.bvhs.iter().map(Bvh::bytes).sum::<usize>() + size_of_val(&self.all[..])
    }
}

/// Builds the hierarchy over the boxes that instances sweep within a range of times.
fn build_swept_bvh(all: &[AnimatedInstance], objects: &[Bvh], range: [f64; 2]) -> Bvh {
    let mut primitives = PrimitiveList::default();
    for (number, instance) in all.iter().enumerate() {
        let Some([low, high]) = objects[instance.object as usize].bounds else { continue };
        let swept = instance.motion.swept_bounds([low.as_dvec3(), high.as_dvec3()], range);
        primitives.push(PrimitiveGroup::Instance(number as u32, round_outward(swept)));
    }
    Bvh::new(primitives)
}

impl Scene {
    /// Returns the animated instances.
    pub fn animated_instances(&self) -> &[AnimatedInstance] {
        &self.animated.all
    }

    /// Returns the animated instances, shared with the scene.
    pub fn shared_animated_instances(&self) -> Arc<[AnimatedInstance]> {
        self.animated.all.clone()
    }

    /// Returns the number of instances that are not animated. Hits count the animated ones after them.
    pub fn resting_instance_count(&self) -> u32 {
        self.instances.len() as u32
    }

    /// Returns the motion of each animated instance and the box of its object: lowest and highest
    /// corner, object space.
    pub fn animated_bounds(&self) -> impl Iterator<Item = ([Vec3; 2], &Motion)> {
        let bounds = |instance: &AnimatedInstance| self.objects[instance.object as usize].bounds;
        self.animated
            .all
            .iter()
            .filter_map(move |instance| Some((bounds(instance)?, &instance.motion)))
    }

    /// Prepares the scene for times between two fractions of its motion. A new scene covers 0 to 1.
    pub fn set_time_range(&mut self, range: [f64; 2]) {
        if range != self.animated.range {
            self.animated = AnimatedInstances::new(self.animated.all.clone(), &self.objects, range);
        }
    }

    /// Turns the animated instances into static ones, at a time given as a fraction of the motion.
    pub fn freeze(&mut self, time: f64) {
        if self.animated.all.is_empty() {
            return;
        }
        let cache = self.frozen.clone();
        let mut cache = cache.lock().unwrap_or_else(PoisonError::into_inner);
        let frozen = match cache.take().filter(|frozen| frozen.time == time) {
            Some(frozen) => frozen,
            None => {
                let stopped = |instance: &AnimatedInstance| Instance {
                    object: instance.object,
                    pose: InstancePose::new(&instance.motion.at(time)),
                };
                let stopped = self.animated.all.iter().map(stopped);
                let instances: Arc<[Instance]> =
                    self.instances.iter().copied().chain(stopped).collect();
                let world =
                    build_world(&self.shapes, &self.static_shapes, &self.objects, &instances);
                let world = Arc::new(world);
                FrozenScene { time, instances, world }
            }
        };
        (self.instances, self.world) = (frozen.instances.clone(), frozen.world.clone());
        self.animated = AnimatedInstances::default();
        *cache = Some(frozen);
    }

    /// Returns the object of an instance.
    pub(super) fn object_of(&self, instance: u32) -> u32 {
        let instance = instance as usize;
        match self.instances.get(instance) {
            Some(Instance { object, .. }) => *object,
            None => self.animated.all[instance - self.instances.len()].object,
        }
    }

    /// Returns the pose of an instance, at a time if it is animated.
    pub(super) fn pose(&self, instance: u32, time: f32) -> InstancePose {
        if let Some(Instance { pose, .. }) = self.instances.get(instance as usize) {
            return *pose;
        }
        let instance = &self.animated.all[instance as usize - self.instances.len()];
        InstancePose::new(&instance.motion.at(f64::from(time)))
    }
}
