//! Objects and their instances: ObjectBegin, ObjectEnd, ObjectInstance.

use std::collections::HashMap;

use super::graphics_state::Block;
use super::memory::granted;
use super::reader::SceneReader;
use super::{SceneError, suggestion_or};
use petzval_base::io::hint;
use petzval_scene::SceneBuilder;
use petzval_scene::motion::Motion;

/// Limit of the depth of objects in objects.
const MAX_DEPTH: usize = 32;
/// Limit of the instances in one scene.
const MAX_INSTANCES: usize = 1 << 26;

/// A part of an object that is not a shape of its own.
pub(super) enum Nested {
    /// An instance of the object of this name.
    Object(String),
    /// The index of an unnamed object that holds moving shapes.
    MovingShapes(u32),
}

/// An object, and the instances of other objects in it.
pub(super) struct Object {
    pub(super) index: u32,
    pub(super) nested: Vec<(Nested, Motion)>,
    /// Instances that one use of it makes, itself and nested ones included.
    pub(super) instances: usize,
    /// Depth of nesting; 1 if nothing is nested in it.
    pub(super) depth: usize,
}

/// Adds an instance of an object, and of all that is nested in it, to the world.
fn instantiate(
    objects: &HashMap<String, Object>,
    builder: &mut SceneBuilder,
    name: &str,
    world_from_object: &Motion,
) {
    let Some(object) = objects.get(name) else { return };
    builder.add_animated_instance(object.index, world_from_object.clone());
    for (nested, motion) in &object.nested {
        let motion = world_from_object.compose(motion);
        match nested {
            Nested::Object(name) => instantiate(objects, builder, name, &motion),
            Nested::MovingShapes(index) => builder.add_animated_instance(*index, motion),
        }
    }
}

impl SceneReader {
    pub(super) fn object_begin(&mut self) -> Result<(), SceneError> {
        self.require_in_world("ObjectBegin")?;
        let name = self.string()?;
        if self.open_object.is_some() {
            self.begin_block(Block::Object)?;
            return self.refuse("ObjectBegin inside ObjectBegin", "close the first object before");
        }
        self.set_aside_object(&name);
        self.begin_block(Block::Object)?;
        let index = self.builder.add_object();
        self.builder.name_object(index, &name);
        self.objects
            .insert(name.clone(), Object { index, nested: Vec::new(), instances: 1, depth: 1 });
        self.open_object = Some(name);
        Ok(())
    }

    /// Makes room for a second object of a name, which pbrt-v3 reads. Instances inside other objects
    /// stay those of the first.
    fn set_aside_object(&mut self, name: &str) {
        let Some(first) = self.objects.remove(name) else { return };
        self.warnings.warn(&self.at, "second object", || {
            format!("a second object \"{name}\": from here on, the name means this one")
        });
        // No name in a file holds this character.
        let aside = format!("{name}\0{}", self.objects.len());
        for (nested, _) in self.objects.values_mut().flat_map(|object| &mut object.nested) {
            if let Nested::Object(used) = nested
                && used == name
            {
                used.clone_from(&aside);
            }
        }
        self.objects.insert(aside, first);
    }

    pub(super) fn object_end(&mut self) -> Result<(), SceneError> {
        self.end_block(Block::Object)?;
        self.open_object = None;
        Ok(())
    }

    pub(super) fn object_instance(&mut self) -> Result<(), SceneError> {
        self.require_in_world("ObjectInstance")?;
        let name = self.string()?;
        let Some(object) = self.objects.get(&name) else {
            if self.recovery.is_lost(&name) {
                return Ok(());
            }
            let hint = hint(&name, self.objects.keys().map(String::as_str));
            let behind = suggestion_or(hint, "expected a name that ObjectBegin defines before");
            return self.refuse(format!("no object \"{name}\"{behind}"), "");
        };
        let (instances, depth) = (object.instances, object.depth + 1);
        if self.open_object.as_ref() == Some(&name) {
            let found = format!("object \"{name}\" contains itself");
            return self.refuse(found, "close it with ObjectEnd before its first instance");
        }
        let Some(motion) = self.invertible_motion() else {
            self.warn_unsupported("an instance that its transform flattens", "it is left out");
            return Ok(());
        };
        match self.open_object {
            Some(_) => {
                let bytes = size_of::<(Nested, Motion)>() as u64;
                granted(&self.at, "an instance of an object", self.context.claim(bytes))?;
            }
            None => self.count_instances(instances)?,
        }
        let total = match self.open_object.as_ref().and_then(|open| self.objects.get_mut(open)) {
            Some(open) => {
                open.nested.push((Nested::Object(name), motion));
                open.instances = open.instances.saturating_add(instances);
                open.depth = open.depth.max(depth);
                open.instances
            }
            None => {
                if depth <= MAX_DEPTH {
                    instantiate(&self.objects, &mut self.builder, &name, &motion);
                }
                self.instance_count
            }
        };
        if depth > MAX_DEPTH {
            return self.refuse(format!("{depth} nested objects"), "expected at most 32");
        }
        self.check_instances(total)
    }

    /// Claims instances in the world, and counts them.
    pub(super) fn count_instances(&mut self, more: usize) -> Result<(), SceneError> {
        self.claim_instances(more as u64)?;
        self.instance_count = self.instance_count.saturating_add(more);
        self.check_instances(self.instance_count)
    }

    fn check_instances(&self, total: usize) -> Result<(), SceneError> {
        match total > MAX_INSTANCES {
            true => {
                let found = format!("{total} instances of objects");
                self.refuse(found, "expected at most 67 million")
            }
            false => Ok(()),
        }
    }

    /// Returns the motion between the current transforms, or `None` if one of them flattens space.
    pub(super) fn invertible_motion(&self) -> Option<Motion> {
        let flat = self.state.ctm.iter().any(|ctm| !ctm.inverse().is_finite());
        Motion::between(self.state.ctm).filter(|_| !flat)
    }

    /// Returns the index of the object between `ObjectBegin` and `ObjectEnd`.
    pub(super) fn open_object_index(&self) -> Option<u32> {
        let open = self.open_object.as_ref().and_then(|name| self.objects.get(name));
        open.map(|open| open.index)
    }
}
