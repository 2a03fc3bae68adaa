//! How far things go on the film.

use glam::{DAffine3, DVec3};

use super::view::View;
use super::{By, Harm, Question};
use crate::lens::Camera;
use crate::motion::Motion;
use crate::rays::{NONE, RayBatch};
use crate::scene::{Scene, TraversalStack};
use crate::shutter::{Rolling, Timing};

/// What moves, and when.
#[derive(Clone, Copy, Debug)]
pub struct Moves<'a> {
    /// What is seen.
    pub scene: &'a Scene,
    /// When the film is exposed, with all that moves and rolls.
    pub timing: &'a Timing,
    /// How rows are read, where it is not all at once, and who says so.
    pub rolling: Option<(Rolling, By)>,
    /// From pixel to pixel, um.
    pub pitch: f64,
}

impl Moves<'_> {
    /// Whether anything does, the camera included.
    pub(super) fn any(&self) -> bool {
        !self.scene.movers().is_empty() || self.timing.ride.is_some()
    }
}

/// Steps of a path from one time to another.
const STEPS: u32 = 8;
/// Things whose paths are followed; of more, some are left out.
const MOST_THINGS: usize = 4096;
/// Rows and columns of the pixels whose rays are looked at.
const GRID: u32 = 16;

/// How far anything that is seen goes on the film between two shares of the motion, at most: for
/// things by their boxes, for a camera by what the pixels of a grid see.
pub(super) fn travel(question: &Question, range: [f64; 2]) -> Harm {
    let Moves { scene, timing, pitch, .. } = question.moves;
    let path = Path::new(question.camera, question.resolution, timing.ride.as_ref(), range);
    let mut pixels: f64 = 0.0;
    let every = scene.movers().len() / MOST_THINGS + 1;
    for ([low, high], motion) in scene.moving_boxes().step_by(every) {
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        for i in 0..27 {
            let share = DVec3::from([i % 3, i / 3 % 3, i / 9].map(|step| f64::from(step) / 2.0));
            let point = low + (high - low) * share;
            pixels = pixels.max(path.length(|time| motion.at(time).transform_point3(point)));
        }
    }
    if timing.ride.is_some() {
        for point in seen(question) {
            pixels = pixels.max(path.length(|_| point));
        }
    }
    Harm::Blur { um: pixels * pitch, pixels }
}

/// The film while time passes.
struct Path {
    view: View,
    /// Times, and world space to camera space at each.
    times: Vec<(f64, DAffine3)>,
}

impl Path {
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
        Self { view: View::of(camera, resolution), times: (0..=STEPS).map(at).collect() }
    }

    /// The length of the path of a point, pixels, as far as it is on the film.
    fn length(&self, place: impl Fn(f64) -> DVec3) -> f64 {
        let mut last: Option<([f64; 2], bool)> = None;
        let mut length = 0.0;
        for (time, camera_from_world) in &self.times {
            let now = self.view.pixel(camera_from_world.transform_point3(place(*time)));
            if let (Some((a, before)), Some((b, after))) = (last, now)
                && (before || after)
            {
                length += (b[0] - a[0]).hypot(b[1] - a[1]);
            }
            last = now;
        }
        if length.is_finite() { length } else { 0.0 }
    }
}

/// The share of the pixels of a grid whose rays come near to what moves.
pub(super) fn share_near(question: &Question) -> f64 {
    let (mut near, mut all) = (0, 0);
    principal(question, |rays| {
        all += 1;
        near += u32::from(question.moves.scene.comes_near(rays, 0));
    });
    f64::from(near) / f64::from(all.max(1))
}

/// What the pixels of a grid see, world space.
fn seen(question: &Question) -> Vec<DVec3> {
    let Moves { scene, timing, .. } = question.moves;
    let size = scene.bounds().map_or(1.0, |[low, high]| (high - low).length());
    // What is seen of the sky is farther away than anything.
    let far = 1e4 * (size + question.camera.world_from_camera.translation.length() as f32 + 1.0);
    let (mut stack, mut points) = (TraversalStack::default(), Vec::new());
    principal(question, |rays| {
        let ray = rays.ray(0);
        let hit = scene.closest_at::<f32>(&ray, timing.middle() as f32, &mut stack);
        let t = f64::from(if hit.shape == NONE { far } else { hit.t });
        let [origin, direction] =
            [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
        points.push(origin + direction * t);
    });
    points
}

/// The rays of a grid of pixels through the middle of their pupils, one after the other.
fn principal(question: &Question, mut see: impl FnMut(&RayBatch)) {
    let mut rays = RayBatch::default();
    for i in 0..GRID * GRID {
        let place = [i % GRID, i / GRID];
        let pixel =
            [0, 1].map(|axis| (2 * place[axis] + 1) * question.resolution[axis] / (2 * GRID));
        question.camera.principal(pixel, question.resolution, &mut rays);
        if rays.len > 0 {
            see(&rays);
        }
    }
}
