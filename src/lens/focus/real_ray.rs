//! Focus by real rays: the best image of a point on the axis.
//!
//! The best focus is the plane in which the rays of the whole aperture have the smallest root mean
//! square distance from the axis. It differs from the paraxial focus by the lens's spherical
//! aberration, the more the larger the aperture.
//!
//! Tilt and decentre of elements are ignored: focus and f-number are those of the designer's lens.
//! An off-axis lens, whose apertures leave out the vertices of its surfaces, is focused as the lens
//! of which it is a part.

use std::borrow::Cow;

use petzval_base::bisection::{bisect, try_bisect};

use super::paraxial::{FocusError, Paraxial, RayTransferMatrix};
use crate::prescription::surface_aperture::SurfaceAperture;
use crate::prescription::{Prescription, Row};
use crate::trace::kernel::LensRay;
use crate::trace::sequence::{Side, sequence};
use crate::trace::surface::Surface;
use crate::trace::trace_one;

/// Rays in each plane, each for an equal share of the aperture.
const ZONES: u32 = 24;
/// Heights at which the marginal ray is searched before bisection.
const HEIGHTS: u32 = 48;
/// Bisection steps: they reach the precision of f64.
const HALVINGS: u32 = 52;

/// Focuses a lens by real rays.
pub struct RealRayFocus<'a> {
    lens: Cow<'a, Prescription>,
    paraxial: Paraxial,
    /// Distance of the start plane before the front vertex, mm.
    start: f64,
    surfaces: Vec<Surface<f64>>,
}

/// Returns whether light through an aperture does not pass the vertex of its surface.
fn leaves_out_vertex(aperture: &SurfaceAperture) -> bool {
    !aperture.obscures && !aperture.transmits(0.0, 0.0)
}

/// Returns the lens of which an off-axis lens is a part, without the arms of spiders, which block rays
/// in the planes of x and y.
fn parent_lens(mut lens: Prescription) -> Prescription {
    for row in &mut lens.rows {
        row.remove_arms();
        row.apertures.retain(|aperture| !leaves_out_vertex(aperture));
    }
    lens
}

impl<'a> RealRayFocus<'a> {
    /// Prepares a lens, at its present aperture.
    pub fn new(lens: &'a Prescription) -> Self {
        let lens = match lens.is_misaligned() {
            true => Cow::Owned(lens.centred()),
            false => Cow::Borrowed(lens),
        };
        let misled = |row: &Row| row.has_arms() || row.apertures.iter().any(leaves_out_vertex);
        let lens = match lens.rows.iter().any(misled) {
            true => Cow::Owned(parent_lens(lens.into_owned())),
            false => lens,
        };
        let front = &lens.rows[0];
        let start = 2.0 * front.sag(front.diameter / 2.0).abs() + front.diameter;
        let surfaces = sequence::<f64>(&lens, Side::Scene(start));
        Self { paraxial: Paraxial::new(&lens), lens, start, surfaces }
    }

    /// Returns the distance of the film behind the rear vertex (mm) at which an axis point `object`
    /// mm (or infinitely far) before the front vertex is sharpest; `None` if no rays pass or they
    /// do not converge.
    pub fn image_distance(&self, object: f64) -> Option<f64> {
        self.sharpest(object).ok()
    }

    /// Does the same, with the reason if there is none.
    fn sharpest(&self, object: f64) -> Result<f64, FocusError> {
        let (mut across, mut spread) = (0.0, 0.0);
        for plane in [0, 1] {
            let marginal_height = self.marginal_height(object, plane).ok_or(FocusError::NoRays)?;
            for zone in 0..ZONES {
                let share = (f64::from(zone) + 0.5) / f64::from(ZONES);
                // A central ray may be blocked by an obstruction.
                if let Some(ray) = self.ray(object, plane, marginal_height * share.sqrt()) {
                    let slope = ray.t[plane] / ray.t[2];
                    across += (ray.p[plane] - ray.p[2] * slope) * slope;
                    spread += slope * slope;
                }
            }
        }
        let film = -across / spread;
        match film.is_finite() {
            true if film > 0.0 => Ok(film),
            true => Err(FocusError::NotBehindLens { at: film }),
            false => Err(self.no_image()),
        }
    }

    fn no_image(&self) -> FocusError {
        let Paraxial { focal_length, back_focal_distance, .. } = self.paraxial;
        FocusError::NoImage { focal_length, back_focal_distance }
    }

    /// Traces the ray from a point on the axis to a height in the plane of the front vertex, along
    /// x (0) or y (1).
    fn ray(&self, object: f64, plane: usize, height: f64) -> Option<LensRay<f64>> {
        let slope = height / object;
        let length = slope.hypot(1.0);
        let (mut p, mut t) = ([0.0; 3], [0.0, 0.0, 1.0 / length]);
        p[plane] = height - slope * self.start;
        t[plane] = slope / length;
        trace_one::<f64>(LensRay::new(p, t), &self.surfaces).ok()
    }

    /// Returns the greatest height that passes the lens.
    fn marginal_height(&self, object: f64, plane: usize) -> Option<f64> {
        let most = self.lens.rows[0].diameter * 0.6;
        let passes = |height: f64| self.ray(object, plane, height).is_some();
        let height = |i: u32| most * f64::from(i) / f64::from(HEIGHTS);
        let mut last = (0..=HEIGHTS).rev().find(|&i| passes(height(i))).map(height);
        // The stop may be so small that no height of the grid passes.
        let mut small = height(1);
        while last.is_none_or(|marginal_height| marginal_height == 0.0) && small > 1e-9 * most {
            small /= 2.0;
            last = passes(small).then_some(small).or(last);
        }
        let open = last?;
        let shut = if open < height(1) { 2.0 * open.max(small) } else { open + height(1) };
        Some(bisect([open, shut], HALVINGS, passes)[0])
    }

    /// Returns the distance of the film behind the rear vertex (mm) at which objects `focus` mm (or
    /// infinitely far) before the film plane are sharpest.
    ///
    /// # Errors
    /// Returns an error if the lens cannot focus so near, or forms no image.
    pub fn film_distance(&self, focus: f64) -> Result<f64, FocusError> {
        let length = self.paraxial.length;
        let no_image = self.no_image();
        // First-order optics rejects a lens that forms no image at all.
        let expected = match self.paraxial.film_for_focus(focus) {
            Err(FocusError::TooNear { nearest, .. }) => {
                self.paraxial.film_for_focus(nearest * (1.0 + 1e-6))?
            }
            other => other?,
        };
        if focus.is_infinite() {
            return self.sharpest(focus);
        }
        let travel = self.paraxial.travel;
        let apart = |object: f64| Some(object + length + travel * self.image_distance(object)?);
        if travel < 0.0 {
            return self.film_before_mirror(focus).ok_or(no_image);
        }
        let nearest = self.nearest().ok_or(no_image)?;
        let least = apart(nearest).ok_or(no_image)?;
        if focus < least {
            return Err(FocusError::TooNear { asked: focus, nearest: least });
        }
        // Beyond the nearest object, the object moves away faster than its image approaches.
        let ends = [nearest, (focus - length - expected / 2.0).max(nearest * 2.0)];
        let too_near = |object: f64| Some(apart(object)? < focus);
        let [_, far] = try_bisect(ends, HALVINGS + 8, too_near).ok_or(no_image)?;
        self.image_distance(far).ok_or(no_image)
    }

    /// Returns the distance of a film that stands on the scene side of the last mirror: the object
    /// at the focal point has its image infinitely far on the side of the scene, and the distance
    /// between both grows with that of the object.
    fn film_before_mirror(&self, focus: f64) -> Option<f64> {
        let RayTransferMatrix { c, d, .. } = self.paraxial.whole;
        let apart =
            |object: f64| Some(object + self.paraxial.length - self.image_distance(object)?);
        let ends = [(-d / c).max(0.0), focus.abs() + 1e3 * self.paraxial.focal_length];
        // Next to the focal point no image is found.
        let too_near = |object: f64| apart(object).is_none_or(|apart| apart < focus);
        let [_, far] = bisect(ends, HALVINGS + 8, too_near);
        self.image_distance(far)
    }

    /// Returns the object distance before the front vertex (mm) at which object and film are
    /// closest to each other, by golden-section search of its logarithm around the paraxial value.
    fn nearest(&self) -> Option<f64> {
        let Err(FocusError::TooNear { nearest, .. }) = self.paraxial.film_for_focus(0.0) else {
            return None;
        };
        let film = self.paraxial.film_for_focus(nearest * (1.0 + 1e-9)).ok()?;
        let guess = nearest - self.paraxial.length - film;
        let apart = |log: f64| {
            let object = log.exp();
            self.image_distance(object).map_or(f64::INFINITY, |film| object + film)
        };
        let guess = if guess > 0.0 { guess } else { self.paraxial.focal_length };
        let (mut low, mut high) = (guess.ln() - 1.0, guess.ln() + 1.0);
        let ratio = (5f64.sqrt() - 1.0) / 2.0;
        for _ in 0..40 {
            let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
            if apart(a) <= apart(b) {
                high = b;
            } else {
                low = a;
            }
        }
        let object = ((low + high) / 2.0).exp();
        self.image_distance(object).map(|_| object)
    }

    /// Returns the object distance before the front vertex (mm) that is sharpest on a film `film`
    /// mm behind the rear vertex; infinite if that is the best possible, `None` if nothing real is
    /// sharp.
    pub fn object_distance(&self, film: f64) -> Option<f64> {
        let infinity = self.image_distance(f64::INFINITY)?;
        if film <= infinity {
            // A millionth is below the tolerance of any mount.
            return (film >= infinity * (1.0 - 1e-6)).then_some(f64::INFINITY);
        }
        // The image approaches as the object moves away.
        let ends = [0.0, 1.0 / self.nearest().unwrap_or(self.start).min(self.start)];
        let far =
            |inverse: f64| self.image_distance(1.0 / inverse).is_some_and(|image| image < film);
        let [near, _] = bisect(ends, HALVINGS, far);
        Some(1.0 / near)
    }

    /// Returns the f-number by a traced marginal ray: 1 / (2 n sin theta). Theta is the angle with
    /// the axis of the outermost ray that leaves the lens from the centre of a film focused at
    /// infinity, and n the index of the medium before the film. A uniform sky of radiance L gives that
    /// point the irradiance pi L / (4 N^2): in a medium the radiance is n^2 L.
    ///
    /// It equals focal length over pupil diameter if the lens obeys the sine condition, and differs
    /// from [`Paraxial::f_number`] by aberrations and by rims narrower than the stop. `None` if the
    /// lens forms no image.
    pub fn f_number(&self) -> Option<f64> {
        let film = self.film_distance(f64::INFINITY).ok()?;
        let surfaces = sequence::<f64>(&self.lens, Side::Film(film));
        let n = self.lens.rear().index;
        let passes = |sine: f64| {
            let t = [n * sine, 0.0, n * (1.0 - sine * sine).sqrt()];
            trace_one::<f64>(LensRay::new([0.0; 3], t), &surfaces).is_ok()
        };
        // The search range is twice the paraxial value, which may be far off.
        let expected = (0.5 / (n * self.paraxial.f_number())).min(0.5);
        let height = |i: u32| 2.0 * expected * f64::from(i) / f64::from(HEIGHTS);
        let last = (1..=HEIGHTS).rev().find(|&i| passes(height(i)))?;
        let [sine, _] = bisect([height(last), height(last + 1).min(1.0)], HALVINGS, passes);
        Some(0.5 / (n * sine))
    }
}
