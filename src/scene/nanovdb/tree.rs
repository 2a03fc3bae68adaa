//! The tree of a NanoVDB grid of f32, in the memory layout of version 32.

use std::cell::Cell;

use glam::{I64Vec3, IVec3};

use crate::io::ReadContext;

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
const LEAF_SIDE: i32 = 8;
/// Offset of the voxels of a leaf.
const LEAF_VALUES: u64 = 96;

/// A kind of inner nodes.
struct Level {
    /// Logarithm of the number of children along an axis.
    log2: u32,
    /// Voxels of a child along an axis.
    child_side: i32,
    /// Offsets of the mask of children and of their table.
    children: u64,
    table: u64,
    /// The kind of the children; `None` if they are leaves.
    below: Option<&'static Level>,
}

const LOWER: Level = Level { log2: 4, child_side: 8, children: 32 + 512, table: 1088, below: None };
const UPPER: Level =
    Level { log2: 5, child_side: 128, children: 32 + 4096, table: 8256, below: Some(&LOWER) };

/// Side of a tile of the root (voxels).
const ROOT_SIDE: i32 = 4096;

/// A tree. Its bytes are not checked before they are read.
pub(super) struct Tree<'a> {
    bytes: &'a [u8],
    /// Offset of the root.
    root: u64,
    context: &'a ReadContext,
    /// Bytes that nodes which are still to be visited may take: nodes do not overlap.
    unvisited: Cell<u64>,
}

impl<'a> Tree<'a> {
    pub(super) fn new(bytes: &'a [u8], context: &'a ReadContext) -> Result<Self, String> {
        let unvisited = Cell::new(bytes.len() as u64);
        let mut tree = Self { bytes, root: 0, context, unvisited };
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

    /// Returns the number of leaves that the tree claims to have.
    pub(super) fn leaves(&self) -> u64 {
        u64::from(self.u32(GRID + 32).unwrap_or_default())
    }

    /// Returns the matrix from index space, row by row, and the translation.
    pub(super) fn map(&self) -> ([f64; 9], [f64; 3]) {
        let number = |at: u64| self.array(at).map(f64::from_le_bytes).unwrap_or_default();
        let matrix = std::array::from_fn(|i| number(MAP + 8 * i as u64));
        (matrix, std::array::from_fn(|i| number(TRANSLATION + 8 * i as u64)))
    }

    /// Calls a function with the index coordinates and the value of every voxel of the leaves, and of
    /// the tiles between the active voxels that are not 0.
    pub(super) fn visit(&self, voxel: &mut dyn FnMut(IVec3, f32)) -> Result<(), String> {
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
                0 => self.fill(origin, ROOT_SIDE, self.f32(at + 20)?, voxel)?,
                _ => self.visit_node(&UPPER, self.child(self.root, at + 8)?, origin, voxel)?,
            }
        }
        Ok(())
    }

    fn visit_node(
        &self,
        level: &Level,
        node: u64,
        origin: IVec3,
        voxel: &mut dyn FnMut(IVec3, f32),
    ) -> Result<(), String> {
        let side = 1u64 << level.log2;
        self.node(node, level.table + 8 * side.pow(3))?;
        for i in 0..side.pow(3) {
            let has_child =
                self.bytes[(node + level.children + i / 8) as usize] >> (i % 8) & 1 == 1;
            // z is fastest.
            let place = [i / (side * side), i / side % side, i % side].map(|v| v as i32);
            let corner = origin + level.child_side * IVec3::from(place);
            let entry = node + level.table + 8 * i;
            match (has_child, level.below) {
                (false, _) => self.fill(corner, level.child_side, self.f32(entry)?, voxel)?,
                (true, Some(below)) => {
                    self.visit_node(below, self.child(node, entry)?, corner, voxel)?;
                }
                (true, None) => self.visit_leaf(self.child(node, entry)?, corner, voxel)?,
            }
        }
        Ok(())
    }

    fn visit_leaf(
        &self,
        leaf: u64,
        origin: IVec3,
        voxel: &mut dyn FnMut(IVec3, f32),
    ) -> Result<(), String> {
        let values = &self.node(leaf, LEAF_VALUES + 4 * 512)?[LEAF_VALUES as usize..];
        for (i, value) in (0..).zip(values.as_chunks::<4>().0) {
            let place = IVec3::new(i / 64, i / LEAF_SIDE % LEAF_SIDE, i % LEAF_SIDE);
            voxel(origin + place, f32::from_le_bytes(*value));
        }
        Ok(())
    }

    /// Visits the voxels of a tile that are between the active ones.
    fn fill(
        &self,
        origin: IVec3,
        side: i32,
        value: f32,
        voxel: &mut dyn FnMut(IVec3, f32),
    ) -> Result<(), String> {
        if value == 0.0 {
            return Ok(());
        }
        let [low, high] = self.active();
        let first = origin.max(low);
        let last = origin.saturating_add(IVec3::splat(side - 1)).min(high);
        let size = (last.as_i64vec3() - first.as_i64vec3() + 1).max(I64Vec3::ZERO);
        let voxels = size.to_array().iter().fold(1u64, |all, &n| all.saturating_mul(n as u64));
        self.context.check(voxels.saturating_mul(4))?;
        for x in first.x..=last.x {
            for y in first.y..=last.y {
                for z in first.z..=last.z {
                    voxel(IVec3::new(x, y, z), value);
                }
            }
        }
        Ok(())
    }
}

fn broken() -> String {
    "a node of the grid's tree is outside the file".to_owned()
}
