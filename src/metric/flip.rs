//! FLIP: what an observer would notice when two pictures are shown in turn.
//!
//! Colours are compared in an opponent space, blurred as the eye blurs them at a viewing
//! distance; edges and points that only one picture has weigh the difference up (Andersson,
//! Nilsson, Akenine-Moeller, Oskarsson, Astrom & Fairchild 2020). Pictures of more range than a
//! display's are compared at several exposures, and the largest difference counts (Andersson,
//! Nilsson, Shirley & Akenine-Moeller 2021).

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::image::Picture;

/// Exponent and the two constants of the map from colour distances to 0..1 (2020, sec. 4.1).
const COLOUR: [f64; 3] = [0.7, 0.4, 0.95];
/// Width of the feature detectors, degrees, and exponent (sec. 4.2).
const FEATURE: [f64; 2] = [0.082, 0.5];
/// The eye's contrast sensitivity as Gaussians a, b per channel: achromatic, red-green,
/// blue-yellow (sec. 4.1.1, after Johnson & Fairchild 2003).
const SENSITIVITY: [[[f64; 2]; 2]; 3] =
    [[[1.0, 0.0047], [0.0, 1e-5]], [[1.0, 0.0053], [0.0, 1e-5]], [[34.1, 0.04], [13.5, 0.025]]];
/// The fit of ACES's tone curve by Narkowicz 2016, with its exposure of 0.6: coefficients of
/// x^2, x, 1 above and below the line.
const TONE: [[f64; 3]; 2] =
    [[0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0], [0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14]];
/// The displayed brightness that the exposures start and end at (2021, sec. 3.2).
const BRIGHT: f64 = 0.85;

/// Pixels in a degree of visual angle where nothing else is known: a display 0.7 m wide of 3840
/// pixels, from 0.7 m away.
pub fn pixels_per_degree() -> f64 {
    0.7 * (3840.0 / 0.7) * std::f64::consts::PI / 180.0
}

/// The differences of two pictures of high dynamic range.
#[derive(Clone, Debug)]
pub struct HdrFlip {
    /// By pixel, the largest over all exposures.
    pub map: Vec<f32>,
    /// First and last exposure, stops.
    pub exposures: [f64; 2],
    /// How many exposures there are.
    pub count: u32,
}

/// The difference by pixel, 0 to 1, of two pictures that are shown as they are; linear light,
/// clipped at white.
pub fn flip_ldr(picture: &Picture, reference: &Picture, ppd: f64) -> Vec<f32> {
    let clipped = |picture: &Picture| -> Vec<DVec3> {
        let pixels = picture.pixels.iter();
        pixels.map(|p| DVec3::from_array(p.map(|c| f64::from(c.clamp(0.0, 1.0))))).collect()
    };
    let eye = Eye::new(ppd);
    let [picture, reference] = [(picture, clipped(picture)), (reference, clipped(reference))]
        .map(|(of, pixels)| eye.see(of.size, &pixels));
    compare(&picture, &reference)
}

/// The difference by pixel, 0 to 1, of two pictures of any range.
pub fn flip_hdr(picture: &Picture, reference: &Picture, ppd: f64) -> HdrFlip {
    let [start, stop] = exposures(reference);
    let count = (stop - start).ceil().max(2.0) as u32;
    let eye = Eye::new(ppd);
    let mut map = vec![0.0f32; reference.pixels.len()];
    for i in 0..count {
        let exposure = start + (stop - start) * f64::from(i) / f64::from(count - 1);
        let shown = |picture: &Picture| {
            let pixels: Vec<DVec3> =
                picture.pixels.iter().map(|&p| tone(p.map(f64::from), exposure)).collect();
            eye.see(picture.size, &pixels)
        };
        let [picture, reference] = [picture, reference].map(shown);
        for (most, off) in map.iter_mut().zip(compare(&picture, &reference)) {
            *most = most.max(off);
        }
    }
    HdrFlip { map, exposures: [start, stop], count }
}

/// A colour as a display shows it at an exposure in stops.
fn tone(colour: [f64; 3], exposure: f64) -> DVec3 {
    let curve = |[a, b, c]: [f64; 3], x: f64| (a * x + b) * x + c;
    DVec3::from_array(colour.map(|c| {
        let x = c.max(0.0) * exposure.exp2();
        (curve(TONE[0], x) / curve(TONE[1], x)).clamp(0.0, 1.0)
    }))
}

/// The exposures, in stops, at which the brightest and the median pixel of a picture are shown
/// bright.
fn exposures(picture: &Picture) -> [f64; 2] {
    // Where the curve is at BRIGHT: a quadratic.
    let [a, b, c] = [0, 1, 2].map(|i| TONE[0][i] - BRIGHT * TONE[1][i]);
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    let x = ((-b + root) / (2.0 * a)).max((-b - root) / (2.0 * a));
    let luminance = |&[r, g, b]: &[f32; 3]| {
        XYZ[0].y * f64::from(r) + XYZ[1].y * f64::from(g) + XYZ[2].y * f64::from(b)
    };
    let mut light: Vec<f64> = picture.pixels.iter().map(luminance).collect();
    light.sort_by(f64::total_cmp);
    let least = f64::from(f32::EPSILON);
    let most = light.last().copied().unwrap_or(1.0).max(least);
    let median = light.get(light.len() / 2).copied().unwrap_or(1.0);
    [(x / most).log2(), (x / median.max(least)).log2()]
}

/// Linear sRGB to X, Y, Z: columns, with as many digits as FLIP's authors take.
const XYZ: [DVec3; 3] = [
    DVec3::new(10_135_552.0 / 24_577_794.0, 871_024.0 / 4_096_299.0, 79_184.0 / 4_096_299.0),
    DVec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 4_394_405.0 / 36_866_691.0),
    DVec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
];

fn xyz(rgb: DVec3) -> DVec3 {
    DMat3::from_cols(XYZ[0], XYZ[1], XYZ[2]) * rgb
}

/// White's X, Y, Z.
fn white() -> DVec3 {
    xyz(DVec3::ONE)
}

/// The linear opponent space Y Cx Cz (Flohr et al. 1993).
fn opponent(rgb: DVec3) -> DVec3 {
    let n = xyz(rgb) / white();
    DVec3::new(116.0 * n.y - 16.0, 500.0 * (n.x - n.y), 200.0 * (n.y - n.z))
}

fn from_opponent(c: DVec3) -> DVec3 {
    let y = (c.x + 16.0) / 116.0;
    let xyz = DVec3::new(y + c.y / 500.0, y, y - c.z / 200.0) * white();
    DMat3::from_cols(XYZ[0], XYZ[1], XYZ[2]).inverse() * xyz
}

/// CIELAB, its a and b less where it is dark (Hunt 1952).
fn hunt_lab(rgb: DVec3) -> DVec3 {
    let f = |t: f64| {
        const DELTA: f64 = 6.0 / 29.0;
        if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let n = xyz(rgb) / white();
    let [x, y, z] = [f(n.x), f(n.y), f(n.z)];
    let l = 116.0 * y - 16.0;
    DVec3::new(l, 500.0 * (x - y) * 0.01 * l, 200.0 * (y - z) * 0.01 * l)
}

/// The distance of two colours (Abasi et al. 2020, "HyAB").
fn distance(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// One-dimensional kernels at a viewing distance.
struct Eye {
    /// By channel, the Gaussians whose sum blurs it, already weighted: along one axis.
    blur: [Vec<Vec<f64>>; 3],
    /// A Gaussian, and its first and second derivative, each scaled for the filters they make.
    smooth: Vec<f64>,
    edge: Vec<f64>,
    point: Vec<f64>,
}

/// What is seen of a picture.
struct Seen {
    /// Hunt-adjusted CIELAB of what the eye resolves.
    colours: Vec<DVec3>,
    /// Strength of edges and points.
    features: Vec<[f64; 2]>,
}

impl Eye {
    fn new(ppd: f64) -> Self {
        use std::f64::consts::PI;
        let widest = SENSITIVITY.iter().flatten().map(|[_, b]| *b).fold(0.0, f64::max);
        let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * ppd).ceil() as i32;
        let blur = SENSITIVITY.map(|gaussians| {
            let one = |&[a, b]: &[f64; 2]| -> Vec<f64> {
                // The amplitude is the plane's; each axis takes its root.
                let height = (a * (PI / b).sqrt()).sqrt();
                let at = |i: i32| height * (-(PI * f64::from(i) / ppd).powi(2) / b).exp();
                (-radius..=radius).map(at).collect()
            };
            let mut kernels: Vec<Vec<f64>> =
                gaussians.iter().filter(|[a, _]| *a > 0.0).map(one).collect();
            let total: f64 = kernels.iter().map(|k| k.iter().sum::<f64>().powi(2)).sum();
            kernels.iter_mut().flatten().for_each(|k| *k /= total.sqrt());
            kernels
        });
        let sd = 0.5 * FEATURE[0] * ppd;
        let radius = (3.0 * sd).ceil() as i32;
        let places = || (-radius..=radius).map(f64::from);
        let gauss = |x: f64| (-x * x / (2.0 * sd * sd)).exp();
        let sum: f64 = places().map(gauss).sum();
        let smooth = places().map(|x| gauss(x) / sum).collect();
        // What is above 0 sums to 1, and what is below to -1.
        let even = |kernel: Vec<f64>| -> Vec<f64> {
            let above: f64 = kernel.iter().filter(|k| **k > 0.0).sum();
            let below: f64 = -kernel.iter().filter(|k| **k < 0.0).sum::<f64>();
            kernel.iter().map(|&k| if k > 0.0 { k / above } else { k / below }).collect()
        };
        let edge = even(places().map(|x| -x * gauss(x)).collect());
        let point = even(places().map(|x| (x * x / (sd * sd) - 1.0) * gauss(x)).collect());
        Self { blur, smooth, edge, point }
    }

    fn see(&self, size: [usize; 2], pixels: &[DVec3]) -> Seen {
        let opposed: Vec<DVec3> = pixels.par_iter().map(|&p| opponent(p)).collect();
        let channel = |c: usize| -> Vec<f64> { opposed.iter().map(|p| p[c]).collect() };
        let blurred = [0, 1, 2].map(|c| {
            let plane = channel(c);
            let mut sum = vec![0.0; plane.len()];
            for kernel in &self.blur[c] {
                let part = convolve(size, &plane, kernel, kernel);
                sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
            }
            sum
        });
        let colours = (0..pixels.len())
            .into_par_iter()
            .map(|i| {
                let rgb = from_opponent(DVec3::from_array([0, 1, 2].map(|c| blurred[c][i])));
                hunt_lab(rgb.clamp(DVec3::ZERO, DVec3::ONE))
            })
            .collect();
        let bright: Vec<f64> = channel(0).iter().map(|y| (y + 16.0) / 116.0).collect();
        let [edges, points] = [&self.edge, &self.point].map(|kernel| {
            let across = convolve(size, &bright, kernel, &self.smooth);
            let along = convolve(size, &bright, &self.smooth, kernel);
            across.iter().zip(along).map(|(x, y)| x.hypot(y)).collect::<Vec<f64>>()
        });
        let features = edges.into_iter().zip(points).map(|(edge, point)| [edge, point]).collect();
        Seen { colours, features }
    }
}

/// Convolves a plane with a kernel along rows and one along columns; beyond the border the plane
/// goes on as at it.
fn convolve(size: [usize; 2], plane: &[f64], along_x: &[f64], along_y: &[f64]) -> Vec<f64> {
    let [width, height] = size;
    let at = |i: usize, k: usize, kernel: &[f64], n: usize| {
        (i + k).saturating_sub(kernel.len() / 2).min(n - 1)
    };
    let mut rows = vec![0.0; plane.len()];
    rows.par_chunks_exact_mut(width).zip(plane.par_chunks_exact(width)).for_each(|(to, from)| {
        for (x, to) in to.iter_mut().enumerate() {
            let taps = along_x.iter().enumerate();
            *to = taps.map(|(k, weight)| weight * from[at(x, k, along_x, width)]).sum();
        }
    });
    let mut both = vec![0.0; plane.len()];
    both.par_chunks_exact_mut(width).enumerate().for_each(|(y, to)| {
        for (k, weight) in along_y.iter().enumerate() {
            let from = &rows[at(y, k, along_y, height) * width..][..width];
            to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
        }
    });
    both
}

/// The difference of what is seen of two pictures.
fn compare(picture: &Seen, reference: &Seen) -> Vec<f32> {
    let [exponent, knee, height] = COLOUR;
    let most = distance(hunt_lab(DVec3::Y), hunt_lab(DVec3::Z)).powf(exponent);
    let knee = knee * most;
    let one = |i: usize| {
        let off = distance(picture.colours[i], reference.colours[i]).powf(exponent);
        let colour = match off < knee {
            true => off * height / knee,
            false => height + (off - knee) / (most - knee) * (1.0 - height),
        };
        let off = |f: usize| (picture.features[i][f] - reference.features[i][f]).abs();
        let feature = (off(0).max(off(1)) / 2f64.sqrt()).powf(FEATURE[1]);
        colour.powf(1.0 - feature) as f32
    };
    (0..picture.colours.len()).into_par_iter().map(one).collect()
}
