//! A real lens with the film behind it, ready to trace.

use super::band::Band;
use super::fidelity::F64Columns;
use super::reprojection::ReprojectionColumns;
use crate::focus::paraxial::Paraxial;
use crate::prescription::Prescription;
use crate::prescription::pose::{FilmPlane, Pose};
use crate::pupil::aim::{LaunchPlane, TargetColumns, aim, aim_one_f64};
use crate::pupil::{PupilBounds, PupilSampling};
use crate::trace::kernel::LensRay;
use crate::trace::{retrace_in_f64, retrace_in_f64_lossy, trace, trace_lossy};
use crate::vignetting::Vignetting;
use petzval_base::lanes::Real;
use petzval_base::rays::{Column, LensBatch, SampleBatch};
use petzval_base::stats::LensStats;
use petzval_spectrum::LightBand;

/// A real lens and the film behind it.
#[derive(Clone, Debug)]
pub struct RealLens {
    /// The lens as designed, with the stop set to the requested aperture.
    pub prescription: Prescription,
    /// Its first-order data.
    pub paraxial: Paraxial,
    /// Distance from the rear vertex to the centre of the film along the axis, mm.
    pub film_distance: f64,
    /// Tilt and decentre of the film about its centre.
    pub film_pose: Pose,
    /// Camera units per millimetre.
    pub units_per_mm: f64,
    /// Depth of the front vertex in camera space, camera units.
    pub front_depth: f64,
    /// The wavelength bands that are traced: one for all light, or several with dispersion.
    pub bands: Vec<Band>,
    /// Whether surfaces lose the light that they reflect, by their coatings. Off in a new lens.
    pub fresnel: bool,
    /// The part of the rear vertex plane that each film point samples.
    pub pupil_bounds: PupilBounds,
    /// The film that the pupil bounds were computed for.
    pub film: FilmPlane,
    /// How the pupil is sampled.
    pub pupil_sampling: PupilSampling,
    /// Whether every ray is traced in f64.
    pub trace_in_f64: bool,
}

impl RealLens {
    /// Makes a lens ready to trace, with a film of this half diagonal (mm) at this distance (mm)
    /// behind the rear vertex.
    pub fn new(
        prescription: Prescription,
        film_distance: f64,
        half_diagonal: f64,
        pupil_sampling: PupilSampling,
        unit: f64,
        front: f64,
    ) -> Self {
        let film = FilmPlane::aligned(film_distance, half_diagonal);
        Self::with_film(prescription, &film, pupil_sampling, unit, front)
    }

    /// Makes a lens ready to trace, with a film that may be tilted or decentred.
    pub fn with_film(
        prescription: Prescription,
        film: &FilmPlane,
        pupil_sampling: PupilSampling,
        unit: f64,
        front: f64,
    ) -> Self {
        let paraxial = Paraxial::new(&prescription);
        Self {
            bands: vec![Band::all_light(&prescription, film.distance)],
            pupil_bounds: PupilBounds::for_film(&prescription, film, pupil_sampling),
            prescription,
            paraxial,
            film_distance: film.distance,
            film_pose: film.pose,
            film: *film,
            pupil_sampling,
            units_per_mm: unit,
            front_depth: front,
            fresnel: false,
            trace_in_f64: false,
        }
    }

    /// Splits the light into bands: every ray is traced at one wavelength. The pupil bounds stay
    /// those of the d line until [`Self::bound_all_bands`]; light of other wavelengths outside them
    /// is found only by the few samples around them.
    pub fn disperse(&mut self, bands: &[LightBand]) {
        let one = |band: &LightBand| {
            Band::new(&self.prescription, self.film_distance, band.wavelength, band.response)
        };
        self.bands = bands.iter().map(one).collect();
    }

    /// Computes the pupil bounds again so that they enclose the light of the first and the last
    /// band too; the light of the bands between lies between.
    pub fn bound_all_bands(&mut self) {
        let ends = [self.bands.first(), self.bands.last()].into_iter().flatten();
        let others: Vec<Prescription> =
            ends.map(|band| self.prescription.at_checked_wavelength(band.wavelength)).collect();
        self.pupil_bounds = PupilBounds::for_wavelengths(
            &self.prescription,
            &others,
            &self.film,
            self.pupil_sampling,
        );
    }

    /// Returns the bounds of its pupil.
    pub fn pupil_bounds(&self) -> &PupilBounds {
        &self.pupil_bounds
    }

    /// Returns whether film or elements are tilted or decentred.
    pub fn is_misaligned(&self) -> bool {
        !self.film_pose.is_aligned() || self.prescription.is_misaligned()
    }

    /// Returns whether lens and film are rotationally symmetric about the axis.
    pub fn is_round(&self) -> bool {
        self.prescription.is_round() && self.film_pose.is_aligned()
    }

    /// Returns the vignetting analysis of the lens, with this number of rays per film point.
    pub fn vignetting(&self, rays: u32) -> Vignetting {
        Vignetting::for_pose(&self.prescription, self.film_distance, self.film_pose, rays)
    }

    /// Returns whether light reaches any film point of a rectangle [mm from the film's centre].
    pub(super) fn any_light(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        let Pose { decentre, .. } = self.film_pose;
        // Rings are centred on the axis; a grid covers the film itself.
        match self.pupil_bounds.uses_lens_frame() {
            true => self.pupil_bounds.any_light(low, high),
            false => {
                let moved = |v: [f64; 2]| [0, 1].map(|i| v[i] + decentre[i]);
                self.pupil_bounds.any_light(moved(low), moved(high))
            }
        }
    }

    /// Returns the density with which the pupil sampler draws a ray, per steradian: for a point of
    /// the film [mm from its centre] and a direction from it in the frame of the lens, z towards
    /// the scene, of any length. It is 0 where the sampler draws nothing, or where its samples have
    /// no weight. The lens may still block the ray.
    ///
    /// A density over the plane of the rear vertex becomes one over directions by dA = d^2 dw / cos:
    /// d is the distance to the point in that plane, and cos the cosine to the axis.
    pub fn sampling_density(&self, film: [f64; 2], direction: [f64; 3]) -> f64 {
        let [x, y, z] = self.film_pose.film_point(film);
        let [dx, dy, dz] = direction;
        let ahead = self.film_distance - z;
        let normal = self.film_pose.film_normal();
        if !(dz > 0.0 && ahead > 0.0 && normal[0] * dx + normal[1] * dy + normal[2] * dz > 0.0) {
            return 0.0;
        }
        let [u, v] = [x + dx / dz * ahead, y + dy / dz * ahead];
        let lens_frame = self.pupil_bounds.uses_lens_frame();
        let (known, point) = if lens_frame {
            (film, [u, v])
        } else if self.film_pose.is_untilted() {
            let r = x.hypot(y);
            let (cos, sin) = if r > 0.0 { (x / r, y / r) } else { (1.0, 0.0) };
            ([x, y], [cos * u + sin * v, cos * v - sin * u])
        } else {
            ([x, y], [u, v])
        };
        let [known, point] = [known, point].map(|at| at.map(|v| v as f32));
        let per_area = f64::from(self.pupil_bounds.density(known, point));
        let d2 = (u - x).powi(2) + (v - y).powi(2) + ahead * ahead;
        per_area * d2 * d2.sqrt() / ahead
    }

    /// Returns the film as rays of a band start from it.
    fn plane(&self, band: usize) -> LaunchPlane {
        LaunchPlane {
            distance: self.film_distance as f32,
            index: self.bands[band].film_index as f32,
            pose: self.film_pose,
        }
    }

    /// Makes rays that leave the film from film samples. Returns the film.
    #[inline(always)]
    pub fn launch<R: Real<Scalar = f32>>(
        &self,
        samples: &SampleBatch,
        columns: &mut LensColumns,
        stats: &mut LensStats,
    ) -> LaunchPlane {
        let LensColumns { batch, targets, .. } = columns;
        let plane = self.plane(samples.band);
        aim::<R>(samples, &self.pupil_bounds, &plane, targets, batch);
        stats.aimed += batch.live as u64;
        plane
    }

    /// Traces film samples to rays that leave the front surface, in the frame of the front vertex, with losses or without.
    #[inline(always)]
    pub fn trace_samples<R: Real<Scalar = f32>>(
        &self,
        samples: &SampleBatch,
        columns: &mut LensColumns,
        fresnel: bool,
        stats: &mut LensStats,
    ) {
        let plane = self.launch::<R>(samples, columns, stats);
        let LensColumns { batch, targets, exact, launched, .. } = columns;
        if self.bands.len() > 1 {
            launched[..batch.len].copy_from_slice(&batch.weight[..batch.len]);
        }
        let start = |i| aim_one_f64(samples, &self.pupil_bounds, targets, &plane, i);
        self.trace_batch::<R>(samples.band, batch, exact, fresnel, stats, start);
    }

    /// Traces rays that leave the film to the plane of the front vertex. `start` returns a launched
    /// ray in f64, for retracing.
    #[inline(always)]
    pub fn trace_batch<R: Real<Scalar = f32>>(
        &self,
        band: usize,
        batch: &mut LensBatch<f32>,
        exact: &mut F64Columns,
        fresnel: bool,
        stats: &mut LensStats,
        start: impl Fn(usize) -> LensRay<f64>,
    ) {
        if self.trace_in_f64 {
            self.trace_batch_f64::<R>(band, batch, exact, fresnel, stats);
            return;
        }
        let band = &self.bands[band];
        let blocked = stats.blocked_mut(self.prescription.rows.len());
        match fresnel {
            false => trace::<R>(batch, &band.to_scene, blocked),
            true => trace_lossy::<R>(batch, &band.to_scene, blocked),
        }
        let retraced = batch.needs_f64.len() as u64;
        match fresnel {
            false => retrace_in_f64::<R>(batch, &band.to_scene_f64, blocked, start),
            true => retrace_in_f64_lossy::<R>(batch, &band.to_scene_f64, blocked, start),
        }
        stats.retraced += retraced;
    }
}

/// Working columns of the lens stage.
#[derive(Clone, Debug, Default)]
pub struct LensColumns {
    /// The rays.
    pub batch: LensBatch<f32>,
    pub(crate) targets: TargetColumns,
    /// Weights of the rays of a band at the film.
    pub(crate) launched: Column<f32>,
    pub(crate) landing: ReprojectionColumns,
    /// Rays that are traced in f64.
    pub exact: F64Columns,
}
