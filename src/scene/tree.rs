//! The bounding volume hierarchy: obvhs finds the tree, and its binary nodes are collapsed
//! into nodes of eight boxes and leaves of eight triangles, for one ray against eight at a
//! time (Wald, Benthin & Boulos 2008, "Getting rid of packets"). This is the only file that
//! names the `obvhs` crate.

use std::time::Duration;

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

/// What a child of a node is: the two top bits of its code, the place in its list below them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// Another node.
    Node(u32),
    /// A packet of up to eight triangles.
    Triangles(u32),
    /// A shape that is not a mesh, by its index in the scene.
    Quadric(u32),
    /// An instance, by its index in the scene.
    Instance(u32),
}

/// A child in 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Code(u32);

impl Code {
    const PLACE: u32 = (1 << 30) - 1;

    fn of(child: Child) -> Self {
        let (kind, place) = match child {
            Child::Node(i) => (0, i),
            Child::Triangles(i) => (1, i),
            Child::Quadric(i) => (2, i),
            Child::Instance(i) => (3, i),
        };
        assert!(place <= Self::PLACE, "a tree holds at most 2^30 of each kind");
        Self(kind << 30 | place)
    }

    /// What it stands for.
    #[inline(always)]
    pub fn child(self) -> Child {
        let place = self.0 & Self::PLACE;
        match self.0 >> 30 {
            0 => Child::Node(place),
            1 => Child::Triangles(place),
            2 => Child::Quadric(place),
            _ => Child::Instance(place),
        }
    }
}

/// Eight boxes and what is in them. The boxes of missing children are inside out, so that no
/// ray hits them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Node {
    /// `bounds[0]` the low and `bounds[1]` the high sides, by axis, of the eight boxes.
    pub bounds: [[[f32; 8]; 3]; 2],
    /// What is in the boxes.
    pub children: [Code; 8],
}

/// Up to eight triangles. Missing ones have NaN corners, which no ray hits.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Packet {
    /// Three corners, by axis, of eight triangles.
    pub corners: [[[f32; 8]; 3]; 3],
    /// Which shape of the scene each belongs to.
    pub shape: [u32; 8],
    /// Which triangle of its shape each is.
    pub triangle: [u32; 8],
}

/// What a tree is built of.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// Lowest and highest corner of its box.
    pub bounds: [Vec3; 2],
    /// What it is.
    pub kind: ItemKind,
}

/// The kinds of things in a tree.
#[derive(Clone, Copy, Debug)]
pub enum ItemKind {
    /// A triangle of a mesh.
    Triangle {
        /// The mesh among the scene's shapes.
        shape: u32,
        /// Its place in the mesh.
        triangle: u32,
        /// Its corners.
        corners: [Vec3; 3],
    },
    /// Another shape of the scene.
    Quadric(u32),
    /// An instance of the scene.
    Instance(u32),
}

/// A hierarchy over triangles, quadrics and instances.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    pub(super) nodes: Vec<Node>,
    pub(super) packets: Vec<Packet>,
    /// Lowest and highest corner of everything; `None` where there is nothing.
    pub bounds: Option<[Vec3; 2]>,
}

impl Tree {
    /// Builds the hierarchy.
    pub fn new(items: &[Item]) -> Self {
        if items.is_empty() {
            return Self::default();
        }
        let boxes: Vec<Aabb> = items
            .iter()
            .map(|item| Aabb::new(item.bounds[0].into(), item.bounds[1].into()))
            .collect();
        let params = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
        let binary = build_bvh2(&boxes, params, &mut Duration::default());
        let root = binary.nodes[0].aabb;
        let mut collapse = Collapse {
            items,
            light: light_nodes(&binary, items),
            binary: &binary,
            tree: Self { bounds: Some([root.min.into(), root.max.into()]), ..Self::default() },
        };
        collapse.run();
        collapse.tree
    }
}

/// For every binary node the number of triangles below it, if that is all there is and they
/// fit into a packet; 0 otherwise.
fn light_nodes(binary: &Bvh2, items: &[Item]) -> Vec<u8> {
    let mut light = vec![0u8; binary.nodes.len()];
    let mut order = vec![0usize];
    let mut next = 0;
    while let Some(&i) = order.get(next) {
        let node = &binary.nodes[i];
        if !node.is_leaf() {
            let first = node.first_index as usize;
            order.extend([first, first + 1]);
        }
        next += 1;
    }
    for i in order.into_iter().rev() {
        let node = &binary.nodes[i];
        let first = node.first_index as usize;
        light[i] = if node.is_leaf() {
            let count = node.prim_count as usize;
            let leaf = &binary.primitive_indices[first..first + count];
            let all = leaf
                .iter()
                .all(|&item| matches!(items[item as usize].kind, ItemKind::Triangle { .. }));
            if all && count <= 8 { count as u8 } else { 0 }
        } else {
            match (light[first], light[first + 1]) {
                (0, _) | (_, 0) => 0,
                (a, b) if a + b <= 8 => a + b,
                _ => 0,
            }
        };
    }
    light
}

struct Collapse<'a> {
    items: &'a [Item],
    binary: &'a Bvh2,
    light: Vec<u8>,
    tree: Tree,
}

impl Collapse<'_> {
    fn run(&mut self) {
        // (binary node, where its wide node stands)
        let mut todo = vec![(0usize, self.empty_node())];
        while let Some((from, to)) = todo.pop() {
            for (slot, binary) in self.gather(from).into_iter().enumerate() {
                let node = &self.binary.nodes[binary];
                let (low, high) = (node.aabb.min.to_array(), node.aabb.max.to_array());
                let child = if self.light[binary] > 0 {
                    Child::Triangles(self.packet(binary))
                } else if node.is_leaf() {
                    match self.items[self.leaf(binary)[0] as usize].kind {
                        ItemKind::Quadric(shape) => Child::Quadric(shape),
                        ItemKind::Instance(instance) => Child::Instance(instance),
                        ItemKind::Triangle { .. } => unreachable!("lone triangles are light"),
                    }
                } else {
                    let wide = self.empty_node();
                    todo.push((binary, wide));
                    Child::Node(wide as u32)
                };
                let wide = &mut self.tree.nodes[to];
                for axis in 0..3 {
                    wide.bounds[0][axis][slot] = low[axis];
                    wide.bounds[1][axis][slot] = high[axis];
                }
                wide.children[slot] = Code::of(child);
            }
        }
    }

    fn empty_node(&mut self) -> usize {
        self.tree.nodes.push(Node {
            bounds: [[[f32::INFINITY; 8]; 3], [[f32::NEG_INFINITY; 8]; 3]],
            children: [Code(0); 8],
        });
        self.tree.nodes.len() - 1
    }

    /// Up to eight binary nodes that stand for one: the largest is opened until there are
    /// eight or none is left to open.
    fn gather(&self, from: usize) -> Vec<usize> {
        let mut children = vec![from];
        while children.len() < 8 {
            let opens = |&i: &usize| self.light[i] == 0 && !self.binary.nodes[i].is_leaf();
            let area = |i: usize| self.binary.nodes[i].aabb.half_area();
            let largest = (0..children.len())
                .filter(|&slot| opens(&children[slot]))
                .max_by(|&a, &b| area(children[a]).total_cmp(&area(children[b])));
            let Some(slot) = largest else { break };
            let first = self.binary.nodes[children[slot]].first_index as usize;
            children[slot] = first;
            children.push(first + 1);
        }
        children
    }

    fn leaf(&self, binary: usize) -> &[u32] {
        let node = &self.binary.nodes[binary];
        let first = node.first_index as usize;
        &self.binary.primitive_indices[first..first + node.prim_count as usize]
    }

    /// Packs the triangles below a binary node.
    fn packet(&mut self, binary: usize) -> u32 {
        let mut packet =
            Packet { corners: [[[f32::NAN; 8]; 3]; 3], shape: [0; 8], triangle: [0; 8] };
        let (mut todo, mut slot) = (vec![binary], 0);
        while let Some(i) = todo.pop() {
            if !self.binary.nodes[i].is_leaf() {
                let first = self.binary.nodes[i].first_index as usize;
                todo.extend([first, first + 1]);
                continue;
            }
            for &item in self.leaf(i) {
                let ItemKind::Triangle { shape, triangle, corners } =
                    self.items[item as usize].kind
                else {
                    unreachable!("light nodes hold triangles only")
                };
                for (corner, p) in corners.iter().enumerate() {
                    for axis in 0..3 {
                        packet.corners[corner][axis][slot] = p[axis];
                    }
                }
                packet.shape[slot] = shape;
                packet.triangle[slot] = triangle;
                slot += 1;
            }
        }
        self.tree.packets.push(packet);
        (self.tree.packets.len() - 1) as u32
    }
}
