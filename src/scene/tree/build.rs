//! The binary tree that obvhs finds: PLOC (Meister & Bittner 2018) improved by reinsertion
//! (Meister & Bittner 2018, "Parallel reinsertion for bounding volume hierarchy optimization").
//! This is the only file that names the `obvhs` crate.

use std::time::Duration;

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::{Parts, Tree, collapse};

impl Tree {
    /// Builds the hierarchy.
    pub(in crate::scene) fn new(parts: &Parts) -> Self {
        match Binary::new(parts) {
            Some(binary) => collapse::collapse(&binary, parts),
            None => Self::default(),
        }
    }
}

/// A binary tree; node 0 is its root.
pub(super) struct Binary {
    tree: Bvh2,
    /// The items that are in the tree, where it is not simply all of them.
    items: Option<Vec<u32>>,
}

/// What a binary node is.
pub(super) enum Split {
    /// The two nodes below it.
    Nodes([usize; 2]),
    /// One item.
    Item(usize),
}

impl Binary {
    fn new(parts: &Parts) -> Option<Self> {
        let mut boxes = Vec::with_capacity(parts.len());
        boxes.extend(parts.boxes().map(|(_, [low, high])| Aabb::new(low.into(), high.into())));
        let items = (boxes.len() < parts.len()).then(|| parts.boxes().map(|(i, _)| i).collect());
        if boxes.is_empty() {
            return None;
        }
        let params = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
        Some(Self { tree: build_bvh2(&boxes, params, &mut Duration::default()), items })
    }

    /// What is below a node.
    pub(super) fn split(&self, node: usize) -> Split {
        let node = &self.tree.nodes[node];
        let first = node.first_index as usize;
        if !node.is_leaf() {
            return Split::Nodes([first, first + 1]);
        }
        let item = self.tree.primitive_indices[first];
        Split::Item(self.items.as_ref().map_or(item, |items| items[item as usize]) as usize)
    }

    /// Lowest and highest corner of a node.
    pub(super) fn bounds(&self, node: usize) -> [Vec3; 2] {
        let bounds = &self.tree.nodes[node].aabb;
        [bounds.min.into(), bounds.max.into()]
    }

    /// Half the area of a node's box.
    pub(super) fn area(&self, node: usize) -> f32 {
        self.tree.nodes[node].aabb.half_area()
    }

    /// How many nodes there are.
    pub(super) fn len(&self) -> usize {
        self.tree.nodes.len()
    }
}
