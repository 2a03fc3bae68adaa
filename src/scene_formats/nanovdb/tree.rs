//! The tree of a NanoVDB grid of f32, in the memory layout of version 32.

use std::cell::Cell;

use glam::IVec3;

/// Bytes of the head of a grid, before its tree.
const GRID: u64 = 672;
/// Offsets in the head: the map from index space, row by row, and its translation.
const MAP: u64 = 296 + 88;
const TRANSLATION: u64 = MAP + 144;
/// Bytes of the root, before its table, and of an entry of it.
const ROOT: u64 = 64;
const ROOT_TILE: u64 = 32;
/// Most entries of a root: each covers 4096 voxels along each axis.
const MAX_ROOT_TILES: u32 = 1 << 20;
/// Number of voxels of a leaf along an axis.
const LEAF_SIDE: u32 = 8;
/// Offset of the voxels of a leaf.
const LEAF_VALUES: u64 = 96;

/// A kind of inner nodes.
struct Level {
    /// Logarithm of the number of children along an axis.
    log2: u32,
    /// Voxels of a child along an axis.
    child_side: i32,
    /// Size of a child that is a tile: 1 for the second largest, 2 for the smallest.
    tile: usize,
    /// Offsets of the mask of children and of their table.
    children: u64,
    table: u64,
    /// The kind of the children; `None` if they are leaves.
    below: Option<&'static Level>,
}

const LOWER: Level =
    Level { log2: 4, child_side: 8, tile: 2, children: 32 + 512, table: 1088, below: None };
const UPPER: Level = Level {
    log2: 5,
    child_side: 128,
    tile: 1,
    children: 32 + 4096,
    table: 8256,
    below: Some(&LOWER),
};

/// Receiver of the contents of a tree.
pub(super) trait TreeVisitor {
    /// A tile of one value, from its first voxel on: the largest are of size 0, with 4096 voxels along an
    /// axis, those of size 1 have 128, and those of size 2 have 8.
    fn tile(&mut self, origin: IVec3, size: usize, value: f32);

    /// A leaf of 8 voxels along each axis, from its first voxel on, as a function of the place in it.
    fn leaf(&mut self, origin: IVec3, value: &dyn Fn([u32; 3]) -> f32);
}

/// A tree. Its bytes are not checked before they are read.
pub(super) struct Tree<'a> {
    bytes: &'a [u8],
    /// Offset of the root.
    root: u64,
    /// Bytes that nodes which are still to be visited may take: nodes do not overlap.
    unvisited: Cell<u64>,
}

impl<'a> Tree<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, String> {
        let unvisited = Cell::new(bytes.len() as u64);
        let mut tree = Self { bytes, root: 0, unvisited };
        tree.root = GRID.checked_add(tree.u64(GRID + 24)?).ok_or_else(broken)?;
        // Everything that is read without further checks.
        tree.slice(tree.root, ROOT)?;
        Ok(tree)
    }

    /// Returns the bytes of a node, whose kind has this size. Each is visited once.
    fn node(&self, at: u64, len: u64) -> Result<&'a [u8], String> {
        self.unvisited.set(self.unvisited.get().checked_sub(len).ok_or_else(broken)?);
        self.slice(at, len)
    }

    fn slice(&self, at: u64, len: u64) -> Result<&'a [u8], String> {
        let range = || Some(usize::try_from(at).ok()?..usize::try_from(at.checked_add(len)?).ok()?);
        range().and_then(|range| self.bytes.get(range)).ok_or_else(broken)
    }

    fn array<const N: usize>(&self, at: u64) -> Result<[u8; N], String> {
        let mut array = [0; N];
        array.copy_from_slice(self.slice(at, N as u64)?);
        Ok(array)
    }

    fn u32(&self, at: u64) -> Result<u32, String> {
        self.array(at).map(u32::from_le_bytes)
    }

    fn u64(&self, at: u64) -> Result<u64, String> {
        self.array(at).map(u64::from_le_bytes)
    }

    fn f32(&self, at: u64) -> Result<f32, String> {
        self.array(at).map(f32::from_le_bytes)
    }

    /// Returns the address of a child, given by its distance from a node.
    fn child(&self, node: u64, at: u64) -> Result<u64, String> {
        let distance = self.u64(at)? as i64;
        // Children follow their parents, so that a tree has no cycles.
        match u64::try_from(distance) {
            Ok(distance) if distance > 0 => node.checked_add(distance).ok_or_else(broken),
            _ => Err(broken()),
        }
    }

    /// Returns the index coordinates of the lowest and the highest active voxel.
    pub(super) fn active(&self) -> [IVec3; 2] {
        let corner = |first: u64| {
            let of = |i: u64| self.u32(self.root + 4 * (first + i)).unwrap_or_default() as i32;
            IVec3::new(of(0), of(1), of(2))
        };
        [corner(0), corner(3)]
    }

    /// Returns the matrix from index space, row by row, and the translation.
    pub(super) fn map(&self) -> ([f64; 9], [f64; 3]) {
        let number = |at: u64| self.array(at).map(f64::from_le_bytes).unwrap_or_default();
        let matrix = std::array::from_fn(|i| number(MAP + 8 * i as u64));
        (matrix, std::array::from_fn(|i| number(TRANSLATION + 8 * i as u64)))
    }

    /// Visits every leaf, and every tile that is not 0.
    pub(super) fn visit(&self, visitor: &mut dyn TreeVisitor) -> Result<(), String> {
        let tiles = self.u32(self.root + 24)?;
        if tiles > MAX_ROOT_TILES {
            return Err(broken());
        }
        for tile in 0..u64::from(tiles) {
            let at = self.root + ROOT + tile * ROOT_TILE;
            let key = self.u64(at)?;
            let coordinate = |shift: u32| (((key >> shift) & 0x1f_ffff) << 12) as u32 as i32;
            let origin = IVec3::new(coordinate(42), coordinate(21), coordinate(0));
            match self.u64(at + 8)? {
                0 => visit_tile(visitor, origin, 0, self.f32(at + 20)?),
                _ => self.visit_node(&UPPER, self.child(self.root, at + 8)?, origin, visitor)?,
            }
        }
        Ok(())
    }

    fn visit_node(
        &self,
        level: &Level,
        node: u64,
        origin: IVec3,
        visitor: &mut dyn TreeVisitor,
    ) -> Result<(), String> {
        let side = 1u64 << level.log2;
        self.node(node, level.table + 8 * side.pow(3))?;
        for i in 0..side.pow(3) {
            let has_child =
                self.bytes[(node + level.children + i / 8) as usize] >> (i % 8) & 1 == 1;
            // z is fastest.
            let place = [i / (side * side), i / side % side, i % side].map(|v| v as i32);
            let corner = origin.wrapping_add(level.child_side * IVec3::from(place));
            let entry = node + level.table + 8 * i;
            match (has_child, level.below) {
                (false, _) => visit_tile(visitor, corner, level.tile, self.f32(entry)?),
                (true, Some(below)) => {
                    self.visit_node(below, self.child(node, entry)?, corner, visitor)?;
                }
                (true, None) => self.visit_leaf(self.child(node, entry)?, corner, visitor)?,
            }
        }
        Ok(())
    }

    fn visit_leaf(
        &self,
        leaf: u64,
        origin: IVec3,
        visitor: &mut dyn TreeVisitor,
    ) -> Result<(), String> {
        let values = &self.node(leaf, LEAF_VALUES + 4 * 512)?[LEAF_VALUES as usize..];
        let values = values.as_chunks::<4>().0;
        visitor.leaf(origin, &|[x, y, z]| {
            let i = (x * LEAF_SIDE + y) * LEAF_SIDE + z;
            f32::from_le_bytes(values[i as usize])
        });
        Ok(())
    }
}

fn visit_tile(visitor: &mut dyn TreeVisitor, origin: IVec3, size: usize, value: f32) {
    if value != 0.0 {
        visitor.tile(origin, size, value);
    }
}

fn broken() -> String {
    "a node of the grid's tree is outside the file".to_owned()
}
