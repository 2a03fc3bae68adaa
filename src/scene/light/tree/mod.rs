//! Light tree: the random selection of one of many emitters, with a probability in proportion to a
//! bound on its contribution to a point (Conty Estevez & Kulla 2018, "Importance sampling of many
//! lights with adaptive tree splitting"; Pharr, Jakob & Humphreys, "Physically Based Rendering",
//! 12.6.3).
//!
//! The probability depends only on the position of the receiver and on the side from which it
//! receives light, so it can be computed again when BSDF sampling hits an emitter.

mod bounds;
mod cone;
mod descent;
mod node;
mod split;

use std::ops::Range;

pub(super) use bounds::LightBounds;
pub(super) use cone::Cone;
pub(super) use descent::Descent;
pub(super) use node::{LightChild, LightNode, Receiver};

use split::{SplitRule, split};

/// The unit of selection: a triangle, a quadric or a point light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Emitter {
    pub(super) bounds: LightBounds,
    /// Index among the emitters of the scene.
    pub(super) index: u32,
}

/// Tree over emitters, with eight children a node.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    /// Nodes, the root first; empty without emitters.
    nodes: Vec<LightNode>,
    /// Slot of every emitter, by its index: eight times the index of its node, plus its index among
    /// the children; [`NOT_IN_TREE`] for those that are not in the tree.
    slots: Vec<u32>,
}

const NOT_IN_TREE: u32 = u32::MAX;
/// Number of successive splits by cost, after which splits are at the median.
const MAX_BEST_SPLITS: u32 = 60;

/// A group of emitters that may be split further.
#[derive(Clone)]
struct Branch {
    emitters: Range<usize>,
    /// Number of splits that led to it.
    splits: u32,
}

impl LightTree {
    /// Builds the tree over emitters whose indices are below `count`.
    pub(super) fn new(mut emitters: Vec<Emitter>, count: usize) -> Self {
        let mut tree = Self { nodes: Vec::new(), slots: vec![NOT_IN_TREE; count] };
        if !emitters.is_empty() {
            let all = Branch { emitters: 0..emitters.len(), splits: 0 };
            tree.build_node(&mut emitters, all);
        }
        tree
    }

    /// Returns whether the tree has no emitters.
    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Adds the node of a group and all nodes below it. Returns its index and bounds.
    fn build_node(&mut self, emitters: &mut [Emitter], whole: Branch) -> (u32, LightBounds) {
        let node = self.nodes.len();
        self.nodes.push(LightNode::EMPTY);
        let mut branches = vec![whole];
        while branches.len() < 8 {
            let size = |branch: &Branch| branch.emitters.len();
            let Some(i) = (0..branches.len()).max_by_key(|&i| size(&branches[i])) else { break };
            let Range { start, end } = branches[i].emitters.clone();
            if end - start < 2 {
                break;
            }
            // Splits by cost alone could make the tree as deep as there are lights, if each is
            // closer to the next.
            let splits = branches[i].splits + 1;
            let rule = match splits > MAX_BEST_SPLITS {
                true => SplitRule::Median,
                false => SplitRule::LeastCost,
            };
            let middle = start + split(&mut emitters[start..end], rule);
            branches[i] = Branch { emitters: start..middle, splits };
            branches.push(Branch { emitters: middle..end, splits });
        }
        let mut sum: Option<LightBounds> = None;
        for (i, branch) in branches.into_iter().enumerate() {
            let slot = (node * 8 + i) as u32;
            let (bounds, child) = if branch.emitters.len() == 1 {
                let emitter = &emitters[branch.emitters.start];
                self.slots[emitter.index as usize] = slot;
                (emitter.bounds, LightChild::Emitter(emitter.index))
            } else {
                let (index, bounds) = self.build_node(emitters, branch);
                self.nodes[index as usize].parent = slot;
                (bounds, LightChild::Node(index))
            };
            self.nodes[node].set_child(i, &bounds, child);
            sum = Some(sum.map_or(bounds, |sum| sum.union(bounds)));
        }
        let bounds = sum.unwrap_or_else(|| emitters[0].bounds);
        (node as u32, bounds)
    }

    /// Selects an emitter for one receiver, by two numbers in [0, 1). Returns its index and
    /// probability, or `None` if the rest of the tree cannot contribute.
    pub(super) fn choose(&self, receiver: &Receiver<f32>, u: [f32; 2]) -> Option<(u32, f32)> {
        let mut node = self.nodes.first()?;
        let mut descent = Descent::new(u);
        loop {
            let importance = node.importance(receiver);
            let step = descent.step(node.len(), |i| importance[i]);
            if !step.some {
                return None;
            }
            match node.child(step.child as usize) {
                LightChild::Emitter(index) => return Some((index, descent.probability)),
                LightChild::Node(index) => node = &self.nodes[index as usize],
            }
        }
    }

    /// Returns the probability with which [`Self::choose`] selects an emitter.
    pub(super) fn probability(&self, receiver: &Receiver<f32>, emitter: u32) -> f32 {
        let mut slot = self.slots[emitter as usize];
        if slot == NOT_IN_TREE {
            return 0.0;
        }
        let mut probability = 1.0;
        loop {
            let node = &self.nodes[slot as usize / 8];
            let importance = node.importance(receiver);
            let sum: f32 = importance.iter().sum();
            let one = importance[slot as usize % 8];
            if !(one > 0.0 && sum.is_finite()) {
                return 0.0;
            }
            probability *= one / sum;
            if slot < 8 {
                return probability;
            }
            slot = node.parent;
        }
    }

    /// Returns the only emitter, if there is just one.
    pub(super) fn only_emitter(&self) -> Option<u32> {
        match &self.nodes[..] {
            [node] if node.len() == 1 => match node.child(0) {
                LightChild::Emitter(index) => Some(index),
                LightChild::Node(_) => None,
            },
            _ => None,
        }
    }

    /// Returns a node by its index; 0 is the root.
    pub(super) fn node(&self, index: u32) -> &LightNode {
        &self.nodes[index as usize]
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::GlossyLobe;
    use super::*;
    use petzval_base::sampler::{Dimension, sample_2d};

    /// A point that receives light from all sides.
    fn at(p: Vec3) -> Receiver<f32> {
        Receiver { position: p.to_array(), reception: Vec3::ZERO.into() }
    }

    /// A narrow lobe in any direction.
    fn lobe(numbers: &mut Numbers) -> Option<GlossyLobe> {
        GlossyLobe::new(numbers.vector().normalize().to_array(), 1e-4, 0.98)
    }

    /// Lehmer's generator of uniform numbers in [0, 1).
    struct Numbers(u64);

    impl Numbers {
        fn pair(&mut self) -> [f32; 2] {
            [self.next(), self.next()].map(|u| (u as f32).min(1.0 - f32::EPSILON))
        }

        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(0xd134_2543_de82_ef95) | 1;
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }

        fn vector(&mut self) -> Vec3 {
            Vec3::from([0; 3].map(|_| (2.0 * self.next() - 1.0) as f32))
        }
    }

    fn emitters(count: u32, numbers: &mut Numbers) -> Vec<Emitter> {
        let mut emitters = Vec::new();
        for index in 0..count {
            let (low, size) = (numbers.vector() * 10.0, numbers.vector().abs());
            let normals = Cone { axis: numbers.vector().normalize(), angle: 0.0 };
            let two_sided = numbers.next() < 0.2;
            let normals = if numbers.next() < 0.2 { Cone::ALL } else { normals };
            let intensity = numbers.next() as f32;
            let high = low + size;
            let bounds =
                LightBounds { low, high, normals, cos_emission: 0.0, intensity, two_sided };
            emitters.push(Emitter { bounds, index });
        }
        emitters
    }

    #[test]
    fn probabilities_of_all_emitters_and_of_none_sum_to_one() {
        let mut numbers = Numbers(1);
        for count in [1, 2, 3, 17, 1000] {
            let emitters = emitters(count, &mut numbers);
            let tree = LightTree::new(emitters.clone(), count as usize);
            for _ in 0..20 {
                let p = numbers.vector() * 20.0;
                let probability = |i: u32| f64::from(tree.probability(&at(p), i));
                let sum: f64 = (0..count).map(probability).sum();
                let tries = 20_000;
                let none = (0..tries).filter(|_| tree.choose(&at(p), numbers.pair()).is_none());
                let none = none.count() as f64 / f64::from(tries);
                let allowed = 5.0 * (none.max(1e-4) / f64::from(tries)).sqrt();
                assert!((sum + none - 1.0).abs() < allowed + 1e-5, "{count}: {sum} {none}");
            }
        }
    }

    #[test]
    fn an_emitter_is_always_selected_if_all_can_contribute() {
        let mut numbers = Numbers(2);
        let mut emitters = emitters(500, &mut numbers);
        emitters.iter_mut().for_each(|emitter| emitter.bounds.normals = Cone::ALL);
        let tree = LightTree::new(emitters, 500);
        for _ in 0..100 {
            let p = numbers.vector() * 20.0;
            let sum: f64 = (0..500).map(|i| f64::from(tree.probability(&at(p), i))).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        }
    }

    #[test]
    fn frequencies_equal_the_recomputed_probabilities() {
        let mut numbers = Numbers(3);
        let tree = LightTree::new(emitters(100, &mut numbers), 100);
        for round in 0..8 {
            let mut receiver = at(numbers.vector() * 12.0);
            if round % 2 == 1 {
                receiver.reception.lobe = lobe(&mut numbers);
            }
            let n = 1 << 18;
            let mut counts = [0.0; 100];
            for i in 0..n {
                let u = sample_2d(7, i, Dimension::LightChoice(0));
                let Some((emitter, probability)) = tree.choose(&receiver, u) else { continue };
                counts[emitter as usize] += 1.0;
                let again = tree.probability(&receiver, emitter);
                assert!((again / probability - 1.0).abs() < 1e-6, "{again} {probability}");
            }
            for (i, count) in (0..).zip(counts) {
                let expected = f64::from(tree.probability(&receiver, i)) * f64::from(n);
                // An emitter is a rectangle of the unit square. A (0, 18, 2)-net in base 2 has at
                // most 18 / 3 + 19 / 9 points too many or too few in a rectangle at a corner
                // (Niederreiter 1987), and four times as many in any rectangle.
                assert!((count - expected).abs() <= 33.0, "{i}: {count} of {expected}");
            }
        }
    }

    #[test]
    fn every_emitter_that_contributes_has_a_nonzero_probability() {
        let mut numbers = Numbers(4);
        let emitters = emitters(300, &mut numbers);
        let tree = LightTree::new(emitters.clone(), 300);
        for i in 0..400 {
            let p = numbers.vector() * 15.0;
            let mut receiver = at(p);
            if i % 2 == 1 {
                receiver.reception.lobe = lobe(&mut numbers);
            }
            for Emitter { bounds, index } in &emitters {
                let point = bounds.low + (bounds.high - bounds.low) * numbers.vector().abs();
                let towards = (p - point).normalize();
                let cos = towards.dot(bounds.normals.axis);
                let all_directions = bounds.normals.angle > 0.0 || bounds.two_sided;
                if all_directions || cos > 0.0 {
                    assert!(tree.probability(&receiver, *index) > 0.0, "{p} {bounds:?}");
                }
            }
        }
    }
}
