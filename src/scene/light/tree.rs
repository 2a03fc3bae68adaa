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
                assert_eq!(probability, tree.probability(p, emitter));
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
