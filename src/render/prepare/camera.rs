//! Camera of a job: pinhole, thin lens, parallel rays, sphere or real lens, from its description in
//! a scene file.

use super::focus::{FilmPlacement, FilmPlacer, View};
use super::lens::{align, f_number_diameter, read_lens};
use super::report::Report;
use super::{Changes, ExcludedEffects, FocusOn, PrepareError};
use crate::plan::Misalignment;
use crate::sensor::ev100;
use petzval_base::io::ReadContext;
use petzval_lens::{
    FocusModel, LensModel, Orthographic, Paraxial, Pose, RealRayFocus, SphericalMapping, ThinLens,
};
use petzval_scene_formats::pbrt::{CameraSpec, FilmSpec, RealisticSpec, SphericalSpec, ThinSpec};

/// Everything that a camera is made from, besides its description.
#[derive(Clone, Copy)]
pub(super) struct CameraInput<'a> {
    /// For reading the lens and its iris.
    pub context: &'a ReadContext,
    pub film: &'a FilmSpec,
    pub changes: &'a Changes,
    pub excluded: ExcludedEffects,
    /// The efficiency of the shutter: the share of the light that it passes.
    pub efficiency: f64,
    pub view: View<'a>,
}

/// A camera without its pose in the world.
pub(super) struct CameraSetup {
    pub model: LensModel,
    /// The size of the film, in the units of [`Camera::film`](petzval_lens::Camera::film).
    pub film_size: [f64; 2],
    /// Exposure time times ISO / 100.
    pub imaging_ratio: f64,
    /// The nearest and the farthest depth that is seen.
    pub depth: [f64; 2],
    /// The tilts and shifts of lens and film, simulated or not; `None` if there are none.
    pub misalignment: Option<Misalignment>,
}

impl CameraInput<'_> {
    /// Sets up the camera of a scene file.
    ///
    /// # Errors
    /// Returns an error if its lens cannot be read, stopped down or focused as asked.
    pub fn set_up(
        &self,
        spec: &CameraSpec,
        report: &mut Report,
    ) -> Result<CameraSetup, PrepareError> {
        match (spec, self.changes.needs_lens()) {
            (CameraSpec::Thin(thin), Some(_)) if thin.takes_lens && self.changes.lens.is_some() => {
                self.mounted(thin, report)
            }
            (CameraSpec::Thin(_) | CameraSpec::Spherical(_), Some(setting)) => {
                let problem = format!("{setting} is given, but this camera has no lens file");
                Err(PrepareError::Camera { at: report.camera_at.clone(), problem })
            }
            (CameraSpec::Thin(spec), None) => Ok(self.thin(spec, report)),
            (CameraSpec::Spherical(spec), None) => Ok(self.spherical(spec, report)),
            (CameraSpec::Realistic(spec), _) => self.real(spec, report),
        }
    }

    fn thin(&self, spec: &ThinSpec, report: &mut Report) -> CameraSetup {
        let resolution = self.view.frame.resolution;
        let pixels = f64::from(resolution[0]) / f64::from(resolution[1]);
        let aspect = spec.aspect.unwrap_or(pixels);
        let parallel = spec.fov.is_none();
        let short = match spec.fov {
            Some(fov) => 2.0 * (fov.to_radians() / 2.0).tan(),
            // Parallel rays end in this window in the plane z = 0. With a lens, as in pbrt-v4, all
            // rays come from the lens at the origin, and the window is in the plane in focus.
            None if spec.lens_radius > 0.0 => 2.0 / spec.focal_distance,
            None => 2.0,
        };
        let (film_size, middle) = match spec.window {
            Some([x0, x1, y0, y1]) => {
                let half = short / 2.0;
                (
                    [(x1 - x0) * half, (y1 - y0) * half],
                    [(x0 + x1) / 2.0 * half, (y0 + y1) / 2.0 * half],
                )
            }
            None if aspect >= 1.0 => ([short * aspect, short], [0.0; 2]),
            None => ([short, short / aspect], [0.0; 2]),
        };
        let lens = ThinLens { radius: spec.lens_radius, focus: spec.focal_distance, middle };
        let (name, model) = match lens.radius > 0.0 {
            true => ("thin lens", LensModel::Thin(lens)),
            false if parallel => ("orthographic", LensModel::Orthographic(Orthographic { middle })),
            false => ("pinhole", LensModel::Thin(lens)),
        };
        report.text("lensModel", name.to_owned());
        if lens.radius > 0.0 {
            report.number("focus", lens.focus);
        }
        self.without_glass(model, film_size, spec.depth, spec.exposure_time, report)
    }

    fn spherical(&self, spec: &SphericalSpec, report: &mut Report) -> CameraSetup {
        let name = match spec.mapping {
            SphericalMapping::EqualArea => "spherical, equal area",
            SphericalMapping::Equirectangular => "spherical, equirectangular",
        };
        report.text("lensModel", name.to_owned());
        let (model, depth) = (LensModel::Spherical(spec.mapping), [0.0, f64::INFINITY]);
        self.without_glass(model, [1.0; 2], depth, spec.exposure_time, report)
    }

    /// Returns a camera that is not a real lens.
    fn without_glass(
        &self,
        model: LensModel,
        film_size: [f64; 2],
        depth: [f64; 2],
        exposure_time: f64,
        report: &mut Report,
    ) -> CameraSetup {
        report.number("expTime", exposure_time);
        let imaging_ratio = exposure_time * self.film.iso / 100.0;
        CameraSetup { model, film_size, imaging_ratio, depth, misalignment: None }
    }

    /// Sets up the user's lens in the place of a pinhole. It is wide open and focused on what the
    /// middle of the picture sees, unless the user asks for something else.
    fn mounted(&self, thin: &ThinSpec, report: &mut Report) -> Result<CameraSetup, PrepareError> {
        let spec = RealisticSpec::V4 {
            lens: self.changes.lens.clone().unwrap_or_default(),
            lens_at: report.camera_at.clone(),
            aperture: f64::INFINITY,
            iris: None,
            focus: f64::INFINITY,
            exposure_time: thin.exposure_time,
            film_pose: Pose::default(),
        };
        let focus = self.changes.focus.or(Some(FocusOn::Pixel(None)));
        let changes = Changes { focus, ..self.changes.clone() };
        CameraInput { changes: &changes, ..*self }.real(&spec, report)
    }

    fn real(&self, spec: &RealisticSpec, report: &mut Report) -> Result<CameraSetup, PrepareError> {
        let Self { film, changes, .. } = *self;
        let mut prescription = read_lens(self, spec, report)?;
        let (RealisticSpec::V4 { aperture, .. } | RealisticSpec::V2 { aperture, .. }) = spec;
        let aperture = match changes.f_number {
            Some(f_number) => f_number_diameter(&prescription, f_number, report)?,
            None => *aperture,
        };
        let stop_diameter = prescription.stop_down(aperture);
        if stop_diameter < aperture * (1.0 - 1e-9) && changes.lens.is_none() {
            report.warn(format!(
                "a stop of {aperture} mm is asked for, but the lens opens to {stop_diameter} mm"
            ));
        }
        let (film_pose, misalignment) =
            align(&mut prescription, spec, changes, self.excluded.tilt_shift);
        let (placement, diagonal, unit, imaging_ratio, depth, time) = match spec {
            RealisticSpec::V4 { focus, exposure_time, .. } => {
                let ratio = exposure_time * film.iso / 100.0;
                let placement = FilmPlacement::FocusedAt(*focus);
                let depth = [0.0, f64::INFINITY];
                (placement, film.diagonal, 1e-3, ratio, depth, *exposure_time)
            }
            RealisticSpec::V2 { film_distance, film_diagonal, depth, .. } => {
                (FilmPlacement::Distance(*film_distance), *film_diagonal, 1.0, 1.0, *depth, 0.0)
            }
        };
        let diagonal = changes.film_diagonal.unwrap_or(diagonal);
        let [x, y] = self.view.frame.resolution.map(f64::from);
        let aspect = y / x;
        let width = diagonal / (1.0 + aspect * aspect).sqrt();
        let film_size = [width, width * aspect];
        let focused = matches!(placement, FilmPlacement::FocusedAt(_)) || changes.focus.is_some();
        let pbrt_focus = changes.focus_model == FocusModel::Pbrt;
        if !focused && pbrt_focus {
            let message = "'focus_model' pbrt: the scene says where the film stands, so it stays \
                           there; give 'focus' too";
            report.warn(message.to_owned());
        }
        let placer = FilmPlacer {
            prescription: &prescription,
            film_pose,
            film_size,
            diagonal,
            unit,
            // The origin of pbrt-v4's camera is the film; that of pbrt-v2's is the front vertex.
            origin_at_film: matches!(spec, RealisticSpec::V4 { .. }),
            imaging_ratio,
            depth,
            changes,
            view: &self.view,
            camera_at: report.camera_at.clone(),
        };
        let lens = placer.focus(placement)?;
        // Groups that move for focus change the focal length and the pupil; the f-number is that at
        // infinity. As for an f-number that is asked for, it is that of the marginal ray.
        let f_number = RealRayFocus::new(&prescription)
            .f_number()
            .unwrap_or_else(|| Paraxial::new(&prescription).f_number());
        let film_distance = lens.film_distance;
        let object_distance = RealRayFocus::new(&lens.prescription)
            .object_distance(film_distance)
            .unwrap_or(f64::NAN);
        report.text("lensModel", lens.prescription.name.clone());
        if !lens.paraxial.is_afocal() {
            report.number("effectiveFocalLength", lens.paraxial.focal_length);
            report.number("aperture", f_number);
        }
        report.number(
            "focus",
            (object_distance + lens.prescription.film_position(film_distance)) * 1e-3,
        );
        if focused && pbrt_focus {
            report.text("focusModel", "pbrt".to_owned());
        }
        report.number("filmDistance", film_distance);
        report.number("stopDiameter", stop_diameter);
        if !lens.film_pose.is_aligned() {
            let pair = |[x, y]: [f64; 2]| format!("{x} {y}");
            report.text("filmShift", pair(lens.film_pose.film_shift()));
            report.text("filmTilt", pair(lens.film_pose.tilt));
        }
        report.number("entrancePupilOffset", lens.paraxial.entrance_pupil.position);
        report.number("expTime", time);
        // pbrt-v2's camera has no shutter.
        if time > 0.0 {
            let pitch = 1e3 * film_size[0] / x;
            let ev = ev100(f_number, time * self.efficiency, changes.iso(film, pitch));
            report.number("exposureValue", ev);
        }
        Ok(CameraSetup {
            model: LensModel::Real(Box::new(lens)),
            film_size,
            imaging_ratio,
            depth,
            misalignment,
        })
    }
}
