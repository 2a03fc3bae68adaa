//! Motion of the image on the film.

use glam::{DAffine3, DVec3};

use super::{DecidedBy, PlanInput};
use crate::film_projection::FilmProjection;
use crate::timing::Timing;
use petzval_base::rays::{NO_INDEX, RayBatch};
use petzval_lens::Camera;
use petzval_scene::motion::Motion;
use petzval_scene::shutter::RollingShutter;
use petzval_scene::{Scene, TraversalStack};

/// Moving parts of a scene, and the times of samples.
#[derive(Clone, Copy, Debug)]
pub struct MotionInput<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The times of samples with motion and rolling shutter.
    pub timing: &'a Timing,
    /// The rolling shutter and its source, if there is one.
    pub rolling: Option<(RollingShutter, DecidedBy)>,
    /// The distance from pixel to pixel (um).
    pub pitch: f64,
}

impl MotionInput<'_> {
    /// Returns whether anything moves, including the camera.
    pub(super) fn any(&self) -> bool {
        !self.scene.animated_instances().is_empty() || self.timing.camera_motion.is_some()
    }
}

/// Steps of a path over the time range.
const STEPS: u32 = 8;
/// Largest number of objects whose paths are followed. Of more objects, every nth is.
const MAX_OBJECTS: usize = 4096;
/// Rows and columns of the grid of pixels whose rays are traced.
const GRID: u32 = 16;

/// Returns the length of the longest path on the film (pixels) of any visible point between two times,
/// given as shares of the motion. Objects are represented by their boxes. Under a moving camera, the points that a grid of
/// pixels sees are followed too.
pub(super) fn image_motion(input: &PlanInput, range: [f64; 2]) -> f64 {
    let MotionInput { scene, timing, .. } = input.motion;
    let path = ImagePath::new(input.camera, input.resolution, timing.camera_motion.as_ref(), range);
    let mut pixels: f64 = 0.0;
    let every = scene.animated_instances().len() / MAX_OBJECTS + 1;
    for ([low, high], motion) in scene.animated_bounds().step_by(every) {
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        for i in 0..27 {
            let share = DVec3::from([i % 3, i / 3 % 3, i / 9].map(|step| f64::from(step) / 2.0));
            let point = low + (high - low) * share;
            pixels = pixels.max(path.length(|time| motion.at(time).transform_point3(point)));
        }
    }
    if timing.camera_motion.is_some() {
        for point in seen(input) {
            pixels = pixels.max(path.length(|_| point));
        }
    }
    pixels
}

/// Projection onto the film at a series of times.
struct ImagePath {
    projection: FilmProjection,
    /// The times, and the transform from world to camera space at each.
    times: Vec<(f64, DAffine3)>,
}

impl ImagePath {
    fn new(
        camera: &Camera,
        resolution: [u32; 2],
        ride: Option<&Motion>,
        [from, to]: [f64; 2],
    ) -> Self {
        let rest = camera.world_from_camera.inverse();
        let at = |step: u32| {
            let time = from + (to - from) * f64::from(step) / f64::from(STEPS);
            let back = ride.map_or(DAffine3::IDENTITY, |ride| ride.at(time).inverse());
            (time, rest * back)
        };
        Self {
            projection: FilmProjection::of(camera, resolution),
            times: (0..=STEPS).map(at).collect(),
        }
    }

    /// Returns the length of the path of a point on the film (pixels).
    fn length(&self, place: impl Fn(f64) -> DVec3) -> f64 {
        let mut last: Option<[f64; 2]> = None;
        let mut length = 0.0;
        for (time, camera_from_world) in &self.times {
            let point = camera_from_world.transform_point3(place(*time));
            let now = self.projection.pixel(point, last);
            if let (Some(a), Some(b)) = (last, now)
                && [a, b].iter().any(|&pixel| self.projection.is_on_film(pixel))
            {
                let [x, y] = self.projection.displacement(a, b);
                length += x.hypot(y);
            }
            last = now;
        }
        if length.is_finite() { length } else { 0.0 }
    }
}

/// Returns the share of the pixels of a grid whose rays meet the boxes around moving objects.
pub(super) fn share_near(input: &PlanInput) -> f64 {
    let (mut near, mut all) = (0, 0);
    central_rays(input, |rays| {
        all += 1;
        near += u32::from(input.motion.scene.may_hit_animated(rays, 0));
    });
    f64::from(near) / f64::from(all.max(1))
}

/// Returns the points that the pixels of a grid see, in world space.
fn seen(input: &PlanInput) -> Vec<DVec3> {
    let MotionInput { scene, timing, .. } = input.motion;
    let size = scene.bounds().map_or(1.0, |[low, high]| (high - low).length());
    // The sky is farther away than any surface.
    let far = 1e4 * (size + input.camera.world_from_camera.translation.length() as f32 + 1.0);
    let (mut stack, mut points) = (TraversalStack::default(), Vec::new());
    central_rays(input, |rays| {
        let ray = rays.ray(0);
        let hit = scene.closest_at::<f32>(&ray, timing.first_row_middle() as f32, &mut stack);
        let t = f64::from(if hit.shape == NO_INDEX { far } else { hit.t });
        let [origin, direction] =
            [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
        points.push(origin + direction * t);
    });
    points
}

/// Calls `see` with the central ray of each pixel of a grid.
fn central_rays(input: &PlanInput, mut see: impl FnMut(&RayBatch)) {
    let mut rays = RayBatch::default();
    for i in 0..GRID * GRID {
        let place = [i % GRID, i / GRID];
        let pixel = [0, 1].map(|axis| (2 * place[axis] + 1) * input.resolution[axis] / (2 * GRID));
        input.camera.central_ray(pixel, input.resolution, &mut rays);
        if rays.len > 0 {
            see(&rays);
        }
    }
}
