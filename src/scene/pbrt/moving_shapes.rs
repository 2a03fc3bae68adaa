//! Moving shapes: an unnamed object holds them, and its one instance moves.

use glam::DAffine3;

use super::objects::Nested;
use super::reader::SceneReader;

/// An unnamed object of moving shapes. Consecutive shapes with the same motion share it.
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
    /// Returns the space of a shape: that of a moving object if its transform changes. Returns
    /// `None` if the transform flattens the shape. A shape with an area light cannot move.
    pub(super) fn shape_space(&mut self, name: &str) -> Option<ShapeSpace> {
        let transforms = self.state.ctm;
        if transforms[0] == transforms[1] {
            return Some(ShapeSpace { object: None, transform: transforms[0] });
        }
        if self.state.area_light.is_some() {
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
