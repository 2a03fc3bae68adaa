//! Random selection of lights for the points of a wave: all points descend the light tree together.

use std::ops::Range;

use super::Lights;
use super::sampler::{EmitterClass, LightChoice};
use super::stage::{LightColumns, LightInputs};
use super::tree::{Descent, LightChild, Receiver};
use petzval_base::lanes::{LaneIndices, Real};
use petzval_base::rays::SortedColumn;

/// Entries at a node of the tree.
#[derive(Clone, Debug)]
pub(super) struct Branch {
    node: u32,
    /// Range in [`Descents::entries`].
    range: Range<usize>,
}

/// Descents through the tree that have not ended.
#[derive(Clone, Debug, Default)]
pub(super) struct Descents {
    entries: Vec<u32>,
    sorted: Vec<u32>,
    /// Selected child by position in `entries`.
    children: Vec<u8>,
    branches: Vec<Branch>,
    u: [SortedColumn<f32>; 2],
    probability: SortedColumn<f32>,
}

/// Mark of an entry for which no child can contribute.
const NO_CHILD: u8 = 8;

impl Lights {
    /// Selects a light for every entry, and sorts the entries by the class of its emitter.
    pub(super) fn choose_all<R: Real<Scalar = f32>>(
        &self,
        inputs: &LightInputs,
        columns: &mut LightColumns,
    ) {
        columns.chosen.clear();
        let (tree, distant) = (self.tree(), self.distant_count());
        if let (0, Some(only)) = (distant, tree.only_emitter()) {
            let choice = self.emitter_choice(only, 1.0);
            inputs.entries.iter().for_each(|&at| columns.chosen.add(at, choice, self.class(only)));
            return;
        }
        let descents = &mut columns.descents;
        descents.entries.clear();
        for chunk in inputs.entries.chunks(R::LANES) {
            let lanes = LaneIndices::new::<R>(chunk);
            let (index, rest) = self.split(lanes.load::<R>(&inputs.choice[0][..]));
            lanes.store(rest, &mut descents.u[0][..]);
            lanes.store(lanes.load::<R>(&inputs.choice[1][..]), &mut descents.u[1][..]);
            let mut indices = [0.0; 8];
            index.store(&mut indices);
            for (&at, index) in chunk.iter().zip(indices) {
                if (index as usize) < distant {
                    let choice = self.distant_choice(index as usize);
                    columns.chosen.add(at, choice, EmitterClass::General);
                } else if tree.is_empty() {
                    columns.chosen.none.push(at);
                } else {
                    descents.probability[at as usize] = self.choice_probability();
                    descents.entries.push(at);
                }
            }
        }
        if descents.entries.is_empty() {
            return;
        }
        descents.branches.push(Branch { node: 0, range: 0..descents.entries.len() });
        while let Some(branch) = columns.descents.branches.pop() {
            self.descend::<R>(inputs, branch, columns);
        }
    }

    /// Selects the child of a node for all entries there.
    fn descend<R: Real<Scalar = f32>>(
        &self,
        inputs: &LightInputs,
        Branch { node, range }: Branch,
        columns: &mut LightColumns,
    ) {
        let LightColumns { descents, chosen } = columns;
        let node = self.tree().node(node);
        let Descents { entries, sorted, children, branches, u, probability } = descents;
        children.clear();
        let mut counts = [0; NO_CHILD as usize + 1];
        for chunk in entries[range.clone()].chunks(R::LANES) {
            let lanes = LaneIndices::new::<R>(chunk);
            let receiver = Receiver {
                position: inputs.surfaces.gather_positions(&lanes),
                reception: inputs.reception(&lanes),
            };
            let mut descent = Descent {
                u: [lanes.load(&u[0][..]), lanes.load(&u[1][..])],
                probability: lanes.load::<R>(&probability[..]),
            };
            let step = descent.step(node.len(), |i| node.importance_of(i, &receiver));
            lanes.store(descent.u[0], &mut u[0][..]);
            lanes.store(descent.u[1], &mut u[1][..]);
            lanes.store(descent.probability, &mut probability[..]);
            let (mut selected, some) = ([0.0; 8], R::bits(step.some));
            step.child.store(&mut selected);
            for lane in 0..chunk.len() {
                let child = if some >> lane & 1 == 1 { selected[lane] as u8 } else { NO_CHILD };
                counts[usize::from(child)] += 1;
                children.push(child);
            }
        }
        // Counting sort by child.
        let mut ends = [range.start; NO_CHILD as usize + 1];
        for i in 1..ends.len() {
            ends[i] = ends[i - 1] + counts[i - 1];
        }
        sorted.resize(entries.len(), 0);
        for (&at, &child) in entries[range.clone()].iter().zip(children.iter()) {
            let end = &mut ends[usize::from(child)];
            sorted[*end] = at;
            *end += 1;
        }
        entries[range.clone()].copy_from_slice(&sorted[range]);
        for child in 0..=usize::from(NO_CHILD) {
            let range = ends[child] - counts[child]..ends[child];
            if range.is_empty() {
                continue;
            }
            if child == usize::from(NO_CHILD) {
                chosen.none.extend(&entries[range]);
                continue;
            }
            match node.child(child) {
                LightChild::Node(node) => branches.push(Branch { node, range }),
                LightChild::Emitter(emitter) => {
                    let class = self.class(emitter);
                    for &at in &entries[range] {
                        let choice = self.emitter_choice(emitter, probability[at as usize]);
                        chosen.add(at, choice, class);
                    }
                }
            }
        }
    }
}

/// Selected lights, by the class of their emitters.
#[derive(Clone, Debug, Default)]
pub(super) struct ChosenLights {
    /// Entries and their lights, by class.
    pub(super) groups: [Vec<u32>; 4],
    /// Entries for which no light can contribute.
    pub(super) none: Vec<u32>,
    /// Index of the light.
    pub(super) light: SortedColumn<u32>,
    /// Index of its triangle if it is a mesh, otherwise 0.
    pub(super) primitive: SortedColumn<u32>,
    /// Probability of the selection.
    pub(super) probability: SortedColumn<f32>,
}

impl ChosenLights {
    /// Forgets all entries.
    pub(super) fn clear(&mut self) {
        self.groups.iter_mut().for_each(Vec::clear);
        self.none.clear();
    }

    /// Adds the light of an entry.
    #[inline(always)]
    pub(super) fn add(&mut self, at: u32, choice: LightChoice, class: EmitterClass) {
        self.groups[class as usize].push(at);
        let at = at as usize;
        self.light[at] = choice.light;
        self.primitive[at] = choice.primitive;
        self.probability[at] = choice.probability;
    }

    /// Returns the light of an entry.
    pub(super) fn choice(&self, at: usize) -> LightChoice {
        LightChoice {
            light: self.light[at],
            primitive: self.primitive[at],
            probability: self.probability[at],
        }
    }
}
