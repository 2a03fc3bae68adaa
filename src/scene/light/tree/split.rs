//! Split of a group of emitters in two, at the plane of least cost.

use glam::Vec3;

use super::Emitter;

/// Bins along an axis; a group may be split between any two of them.
const BINS: usize = 16;
/// Largest group for which all axes are tried; larger groups use the longest only.
const ALL_AXES: usize = 64;

/// Bounds of the emitters whose centres are in one interval of an axis.
#[derive(Clone, Copy)]
struct Bin {
    low: Vec3,
    high: Vec3,
    /// Sum of the unit axes, weighted by intensity.
    axes: Vec3,
    intensity: f32,
}

impl Bin {
    const EMPTY: Self =
        Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, axes: Vec3::ZERO, intensity: 0.0 };

    fn union(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            axes: self.axes + other.axes,
            intensity: self.intensity + other.intensity,
        }
    }

    /// Returns the cost of the group: its intensity, times the spread of its normals, times the
    /// squared diagonal of its box. The spread follows from the length of the mean normal: 1 for
    /// equal normals, 4 for normals in all directions (the ratio of 4 pi to pi in the weighting of
    /// Conty Estevez & Kulla). The diagonal is not 0 for lights in a row, unlike the surface area.
    fn cost(&self) -> f32 {
        if self.intensity <= 0.0 {
            return 0.0;
        }
        let spread = 4.0 - 3.0 * (self.axes.length() / self.intensity).min(1.0);
        self.intensity * spread * (self.high - self.low).length_squared()
    }
}

/// Rule of a split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SplitRule {
    /// Least cost of both sides.
    LeastCost,
    /// Equal numbers of emitters.
    Median,
}

/// Partitions a group of at least two, and returns the index of the first emitter of the second
/// side. No side is empty.
pub(super) fn split(group: &mut [Emitter], rule: SplitRule) -> usize {
    let half = group.len() / 2;
    if group.len() < 3 {
        return half;
    }
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for emitter in group.iter() {
        let middle = emitter.bounds.centre();
        (low, high) = (low.min(middle), high.max(middle));
    }
    let extent = high - low;
    let longest = extent.max_position();
    let cut = match rule {
        SplitRule::Median => None,
        SplitRule::LeastCost => (0..3)
            .filter(|&axis| axis == longest || group.len() <= ALL_AXES)
            .filter(|&axis| extent[axis] > 0.0 && extent[axis].is_finite())
            .filter_map(|axis| best_cut(group, axis, low[axis], extent[axis]))
            .min_by(|a, b| a.1.total_cmp(&b.1)),
    };
    if let Some((cut, _)) = cut {
        let mut middle = 0;
        for i in 0..group.len() {
            if cut.is_before(&group[i]) {
                group.swap(i, middle);
                middle += 1;
            }
        }
        if middle > 0 && middle < group.len() {
            return middle;
        }
    }
    let along = |emitter: &Emitter| emitter.bounds.centre()[longest];
    group.select_nth_unstable_by(half, |a, b| along(a).total_cmp(&along(b)));
    half
}

/// A plane between two bins.
struct Cut {
    axis: usize,
    /// Coordinate at the start of the first bin.
    low: f32,
    /// Bins per unit of length.
    scale: f32,
    /// First bin after the plane.
    bin: usize,
}

impl Cut {
    fn bin(&self, emitter: &Emitter) -> usize {
        let along = emitter.bounds.centre()[self.axis];
        (((along - self.low) * self.scale) as usize).min(BINS - 1)
    }

    fn is_before(&self, emitter: &Emitter) -> bool {
        self.bin(emitter) < self.bin
    }
}

/// Returns the cut of least cost along an axis, and its cost.
fn best_cut(group: &[Emitter], axis: usize, low: f32, extent: f32) -> Option<(Cut, f32)> {
    let mut cut = Cut { axis, low, scale: BINS as f32 / extent, bin: 0 };
    if !cut.scale.is_finite() {
        return None;
    }
    let mut bins = [Bin::EMPTY; BINS];
    for emitter in group {
        let bounds = &emitter.bounds;
        let bin = &mut bins[cut.bin(emitter)];
        bin.low = bin.low.min(bounds.low);
        bin.high = bin.high.max(bounds.high);
        // The axis of a light that emits in all directions has no meaning.
        let directed = if bounds.normals.angle < std::f32::consts::PI { 1.0 } else { 0.0 };
        bin.axes += bounds.normals.axis * (bounds.intensity * directed);
        bin.intensity += bounds.intensity;
    }
    let mut after = [0.0; BINS];
    let mut sum = Bin::EMPTY;
    for i in (1..BINS).rev() {
        sum = sum.union(bins[i]);
        after[i] = sum.cost();
    }
    let mut least = f32::INFINITY;
    sum = Bin::EMPTY;
    for i in 1..BINS {
        sum = sum.union(bins[i - 1]);
        let cost = sum.cost() + after[i];
        if cost < least {
            (least, cut.bin) = (cost, i);
        }
    }
    (cut.bin > 0).then_some((cut, least))
}
