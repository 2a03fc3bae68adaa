//! Moving shapes, and curves whose transform changes their cross-section: an unnamed object holds
//! them, and its one instance moves or deforms them.

use glam::{DAffine3, DMat3};

use super::objects::Nested;
use super::reader::SceneReader;

/// An unnamed object of such shapes. Consecutive shapes with the same motion share it.
pub(super) struct MovingObject {
    /// The open object in which it was made.
    parent: Option<String>,
    transforms: [DAffine3; 2],
    object: u32,
}

/// The space into which a shape is transformed.
pub(super) struct ShapeSpace {
    /// Index of the moving object; `None` is the open object, or else the world.
    pub(super) object: Option<u32>,
    /// Shape space to this space.
    pub(super) transform: DAffine3,
}

impl SceneReader {
    /// Returns the space of a shape: that of a moving object if its transform changes, or if it is
    /// no similarity but must be one. Returns `None` if the transform flattens the shape. A shape
    /// with an area light cannot move.
    pub(super) fn shape_space(&mut self, name: &str, similar: bool) -> Option<ShapeSpace> {
        let transforms = self.state.ctm;
        let emits = self.state.area_light.is_some();
        if transforms[0] == transforms[1] && (!similar || emits || is_similarity(&transforms[0])) {
            return Some(ShapeSpace { object: None, transform: transforms[0] });
        }
        if emits {
            let transform = self.fixed_transform(&format!("a {name} with an area light"));
            return Some(ShapeSpace { object: None, transform });
        }
        let same = |moving: &&MovingObject| {
            moving.parent == self.open_object && moving.transforms == transforms
        };
        if let Some(moving) = self.moving_object.as_ref().filter(same) {
            let object = Some(moving.object);
            return Some(ShapeSpace { object, transform: DAffine3::IDENTITY });
        }
        let Some(motion) = self.invertible_motion() else {
            self.warn_unsupported(
                &format!("a {name} that its transform flattens"),
                "it is left out",
            );
            return None;
        };
        let object = self.builder.add_object();
        match self.open_object.as_ref().and_then(|open| self.objects.get_mut(open)) {
            Some(open) => {
                open.nested.push((Nested::MovingShapes(object), motion));
                open.instances = open.instances.saturating_add(1);
            }
            None => self.builder.add_animated_instance(object, motion),
        }
        let parent = self.open_object.clone();
        self.moving_object = Some(MovingObject { parent, transforms, object });
        Some(ShapeSpace { object: Some(object), transform: DAffine3::IDENTITY })
    }
}

/// Returns whether a transform rotates, moves and scales all directions alike, without mirroring.
fn is_similarity(transform: &DAffine3) -> bool {
    // Far above the rounding of rotations that a file states with six digits.
    const TOLERANCE: f64 = 1e-4;
    let matrix = transform.matrix3;
    let scale = matrix.determinant().cbrt();
    let square = matrix.transpose() * matrix * (scale * scale).recip();
    scale > 0.0 && square.abs_diff_eq(DMat3::IDENTITY, TOLERANCE)
}
