//! Where a group of emitters is best divided in two.

use glam::Vec3;

use super::tree::Emitter;

/// Places along an axis where a group may be divided, and one.
const BINS: usize = 16;
/// Groups up to this size are tried along all axes, larger ones along the longest only.
const ALL_AXES: usize = 64;

/// Emitters whose middles are close together.
#[derive(Clone, Copy)]
struct Bin {
    low: Vec3,
    high: Vec3,
    /// Sum of the axes, each as long as its intensity.
    axes: Vec3,
    intensity: f32,
}

impl Bin {
    const EMPTY: Self =
        Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, axes: Vec3::ZERO, intensity: 0.0 };

    fn with(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            axes: self.axes + other.axes,
            intensity: self.intensity + other.intensity,
        }
    }

    /// How uncertain it is what the group contributes: its strength, times its size, times the
    /// spread of its normals, for which the length of their mean stands. A flat group sends
    /// into a hemisphere, one of all normals into four times the solid angle (pi against 4 pi
    /// when weighted as Conty Estevez & Kulla do). The size is a diagonal, which lights in a
    /// row have as well.
    fn cost(&self) -> f32 {
        if self.intensity <= 0.0 {
            return 0.0;
        }
        let spread = 4.0 - 3.0 * (self.axes.length() / self.intensity).min(1.0);
        self.intensity * spread * (self.high - self.low).length_squared()
    }
}

/// Divides a group: sorts it about a place, not at its ends, and answers the place.
pub(super) fn split(group: &mut [Emitter], halve: bool) -> usize {
    let half = group.len() / 2;
    if group.len() < 3 {
        return half;
    }
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for emitter in group.iter() {
        let middle = emitter.bounds.middle();
        (low, high) = (low.min(middle), high.max(middle));
    }
    let extent = high - low;
    let longest = extent.max_position();
    let cut = match halve {
        true => None,
        false => (0..3)
            .filter(|&axis| axis == longest || group.len() <= ALL_AXES)
            .filter(|&axis| extent[axis] > 0.0 && extent[axis].is_finite())
            .filter_map(|axis| best_cut(group, axis, low[axis], extent[axis]))
            .min_by(|a, b| a.1.total_cmp(&b.1)),
    };
    if let Some((cut, _)) = cut {
        let mut place = 0;
        for i in 0..group.len() {
            if cut.before(&group[i]) {
                group.swap(i, place);
                place += 1;
            }
        }
        if place > 0 && place < group.len() {
            return place;
        }
    }
    let along = |emitter: &Emitter| emitter.bounds.middle()[longest];
    group.select_nth_unstable_by(half, |a, b| along(a).total_cmp(&along(b)));
    half
}

/// A plane between two bins.
struct Cut {
    axis: usize,
    low: f32,
    scale: f32,
    bin: usize,
}

impl Cut {
    fn bin(&self, emitter: &Emitter) -> usize {
        let along = emitter.bounds.middle()[self.axis];
        (((along - self.low) * self.scale) as usize).min(BINS - 1)
    }

    fn before(&self, emitter: &Emitter) -> bool {
        self.bin(emitter) < self.bin
    }
}

/// The best place along an axis, and its cost.
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
        // Of what shines all around no axis is meant.
        let directed = if bounds.normals.angle < std::f32::consts::PI { 1.0 } else { 0.0 };
        bin.axes += bounds.normals.axis * (bounds.intensity * directed);
        bin.intensity += bounds.intensity;
    }
    let mut after = [0.0; BINS];
    let mut sum = Bin::EMPTY;
    for i in (1..BINS).rev() {
        sum = sum.with(bins[i]);
        after[i] = sum.cost();
    }
    let mut least = f32::INFINITY;
    sum = Bin::EMPTY;
    for i in 1..BINS {
        sum = sum.with(bins[i - 1]);
        let cost = sum.cost() + after[i];
        if cost < least {
            (least, cut.bin) = (cost, i);
        }
    }
    (cut.bin > 0).then_some((cut, least))
}
