//! Blur and diffraction together: rays traced from the scene and spread by the picture's kernel,
//! against the sum of all plane waves at the film.

use petzval_image::Picture;
use petzval_lens::{
    Camera, ExitPupil, LensModel, Prescription, PupilSampling, RealLens, SpectralLine,
};
use petzval_lens_formats::read;
use petzval_optics::{ConditionChoices, FieldRays, ImageQuality, ImagingConditions, ImagingGrid};
use petzval_render::diffraction::{Diffraction, PointSpread};
use petzval_render::film::Frame;
use petzval_spectrum::LightBand;

/// Wavelength (nm).
const NM: f64 = 587.56;
/// Pixels along each side of the pictures.
const SIDE: usize = 81;
/// Samples of the sum of waves along each side of a pixel.
const SAMPLES: usize = 5;

/// A field point of a lens in light of one wavelength.
struct Point {
    lens: RealLens,
    rays: FieldRays,
    /// Width of a pixel (mm).
    pitch: f64,
}

impl Point {
    fn new(lens: &Prescription, height: f64, pitch: f64) -> Self {
        let choices =
            ConditionChoices { image_height: Some(height.max(0.5)), ..Default::default() };
        let mut conditions = ImagingConditions::new(lens, choices).expect("a focus");
        conditions.wavelengths = vec![SpectralLine { nm: NM, weight: 1.0 }];
        conditions.primary = 0;
        let film = conditions.film_distance;
        let grid = ImagingGrid { fields: 2, pupil: 192, threads: 1 };
        let mut quality = ImageQuality::new(lens, conditions, grid).expect("glasses with data");
        let field = if height > 0.0 { 1 } else { 0 };
        let rays = quality.fields.swap_remove(field);
        let lens = RealLens::new(lens.clone(), film, 25.0, PupilSampling::Pupil, 1e-3, 0.1);
        Self { lens, rays, pitch }
    }

    /// Returns the picture of the rays alone, with the reference point in the middle.
    fn spot(&self) -> Picture {
        let mut pixels = vec![[0.0f32; 3]; SIDE * SIDE];
        for grid in self.rays.open_grids() {
            let light: f64 = grid.open().map(|(_, cell)| cell.share * cell.density).sum();
            for (_, cell) in grid.open() {
                let away = [0, 1].map(|i| (cell.point[i] - grid.reference[i]) / self.pitch);
                let middle = (SIDE / 2) as f64;
                let [x, y] = [middle - away[0], middle + away[1]].map(|v| v.round() as usize);
                let share = (cell.share * cell.density / light) as f32;
                if x < SIDE && y < SIDE {
                    pixels[y * SIDE + x].iter_mut().for_each(|v| *v += share);
                }
            }
        }
        Picture { size: [SIDE; 2], pixels }
    }

    /// Returns the picture of the light: the sum of all plane waves.
    fn waves(&self) -> Vec<f64> {
        let side = SIDE * SAMPLES;
        let image = self.rays.point_image(side, self.pitch * SIDE as f64).expect("light");
        // The image lies around the centroid, between samples of this grid.
        let mut pixels = vec![0.0; SIDE * SIDE];
        for (i, value) in image.values.iter().enumerate() {
            let place = [i % side, i / side].map(|v| v as f64);
            let place = [0, 1].map(|k| place[k] + image.centre[k] / image.pitch);
            for corner in 0..4 {
                let low = place.map(f64::floor);
                let step = [f64::from(corner % 2), f64::from(corner / 2)];
                let weight: f64 =
                    (0..2).map(|k| 1.0 - (place[k] - low[k] - step[k]).abs()).product();
                let at = [0, 1].map(|k| ((low[k] + step[k]) / SAMPLES as f64).floor());
                if at.iter().all(|v| (0.0..SIDE as f64).contains(v)) {
                    let [x, y] = at.map(|v| v as usize);
                    pixels[y * SIDE + SIDE - 1 - x] += weight * value;
                }
            }
        }
        pixels
    }

    /// Returns the spot as the picture's diffraction spreads it.
    fn spread(&self) -> Vec<f64> {
        let reference = self.rays.open_grids().next().expect("a grid").reference;
        // A film large enough that the point lies in it, of which the picture is a crop.
        let reach = (reference[1].abs() / self.pitch).ceil() as u32 + SIDE as u32;
        let count = 2 * reach + 1;
        let centre = [reach, (f64::from(reach) + reference[1] / self.pitch).round() as u32];
        let half = SIDE as u32 / 2;
        let frame = Frame {
            low: centre.map(|c| c - half),
            high: centre.map(|c| c + half + 1),
            ..Frame::whole([count; 2])
        };
        let camera = Camera {
            model: LensModel::Real(Box::new(self.lens.clone())),
            film: [f64::from(count) * self.pitch; 2],
            world_from_camera: glam::DAffine3::IDENTITY,
            imaging_ratio: 1.0,
            depth: [0.0, f64::INFINITY],
        };
        let spread = Diffraction::new(&camera, &frame, &light()).spread(&self.spot());
        spread.pixels.iter().map(|pixel| f64::from(pixel[1])).collect()
    }

    /// Returns the spot as a flat wavefront spreads it.
    fn spread_flat(&self) -> Vec<f64> {
        let reference = self.rays.open_grids().next().expect("a grid").reference;
        let pupil = ExitPupil::trace(&self.lens, reference).expect("light");
        let um = 1e3 * self.pitch;
        let spread = PointSpread::new(&pupil, &light(), um * SIDE as f64, um);
        let spot = self.spot();
        let mut pixels = vec![0.0; SIDE * SIDE];
        for (i, from) in spot.pixels.iter().enumerate().filter(|(_, from)| from[1] > 0.0) {
            for (j, into) in pixels.iter_mut().enumerate() {
                let away = [(i % SIDE, j % SIDE), (i / SIDE, j / SIDE)]
                    .map(|(from, to)| um * (to as f64 - from as f64));
                *into += f64::from(from[1]) * spread.at([-away[0], away[1]])[1] * um * um;
            }
        }
        pixels
    }
}

fn light() -> Vec<LightBand> {
    let band = |wavelength| LightBand { wavelength, response: [1.0; 3] };
    vec![band(NM - 1.0), band(NM + 1.0)]
}

/// Returns the share of the light that lies in the wrong pixels.
fn misplaced(a: &[f64], b: &[f64]) -> f64 {
    let sum = |v: &[f64]| v.iter().sum::<f64>();
    let (a_sum, b_sum) = (sum(a), sum(b));
    a.iter().zip(b).map(|(a, b)| (a / a_sum - b / b_sum).abs()).sum::<f64>() / 2.0
}

#[test]
fn blur_and_diffraction_together_equal_the_sum_of_waves() {
    let file =
        |name: &str| read(&crate::support::root().join("lenses").join(name)).expect("a lens");
    let stopped = |name: &str, factor: f64| {
        let mut lens = file(name);
        let diameter = lens.rows[lens.stop()].diameter * factor;
        lens.stop_down(diameter);
        lens
    };
    for (name, lens, height, pitch, most) in [
        ("phone f/3.5", file("phone.toml"), 0.0, 0.6e-3, 0.03),
        ("phone f/3.5", file("phone.toml"), 1.5, 0.6e-3, 0.12),
        ("dgauss f/4", stopped("dgauss.50mm.dat", 0.5), 0.0, 1.0e-3, 0.03),
        ("dgauss f/5", stopped("dgauss.50mm.dat", 0.4), 6.0, 1.5e-3, 0.04),
    ] {
        let point = Point::new(&lens, height, pitch);
        let waves = point.waves();
        let found = misplaced(&point.spread(), &waves);
        let flat = misplaced(&point.spread_flat(), &waves);
        println!(
            "{name} at {height} mm: {:.2} % of the light misplaced, {:.2} % by a flat wavefront",
            100.0 * found,
            100.0 * flat
        );
        assert!(found < most && found < 0.5 * flat, "{name} at {height} mm: {found}, {flat}");
    }
}
