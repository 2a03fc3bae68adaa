//! Bounding volume hierarchy with nodes of eight boxes and packets of eight triangles, which one
//! ray tests at once (Wald, Benthin & Boulos 2008, "Getting rid of packets").
//!
//! # Memory
//!
//! A node takes 256 bytes and a packet of triangles 352. Packets hold five to eight triangles,
//! so a large mesh takes 50 to 90 bytes a triangle, without its vertices and indices
//! ([`Bvh::bytes`]). A packet of patches takes 512 bytes, a packet
//! of pieces of curves 320, a quadric 250. The build takes about 300 bytes a triangle in addition.

mod build;
mod collapse;
mod ploc;
mod primitives;
mod traverse;

pub(super) use primitives::{PrimitiveGroup, PrimitiveList};
pub use traverse::TraversalStack;
pub(super) use traverse::{
    LeafIntersector, NearestHit, RayPacket, RayQueue, TraversalRay, may_hit_box, traverse,
};

use glam::Vec3;

use super::geometry::QuadricSurface;

/// A child of a node: its kind, and its index in the list of that kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    /// Another node.
    Node(u32),
    /// A packet of up to eight opaque triangles.
    Triangles(u32),
    /// A packet of up to eight triangles, at least one of which has an alpha texture.
    AlphaTestedTriangles(u32),
    /// A quadric.
    Quadric(u32),
    /// An instance, by its index in the scene.
    Instance(u32),
    /// A packet of up to eight bilinear patches.
    Patches(u32),
    /// A packet of up to eight pieces of curves.
    Curves(u32),
}

/// A [`Child`] in 32 bits: the kind in the top three, the index below.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(super) struct PackedChild(u32);

impl PackedChild {
    const KIND_SHIFT: u32 = 29;
    const INDEX_MASK: u32 = (1 << Self::KIND_SHIFT) - 1;
    /// The root, which is node 0.
    pub(super) const ROOT: Self = Self(0);

    /// Packs a child. `SceneBuilder::build` refuses scenes whose indices would not fit.
    pub(super) fn pack(child: Child) -> Self {
        let (kind, index) = match child {
            Child::Node(i) => (0, i),
            Child::Triangles(i) => (1, i),
            Child::AlphaTestedTriangles(i) => (2, i),
            Child::Quadric(i) => (3, i),
            Child::Instance(i) => (4, i),
            Child::Patches(i) => (5, i),
            Child::Curves(i) => (6, i),
        };
        debug_assert!(index <= Self::INDEX_MASK, "index {index} does not fit into 29 bits");
        Self(kind << Self::KIND_SHIFT | index)
    }

    /// Returns the child of a sort key, which is in its lower half.
    #[inline(always)]
    pub(super) fn from_key(key: u64) -> Self {
        Self(key as u32)
    }

    /// Returns a sort key: the bits of a distance of at least 0 above those of the child. Keys sort
    /// by distance.
    #[inline(always)]
    pub(super) fn key(self, distance: f32) -> u64 {
        u64::from(distance.to_bits()) << 32 | u64::from(self.0)
    }

    /// Returns the index of the node, or `None` if the child is not a node.
    #[inline(always)]
    pub(super) fn node(self) -> Option<usize> {
        (self.0 <= Self::INDEX_MASK).then_some(self.0 as usize)
    }

    /// Unpacks the child.
    #[inline(always)]
    pub(super) fn unpack(self) -> Child {
        let index = self.0 & Self::INDEX_MASK;
        match self.0 >> Self::KIND_SHIFT {
            0 => Child::Node(index),
            1 => Child::Triangles(index),
            2 => Child::AlphaTestedTriangles(index),
            3 => Child::Quadric(index),
            4 => Child::Instance(index),
            5 => Child::Patches(index),
            _ => Child::Curves(index),
        }
    }
}

/// Up to eight children and their boxes. The boxes of missing children are inside out, so no ray
/// hits them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Low and high sides of the eight boxes, by axis.
    pub(super) bounds: [[[f32; 8]; 2]; 3],
    /// Contents of the boxes.
    pub(super) children: [PackedChild; 8],
}

impl Node {
    /// A node without children.
    pub(super) const EMPTY: Self = Self {
        bounds: [[[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]]; 3],
        children: [PackedChild::ROOT; 8],
    };
}

/// Corners of up to eight triangles, by corner, axis and lane. Missing triangles are NaN, which no
/// ray hits.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct TrianglePacket {
    pub(super) corners: [[[f32; 8]; 3]; 3],
}

/// Shape of a scene, and triangle, patch or segment of it. Ids sort by shape first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(C)]
pub(super) struct PrimitiveId {
    pub(super) shape: u32,
    pub(super) triangle: u32,
}

/// Ids of the triangles in a packet. They are stored apart from the corners, because traversal
/// reads them for hits only.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct PrimitiveIds(pub(super) [PrimitiveId; 8]);

/// Corners and ids of up to eight bilinear patches. Missing patches are NaN, which no ray hits.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct PatchPacket {
    /// By corner, axis and lane.
    pub(super) corners: [[[f32; 8]; 3]; 4],
    pub(super) ids: PrimitiveIds,
    /// Whether a patch has an alpha texture.
    pub(super) alpha_tested: bool,
}

/// Capsules around up to eight pieces of curves, and their ids. Missing pieces are NaN, which no ray
/// hits. The segments of the curves stay in their shapes.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct CurvePacket {
    /// One end of the chord of each piece, by axis and lane.
    pub(super) start: [[f32; 8]; 3],
    /// The other end minus the first, by axis and lane.
    pub(super) chord: [[f32; 8]; 3],
    /// Largest distance of a point of the piece from its chord.
    pub(super) radius: [f32; 8],
    /// Number of the piece in its segment, and number of the segment's pieces.
    pub(super) parts: [[u8; 2]; 8],
    /// Whether a curve has an alpha texture.
    pub(super) alpha_tested: bool,
    pub(super) ids: PrimitiveIds,
}

/// A quadric in the space of a hierarchy: a shape, or the only shape of an instanced object.
#[derive(Clone, Debug)]
pub(super) struct PlacedQuadric {
    pub(super) surface: QuadricSurface,
    /// Index of its shape.
    pub(super) shape: u32,
    /// Index of its instance, or [`NO_INDEX`](petzval_base::rays::NO_INDEX).
    pub(super) instance: u32,
    pub(super) alpha_tested: bool,
}

/// Bounding volume hierarchy over triangles, patches, curves, quadrics and instances.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// Nodes, the root first. The root of an empty hierarchy has no children.
    pub(super) nodes: Vec<Node>,
    pub(super) packets: Vec<TrianglePacket>,
    /// Ids of the triangles, by packet.
    pub(super) primitive_ids: Vec<PrimitiveIds>,
    pub(super) patches: Vec<PatchPacket>,
    pub(super) curves: Vec<CurvePacket>,
    pub(super) quadrics: Vec<PlacedQuadric>,
    /// Most children that wait on the traversal stack at once.
    pub(super) stack_size: usize,
    /// Lowest and highest corner of all primitives; `None` if there are none.
    pub bounds: Option<[Vec3; 2]>,
}

impl Default for Bvh {
    fn default() -> Self {
        Self {
            nodes: vec![Node::EMPTY],
            packets: Vec::new(),
            primitive_ids: Vec::new(),
            patches: Vec::new(),
            curves: Vec::new(),
            quadrics: Vec::new(),
            stack_size: 8,
            bounds: None,
        }
    }
}

impl Bvh {
    /// Most primitives of one hierarchy. Indices have 29 bits, and eight times the index of a
    /// packet must stay below [`NO_INDEX`](petzval_base::rays::NO_INDEX).
    pub(super) const MAX_PRIMITIVES: u64 = PackedChild::INDEX_MASK as u64;

    /// Estimate of the memory of a primitive in a finished hierarchy (bytes), on the high side.
    pub const BYTES_PER_PRIMITIVE: u64 = 90;
    /// Additional memory for each primitive during the build (bytes).
    pub const BUILD_BYTES_PER_PRIMITIVE: u64 = 300;

    /// Additional memory of a patch (bytes), on the high side.
    pub const BYTES_PER_PATCH: u64 = 90;
    /// Additional memory of a quadric, and of an instance of a single quadric (bytes).
    pub const BYTES_PER_QUADRIC: u64 = size_of::<PlacedQuadric>() as u64;

    /// Returns the shape of the only primitive, if that is an opaque quadric.
    pub(super) fn only_quadric(&self) -> Option<u32> {
        let alone = self.packets.is_empty() && self.patches.is_empty() && self.curves.is_empty();
        match &self.quadrics[..] {
            [quadric] if alone && !quadric.alpha_tested => Some(quadric.shape),
            _ => None,
        }
    }

    /// Returns the memory of the hierarchy (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
            + size_of_val(&self.packets[..])
            + size_of_val(&self.primitive_ids[..])
            + size_of_val(&self.patches[..])
            + size_of_val(&self.curves[..])
            + size_of_val(&self.quadrics[..])
    }
}

const _: () = assert!(size_of::<Node>() == 256, "four cache lines");
const _: () = assert!(size_of::<CurvePacket>() == 320, "as the docs say");
const _: () =
    assert!(size_of::<TrianglePacket>() + size_of::<PrimitiveIds>() == 352, "as the docs say");
