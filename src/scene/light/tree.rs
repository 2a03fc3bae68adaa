//! The light tree: which of many emitters, for a point, with a probability that follows what
//! each may contribute (Conty Estevez & Kulla 2018, "Importance sampling of many lights with
//! adaptive tree splitting"; Pharr, Jakob & Humphreys, "Physically Based Rendering", 12.6.3).
//!
//! It looks at the position of the point only, so that the probability can be found again when
//! a ray runs into an emitter by itself.

use std::ops::Range;

use glam::Vec3;

use super::bounds::{Bounds, Groups, Part};
use super::split::split;

/// Something that is chosen as a whole: a triangle, a quadric, a lamp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Emitter {
    pub(super) bounds: Bounds,
    /// Its number.
    pub(super) index: u32,
}

/// A tree over emitters, eight branches from every node.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    /// The root first; none where there is nothing to choose.
    nodes: Vec<Groups>,
    /// Where every emitter hangs, by its number: eight times the place of its node and which
    /// of eight it is; [`NOWHERE`] for those that are not in the tree.
    places: Vec<u32>,
}

const NOWHERE: u32 = u32::MAX;
/// The most times in a row that a group is divided where it seems best.
const DEEPEST: u32 = 60;

/// A group that may be divided further.
#[derive(Clone)]
struct Branch {
    emitters: Range<usize>,
    divided: u32,
}

impl LightTree {
    /// Builds the tree over emitters whose numbers are below `count`.
    pub(super) fn new(mut emitters: Vec<Emitter>, count: usize) -> Self {
        let mut tree = Self { nodes: Vec::new(), places: vec![NOWHERE; count] };
        if !emitters.is_empty() {
            let all = Branch { emitters: 0..emitters.len(), divided: 0 };
            tree.grow(&mut emitters, all);
        }
        tree
    }

    /// Whether there is nothing to choose.
    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Adds a node for a group, and all below it; answers its place and bounds.
    fn grow(&mut self, emitters: &mut [Emitter], whole: Branch) -> (u32, Bounds) {
        let node = self.nodes.len();
        self.nodes.push(Groups::EMPTY);
        let mut branches = vec![whole];
        while branches.len() < 8 {
            let size = |branch: &Branch| branch.emitters.len();
            let Some(i) = (0..branches.len()).max_by_key(|&i| size(&branches[i])) else { break };
            let Range { start, end } = branches[i].emitters.clone();
            if end - start < 2 {
                break;
            }
            // Lights ever closer together would make a tree as deep as there are lights.
            let divided = branches[i].divided + 1;
            let middle = start + split(&mut emitters[start..end], divided > DEEPEST);
            branches[i] = Branch { emitters: start..middle, divided };
            branches.push(Branch { emitters: middle..end, divided });
        }
        let mut sum: Option<Bounds> = None;
        for (i, branch) in branches.into_iter().enumerate() {
            let place = (node * 8 + i) as u32;
            let (bounds, part) = if branch.emitters.len() == 1 {
                let emitter = &emitters[branch.emitters.start];
                self.places[emitter.index as usize] = place;
                (emitter.bounds, Part::Emitter(emitter.index))
            } else {
                let (child, bounds) = self.grow(emitters, branch);
                self.nodes[child as usize].parent = place;
                (bounds, Part::Groups(child))
            };
            self.nodes[node].set(i, &bounds, part);
            sum = Some(sum.map_or(bounds, |sum| sum.with(bounds)));
        }
        let bounds = sum.unwrap_or_else(|| emitters[0].bounds);
        (node as u32, bounds)
    }

    /// Chooses an emitter for a point: its number and the probability of the choice. `None`
    /// where what is left cannot contribute.
    pub(super) fn choose(&self, p: Vec3, mut u: f64) -> Option<(u32, f32)> {
        let mut node = self.nodes.first()?;
        let mut probability = 1.0;
        loop {
            let importance = node.importance(p).map(f64::from);
            let sum: f64 = importance.iter().sum();
            if !(sum > 0.0 && sum.is_finite()) {
                return None;
            }
            let mut rest = u * sum;
            let mut chosen = 0;
            for i in 0..8 {
                // Rounding may leave something at the end: the last that has a share takes it.
                if importance[i] > 0.0 {
                    chosen = i;
                    if rest < importance[i] {
                        break;
                    }
                    rest -= importance[i];
                }
            }
            u = (rest / importance[chosen]).min(1.0 - f64::EPSILON);
            probability *= importance[chosen] / sum;
            match node.part(chosen) {
                Part::Emitter(index) => return Some((index, probability as f32)),
                Part::Groups(place) => node = &self.nodes[place as usize],
            }
        }
    }

    /// The probability with which [`Self::choose`] chooses an emitter for a point.
    pub(super) fn probability(&self, p: Vec3, emitter: u32) -> f32 {
        let mut place = self.places[emitter as usize];
        if place == NOWHERE {
            return 0.0;
        }
        let mut probability = 1.0;
        loop {
            let node = &self.nodes[place as usize / 8];
            let importance = node.importance(p).map(f64::from);
            let sum: f64 = importance.iter().sum();
            let one = importance[place as usize % 8];
            if !(one > 0.0 && sum.is_finite()) {
                return 0.0;
            }
            probability *= one / sum;
            if place < 8 {
                return probability as f32;
            }
            place = node.parent;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::cone::Cone;
    use super::*;

    /// Uniform numbers in [0, 1): Lehmer's generator.
    struct Numbers(u64);

    impl Numbers {
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
            let bounds = Bounds { low, high, normals, cos_beyond: 0.0, intensity, two_sided };
            emitters.push(Emitter { bounds, index });
        }
        emitters
    }

    #[test]
    fn probabilities_of_all_emitters_and_of_none_add_up_to_one() {
        let mut numbers = Numbers(1);
        for count in [1, 2, 3, 17, 1000] {
            let emitters = emitters(count, &mut numbers);
            let tree = LightTree::new(emitters.clone(), count as usize);
            for _ in 0..20 {
                let p = numbers.vector() * 20.0;
                let of = |i: u32| f64::from(tree.probability(p, i));
                let sum: f64 = (0..count).map(of).sum();
                let tries = 20_000;
                let none = (0..tries).filter(|_| tree.choose(p, numbers.next()).is_none());
                let none = none.count() as f64 / f64::from(tries);
                let allowed = 5.0 * (none.max(1e-4) / f64::from(tries)).sqrt();
                assert!((sum + none - 1.0).abs() < allowed + 1e-5, "{count}: {sum} {none}");
            }
        }
    }

    #[test]
    fn where_every_emitter_contributes_one_is_always_chosen() {
        let mut numbers = Numbers(2);
        let mut emitters = emitters(500, &mut numbers);
        emitters.iter_mut().for_each(|emitter| emitter.bounds.normals = Cone::ALL);
        let tree = LightTree::new(emitters, 500);
        for _ in 0..100 {
            let p = numbers.vector() * 20.0;
            let sum: f64 = (0..500).map(|i| f64::from(tree.probability(p, i))).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        }
    }

    #[test]
    fn emitters_are_chosen_with_the_probability_that_is_found_again() {
        let mut numbers = Numbers(3);
        let tree = LightTree::new(emitters(100, &mut numbers), 100);
        for _ in 0..5 {
            let p = numbers.vector() * 12.0;
            let n = 200_000;
            let mut counts = [0.0; 100];
            for i in 0..n {
                let u = (f64::from(i) + numbers.next()) / f64::from(n);
                let Some((emitter, probability)) = tree.choose(p, u) else { continue };
                counts[emitter as usize] += 1.0;
                let again = tree.probability(p, emitter);
                assert!((again / probability - 1.0).abs() < 1e-6, "{again} {probability}");
            }
            for (i, count) in (0..).zip(counts) {
                let expected = f64::from(tree.probability(p, i)) * f64::from(n);
                // Evenly spread numbers: at most one too many or too few at either end.
                assert!((count - expected).abs() <= 2.0, "{i}: {count} instead of {expected}");
            }
        }
    }

    #[test]
    fn whatever_contributes_can_be_chosen() {
        let mut numbers = Numbers(4);
        let emitters = emitters(300, &mut numbers);
        let tree = LightTree::new(emitters.clone(), 300);
        for _ in 0..200 {
            let p = numbers.vector() * 15.0;
            for Emitter { bounds, index } in &emitters {
                let place = bounds.low + (bounds.high - bounds.low) * numbers.vector().abs();
                let towards = (p - place).normalize();
                let cos = towards.dot(bounds.normals.axis);
                let all = bounds.normals.angle > 0.0 || bounds.two_sided;
                if all || cos > 0.0 {
                    assert!(tree.probability(p, *index) > 0.0, "{p} {bounds:?}");
                }
            }
        }
    }
}
