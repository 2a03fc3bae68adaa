//! Focus by real rays: where a point on the axis is imaged best.
//!
//! Best is the plane in which the rays of the whole opening have the smallest root mean square
//! distance from the axis. It stands apart from the plane of first-order optics by the lens's
//! spherical aberration, the more the wider the stop is open.
//!
//! Parts of the lens that stand askew are taken to stand square: focus and f-number are the
//! designer's.

use std::borrow::Cow;

use super::paraxial::{FocusError, Paraxial};
use super::prescription::Prescription;
use super::refract::LensRay;
use super::surface::{From, Surface, sequence};
use super::trace::trace_one;

/// Rays of a bundle in each plane, of equal share of the opening.
const ZONES: u32 = 24;
/// Heights at which the rim of the bundle is looked for before it is halved in.
const HEIGHTS: u32 = 48;
/// Halvings: what they leave is below the rounding of f64.
const HALVINGS: u32 = 52;

/// A lens, to be focused.
pub struct Focus<'a> {
    lens: Cow<'a, Prescription>,
    paraxial: Paraxial,
    /// From a plane this far before the front vertex, mm.
    start: f64,
    surfaces: Vec<Surface<f64>>,
}

impl<'a> Focus<'a> {
    /// Makes a lens ready; the stop counts as it is.
    pub fn of(lens: &'a Prescription) -> Self {
        let lens = match lens.is_askew() {
            true => Cow::Owned(lens.centred()),
            false => Cow::Borrowed(lens),
        };
        let front = &lens.rows[0];
        let start = 2.0 * front.sag(front.diameter / 2.0).abs() + front.diameter;
        let surfaces = sequence::<f64>(&lens, From::Scene(start));
        Self { paraxial: Paraxial::of(&lens), lens, start, surfaces }
    }

    /// The distance of the film behind the rear vertex, mm, at which a point on the axis
    /// `object` mm (or infinitely far) before the front vertex is sharpest; none where no rays
    /// come through or they do not converge.
    pub fn image(&self, object: f64) -> Option<f64> {
        self.sharpest(object).ok()
    }

    /// As [`Self::image`], or why there is none.
    fn sharpest(&self, object: f64) -> Result<f64, FocusError> {
        let (mut across, mut spread) = (0.0, 0.0);
        for plane in [0, 1] {
            let rim = self.rim(object, plane).ok_or(FocusError::Dark)?;
            for zone in 0..ZONES {
                let share = (f64::from(zone) + 0.5) / f64::from(ZONES);
                // A ray may end in the middle, at an obstruction.
                if let Some(ray) = self.ray(object, plane, rim * share.sqrt()) {
                    let slope = ray.t[plane] / ray.t[2];
                    across += (ray.p[plane] - ray.p[2] * slope) * slope;
                    spread += slope * slope;
                }
            }
        }
        let film = -across / spread;
        match film.is_finite() {
            true if film > 0.0 => Ok(film),
            true => Err(FocusError::Inside { at: film }),
            false => Err(self.no_image()),
        }
    }

    fn no_image(&self) -> FocusError {
        let Paraxial { focal_length, back_focal_distance, .. } = self.paraxial;
        FocusError::NoImage { focal_length, back_focal_distance }
    }

    /// The ray from a point on the axis to a height in the plane of the front vertex, along x
    /// (0) or y (1).
    fn ray(&self, object: f64, plane: usize, height: f64) -> Option<LensRay<f64>> {
        let slope = height / object;
        let length = slope.hypot(1.0);
        let (mut p, mut t) = ([0.0; 3], [0.0, 0.0, 1.0 / length]);
        p[plane] = height - slope * self.start;
        t[plane] = slope / length;
        trace_one::<f64>(LensRay::new(p, t), &self.surfaces).ok()
    }

    /// The greatest height that passes.
    fn rim(&self, object: f64, plane: usize) -> Option<f64> {
        let most = self.lens.rows[0].diameter * 0.6;
        let passes = |height: f64| self.ray(object, plane, height).is_some();
        let height = |i: u32| most * f64::from(i) / f64::from(HEIGHTS);
        let mut last = (0..=HEIGHTS).rev().find(|&i| passes(height(i))).map(height);
        // A stop so small that no height of the grid meets it.
        let mut small = height(1);
        while last.is_none_or(|rim| rim == 0.0) && small > 1e-9 * most {
            small /= 2.0;
            last = passes(small).then_some(small).or(last);
        }
        let open = last?;
        let shut = if open < height(1) { 2.0 * open.max(small) } else { open + height(1) };
        Some(edge(open, shut, passes))
    }

    /// The distance of the film behind the rear vertex, mm, that makes what is `focus` mm (or
    /// infinitely far) before the film plane sharpest.
    ///
    /// # Errors
    /// Where the lens cannot focus so near, or forms no image.
    pub fn film(&self, focus: f64) -> Result<f64, FocusError> {
        let length = self.paraxial.length;
        let no_image = self.no_image();
        // First-order optics knows a lens that forms no image at all.
        let expected = match self.paraxial.film_for_focus(focus) {
            Err(FocusError::TooNear { nearest, .. }) => {
                self.paraxial.film_for_focus(nearest * (1.0 + 1e-6))?
            }
            other => other?,
        };
        if focus.is_infinite() {
            return self.sharpest(focus);
        }
        let apart = |object: f64| Some(object + length + self.image(object)?);
        let nearest = self.nearest().ok_or(no_image)?;
        let least = apart(nearest).ok_or(no_image)?;
        if focus < least {
            return Err(FocusError::TooNear { asked: focus, nearest: least });
        }
        // Farther objects than the nearest move away faster than their images come nearer.
        let (mut near, mut far) = (nearest, (focus - length - expected / 2.0).max(nearest * 2.0));
        for _ in 0..HALVINGS + 8 {
            let middle = (near + far) / 2.0;
            if apart(middle).ok_or(no_image)? < focus {
                near = middle;
            } else {
                far = middle;
            }
        }
        self.image(far).ok_or(no_image)
    }

    /// The object distance before the front vertex, mm, at which object and film are nearest to
    /// each other: by golden sections of its logarithm around the paraxial one.
    fn nearest(&self) -> Option<f64> {
        let Err(FocusError::TooNear { nearest, .. }) = self.paraxial.film_for_focus(0.0) else {
            return None;
        };
        let film = self.paraxial.film_for_focus(nearest * (1.0 + 1e-9)).ok()?;
        let guess = nearest - self.paraxial.length - film;
        let apart = |log: f64| {
            let object = log.exp();
            self.image(object).map_or(f64::INFINITY, |film| object + film)
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
        self.image(object).map(|_| object)
    }

    /// The distance before the front vertex, mm, that is sharpest on a film `film` mm behind the
    /// rear vertex; infinite where that is the best it can, none where nothing real is sharp.
    pub fn object(&self, film: f64) -> Option<f64> {
        let infinity = self.image(f64::INFINITY)?;
        if film <= infinity {
            // A millionth is below what any mount holds.
            return (film >= infinity * (1.0 - 1e-6)).then_some(f64::INFINITY);
        }
        // The image comes nearer as the object goes away.
        let (mut near, mut far) = (0.0, 1.0 / self.nearest().unwrap_or(self.start).min(self.start));
        for _ in 0..HALVINGS {
            let middle = (near + far) / 2.0;
            match self.image(1.0 / middle) {
                Some(image) if image < film => near = middle,
                _ => far = middle,
            }
        }
        Some(1.0 / near)
    }

    /// The f-number by a traced marginal ray: 1 / (2 sin theta), theta the angle with the axis of
    /// the outermost ray that leaves the lens from the middle of a film on which infinitely far
    /// things are sharpest. A uniform sky of radiance L gives that point pi L / (4 N^2). It is focal
    /// length over diameter of the bundle where the lens obeys the sine condition, and differs from
    /// [`Paraxial::f_number`] by aberrations and by rims narrower than the stop. None where the
    /// lens forms no image.
    pub fn f_number(&self) -> Option<f64> {
        let film = self.film(f64::INFINITY).ok()?;
        let surfaces = sequence::<f64>(&self.lens, From::Film(film));
        let n = self.lens.rear().index;
        let passes = |sine: f64| {
            let t = [n * sine, 0.0, n * (1.0 - sine * sine).sqrt()];
            trace_one::<f64>(LensRay::new([0.0; 3], t), &surfaces).is_ok()
        };
        // By the paraxial f-number, which may be off by far.
        let expected = (0.5 / self.paraxial.f_number()).min(0.5);
        let height = |i: u32| 2.0 * expected * f64::from(i) / f64::from(HEIGHTS);
        let last = (1..=HEIGHTS).rev().find(|&i| passes(height(i)))?;
        Some(0.5 / edge(height(last), (height(last + 1)).min(1.0), passes))
    }
}

/// The last number, on the way from one that holds to one that does not, that holds.
fn edge(mut holds: f64, mut fails: f64, test: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = (holds + fails) / 2.0;
        if test(middle) {
            holds = middle;
        } else {
            fails = middle;
        }
    }
    holds
}
