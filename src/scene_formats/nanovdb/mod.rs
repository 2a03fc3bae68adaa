//! Reader of fog volumes in NanoVDB files (Museth 2021, "NanoVDB: A GPU-friendly and portable VDB
//! data structure for real-time rendering and simulation"), of version 32 of the format.
//!
//! A file is a sequence of segments: a header, the metadata of its grids, and their contents. A
//! content is a tree in memory order: root, upper nodes of 32^3 children, lower nodes of 16^3, leaves
//! of 8^3 voxels. There is no kept crate that reads it. All offsets are checked.

mod segments;
mod tree;

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3, IVec3};

use petzval_base::io::{HeldMemory, ReadContext, path_excerpt};
use petzval_scene::BrickGrid;
use segments::{GridEntry, entries};
use tree::{Tree, TreeVisitor};

/// An error that stops the reading of a NanoVDB file.
#[derive(Debug, thiserror::Error)]
#[error("{}: {found}", path_excerpt(path))]
pub struct NanoVdbError {
    path: PathBuf,
    found: String,
}

/// A grid of a NanoVDB file.
#[derive(Clone, Debug)]
pub struct NanoGrid {
    /// Voxels.
    pub voxels: BrickGrid,
    /// Index coordinates of the first voxel.
    pub first: IVec3,
    /// Index coordinates of the lowest and the highest active voxel.
    pub active: [IVec3; 2],
    /// Index space to the space of the medium.
    pub medium_from_index: DAffine3,
}

/// Reads the grid of a name. Returns `None` if the file has none.
///
/// # Errors
/// Returns an error if the file cannot be read or is not a NanoVDB file of this version, and if the
/// grid does not hold numbers of 32 bits, is compressed with Blosc or exceeds the budget.
pub fn read(
    path: &Path,
    name: &str,
    context: &ReadContext,
) -> Result<Option<NanoGrid>, NanoVdbError> {
    let refuse = |found: String| NanoVdbError { path: path.to_owned(), found };
    let bytes =
        context.bytes(path).map_err(|error| refuse(format!("cannot read it: {}", error.source)))?;
    let mut held = context.hold(bytes.len() as u64).map_err(refuse)?;
    for entry in entries(&bytes).map_err(refuse)? {
        if entry.name == name.as_bytes() {
            return grid(&entry, &mut held).map(Some).map_err(refuse);
        }
    }
    Ok(None)
}

/// Returns the names of the grids of a file.
///
/// # Errors
/// Returns an error if the file cannot be read or is not a NanoVDB file of this version.
pub fn names(path: &Path, context: &ReadContext) -> Result<Vec<String>, NanoVdbError> {
    let refuse = |found: String| NanoVdbError { path: path.to_owned(), found };
    let bytes =
        context.bytes(path).map_err(|error| refuse(format!("cannot read it: {}", error.source)))?;
    let entries = entries(&bytes).map_err(refuse)?;
    Ok(entries.iter().map(|entry| String::from_utf8_lossy(entry.name).into_owned()).collect())
}

/// The grid that is made of a tree.
struct GridBuilder {
    voxels: BrickGrid,
    /// Index coordinates of the first voxel.
    first: IVec3,
}

impl GridBuilder {
    fn place(&self, at: IVec3) -> [i64; 3] {
        (at.as_i64vec3() - self.first.as_i64vec3()).to_array()
    }
}

impl TreeVisitor for GridBuilder {
    fn tile(&mut self, origin: IVec3, size: usize, value: f32) {
        self.voxels.set_tile(self.place(origin), size, value);
    }

    fn leaf(&mut self, origin: IVec3, value: &dyn Fn([u32; 3]) -> f32) {
        self.voxels.set_brick(self.place(origin), value);
    }
}

fn grid(entry: &GridEntry, held: &mut HeldMemory) -> Result<NanoGrid, String> {
    let content = entry.content(held)?;
    let tree = Tree::new(&content)?;
    let [low, high] = tree.active();
    if low.cmpgt(high).any() {
        return Err("the grid has no active voxels".to_owned());
    }
    // Bricks are those of the leaves, which begin at multiples of 8.
    let first = low & IVec3::splat(!7);
    let size = high.as_i64vec3() - first.as_i64vec3() + 1;
    let resolution = size.to_array().map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    const MOST: u32 = BrickGrid::MAX_RESOLUTION;
    if resolution.iter().any(|&n| n > MOST) {
        return Err(format!(
            "a grid of {resolution:?} voxels; at most {MOST} an axis are possible"
        ));
    }
    // A node or a leaf takes less memory than in the file, where none is visited twice. Their lists grow
    // by doubling.
    held.add(2 * content.len() as u64 + BrickGrid::MAX_ROOT_BYTES)?;
    let within = |at: IVec3, of: IVec3| (at - of).to_array().map(|v| v as u32);
    let in_tile = within(first, first & IVec3::splat(!(BrickGrid::TILE_SIDES[0] as i32 - 1)));
    let voxels = BrickGrid::aligned(resolution, in_tile, within(low, first));
    let mut builder = GridBuilder { voxels, first };
    tree.visit(&mut builder)?;
    let mut voxels = builder.voxels;
    voxels.shrink();
    let (rows, translation) = tree.map();
    let matrix = DMat3::from_cols_array(&rows).transpose();
    let medium_from_index = DAffine3 { matrix3: matrix, translation: DVec3::from(translation) };
    Ok(NanoGrid { voxels, first, active: [low, high], medium_from_index })
}
