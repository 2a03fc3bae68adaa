//! Trajectories of a camera: files of poses, as TUM's data sets have them (Sturm et al. 2012, "A Benchmark for the
//! Evaluation of RGB-D SLAM Systems").

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DQuat, DVec3};
use serde::Deserialize;

use petzval_base::io::ReadContext;

/// Numbers of a line: time, position and quaternion.
const NUMBERS: usize = 8;
/// Largest deviation of a quaternion's length from 1: files have four digits.
const LENGTH_TOLERANCE: f64 = 0.01;
/// Largest coordinate (m).
const MAX_COORDINATE: f64 = 1e9;

/// The poses of a camera, one for each view.
#[derive(Clone, Debug, Deserialize)]
#[serde(from = "PathBuf")]
pub struct Trajectory {
    /// The file.
    pub path: PathBuf,
    poses: Vec<StampedPose>,
}

/// A pose of a camera with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StampedPose {
    /// The time that the file states (s).
    pub time: f64,
    /// The position (m), in a right-handed world.
    position: DVec3,
    /// Rotation from a camera with x to the right, y down and z forward to this world.
    rotation: DQuat,
}

impl From<PathBuf> for Trajectory {
    /// Returns a trajectory whose file has not been read.
    fn from(path: PathBuf) -> Self {
        Self { path, poses: Vec::new() }
    }
}

impl Trajectory {
    /// Reads the file, which is relative to a folder.
    ///
    /// # Errors
    /// Returns an error with its place if the file cannot be read or has no poses.
    pub(super) fn read(&mut self, folder: &Path, context: &ReadContext) -> Result<(), String> {
        let name = self.path.display();
        let bytes = context.bytes(&folder.join(&self.path)).map_err(|error| error.to_string())?;
        let text =
            String::from_utf8(bytes).map_err(|_| format!("{name}: expected text in UTF-8"))?;
        let text = text.trim_start_matches('\u{feff}');
        for (line, row) in (1..).zip(text.lines()) {
            let row = row.split('#').next().unwrap_or_default();
            if row.trim().is_empty() {
                continue;
            }
            let pose = pose(row).map_err(|problem| format!("{name}:{line}: {problem}"))?;
            self.poses.push(pose);
        }
        match self.poses.is_empty() {
            true => Err(format!("{name} has no poses; expected lines of time x y z qx qy qz qw")),
            false => Ok(()),
        }
    }

    /// Returns the number of poses.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Returns whether there are no poses.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// Returns the pose of a view; `None` beyond the last.
    pub fn pose(&self, view: u32) -> Option<StampedPose> {
        self.poses.get(view as usize).copied()
    }
}

fn pose(row: &str) -> Result<StampedPose, String> {
    let expected = "expected time x y z qx qy qz qw: seconds, metres and a quaternion of length 1";
    let parsed: Result<Vec<f64>, String> = row
        .split([' ', '\t', ',', '\r'])
        .filter(|word| !word.is_empty())
        .map(|word| word.parse().map_err(|_| format!("found \"{word}\"; {expected}")))
        .collect();
    let numbers = parsed?;
    let found = numbers.len();
    let [time, x, y, z, i, j, k, real] = <[f64; NUMBERS]>::try_from(numbers)
        .map_err(|_| format!("found {found} numbers; {expected}"))?;
    let (position, rotation) = (DVec3::new(x, y, z), DQuat::from_xyzw(i, j, k, real));
    if let Some(far) =
        position.to_array().into_iter().find(|v| v.abs() > MAX_COORDINATE || v.is_nan())
    {
        return Err(format!("found a coordinate of {far}; expected metres"));
    }
    let length = rotation.length();
    let is_unit = (length - 1.0).abs() <= LENGTH_TOLERANCE;
    if !time.is_finite() {
        return Err(format!("found the time {time}; {expected}"));
    }
    if !is_unit {
        return Err(format!("found a quaternion of length {length:.4}; {expected}"));
    }
    Ok(StampedPose { time, position, rotation: rotation.normalize() })
}

impl StampedPose {
    /// Returns the pose of a scene's camera (x to the right, y up, z forward) in the scene's world, with the scale of
    /// its own pose. A world in which that is not mirrored is left-handed, as that of pbrt: its y is the trajectory's
    /// negated.
    pub(super) fn world_from_camera(&self, own: &DAffine3) -> DAffine3 {
        let scale = own.matrix3.determinant().abs().cbrt();
        let flip = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
        let world = if own.matrix3.determinant() > 0.0 { flip } else { DMat3::IDENTITY };
        DAffine3 {
            matrix3: world * DMat3::from_quat(self.rotation) * flip * scale,
            translation: world * self.position * scale,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_poses_and_faults_have_a_reason() {
        let found =
            pose("1305031102.1758 1.3405 0.6266 1.6575 0.6574 0.6126 -0.2949 -0.3248").unwrap();
        assert_eq!(found.position, DVec3::new(1.3405, 0.6266, 1.6575));
        for (row, expected) in [
            ("1 2 3", "found 3 numbers"),
            ("1 0 0 0 0 0 0 x", "found \"x\""),
            ("1 0 0 0 0 0 0 0", "length 0.0000"),
            ("1 0 0 0 0 0 0 nan", "length NaN"),
            ("1 inf 0 0 0 0 0 1", "coordinate of inf"),
            ("nan 0 0 0 0 0 0 1", "found the time NaN"),
        ] {
            let problem = pose(row).unwrap_err();
            assert!(problem.contains(expected), "{row}: {problem}");
        }
    }

    #[test]
    fn the_identity_looks_along_z_with_y_down() {
        let here = pose("0 1 2 3 0 0 0 1").unwrap();
        // pbrt: left-handed, y up.
        let found = here.world_from_camera(&DAffine3::IDENTITY);
        assert_eq!(found.translation, DVec3::new(1.0, -2.0, 3.0));
        assert_eq!(found.matrix3, DMat3::IDENTITY);
        // A mirrored camera: the world is right-handed, and the trajectory's.
        let mirrored = DAffine3::from_scale(DVec3::new(-2.0, 2.0, 2.0));
        let found = here.world_from_camera(&mirrored);
        assert_eq!(found.translation, DVec3::new(2.0, 4.0, 6.0));
        assert_eq!(found.matrix3 * DVec3::Y, DVec3::new(0.0, -2.0, 0.0));
        assert!(found.matrix3.determinant() < 0.0);
    }
}
