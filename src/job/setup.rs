//! From what a scene file says of its camera to a camera.

use super::place::Place;
use super::{Changes, FocusOn, JobError};
use crate::film::Frame;
use crate::image::{Note, Notes};
use crate::lens::{
    self, Camera, D_LINE, FilmPlane, FocusModel, Iris, LensError, MASKS, Mask, Model, Pose,
    Prescription, RealLens, ThinLens,
};
use crate::plan::{By, Decision, Effect, Plan, Posed, Wanted};
use crate::scene::pbrt::{FilmSpec, IrisSpec, RealisticSpec, ThinSpec};
use crate::sensor::ev100;
use crate::source::{Location, Warning};

/// Model, size of the film, exposure, and the depth that is seen.
type Parts = (Model, [f64; 2], f64, [f64; 2]);

/// A camera in the making: what was noticed, and what to write about it into the picture.
pub(super) struct Setup {
    pub at: Location,
    pub warnings: Vec<Warning>,
    pub notes: Notes,
    /// What does not stand square, simulated or not.
    pub posed: Option<Posed>,
    /// The share of the light that the shutter lets through.
    pub efficiency: f64,
}

impl Setup {
    /// Warns of effects that are asked for by name and cannot be had.
    pub fn missed(&mut self, wanted: &Wanted, plan: &Plan) {
        let Wanted::But(list) = wanted else { return };
        for decision in &plan.effects {
            let Decision { effect, on, reason, .. } = decision;
            if !on && list.contains(&(*effect, true)) {
                let message = format!("--effects +{}: it stays off: {reason}", effect.name());
                self.warnings.push(Warning { at: self.at.clone(), message });
            }
        }
    }

    /// Warns of glass in light that its data do not cover: that of the d line, by which the lens is
    /// focused, or of the bands it is traced in.
    pub fn doubt(&mut self, lens: &RealLens) {
        let used = lens.bands.iter().map(|band| band.wavelength);
        let (low, high) =
            used.fold((D_LINE, D_LINE), |(low, high), nm| (low.min(nm), high.max(nm)));
        for doubt in lens.prescription.doubtful_indices([low, high]) {
            let message = format!("lens {}: {doubt}", lens.prescription.name);
            self.warnings.push(Warning { at: self.at.clone(), message });
        }
    }

    /// Warns where diffraction does not know the light around a part of a picture.
    pub fn cropped(&mut self, frame: &Frame, plan: &Plan) {
        if frame.size() != frame.resolution && plan.has(Effect::Diffraction) {
            let message = "diffraction takes the light beyond the crop to be like that inside, so the \
                           crop is not exactly that part of the whole picture; with --effects \
                           -diffraction it is";
            self.warnings.push(Warning { at: self.at.clone(), message: message.to_owned() });
        }
    }

    /// Notes a number, where it is one.
    pub fn number(&mut self, name: &'static str, value: f64) {
        if !value.is_nan() {
            self.notes.push((name, Note::Number(value)));
        }
    }

    pub fn thin(&mut self, spec: &ThinSpec, film: &FilmSpec, resolution: [u32; 2]) -> Parts {
        let pixels = f64::from(resolution[0]) / f64::from(resolution[1]);
        let aspect = spec.aspect.unwrap_or(pixels);
        let short = 2.0 * (spec.fov.to_radians() / 2.0).tan();
        let (size, middle) = match spec.window {
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
        let name = if lens.radius > 0.0 { "thin lens" } else { "pinhole" };
        self.notes.push(("lensModel", Note::Text(name.to_owned())));
        if lens.radius > 0.0 {
            self.number("focus", lens.focus);
        }
        self.number("expTime", spec.exposure_time);
        (Model::Thin(lens), size, spec.exposure_time * film.iso / 100.0, spec.depth)
    }

    /// One of pbrt's names, or a picture.
    fn iris(&self, IrisSpec { name, path }: &IrisSpec) -> Result<Iris, JobError> {
        if name == "circular" {
            return Ok(Iris::Round);
        }
        if let Some(mask) = Mask::named_by_pbrt(name) {
            return Ok(Iris::Mask(mask));
        }
        let known = MASKS.join(", ");
        Mask::image_by_pbrt(path).map(Iris::Mask).map_err(|error| JobError::Camera {
            at: self.at.clone(),
            problem: format!(
                "aperture \"{name}\": {error}; expected circular, {known} or a picture"
            ),
        })
    }

    /// How the film stands; and takes down how film and lens were meant to, before they are set
    /// square where that is asked for.
    fn poses(&mut self, lens: &mut Prescription, spec: &RealisticSpec, changes: &Changes) -> Pose {
        let (RealisticSpec::V4 { film_pose, .. } | RealisticSpec::V2 { film_pose, .. }) = spec;
        let film = Pose::of_film(
            changes.film_shift.unwrap_or(film_pose.film_shift()),
            changes.film_tilt.unwrap_or(film_pose.tilt),
        );
        if film.is_square() && !lens.is_askew() {
            return Pose::SQUARE;
        }
        let by = match changes.film_shift.is_some() || changes.film_tilt.is_some() {
            _ if film.is_square() => By::Lens,
            true => By::Flag,
            false => By::Scene,
        };
        self.posed = Some(Posed { lens: lens.clone(), film, by });
        if changes.effects.of(Effect::TiltShift) == Some(false) {
            lens.centre();
            return Pose::SQUARE;
        }
        film
    }

    pub fn real(
        &mut self,
        spec: &RealisticSpec,
        film: &FilmSpec,
        place: Place<'_>,
        changes: &Changes,
    ) -> Result<Parts, JobError> {
        let (RealisticSpec::V4 { lens: file, lens_at, aperture, .. }
        | RealisticSpec::V2 { lens: file, lens_at, aperture, .. }) = spec;
        let aperture = *aperture;
        let diagonal = match spec {
            RealisticSpec::V4 { .. } => film.diagonal,
            RealisticSpec::V2 { film_diagonal, .. } => *film_diagonal,
        };
        let mut prescription = match &changes.lens {
            Some(other) => lens::read(other)?,
            None => lens::read(file).map_err(|source| match source {
                LensError::Io { .. } => JobError::Unreadable { at: lens_at.clone(), source },
                // It names its own line.
                LensError::Malformed { .. } => source.into(),
            })?,
        };
        if let Some(coating) = changes.coating {
            prescription.coat(coating);
        }
        if changes.assume_vd {
            let guessed: Vec<&str> =
                prescription.assume_dispersion().iter().map(|glass| glass.name).collect();
            self.notes.push(("assumedGlass", Note::Text(guessed.join(" "))));
        }
        if let RealisticSpec::V4 { iris: Some(iris), .. } = spec {
            let stop = prescription.stop();
            prescription.rows[stop].iris = self.iris(iris)?;
        }
        if changes.effects.of(Effect::Iris) == Some(false) {
            for row in &mut prescription.rows {
                (row.iris, row.obstruction) = (Iris::Round, 0.0);
            }
        }
        let aperture = match changes.f_number {
            Some(asked) => stop_for(&prescription, asked)?,
            None => aperture,
        };
        let opened = prescription.stop_down(aperture);
        if opened < aperture * (1.0 - 1e-9) && changes.lens.is_none() {
            self.warnings.push(Warning {
                at: self.at.clone(),
                message: format!(
                    "a stop of {aperture} mm is asked for, but the lens opens to {opened} mm"
                ),
            });
        }
        let film_pose = self.poses(&mut prescription, spec, changes);
        let camera = |problem: String| JobError::Camera { at: self.at.clone(), problem };
        let film_for = |metres: f64| {
            changes
                .focus_model
                .film(&prescription, metres * 1e3, diagonal)
                .map_err(|error| camera(error.to_string()))
        };
        let (from_file, unit, ratio, depth, time) = match spec {
            RealisticSpec::V4 { focus, exposure_time, .. } => {
                let ratio = exposure_time * film.iso / 100.0;
                (Ok(*focus), 1e-3, ratio, [0.0, f64::INFINITY], *exposure_time)
            }
            RealisticSpec::V2 { film_distance, depth, .. } => {
                (Err(*film_distance), 1.0, 1.0, *depth, 0.0)
            }
        };
        let [x, y] = place.frame.resolution.map(f64::from);
        let aspect = y / x;
        let width = diagonal / (1.0 + aspect * aspect).sqrt();
        let size = [width, width * aspect];
        let stands_at = |film_distance: f64| -> Result<RealLens, JobError> {
            let rim = prescription.rear_reach();
            let corner = |x: f64, y: f64| film_pose.film_point([x * size[0], y * size[1]])[2];
            let ahead = corner(0.5, 0.5).abs().max(corner(0.5, -0.5).abs());
            let nearest = film_distance - ahead;
            if nearest <= rim {
                let tilted = if ahead > 0.0 { " where it is nearest" } else { "" };
                return Err(camera(format!(
                    "the film, {nearest:.4} mm behind the rear vertex{tilted}, would stand inside \
                     the lens, which reaches {rim:.4} mm behind it; focus nearer"
                )));
            }
            // The origin of pbrt-v4's camera is the film, that of the course the front vertex.
            let front = match spec {
                RealisticSpec::V4 { .. } => (film_distance + prescription.length()) * unit,
                RealisticSpec::V2 { .. } => 0.0,
            };
            let lens = prescription.clone();
            let beyond =
                [0, 1].map(|i| place.reach[i] * size[i] / f64::from(place.frame.resolution[i]));
            let radius = diagonal / 2.0 + beyond[0].hypot(beyond[1]);
            let half = [0, 1].map(|i| size[i] / 2.0 + beyond[i]);
            let film = FilmPlane { distance: film_distance, pose: film_pose, radius, half };
            Ok(RealLens::posed(lens, &film, changes.aim, unit, front))
        };
        let by_distance = from_file.is_ok() || changes.focus.is_some();
        if !by_distance && changes.focus_model == FocusModel::Pbrt {
            let message = "--focus-model pbrt: the scene says where the film stands, so it stays \
                           there; give --focus too";
            self.warnings.push(Warning { at: self.at.clone(), message: message.to_owned() });
        }
        let unchanged = || from_file.map_or_else(Ok, film_for);
        let lens = match changes.focus {
            None => stands_at(unchanged()?)?,
            Some(FocusOn::Distance(metres)) => stands_at(film_for(metres)?)?,
            Some(FocusOn::Pixel(pixel)) => {
                let mut lens = stands_at(unchanged()?)?;
                // The view changes a little with the focus: look again from where it is then.
                for _ in 0..2 {
                    let model = Model::Real(Box::new(lens));
                    let world_from_camera = place.world_from_camera;
                    let camera = Camera {
                        model,
                        film: size,
                        world_from_camera,
                        imaging_ratio: ratio,
                        depth,
                    };
                    lens = stands_at(film_for(place.depth(&camera, pixel)? * 1e-3 / unit)?)?;
                }
                lens
            }
        };
        let film_distance = lens.film_distance;
        let focus = lens::Focus::of(&prescription).object(film_distance).unwrap_or(f64::NAN);
        let in_focus = (focus + lens.paraxial.length + film_distance) * 1e-3;
        self.notes.push(("lensModel", Note::Text(lens.prescription.name.clone())));
        if !lens.paraxial.is_afocal() {
            self.number("effectiveFocalLength", lens.paraxial.focal_length);
            self.number("aperture", lens.paraxial.f_number());
        }
        self.number("focus", in_focus);
        if by_distance && changes.focus_model == FocusModel::Pbrt {
            self.notes.push(("focusModel", Note::Text("pbrt".to_owned())));
        }
        self.number("filmDistance", film_distance);
        self.number("stopDiameter", opened);
        if !lens.film_pose.is_square() {
            let pair = |[x, y]: [f64; 2]| Note::Text(format!("{x} {y}"));
            self.notes.push(("filmShift", pair(lens.film_pose.film_shift())));
            self.notes.push(("filmTilt", pair(lens.film_pose.tilt)));
        }
        self.number("entrancePupilOffset", lens.paraxial.entrance_pupil.position);
        self.number("expTime", time);
        // The dialect of 2016 has no shutter.
        if time > 0.0 {
            let ev = ev100(lens.paraxial.f_number(), time * self.efficiency, changes.iso(film));
            self.number("exposureValue", ev);
        }
        Ok((Model::Real(Box::new(lens)), size, ratio, depth))
    }
}

/// The diameter of the stop, mm, that gives an f-number by a traced marginal ray: so that the
/// light on the film follows it, whatever the aberrations of the pupil.
fn stop_for(lens: &Prescription, asked: f64) -> Result<f64, JobError> {
    let f_number = |diameter: f64| {
        let mut closed = lens.clone();
        closed.stop_down(diameter);
        lens::Focus::of(&closed).f_number().unwrap_or(f64::INFINITY)
    };
    let (mut narrow, mut wide) = (0.0, lens.rows[lens.stop()].diameter);
    let open = f_number(wide);
    if open.is_infinite() {
        return Err(JobError::Asked(format!("--fstop {asked}: {} forms no image", lens.name)));
    }
    if asked >= open * (1.0 - 1e-3) {
        // Fifty halvings leave nothing of any stop.
        for _ in 0..50 {
            let middle = (narrow + wide) / 2.0;
            if f_number(middle) > asked {
                narrow = middle;
            } else {
                wide = middle;
            }
        }
        return Ok(wide);
    }
    Err(JobError::Asked(format!(
        "--fstop {asked}: {} opens to f/{open:.2} and no wider; expected {open:.2} or more",
        lens.name
    )))
}
