//! The bounding volume hierarchy: nodes of eight boxes and packets of eight triangles, for one
//! ray against eight at a time (Wald, Benthin & Boulos 2008, "Getting rid of packets").
//!
//! # Memory
//!
//! A node takes 256 bytes and a packet of triangles 352. Packets are filled with five to eight
//! triangles, so a large mesh takes 50 to 90 bytes a triangle besides its own vertices and
//! indices ([`Tree::bytes`]). While a tree is built, about 300 bytes a triangle are needed more.

mod build;
mod collapse;
mod part;

pub(super) use part::{Part, Parts};

use glam::Vec3;

/// What a child of a node is: the three top bits of its code, the place in its list below them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    /// Another node.
    Node(u32),
    /// A packet of up to eight triangles.
    Triangles(u32),
    /// A packet of triangles of which some have holes.
    Cutouts(u32),
    /// A shape that is not a mesh, by its index in the scene.
    Quadric(u32),
    /// An instance, by its index in the scene.
    Instance(u32),
}

/// A child in 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(super) struct Code(u32);

impl Code {
    const SHIFT: u32 = 29;
    const PLACE: u32 = (1 << Self::SHIFT) - 1;
    /// The root of a tree: its first node.
    pub(super) const ROOT: Self = Self(0);

    pub(super) fn of(child: Child) -> Self {
        let (kind, place) = match child {
            Child::Node(i) => (0, i),
            Child::Triangles(i) => (1, i),
            Child::Cutouts(i) => (2, i),
            Child::Quadric(i) => (3, i),
            Child::Instance(i) => (4, i),
        };
        assert!(place <= Self::PLACE, "a tree holds at most 2^29 of each kind");
        Self(kind << Self::SHIFT | place)
    }

    /// The code in the low half of a word, below a distance.
    #[inline(always)]
    pub(super) fn from_key(key: u64) -> Self {
        Self(key as u32)
    }

    /// The code below a distance of 0 or more: keys are in the order of their distances.
    #[inline(always)]
    pub(super) fn key(self, distance: f32) -> u64 {
        u64::from(distance.to_bits()) << 32 | u64::from(self.0)
    }

    /// The node that it stands for, if it is one.
    #[inline(always)]
    pub(super) fn node(self) -> Option<usize> {
        (self.0 <= Self::PLACE).then_some(self.0 as usize)
    }

    /// What it stands for.
    #[inline(always)]
    pub(super) fn child(self) -> Child {
        let place = self.0 & Self::PLACE;
        match self.0 >> Self::SHIFT {
            0 => Child::Node(place),
            1 => Child::Triangles(place),
            2 => Child::Cutouts(place),
            3 => Child::Quadric(place),
            _ => Child::Instance(place),
        }
    }
}

/// Eight boxes and what is in them. The boxes of missing children are inside out, so that no
/// ray hits them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// By axis, the low and the high sides of the eight boxes.
    pub(super) bounds: [[[f32; 8]; 2]; 3],
    /// What is in the boxes.
    pub(super) children: [Code; 8],
}

impl Node {
    /// No children yet.
    pub(super) const EMPTY: Self = Self {
        bounds: [[[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]]; 3],
        children: [Code::ROOT; 8],
    };
}

/// Three corners, by axis, of up to eight triangles. Missing ones are NaN, which no ray hits.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Packet {
    pub(super) corners: [[[f32; 8]; 3]; 3],
}

/// Whose triangles the lanes of a packet are: apart from the corners, since only the nearest
/// hit of a ray is looked up.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Names(pub(super) [[u32; 2]; 8]);

/// A hierarchy over triangles, quadrics and instances.
#[derive(Clone, Debug)]
pub struct Tree {
    /// The root first; of an empty tree the root has no children.
    pub(super) nodes: Vec<Node>,
    pub(super) packets: Vec<Packet>,
    /// Shape and triangle of every lane of every packet.
    pub(super) names: Vec<Names>,
    /// How many children a ray may have to remember at most.
    pub(super) pending: usize,
    /// Lowest and highest corner of everything; `None` where there is nothing.
    pub bounds: Option<[Vec3; 2]>,
}

impl Default for Tree {
    fn default() -> Self {
        Self {
            nodes: vec![Node::EMPTY],
            packets: Vec::new(),
            names: Vec::new(),
            pending: 8,
            bounds: None,
        }
    }
}

impl Tree {
    /// Bytes of a triangle or of another item in a tree, about and at most.
    pub(crate) const ITEM: u64 = 90;
    /// Bytes more for each item while a tree is built.
    pub(crate) const BUILD: u64 = 300;

    /// The memory that the hierarchy takes, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.packets[..]) + size_of_val(&self.names[..])
    }
}

const _: () = assert!(size_of::<Node>() == 256, "four cache lines");
const _: () = assert!(size_of::<Packet>() + size_of::<Names>() == 352, "as the docs say");
