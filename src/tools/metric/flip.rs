//! FLIP: the difference that an observer notices when two pictures alternate.
//!
//! Colours are compared in an opponent space, blurred by the eye's contrast sensitivity at a
//! viewing distance. Edges and points that only one picture has amplify the difference (Andersson,
//! Nilsson, Akenine-Moeller, Oskarsson, Astrom & Fairchild 2020). Pictures of high dynamic range
//! are compared at several exposures, and the largest difference counts (Andersson, Nilsson,
//! Shirley & Akenine-Moeller 2021).

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use petzval_image::Picture;

/// Exponent and the two constants of the map from colour distances to 0..1 (2020, sec. 4.1).
const COLOUR: [f64; 3] = [0.7, 0.4, 0.95];
/// Width of the feature detectors (degrees), and exponent (sec. 4.2).
const FEATURE: [f64; 2] = [0.082, 0.5];
/// Contrast sensitivity of the eye as Gaussians a, b per channel: achromatic, red-green,
/// blue-yellow (sec. 4.1.1, after Johnson & Fairchild 2003).
const SENSITIVITY: [[[f64; 2]; 2]; 3] =
    [[[1.0, 0.0047], [0.0, 1e-5]], [[1.0, 0.0053], [0.0, 1e-5]], [[34.1, 0.04], [13.5, 0.025]]];
/// Fit of the ACES tone curve by Narkowicz 2016, with its exposure of 0.6: coefficients of x^2, x
/// and 1 in the numerator and the denominator.
const TONE: [[f64; 3]; 2] =
    [[0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0], [0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14]];
/// Displayed brightness at the first and the last exposure (2021, sec. 3.2).
const BRIGHT: f64 = 0.85;

/// Returns the default pixels per degree of visual angle: a display 0.7 m wide with 3840 pixels,
/// seen from 0.7 m.
pub fn pixels_per_degree() -> f64 {
    0.7 * (3840.0 / 0.7) * std::f64::consts::PI / 180.0
}

/// HDR-FLIP of two pictures.
#[derive(Clone, Debug)]
pub struct HdrFlip {
    /// Largest difference over all exposures, per pixel.
    pub map: Vec<f32>,
    /// First and last exposure (stops).
    pub exposures: [f64; 2],
    /// Number of exposures.
    pub count: u32,
}

/// Returns LDR-FLIP per pixel, 0 to 1, of two pictures in linear light, clipped at white. `ppd` is
/// the number of pixels per degree of visual angle.
pub fn flip_ldr(picture: &Picture, reference: &Picture, ppd: f64) -> Vec<f32> {
    let clipped = |picture: &Picture| -> Vec<DVec3> {
        let pixels = picture.pixels.iter();
        pixels.map(|p| DVec3::from_array(p.map(|c| f64::from(c.clamp(0.0, 1.0))))).collect()
    };
    let observer = Observer::new(ppd);
    let [picture, reference] = [(picture, clipped(picture)), (reference, clipped(reference))]
        .map(|(of, pixels)| observer.see(of.size, &pixels));
    compare(&picture, &reference)
}

/// Returns HDR-FLIP of two pictures. `ppd` is the number of pixels per degree of visual angle.
pub fn flip_hdr(picture: &Picture, reference: &Picture, ppd: f64) -> HdrFlip {
    let [start, stop] = exposures(reference);
    let count = (stop - start).ceil().max(2.0) as u32;
    let observer = Observer::new(ppd);
    let mut map = vec![0.0f32; reference.pixels.len()];
    for i in 0..count {
        let exposure = start + (stop - start) * f64::from(i) / f64::from(count - 1);
        let shown = |picture: &Picture| {
            let pixels: Vec<DVec3> =
                picture.pixels.iter().map(|&p| tone(p.map(f64::from), exposure)).collect();
            observer.see(picture.size, &pixels)
        };
        let [picture, reference] = [picture, reference].map(shown);
        for (most, error) in map.iter_mut().zip(compare(&picture, &reference)) {
            *most = most.max(error);
        }
    }
    HdrFlip { map, exposures: [start, stop], count }
}

/// Returns a colour as displayed at an exposure (stops).
fn tone(colour: [f64; 3], exposure: f64) -> DVec3 {
    let curve = |[a, b, c]: [f64; 3], x: f64| (a * x + b) * x + c;
    DVec3::from_array(colour.map(|c| {
        let x = c.max(0.0) * exposure.exp2();
        (curve(TONE[0], x) / curve(TONE[1], x)).clamp(0.0, 1.0)
    }))
}

/// Returns the exposures at which the brightest and the median pixel are displayed with
/// [`BRIGHT`] (stops).
fn exposures(picture: &Picture) -> [f64; 2] {
    // The curve equals BRIGHT at a root of a quadratic.
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

/// Columns of the matrix from linear sRGB to X, Y, Z, with the digits of FLIP's authors.
const XYZ: [DVec3; 3] = [
    DVec3::new(10_135_552.0 / 24_577_794.0, 871_024.0 / 4_096_299.0, 79_184.0 / 4_096_299.0),
    DVec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 4_394_405.0 / 36_866_691.0),
    DVec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
];

fn xyz(rgb: DVec3) -> DVec3 {
    DMat3::from_cols(XYZ[0], XYZ[1], XYZ[2]) * rgb
}

/// Returns X, Y, Z of white.
fn white() -> DVec3 {
    xyz(DVec3::ONE)
}

/// Converts linear sRGB to the linear opponent space Y Cx Cz (Flohr et al. 1993).
fn opponent(rgb: DVec3) -> DVec3 {
    let n = xyz(rgb) / white();
    DVec3::new(116.0 * n.y - 16.0, 500.0 * (n.x - n.y), 200.0 * (n.y - n.z))
}

fn from_opponent(c: DVec3) -> DVec3 {
    let y = (c.x + 16.0) / 116.0;
    let xyz = DVec3::new(y + c.y / 500.0, y, y - c.z / 200.0) * white();
    DMat3::from_cols(XYZ[0], XYZ[1], XYZ[2]).inverse() * xyz
}

/// Converts linear sRGB to CIELAB with a and b reduced in the dark (Hunt 1952).
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

/// Returns the distance of two colours (Abasi et al. 2020, "HyAB").
fn distance(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// Model of the observer: one-dimensional filter kernels at a viewing distance.
struct Observer {
    /// Weighted Gaussians of the contrast sensitivity along one axis, by channel.
    blur: [Vec<Vec<f64>>; 3],
    /// A Gaussian and its first and second derivatives, normalised for the feature detectors.
    smooth: Vec<f64>,
    edge: Vec<f64>,
    point: Vec<f64>,
}

/// A picture as the observer perceives it.
struct Percept {
    /// Hunt-adjusted CIELAB colours after the contrast sensitivity filter.
    colours: Vec<DVec3>,
    /// Strengths of edges and points.
    features: Vec<[f64; 2]>,
}

impl Observer {
    fn new(ppd: f64) -> Self {
        use std::f64::consts::PI;
        let widest = SENSITIVITY.iter().flatten().map(|[_, b]| *b).fold(0.0, f64::max);
        let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * ppd).ceil() as i32;
        let blur = SENSITIVITY.map(|gaussians| {
            let one = |&[a, b]: &[f64; 2]| -> Vec<f64> {
                // The amplitude is that of the 2-D Gaussian; each axis takes its root.
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
        // Positive values sum to 1, and negative ones to -1.
        let even = |kernel: Vec<f64>| -> Vec<f64> {
            let above: f64 = kernel.iter().filter(|k| **k > 0.0).sum();
            let below: f64 = -kernel.iter().filter(|k| **k < 0.0).sum::<f64>();
            kernel.iter().map(|&k| if k > 0.0 { k / above } else { k / below }).collect()
        };
        let edge = even(places().map(|x| -x * gauss(x)).collect());
        let point = even(places().map(|x| (x * x / (sd * sd) - 1.0) * gauss(x)).collect());
        Self { blur, smooth, edge, point }
    }

    fn see(&self, size: [usize; 2], pixels: &[DVec3]) -> Percept {
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
        Percept { colours, features }
    }
}

/// Convolves a plane with one kernel along rows and one along columns. Border values extend beyond
/// the plane.
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

/// Returns the difference of two perceived pictures per pixel, 0 to 1.
fn compare(picture: &Percept, reference: &Percept) -> Vec<f32> {
    let [exponent, knee, height] = COLOUR;
    let most = distance(hunt_lab(DVec3::Y), hunt_lab(DVec3::Z)).powf(exponent);
    let knee = knee * most;
    let one = |i: usize| {
        let distance = distance(picture.colours[i], reference.colours[i]).powf(exponent);
        let colour = match distance < knee {
            true => distance * height / knee,
            false => height + (distance - knee) / (most - knee) * (1.0 - height),
        };
        let change = |f: usize| (picture.features[i][f] - reference.features[i][f]).abs();
        let feature = (change(0).max(change(1)) / 2f64.sqrt()).powf(FEATURE[1]);
        colour.powf(1.0 - feature) as f32
    };
    (0..picture.colours.len()).into_par_iter().map(one).collect()
}
