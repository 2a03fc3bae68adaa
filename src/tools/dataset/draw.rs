//! The parameters of one pair, drawn from its number.

use std::fmt;
use std::path::PathBuf;

use glam::{DAffine3, DMat3, DVec3};

use super::spec::{DatasetSpec, DrawnFrom, FocusValue, Range, Reach, RigPlace};
use super::trajectory::StampedPose;
use petzval_base::sampler::hash;
use petzval_render::prepare::{FocusOn, Viewpoint};

/// The parameters of one pair.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// The number of the pair, from 0.
    pub pair: u32,
    /// The number of the view, which all cameras of a rig share.
    pub view: u32,
    /// The number of the rig's camera.
    pub rig_camera: u32,
    /// The pose of the rig on its trajectory; `None` for that of the scene's camera.
    pub pose: Option<StampedPose>,
    /// The place of the camera in its rig, if there is one: moves and turns, as `shift` and `turn`.
    pub place: Option<RigPlace>,
    /// The seed of its pictures.
    pub seed: u32,
    /// The scene file.
    pub scene: PathBuf,
    /// The lens file; `None` for the scene's.
    pub lens: Option<PathBuf>,
    /// The object in focus; `None` for the scene's.
    pub focus: Option<FocusOn>,
    /// The f-number; `None` for the scene's.
    pub f_number: Option<f64>,
    /// The light on the sensor, in stops above that of its base speed.
    pub light: f64,
    /// The move of the camera along its own axes: right, up, forward (m).
    pub shift: [f64; 3],
    /// The turn of the camera: pan to the right, tilt upwards, roll clockwise (degrees).
    pub turn: [f64; 3],
}

/// Parameter that a random number is for.
#[derive(Clone, Copy)]
enum Parameter {
    Seed,
    Scene,
    Lens,
    Focus,
    FNumber,
    Light,
    Shift,
    Turn = 16,
}

/// Random numbers of one pair.
#[derive(Clone, Copy)]
struct PairRandom {
    key: u32,
}

impl PairRandom {
    fn word(self, parameter: Parameter, axis: u32) -> u32 {
        hash(self.key ^ hash(0x9e37_79b9 + parameter as u32 + axis))
    }

    /// Returns a number in [0, 1).
    fn number(self, parameter: Parameter, axis: u32) -> f64 {
        f64::from(self.word(parameter, axis)) / 4_294_967_296.0
    }

    fn pick<T: Clone>(self, parameter: Parameter, list: &[T]) -> T {
        let place = (self.number(parameter, 0) * list.len() as f64) as usize;
        list[place.min(list.len() - 1)].clone()
    }

    fn within(self, parameter: Parameter, Range { from, to, log }: Range) -> f64 {
        let share = self.number(parameter, 0);
        match log {
            true => from * (to / from).powf(share),
            false => from + (to - from) * share,
        }
    }

    fn value<T: Clone>(self, parameter: Parameter, values: &DrawnFrom<T>, of: fn(f64) -> T) -> T {
        match values {
            DrawnFrom::Range(range) => of(self.within(parameter, *range)),
            DrawnFrom::List(list) => self.pick(parameter, list),
            DrawnFrom::One(value) => value.clone(),
        }
    }

    fn deviation(self, parameter: Parameter, reach: Option<Reach>) -> [f64; 3] {
        let reach = reach.map_or([0.0; 3], Reach::axes);
        [0, 1, 2].map(|i| reach[i] * (2.0 * self.number(parameter, i as u32) - 1.0))
    }
}

impl DatasetSpec {
    /// Draws the parameters of a pair.
    pub fn draw(&self, pair: u32) -> Draw {
        let spec = &self.draw;
        let cameras = spec.rig.len().max(1) as u32;
        let (view, rig_camera) = (pair / cameras, pair % cameras);
        let random = PairRandom { key: hash(view ^ hash(self.seed)) };
        let seed = random.word(Parameter::Seed, 0);
        let path = |_| PathBuf::new();
        let focus = |values| match random.value(Parameter::Focus, values, FocusValue::Metres) {
            FocusValue::Metres(metres) => FocusOn::Distance(metres),
            FocusValue::Word(_) => FocusOn::Pixel(None),
        };
        Draw {
            pair,
            view,
            rig_camera,
            pose: spec.trajectory.as_ref().and_then(|trajectory| trajectory.pose(view)),
            place: spec.rig.get(rig_camera as usize).copied(),
            // The noise of the cameras of a rig is independent.
            seed: if rig_camera == 0 { seed } else { hash(seed ^ hash(rig_camera)) },
            scene: random.value(Parameter::Scene, &spec.scene, path),
            lens: spec.lens.as_ref().map(|lens| random.value(Parameter::Lens, lens, path)),
            focus: spec.focus.as_ref().map(focus),
            f_number: spec.fstop.as_ref().map(|n| random.value(Parameter::FNumber, n, |n| n)),
            light: spec.light.as_ref().map_or(0.0, |l| random.value(Parameter::Light, l, |l| l)),
            shift: random.deviation(Parameter::Shift, spec.shift),
            turn: random.deviation(Parameter::Turn, spec.turn),
        }
    }
}

impl Draw {
    /// Returns the viewpoint of a camera of the scene with this pose, move, turn and place in a rig; `None` if it
    /// stays.
    pub(super) fn viewpoint(&self, world_from_camera: &DAffine3) -> Option<Viewpoint> {
        let drawn = RigPlace { shift: self.shift, turn: self.turn };
        if self.pose.is_none() && self.place.is_none() && drawn == RigPlace::default() {
            return None;
        }
        let rest =
            self.pose.map_or(*world_from_camera, |pose| pose.world_from_camera(world_from_camera));
        let DMat3 { x_axis, y_axis, z_axis } = rest.matrix3;
        let axes = DMat3::from_cols(x_axis.normalize(), y_axis.normalize(), z_axis.normalize());
        let per_metre = rest.matrix3.determinant().abs().cbrt();
        let drawn = drawn.of((rest.translation, axes), per_metre);
        let (eye, axes) = self.place.unwrap_or_default().of(drawn, per_metre);
        Some(Viewpoint { eye, target: eye + axes.z_axis, up: axes.y_axis })
    }
}

impl RigPlace {
    /// Returns the place and the axes of a camera that stands here relative to others, in a world of so many units per
    /// metre.
    fn of(&self, (eye, axes): (DVec3, DMat3), per_metre: f64) -> (DVec3, DMat3) {
        let [pan, tilt, roll] = self.turn.map(f64::to_radians);
        let turned = axes
            * DMat3::from_rotation_y(pan)
            * DMat3::from_rotation_x(-tilt)
            * DMat3::from_rotation_z(-roll);
        (eye + axes * DVec3::from_array(self.shift) * per_metre, turned)
    }
}

impl fmt::Display for Draw {
    /// Writes what was drawn, in one line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name =
            |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        write!(f, "{}", name(&self.scene))?;
        self.lens.iter().try_for_each(|lens| write!(f, ", {}", name(lens)))?;
        match self.focus {
            None => {}
            Some(FocusOn::Distance(metres)) => write!(f, ", focus {metres:.3} m")?,
            Some(FocusOn::Pixel(_)) => write!(f, ", focus auto")?,
        }
        self.f_number.iter().try_for_each(|n| write!(f, ", f/{n:.2}"))?;
        if self.light != 0.0 {
            write!(f, ", light {:+.1} stops", self.light)?;
        }
        if let Some(pose) = self.pose {
            write!(f, ", at {} s", pose.time)?;
        }
        if self.place.is_some() {
            write!(f, ", camera {}", self.rig_camera)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_moves_and_turns_about_its_own_axes() {
        // A camera at (5, 0, 0) that looks along +x: right is -z, up is y.
        let axes = DMat3::from_cols(DVec3::NEG_Z, DVec3::Y, DVec3::X);
        let camera = DAffine3 { matrix3: 2.0 * axes, translation: DVec3::new(5.0, 0.0, 0.0) };
        let draw = |shift: [f64; 3], turn: [f64; 3]| Draw {
            pair: 0,
            view: 0,
            rig_camera: 0,
            pose: None,
            place: None,
            seed: 0,
            scene: PathBuf::new(),
            lens: None,
            focus: None,
            f_number: None,
            light: 0.0,
            shift,
            turn,
        };
        assert_eq!(draw([0.0; 3], [0.0; 3]).viewpoint(&camera), None);
        let seen = |shift, turn| {
            let view = draw(shift, turn).viewpoint(&camera).expect("a viewpoint");
            let forward = view.target - view.eye;
            (view.eye, [DVec3::NEG_Z, DVec3::Y].map(|axis| forward.dot(axis)), view.up)
        };
        // The world has two units per metre of the camera.
        let eye = seen([1.0, 2.0, 3.0], [0.0; 3]).0;
        assert!(eye.distance(DVec3::new(11.0, 4.0, -2.0)) < 1e-12, "{eye}");
        let sine = 30f64.to_radians().sin();
        let near = |found: [f64; 2], expected: [f64; 2]| {
            assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-12), "{found:?}");
        };
        near(seen([0.0; 3], [30.0, 0.0, 0.0]).1, [sine, 0.0]);
        near(seen([0.0; 3], [0.0, 30.0, 0.0]).1, [0.0, sine]);
        let (_, forward, up) = seen([0.0; 3], [0.0, 0.0, 30.0]);
        near(forward, [0.0; 2]);
        near([up.dot(DVec3::NEG_Z), up.y], [sine, 30f64.to_radians().cos()]);
    }
}
