//! Collapse of a binary hierarchy into nodes of eight children. The binary nodes to keep are those
//! that minimize the expected cost of a ray (Ylitie, Karras & Laine 2017, "Efficient incoherent ray
//! traversal on GPUs through compressed wide BVHs", 3.1).

use super::build::{BinaryBvh, BinaryNode};
use super::primitives::PacketKind;
use super::{
    Bvh, Child, CurvePacket, Node, PackedChild, PatchPacket, PrimitiveGroup, PrimitiveId,
    PrimitiveIds, PrimitiveList, TrianglePacket,
};
use crate::geometry::PieceBounds;

/// Cost of a test of eight boxes over that of eight triangles, measured on the benches' scenes.
const NODE_COST: f32 = 1.5;

/// Least costs of a binary node that is represented by at most 1, 2, ... 8 children of a wide
/// node, and the decisions that lead to them.
#[derive(Clone, Copy)]
struct NodeCost {
    cost: [f32; 8],
    decision: [Decision; 8],
    /// Kind and number of the primitives below, if they fit into one packet.
    packet: Option<(PacketKind, u8)>,
}

/// Representation of a binary node by at most a given number of children.
#[derive(Clone, Copy, PartialEq)]
enum Decision {
    /// The node itself, as a leaf.
    Leaf,
    /// The node itself, as a wide node with up to eight children.
    Internal,
    /// The same as with one child fewer.
    Fewer,
    /// This many children from its left side, the rest from its right.
    Distribute(u8),
}

/// Collapses a binary hierarchy.
pub(super) fn collapse(binary: &BinaryBvh, primitives: &PrimitiveList) -> Bvh {
    let decisions = decide(binary, primitives);
    let mut collapse = Collapse {
        primitives,
        binary,
        decisions,
        bvh: Bvh { bounds: Some(binary.bounds(0)), nodes: Vec::new(), ..Bvh::default() },
    };
    collapse.run();
    let bvh = &mut collapse.bvh;
    bvh.nodes.shrink_to_fit();
    bvh.packets.shrink_to_fit();
    bvh.primitive_ids.shrink_to_fit();
    bvh.patches.shrink_to_fit();
    bvh.curves.shrink_to_fit();
    collapse.bvh
}

/// Returns the best decisions for every binary node, found from the leaves up.
fn decide(binary: &BinaryBvh, primitives: &PrimitiveList) -> Vec<[Decision; 8]> {
    let mut decisions = vec![[Decision::Leaf; 8]; binary.len()];
    let mut todo = vec![(0, false)];
    let mut done: Vec<NodeCost> = Vec::new();
    while let Some((node, children_done)) = todo.pop() {
        let best = match binary.node(node) {
            BinaryNode::Leaf(primitive) => NodeCost {
                cost: [binary.area(node); 8],
                decision: LEAF,
                packet: primitives.packet_kind(primitive).map(|kind| (kind, 1)),
            },
            BinaryNode::Inner([left, right]) => {
                if !children_done {
                    todo.extend([(node, true), (right, false), (left, false)]);
                    continue;
                }
                let (Some(right), Some(left)) = (done.pop(), done.pop()) else { break };
                combine(&left, &right, binary.area(node))
            }
        };
        decisions[node] = best.decision;
        done.push(best);
    }
    decisions
}

/// Decisions for a node that holds one primitive.
const LEAF: [Decision; 8] = {
    let mut decision = [Decision::Fewer; 8];
    decision[0] = Decision::Leaf;
    decision
};

/// Returns the least costs of a node from those of its two children.
fn combine(left: &NodeCost, right: &NodeCost, area: f32) -> NodeCost {
    let packet = match (left.packet, right.packet) {
        (Some((kind, a)), Some((other, b))) if kind == other && a + b <= 8 => Some((kind, a + b)),
        _ => None,
    };
    let mut best = NodeCost { cost: [0.0; 8], decision: [Decision::Internal; 8], packet };
    for children in 2..=8 {
        let (mut cost, mut from_left) = (left.cost[0] + right.cost[children - 2], 1);
        for k in 2..children {
            let other = left.cost[k - 1] + right.cost[children - k - 1];
            if other < cost {
                (cost, from_left) = (other, k);
            }
        }
        best.cost[children - 1] = cost;
        best.decision[children - 1] = Decision::Distribute(from_left as u8);
    }
    best.cost[0] = best.cost[7] + area * NODE_COST;
    if packet.is_some() && area <= best.cost[0] {
        (best.cost[0], best.decision[0]) = (area, Decision::Leaf);
    }
    // The last entry is the contents of the wide node and must not fall back on the node itself.
    for i in 1..7 {
        if best.cost[i - 1] <= best.cost[i] {
            (best.cost[i], best.decision[i]) = (best.cost[i - 1], Decision::Fewer);
        }
    }
    best
}

struct Collapse<'a> {
    primitives: &'a PrimitiveList<'a>,
    binary: &'a BinaryBvh,
    decisions: Vec<[Decision; 8]>,
    bvh: Bvh,
}

impl Collapse<'_> {
    fn run(&mut self) {
        // (binary node, index of its wide node, depth of the wide node)
        let mut todo = vec![(0usize, self.empty_node(), 1)];
        let mut deepest = 1;
        while let Some((from, to, depth)) = todo.pop() {
            deepest = deepest.max(depth);
            for (slot, binary) in self.collect_children(from).into_iter().enumerate() {
                let child = match (self.decisions[binary][0], self.binary.node(binary)) {
                    (Decision::Leaf, contents) => self.leaf(binary, contents),
                    _ => {
                        let wide = self.empty_node();
                        todo.push((binary, wide, depth + 1));
                        Child::Node(wide as u32)
                    }
                };
                let [low, high] = self.binary.bounds(binary);
                let wide = &mut self.bvh.nodes[to];
                for axis in 0..3 {
                    wide.bounds[axis][0][slot] = low[axis];
                    wide.bounds[axis][1][slot] = high[axis];
                }
                wide.children[slot] = PackedChild::pack(child);
            }
        }
        // All children but one of each node on the path wait, and all of the last node.
        self.bvh.stack_size = 7 * deepest + 1;
    }

    fn empty_node(&mut self) -> usize {
        self.bvh.nodes.push(Node::EMPTY);
        self.bvh.nodes.len() - 1
    }

    /// Returns the binary nodes that become the children of a wide node.
    fn collect_children(&self, from: usize) -> Vec<usize> {
        let mut children = Vec::with_capacity(8);
        // A root that is a leaf becomes the only child of the only wide node.
        let mut todo = match self.binary.node(from) {
            BinaryNode::Inner(_) if self.decisions[from][0] != Decision::Leaf => vec![(from, 8)],
            _ => vec![(from, 1)],
        };
        while let Some((node, mut most)) = todo.pop() {
            let decisions = &self.decisions[node];
            while decisions[most - 1] == Decision::Fewer {
                most -= 1;
            }
            match (decisions[most - 1], self.binary.node(node)) {
                (Decision::Distribute(k), BinaryNode::Inner([left, right])) => {
                    let k = usize::from(k);
                    todo.extend([(right, most - k), (left, k)]);
                }
                _ => children.push(node),
            }
        }
        children
    }

    /// Returns the child for a binary node that becomes a leaf.
    fn leaf(&mut self, binary: usize, contents: BinaryNode) -> Child {
        if let BinaryNode::Leaf(primitive) = contents {
            match *self.primitives.locate(primitive).0 {
                PrimitiveGroup::Quadric(quadric, _) => return Child::Quadric(quadric),
                PrimitiveGroup::Instance(instance, _) => return Child::Instance(instance),
                PrimitiveGroup::Mesh { .. }
                | PrimitiveGroup::Patches { .. }
                | PrimitiveGroup::Curves { .. } => {}
            }
        }
        match self.first_kind(binary) {
            Some(PacketKind::Patches) => {
                self.pack_patches(binary);
                return Child::Patches(self.bvh.patches.len() as u32 - 1);
            }
            Some(PacketKind::Curves) => {
                let packet = self.pack_curves(binary);
                self.bvh.curves.push(packet);
                return Child::Curves(self.bvh.curves.len() as u32 - 1);
            }
            Some(PacketKind::Triangles) | None => {}
        }
        let packet = self.bvh.packets.len() as u32;
        if self.pack_triangles(binary) {
            Child::AlphaTestedTriangles(packet)
        } else {
            Child::Triangles(packet)
        }
    }

    /// Returns the packet kind of the first primitive below a binary node.
    fn first_kind(&self, mut node: usize) -> Option<PacketKind> {
        loop {
            match self.binary.node(node) {
                BinaryNode::Inner([left, _]) => node = left,
                BinaryNode::Leaf(primitive) => return self.primitives.packet_kind(primitive),
            }
        }
    }

    /// Returns the primitives below a binary node.
    fn primitives_below(&self, binary: usize) -> impl Iterator<Item = usize> + use<'_> {
        let mut todo = vec![binary];
        std::iter::from_fn(move || {
            loop {
                match self.binary.node(todo.pop()?) {
                    BinaryNode::Inner(children) => todo.extend(children),
                    BinaryNode::Leaf(primitive) => return Some(primitive),
                }
            }
        })
    }

    /// Packs the triangles below a binary node. Returns whether any needs an alpha test.
    fn pack_triangles(&mut self, binary: usize) -> bool {
        let mut packet = TrianglePacket { corners: [[[f32::NAN; 8]; 3]; 3] };
        let mut ids = PrimitiveIds([PrimitiveId::default(); 8]);
        let mut any_alpha = false;
        for (slot, primitive) in self.primitives_below(binary).enumerate() {
            let (&PrimitiveGroup::Mesh { shape, mesh, alpha_tested }, triangle) =
                self.primitives.locate(primitive)
            else {
                unreachable!("packets of triangles hold nothing else")
            };
            for (corner, p) in mesh.corners(triangle).iter().enumerate() {
                for axis in 0..3 {
                    packet.corners[corner][axis][slot] = p[axis];
                }
            }
            ids.0[slot] = PrimitiveId { shape, triangle };
            any_alpha |= alpha_tested;
        }
        self.bvh.packets.push(packet);
        self.bvh.primitive_ids.push(ids);
        any_alpha
    }

    /// Packs the patches below a binary node.
    fn pack_patches(&mut self, binary: usize) {
        let ids = PrimitiveIds([PrimitiveId::default(); 8]);
        let corners = [[[f32::NAN; 8]; 3]; 4];
        let mut packet = PatchPacket { corners, ids, alpha_tested: false };
        for (slot, primitive) in self.primitives_below(binary).enumerate() {
            let (&PrimitiveGroup::Patches { shape, patches, alpha_tested }, patch) =
                self.primitives.locate(primitive)
            else {
                unreachable!("packets of patches hold nothing else")
            };
            for (corner, p) in patches.corners(patch).iter().enumerate() {
                for axis in 0..3 {
                    packet.corners[corner][axis][slot] = p[axis];
                }
            }
            packet.ids.0[slot] = PrimitiveId { shape, triangle: patch };
            packet.alpha_tested |= alpha_tested;
        }
        self.bvh.patches.push(packet);
    }
    /// Packs the pieces of curves below a binary node.
    fn pack_curves(&self, binary: usize) -> CurvePacket {
        let mut packet = CurvePacket {
            start: [[f32::NAN; 8]; 3],
            chord: [[f32::NAN; 8]; 3],
            radius: [f32::NAN; 8],
            ids: PrimitiveIds([PrimitiveId::default(); 8]),
            parts: [[0, 1]; 8],
            alpha_tested: false,
        };
        for (slot, primitive) in self.primitives_below(binary).enumerate() {
            let (&PrimitiveGroup::Curves { shape, curves, alpha_tested }, number) =
                self.primitives.locate(primitive)
            else {
                unreachable!("packets of curves hold nothing else")
            };
            let piece = curves.piece(number);
            let PieceBounds { ends: [start, end], radius, .. } = curves.piece_bounds(piece);
            let chord = end - start;
            for axis in 0..3 {
                packet.start[axis][slot] = start[axis] as f32;
                packet.chord[axis][slot] = chord[axis] as f32;
            }
            packet.radius[slot] = (radius as f32).next_up();
            packet.ids.0[slot] = PrimitiveId { shape, triangle: piece.segment };
            packet.parts[slot] = [piece.part, piece.parts];
            packet.alpha_tested |= alpha_tested;
        }
        packet
    }
}
