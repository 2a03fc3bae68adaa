//! Included and imported files.

use std::sync::Arc;

use super::graphics_state::{Block, OpenBlock};
use super::lexer::Lexer;
use super::reader::SceneReader;
use super::{SceneError, resolve};
use crate::io::ByteSize;

/// Limit of the chain of files that include each other.
const MAX_DEPTH: usize = 32;

/// The files included so far; a file counts each time that it is included.
#[derive(Clone, Copy, Default)]
pub(super) struct Included {
    files: u64,
    bytes: u64,
}

const MAX_INCLUDED: Included = Included { files: 1 << 15, bytes: 1 << 32 };

impl SceneReader {
    /// Reads another file in place of the directive.
    pub(super) fn include(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        let path = resolve(&self.folder, &name);
        if self.lexers.len() >= MAX_DEPTH {
            let found = format!("more than {MAX_DEPTH} files include each other");
            let expected = "does one include itself?";
            return Err(SceneError::limit(self.at.clone(), found, expected));
        }
        let text = self.context.bytes(&path);
        let text = text.map_err(|source| SceneError::Include { at: self.at.clone(), source })?;
        self.included.files += 1;
        self.included.bytes += text.len() as u64;
        let Included { files, bytes } = self.included;
        if files > MAX_INCLUDED.files || bytes > MAX_INCLUDED.bytes {
            let found = format!("{files} included files of {} in all", ByteSize(bytes));
            let most = format!("{} of {}", MAX_INCLUDED.files, ByteSize(MAX_INCLUDED.bytes));
            let expected = format!("expected at most {most}: do they include each other?");
            return Err(SceneError::limit(self.at.clone(), found, expected));
        }
        debug_assert!(self.peeked.is_none(), "Include does not look ahead of its file name");
        let lexer = Lexer::new(Arc::from(path), text);
        lexer.check_language()?;
        self.lexers.push(lexer);
        Ok(())
    }

    /// Reads another file in place of the directive, but keeps none of its changes of state.
    pub(super) fn import(&mut self) -> Result<(), SceneError> {
        self.require_in_world("Import")?;
        self.include()?;
        if let Some(lexer) = self.lexers.last_mut() {
            lexer.imported = true;
        }
        self.begin_block(Block::Import)
    }

    /// Restores the state at the end of an imported file.
    pub(super) fn end_import(&mut self) -> Result<(), SceneError> {
        match self.open_blocks.pop() {
            Some(OpenBlock { block: Block::Import, saved, .. }) => {
                self.state = saved;
                self.lexers.pop();
                Ok(())
            }
            Some(open) => Err(open.unclosed()),
            None => self.refuse("the end of an import that has not begun", ""),
        }
    }
}
