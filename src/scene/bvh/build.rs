//! Binary hierarchy built by the `obvhs` crate: PLOC (Meister & Bittner 2018), improved by
//! reinsertion (Meister & Bittner 2018, "Parallel reinsertion for bounding volume hierarchy
//! optimization"). No other file uses the crate.

use std::time::Duration;

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::{Bvh, PrimitiveList, collapse};

/// Share of the nodes that are candidates for reinsertion. Against 0.05, rays take 5 to 15 % less time, and
/// the build of a million triangles 0.4 s more on one core; the whole set gains no more.
const REINSERTED: f32 = 0.2;
/// The share if most primitives are pieces of curves. Their boxes overlap so much that a search takes long
/// and finds little: a share of 0.2 doubles the CPU time of the build, and rays are no faster.
const REINSERTED_CURVES: f32 = 0.05;

impl Bvh {
    /// Builds the hierarchy over the primitives that have finite bounds.
    pub(in crate::scene) fn new(primitives: PrimitiveList) -> Self {
        match BinaryBvh::new(&primitives) {
            Some(binary) => {
                let bvh = collapse::collapse(&binary, &primitives);
                Self { quadrics: primitives.quadrics, ..bvh }
            }
            None => Self::default(),
        }
    }
}

/// A binary hierarchy; node 0 is its root.
pub(super) struct BinaryBvh {
    tree: Bvh2,
    /// Indices of the primitives in the tree; `None` if it holds all of the list.
    included: Option<Vec<u32>>,
}

/// Contents of a binary node.
pub(super) enum BinaryNode {
    /// Indices of its two children.
    Inner([usize; 2]),
    /// Index of its only primitive.
    Leaf(usize),
}

impl BinaryBvh {
    fn new(primitives: &PrimitiveList) -> Option<Self> {
        let bounds = || primitives.finite_bounds();
        let mut boxes = Vec::with_capacity(primitives.len());
        boxes.extend(bounds().map(|(_, [low, high])| Aabb::new(low.into(), high.into())));
        let included = (boxes.len() < primitives.len()).then(|| bounds().map(|(i, _)| i).collect());
        if boxes.is_empty() {
            return None;
        }
        let hairy = primitives.curve_piece_count() > boxes.len() / 2;
        let params = BvhBuildParams {
            max_prims_per_leaf: 1,
            reinsertion_batch_ratio: if hairy { REINSERTED_CURVES } else { REINSERTED },
            post_collapse_reinsertion_batch_ratio_multiplier: 1.0,
            ..BvhBuildParams::medium_build()
        };
        Some(Self { tree: build_bvh2(&boxes, params, &mut Duration::default()), included })
    }

    /// Returns the contents of a node.
    pub(super) fn node(&self, node: usize) -> BinaryNode {
        let node = &self.tree.nodes[node];
        let first = node.first_index as usize;
        if !node.is_leaf() {
            return BinaryNode::Inner([first, first + 1]);
        }
        let primitive = self.tree.primitive_indices[first];
        let included = self.included.as_ref();
        BinaryNode::Leaf(included.map_or(primitive, |list| list[primitive as usize]) as usize)
    }

    /// Returns the lowest and highest corner of a node.
    pub(super) fn bounds(&self, node: usize) -> [Vec3; 2] {
        let bounds = &self.tree.nodes[node].aabb;
        [bounds.min.into(), bounds.max.into()]
    }

    /// Returns half the surface area of a node's box.
    pub(super) fn area(&self, node: usize) -> f32 {
        self.tree.nodes[node].aabb.half_area()
    }

    /// Returns the number of nodes.
    pub(super) fn len(&self) -> usize {
        self.tree.nodes.len()
    }
}
