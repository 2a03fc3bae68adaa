//! Light paths of ghosts: from a light by two reflections inside the lens to the film.

use glam::{DVec3, Vec3};

use super::{GhostPair, Ghosts};
use crate::film::{Frame, Splat};
use crate::light_tracing::entry::EntrySquare;
use crate::light_tracing::light_paths::{
    CameraPoses, LightPath, LightPathInput, LightPaths, PathBand, PathCount, PathNumbers, WaveLight,
};
use petzval_base::distribution::{Distribution, DistributionSample};
use petzval_base::lanes::Real;
use petzval_base::rays::{Ray, WAVE_SIZE};
use petzval_base::sampler::{Dimension, pixel_key, sample_2d};
use petzval_lens::RealLens;
use petzval_scene::{SurfacePoint, gamma};

/// Samples of lit pixels per light path. Ghosts are unsharp and need few paths.
const SAMPLES_PER_PATH: u64 = 4;
/// Largest number of bands in which one path is traced.
const BANDS_PER_PATH: usize = 4;

/// A path in one band that arrives on the film.
#[derive(Clone, Copy)]
struct Arrival {
    /// Its index in the wave.
    slot: u32,
    pixel: [u32; 2],
    /// Whether it passed the left half of the exit pupil.
    left_half: bool,
    /// Factor from its flux to the value of the pixel, by channel of the path.
    share: [f32; 3],
}

impl Ghosts {
    /// Returns the number of light paths per sample number.
    pub(crate) fn path_count(&self, frame: &Frame) -> PathCount {
        PathCount::of_part(frame.resolution, self.lit, SAMPLES_PER_PATH)
    }

    /// Traces a wave of a sample number through one pair and returns its splats. Every path is traced in
    /// several evenly spaced bands, so that few paths already have nearly the right hue.
    ///
    /// A path is added to the pixel that it hits; a filter would not change an unsharp image.
    pub(crate) fn trace<R: Real<Scalar = f32>>(
        &self,
        input: &LightPathInput<'_>,
        lens: &RealLens,
        wave_paths: &mut LightPaths,
        [wave, sample]: [u32; 2],
    ) -> Vec<Splat> {
        // A low-discrepancy sequence distributes the waves of a sample index over pairs and bands.
        let of_sample = pixel_key(sample, u32::MAX - 1, input.seed);
        let [u, v] = sample_2d(of_sample, wave, Dimension::Wavelength);
        let Some(pair) = self.choose(f64::from(u)) else { return Vec::new() };
        let count = self.path_count(input.frame);
        let light = input.wave_light(count.wave_number([wave, sample]));
        let input = &light.input;
        sample_wave(input, lens, pixel_key(wave, sample, of_sample), &pair.entry, wave_paths);
        let (bands, shared) = self.bands_of_wave(&light, v);
        let factor = count.splat_scale(input) / (pair.share * shared as f64);
        let mut arrivals: Vec<Arrival> = Vec::new();
        for PathBand { band, weights } in bands {
            if !wave_paths.trace::<R>(lens, &self.surfaces(pair, band)) {
                continue;
            }
            for i in 0..wave_paths.len() {
                let Some(hit) = wave_paths.film_hit(i) else { continue };
                let Some(pixel) = film_pixel(input, hit.point) else { continue };
                let exposure = input.row_exposure(wave_paths.arrival_time(i), pixel);
                let share = weights.map(|w| (w * hit.transmission * factor * exposure) as f32);
                let left_half = input.is_left_half(lens, &hit);
                arrivals.push(Arrival { slot: i as u32, pixel, left_half, share });
            }
        }
        wave_paths.connect::<R>(input, arrivals.iter().map(|arrival| arrival.slot));
        let set = light.set as u16;
        let splat = |&Arrival { slot, pixel, left_half, share }: &Arrival| {
            let flux = wave_paths.flux(slot as usize);
            let light = [0, 1, 2].map(|c| flux[c] * share[c]);
            let is_lit = light != [0.0; 3] && light.iter().all(|c| c.is_finite());
            is_lit.then_some(Splat { pixel, set, left_half, light })
        };
        arrivals.iter().filter_map(splat).collect()
    }

    /// Returns the bands in which the paths of a wave are traced, and how many of them each channel of the
    /// film receives light in. `v` in [0, 1) selects bands of red, green and blue.
    fn bands_of_wave(&self, light: &WaveLight<'_>, v: f32) -> (Vec<PathBand>, usize) {
        let count = self.bands.len();
        match (light.is_spectral(), count) {
            (true, 1) => (vec![PathBand { band: 0, weights: [1.0; 3] }], 1),
            (true, _) => (light.wavelengths(), 1),
            (false, _) => {
                let traced = count.min(BANDS_PER_PATH);
                let stride = count / traced;
                let first = (v * stride as f32) as usize;
                let of_band = |band: usize| PathBand { band, weights: self.bands[band].response };
                ((first..count).step_by(stride).map(of_band).collect(), traced)
            }
        }
    }

    /// Returns the pair that a number in [0, 1) selects.
    fn choose(&self, u: f64) -> Option<&GhostPair> {
        let mut sum = 0.0;
        let found = self.pairs.iter().find(|pair| {
            sum += pair.share;
            u < sum
        });
        found.or(self.pairs.last())
    }
}

/// Samples a wave of lights from points of the front surface. The points are distributed over the square
/// about it by the density `entry`. The square shares the tilt and decentre of the surface.
pub(super) fn sample_wave(
    input: &LightPathInput<'_>,
    lens: &RealLens,
    key: u32,
    entry: &Distribution,
    paths: &mut LightPaths,
) {
    let front = &lens.prescription.rows[0];
    let square = EntrySquare { half: front.diameter / 2.0 };
    let placed = lens.prescription.surface_transforms()[0];
    let poses = CameraPoses::new(input.camera, input.timing);
    paths.clear();
    paths.numbers.fill(key, 0);
    for i in 0..WAVE_SIZE as u32 {
        let PathNumbers { choice, entry: at_entry, light: on_light } =
            paths.numbers.of_path(i as usize);
        let DistributionSample { uv, density, .. } = entry.sample(at_entry);
        let [x, y] = square.place(uv.map(f64::from));
        if x * x + y * y > square.half * square.half {
            continue;
        }
        let [gx, gy] = front.gradient(x, y);
        // From the surface's own frame to that of the front vertex, and on to the camera's,
        // whose z points to the scene.
        let point = placed.transform_point3(DVec3::new(x, y, front.sag_at(x, y)));
        let normal = placed.transform_vector3(DVec3::new(gx, gy, -1.0));
        let outward = DVec3::new(normal.x, normal.y, -normal.z);
        let [right, up, back] = (point * lens.units_per_mm).to_array();
        let time = input.arrival_time(key, i);
        let pose = poses.at(time.scene);
        let place = DVec3::new(right, up, lens.front_depth - back);
        let place = pose.world_from_camera.transform_point3(place);
        // Normals transform by the inverse transpose; the length does not matter.
        let normal = (pose.vector_to_camera.transpose() * outward).normalize().as_vec3();
        let position = place.as_vec3();
        let error = position.abs() * gamma(4) + Vec3::splat(f32::MIN_POSITIVE);
        let from = SurfacePoint { position, error, normal, shading_normal: normal };
        let Some(light) = input.scene.sample_light(&from, normal, choice, on_light) else {
            continue;
        };
        let towards = (pose.vector_to_camera * light.direction.as_dvec3()).normalize();
        // The kernels accept only rays that travel along the axis, towards the film.
        let facing = towards.dot(outward);
        if !(facing > 0.0 && towards.z > 0.0 && light.density > 0.0) {
            continue;
        }
        let area = square.area() / f64::from(density);
        let flux = facing * area / f64::from(light.density);
        let path = LightPath {
            start: point.to_array(),
            towards,
            shadow: Ray {
                origin: from.offset_origin(light.direction).to_array(),
                direction: light.direction.to_array(),
                t_max: light.t_max,
            },
            time,
            sample: [key, i],
        };
        let flux = light.radiance.map(|l| (f64::from(l) * flux) as f32);
        paths.push(&path, flux, uv);
    }
}

/// Returns the rendered pixel that contains a film point (mm).
fn film_pixel(input: &LightPathInput<'_>, point: [f64; 2]) -> Option<[u32; 2]> {
    let frame = &input.frame;
    let pixel = input.film_map().pixel(point).map(f64::floor);
    let inside =
        (0..2).all(|i| pixel[i] >= f64::from(frame.low[i]) && pixel[i] < f64::from(frame.high[i]));
    inside.then(|| pixel.map(|p| p as u32))
}
