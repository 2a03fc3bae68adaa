//! Forward references: textures that are used before they are made.
//!
//! pbrt-v4 makes textures, materials and alphas when the file has ended. Here each is made where it
//! stands, so that errors are found early, unless it names a texture that is not there yet.

use std::collections::HashMap;

use super::SceneError;
use super::materials::Draft;
use super::params::Params;
use super::reader::Reader;
use super::textures::{Missing, Request};

/// Something that is made of textures.
pub(super) enum Waiting {
    Texture(Box<Request>),
    /// The material of this index.
    Material {
        index: u32,
        draft: Draft,
    },
    /// The alpha of these shapes.
    Alpha {
        shapes: Vec<u32>,
        params: Params,
    },
}

impl Reader {
    /// Makes something of its textures, or puts it off where one of them is missing.
    pub(super) fn now_or_later(&mut self, wanted: Waiting) -> Result<(), SceneError> {
        if self.make(&wanted)?.is_some() {
            if let Waiting::Texture(request) = &wanted {
                // What comes next means the new one.
                self.library.textures.remove(&request.key());
            }
            self.waiting.push(wanted);
        }
        Ok(())
    }

    /// Makes something, or answers which texture is missing.
    fn make(&mut self, wanted: &Waiting) -> Result<Option<Missing>, SceneError> {
        match wanted {
            Waiting::Texture(request) => {
                let texture = self.library.texture(request, &mut self.notices)?;
                if let Some(missing) = self.library.missing.take() {
                    return Ok(Some(missing));
                }
                self.library.textures.insert(request.key(), texture);
            }
            Waiting::Material { index, draft } => {
                let material = self.surface(draft)?;
                if let Some(missing) = self.library.missing.take() {
                    return Ok(Some(missing));
                }
                self.builder.change_material(*index, material);
            }
            Waiting::Alpha { shapes, params } => {
                let alpha = self.library.number_or_texture(params, "alpha")?;
                if let Some(missing) = self.library.missing.take() {
                    return Ok(Some(missing));
                }
                for shape in shapes {
                    self.builder.change_alpha(*shape, alpha.clone());
                }
            }
        }
        Ok(None)
    }

    /// Makes all that was put off, each when the last of its textures is there.
    ///
    /// # Errors
    /// Where a texture is never made, or of itself.
    pub(super) fn forward_references(&mut self) -> Result<(), SceneError> {
        let all = std::mem::take(&mut self.waiting);
        let mut ready: Vec<&Waiting> = all.iter().rev().collect();
        let mut blocked: HashMap<String, Vec<(&Waiting, Missing)>> = HashMap::new();
        while let Some(wanted) = ready.pop() {
            if let Some(missing) = self.make(wanted)? {
                blocked.entry(missing.name.clone()).or_default().push((wanted, missing));
            } else if let Waiting::Texture(request) = wanted {
                let freed = blocked.remove(&request.name).unwrap_or_default();
                ready.extend(freed.into_iter().map(|(wanted, _)| wanted));
            }
        }
        // By the name of each texture that is blocked: what it lacks.
        let mut lacks: HashMap<&str, &Missing> = HashMap::new();
        for (wanted, missing) in blocked.values().flatten() {
            if let Waiting::Texture(request) = wanted {
                lacks.insert(&request.name, missing);
            }
        }
        let of_all = || blocked.values().flatten().map(|(_, missing)| missing);
        let never = of_all().filter(|missing| !lacks.contains_key(missing.name.as_str()));
        if let Some(missing) = never.min_by_key(|missing| &missing.at) {
            return Err(self.library.no_texture(missing.clone()));
        }
        let Some(mut missing) = of_all().min_by_key(|missing| &missing.at) else { return Ok(()) };
        // After so many steps the way has come to the circle.
        for _ in 0..lacks.len() {
            missing = lacks.get(missing.name.as_str()).unwrap_or(&missing);
        }
        let found = format!("the texture \"{}\" is made of itself", missing.name);
        Err(SceneError::at(missing.at.clone(), found, "expected one that is not"))
    }
}
