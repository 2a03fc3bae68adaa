//! Viewpoint of the user: a pose of the camera instead of the scene's.

use std::fmt;
use std::str::FromStr;

use glam::{DAffine3, DVec3};

use petzval_scene::look_at_rotation;

/// Largest coordinate: that of a camera in a scene file.
const MAX_COORDINATE: f64 = 1e18;

/// Place and direction of a camera, in the world of the scene file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// The origin of the camera.
    pub eye: DVec3,
    /// A point that the camera looks at, on its axis.
    pub target: DVec3,
    /// A direction that is upright in the picture. It is not parallel to the axis.
    pub up: DVec3,
}

impl Viewpoint {
    /// Returns the viewpoint of a camera that looks at a point this far along its axis (units of the
    /// world).
    pub fn of(world_from_camera: &DAffine3, distance: f64) -> Self {
        let eye = world_from_camera.translation;
        let target = eye + distance * world_from_camera.matrix3.z_axis.normalize();
        Self { eye, target, up: world_from_camera.matrix3.y_axis.normalize() }
    }

    /// Returns a camera at this viewpoint that keeps the scale and the mirroring of another.
    pub fn world_from_camera(&self, other: &DAffine3) -> DAffine3 {
        let rotation = |forward: DVec3, up: DVec3| {
            forward.try_normalize().and_then(|forward| look_at_rotation(forward, up))
        };
        let (y, z) = (other.matrix3.y_axis, other.matrix3.z_axis);
        let matrix3 = match (rotation(z, y), rotation(self.target - self.eye, self.up)) {
            (Some(from), Some(to)) => to * (from.transpose() * other.matrix3),
            _ => other.matrix3,
        };
        DAffine3 { matrix3, translation: self.eye }
    }
}

impl FromStr for Viewpoint {
    type Err = String;

    /// Parses the place, the target and the direction up, which is +y by default.
    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected X,Y,Z of the camera, X,Y,Z of a point in the middle of the picture, \
                        and, unless it is 0,1,0, the direction up, such as 0,1,-3,0,0.5,0";
        let number =
            |part: &str| part.trim().parse().ok().filter(|v: &f64| v.abs() <= MAX_COORDINATE);
        let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
        let mut numbers = numbers.ok_or(expected)?;
        if numbers.len() == 6 {
            numbers.extend(DVec3::Y.to_array());
        }
        if numbers.len() != 9 {
            return Err(expected.to_owned());
        }
        let point = |i: usize| DVec3::from_slice(&numbers[i..]);
        let viewpoint = Self { eye: point(0), target: point(3), up: point(6) };
        let forward = (viewpoint.target - viewpoint.eye).try_normalize();
        let forward = forward.ok_or("the camera looks at its own place; expected two points")?;
        match look_at_rotation(forward, viewpoint.up) {
            Some(_) => Ok(viewpoint),
            None => Err("the camera looks along the direction up; give another".to_owned()),
        }
    }
}

impl fmt::Display for Viewpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers = [self.eye, self.target, self.up].map(|v| v.to_array()).concat();
        let words: Vec<String> = numbers.iter().map(|v| format!("{}", v + 0.0)).collect();
        f.write_str(&words.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    #[test]
    fn the_viewpoint_of_a_camera_gives_the_same_camera() {
        let tilted = DMat3::from_rotation_x(0.3) * DMat3::from_rotation_y(1.1);
        let mirrored = tilted * DMat3::from_diagonal(DVec3::new(-2.0, 2.0, 2.0));
        for matrix3 in [DMat3::IDENTITY, tilted, mirrored] {
            let camera = DAffine3 { matrix3, translation: DVec3::new(1.0, -2.0, 3.0) };
            let viewpoint = Viewpoint::of(&camera, 5.0);
            let other = DAffine3 { matrix3: DMat3::from_rotation_z(0.4), ..camera };
            let same = viewpoint.world_from_camera(&camera);
            assert!(same.abs_diff_eq(camera, 1e-12), "{same} is not {camera}");
            let typed: Viewpoint = viewpoint.to_string().parse().expect("a viewpoint");
            assert_eq!(typed, viewpoint);
            let turned = typed.world_from_camera(&other);
            let axis = camera.matrix3.z_axis.normalize();
            assert!(turned.matrix3.z_axis.abs_diff_eq(axis, 1e-12), "{turned}");
        }
    }

    #[test]
    fn a_viewpoint_that_shows_nothing_is_refused() {
        for text in ["", "1,2,3", "0,0,0,0,0,0", "0,0,0,0,5,0", "0,0,0,0,0,nan", "1,2,3,4,5,6,7"] {
            assert!(text.parse::<Viewpoint>().is_err(), "{text}");
        }
        let plain: Viewpoint = "0,1,-3,0,0.5,0".parse().expect("a viewpoint");
        assert_eq!(plain.up, DVec3::Y);
    }
}
