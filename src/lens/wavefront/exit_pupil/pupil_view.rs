//! View of a film point through the plane of the rear vertex.

use glam::DVec3;

use crate::camera::RealLens;
use crate::prescription::Prescription;
use crate::pupil::outline::PupilBox;
use crate::pupil::scan::{BoxSearch, PupilScan, rough_surfaces};

/// Columns and rows of the search grid.
const GRID: usize = 65;
/// Margin of the search, in steps of the grid.
const MARGIN: f64 = 1.01;

/// Traces waves of rays from a film point. Pupil points are in the film point's own frame, mm: u
/// points away from the axis, v across.
pub(super) struct PupilView {
    scan: PupilScan,
    /// The film point in the film's frame, and in the frame of the lens: x, y, and z towards the
    /// scene.
    film: [f64; 2],
    place: [f64; 3],
    /// Cosine and sine of the angle from x to u.
    rotation: [f64; 2],
    /// The film's axes, z towards the film.
    axes: [DVec3; 2],
}

impl PupilView {
    /// Takes a film point (mm, the film's frame) and the lens, whose openings are those of a prescription.
    pub fn new(lens: &RealLens, prescription: &Prescription, film: [f64; 2]) -> Self {
        let film_distance = &lens.film_distance;
        let surfaces = rough_surfaces(prescription, *film_distance);
        let radius = film[0].hypot(film[1]);
        let rotation = if radius > 0.0 { film.map(|v| v / radius) } else { [1.0, 0.0] };
        let film_axes = lens.film_pose.transform().matrix3;
        Self {
            scan: PupilScan::new(prescription, *film_distance, surfaces),
            film,
            place: lens.film_pose.film_point(film),
            rotation,
            axes: [film_axes.x_axis, film_axes.y_axis],
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

    fn zoom(&mut self, pupil_box: PupilBox) -> Option<PupilBox> {
        let search = BoxSearch { points: GRID, margin: MARGIN, mirrored: false };
        search.zoom(pupil_box, |grid| {
            self.light(grid.len(), |i| grid.at(i)).into_iter().map(|light| light > 0.0).collect()
        })
    }

    /// Returns the transmittance from points of the pupil to the film point, 0 to 1.
    pub fn light(&mut self, count: usize, at: impl Fn(usize) -> [f64; 2]) -> Vec<f32> {
        let mut light = vec![0.0; count];
        let rotation = self.rotation;
        self.scan.trace(self.place, count, |i| turned(at(i), rotation), |i, left| light[i] = left);
        light
    }

    /// Returns T of a point of the pupil, along the film's own axes.
    pub fn direction(&self, point: [f64; 2]) -> [f64; 2] {
        let [x, y, z] = self.scan.towards(self.place, turned(point, self.rotation));
        // The axes have z towards the film.
        self.axes.map(|axis| axis.dot(DVec3::new(x, y, -z)))
    }
}

/// Returns a point of the pupil in the frame of the lens.
fn turned([u, v]: [f64; 2], [cos, sin]: [f64; 2]) -> [f64; 2] {
    [cos * u - sin * v, sin * u + cos * v]
}
