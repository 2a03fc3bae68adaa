//! Reader of NanoVDB files, with files that the test writes in the layout of the format, and damaged
//! ones.

use crate::support::{folder, write};
use glam::{DVec3, IVec3};
use petzval_base::io::ReadContext;
use petzval_scene::{BrickGrid, Voxels};
use petzval_scene_formats::nanovdb::{names, read};

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

fn opened(bytes: &[u8]) -> Result<Option<petzval_scene_formats::nanovdb::NanoGrid>, String> {
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

/// Returns a content without nodes: the root has these tiles, keys and values, and these active voxels.
fn root_tiles(tiles: &[([i32; 3], f32)], active: [[i32; 3]; 2]) -> Vec<u8> {
    let root = GRID + TREE;
    let mut bytes = vec![0; root + 64 + 32 * tiles.len()];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    for axis in 0..3 {
        put(384 + 32 * axis, &1f64.to_le_bytes());
    }
    put(GRID + 24, &(TREE as u64).to_le_bytes());
    for (i, value) in active.as_flattened().iter().enumerate() {
        put(root + 4 * i, &value.to_le_bytes());
    }
    put(root + 24, &(tiles.len() as u32).to_le_bytes());
    for (i, (origin, value)) in tiles.iter().enumerate() {
        let [x, y, z] = origin.map(|v| u64::from(v as u32 >> 12));
        let at = root + 64 + 32 * i;
        put(at, &(x << 42 | y << 21 | z).to_le_bytes());
        put(at + 20, &value.to_le_bytes());
    }
    bytes
}

fn packed(content: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(content).expect("room");
    let packed = encoder.finish().expect("room");
    let stored = [&(packed.len() as u64).to_le_bytes()[..], &packed].concat();
    file("density", 1, 1, content, &stored)
}

/// Files of some hundred bytes that filled gigabytes with voxels of one value.
#[test]
fn tiles_of_any_size_take_no_memory_for_their_voxels() {
    let folder = folder();
    let corner = [-4096, 0, 8192];
    for (tiles, active) in [
        (vec![(corner, 1.5)], [[-4090, 3, 8200], [-1, 4095, 12287]]),
        (vec![(corner, 1.5)], [corner, [-3000, 1000, 9000]]),
        (vec![([0; 3], 9.0), (corner, 1.5)], [[-4096, 0, 0], [61_439, 65_535, 12_287]]),
    ] {
        let bytes = packed(&root_tiles(&tiles, active));
        assert!(bytes.len() < 400, "{} bytes", bytes.len());
        let path = write(&folder, "a.nvdb", bytes);
        let context = ReadContext::with_memory(1_000_000);
        let grid = crate::support::promptly("a tile", || read(&path, "density", &context))
            .unwrap_or_else(|error| panic!("{error}"))
            .expect("a grid");
        assert!(grid.voxels.bytes() < 100_000, "{} bytes", grid.voxels.bytes());
        let [low, high] = active.map(IVec3::from);
        let value = |at: IVec3| {
            let place = at - grid.first;
            grid.voxels.value(place.to_array().map(|v| v as u32))
        };
        // Tiles are between the active voxels alone.
        let in_tile = (high).min(IVec3::from(corner) + 4095);
        let first = low.max(IVec3::from(corner));
        for at in [first, in_tile, (first + in_tile) / 2] {
            assert_eq!(value(at), 1.5, "{at}");
        }
        if grid.first.x < low.x {
            assert_eq!(value(first - IVec3::X), 0.0);
        }
        let all = grid.voxels.resolution().map(|n| 0..n);
        let mut most = 0.0f32;
        crate::support::promptly("the maximum", || {
            grid.voxels.visit_range(all, &mut |value| most = most.max(value));
        });
        assert_eq!(most, if tiles.len() == 2 { 9.0 } else { 1.5 });
    }
}

#[test]
fn a_million_equal_tiles_take_no_time() {
    let tiles = vec![([0; 3], 2.0); 1 << 20];
    let bytes = packed(&root_tiles(&tiles, [[0; 3], [4095; 3]]));
    let grid =
        crate::support::promptly("2^20 tiles", || opened(&bytes)).expect("a file").expect("a grid");
    assert_eq!(grid.voxels.value([7, 8, 4095]), 2.0);
}

#[test]
fn what_is_unpacked_is_held_and_returned() {
    let folder = folder();
    let path = write(&folder, "a.nvdb", packed(&tree(-8, 0.0)));
    let content = (GRID + TREE + ROOT + UPPER + LOWER + LEAF) as u64;
    let small = ReadContext::with_memory(content - 1);
    let refusal = read(&path, "density", &small).expect_err("too little").to_string();
    assert!(refusal.contains("of memory"), "{refusal}");
    // The grid takes up to twice as much beside the content that is unpacked.
    let refusal = read(&path, "density", &ReadContext::with_memory(2 * content));
    assert!(refusal.expect_err("too little for the grid").to_string().contains("of memory"));
    let context = ReadContext::with_memory(4 * content);
    for _ in 0..9 {
        assert!(read(&path, "density", &context).expect("enough").is_some());
    }
}

/// A brick grid and the voxels that it should have.
#[test]
fn bricks_and_tiles_are_found_at_every_offset() {
    for offset in [0, 8, 4088, 1000 * 8] {
        let mut grid = BrickGrid::aligned([150, 30, 30], [offset; 3], [3, 0, 0]);
        let shift = i64::from(offset % 4096);
        // Multiples of the sizes, from the place in the largest tile on.
        let at = |v: i64, side: i64| v - (v + shift) % side;
        grid.set_tile([at(20, 8), at(20, 8), at(20, 8)], 2, 5.0);
        grid.set_brick([at(130, 8), at(9, 8), at(9, 8)], |[x, y, z]| (x + 8 * y + 64 * z) as f32);
        grid.set([0, 0, 29], 7.0);
        let inside =
            |v: [i64; 3], of: [i64; 3]| (0..3).all(|i| (0..8).contains(&(v[i] - at(of[i], 8))));
        let (mut sum, mut expected_sum) = (0.0, 0.0);
        for z in 0..30 {
            for y in 0..30 {
                for x in 0..150 {
                    let voxel = [x, y, z].map(i64::from);
                    let [i, j, k] = [(0, 130), (1, 9), (2, 9)].map(|(i, v)| voxel[i] - at(v, 8));
                    let expected = match voxel {
                        [0, 0, 29] => 7.0,
                        _ if inside(voxel, [20; 3]) => 5.0,
                        _ if inside(voxel, [130, 9, 9]) => (i + 8 * j + 64 * k) as f32,
                        _ => 0.0,
                    };
                    assert_eq!(grid.value([x, y, z]), expected, "{voxel:?} at {offset}");
                    expected_sum += f64::from(expected).min(4.0);
                }
            }
        }
        // Ranges of one voxel visit each once.
        for z in 0..30 {
            for y in 0..30 {
                for x in 0..150 {
                    let range = [x..x + 1, y..y + 1, z..z + 1];
                    grid.visit_range(range, &mut |value| sum += f64::from(value).min(4.0));
                }
            }
        }
        assert_eq!(sum, expected_sum);
        grid.visit_range([3..3, 0..9, 0..9], &mut |_| panic!("an empty range"));
        let mut most = 0.0f32;
        grid.visit_range([100..150, 0..30, 0..30], &mut |value| most = most.max(value));
        assert_eq!(most, 511.0);
    }
    // A large tile, and smaller ones that replace it in part.
    let mut grid = BrickGrid::aligned([5000, 9, 9], [8; 3], [0; 3]);
    grid.set_tile([-8; 3], 0, 1.0);
    grid.set_tile([120, -8, -8], 1, 2.0);
    grid.set_tile([128, 0, 0], 2, 3.0);
    grid.set([129, 0, 0], 4.0);
    for (x, expected) in [(0, 1.0), (119, 1.0), (120, 2.0), (128, 3.0), (129, 4.0), (136, 2.0)] {
        assert_eq!(grid.value([x, 0, 0]), expected, "{x}");
    }
    assert_eq!([248, 4087, 4088].map(|x| grid.value([x, 0, 0])), [1.0, 1.0, 0.0]);
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
