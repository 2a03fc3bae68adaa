//! Included and imported files.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use super::graphics_state::{Block, OpenBlock};
use super::lexer::Lexer;
use super::reader::SceneReader;
use super::{SceneError, resolve};
use petzval_base::io::{ByteSize, ReadContext, ReadError};

/// Limit of the chain of files that include each other.
const MAX_DEPTH: usize = 32;

/// The files included so far.
#[derive(Default)]
pub(super) struct Included {
    /// By the names that directives give them.
    files: HashMap<String, IncludedFile>,
    /// Addresses of the texts that are kept.
    kept: HashSet<usize>,
    /// Number of inclusions, and the sum of their sizes (bytes).
    count: u64,
    bytes: u64,
}

/// A file that is included once or more.
struct IncludedFile {
    path: Arc<Path>,
    /// The content from the second inclusion on: most files are included once.
    text: Option<Arc<Vec<u8>>>,
}

/// Limits of the inclusions of a scene: each costs about as long as its bytes take to read.
const MAX_COUNT: u64 = 1 << 20;
const MAX_BYTES: u64 = 1 << 32;

impl Included {
    /// Returns the address of the text of a lexer, if it is kept, so that no other text gets it.
    pub(super) fn kept(&self, lexer: &Lexer) -> Option<usize> {
        let address = Arc::as_ptr(lexer.shared_text()) as usize;
        self.kept.contains(&address).then_some(address)
    }

    /// Returns the path and the content of a file.
    fn open(
        &mut self,
        name: &str,
        folder: &Path,
        context: &ReadContext,
    ) -> Result<(Arc<Path>, Arc<Vec<u8>>), ReadError> {
        if let Some(IncludedFile { path, text: Some(text) }) = self.files.get(name) {
            return Ok((path.clone(), text.clone()));
        }
        let path: Arc<Path> = Arc::from(resolve(folder, name));
        let text = Arc::new(context.bytes(&path)?);
        match self.files.get_mut(name) {
            // A scene that has no room for the text reads it again each time.
            Some(file) if context.claim(text.len() as u64).is_ok() => {
                self.kept.insert(Arc::as_ptr(&text) as usize);
                file.text = Some(text.clone());
            }
            Some(_) => {}
            None => {
                let file = IncludedFile { path: path.clone(), text: None };
                self.files.insert(name.to_owned(), file);
            }
        }
        Ok((path, text))
    }
}

impl SceneReader {
    /// Reads another file in place of the directive.
    pub(super) fn include(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        if self.lexers.len() >= MAX_DEPTH {
            let found = format!("more than {MAX_DEPTH} files include each other");
            let expected = "does one include itself?";
            return Err(SceneError::limit(self.at.clone(), found, expected));
        }
        let opened = self.included.open(&name, &self.folder, &self.context);
        let (path, text) =
            opened.map_err(|source| SceneError::Include { at: self.at.clone(), source })?;
        self.included.count += 1;
        self.included.bytes += text.len() as u64;
        let Included { count, bytes, .. } = self.included;
        if count > MAX_COUNT || bytes > MAX_BYTES {
            let found = format!("{count} included files of {} in all", ByteSize(bytes));
            let most = format!("{MAX_COUNT} of {}", ByteSize(MAX_BYTES));
            let expected = format!("expected at most {most}: do they include each other?");
            return Err(SceneError::limit(self.at.clone(), found, expected));
        }
        debug_assert!(self.peeked.is_none(), "Include does not look ahead of its file name");
        let lexer = Lexer::new(path, text);
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
