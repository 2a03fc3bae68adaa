//! Panel: what the page shows about the camera beside the picture, as JSON.

use petzval_image::find_number;
use petzval_lens::{Camera, FocusModel, LensModel, RealLens, RealRayFocus};
use petzval_render::aov::CircleOfConfusion;
use petzval_render::job::Job;
use petzval_render::memory::machine;
use petzval_render::prepare::{Changes, Prepared, Viewpoint};
use petzval_scene_formats::pbrt::Description;
use serde_json::{Value, json};

use super::settings::ViewSettings;
use super::widest_stop::WidestStop;
use crate::cli::plan::{self, Work};
use petzval_lens::AxialLight;

/// The use of a prepared job in the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PreparedAs {
    /// A draft, whose plan is not that of the picture.
    Draft,
    Picture,
}

/// The state of the last draft or picture.
#[derive(Debug)]
pub(super) struct Panel {
    last: Value,
    focus: Option<f64>,
    widest: WidestStop,
}

impl Panel {
    pub fn new(description: &Description) -> Self {
        Self { last: Value::Null, focus: None, widest: WidestStop::new(description) }
    }

    /// Returns the state of a draft or a picture that is prepared. A draft keeps the plan of the last
    /// picture.
    pub fn update(
        &mut self,
        generation: u64,
        settings: &ViewSettings,
        changes: &Changes,
        prepared: &Prepared,
        purpose: PreparedAs,
    ) -> Value {
        let Prepared { job, notes, warnings } = prepared;
        let number = |name: &str| find_number(notes, name);
        let lens = match &job.camera.model {
            LensModel::Real(lens) => {
                lens_json(lens, job.camera.half_diagonal(), self.widest.f_number(changes))
            }
            _ => Value::Null,
        };
        let plan = match purpose {
            PreparedAs::Draft => self.last["plan"].take(),
            PreparedAs::Picture => plan::json(&job.plan, Work::of(job, machine::cores())),
        };
        self.focus = number("focus");
        let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        self.last = json!({
            "type": "state",
            "generation": generation,
            "draft": purpose == PreparedAs::Draft,
            "options": settings.to_json(),
            "command": settings.command(),
            "size": job.frame.size(),
            "resolution": job.frame.resolution,
            "samples": job.samples.len(),
            "plan": plan,
            "warnings": warnings,
            "lens": lens,
            "film": job.camera.film,
            "focus": self.focus,
            "depth_of_field": depth_of_field(&job.camera, self.focus),
            "exposure_time": number("expTime"),
            "exposure_value": number("exposureValue"),
            "iso": number("isoSpeed"),
            "sensor": changes.sensor.is_some(),
            "camera": camera_json(job, self.focus),
            "error": Value::Null,
        });
        self.last.clone()
    }

    /// Returns the distance in focus (m).
    pub fn focus(&self) -> Option<f64> {
        self.focus
    }

    /// Returns the state of settings that show no picture: the last one, with the reason.
    pub fn failed(&mut self, generation: u64, settings: &ViewSettings, problem: &str) -> &Value {
        if self.last.is_null() {
            self.last = json!({ "type": "state" });
        }
        self.last["generation"] = json!(generation);
        self.last["options"] = settings.to_json();
        self.last["error"] = json!(problem);
        &self.last
    }
}

/// Returns the facts of a lens on a film of this half diagonal (mm).
fn lens_json(lens: &RealLens, half_diagonal: f64, widest: Option<f64>) -> Value {
    let f_number = f_number(lens, half_diagonal);
    let t_number = f_number
        .zip(AxialLight::of(lens, lens.prescription.design.primary_wavelength()))
        .map(|(f_number, light)| light.t_number(f_number));
    let prescription = &lens.prescription;
    json!({
        "name": prescription.name,
        "focal_length": lens.paraxial.focal_length,
        "f_number": f_number,
        "widest_f_number": widest,
        "t_number": t_number,
        "zoom": prescription.zoom_range(),
        "tilt": lens.film_pose.tilt,
        "shift": lens.film_pose.film_shift(),
    })
}

/// Returns the f-number by the marginal ray, as `--fstop` counts it: focused at infinity, also if the
/// lens is focused nearer by groups that move.
fn f_number(lens: &RealLens, half_diagonal: f64) -> Option<f64> {
    let near = &lens.prescription;
    let distant = near.focus_by_groups(f64::INFINITY, FocusModel::default(), 2.0 * half_diagonal);
    let distant = distant.and_then(Result::ok).map(|(lens, _)| lens);
    RealRayFocus::new(distant.as_ref().unwrap_or(near)).f_number()
}

/// Returns the nearest and the farthest distance from the film (m) that are sharp on the axis for a
/// distance in focus (m), null for infinity, and the diameter of their circle of confusion (mm).
fn depth_of_field(camera: &Camera, focus: Option<f64>) -> Value {
    let (LensModel::Real(lens), Some(focus)) = (&camera.model, focus) else { return Value::Null };
    let circle = CircleOfConfusion::sharp_diameter(2.0 * camera.half_diagonal());
    let film = lens.prescription.film_position(lens.film_distance);
    let limits = CircleOfConfusion::new(camera)
        .and_then(|blur| blur.depth_of_field(1e3 * focus - film, circle));
    let Some(limits) = limits else { return Value::Null };
    let [near, far] = limits.map(|distance| (distance + film) / 1e3);
    json!({ "near": near, "far": far.is_finite().then_some(far), "circle": circle })
}

/// Returns the viewpoint, at the distance in focus if it is known, in units of the world.
fn camera_json(job: &Job, focus: Option<f64>) -> Value {
    let camera = &job.camera;
    let scale = camera.world_from_camera.matrix3.z_axis.length();
    let units_per_metre = match &camera.model {
        LensModel::Real(lens) => 1e3 * lens.units_per_mm,
        _ => 1.0,
    };
    let focus = focus.filter(|focus| focus.is_finite() && *focus > 0.0);
    let scene = || {
        let [low, high] = job.scene.bounds()?;
        let middle = (low + high).as_dvec3() / 2.0;
        Some(middle.distance(camera.world_from_camera.translation) / scale / units_per_metre)
    };
    let distance = focus.or_else(scene).unwrap_or(1.0) * units_per_metre * scale;
    let Viewpoint { eye, target, up } = Viewpoint::of(&camera.world_from_camera, distance);
    json!({ "eye": eye.to_array(), "target": target.to_array(), "up": up.to_array() })
}
