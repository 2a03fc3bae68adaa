//! Enlarged parts of the pictures, and of their differences.

use std::io;

use petzval_image::Picture;
use petzval_tools::accuracy::{LadderRun, Reference, SplitPicture};

/// Width and height of a crop, if the picture is that large (pixels).
const SIDE: usize = 40;

/// Factor on the brightness of differences.
pub(super) const GAIN: f32 = 4.0;

/// A rectangle of the picture.
#[derive(Clone, Debug)]
pub(super) struct Region {
    pub title: &'static str,
    pub low: [usize; 2],
    pub size: [usize; 2],
}

/// Chooses the parts to show: where models differ most, where the picture has most detail, and a
/// corner.
pub(super) fn regions(run: &LadderRun, reference: &Reference) -> Vec<Region> {
    let whole = reference.picture.size;
    let size = whole.map(|n| n.min(SIDE));
    let most = whole.map(|n| n.saturating_sub(SIDE));
    let light: Vec<f64> = reference.picture.pixels.iter().map(|p| f64::from(p[1])).collect();
    let detail = detail(&reference.shown(&reference.picture));
    let found = [
        ("Where models differ most", fullest(&differences(run, reference), whole, size)),
        ("Where there is most detail", fullest(&detail, whole, size)),
        ("Towards a corner", corner(&light, whole, most, size)),
    ];
    let mut regions: Vec<Region> = Vec::new();
    for (title, low) in found {
        let far = |other: &Region| (0..2).any(|i| low[i].abs_diff(other.low[i]) > SIDE / 2);
        if regions.iter().all(far) {
            regions.push(Region { title, low, size });
        }
    }
    regions
}

/// Returns the upper left corner of the part of this size with the largest sum.
fn fullest(map: &[f64], whole: [usize; 2], size: [usize; 2]) -> [usize; 2] {
    let places = |i: usize| (0..=whole[i] - size[i]).step_by(SIDE / 4).chain([whole[i] - size[i]]);
    let all = places(1).flat_map(|y| places(0).map(move |x| [x, y]));
    let sums = all.map(|low| (low, sum(map, whole[0], low, size)));
    sums.max_by(|a, b| a.1.total_cmp(&b.1)).map_or([0, 0], |(low, _)| low)
}

/// Returns the squared slope of a picture at each pixel.
fn detail(picture: &Picture) -> Vec<f64> {
    let [width, height] = picture.size;
    let of = |j: usize| f64::from(picture.pixels[j][1]);
    let slope = |i: usize| {
        let [x, y] = [i % width, i / width];
        let right = y * width + (x + 1).min(width - 1);
        let below = (y + 1).min(height - 1) * width + x;
        (of(right) - of(i)).powi(2) + (of(below) - of(i)).powi(2)
    };
    (0..width * height).map(slope).collect()
}

/// Returns the squared differences of all models from the richest at each pixel, each model with
/// the same weight. They are products of halves of the samples, so noise adds nothing to the mean.
fn differences(run: &LadderRun, reference: &Reference) -> Vec<f64> {
    let mut all = vec![0.0; reference.picture.pixels.len()];
    for rung in 0..run.rungs() {
        if !run.last(rung).is_some_and(|point| point.bias.is_some_and(|bias| bias.certain())) {
            continue;
        }
        let Some([own, richest]) = run.pair(rung) else { continue };
        let off = |i: usize, c: usize, [p, q]: [usize; 2]| {
            let of =
                |parts: &SplitPicture<4>| parts.means[p].pixels[i][c] + parts.means[q].pixels[i][c];
            f64::from(of(own) - of(richest))
        };
        let weight = |i: usize, c: usize| f64::from(reference.weight[i][c]);
        let product =
            |i| (0..3).map(|c| weight(i, c) * off(i, c, [0, 1]) * off(i, c, [2, 3])).sum();
        let map: Vec<f64> = (0..all.len()).map(product).collect();
        let whole: f64 = map.iter().sum();
        if whole > 0.0 {
            all.iter_mut().zip(map).for_each(|(all, one)| *all += one / whole);
        }
    }
    all
}

fn sum(map: &[f64], row: usize, low: [usize; 2], size: [usize; 2]) -> f64 {
    (low[1]..low[1] + size[1]).map(|y| map[y * row + low[0]..][..size[0]].iter().sum::<f64>()).sum()
}

/// Returns the part nearest to a corner that has a third of the picture's mean light: the corners
/// themselves may be dark.
fn corner(light: &[f64], whole: [usize; 2], most: [usize; 2], size: [usize; 2]) -> [usize; 2] {
    let enough = light.iter().sum::<f64>() / light.len().max(1) as f64 / 3.0;
    let area = (size[0] * size[1]) as f64;
    for step in 0..=8 {
        let inward = most.map(|n| n * step / 16);
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|at: [usize; 2]| {
            [0, 1].map(|i| if at[i] == 0 { inward[i] } else { most[i] - inward[i] })
        });
        let of = |low: &[usize; 2]| sum(light, whole[0], *low, size) / area;
        if let Some(best) = corners.iter().copied().max_by(|a, b| of(a).total_cmp(&of(b)))
            && of(&best) > enough
        {
            return best;
        }
    }
    most
}

/// Returns a part of a rung's picture, and of its difference from the richest rung's with the same
/// seeds, as PNG files.
pub(super) fn crops(
    pair: [&SplitPicture<4>; 2],
    region: &Region,
    reference: &Reference,
) -> io::Result<[Vec<u8>; 2]> {
    let [own, richest] = pair.map(|parts| cut(&parts.picture(), region));
    let mut off = own.clone();
    for (off, other) in off.pixels.iter_mut().zip(&richest.pixels) {
        *off = [0, 1, 2].map(|c| (off[c] - other[c]).abs());
    }
    Ok([own.png(reference.exposure)?, off.png(GAIN * reference.exposure)?])
}

fn cut(picture: &Picture, Region { low, size, .. }: &Region) -> Picture {
    let rows = (low[1]..low[1] + size[1]).map(|y| y * picture.size[0] + low[0]);
    let pixels = rows.flat_map(|start| picture.pixels[start..start + size[0]].iter().copied());
    Picture { size: *size, pixels: pixels.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dark_corner_is_not_shown() {
        let whole = [100, 80];
        let inside = |i: usize| (i % 100).abs_diff(50).pow(2) + (i / 100).abs_diff(40).pow(2) < 144;
        let light: Vec<f64> = (0..8000).map(|i| if inside(i) { 1.0 } else { 0.0 }).collect();
        let most = whole.map(|n| n - SIDE);
        let low = corner(&light, whole, most, [SIDE; 2]);
        assert!(sum(&light, 100, low, [SIDE; 2]) > 30.0, "{low:?}");
        assert!(low != most && (0..2).all(|i| low[i] <= most[i]), "{low:?}");
        assert_eq!(corner(&vec![1.0; 8000], whole, most, [SIDE; 2]), most);
    }

    #[test]
    fn the_part_with_most_detail_holds_the_edge() {
        let pixels = (0..8000).map(|i| [if i % 100 < 73 { 0.2 } else { 0.7 }; 3]).collect();
        let detail = detail(&Picture { size: [100, 80], pixels });
        let [x, _] = fullest(&detail, [100, 80], [SIDE; 2]);
        assert!((33..=72).contains(&x), "{x}");
    }

    #[test]
    fn a_crop_holds_its_region() {
        let pixels = (0..12).map(|i| [i as f32; 3]).collect();
        let picture = Picture { size: [4, 3], pixels };
        let region = Region { title: "", low: [1, 1], size: [2, 2] };
        let cut: Vec<f32> = cut(&picture, &region).pixels.iter().map(|p| p[0]).collect();
        assert_eq!(cut, [5.0, 6.0, 9.0, 10.0]);
    }
}
