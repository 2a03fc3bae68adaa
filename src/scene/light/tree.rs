//! The light tree: which of many emitters, for a point, with a probability that follows what
//! each may contribute (Conty Estevez & Kulla 2018, "Importance sampling of many lights with
//! adaptive tree splitting"; Pharr, Jakob & Humphreys, "Physically Based Rendering", 12.6.3).
//!
//! It looks at the position of the point only, so that the probability can be found again when
//! a ray runs into an emitter by itself.

use glam::Vec3;

use super::bounds::{Bounds, Group, Part};
use super::split::split;

/// Something that is chosen as a whole: a triangle, a quadric, a lamp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Emitter {
    pub(super) bounds: Bounds,
    /// Its number.
    pub(super) index: u32,
}

/// A binary tree over emitters.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    root: Option<Group>,
    pairs: Vec<[Group; 2]>,
    /// The way to every emitter by its number, from the root on: bit by bit, the lowest first,
    /// 1 for the second of a pair. [`NOWHERE`] for those that are not in the tree.
    trails: Vec<u64>,
}

/// No way: a path is never 64 pairs long.
const NOWHERE: u64 = u64::MAX;
/// The longest way.
const DEEPEST: u32 = 60;

impl LightTree {
    /// Builds the tree over emitters whose numbers are below `count`.
    pub(super) fn new(mut emitters: Vec<Emitter>, count: usize) -> Self {
        let mut tree = Self {
            root: None,
            pairs: Vec::with_capacity(emitters.len().saturating_sub(1)),
            trails: vec![NOWHERE; count],
        };
        if !emitters.is_empty() {
            tree.root = Some(tree.grow(&mut emitters, 0, 0).0);
        }
        tree
    }

    /// Whether there is nothing to choose.
    pub(super) fn is_empty(&self) -> bool {
        self.root.is_none()
    }

    fn grow(&mut self, group: &mut [Emitter], trail: u64, depth: u32) -> (Group, Bounds) {
        if let [emitter] = group {
            self.trails[emitter.index as usize] = trail;
            let part = Part::Emitter(emitter.index);
            return (Group::new(&emitter.bounds, part), emitter.bounds);
        }
        // Lights ever closer together would make a tree as deep as there are lights.
        let levels = usize::BITS - group.len().leading_zeros();
        let place = split(group, depth + levels >= DEEPEST);
        let pair = self.pairs.len();
        self.pairs.push([Group::default(); 2]);
        let (first, second) = group.split_at_mut(place);
        let (a, a_bounds) = self.grow(first, trail, depth + 1);
        let (b, b_bounds) = self.grow(second, trail | 1 << depth, depth + 1);
        self.pairs[pair] = [a, b];
        let bounds = a_bounds.with(b_bounds);
        (Group::new(&bounds, Part::Pair(pair as u32)), bounds)
    }

    /// Chooses an emitter for a point: its number and the probability of the choice. `None`
    /// where what is left cannot contribute.
    pub(super) fn choose(&self, p: Vec3, mut u: f64) -> Option<(u32, f32)> {
        let mut group = self.root.filter(|root| root.importance(p) > 0.0)?;
        let mut probability = 1.0;
        loop {
            let pair = match group.part() {
                Part::Emitter(index) => return Some((index, probability as f32)),
                Part::Pair(pair) => &self.pairs[pair as usize],
            };
            let first = share(pair, p)?;
            if u < first {
                u /= first;
                probability *= first;
                group = pair[0];
            } else {
                u = (u - first) / (1.0 - first);
                probability *= 1.0 - first;
                group = pair[1];
            }
            // Rounding may reach 1, which would choose what has no share.
            u = u.min(1.0 - f64::EPSILON);
        }
    }

    /// The probability with which [`Self::choose`] chooses an emitter for a point.
    pub(super) fn probability(&self, p: Vec3, emitter: u32) -> f32 {
        let mut trail = self.trails[emitter as usize];
        let Some(mut group) = self.root.filter(|root| root.importance(p) > 0.0) else { return 0.0 };
        if trail == NOWHERE {
            return 0.0;
        }
        let mut probability = 1.0;
        while let Part::Pair(pair) = group.part() {
            let pair = &self.pairs[pair as usize];
            let Some(first) = share(pair, p) else { return 0.0 };
            let second = trail & 1 != 0;
            probability *= if second { 1.0 - first } else { first };
            group = pair[usize::from(second)];
            trail >>= 1;
        }
        probability as f32
    }
}

/// The probability of the first of a pair; `None` where neither can contribute.
#[inline(always)]
fn share(pair: &[Group; 2], p: Vec3) -> Option<f64> {
    let [a, b] = [0, 1].map(|i| f64::from(pair[i].importance(p)));
    (a + b > 0.0).then(|| a / (a + b))
}
