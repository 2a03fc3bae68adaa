//! Binary hierarchy: a clustering of boxes, improved by reinsertion by the `obvhs` crate (Meister &
//! Bittner 2018, "Parallel reinsertion for bounding volume hierarchy optimization"). Only this file and
//! the clustering use the crate.

use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;

use super::ploc::{Clustering, cluster};
use super::{Bvh, PrimitiveList, collapse};

/// Share of the nodes that are candidates for reinsertion. Against 0.05, rays take 5 to 15 % less time, and
/// the build of a million triangles 0.4 s more on one core; the whole set gains no more.
const REINSERTED: f32 = 0.2;
/// The share if most primitives are pieces of curves. Their boxes overlap so much that a search takes long
/// and finds little: a share of 0.2 doubles the CPU time of the build, and rays are no faster.
const REINSERTED_CURVES: f32 = 0.05;

impl Bvh {
    /// Builds the hierarchy over the primitives that have finite bounds.
    pub(crate) fn new(primitives: PrimitiveList) -> Self {
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
        let tree = binary_tree(&boxes, if hairy { REINSERTED_CURVES } else { REINSERTED });
        Some(Self { tree, included })
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

/// Returns the tree of boxes, with two rounds of reinsertion of this share of its nodes.
fn binary_tree(boxes: &[Aabb], reinserted: f32) -> Bvh2 {
    let Clustering { mut tree, degenerate } = cluster(boxes);
    // Nodes of equal boxes gain nothing elsewhere, and each search for a place may visit most of them.
    if !degenerate {
        let mut optimizer = ReinsertionOptimizer::default();
        for _ in 0..2 {
            optimizer.run(&mut tree, reinserted, None);
        }
    }
    tree
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use glam::Vec3A;
    use obvhs::BvhBuildParams;
    use obvhs::bvh2::builder::build_bvh2;

    use super::super::primitives::PrimitiveGroup;
    use super::*;
    use crate::geometry::Mesh;
    use petzval_base::sampler::hash;

    fn random(i: u32, axis: u32) -> f32 {
        hash(8 * i + axis) as f32 / u32::MAX as f32
    }

    /// Boxes of sizes that differ, some flat or equal, at random places.
    fn scattered(count: u32) -> Vec<Aabb> {
        let one = |i: u32| {
            let low = Vec3A::from_array([0, 1, 2].map(|axis| 9.0 * random(i / 2, axis)));
            let size =
                Vec3A::from_array([3, 4, 5].map(|axis| random(i / (1 + i % 2), axis).powi(3)));
            Aabb::new(low, low + if i.is_multiple_of(5) { size * Vec3A::X } else { size })
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn trees_are_those_of_the_crate_of_reinsertion() {
        for count in [1, 2, 3, 17, 300, 5000, 20_000] {
            let boxes = scattered(count);
            for reinserted in [REINSERTED, REINSERTED_CURVES] {
                let params = BvhBuildParams {
                    max_prims_per_leaf: 1,
                    reinsertion_batch_ratio: reinserted,
                    post_collapse_reinsertion_batch_ratio_multiplier: 1.0,
                    ..BvhBuildParams::medium_build()
                };
                let expected = build_bvh2(&boxes, params, &mut Duration::default());
                let found = binary_tree(&boxes, reinserted);
                let nodes = |tree: &Bvh2| -> Vec<_> {
                    let node = |node: &obvhs::bvh2::node::Bvh2Node| {
                        let aabb = node.aabb();
                        let bounds = [aabb.min, aabb.max].map(|corner| corner.to_array());
                        (bounds, node.prim_count, node.first_index)
                    };
                    tree.nodes.iter().map(node).collect()
                };
                assert!(nodes(&found) == nodes(&expected), "{count} boxes");
                assert_eq!(found.primitive_indices, expected.primitive_indices);
            }
        }
    }

    #[test]
    fn triangles_without_an_area_are_in_no_tree() {
        let mut mesh = Mesh {
            positions: vec![
                [0.0; 3],
                [1.0, 0.0, 0.0],
                [0.1, 0.7, 0.0],
                [0.2, 1.4, 0.0],
                [1e-30; 3],
            ],
            triangles: vec![[0; 3], [0, 1, 1], [0, 2, 3]],
            ..Mesh::default()
        };
        let included = |mesh: &Mesh| {
            let mut list = PrimitiveList::default();
            list.push(PrimitiveGroup::Mesh { shape: 0, mesh, alpha_tested: false });
            BinaryBvh::new(&list).map(|tree| tree.included)
        };
        assert_eq!(included(&mesh), None);
        mesh.triangles.extend([[0, 1, 2], [0, 1, 4], [1; 3]]);
        assert_eq!(included(&mesh), Some(Some(vec![3, 4])));
        mesh.triangles.retain(|triangle| [[0, 1, 2], [0, 1, 4]].contains(triangle));
        assert_eq!(included(&mesh), Some(None));
    }

    /// Returns the depth of a tree, and the number of its leaves.
    fn depth_and_leaves(tree: &Bvh2) -> [usize; 2] {
        let (mut deepest, mut leaves) = (0, vec![false; tree.primitive_indices.len()]);
        let mut todo = vec![(0usize, 1)];
        while let Some((node, depth)) = todo.pop() {
            deepest = deepest.max(depth);
            let node = &tree.nodes[node];
            let first = node.first_index as usize;
            match node.is_leaf() {
                true => leaves[tree.primitive_indices[first] as usize] = true,
                false => todo.extend([(first, depth + 1), (first + 1, depth + 1)]),
            }
        }
        [deepest, leaves.iter().filter(|leaf| **leaf).count()]
    }

    /// Each of them took a time that grew with the square of the number: 40,000 equal boxes took 78 s.
    #[test]
    fn boxes_in_one_place_take_the_time_of_others() {
        const COUNT: u32 = 40_000;
        let cube = |side: f32| Aabb::new(Vec3A::splat(-side), Vec3A::splat(side));
        let all = |one: &dyn Fn(u32) -> Aabb| (0..COUNT).map(one).collect::<Vec<_>>();
        let on_circle = |i: u32| {
            let angle = std::f32::consts::TAU * i as f32 / COUNT as f32;
            Vec3A::new(angle.cos(), angle.sin(), 0.0)
        };
        let near = |i: u32, first: u32, most: f32| {
            most * Vec3A::from_array([0, 1, 2].map(|axis| random(i, first + axis)))
        };
        let equal = all(&|_| cube(1.0));
        let (mut half, rest) = (scattered(COUNT / 2), &equal[..COUNT as usize / 2]);
        half.extend(rest);
        for (name, boxes) in [
            ("equal", equal),
            ("points", all(&|_| cube(0.0))),
            ("nested", all(&|i| cube(1.0 + i as f32))),
            ("nested pairs", all(&|i| cube(1.0 + (i / 2) as f32))),
            ("from one corner", all(&|i| Aabb::new(Vec3A::ZERO, Vec3A::new(i as f32, 1.0, 1.0)))),
            ("a fan", all(&|i| Aabb::from_points(&[0, i, i + 1].map(on_circle)))),
            ("nearly equal", all(&|i| Aabb::new(near(i, 0, 1e-6) - 1.0, near(i, 3, 1e-6) + 1.0))),
            ("overlapping", all(&|i| Aabb::new(near(i, 0, 0.1) - 1.0, near(i, 3, 0.1) + 1.0))),
            (
                "in twenty places",
                all(&|i| {
                    let low = near(i / 2000, 0, 9.0);
                    Aabb::new(low, low + 1.0)
                }),
            ),
            ("half of them equal", half),
        ] {
            let start = Instant::now();
            let tree = binary_tree(&boxes, REINSERTED);
            let [depth, leaves] = depth_and_leaves(&tree);
            assert!(start.elapsed() < Duration::from_secs(20), "{name}: {:?}", start.elapsed());
            assert!(leaves == boxes.len() && depth < 300, "{name}: {leaves} leaves, {depth} deep");
        }
    }
}
