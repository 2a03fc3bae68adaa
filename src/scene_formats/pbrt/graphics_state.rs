//! Graphics state and the blocks that save and restore it.

use std::sync::Arc;

use glam::DAffine3;

use super::SceneError;
use super::attributes::Target;
use super::materials::MaterialDirective;
use super::memory::granted;
use super::params::Param;
use super::reader::SceneReader;
use petzval_base::io::Location;
use petzval_scene::{Emission, MediumInterface, VACUUM};
use petzval_spectrum::ColourSpace;

/// The state that `AttributeBegin` saves.
#[derive(Clone)]
pub(super) struct GraphicsState {
    /// The current transform at the start and at the end of the motion.
    pub(super) ctm: [DAffine3; 2],
    /// Whether directives change the start and the end transform.
    pub(super) active: [bool; 2],
    pub(super) reverse_orientation: bool,
    /// Index of the current material.
    pub(super) material: u32,
    /// The directive of the current material, in a file of pbrt-v3 or older: parameters of a shape
    /// override its own.
    pub(super) material_directive: Option<Arc<MaterialDirective>>,
    pub(super) area_light: Option<Emission>,
    /// The media on the sides of shapes.
    pub(super) media: MediumInterface,
    /// The space of `rgb` colours.
    pub(super) colour_space: ColourSpace,
    /// The defaults that `Attribute` set, by [`Target`].
    pub(super) attributes: [Arc<Vec<Param>>; Target::ALL.len()],
}

impl GraphicsState {
    pub(super) fn new(material: u32) -> Self {
        Self {
            ctm: [DAffine3::IDENTITY; 2],
            active: [true; 2],
            reverse_orientation: false,
            material,
            material_directive: None,
            area_light: None,
            media: MediumInterface { inside: VACUUM, outside: VACUUM },
            colour_space: ColourSpace::default(),
            attributes: Default::default(),
        }
    }
}

/// The kinds of blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Block {
    Attribute,
    Transform,
    Object,
    /// An imported file, at whose end its changes of state are undone.
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

/// A block that is not closed yet.
pub(super) struct OpenBlock {
    pub(super) block: Block,
    /// The state before it.
    pub(super) saved: GraphicsState,
    pub(super) at: Location,
}

impl OpenBlock {
    /// Returns the error for a file that ends before this block.
    pub(super) fn unclosed(self) -> SceneError {
        let found = format!("{0}Begin without {0}End", self.block.name());
        SceneError::at(self.at, found, "the file ends before it is closed")
    }
}

impl SceneReader {
    pub(super) fn begin_block(&mut self, block: Block) -> Result<(), SceneError> {
        // Lists grow by doubling.
        let bytes = (self.open_blocks.len() + 1) * 2 * size_of::<OpenBlock>();
        let what = format!("{} nested blocks", self.open_blocks.len() + 1);
        granted(&self.at, &what, self.memory_of_blocks.resize(bytes as u64))?;
        let (saved, at) = (self.state.clone(), self.at.clone());
        self.open_blocks.push(OpenBlock { block, saved, at });
        Ok(())
    }

    pub(super) fn end_block(&mut self, block: Block) -> Result<(), SceneError> {
        if self.dialect.is_older() {
            self.match_open_block(block);
        }
        match self.open_blocks.pop() {
            Some(open) if open.block == block => {
                if block == Block::Transform {
                    (self.state.ctm, self.state.active) = (open.saved.ctm, open.saved.active);
                } else {
                    self.state = open.saved;
                }
                Ok(())
            }
            Some(open) if open.block == Block::Import => {
                self.open_blocks.push(open);
                let found = format!("{0}End without {0}Begin in its file", block.name());
                self.refuse(found, "close each block in the file that opens it")
            }
            Some(open) => {
                let found = format!(
                    "{}End inside the {}Begin of {}",
                    block.name(),
                    open.block.name(),
                    open.at
                );
                self.open_blocks.push(open);
                self.close_enclosing(block);
                self.recovery.blocks_mismatch = true;
                self.refuse(found, "close blocks in the reverse order of their opening")
            }
            None => self.refuse(format!("{0}End without {0}Begin", block.name()), "remove it"),
        }
    }

    /// Makes the innermost open block one of the kind that ends, as pbrt reads blocks before v4:
    /// attributes and objects share one stack of states, and transforms have a stack of their own.
    fn match_open_block(&mut self, block: Block) {
        let shares_stack = |a: Block, b: Block| (a == Block::Transform) == (b == Block::Transform);
        let in_file = self.open_blocks.iter().rev().take_while(|b| b.block != Block::Import);
        let Some(depth) = in_file.map(|b| b.block).position(|open| shares_stack(open, block))
        else {
            return;
        };
        let last = self.open_blocks.len() - 1;
        // The transforms of the blocks between stay in their order, each in the place of the one
        // that it is behind.
        let taken = self.open_blocks.remove(last - depth);
        let mut transforms = (taken.saved.ctm, taken.saved.active);
        for open in &mut self.open_blocks[last - depth..] {
            let saved = (&mut open.saved.ctm, &mut open.saved.active);
            std::mem::swap(saved.0, &mut transforms.0);
            std::mem::swap(saved.1, &mut transforms.1);
        }
        let mut saved = taken.saved;
        (saved.ctm, saved.active) = transforms;
        self.open_blocks.push(OpenBlock { block, saved, at: taken.at });
    }

    /// Closes the innermost block of this kind in the file and all blocks in it, so that one
    /// misplaced end is not an error at each end behind it.
    fn close_enclosing(&mut self, block: Block) {
        let enclosing = self.open_blocks.iter().rev().take_while(|b| b.block != Block::Import);
        if let Some(depth) = enclosing.map(|open| open.block).position(|kind| kind == block) {
            self.open_blocks.truncate(self.open_blocks.len() - depth);
            if let Some(open) = self.open_blocks.pop() {
                self.state = open.saved;
            }
        }
    }

    pub(super) fn world_begin(&mut self) -> Result<(), SceneError> {
        self.require_before_world("a second WorldBegin")?;
        self.in_world = true;
        self.state.ctm = [DAffine3::IDENTITY; 2];
        self.state.active = [true; 2];
        self.coordinate_systems.insert("world".to_owned(), self.state.ctm);
        Ok(())
    }
}
