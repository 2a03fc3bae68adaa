//! Reader of NanoVDB files, with files that the test writes in the layout of the format, and damaged
//! ones.

mod support;

use glam::{DVec3, IVec3};
use petzval::io::ReadContext;
use petzval::scene::nanovdb::{names, read};
use petzval::scene::{BrickGrid, Voxels};
use support::{folder, write};

/// Sizes of the parts of a grid, and the offsets of what the reader needs.
const GRID: usize = 672;
const TREE: usize = 64;
const ROOT: usize = 64 + 32;
const UPPER: usize = 270_400;
const LOWER: usize = 33_856;
const LEAF: usize = 2144;

/// Returns a grid of one leaf at `origin`, a multiple of 8 in -4096 to 0, and of one tile of 8^3
/// voxels of `tile` beside it in z. The voxels of the leaf are 1, 2, ... 512.
fn tree(origin: i32, tile: f32) -> Vec<u8> {
    let root = GRID + TREE;
    let (upper, lower) = (root + ROOT, root + ROOT + UPPER);
    let leaf = lower + LOWER;
    let mut bytes = vec![0; leaf + LEAF];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    // The map: voxels of 0.5, with the first at (1, 2, 3).
    for axis in 0..3 {
        put(384 + 32 * axis, &0.5f64.to_le_bytes());
        put(528 + 8 * axis, &(1.0 + axis as f64).to_le_bytes());
    }
    put(GRID + 24, &(TREE as u64).to_le_bytes());
    put(GRID + 32, &1u32.to_le_bytes());
    // The root: the box of active voxels, and one tile whose key has the upper bits of x, y, z.
    for axis in 0..3 {
        put(root + 4 * axis, &origin.to_le_bytes());
        let high = origin + if axis == 2 { 15 } else { 7 };
        put(root + 12 + 4 * axis, &high.to_le_bytes());
    }
    put(root + 24, &1u32.to_le_bytes());
    let key = u64::from(origin as u32 >> 12);
    put(root + 64, &(key << 42 | key << 21 | key).to_le_bytes());
    put(root + 72, &((upper - root) as u64).to_le_bytes());
    let place = |node: i32, bits: u32, side: i32| {
        let within = (node & ((1 << bits) * side - 1)) / side;
        let n = 1 << bits;
        ((within * n + within) * n + within) as usize
    };
    let in_upper = place(origin, 5, 128);
    put(upper + 32 + 4096 + in_upper / 8, &[1 << (in_upper % 8)]);
    put(upper + 8256 + 8 * in_upper, &((lower - upper) as u64).to_le_bytes());
    let in_lower = place(origin, 4, 8);
    put(lower + 32 + 512 + in_lower / 8, &[1 << (in_lower % 8)]);
    put(lower + 1088 + 8 * in_lower, &((leaf - lower) as u64).to_le_bytes());
    put(lower + 1088 + 8 * (in_lower + 1), &tile.to_le_bytes());
    for i in 0..512 {
        put(leaf + 96 + 4 * i, &(1.0 + i as f32).to_le_bytes());
    }
    bytes
}

/// Returns a file of one segment.
fn file(name: &str, kind: u32, codec: u16, content: &[u8], stored: &[u8]) -> Vec<u8> {
    let mut file = b"NanoVDB0".to_vec();
    file.extend((32u32 << 21 | 4 << 10).to_le_bytes());
    file.extend([1u16.to_le_bytes(), codec.to_le_bytes()].concat());
    let mut metadata = [0; 176];
    metadata[..8].copy_from_slice(&(content.len() as u64).to_le_bytes());
    metadata[8..16].copy_from_slice(&(stored.len() as u64).to_le_bytes());
    metadata[32..36].copy_from_slice(&kind.to_le_bytes());
    metadata[136..140].copy_from_slice(&(name.len() as u32 + 1).to_le_bytes());
    file.extend(metadata);
    file.extend(name.as_bytes());
    file.push(0);
    file.extend(stored);
    file
}

fn plain(content: &[u8]) -> Vec<u8> {
    file("density", 1, 0, content, content)
}

fn opened(bytes: &[u8]) -> Result<Option<petzval::scene::nanovdb::NanoGrid>, String> {
    let folder = folder();
    let path = write(&folder, "a.nvdb", bytes);
    read(&path, "density", &ReadContext::default()).map_err(|error| error.to_string())
}

#[test]
fn voxels_tiles_and_the_map_are_read_plain_and_packed() {
    for origin in [-4096, -144, -16] {
        let content = tree(origin, 0.25);
        let mut packed = Vec::new();
        {
            use std::io::Write;
            let mut encoder =
                flate2::write::ZlibEncoder::new(&mut packed, flate2::Compression::fast());
            encoder.write_all(&content).expect("room");
            encoder.finish().expect("room");
        }
        let stored = [&(packed.len() as u64).to_le_bytes()[..], &packed].concat();
        let files = [plain(&content), file("density", 1, 1, &content, &stored)];
        for bytes in files {
            let grid = opened(&bytes).expect("a file").expect("a grid");
            assert_eq!(grid.first, IVec3::splat(origin));
            assert_eq!(grid.active[1], IVec3::new(origin + 7, origin + 7, origin + 15));
            assert_eq!(grid.voxels.resolution(), [8, 8, 16]);
            // z is fastest in a leaf.
            assert_eq!(grid.voxels.value([0, 0, 0]), 1.0);
            assert_eq!(grid.voxels.value([0, 0, 1]), 2.0);
            assert_eq!(grid.voxels.value([0, 1, 0]), 9.0);
            assert_eq!(grid.voxels.value([7, 7, 7]), 512.0);
            assert_eq!(grid.voxels.value([3, 4, 12]), 0.25);
            let at = grid.medium_from_index.transform_point3(DVec3::new(2.0, 4.0, -6.0));
            assert_eq!(at, DVec3::new(2.0, 4.0, 0.0));
        }
    }
}

#[test]
fn the_grids_of_a_file_have_names() {
    let folder = folder();
    let content = tree(-8, 0.0);
    let both = [plain(&content), file("heat", 1, 0, &content, &content)].concat();
    let path = write(&folder, "a.nvdb", both);
    let context = ReadContext::default();
    assert_eq!(names(&path, &context).expect("names"), ["density", "heat"]);
    assert!(read(&path, "heat", &context).expect("a file").is_some());
    assert!(read(&path, "hea", &context).expect("a file").is_none());
}

#[test]
fn files_that_are_damaged_or_of_another_kind_are_refused() {
    let content = tree(-8, 0.0);
    let mut old = plain(&content);
    old[8..12].copy_from_slice(&(29u32 << 21).to_le_bytes());
    for (bytes, fault) in [
        (b"VDB of another kind".to_vec(), "not a NanoVDB file"),
        (b"Nano".to_vec(), "cut short"),
        (old, "version 29 of NanoVDB"),
        (file("density", 3, 0, &content, &content), "values of type 3"),
        (file("density", 1, 2, &content, &content), "Blosc"),
        (file("density", 1, 1, &content, &[9; 40]), "cannot be unpacked"),
        (plain(&content[..700]), "outside the file"),
    ] {
        let found = opened(&bytes).expect_err(fault);
        assert!(found.contains(fault), "{found}, not {fault}");
    }
    // Cut anywhere, a file is an error or a grid, but no panic.
    let whole = plain(&content);
    for end in (0..whole.len()).step_by(997) {
        assert!(opened(&whole[..end]).is_err() || end == 0, "{end}");
    }
}

/// Nodes that refer to each other or to one node again and again would keep the reader busy for
/// ever.
#[test]
fn trees_with_shared_nodes_and_backward_links_are_refused() {
    let content = tree(-8, 0.0);
    let lower = GRID + TREE + ROOT + UPPER;
    let mut shared = content.clone();
    shared[lower + 32 + 512..lower + 32 + 1024].fill(0xff);
    for i in 0..4096 {
        let at = lower + 1088 + 8 * i;
        shared[at..at + 8].copy_from_slice(&(LOWER as u64).to_le_bytes());
    }
    let mut backward = content.clone();
    let root = GRID + TREE;
    backward[root + 72..root + 80].copy_from_slice(&(-64i64).to_le_bytes());
    for bytes in [shared, backward] {
        let found = opened(&plain(&bytes)).expect_err("a broken tree");
        assert!(found.contains("outside the file"), "{found}");
    }
}

#[test]
fn a_sparse_grid_interpolates_across_bricks() {
    let mut grid = BrickGrid::empty([20, 9, 9]);
    let value = |v: [u32; 3]| (v[0] * 100 + v[1] * 10 + v[2]) as f32;
    for x in 0..20 {
        for y in 0..9 {
            for z in 0..9 {
                grid.set([x, y, z], value([x, y, z]));
            }
        }
    }
    grid.set([20, 0, 0], 7.0);
    for at in [[7.5, 3.25, 7.75], [0.0, 0.0, 0.0], [18.9, 7.9, 7.1]] {
        let found = grid.interpolate(glam::Vec3::from(at));
        let expected = at[0] * 100.0 + at[1] * 10.0 + at[2];
        assert!((found - expected).abs() < 1e-3 * (1.0 + expected), "{at:?}: {found}");
    }
    assert_eq!(grid.interpolate(glam::Vec3::new(-1.0, 2.0, 2.0)), 0.0);
    let edge = grid.interpolate(glam::Vec3::new(-0.5, 2.0, 2.0));
    assert!((edge - 0.5 * value([0, 2, 2])).abs() < 1e-5, "{edge}");
}
