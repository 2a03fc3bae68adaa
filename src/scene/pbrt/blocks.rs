//! Blocks, objects and included files.

use std::collections::HashMap;
use std::fs;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;

use super::SceneError;
use super::reader::Reader;
use super::token::Lexer;
use crate::scene::SceneBuilder;
use crate::source::{Unreadable, hint};
use crate::spectrum::ColourSpace;

/// Files that may include each other in a chain, and objects that may hold each other.
const MOST_NESTED: usize = 32;
/// Copies of objects in one scene.
const MOST_INSTANCES: usize = 1 << 26;

/// What AttributeBegin saves.
#[derive(Clone)]
pub(super) struct State {
    pub(super) ctm: DAffine3,
    pub(super) reversed: bool,
    pub(super) material: u32,
    /// Radiance and whether both sides shine.
    pub(super) area_light: Option<([f32; 3], bool)>,
    /// What colours are given in.
    pub(super) space: ColourSpace,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Block {
    Attribute,
    Transform,
    Object,
}

impl Block {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Attribute => "Attribute",
            Self::Transform => "Transform",
            Self::Object => "Object",
        }
    }
}

/// An object, and the copies of other objects in it.
pub(super) struct Object {
    pub(super) index: u32,
    pub(super) nested: Vec<(String, DAffine3)>,
    pub(super) copies: usize,
    /// Objects inside objects, itself counted.
    pub(super) depth: usize,
}

/// Puts an object and all that is nested in it into the world.
fn place(
    objects: &HashMap<String, Object>,
    builder: &mut SceneBuilder,
    name: &str,
    world_from_object: DAffine3,
) {
    let Some(object) = objects.get(name) else { return };
    builder.instance(object.index, world_from_object);
    for (nested, transform) in &object.nested {
        place(objects, builder, nested, world_from_object * *transform);
    }
}

/// The bytes of a file. What is no file, and so of no known size, may hold 256 MiB.
pub(super) fn load(path: &Path) -> Result<Vec<u8>, Unreadable> {
    let read = || {
        let file = fs::File::open(path)?;
        let most = file.metadata()?.len().max(1 << 28);
        let mut bytes = Vec::new();
        file.take(most + 1).read_to_end(&mut bytes)?;
        match bytes.len() as u64 > most {
            true => Err(io::Error::other("it does not end")),
            false => Ok(bytes),
        }
    };
    read().map_err(|source| Unreadable { path: path.to_owned(), source })
}

impl Reader {
    pub(super) fn begin(&mut self, block: Block) -> Result<(), SceneError> {
        self.saved.push((block, self.state.clone(), self.at.clone()));
        Ok(())
    }

    pub(super) fn end(&mut self, block: Block) -> Result<(), SceneError> {
        match self.saved.pop() {
            Some((open, state, _)) if open == block => {
                if block == Block::Transform {
                    self.state.ctm = state.ctm;
                } else {
                    self.state = state;
                }
                Ok(())
            }
            Some((open, _, at)) => self.refuse(
                format!("{}End inside the {}Begin of {at}", block.name(), open.name()),
                "blocks must close in the order in which they were opened",
            ),
            None => self.refuse(format!("{0}End without {0}Begin", block.name()), ""),
        }
    }

    pub(super) fn object_begin(&mut self) -> Result<(), SceneError> {
        self.after_world("ObjectBegin")?;
        let name = self.string()?;
        if self.object.is_some() {
            return self.refuse("ObjectBegin inside ObjectBegin", "close the first one before");
        }
        if self.objects.contains_key(&name) {
            return self.refuse(format!("a second object \"{name}\""), "give it another name");
        }
        self.begin(Block::Object)?;
        let index = self.builder.object();
        self.objects
            .insert(name.clone(), Object { index, nested: Vec::new(), copies: 1, depth: 1 });
        self.object = Some(name);
        Ok(())
    }

    pub(super) fn object_end(&mut self) -> Result<(), SceneError> {
        self.end(Block::Object)?;
        self.object = None;
        Ok(())
    }

    pub(super) fn object_instance(&mut self) -> Result<(), SceneError> {
        self.after_world("ObjectInstance")?;
        let name = self.string()?;
        let Some(object) = self.objects.get(&name) else {
            let hint = hint(&name, self.objects.keys().map(String::as_str));
            return self.refuse(format!("no object \"{name}\"{hint}"), "");
        };
        let (copies, depth) = (object.copies, object.depth + 1);
        if self.object.as_ref() == Some(&name) {
            return self.refuse(format!("object \"{name}\" contains itself"), "");
        }
        let ctm = self.state.ctm;
        if !ctm.inverse().is_finite() {
            self.warn_here("an instance that its transform flattens", "it is left out");
            return Ok(());
        }
        let total = match self.object.as_ref().and_then(|open| self.objects.get_mut(open)) {
            Some(open) => {
                open.nested.push((name, ctm));
                open.copies = open.copies.saturating_add(copies);
                open.depth = open.depth.max(depth);
                open.copies
            }
            None => {
                self.instances = self.instances.saturating_add(copies);
                if self.instances <= MOST_INSTANCES {
                    place(&self.objects, &mut self.builder, &name, ctm);
                }
                self.instances
            }
        };
        if depth > MOST_NESTED {
            return self
                .refuse(format!("{depth} objects inside each other"), "expected at most 32");
        }
        if total > MOST_INSTANCES {
            return self
                .refuse(format!("{total} copies of objects"), "expected at most 67 million");
        }
        Ok(())
    }

    pub(super) fn include(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        let path = self.folder.join(&name);
        if self.files.len() >= MOST_NESTED {
            let found = format!("more than {MOST_NESTED} files include each other");
            return self.refuse(found, "does one include itself?");
        }
        let text =
            load(&path).map_err(|source| SceneError::Include { at: self.at.clone(), source })?;
        debug_assert!(self.pending.is_none(), "a directive without parameters looks not ahead");
        self.files.push(Lexer::new(Arc::from(path), text));
        Ok(())
    }

    pub(super) fn world_begin(&mut self) -> Result<(), SceneError> {
        self.before_world("a second WorldBegin")?;
        self.in_world = true;
        self.state.ctm = DAffine3::IDENTITY;
        self.systems.insert("world".to_owned(), DAffine3::IDENTITY);
        Ok(())
    }
}
