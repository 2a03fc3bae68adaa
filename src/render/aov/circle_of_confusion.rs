//! Circle of confusion to first order.

use petzval_lens::{Camera, LensModel, RealLens};

/// First-order circle of confusion as a function of depth, in camera units: the image on the film of a
/// point, by the rays through the entrance pupil.
#[derive(Clone, Copy, Debug)]
pub struct CircleOfConfusion {
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
    /// Returns the diameter that usually counts as sharp on a film of this diagonal: a 1500th of it.
    pub fn sharp_diameter(diagonal: f64) -> f64 {
        diagonal / 1500.0
    }

    /// Returns the circle of confusion of a real lens; `None` for other models.
    pub fn new(camera: &Camera) -> Option<Self> {
        match &camera.model {
            LensModel::Real(lens) => Some(Self::of_lens(lens)),
            _ => None,
        }
    }

    /// Returns the circle of confusion of a lens.
    pub fn of_lens(lens: &RealLens) -> Self {
        let (paraxial, whole) = (&lens.paraxial, &lens.paraxial.whole);
        let reduced = lens.film_distance / paraxial.film_index;
        let back = |own: [f64; 2]| -lens.film_pose.film_point(own)[2];
        Self {
            front: lens.front_depth,
            mm_per_unit: 1.0 / lens.units_per_mm,
            offset: whole.b + reduced * whole.d,
            per_distance: whole.a + reduced * whole.c,
            per_film_shift: [whole.d, whole.c].map(|of| of / paraxial.film_index),
            tilt: [back([1.0, 0.0]), back([0.0, 1.0])],
            pupil: [paraxial.entrance_pupil.position, paraxial.entrance_pupil.diameter],
        }
    }

    /// Returns the diameter (um) for a point at a depth [camera units], which may be infinite, seen
    /// from a film point (mm).
    pub fn diameter(&self, depth: f64, film: [f64; 2]) -> f64 {
        let distance = (depth - self.front) * self.mm_per_unit;
        let [position, diameter] = self.pupil;
        let back = self.tilt[0] * film[0] + self.tilt[1] * film[1];
        let [offset, per_distance] = self.per_film_shift.map(|change| change * back);
        let per_distance = self.per_distance + per_distance;
        // Slope of the ray through the rim of the pupil times its coefficient.
        let height = match distance.is_infinite() {
            true => diameter / 2.0 * per_distance,
            false => {
                let slope = diameter / 2.0 / (distance + position);
                slope * (self.offset + offset + distance * per_distance)
            }
        };
        (2e3 * height).abs()
    }

    /// Returns the nearest and the farthest distance from the front vertex (mm) whose circle of
    /// confusion on the axis is not larger than this diameter (mm): the depth of field about a
    /// distance in focus (mm). The second is infinite if no distance is too far. `None` if no
    /// distance is sharp enough.
    ///
    /// It is the solution of [`CircleOfConfusion::diameter`] for the distance, with either sign of
    /// the diameter: the rays meet behind the film or before it. The film stands where the distance
    /// in focus is sharp to first order; by aberrations, the smallest spot is a little beside.
    pub fn depth_of_field(&self, focus: f64, diameter: f64) -> Option<[f64; 2]> {
        let [position, pupil] = self.pupil;
        let [offset, per_distance] = self.focused_at(focus);
        let distance =
            |signed: f64| (signed * position - pupil * offset) / (pupil * per_distance - signed);
        let mut ends = [distance(diameter), distance(-diameter)];
        ends.sort_by(f64::total_cmp);
        // Rays from a point behind the camera converge: such a point is beyond infinity.
        let beyond = |end: f64| if end > 0.0 { end } else { f64::INFINITY };
        let [near, far] = match ends {
            [low, high] if low > 0.0 => [low, high],
            [low, high] => [high, beyond(low)],
        };
        (near > 0.0 && near.is_finite()).then_some([near, far])
    }

    /// Returns the distance from the front vertex (mm) at which to focus so that infinity is just sharp: its circle of
    /// confusion on the axis has this diameter (mm).
    pub fn hyperfocal(&self, diameter: f64) -> f64 {
        let [offset, per_distance] = self.focused_at(f64::INFINITY);
        let [by_offset, by_distance] = self.per_film_shift;
        // The film moves back until the height at infinity, half of the pupil times the coefficient, is half of the circle.
        let shift = (diameter / (self.pupil[1] * by_distance)).abs();
        -(offset + shift * by_offset) / (per_distance + shift * by_distance)
    }

    /// Returns both coefficients of the axis with the film where a distance from the front vertex (mm) is sharp.
    fn focused_at(&self, focus: f64) -> [f64; 2] {
        let Self { offset, per_distance, per_film_shift: [by_offset, by_distance], .. } = *self;
        let shift = match focus.is_finite() {
            true => -(offset + focus * per_distance) / (by_offset + focus * by_distance),
            false => -per_distance / by_distance,
        };
        [offset + shift * by_offset, per_distance + shift * by_distance]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thin lens of 50 mm at f/2, on the front vertex, with the film where `focus` (mm) is sharp.
    fn thin(focus: f64) -> CircleOfConfusion {
        let film = 1.0 / (1.0 / 50.0 - 1.0 / focus);
        CircleOfConfusion {
            front: 0.0,
            mm_per_unit: 1.0,
            offset: film,
            per_distance: 1.0 - film / 50.0,
            per_film_shift: [1.0, -1.0 / 50.0],
            tilt: [0.0; 2],
            pupil: [0.0, 25.0],
        }
    }

    #[test]
    fn the_depth_of_field_is_that_of_a_thin_lens() {
        // The hyperfocal distance f^2 / (N c) + f.
        let (circle, hyperfocal) = (0.03, 50.0 * 50.0 / (2.0 * 0.03) + 50.0);
        for focus in [400.0, 3000.0, 0.9 * hyperfocal, 1.1 * hyperfocal, 1e7] {
            let [near, far] = thin(focus).depth_of_field(focus, circle).expect("limits");
            let expected = focus * (hyperfocal - 50.0) / (hyperfocal + focus - 2.0 * 50.0);
            assert!((near / expected - 1.0).abs() < 1e-9, "{focus}: {near}, not {expected}");
            let expected = match focus < hyperfocal {
                true => focus * (hyperfocal - 50.0) / (hyperfocal - focus),
                false => f64::INFINITY,
            };
            assert!(far == expected || (far / expected - 1.0).abs() < 1e-9, "{focus}: {far}");
            for end in [near, far.min(1e12)] {
                let blur = thin(focus).diameter(end, [0.0; 2]);
                assert!(blur <= 1e3 * circle * (1.0 + 1e-9), "{focus}, {end}: {blur}");
            }
        }
        let found = thin(700.0).hyperfocal(circle);
        assert!((found / hyperfocal - 1.0).abs() < 1e-9, "{found}, not {hyperfocal}");
        let [near, far] =
            thin(f64::INFINITY).depth_of_field(f64::INFINITY, circle).expect("limits");
        assert!((near / (hyperfocal - 50.0) - 1.0).abs() < 1e-9 && far.is_infinite(), "{near}");
    }

    #[test]
    fn infinity_is_the_limit_of_far_points() {
        for focus in [500.0, 2000.0, f64::INFINITY] {
            let confusion = thin(focus);
            let [far, infinity] = [1e9, f64::INFINITY].map(|at| confusion.diameter(at, [0.0; 2]));
            // A thin lens focused at s blurs a point at u by D f (1 - s / u) / (s - f), and the sky by
            // D f / (s - f). Focused at infinity, it blurs the point by D f / u.
            let difference = 1e3 * 25.0 * 50.0 / (1.0 - 50.0 / focus) / 1e9;
            let found = (far - infinity).abs();
            assert!((found / difference - 1.0).abs() < 1e-3, "{focus}: {found}, {difference}");
            let expected = 1e3 * 25.0 * 50.0 / (focus - 50.0);
            assert!((infinity - expected).abs() < 1e-6 * expected.max(1.0), "{focus}: {infinity}");
        }
    }

    #[test]
    fn the_depth_of_field_is_that_about_the_focus_wherever_the_film_is() {
        for focus in [500.0, 2000.0, f64::INFINITY] {
            let expected = thin(focus).depth_of_field(focus, 0.03).expect("limits");
            let found = thin(1000.0).depth_of_field(focus, 0.03).expect("limits");
            for (found, expected) in found.into_iter().zip(expected) {
                let same = found == expected || (found / expected - 1.0).abs() < 1e-9;
                assert!(same, "{focus}: {found}, not {expected}");
            }
        }
    }
}
