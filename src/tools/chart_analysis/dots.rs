//! Dark dots on a bright ground.

use petzval_base::least_squares::least_squares;
use petzval_image::Picture;

/// Blocks of the shorter side of the picture in which the ground is measured.
const BLOCKS: usize = 8;
/// Share of the values of a block that are darker than its ground.
const GROUND_RANK: f64 = 0.8;
/// Values below this share of the ground belong to dots.
const DARK: f64 = 0.6;
/// Least number of pixels of a dot.
const MIN_PIXELS: usize = 7;
/// Largest ratio of the sides of the box around a dot.
const MAX_ASPECT: f64 = 2.0;
/// Least number of pixels of the ground around a dot.
const MIN_GROUND: usize = 12;
/// Distances around a dot up to which its centroid takes pixels in, and from there up to which they are ground: relative
/// to its larger side, to which some pixels are added.
const SURROUNDINGS: [f64; 2] = [0.15, 0.5];
const SURROUNDING_PIXELS: f64 = 2.0;

/// A dot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dot {
    /// Centroid of what the dot takes from the ground, in green (pixels; the centre of the first is at 0).
    pub at: [f64; 2],
    /// Centroids in red and in blue less that in green (pixels).
    pub colour: [[f64; 2]; 2],
}

/// Finds the dots that lie wholly inside the picture.
pub(super) fn find_dots(picture: &Picture) -> Vec<Dot> {
    let [width, height] = picture.size;
    let values: Vec<f64> =
        picture.pixels.iter().map(|pixel| pixel.iter().copied().map(f64::from).sum()).collect();
    let ground = Ground::new(&values, picture.size);
    let mut dark: Vec<bool> =
        (0..values.len()).map(|i| values[i] < DARK * ground.at(i % width, i / width)).collect();
    let all_dark = dark.clone();
    let mut dots = Vec::new();
    for start in 0..dark.len() {
        if !dark[start] {
            continue;
        }
        // A connected patch, and the box around it.
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        let mut pixels = 0;
        let mut open = vec![start];
        dark[start] = false;
        while let Some(i) = open.pop() {
            let at = [i % width, i / width];
            pixels += 1;
            low = [0, 1].map(|k| low[k].min(at[k]));
            high = [0, 1].map(|k| high[k].max(at[k]));
            let neighbours = [
                (at[0] > 0).then(|| i - 1),
                (at[0] + 1 < width).then_some(i + 1),
                (at[1] > 0).then(|| i - width),
                (at[1] + 1 < height).then_some(i + width),
            ];
            for next in neighbours.into_iter().flatten() {
                if std::mem::take(&mut dark[next]) {
                    open.push(next);
                }
            }
        }
        let sides = [0, 1].map(|k| (high[k] - low[k] + 1) as f64);
        let larger = sides[0].max(sides[1]);
        let [reach, ground] = SURROUNDINGS.map(|share| share * larger + SURROUNDING_PIXELS);
        let around = ground.ceil() as usize;
        let is_inside = (0..2).all(|k| low[k] >= around && high[k] + around < picture.size[k]);
        let is_round = larger <= MAX_ASPECT * sides[0].min(sides[1]);
        // A disk fills pi / 4 of its box.
        let is_full = pixels as f64 > 0.5 * sides[0] * sides[1];
        if pixels >= MIN_PIXELS && is_inside && is_round && is_full {
            let window = [low.map(|n| n - around), high.map(|n| n + around)];
            dots.extend(centroids(picture, &all_dark, window, larger / 2.0 + reach));
        }
    }
    dots
}

/// Returns the centroids of a dot of this radius in the middle of a window; `None` if a channel shows none, or little
/// ground is around it. Pixels that are dark there belong to other dots.
fn centroids(
    picture: &Picture,
    dark: &[bool],
    [low, high]: [[usize; 2]; 2],
    radius: f64,
) -> Option<Dot> {
    let middle = [0, 1].map(|k| (low[k] + high[k]) as f64 / 2.0);
    let centroid = |value: &dyn Fn([f32; 3]) -> f64| -> Option<[f64; 2]> {
        // Pixels by their place from the middle: those of the dot, and the ground around it.
        let (mut dot, mut columns, mut side) = (Vec::new(), vec![Vec::new(); 3], Vec::new());
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                let [u, v] = [x as f64 - middle[0], y as f64 - middle[1]];
                let i = y * picture.size[0] + x;
                let value = value(picture.pixels[i]);
                if u.hypot(v) <= radius {
                    dot.push((u, v, value));
                } else if !dark[i] {
                    let terms = [1.0, u, v];
                    columns.iter_mut().zip(terms).for_each(|(column, term)| column.push(term));
                    side.push(value);
                }
            }
        }
        if side.len() < MIN_GROUND {
            return None;
        }
        // The ground is a plane.
        let plane = least_squares(columns, vec![side]);
        let [mut sum, mut u_sum, mut v_sum] = [0.0; 3];
        for (u, v, value) in dot {
            let taken = 1.0 - value / (plane[0][0] + plane[0][1] * u + plane[0][2] * v);
            sum += taken;
            u_sum += taken * u;
            v_sum += taken * v;
        }
        let off = [u_sum / sum, v_sum / sum];
        (sum > 0.0 && off[0].hypot(off[1]) < radius).then(|| [0, 1].map(|k| middle[k] + off[k]))
    };
    let [red, green, blue] = [0, 1, 2].map(|c| centroid(&|pixel| f64::from(pixel[c])));
    let (red, green, blue) = (red?, green?, blue?);
    let less = |of: [f64; 2]| [0, 1].map(|k| of[k] - green[k]);
    Some(Dot { at: green, colour: [less(red), less(blue)] })
}

/// Brightness of the ground, by block.
struct Ground {
    side: usize,
    columns: usize,
    levels: Vec<f64>,
}

impl Ground {
    fn new(values: &[f64], [width, height]: [usize; 2]) -> Self {
        let side = (width.min(height) / BLOCKS).max(1);
        let [columns, rows] = [width, height].map(|n| n.div_ceil(side));
        let mut levels = Vec::new();
        for block in 0..columns * rows {
            let [x, y] = [block % columns * side, block / columns * side];
            let rows = values.chunks_exact(width).skip(y).take(side);
            let mut inside: Vec<f64> =
                rows.flat_map(|row| &row[x..(x + side).min(width)]).copied().collect();
            let rank = ((inside.len() - 1) as f64 * GROUND_RANK) as usize;
            levels.push(*inside.select_nth_unstable_by(rank, f64::total_cmp).1);
        }
        Self { side, columns, levels }
    }

    /// Returns the level at a pixel: that of its block, which is bright enough for a threshold.
    fn at(&self, x: usize, y: usize) -> f64 {
        self.levels[y / self.side * self.columns + x / self.side]
    }
}
