//! From a binary tree to nodes of eight: which binary nodes disappear is chosen so that the
//! expected cost of a ray is least (Ylitie, Karras & Laine 2017, "Efficient incoherent ray
//! traversal on GPUs through compressed wide BVHs", 3.1).

use super::build::{Binary, Split};
use super::{Child, Code, Names, Node, Packet, Part, Parts, Tree};

/// What it costs to meet eight boxes, in units of what it costs to meet eight triangles:
/// measured on the benches' scenes.
const NODE_COST: f32 = 1.5;

/// How a binary node is best represented by at most 1, 2, ... 8 children of a wide node: the
/// cost, and the choice that leads to it.
#[derive(Clone, Copy)]
struct Best {
    cost: [f32; 8],
    choice: [Choice; 8],
    /// Triangles below, if that is all there is and they fit into a packet; 0 otherwise.
    triangles: u8,
}

/// How a binary node is represented by at most so many children.
#[derive(Clone, Copy, PartialEq)]
enum Choice {
    /// By itself, as a leaf.
    Leaf,
    /// By itself, as a wide node over up to eight.
    Wide,
    /// As it would be by one child fewer.
    Fewer,
    /// By this many of its left side, and the rest of its right.
    Split(u8),
}

/// Collapses a binary tree.
pub(super) fn collapse(binary: &Binary, parts: &Parts) -> Tree {
    let choices = choose(binary, parts);
    let mut collapse = Collapse {
        parts,
        binary,
        choices,
        tree: Tree { bounds: Some(binary.bounds(0)), nodes: Vec::new(), ..Tree::default() },
    };
    collapse.run();
    let tree = &mut collapse.tree;
    tree.nodes.shrink_to_fit();
    tree.packets.shrink_to_fit();
    tree.names.shrink_to_fit();
    collapse.tree
}

/// The best choices of every binary node, found from the leaves up.
fn choose(binary: &Binary, parts: &Parts) -> Vec<[Choice; 8]> {
    let mut choices = vec![[Choice::Leaf; 8]; binary.len()];
    let mut todo = vec![(0, false)];
    let mut done: Vec<Best> = Vec::new();
    while let Some((node, below)) = todo.pop() {
        let best = match binary.split(node) {
            Split::Item(item) => Best {
                cost: [binary.area(node); 8],
                choice: LEAF,
                triangles: u8::from(parts.is_triangle(item)),
            },
            Split::Nodes([left, right]) => {
                if !below {
                    todo.extend([(node, true), (right, false), (left, false)]);
                    continue;
                }
                let (Some(right), Some(left)) = (done.pop(), done.pop()) else { break };
                join(&left, &right, binary.area(node))
            }
        };
        choices[node] = best.choice;
        done.push(best);
    }
    choices
}

const LEAF: [Choice; 8] = {
    let mut choice = [Choice::Fewer; 8];
    choice[0] = Choice::Leaf;
    choice
};

/// The best choices of a node by those of the two below it.
fn join(left: &Best, right: &Best, area: f32) -> Best {
    let triangles = match (left.triangles, right.triangles) {
        (0, _) | (_, 0) => 0,
        (a, b) if a + b <= 8 => a + b,
        _ => 0,
    };
    let mut best = Best { cost: [0.0; 8], choice: [Choice::Wide; 8], triangles };
    for children in 2..=8 {
        let (mut cost, mut choice) = (left.cost[0] + right.cost[children - 2], 1);
        for k in 2..children {
            let other = left.cost[k - 1] + right.cost[children - k - 1];
            if other < cost {
                (cost, choice) = (other, k);
            }
        }
        best.cost[children - 1] = cost;
        best.choice[children - 1] = Choice::Split(choice as u8);
    }
    best.cost[0] = best.cost[7] + area * NODE_COST;
    if triangles > 0 && area <= best.cost[0] {
        (best.cost[0], best.choice[0]) = (area, Choice::Leaf);
    }
    // The last is what a wide node holds: it may not fall back on the node itself.
    for i in 1..7 {
        if best.cost[i - 1] <= best.cost[i] {
            (best.cost[i], best.choice[i]) = (best.cost[i - 1], Choice::Fewer);
        }
    }
    best
}

struct Collapse<'a> {
    parts: &'a Parts<'a>,
    binary: &'a Binary,
    choices: Vec<[Choice; 8]>,
    tree: Tree,
}

impl Collapse<'_> {
    fn run(&mut self) {
        // (binary node, where its wide node stands, how deep that is)
        let mut todo = vec![(0usize, self.empty_node(), 1)];
        let mut deepest = 1;
        while let Some((from, to, depth)) = todo.pop() {
            deepest = deepest.max(depth);
            for (slot, binary) in self.gather(from).into_iter().enumerate() {
                let child = match (self.choices[binary][0], self.binary.split(binary)) {
                    (Choice::Leaf, split) => self.leaf(binary, split),
                    _ => {
                        let wide = self.empty_node();
                        todo.push((binary, wide, depth + 1));
                        Child::Node(wide as u32)
                    }
                };
                let [low, high] = self.binary.bounds(binary);
                let wide = &mut self.tree.nodes[to];
                for axis in 0..3 {
                    wide.bounds[axis][0][slot] = low[axis];
                    wide.bounds[axis][1][slot] = high[axis];
                }
                wide.children[slot] = Code::of(child);
            }
        }
        // Of every node on the way all children but one wait, and at the last one all.
        self.tree.pending = 7 * deepest + 1;
    }

    fn empty_node(&mut self) -> usize {
        self.tree.nodes.push(Node::EMPTY);
        self.tree.nodes.len() - 1
    }

    /// The binary nodes that are the children of a wide one.
    fn gather(&self, from: usize) -> Vec<usize> {
        let mut children = Vec::with_capacity(8);
        // A root that is itself a leaf is the only child of the only node.
        let mut todo = match self.binary.split(from) {
            Split::Nodes(_) if self.choices[from][0] != Choice::Leaf => vec![(from, 8)],
            _ => vec![(from, 1)],
        };
        while let Some((node, mut most)) = todo.pop() {
            let choices = &self.choices[node];
            while choices[most - 1] == Choice::Fewer {
                most -= 1;
            }
            match (choices[most - 1], self.binary.split(node)) {
                (Choice::Split(k), Split::Nodes([left, right])) => {
                    let k = usize::from(k);
                    todo.extend([(right, most - k), (left, k)]);
                }
                _ => children.push(node),
            }
        }
        children
    }

    /// What stands for a binary node that is a leaf.
    fn leaf(&mut self, binary: usize, split: Split) -> Child {
        if let Split::Item(item) = split {
            match *self.parts.find(item).0 {
                Part::Quadric(shape, _) => return Child::Quadric(shape),
                Part::Instance(instance, _) => return Child::Instance(instance),
                Part::Mesh { .. } => {}
            }
        }
        let place = self.tree.packets.len() as u32;
        if self.packet(binary) { Child::Cutouts(place) } else { Child::Triangles(place) }
    }

    /// Packs the triangles below a binary node. Answers whether any has holes.
    fn packet(&mut self, binary: usize) -> bool {
        let mut packet = Packet { corners: [[[f32::NAN; 8]; 3]; 3] };
        let mut names = Names([[0; 2]; 8]);
        let (mut todo, mut slot, mut holes) = (vec![binary], 0, false);
        while let Some(node) = todo.pop() {
            let item = match self.binary.split(node) {
                Split::Nodes(below) => {
                    todo.extend(below);
                    continue;
                }
                Split::Item(item) => item,
            };
            let (&Part::Mesh { shape, mesh, cutout }, triangle) = self.parts.find(item) else {
                unreachable!("packets hold triangles only")
            };
            for (corner, p) in mesh.corners(triangle).iter().enumerate() {
                for axis in 0..3 {
                    packet.corners[corner][axis][slot] = p[axis];
                }
            }
            names.0[slot] = [shape, triangle];
            holes |= cutout;
            slot += 1;
        }
        self.tree.packets.push(packet);
        self.tree.names.push(names);
        holes
    }
}
