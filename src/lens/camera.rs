//! A camera: a lens model, a film behind it, and a place in the world.

use glam::DAffine3;

use super::aim::{Plane, TargetColumns, aim, aimed};
use super::band::Band;
use super::landing::LandingColumns;
use super::paraxial::Paraxial;
use super::placement::Placement;
use super::pose::{FilmPlane, Pose};
use super::prescription::Prescription;
use super::pupil::{Aim, PupilBound};
use super::refract::LensRay;
use super::simulated::ExactColumns;
use super::thin::ThinLens;
use super::trace::{settle, settle_lossy, trace, trace_lossy};
use super::vignetting::Vignetting;
use crate::lanes::{self, Real};
use crate::plan::EFFECTS;
use crate::rays::{Column, LensBatch, RayBatch, SampleBatch};
use crate::spectrum::LightBand;
use crate::stats::LensStats;

/// What makes rays of film samples.
#[derive(Clone, Debug)]
pub struct Camera {
    /// How light gets from the scene to the film.
    pub model: Model,
    /// Width and height of the film: mm behind a real lens, of the plane z = 1 for a thin one.
    pub film: [f64; 2],
    /// Camera space (+z to the scene) to world space.
    pub world_from_camera: DAffine3,
    /// What a weight of 1 adds to a pixel: exposure time x ISO / 100.
    pub imaging_ratio: f64,
    /// Nearest and farthest depth that is seen, camera units.
    pub depth: [f64; 2],
}

/// A model of the lens.
#[derive(Clone, Debug)]
pub enum Model {
    /// Every surface of a real lens.
    Real(Box<RealLens>),
    /// A point, or a disk that focuses perfectly on one plane.
    Thin(ThinLens),
}

/// A real lens and the film behind it.
#[derive(Clone, Debug)]
pub struct RealLens {
    /// The lens as its designer wrote it down, the stop closed as asked.
    pub prescription: Prescription,
    /// Its first-order data.
    pub paraxial: Paraxial,
    /// Rear vertex to the middle of the film along the axis, mm.
    pub film_distance: f64,
    /// How the film stands, turned about its own middle.
    pub film_pose: Pose,
    /// Camera units in a millimetre.
    pub unit: f64,
    /// Depth of the front vertex in camera space, camera units.
    pub front: f64,
    /// The light that it is traced in: all at once, or taken apart.
    pub bands: Vec<Band>,
    /// Whether surfaces take what they reflect, each by its coating. Off in a new lens.
    pub fresnel: bool,
    pub(super) bound: PupilBound,
    /// What the bound was found for.
    pub(super) film: FilmPlane,
    pub(super) aiming: Aim,
    /// Whether every ray is traced in f64.
    pub(super) double: bool,
}

impl RealLens {
    /// A lens ready to trace, with a film of this half diagonal, mm, at this distance behind
    /// the rear vertex.
    pub fn new(
        prescription: Prescription,
        film_distance: f64,
        half_diagonal: f64,
        aiming: Aim,
        unit: f64,
        front: f64,
    ) -> Self {
        let film = FilmPlane::square(film_distance, half_diagonal);
        Self::posed(prescription, &film, aiming, unit, front)
    }

    /// The same with a film that may not stand square.
    pub fn posed(
        prescription: Prescription,
        film: &FilmPlane,
        aiming: Aim,
        unit: f64,
        front: f64,
    ) -> Self {
        let paraxial = Paraxial::of(&prescription);
        Self {
            bands: vec![Band::whole(&prescription, film.distance)],
            bound: PupilBound::posed(&prescription, film, aiming),
            prescription,
            paraxial,
            film_distance: film.distance,
            film_pose: film.pose,
            film: *film,
            aiming,
            unit,
            front,
            fresnel: false,
            double: false,
        }
    }

    /// Takes the light apart: every ray is traced at one wavelength. The pupil stays that of the d
    /// line; what another wavelength lets through beside it is found by the few rays that are aimed
    /// at the whole rear element, until [`Self::cover`].
    pub fn disperse(&mut self, bands: &[LightBand]) {
        let one = |band: &LightBand| {
            Band::new(&self.prescription, self.film_distance, band.wavelength, band.response)
        };
        self.bands = bands.iter().map(one).collect();
    }

    /// Finds the bounds of the pupil again, for the first and the last of its bands too: the light of
    /// those between lies between.
    pub fn cover(&mut self) {
        let ends = [self.bands.first(), self.bands.last()].into_iter().flatten();
        let others: Vec<Prescription> =
            ends.map(|band| self.prescription.at_wavelength(band.wavelength)).collect();
        self.bound = PupilBound::coloured(&self.prescription, &others, &self.film, self.aiming);
    }

    /// The bounds of its pupil.
    pub fn bound(&self) -> &PupilBound {
        &self.bound
    }

    /// Whether film or elements stand askew.
    pub fn is_askew(&self) -> bool {
        !self.film_pose.is_square() || self.prescription.is_askew()
    }

    /// Whether turning the film about its middle changes nothing.
    pub fn is_round(&self) -> bool {
        self.prescription.is_round() && self.film_pose.is_square()
    }

    /// Where its light goes, by so many rays for a film point.
    pub fn vignetting(&self, rays: u32) -> Vignetting {
        Vignetting::posed(&self.prescription, self.film_distance, self.film_pose, rays)
    }

    /// Whether light comes to any film point of a rectangle, mm from the film's own middle.
    fn any_open(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        let Pose { decentre, .. } = self.film_pose;
        // Rings are about the axis, a grid is over the film itself.
        match self.bound.is_askew() {
            true => self.bound.any_open(low, high),
            false => {
                let moved = |v: [f64; 2]| [0, 1].map(|i| v[i] + decentre[i]);
                self.bound.any_open(moved(low), moved(high))
            }
        }
    }

    /// The film, as rays start from it.
    fn plane(&self) -> Plane {
        Plane {
            distance: self.film_distance as f32,
            index: self.prescription.rear().index as f32,
            pose: self.film_pose,
        }
    }

    /// From film samples to rays that leave the film. Answers the film.
    #[inline(always)]
    pub(super) fn launch<R: Real<Scalar = f32>>(
        &self,
        samples: &SampleBatch,
        columns: &mut LensColumns,
        stats: &mut LensStats,
    ) -> Plane {
        let LensColumns { batch, targets, .. } = columns;
        let plane = self.plane();
        aim::<R>(samples, &self.bound, &plane, targets, batch);
        stats.aimed += batch.living as u64;
        plane
    }

    /// From film samples to rays in the plane of the front vertex, with losses or without.
    #[inline(always)]
    pub(super) fn traced<R: Real<Scalar = f32>>(
        &self,
        samples: &SampleBatch,
        columns: &mut LensColumns,
        fresnel: bool,
        stats: &mut LensStats,
    ) {
        let plane = self.launch::<R>(samples, columns, stats);
        let LensColumns { batch, targets, exact, launched, .. } = columns;
        if EFFECTS && self.bands.len() > 1 {
            launched[..batch.len].copy_from_slice(&batch.weight[..batch.len]);
        }
        let start = |i| aimed(samples, &self.bound, targets, &plane, i);
        self.pass::<R>(samples.band, batch, exact, fresnel, stats, start);
    }

    /// From rays that leave the film to rays in the plane of the front vertex. `start` answers one of
    /// them once more, in f64.
    #[inline(always)]
    pub(super) fn pass<R: Real<Scalar = f32>>(
        &self,
        band: usize,
        batch: &mut LensBatch<f32>,
        exact: &mut ExactColumns,
        fresnel: bool,
        stats: &mut LensStats,
        start: impl Fn(usize) -> LensRay<f64>,
    ) {
        if self.double {
            self.pass_double(band, batch, exact, fresnel, stats);
            return;
        }
        let (blocked, band) = (&mut stats.blocked, &self.bands[band]);
        match fresnel {
            false => trace::<R>(batch, &band.surfaces, blocked),
            true => trace_lossy::<R>(batch, &band.surfaces, blocked),
        }
        stats.redone += batch.doubtful.len() as u64;
        match fresnel {
            false => settle::<R>(batch, &band.exact, blocked, start),
            true => settle_lossy::<R>(batch, &band.exact, blocked, start),
        }
    }
}

/// The columns that the lens stage works in.
#[derive(Clone, Debug, Default)]
pub struct LensColumns {
    pub(super) batch: LensBatch<f32>,
    pub(super) targets: TargetColumns,
    /// What rays of a band counted on the film.
    pub(super) launched: Column<f32>,
    pub(super) landing: LandingColumns,
    pub(super) exact: ExactColumns,
}

impl Camera {
    /// Half the diagonal of the film.
    pub fn half_diagonal(&self) -> f64 {
        self.film[0].hypot(self.film[1]) / 2.0
    }

    /// Into how many bands the light is taken apart.
    pub fn bands(&self) -> usize {
        match &self.model {
            Model::Real(lens) => lens.bands.len(),
            Model::Thin(_) => 1,
        }
    }

    /// Whether any light can come to the part of a picture of this resolution between two
    /// places, pixels.
    pub fn sees(&self, low: [f64; 2], high: [f64; 2], resolution: [u32; 2]) -> bool {
        let Model::Real(lens) = &self.model else { return true };
        // Mirrored in x and upside down in y, as the film stage has it.
        let place = |pixel: f64, i: usize| {
            let place = pixel * self.film[i] / f64::from(resolution[i]);
            if i == 0 { self.film[i] / 2.0 - place } else { place - self.film[i] / 2.0 }
        };
        lens.any_open([place(high[0], 0), place(low[1], 1)], [place(low[0], 0), place(high[1], 1)])
    }

    /// How far behind the camera's origin the film stands, camera units.
    pub fn film_behind(&self) -> f64 {
        match &self.model {
            Model::Real(lens) => {
                let front = (lens.film_distance + lens.paraxial.length) * lens.unit;
                front - lens.front
            }
            Model::Thin(_) => 0.0,
        }
    }

    /// The ray that a pixel's centre sends through the middle of its pupil, if it comes through.
    pub fn principal(&self, pixel: [u32; 2], resolution: [u32; 2], rays: &mut RayBatch) {
        let mut samples = SampleBatch { len: 1, ..SampleBatch::default() };
        for axis in 0..2 {
            let share = (f64::from(pixel[axis]) + 0.5) / f64::from(resolution[axis]) - 0.5;
            // Mirrored in x and upside down in y, as the film stage has it.
            let sign = if axis == 0 { -1.0 } else { 1.0 };
            samples.film[axis][0] = (sign * share * self.film[axis]) as f32;
        }
        // Not of the rear element, and at no distance from the middle.
        (samples.pupil[0][0], samples.pupil[1][0]) = (0.5, 0.0);
        let mut stats = LensStats::default();
        if let Model::Real(lens) = &self.model {
            stats.blocked = vec![0; lens.prescription.rows.len()];
        }
        self.expose::<f32>(&samples, &mut LensColumns::default(), rays, &mut stats);
    }

    /// From film samples to rays in world space, as many as leave the lens: a stage.
    ///
    pub fn expose<R: Real<Scalar = f32>>(
        &self,
        samples: &SampleBatch,
        columns: &mut LensColumns,
        rays: &mut RayBatch,
        stats: &mut LensStats,
    ) {
        match &self.model {
            Model::Real(lens) => {
                lens.traced::<R>(samples, columns, EFFECTS && lens.fresnel, stats);
                self.emerge::<R>(lens, &lens.bands[samples.band], &columns.batch, rays);
            }
            Model::Thin(lens) => self.project::<R>(lens, samples, rays),
        }
    }

    /// Moves the rays that came out into world space, without gaps.
    pub(super) fn emerge<R: Real<Scalar = f32>>(
        &self,
        lens: &RealLens,
        band: &Band,
        batch: &LensBatch<f32>,
        rays: &mut RayBatch,
    ) {
        let place = Placement::<R>::new(self, lens.unit, lens.front);
        let ratio = band.response.map(|response| R::constant(self.imaging_ratio * response));
        let len = batch.len;
        let x = batch.x.packets::<R>(len);
        let packets = x.len();
        let [y, z] = [&batch.y, &batch.z].map(|column| &column.packets::<R>(len)[..packets]);
        let [tx, ty, tz] =
            [&batch.tx, &batch.ty, &batch.tz].map(|column| &column.packets::<R>(len)[..packets]);
        let weight = &batch.weight.packets::<R>(len)[..packets];
        let mut alive = 0;
        for i in 0..packets {
            let living = R::bits(x[i].same(x[i]));
            // Every packet is written, the living first; the next one writes over the others.
            let order = lanes::ranks(living);
            let start = [x[i].ordered(order), y[i].ordered(order), z[i].ordered(order)];
            let towards = [tx[i].ordered(order), ty[i].ordered(order), tz[i].ordered(order)];
            let weight = weight[i].ordered(order);
            let (origin, direction, end) = place.ray(start, towards);
            let to = alive..alive + R::LANES;
            for axis in 0..3 {
                origin[axis].store(&mut rays.origin[axis][to.clone()]);
                direction[axis].store(&mut rays.direction[axis][to.clone()]);
                (weight * ratio[axis]).store(&mut rays.carried[axis][to.clone()]);
            }
            end.store(&mut rays.t_max[to.clone()]);
            for (slot, lane) in rays.slot[to].iter_mut().zip(order) {
                *slot = (i * R::LANES) as u32 + lane;
            }
            alive += living.count_ones() as usize;
        }
        rays.len = alive;
    }
}
