//! Calibration: the camera models of computer vision that describe a real lens.
//!
//! Programs that measure in pictures describe a camera by a centre of projection, a camera matrix
//! and a polynomial of distortion. A photograph of a target gives estimates of them; here they are
//! fitted to the rays that the lens really traces. The order of the steps:
//!
//! 1. [`ray_field`]: one ray in the scene for each film point, its [`bundle`]'s centroid or the
//!    chief ray.
//! 2. [`projection_centre`]: the point nearest to all these rays. The entrance pupil of a real lens
//!    moves with the field, so they do not all pass through one point.
//! 3. [`fit`]: each [`model`], in the plane in focus, as seen from that point.
//!
//! [`warp`] maps pictures to and from an ideal pinhole, [`radial`] fits the polynomials of
//! photographers' programs, and [`spot`] draws point spreads.

pub(crate) mod bundle;
pub(crate) mod channel;
pub(crate) mod fit;
pub mod focused_lens;
pub(crate) mod model;
pub(crate) mod pixel_grid;
pub(crate) mod projection_centre;
pub(crate) mod radial;
pub(crate) mod raw_correction;
pub(crate) mod ray_field;
pub(crate) mod spot;
pub(crate) mod suitability;
pub(crate) mod warp;

use glam::DVec3;

use self::fit::{FitPoint, FitSymmetry};
use self::model::DistortionModel;
use self::pixel_grid::{PixelGrid, SightLine};
use self::projection_centre::ProjectionCentre;
use self::ray_field::{FieldBand, FieldRay, RayField};
use self::suitability::{FittedModel, Misfit, fit_model};
use petzval_lens::Prescription;
use petzval_lens::PupilSampling;
use petzval_lens::RealRayFocus;
use petzval_lens::{Camera, LensModel, RealLens};
use petzval_lens::{FilmPlane, Pose};

/// Points of the fit along the longer side of the picture.
const POINTS: usize = 41;
/// Largest error of a model that is taken without a look at more complicated ones (pixels).
const EXACT: f64 = 0.1;
/// Largest error of a model that describes a lens, relative to half the diagonal of the picture.
const COARSE: f64 = 4e-3;
/// Distances at which residuals are stated, relative to the distance in focus.
const OTHER_DISTANCES: [f64; 2] = [0.75, 1.5];
/// The same if infinity is in focus, in focal lengths.
const NEAR_FOCAL_LENGTHS: f64 = 100.0;

/// A camera to calibrate: a focused lens, and the film behind it.
#[derive(Clone, Copy, Debug)]
pub struct CalibrationSetup<'a> {
    /// The lens, with the stop and the groups as they are for the picture.
    pub lens: &'a Prescription,
    /// Distance of the film behind the rear vertex (mm).
    pub film_distance: f64,
    /// Tilt and decentre of the film.
    pub film_pose: Pose,
    /// The pixels on the film.
    pub pixels: PixelGrid,
    /// The ray that stands for a film point.
    pub ray: FieldRay,
}

/// Why a camera cannot be calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// No light reaches enough of the film.
    #[error("no light comes through the lens to the middle of the film; check stop and film")]
    Dark,
    /// The rays of the scene are parallel to each other.
    #[error("the lens has no centre of projection: its chief rays are parallel to each other")]
    Parallel,
}

/// A calibrated camera.
///
/// Positions are in the frame of the camera: mm, x to the right and y down in the picture, z towards
/// the scene from the film plane. Pixels are those of [`PixelGrid`].
#[derive(Clone, Debug)]
pub struct Calibration {
    /// The pixels.
    pub pixels: PixelGrid,
    /// The ray that stands for a film point.
    pub ray: FieldRay,
    /// The wavelength of the rays (nm).
    pub wavelength: f64,
    /// Distance of the plane in focus from the film plane (mm); may be infinite.
    pub focus: f64,
    /// Depth of the front vertex before the film plane (mm).
    pub front_depth: f64,
    /// The centre of projection.
    pub centre: ProjectionCentre,
    /// Largest angle to the axis of the rays of the picture (radians).
    pub largest_angle: f64,
    /// Share of the picture's points that receive light.
    pub lit: f64,
    /// Whether lens and film are rotationally symmetric about the axis.
    pub round: bool,
    /// The models that were tried: their fits, or why they do not describe the lens, in the order of
    /// [`DistortionModel::ALL`].
    pub models: Vec<(DistortionModel, Result<FittedModel, Misfit>)>,
    field: RayField,
}

impl<'a> CalibrationSetup<'a> {
    /// Returns the setup of the whole picture of a camera, with the centroids of bundles; `None` without a
    /// real lens.
    pub fn of_camera(camera: &'a Camera, resolution: [u32; 2]) -> Option<Self> {
        let LensModel::Real(lens) = &camera.model else { return None };
        Some(Self {
            lens: &lens.prescription,
            film_distance: lens.film_distance,
            film_pose: lens.film_pose,
            pixels: PixelGrid::new(resolution, camera.film[0]),
            ray: FieldRay::Centroid,
        })
    }

    /// Calibrates the camera at the primary wavelength, by all models. Takes some tens of
    /// milliseconds, or some tenths of a second if the lens is not round.
    ///
    /// # Errors
    /// Returns an error if the film is dark or the lens has no centre of projection.
    pub fn calibrate(&self) -> Result<Calibration, CalibrationError> {
        self.calibrate_by(&DistortionModel::ALL, |_| false)
    }

    /// Calibrates the camera by no more models than it takes to know the one that
    /// [`Calibration::suggested`] returns.
    ///
    /// # Errors
    /// As [`Self::calibrate`].
    pub fn calibrate_quickly(&self) -> Result<Calibration, CalibrationError> {
        let [_, models @ ..] = DistortionModel::ALL;
        self.calibrate_by(&models, |fit| fit.residual.max <= EXACT)
    }

    /// Calibrates the camera by some models, up to the first that is good enough.
    fn calibrate_by(
        &self,
        tried: &[DistortionModel],
        enough: fn(&FittedModel) -> bool,
    ) -> Result<Calibration, CalibrationError> {
        let Self { lens, film_distance, pixels, ray, .. } = *self;
        let field = self.field(&self.real_lens(), ray, FieldBand::One(0));
        let points = pixels.sample_points(POINTS);
        let rays: Vec<([f64; 2], SightLine)> = points
            .iter()
            .filter_map(|&pixel| Some((pixel, field.ray(pixels.film_point(pixel))?)))
            .collect();
        if rays.len() < points.len() / 10 || field.irradiance(self.middle()) <= 0.0 {
            return Err(CalibrationError::Dark);
        }
        let round = self.round().is_some();
        let centre = ProjectionCentre::of(rays.iter().map(|(_, ray)| ray), round)
            .ok_or(CalibrationError::Parallel)?;
        let front_depth = lens.film_position(film_distance);
        let focus = RealRayFocus::new(lens)
            .object_distance(film_distance)
            .map_or(f64::INFINITY, |distance| distance + front_depth);
        let seen = |distance: f64| -> Vec<FitPoint> {
            let point = |(pixel, ray): &([f64; 2], SightLine)| FitPoint {
                direction: ray.seen_from(centre.point, distance),
                pixel: *pixel,
            };
            rays.iter().map(point).collect()
        };
        let others = match focus.is_finite() {
            true => OTHER_DISTANCES.map(|share| share * focus).to_vec(),
            false => {
                let focal_length = petzval_lens::Paraxial::new(lens).focal_length;
                vec![front_depth + NEAR_FOCAL_LENGTHS * focal_length.abs()]
            }
        };
        let others: Vec<(f64, Vec<FitPoint>)> =
            others.into_iter().map(|distance| (distance, seen(distance))).collect();
        let axis = pixels.pixel(self.film_pose.decentre.map(|mm| -mm));
        let symmetry = match round {
            true => FitSymmetry::Round(axis),
            false => FitSymmetry::None { start: axis },
        };
        let in_focus = seen(focus);
        let largest_angle = rays.iter().map(|(_, ray)| ray.angle()).fold(0.0, f64::max);
        // A thin prism is for what is not round.
        let tried = tried.iter().filter(|model| !(round && **model == DistortionModel::ThinPrism));
        let tolerance = COARSE * pixels.half_diagonal() / pixels.pitch;
        let mut models = Vec::new();
        for &model in tried {
            let found = fit_model(model, &in_focus, symmetry, &others, tolerance);
            let last = found.as_ref().is_ok_and(enough);
            models.push((model, found));
            if last {
                break;
            }
        }
        Ok(Calibration {
            pixels,
            ray,
            wavelength: lens.design.primary_wavelength(),
            focus,
            front_depth,
            centre,
            largest_angle,
            lit: rays.len() as f64 / points.len() as f64,
            round,
            models,
            field,
        })
    }

    /// Returns the decentre of the film if lens and film are otherwise symmetric about the axis.
    fn round(&self) -> Option<[f64; 2]> {
        let round = self.lens.is_round() && self.film_pose.is_untilted();
        round.then_some(self.film_pose.decentre)
    }

    /// Returns the film point in the middle of the light: the axis, or the centre of the film.
    fn middle(&self) -> [f64; 2] {
        let [x, y] = self.film_pose.decentre.map(|mm| -mm);
        let [width, height] = self.pixels.film_size();
        if x.abs() < width / 2.0 && y.abs() < height / 2.0 { [x, y] } else { [0.0; 2] }
    }

    /// Returns the lens ready to trace in f64, with the film that [`RayField::trace`] needs.
    fn real_lens(&self) -> RealLens {
        let Self { lens, film_distance, film_pose, pixels, .. } = *self;
        let size = pixels.film_size();
        let film = match self.round() {
            Some(decentre) => {
                let [x, y] = [0, 1].map(|i| size[i] / 2.0 + decentre[i].abs());
                FilmPlane::aligned(film_distance, 1.03 * x.hypot(y))
            }
            None => FilmPlane {
                distance: film_distance,
                pose: film_pose,
                radius: 1.03 * pixels.half_diagonal(),
                half: size.map(|size| 0.515 * size),
            },
        };
        let mut lens = RealLens::with_film(lens.clone(), &film, PupilSampling::Pupil, 1.0, 0.0);
        lens.trace_in_f64 = true;
        lens
    }

    fn field(&self, lens: &RealLens, ray: FieldRay, band: FieldBand<'_>) -> RayField {
        RayField::trace(lens, ray, band, self.pixels.film_size(), self.round())
    }
}

impl Calibration {
    /// Returns the model to use: Brown-Conrady if it is exact to a tenth of a pixel, or else the
    /// first of the fisheye, the rational and the thin-prism model that is; the most exact if none
    /// is. `None` if none describes the lens.
    pub fn suggested(&self) -> Option<&FittedModel> {
        let usual = |fit: &&FittedModel| fit.model != DistortionModel::RadTan;
        let fitted = self.models.iter().filter_map(|(_, fit)| fit.as_ref().ok()).filter(usual);
        let exact = fitted.clone().find(|fit| fit.residual.max <= EXACT);
        exact.or_else(|| fitted.min_by(|a, b| a.residual.max.total_cmp(&b.residual.max)))
    }

    /// Returns the fit of a model, if it describes the lens.
    pub fn fitted(&self, model: DistortionModel) -> Option<&FittedModel> {
        self.models.iter().find(|(found, _)| *found == model)?.1.as_ref().ok()
    }

    /// Returns the ray that a point of the picture (pixels) shows; `None` if it is dark.
    pub fn scene_ray(&self, pixel: [f64; 2]) -> Option<SightLine> {
        self.field.ray(self.pixels.film_point(pixel))
    }

    /// Returns the irradiance at a point of the picture (pixels), relative to that in the middle.
    pub fn relative_illumination(&self, pixel: [f64; 2]) -> f64 {
        let irradiance = |pixel| self.field.irradiance(self.pixels.film_point(pixel));
        irradiance(pixel) / irradiance(self.pixels.centre())
    }

    /// Returns the largest distance (pixels, in the plane in focus) between the images of points by
    /// this calibration's rays and by those of another.
    pub fn largest_difference(&self, other: &Self) -> Option<f64> {
        let matrix = self.suggested()?.matrix;
        let differences = self.pixels.sample_points(POINTS).into_iter().filter_map(|pixel| {
            let [a, b] = [self, other].map(|one| {
                let seen = one.scene_ray(pixel)?.seen_from(self.centre.point, self.focus);
                let model = DistortionModel::KannalaBrandt;
                Some(matrix.pixel(model.distort(&[], seen)?))
            });
            let (a, b) = (a?, b?);
            Some((a[0] - b[0]).hypot(a[1] - b[1]))
        });
        Some(differences.fold(0.0, f64::max))
    }

    /// Returns the direction in which the centre of projection sees the point in focus of a pixel.
    fn seen(&self, pixel: [f64; 2]) -> Option<DVec3> {
        Some(self.scene_ray(pixel)?.seen_from(self.centre.point, self.focus))
    }
}
