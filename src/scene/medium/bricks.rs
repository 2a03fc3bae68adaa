//! Sparse grids of voxels: a tree with bricks of eight voxels along each axis where values differ, and
//! tiles where they do not (Museth 2013, "VDB: High-resolution sparse volumes with dynamic topology").

use std::ops::Range;

use glam::Vec3;

use super::grid::{Voxels, trilinear};

/// Logarithm of the voxels of a brick along an axis.
const BRICK: u32 = 3;
/// Logarithms of the children of an inner node along an axis, from the lowest level up.
const LEVELS: [u32; 2] = [4, 5];
/// Logarithms of the voxels of a brick and of inner nodes along an axis.
const SIDES: [u32; 3] = [BRICK, BRICK + LEVELS[0], BRICK + LEVELS[0] + LEVELS[1]];
/// Number of voxels of a brick.
const BRICK_VOXELS: usize = 1 << (3 * BRICK);

/// Voxels from the first to before the last along each axis.
type VoxelRange = [Range<u32>; 3];

/// Contents of a part of the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Cell {
    /// Voxels that are 0.
    #[default]
    Empty,
    /// Voxels of one value.
    Tile(f32),
    /// A brick or an inner node, by its index in the list of its level.
    Child(u32),
}

/// A sparse grid. Voxels outside its bricks and tiles are 0.
#[derive(Clone, Debug)]
pub struct BrickGrid {
    resolution: [u32; 3],
    /// Place of the first voxel in the first child of the root.
    offset: [u32; 3],
    /// The lowest voxel that counts in tiles.
    first_of_tiles: [u32; 3],
    /// Number of the root's children along the axes.
    root_size: [u32; 3],
    /// The root's children, x fastest.
    root: Vec<Cell>,
    /// Inner nodes of the two levels, from the lowest up: their children, x fastest.
    nodes: [Vec<Box<[Cell]>>; 2],
    /// Voxels of the bricks, x fastest.
    bricks: Vec<[f32; BRICK_VOXELS]>,
}

/// Returns the index of a child in an inner node that spans it and `2^log2` children along each axis,
/// each of `2^side` voxels.
#[inline(always)]
fn child_index(at: [u32; 3], side: u32, log2: u32) -> usize {
    let [x, y, z] = at.map(|v| (v >> side & ((1 << log2) - 1)) as usize);
    (z << log2 | y) << log2 | x
}

impl BrickGrid {
    /// Largest resolution.
    pub const MAX_RESOLUTION: u32 = 1 << 16;
    /// Voxels along an axis of the largest tile, of the second largest, and of the smallest.
    pub const TILE_SIDES: [u32; 3] = [1 << SIDES[2], 1 << SIDES[1], 1 << SIDES[0]];
    /// Memory of a brick (bytes).
    pub const BRICK_BYTES: u64 = size_of::<[f32; BRICK_VOXELS]>() as u64;
    /// Largest memory of the root (bytes).
    pub const MAX_ROOT_BYTES: u64 = 18 * 18 * 18 * size_of::<Cell>() as u64;

    /// The grid of this resolution without bricks.
    pub fn empty(resolution: [u32; 3]) -> Self {
        Self::aligned(resolution, [0; 3], [0; 3])
    }

    /// The grid without bricks whose first voxel has this place in a largest tile, in voxels; tiles begin
    /// at the voxel `first_of_tiles`. The resolution is at most [`Self::MAX_RESOLUTION`].
    pub fn aligned(resolution: [u32; 3], offset: [u32; 3], first_of_tiles: [u32; 3]) -> Self {
        let resolution = resolution.map(|n| n.min(Self::MAX_RESOLUTION));
        let offset = offset.map(|v| v % Self::TILE_SIDES[0]);
        let root_size =
            [0, 1, 2].map(|i| (resolution[i] + offset[i]).div_ceil(Self::TILE_SIDES[0]));
        let count = root_size.iter().map(|&n| n as usize).product();
        let root = vec![Cell::Empty; count];
        let (nodes, bricks) = ([const { Vec::new() }; 2], Vec::new());
        Self { resolution, offset, first_of_tiles, root_size, root, nodes, bricks }
    }

    /// Sets a voxel, and adds its brick if it is not 0. Voxels outside the grid are left out.
    pub fn set(&mut self, voxel: [u32; 3], value: f32) {
        if (0..3).any(|axis| voxel[axis] >= self.resolution[axis]) {
            return;
        }
        let at = self.aligned_place(voxel);
        if let Some(brick) = self.brick_for(at, value != 0.0) {
            brick[child_index(at, 0, BRICK)] = value;
        }
    }

    /// Sets the voxels of the brick around one, as a function of their index, x fastest. Voxels outside
    /// the grid are left out, and the brick is, if all others are 0.
    pub fn set_brick(&mut self, voxel: [i64; 3], value: impl Fn([u32; 3]) -> f32) {
        let mut values = [0.0; BRICK_VOXELS];
        let mut place = None;
        for (i, v) in values.iter_mut().enumerate() {
            let i = i as u32;
            let within = [i % 8, i / 8 % 8, i / 64];
            let at = [0, 1, 2].map(|axis| voxel[axis] + i64::from(within[axis]));
            let inside =
                (0..3).all(|axis| (0..i64::from(self.resolution[axis])).contains(&at[axis]));
            if inside {
                *v = value(within);
                place = place.or(Some(at.map(|v| v as u32)));
            }
        }
        let Some(place) = place else { return };
        let filled = values.iter().any(|v| *v != 0.0);
        if let Some(brick) = self.brick_for(self.aligned_place(place), filled) {
            *brick = values;
        }
    }

    /// Gives one value to all voxels of the tile around a voxel: of the largest (0), of the second
    /// largest (1) or of the smallest (2). Those outside the grid are left out.
    pub fn set_tile(&mut self, voxel: [i64; 3], size: usize, value: f32) {
        let side = i64::from(Self::TILE_SIDES[size]);
        let corner = [0, 1, 2].map(|axis| {
            let at = voxel[axis] + i64::from(self.offset[axis]);
            at - at.rem_euclid(side)
        });
        let reaches = |axis: usize| {
            let [low, end] = [0, self.resolution[axis]].map(|v| i64::from(v + self.offset[axis]));
            corner[axis] < end && corner[axis] + side > low
        };
        if !(0..3).all(reaches) {
            return;
        }
        let cell = if value == 0.0 { Cell::Empty } else { Cell::Tile(value) };
        // A tile that begins before the root's first child ends there, too.
        let at = corner.map(|v| v.max(0) as u32);
        if let Some(place) = self.cell_for(at, size, cell != Cell::Empty) {
            *place = cell;
        }
    }

    /// Releases memory that was reserved for more bricks and nodes.
    pub fn shrink(&mut self) {
        self.bricks.shrink_to_fit();
        self.nodes.iter_mut().for_each(Vec::shrink_to_fit);
    }

    /// Returns its memory (bytes).
    pub fn bytes(&self) -> usize {
        let nodes: usize = self.nodes.iter().flatten().map(|node| size_of_val(&node[..])).sum();
        size_of_val(&self.root[..]) + nodes + self.bricks.len() * Self::BRICK_BYTES as usize
    }

    #[inline(always)]
    fn aligned_place(&self, voxel: [u32; 3]) -> [u32; 3] {
        [0, 1, 2].map(|axis| voxel[axis] + self.offset[axis])
    }

    #[inline(always)]
    fn root_index(&self, at: [u32; 3]) -> usize {
        let [x, y, z] = at.map(|v| (v >> SIDES[2]) as usize);
        let [nx, ny, _] = self.root_size.map(|n| n as usize);
        (z * ny + y) * nx + x
    }

    /// Returns the cell of a tile around a place, and adds the nodes above it if `add`.
    fn cell_for(&mut self, at: [u32; 3], size: usize, add: bool) -> Option<&mut Cell> {
        let root = self.root_index(at);
        let mut cell = self.root.get_mut(root)?;
        let [lower, upper] = &mut self.nodes;
        for (level, nodes) in [(1, upper), (0, lower)].into_iter().take(size) {
            let node = match *cell {
                Cell::Child(node) => node,
                _ if !add => return None,
                // A tile below others replaces them in part.
                outer => {
                    let node = nodes.len() as u32;
                    nodes.push(vec![outer; 1 << (3 * LEVELS[level])].into());
                    *cell = Cell::Child(node);
                    node
                }
            };
            let index = child_index(at, SIDES[level], LEVELS[level]);
            cell = nodes.get_mut(node as usize)?.get_mut(index)?;
        }
        Some(cell)
    }

    /// Returns the brick around a place, and adds it if `add`.
    fn brick_for(&mut self, at: [u32; 3], add: bool) -> Option<&mut [f32; BRICK_VOXELS]> {
        let next = self.bricks.len() as u32;
        let brick = match self.cell_for(at, 2, add)? {
            Cell::Child(brick) => *brick,
            _ if !add => return None,
            cell => {
                let value = if let Cell::Tile(value) = *cell { value } else { 0.0 };
                *cell = Cell::Child(next);
                self.bricks.push([value; BRICK_VOXELS]);
                next
            }
        };
        self.bricks.get_mut(brick as usize)
    }

    /// Returns the lowest inner node around a place, or the tile in its place.
    #[inline(always)]
    fn node_around(&self, at: [u32; 3]) -> Cell {
        let cell = self.root[self.root_index(at)];
        let Cell::Child(node) = cell else { return cell };
        self.nodes[1][node as usize][child_index(at, SIDES[1], LEVELS[1])]
    }

    /// Returns the brick or the tile around a place in a lowest inner node.
    #[inline(always)]
    fn brick_in(&self, node: Cell, at: [u32; 3]) -> Cell {
        let Cell::Child(child) = node else { return node };
        self.nodes[0][child as usize][child_index(at, SIDES[0], LEVELS[0])]
    }

    /// Returns the value of a voxel in a cell.
    #[inline(always)]
    fn value_in(&self, cell: Cell, voxel: [u32; 3]) -> f32 {
        match cell {
            Cell::Empty => 0.0,
            Cell::Tile(value) => {
                let counts = (0..3).all(|axis| voxel[axis] >= self.first_of_tiles[axis]);
                if counts { value } else { 0.0 }
            }
            Cell::Child(brick) => {
                self.bricks[brick as usize][child_index(self.aligned_place(voxel), 0, BRICK)]
            }
        }
    }

    /// Visits the values of the voxels of a range that are in a cell of this level: 3 for the root's
    /// children, 1 for bricks.
    fn visit_cell(&self, cell: Cell, level: usize, range: &VoxelRange, visit: &mut dyn FnMut(f32)) {
        let Cell::Child(child) = cell else {
            visit(self.value_in(cell, [0, 1, 2].map(|axis| range[axis].end - 1)));
            return;
        };
        if level == 1 {
            for z in range[2].clone() {
                for y in range[1].clone() {
                    for x in range[0].clone() {
                        visit(self.value_in(cell, [x, y, z]));
                    }
                }
            }
            return;
        }
        let (side, log2) = (SIDES[level - 2], LEVELS[level - 2]);
        let node = &self.nodes[level - 2][child as usize];
        self.visit_children(range, side, &mut |at, range| {
            self.visit_cell(node[child_index(at, side, log2)], level - 1, range, visit);
        });
    }

    /// Calls a function for each part of a range that is in one child of `2^side` voxels.
    fn visit_children(
        &self,
        range: &VoxelRange,
        side: u32,
        part: &mut dyn FnMut([u32; 3], &VoxelRange),
    ) {
        let children = |axis: usize| {
            let Range { start, end } = range[axis];
            let offset = self.offset[axis];
            let last = (end.max(start + 1) - 1 + offset) >> side;
            ((start + offset) >> side..=last).map(move |child| {
                let [low, high] = [child, child + 1].map(|child| child << side);
                start.max(low.saturating_sub(offset))..end.min(high - offset)
            })
        };
        if range.iter().any(Range::is_empty) {
            return;
        }
        for z in children(2) {
            for y in children(1) {
                for x in children(0) {
                    let at = self.aligned_place([x.start, y.start, z.start]);
                    part(at, &[x, y.clone(), z.clone()]);
                }
            }
        }
    }
}

impl Voxels for BrickGrid {
    type Value = f32;

    fn resolution(&self) -> [u32; 3] {
        self.resolution
    }

    #[inline(always)]
    fn value(&self, voxel: [u32; 3]) -> f32 {
        let at = self.aligned_place(voxel);
        self.value_in(self.brick_in(self.node_around(at), at), voxel)
    }

    /// Returns the value at a point between voxels. Most have all eight in one brick or tile, and nearly all
    /// in one node.
    #[inline]
    fn interpolate(&self, at: Vec3) -> f32 {
        let low = at.floor().to_array().map(|v| v as i64);
        let inside =
            (0..3).all(|axis| low[axis] >= 0 && low[axis] + 1 < i64::from(self.resolution[axis]));
        if !inside {
            return trilinear(at, |voxel| self.value_or_zero(voxel));
        }
        let first = self.aligned_place(low.map(|v| v as u32));
        let together = |side: u32| first.iter().all(|v| v % (1 << side) < (1 << side) - 1);
        if !together(SIDES[1]) {
            return trilinear(at, |voxel| self.value_or_zero(voxel));
        }
        let node = self.node_around(first);
        if together(SIDES[0]) {
            let cell = self.brick_in(node, first);
            return trilinear(at, |voxel| self.value_in(cell, voxel.map(|v| v as u32)));
        }
        trilinear(at, |voxel| {
            let voxel = voxel.map(|v| v as u32);
            self.value_in(self.brick_in(node, self.aligned_place(voxel)), voxel)
        })
    }

    fn visit_range(&self, range: VoxelRange, visit: &mut dyn FnMut(f32)) {
        self.visit_children(&range, SIDES[2], &mut |at, range| {
            self.visit_cell(self.root[self.root_index(at)], 3, range, visit);
        });
    }
}
