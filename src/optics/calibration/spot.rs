//! Point spreads by geometry: real rays of white light from points of the scene, counted in the
//! pixels where they land. Diffraction is left out.

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::bundle::BundleTracer;
use super::{Calibration, CalibrationSetup};
use petzval_base::sampler::{Dimension, sample_2d};
use petzval_lens::LensRay;
use petzval_lens::Paraxial;
use petzval_lens::Side;
use petzval_lens::Surface;
use petzval_lens::sequence_at;
use petzval_lens::trace_one;
use petzval_spectrum::IndexRangeError;
use petzval_spectrum::LightBand;

/// Rays of each point, in all bands together.
const RAYS: u32 = 8192;
/// Rays that find the entrance pupil.
const PUPIL_RAYS: usize = 252;
/// Margin around the entrance pupil, as a share of its size: nearer points see it larger.
const MARGIN: f64 = 0.25;
/// Share of the light that the largest spread should hold.
const CAPTURED: f64 = 0.995;
/// Columns and rows of points of the picture.
const USUAL_GRID: [usize; 2] = [7, 5];
/// Largest width of a spread (pixels).
const USUAL_WIDTH: usize = 65;
/// Distances relative to that in focus; infinity is added.
const USUAL_DISTANCES: [f64; 4] = [0.5, 0.75, 1.0, 1.5];
/// The same if infinity is in focus, in focal lengths.
const USUAL_FOCAL_LENGTHS: [f64; 4] = [50.0, 100.0, 200.0, 400.0];
/// Least cosine to the axis of the rays of a point.
const FORWARD: f64 = 0.1;

/// Point spreads by field, distance and colour channel.
#[derive(Clone, Debug, PartialEq)]
pub struct SpotGrid {
    /// Points of the picture, row by row (pixels). In focus, the light of the scene point has its
    /// centre there.
    pub fields: Vec<[f64; 2]>,
    /// Columns and rows of these points.
    pub grid: [usize; 2],
    /// Distances of the scene points from the film plane (mm).
    pub distances: Vec<f64>,
    /// Width and height of a spread (pixels); its middle pixel is on the point of the picture.
    pub side: usize,
    /// Shares of the light in each pixel: by distance, field, row, column and channel. Each channel
    /// of a spread adds up to 1, or to 0 if no light arrives.
    pub shares: Vec<f32>,
    /// Least share of the light of a spread that its pixels hold.
    pub captured: f64,
}

/// A ray that lands: its offset from the point of the picture (pixels), and its light in each
/// channel.
#[derive(Clone, Copy)]
struct Landing {
    offset: [f64; 2],
    light: [f64; 3],
}

impl SpotGrid {
    /// Returns the lengths of the axes of the shares: distance, row and column of the point, y, x and
    /// channel.
    pub fn shape(&self) -> [usize; 6] {
        [self.distances.len(), self.grid[1], self.grid[0], self.side, self.side, 3]
    }
}

impl CalibrationSetup<'_> {
    /// Returns the point spreads of 7 x 5 points of the picture at the distance in focus, nearer,
    /// farther and at infinity, at most 65 pixels wide.
    ///
    /// # Errors
    /// As [`Self::spots`].
    pub fn usual_spots(&self, calibration: &Calibration) -> Result<SpotGrid, IndexRangeError> {
        let focal_length = Paraxial::new(self.lens).focal_length.abs();
        let (steps, unit) = match calibration.focus.is_finite() {
            true => (USUAL_DISTANCES, calibration.focus),
            false => (USUAL_FOCAL_LENGTHS, focal_length),
        };
        // Points just before the lens are of no use.
        let nearest = calibration.front_depth + 2.0 * self.lens.rows[0].diameter;
        let mut distances: Vec<f64> =
            steps.into_iter().map(|step| step * unit).filter(|d| *d > nearest).collect();
        distances.push(f64::INFINITY);
        self.spots(calibration, USUAL_GRID, distances, USUAL_WIDTH)
    }

    /// Returns the point spreads of `grid` points of the picture at some distances from the film
    /// plane (mm), at most `most` pixels wide.
    ///
    /// # Errors
    /// Returns an error if the data of a glass do not cover visible light.
    pub fn spots(
        &self,
        calibration: &Calibration,
        grid: [usize; 2],
        distances: Vec<f64>,
        most: usize,
    ) -> Result<SpotGrid, IndexRangeError> {
        let tracer = SpotTracer::new(self, calibration, self.checked_bands()?);
        let size = self.pixels.resolution.map(f64::from);
        // Cell centres, so that spreads at the edge of the picture stand for as much of it.
        let place = |i: usize, axis: usize| (i as f64 + 0.5) / grid[axis] as f64 * size[axis] - 0.5;
        let fields: Vec<[f64; 2]> = (0..grid[0] * grid[1])
            .map(|i| [place(i % grid[0], 0), place(i / grid[0], 1)])
            .collect();
        let jobs: Vec<(f64, [f64; 2])> =
            distances.iter().flat_map(|&d| fields.iter().map(move |&field| (d, field))).collect();
        let landings: Vec<Vec<Landing>> =
            jobs.par_iter().map(|&(distance, field)| tracer.landings(field, distance)).collect();
        let needed = landings.iter().map(|all| needed_half(all)).max().unwrap_or(0);
        let side = (2 * needed + 1).min(most | 1);
        let mut captured = 1.0f64;
        let mut shares = Vec::with_capacity(landings.len() * side * side * 3);
        for landings in &landings {
            let (spread, share) = histogram(landings, side);
            shares.extend(spread);
            captured = captured.min(share);
        }
        Ok(SpotGrid { fields, grid, distances, side, shares, captured })
    }
}

/// Returns the half width (pixels) of the square that holds nearly all light.
fn needed_half(landings: &[Landing]) -> usize {
    let mut extents: Vec<(f64, f64)> = landings
        .iter()
        .map(|l| (l.offset[0].abs().max(l.offset[1].abs()), l.light.iter().sum()))
        .collect();
    extents.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = extents.iter().map(|(_, light)| light).sum();
    let mut sum = 0.0;
    for (extent, light) in extents {
        sum += light;
        if sum >= CAPTURED * all {
            return (extent + 0.5) as usize;
        }
    }
    0
}

/// Counts rays in pixels. Returns the shares of the light and the part of it that is inside.
fn histogram(landings: &[Landing], side: usize) -> (Vec<f32>, f64) {
    let (mut sums, mut total, mut inside) = (vec![0.0; side * side * 3], 0.0, [0.0; 3]);
    let half = (side / 2) as f64;
    for Landing { offset, light } in landings {
        total += light.iter().sum::<f64>();
        let [x, y] = offset.map(|v| (v + half + 0.5).floor());
        if (0.0..side as f64).contains(&x) && (0.0..side as f64).contains(&y) {
            let first = 3 * (y as usize * side + x as usize);
            for channel in 0..3 {
                sums[first + channel] += light[channel];
                inside[channel] += light[channel];
            }
        }
    }
    let share = |i: usize| {
        let all = inside[i % 3];
        if all > 0.0 { (sums[i] / all) as f32 } else { 0.0 }
    };
    let held = if total > 0.0 { inside.iter().sum::<f64>() / total } else { 1.0 };
    ((0..sums.len()).map(share).collect(), held)
}

/// Traces rays from points of the scene to the film.
pub struct SpotTracer<'a> {
    setup: &'a CalibrationSetup<'a>,
    calibration: &'a Calibration,
    lens: petzval_lens::RealLens,
    /// Distance of the plane before the front vertex at which rays start (mm).
    start: f64,
    bands: Vec<(LightBand, Vec<Surface<f64>>)>,
    /// From the last vertex to the frame of the film.
    film: DAffine3,
}

impl<'a> SpotTracer<'a> {
    fn new(
        setup: &'a CalibrationSetup<'a>,
        calibration: &'a Calibration,
        bands: Vec<LightBand>,
    ) -> Self {
        let front = &setup.lens.rows[0];
        let start = 2.0 * front.sag(front.diameter / 2.0).abs() + front.diameter;
        let surfaces = |band: LightBand| {
            let lens = setup.lens.at_checked_wavelength(band.wavelength);
            (band, sequence_at::<f64>(&lens, Side::Scene(start), band.wavelength))
        };
        let middle = DAffine3::from_translation(DVec3::new(0.0, 0.0, setup.film_distance));
        Self {
            setup,
            calibration,
            lens: setup.real_lens(),
            start,
            bands: bands.into_iter().map(surfaces).collect(),
            film: (middle * setup.film_pose.transform()).inverse(),
        }
    }

    /// Returns the rays that land of the scene point that a point of the picture shows at a distance.
    fn landings(&self, pixel: [f64; 2], distance: f64) -> Vec<Landing> {
        let pixels = &self.setup.pixels;
        let Some(axis) = self.calibration.scene_ray(pixel) else { return Vec::new() };
        if axis.direction.z < FORWARD {
            return Vec::new();
        }
        let depth = self.calibration.front_depth;
        let source = distance.is_finite().then(|| {
            let along = (distance - axis.point.z) / axis.direction.z;
            axis.point + along * axis.direction
        });
        // The entrance pupil in the plane of the front vertex.
        let film = match self.setup.round() {
            Some(decentre) => [0, 1].map(|i| pixels.film_point(pixel)[i] + decentre[i]),
            None => pixels.film_point(pixel),
        };
        let bundle = BundleTracer::new(&self.lens, PUPIL_RAYS).rays(film, 0);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for ray in bundle.iter().map(|ray| ray.ray).filter(|ray| ray.direction.z > FORWARD) {
            let at = ray.point + (depth - ray.point.z) / ray.direction.z * ray.direction;
            for (i, v) in [at.x, at.y].into_iter().enumerate() {
                (low[i], high[i]) = (low[i].min(v), high[i].max(v));
            }
        }
        let mut landings = Vec::new();
        for i in 0..RAYS / self.bands.len() as u32 {
            let numbers = sample_2d(0, i, Dimension::Pupil);
            let at = [0, 1].map(|k| {
                let share = (1.0 + 2.0 * MARGIN) * f64::from(numbers[k]) - MARGIN;
                low[k] + share * (high[k] - low[k])
            });
            let point = DVec3::new(at[0], at[1], depth);
            let towards = source.map_or(-axis.direction, |source| point - source);
            let direction = towards.normalize();
            // Light per area of the plane: cosine over the square of the distance.
            let light = source.map_or(1.0, |_| -direction.z / towards.length_squared());
            for (band, surfaces) in &self.bands {
                if let Some(landed) = self.land(point, direction, surfaces) {
                    let found = pixels.pixel(landed);
                    landings.push(Landing {
                        offset: [0, 1].map(|k| found[k] - pixel[k]),
                        light: band.response.map(|response| response * light),
                    });
                }
            }
        }
        landings
    }

    /// Returns the film point (mm) of a ray through a point of the plane of the front vertex.
    fn land(&self, point: DVec3, direction: DVec3, surfaces: &[Surface<f64>]) -> Option<[f64; 2]> {
        // The frame of the trace: y up, z towards the film.
        let t = [direction.x, -direction.y, -direction.z];
        let back = -self.start / t[2];
        let p = [point.x + back * t[0], -point.y + back * t[1], 0.0];
        let ray = trace_one::<f64>(LensRay::new(p, t), surfaces).ok()?;
        let p = self.film.transform_point3(DVec3::from_array(ray.p));
        let t = self.film.transform_vector3(DVec3::from_array(ray.t));
        let at = p - p.z / t.z * t;
        (t.z > 0.0 && at.is_finite()).then_some([at.x, at.y])
    }
}
