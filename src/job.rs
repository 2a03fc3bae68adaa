//! From what a scene file asks for, and what the command line changes, to a job.

use std::path::PathBuf;

use glam::DAffine3;

use crate::aov::Aov;
use crate::film::{Filter, Frame, Response};
use crate::image::{Note, Notes};
use crate::lens::{self, Aim, Camera, LensError, Model, Prescription, RealLens, ThinLens};
use crate::lens::{Coating, Iris, MASKS, Mask};
use crate::plan::{Effect, Question, Visible, Wanted, plan};
use crate::rays::{HitBatch, NONE, RayBatch};
use crate::render::Job;
use crate::scene::pbrt::{CameraSpec, Description, FilmSpec, IrisSpec, RealisticSpec, ThinSpec};
use crate::scene::{Scene, TraversalStack};
use crate::sensor::{self, ev100};
use crate::source::{Location, Warning};
use crate::spectrum::{bands, white_balance};

/// What to focus on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FocusOn {
    /// A distance, metres from the film; infinite is allowed.
    Distance(f64),
    /// What a pixel sees, or the middle of the picture.
    Pixel(Option<[u32; 2]>),
}

/// What may be asked for instead of what the scene file says.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// Another lens file.
    pub lens: Option<PathBuf>,
    /// Another distance in focus.
    pub focus: Option<FocusOn>,
    /// Another f-number, by the marginal ray ([`lens::Focus::f_number`]).
    pub f_number: Option<f64>,
    /// What to coat faces to air with that have no coating of their own; given, surfaces take what
    /// they reflect.
    pub coating: Option<Coating>,
    /// Another size of the picture, pixels.
    pub resolution: Option<[u32; 2]>,
    /// Which effects to simulate.
    pub effects: Wanted,
    /// From what on one counts as visible.
    pub visible: Visible,
    /// First pixel, and first pixel not, that is rendered.
    pub crop: Option<[[u32; 2]; 2]>,
    /// Samples a pixel.
    pub samples: Option<u32>,
    /// Seed of the random numbers.
    pub seed: Option<u32>,
    /// How film points choose where to aim.
    pub aim: Aim,
    /// Layers beside the colours.
    pub layers: Vec<Aov>,
    /// Whether the picture's format holds layers, so that those of the scene file are wanted.
    pub holds_layers: bool,
    /// A sensor that reads the picture out.
    pub sensor: Option<sensor::Settings>,
}

impl Changes {
    /// The speed that the picture is taken at.
    fn iso(&self, film: &FilmSpec) -> f64 {
        self.sensor.and_then(|sensor| sensor.iso).unwrap_or(film.iso)
    }

    /// The option that makes sense with a real lens only, if one is given.
    fn needs_lens(&self) -> Option<&'static str> {
        let given = [
            (self.lens.is_some(), "--lens"),
            (self.focus.is_some(), "--focus"),
            (self.f_number.is_some(), "--fstop"),
            (self.coating.is_some(), "--coating"),
        ];
        given.into_iter().find(|(given, _)| *given).map(|(_, option)| option)
    }
}

/// Why a scene cannot be photographed as asked.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// The lens file.
    #[error(transparent)]
    Lens(#[from] LensError),
    /// The camera and its lens do not fit together.
    #[error("{at}: {problem}")]
    Camera {
        /// Where the camera stands in the scene file.
        at: Location,
        /// What is wrong.
        problem: String,
    },
    /// The command line asks for what cannot be.
    #[error("{0}")]
    Asked(String),
}

/// Makes a scene ready to render. Answers the job, what to write about it into the picture, and
/// what was noticed on the way.
///
/// # Errors
/// Where the lens cannot be read, or cannot do what is asked of it.
pub fn prepare(
    description: Description,
    changes: &Changes,
) -> Result<(Job, Notes, Vec<Warning>), JobError> {
    let Description { scene, camera, world_from_camera, camera_at, film, warnings, .. } =
        description;
    let mut setup = Setup { at: camera_at, warnings, notes: Notes::new() };
    let frame = frame(&film, changes)?;
    let response = Response {
        filter: Filter::new(description.filter.profile, description.filter.radius),
        brightest: film.brightest,
        balance: film.white_balance.map(white_balance),
    };
    let (model, size, imaging_ratio, depth) = match camera {
        CameraSpec::Thin(_) if changes.needs_lens().is_some() => {
            let option = changes.needs_lens().unwrap_or_default();
            let problem = format!("{option} is given, but this camera has no lens file");
            return Err(JobError::Camera { at: setup.at, problem });
        }
        CameraSpec::Thin(spec) => setup.thin(&spec, &film, frame.resolution),
        CameraSpec::Realistic(spec) => {
            let reach = response.filter.reach();
            let place = Place { scene: &scene, world_from_camera, frame: &frame, reach };
            setup.real(&spec, &film, place, changes)?
        }
    };
    let samples = changes.samples.unwrap_or(description.samples);
    let seed = changes.seed.unwrap_or(description.seed);
    let pitch = 1e3 * pitch(&model, &film, size, frame.resolution);
    let asked = changes.sensor.map(|settings| settings.sensor(film.iso, pitch));
    let sensor = asked.filter(|_| changes.effects.of(Effect::Sensor) != Some(false));
    if let Some(sensor) = &sensor {
        setup.notes.push(("sensor", Note::Text(sensor.to_string())));
    }
    setup.number("isoSpeed", changes.iso(&film));
    setup.number("filmWidth", size[0]);
    setup.number("filmHeight", size[1]);
    setup.number("samplesPerPixel", f64::from(samples));
    setup.number("seed", f64::from(seed));
    let mut camera = Camera { model, film: size, world_from_camera, imaging_ratio, depth };
    let plan = plan(&Question {
        camera: &camera,
        resolution: frame.resolution,
        coated: changes.coating.is_some(),
        sensor: asked.as_ref(),
        samples,
        moves: description.moves,
        wanted: &changes.effects,
        visible: changes.visible,
    });
    if let Model::Real(lens) = &mut camera.model {
        lens.fresnel = plan.has(Effect::Fresnel);
        if plan.has(Effect::Dispersion) {
            lens.disperse(&bands());
        }
    }
    setup.notes.push(("effects", Note::Text(plan.line())));
    let job = Job {
        scene,
        camera,
        plan,
        frame,
        film: response,
        samples: 0..samples,
        seed,
        reach: description.reach,
        layers: layers(&film, changes),
        sensor,
    };
    if let (Some(aov), Model::Thin(_)) =
        (job.layers.iter().find(|aov| aov.needs_lens()), &job.camera.model)
    {
        let name = format!("{aov:?}").to_lowercase();
        return Err(JobError::Asked(format!("--aov {name}: this camera has no lens file")));
    }
    Ok((job, setup.notes, setup.warnings))
}

/// The distance from pixel to pixel, mm.
fn pitch(model: &Model, film: &FilmSpec, size: [f64; 2], resolution: [u32; 2]) -> f64 {
    let [width, height] = resolution.map(f64::from);
    match model {
        Model::Real(_) => size[0] / width,
        // Its own film is measured in distances from the pinhole.
        Model::Thin(_) => film.diagonal / width.hypot(height),
    }
}

/// The layers that the command line or a film of the kind "gbuffer" asks for, each once.
fn layers(film: &FilmSpec, changes: &Changes) -> Vec<Aov> {
    let given: &[Aov] = match film.gbuffer && changes.holds_layers {
        true => &[Aov::Depth, Aov::Position, Aov::Normal, Aov::Albedo, Aov::Variance],
        false => &[],
    };
    let mut layers = Vec::new();
    for &aov in changes.layers.iter().chain(given) {
        if !layers.contains(&aov) {
            layers.push(aov);
        }
    }
    layers
}

fn frame(film: &FilmSpec, changes: &Changes) -> Result<Frame, JobError> {
    let resolution = changes.resolution.unwrap_or(film.resolution);
    // A crop in the scene file is in its own pixels; it keeps its share of the picture.
    let scaled = |pixel: [u32; 2]| {
        [0, 1].map(|i| {
            let share = f64::from(pixel[i]) / f64::from(film.resolution[i]);
            (share * f64::from(resolution[i])).round() as u32
        })
    };
    let [low, high] = changes.crop.unwrap_or(film.bounds.map(scaled));
    let inside = (0..2).all(|i| low[i] < high[i] && high[i] <= resolution[i]);
    if !inside {
        return Err(JobError::Asked(format!(
            "the crop {},{},{},{} leaves nothing of a picture of {} x {} pixels; \
             it reads X0,Y0,X1,Y1 with X1 and Y1 not included",
            low[0], low[1], high[0], high[1], resolution[0], resolution[1]
        )));
    }
    let pixels = u64::from(high[0] - low[0]) * u64::from(high[1] - low[1]);
    if pixels > MOST_PIXELS {
        return Err(JobError::Asked(format!(
            "a picture of {pixels} pixels would take about {} GB of memory; render it in parts of \
             at most {MOST_PIXELS} pixels with --crop",
            pixels * BYTES_PER_PIXEL / 1_000_000_000
        )));
    }
    Ok(Frame { resolution, low, high })
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

/// Pixels of one render.
const MOST_PIXELS: u64 = 1 << 27;
/// Sums by tile and by film, the picture, and room to encode it.
const BYTES_PER_PIXEL: u64 = 72;

/// What the film looks at.
struct Place<'a> {
    scene: &'a Scene,
    world_from_camera: DAffine3,
    frame: &'a Frame,
    /// How far beyond the picture's edge its samples lie, pixels.
    reach: [f64; 2],
}

impl Place<'_> {
    /// How far before the film plane, in camera units, stands what a pixel sees through the
    /// middle of the pupil; infinitely far where it sees nothing.
    fn depth(&self, camera: &Camera, pixel: Option<[u32; 2]>) -> Result<f64, JobError> {
        let resolution = self.frame.resolution;
        let pixel = pixel.unwrap_or(resolution.map(|n| n / 2));
        let [x, y] = pixel;
        if (0..2).any(|i| pixel[i] >= resolution[i]) {
            return Err(JobError::Asked(format!(
                "--focus auto@{x},{y}: the picture has {} x {} pixels, counted from 0",
                resolution[0], resolution[1]
            )));
        }
        let mut rays = RayBatch::default();
        camera.principal(pixel, resolution, &mut rays);
        if rays.len == 0 {
            return Err(JobError::Asked(format!(
                "--focus auto@{x},{y}: no light comes through the middle of the lens to this pixel"
            )));
        }
        let mut hits = HitBatch::default();
        self.scene.intersect::<f32>(&rays, &mut hits, &mut TraversalStack::default());
        let ray = rays.ray(0);
        let hit = [0, 1, 2]
            .map(|i| f64::from(ray.origin[i]) + f64::from(hits[0].t) * f64::from(ray.direction[i]));
        let depth = self.world_from_camera.inverse().transform_point3(hit.into()).z;
        let depth = depth + camera.film_behind();
        Ok(if hits[0].shape == NONE || depth <= 0.0 { f64::INFINITY } else { depth })
    }
}

type Parts = (Model, [f64; 2], f64, [f64; 2]);

struct Setup {
    at: Location,
    warnings: Vec<Warning>,
    notes: Notes,
}

impl Setup {
    fn number(&mut self, name: &'static str, value: f64) {
        self.notes.push((name, Note::Number(value)));
    }

    fn thin(&mut self, spec: &ThinSpec, film: &FilmSpec, resolution: [u32; 2]) -> Parts {
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
        if let Some(mask) = Mask::named(name) {
            return Ok(Iris::Mask(mask));
        }
        let known = MASKS.join(", ");
        Mask::image(path).map(Iris::Mask).map_err(|error| JobError::Camera {
            at: self.at.clone(),
            problem: format!(
                "aperture \"{name}\": {error}; expected circular, {known} or a picture"
            ),
        })
    }

    fn real(
        &mut self,
        spec: &RealisticSpec,
        film: &FilmSpec,
        place: Place<'_>,
        changes: &Changes,
    ) -> Result<Parts, JobError> {
        let (file, aperture, diagonal) = match spec {
            RealisticSpec::V4 { lens, aperture, .. } => (lens, *aperture, film.diagonal),
            RealisticSpec::V2 { lens, aperture, film_diagonal, .. } => {
                (lens, *aperture, *film_diagonal)
            }
        };
        let mut prescription = lens::read(changes.lens.as_deref().unwrap_or(file))?;
        if let Some(coating) = changes.coating {
            prescription.coat(coating);
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
        let camera = |problem: String| JobError::Camera { at: self.at.clone(), problem };
        let film_for = |metres: f64| {
            lens::Focus::of(&prescription)
                .film(metres * 1e3)
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
            let rear = prescription.rear();
            let half = rear.diameter / 2.0;
            let rim = rear.sag_at(half, 0.0).max(rear.sag_at(0.0, half)).max(0.0);
            if film_distance <= rim {
                return Err(camera(format!(
                    "the film, {film_distance:.4} mm behind the rear vertex, would stand inside \
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
            Ok(RealLens::new(lens, film_distance, radius, changes.aim, unit, front))
        };
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
        self.number("effectiveFocalLength", lens.paraxial.focal_length);
        self.number("aperture", lens.paraxial.f_number());
        self.number("focus", in_focus);
        self.number("filmDistance", film_distance);
        self.number("stopDiameter", opened);
        self.number("entrancePupilOffset", lens.paraxial.entrance_pupil.position);
        self.number("expTime", time);
        // The dialect of 2016 has no shutter.
        if time > 0.0 {
            let ev = ev100(lens.paraxial.f_number(), time, changes.iso(film));
            self.number("exposureValue", ev);
        }
        Ok((Model::Real(Box::new(lens)), size, ratio, depth))
    }
}
