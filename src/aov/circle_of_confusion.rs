//! Circle of confusion to first order.

use crate::lens::{Camera, LensModel};

/// First-order circle of confusion as a function of depth, in camera units.
#[derive(Clone, Copy, Debug)]
pub(super) struct CircleOfConfusion {
    /// Depth of the front vertex [camera units].
    front: f64,
    /// Millimetres per camera unit.
    mm_per_unit: f64,
    /// A ray from an axis point at distance s before the front vertex meets the film at (offset + s
    /// per_distance) times its slope.
    offset: f64,
    per_distance: f64,
    /// Change of both coefficients per mm that the film moves back.
    per_film_shift: [f64; 2],
    /// Displacement of the film to the back per mm along each of its axes.
    tilt: [f64; 2],
    /// The entrance pupil: distance behind the front vertex and diameter (mm).
    pupil: [f64; 2],
}

impl CircleOfConfusion {
    /// Returns the circle of confusion of a real lens; `None` for other models.
    pub fn new(camera: &Camera) -> Option<Self> {
        let LensModel::Real(lens) = &camera.model else { return None };
        let (paraxial, whole) = (&lens.paraxial, &lens.paraxial.whole);
        let reduced = lens.film_distance / paraxial.film_index;
        let back = |own: [f64; 2]| -lens.film_pose.film_point(own)[2];
        Some(Self {
            front: lens.front_depth,
            mm_per_unit: 1.0 / lens.units_per_mm,
            offset: whole.b + reduced * whole.d,
            per_distance: whole.a + reduced * whole.c,
            per_film_shift: [whole.d, whole.c].map(|of| of / paraxial.film_index),
            tilt: [back([1.0, 0.0]), back([0.0, 1.0])],
            pupil: [paraxial.entrance_pupil.position, paraxial.entrance_pupil.diameter],
        })
    }

    /// Returns the diameter (um) for a point at a depth [camera units], seen from a film point
    /// (mm).
    pub fn diameter(&self, depth: f64, film: [f64; 2]) -> f64 {
        let distance = (depth - self.front) * self.mm_per_unit;
        let [position, diameter] = self.pupil;
        // Slope of the ray through the rim of the pupil.
        let slope = diameter / 2.0 / (distance + position);
        let back = self.tilt[0] * film[0] + self.tilt[1] * film[1];
        let [offset, per_distance] = self.per_film_shift.map(|change| change * back);
        (2e3 * slope * (self.offset + offset + distance * (self.per_distance + per_distance))).abs()
    }
}
