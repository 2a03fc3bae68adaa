//! View of a film point through the plane of the rear vertex.

use glam::DVec3;

use crate::camera::RealLens;
use crate::pupil::outline::PupilBox;
use crate::trace::sequence::{Side, sequence};
use crate::trace::surface::Surface;
use crate::trace::trace;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{LensBatch, WAVE_SIZE};

/// Cells along each side of the search grid.
const GRID: usize = 64;
/// Rounds of the search: each zooms in by 32 at most.
const ROUNDS: usize = 6;

/// Traces waves of rays from a film point. Pupil points are in the film point's own frame, mm: u
/// points away from the axis, v across.
pub(super) struct PupilView {
    surfaces: Vec<Surface<f32>>,
    batch: Box<LensBatch<f32>>,
    blocked: Vec<u64>,
    /// The film point in the film's frame, and in the frame of the lens: x, y, and z towards the
    /// scene.
    film: [f64; 2],
    place: [f64; 3],
    /// Cosine and sine of the angle from x to u.
    rotation: [f64; 2],
    /// The film's axes, z towards the film.
    axes: [DVec3; 2],
    distance: f64,
    index: f64,
}

impl PupilView {
    pub fn new(lens: &RealLens, film: [f64; 2]) -> Self {
        let mut surfaces = sequence::<f32>(&lens.prescription, Side::Film(lens.film_distance));
        // An outline needs no exact directions, so no ray is retraced in f64.
        surfaces.iter_mut().for_each(|surface| surface.uncertainty = 0.0);
        let radius = film[0].hypot(film[1]);
        let rotation = if radius > 0.0 { film.map(|v| v / radius) } else { [1.0, 0.0] };
        let film_axes = lens.film_pose.transform().matrix3;
        Self {
            surfaces,
            batch: Box::default(),
            blocked: vec![0; lens.prescription.rows.len()],
            film,
            place: lens.film_pose.film_point(film),
            rotation,
            axes: [film_axes.x_axis, film_axes.y_axis],
            distance: lens.film_distance,
            index: lens.prescription.rear().index,
        }
    }

    /// Returns a tight box around the light, if there is any.
    pub fn pupil_box(&mut self, lens: &RealLens) -> Option<PupilBox> {
        let film = self.film.map(|v| v as f32);
        let bound = lens.pupil_bounds();
        if bound.uses_lens_frame() {
            // These bounds are not in the film point's frame.
            let half = lens.prescription.rear().diameter;
            return self.zoom(PupilBox::around(&[[-half, -half], [half, half]]));
        }
        let (fan, rear) = (bound.fan(film), bound.rear(film));
        let [a, b] = rear.half.map(f64::from);
        let [u, v] = rear.centre.map(f64::from);
        let whole = PupilBox::around(&[[u - a, v - b], [u + a, v + b]]);
        let point = |corner: [f32; 2]| [0, 1].map(|i| f64::from(fan.centre[i] + corner[i]));
        let expected = fan.is_open().then(|| PupilBox::around(&fan.corners.map(point)));
        let expected =
            expected.map(|pupil_box| pupil_box.grown(pupil_box.size().map(|size| 0.1 * size)));
        expected.into_iter().chain([whole]).find_map(|pupil_box| self.zoom(pupil_box))
    }

    /// Zooms in until the light fills half of the box in both directions.
    fn zoom(&mut self, mut pupil_box: PupilBox) -> Option<PupilBox> {
        for _ in 0..ROUNDS {
            let cell = pupil_box.size().map(|size| size / GRID as f64);
            let corner = pupil_box.corner();
            let place = |i: usize| {
                let (column, row) = (i % (GRID + 1), i / (GRID + 1));
                [corner[0] + cell[0] * column as f64, corner[1] + cell[1] * row as f64]
            };
            let lit = self.light((GRID + 1) * (GRID + 1), place);
            let points: Vec<_> = (0..lit.len()).filter(|&i| lit[i] > 0.0).map(place).collect();
            if points.is_empty() {
                return None;
            }
            let tight = PupilBox::around(&points).grown(cell.map(|side| 1.01 * side));
            let filled = (0..2).all(|i| tight.size()[i] > 0.5 * pupil_box.size()[i]);
            pupil_box = tight;
            if filled {
                break;
            }
        }
        Some(pupil_box)
    }

    /// Returns the transmittance from points of the pupil to the film point, 0 to 1.
    pub fn light(&mut self, count: usize, at: impl Fn(usize) -> [f64; 2]) -> Vec<f32> {
        let mut light = Vec::with_capacity(count);
        for start in (0..count).step_by(WAVE_SIZE) {
            let rays = WAVE_SIZE.min(count - start);
            for i in 0..rays {
                let [tx, ty, tz] = self.towards(at(start + i));
                let batch = &mut *self.batch;
                [batch.x[i], batch.y[i], batch.z[i]] = self.place.map(|v| v as f32);
                batch.weight[i] = 1.0;
                (batch.tx[i], batch.ty[i], batch.tz[i]) = (tx as f32, ty as f32, tz as f32);
            }
            let batch = &mut *self.batch;
            batch.resize::<f32x8>(rays);
            trace::<f32x8>(batch, &self.surfaces, &mut self.blocked);
            let left = |i: usize| if batch.x[i].is_nan() { 0.0 } else { batch.weight[i] };
            light.extend((0..rays).map(left));
        }
        light
    }

    /// Returns the direction to a point of the pupil in the frame of the lens, of the length of the
    /// index.
    pub fn towards(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let [cos, sin] = self.rotation;
        let [px, py, pz] = self.place;
        let (x, y) = (cos * u - sin * v - px, sin * u + cos * v - py);
        let z = self.distance - pz;
        let scale = self.index / (x * x + y * y + z * z).sqrt();
        [x * scale, y * scale, z * scale]
    }

    /// Returns T of a point of the pupil, along the film's own axes.
    pub fn direction(&self, point: [f64; 2]) -> [f64; 2] {
        let [x, y, z] = self.towards(point);
        // The axes have z towards the film.
        self.axes.map(|axis| axis.dot(DVec3::new(x, y, -z)))
    }
}
