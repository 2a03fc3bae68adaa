//! Blocks, objects and included files.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DAffine3;

use super::claims::granted;
use super::params::Param;
use super::reader::Reader;
use super::token::Lexer;
use super::{SceneError, resolve};
use crate::memory::{Size, budget};
use crate::motion::Motion;
use crate::scene::{Emission, SceneBuilder};
use crate::source::{Location, bytes, hint};
use crate::spectrum::ColourSpace;

/// Files that may include each other in a chain, and objects that may hold each other.
const MOST_NESTED: usize = 32;
/// Files that may be included in all, one as often as it is, and their bytes.
const MOST_INCLUDED: [u64; 2] = [1 << 15, 1 << 32];
/// Copies of objects in one scene.
const MOST_INSTANCES: usize = 1 << 26;

/// What AttributeBegin saves.
#[derive(Clone)]
pub(super) struct State {
    /// The current transform, at the start and at the end of the motion.
    pub(super) ctm: [DAffine3; 2],
    /// Which of the two the next directives change.
    pub(super) active: [bool; 2],
    pub(super) reversed: bool,
    pub(super) material: u32,
    pub(super) area_light: Option<Emission>,
    /// What colours are given in.
    pub(super) space: ColourSpace,
    /// What Attribute gave, by its place in [`TARGETS`](super::attributes::TARGETS).
    pub(super) attributes: [Arc<Vec<Param>>; 5],
}

impl State {
    pub(super) fn new(material: u32) -> Self {
        Self {
            ctm: [DAffine3::IDENTITY; 2],
            active: [true; 2],
            reversed: false,
            material,
            area_light: None,
            space: ColourSpace::default(),
            attributes: Default::default(),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Block {
    Attribute,
    Transform,
    Object,
    /// A file whose changes of state end with it.
    Import,
}

impl Block {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Attribute => "Attribute",
            Self::Transform => "Transform",
            Self::Object => "Object",
            Self::Import => "Import",
        }
    }
}

/// What stands in an object beside its shapes.
pub(super) enum Nested {
    /// A copy of another one.
    Object(String),
    /// What moves there: an object without a name.
    Mover(u32),
}

/// An object, and the copies of other objects in it.
pub(super) struct Object {
    pub(super) index: u32,
    pub(super) nested: Vec<(Nested, Motion)>,
    pub(super) copies: usize,
    /// Objects inside objects, itself counted.
    pub(super) depth: usize,
}

/// Puts an object and all that is nested in it into the world.
fn place(
    objects: &HashMap<String, Object>,
    builder: &mut SceneBuilder,
    name: &str,
    world_from_object: &Motion,
) {
    let Some(object) = objects.get(name) else { return };
    builder.mover(object.index, world_from_object.clone());
    for (nested, motion) in &object.nested {
        let motion = world_from_object.then(motion);
        match nested {
            Nested::Object(name) => place(objects, builder, name, &motion),
            Nested::Mover(index) => builder.mover(*index, motion),
        }
    }
}

impl Reader {
    pub(super) fn begin(&mut self, block: Block) -> Result<(), SceneError> {
        let bytes = (self.saved.len() + 1) * 2 * size_of::<(Block, State, Location)>();
        let what = format!("{} blocks inside each other", self.saved.len() + 1);
        granted(&self.at, &what, budget::fits(bytes as u64))?;
        self.saved.push((block, self.state.clone(), self.at.clone()));
        Ok(())
    }

    pub(super) fn end(&mut self, block: Block) -> Result<(), SceneError> {
        match self.saved.pop() {
            Some((open, state, _)) if open == block => {
                if block == Block::Transform {
                    (self.state.ctm, self.state.active) = (state.ctm, state.active);
                } else {
                    self.state = state;
                }
                Ok(())
            }
            Some((Block::Import, ..)) => {
                let found = format!("{0}End without {0}Begin in its file", block.name());
                self.refuse(found, "blocks must close in the file that opens them")
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
        let flat = self.state.ctm.iter().any(|ctm| !ctm.inverse().is_finite());
        let Some(motion) = Motion::between(self.state.ctm).filter(|_| !flat) else {
            self.warn_here("an instance that its transform flattens", "it is left out");
            return Ok(());
        };
        match self.object {
            Some(_) => {
                let bytes = size_of::<(Nested, Motion)>() as u64;
                granted(&self.at, "a copy of an object", budget::claim(bytes))?;
            }
            None => self.claim_copies(copies as u64)?,
        }
        let total = match self.object.as_ref().and_then(|open| self.objects.get_mut(open)) {
            Some(open) => {
                open.nested.push((Nested::Object(name), motion));
                open.copies = open.copies.saturating_add(copies);
                open.depth = open.depth.max(depth);
                open.copies
            }
            None => {
                self.instances = self.instances.saturating_add(copies);
                if self.instances <= MOST_INSTANCES {
                    place(&self.objects, &mut self.builder, &name, &motion);
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

    /// Reads another file as if it stood here, but keeps none of its changes of state.
    pub(super) fn import(&mut self) -> Result<(), SceneError> {
        self.after_world("Import")?;
        self.include()?;
        if let Some(file) = self.files.last_mut() {
            file.imported = true;
        }
        self.begin(Block::Import)
    }

    /// An imported file has ended.
    pub(super) fn end_import(&mut self) -> Result<(), SceneError> {
        match self.saved.pop() {
            Some((Block::Import, state, _)) => {
                self.state = state;
                self.files.pop();
                Ok(())
            }
            Some((open, _, at)) => {
                let found = format!("{0}Begin without {0}End", open.name());
                Err(SceneError::at(at, found, "the file ends before it is closed"))
            }
            None => self.refuse("a file that ends twice", ""),
        }
    }

    pub(super) fn include(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        let path = resolve(&self.folder, &name);
        if self.files.len() >= MOST_NESTED {
            let found = format!("more than {MOST_NESTED} files include each other");
            return self.refuse(found, "does one include itself?");
        }
        let text =
            bytes(&path).map_err(|source| SceneError::Include { at: self.at.clone(), source })?;
        let [files, total] = &mut self.included;
        *files += 1;
        *total += text.len() as u64;
        if *files > MOST_INCLUDED[0] || *total > MOST_INCLUDED[1] {
            let found = format!("{files} included files of {} in all", Size(*total));
            let most = format!("{} of {}", MOST_INCLUDED[0], Size(MOST_INCLUDED[1]));
            let expected = format!("expected at most {most}: do they include each other?");
            return self.refuse(found, &expected);
        }
        debug_assert!(self.pending.is_none(), "a directive without parameters looks not ahead");
        self.files.push(Lexer::new(Arc::from(path), text));
        Ok(())
    }

    pub(super) fn world_begin(&mut self) -> Result<(), SceneError> {
        self.before_world("a second WorldBegin")?;
        self.in_world = true;
        self.state.ctm = [DAffine3::IDENTITY; 2];
        self.state.active = [true; 2];
        self.systems.insert("world".to_owned(), self.state.ctm);
        Ok(())
    }
}
