//! Grids of voxels, and trilinear interpolation between their centres.

use std::ops::{Add, Mul, Range};
use std::sync::Arc;

use glam::Vec3;

/// Values at points with integer coordinates; 0 outside a box that begins at the origin.
pub trait Voxels {
    /// Type of the values.
    type Value: Copy + Default + Add<Output = Self::Value> + Mul<f32, Output = Self::Value>;

    /// Returns the numbers of voxels along the axes.
    fn resolution(&self) -> [u32; 3];

    /// Returns the value of a voxel inside the box.
    fn value(&self, voxel: [u32; 3]) -> Self::Value;

    /// Returns the value at a point between voxels.
    #[inline]
    fn interpolate(&self, at: Vec3) -> Self::Value {
        trilinear(at, |voxel| self.value_or_zero(voxel))
    }

    /// Returns the value of a voxel, or 0 outside the box.
    #[inline(always)]
    fn value_or_zero(&self, voxel: [i64; 3]) -> Self::Value {
        let mut axes = voxel.iter().zip(self.resolution());
        let inside = axes.all(|(v, end)| (0..i64::from(end)).contains(v));
        if inside { self.value(voxel.map(|v| v as u32)) } else { Self::Value::default() }
    }

    /// Calls a function with every value of the voxels in a range inside the box, once or more often.
    fn visit_range(&self, [x, y, z]: [Range<u32>; 3], visit: &mut dyn FnMut(Self::Value)) {
        for z in z {
            for y in y.clone() {
                for x in x.clone() {
                    visit(self.value([x, y, z]));
                }
            }
        }
    }
}

/// Returns the value at a point between voxels, by a function that returns that of a voxel.
#[inline(always)]
pub(super) fn trilinear<V: Copy + Add<Output = V> + Mul<f32, Output = V>>(
    at: Vec3,
    value: impl Fn([i64; 3]) -> V,
) -> V {
    let low = at.floor();
    let offset = at - low;
    let [x, y, z] = low.to_array().map(|v| v as i64);
    let along_x = |j, k| lerp(offset.x, value([x, j, k]), value([x + 1, j, k]));
    let in_plane = |k| lerp(offset.y, along_x(y, k), along_x(y + 1, k));
    lerp(offset.z, in_plane(z), in_plane(z + 1))
}

#[inline(always)]
fn lerp<T: Add<Output = T> + Mul<f32, Output = T>>(t: f32, a: T, b: T) -> T {
    a * (1.0 - t) + b * t
}

/// A grid that stores the value of every voxel, x fastest.
#[derive(Clone, Debug)]
pub struct VoxelGrid<T> {
    resolution: [u32; 3],
    values: Arc<[T]>,
}

impl<T: Copy> VoxelGrid<T> {
    /// Makes a grid. Returns `None` if the number of values is not the product of the resolution.
    pub fn new(resolution: [u32; 3], values: Vec<T>) -> Option<Self> {
        let voxels = resolution.iter().try_fold(1u64, |all, &n| all.checked_mul(u64::from(n)))?;
        let complete = voxels > 0 && voxels == values.len() as u64;
        complete.then(|| Self { resolution, values: values.into() })
    }

    /// The grid of one voxel.
    pub fn one(value: T) -> Self {
        Self { resolution: [1; 3], values: [value].into() }
    }

    /// Returns its memory (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..])
    }
}

impl<T> Voxels for VoxelGrid<T>
where
    T: Copy + Default + Add<Output = T> + Mul<f32, Output = T>,
{
    type Value = T;

    fn resolution(&self) -> [u32; 3] {
        self.resolution
    }

    #[inline(always)]
    fn value(&self, [x, y, z]: [u32; 3]) -> T {
        let [nx, ny, _] = self.resolution.map(|n| n as usize);
        self.values[(z as usize * ny + y as usize) * nx + x as usize]
    }
}
