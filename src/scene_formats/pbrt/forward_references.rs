//! Forward references: uses of textures that are defined later.
//!
//! pbrt-v4 makes textures, materials and alphas at the end of the file. This reader makes each at
//! its directive, so that errors are found early, unless it names a texture that is not defined
//! yet.

use std::collections::HashMap;

use super::SceneError;
use super::materials::MaterialDraft;
use super::params::Params;
use super::reader::SceneReader;
use super::texture_library::MissingTexture;
use super::textures::TextureDirective;

/// A definition that may have to wait for its textures.
pub(super) enum Deferred {
    Texture(Box<TextureDirective>),
    /// The material of this index.
    Material {
        index: u32,
        draft: MaterialDraft,
    },
    /// The alpha of these shapes.
    Alpha {
        shapes: Vec<u32>,
        params: Params,
    },
}

impl SceneReader {
    /// Makes a definition, or defers it if one of its textures is not defined yet.
    pub(super) fn define_or_defer(&mut self, definition: Deferred) -> Result<(), SceneError> {
        if self.define(&definition)?.is_some() {
            if let Deferred::Texture(directive) = &definition {
                // Uses that follow mean this texture, not an earlier one of the same name.
                self.library.textures.remove(&directive.key());
            }
            self.deferred.push(definition);
        }
        Ok(())
    }

    /// Makes a definition, or returns the texture that it lacks.
    fn define(&mut self, definition: &Deferred) -> Result<Option<MissingTexture>, SceneError> {
        match definition {
            Deferred::Texture(directive) => {
                let texture = self.library.texture(directive)?;
                if let Some(missing) = self.library.missing.take() {
                    return Ok(Some(missing));
                }
                self.library.textures.insert(directive.key(), texture);
            }
            Deferred::Material { index, draft } => {
                let material = self.build_material(draft)?;
                if let Some(missing) = self.library.missing.take() {
                    return Ok(Some(missing));
                }
                self.builder.replace_material(*index, material);
            }
            Deferred::Alpha { shapes, params } => {
                let alpha = self.library.number_or_texture(params, "alpha")?;
                if let Some(missing) = self.library.missing.take() {
                    return Ok(Some(missing));
                }
                for shape in shapes {
                    self.builder.set_alpha(*shape, alpha.clone());
                }
            }
        }
        Ok(None)
    }

    /// Makes all deferred definitions, each after the last of its textures. Reports textures that
    /// are never defined, or are defined by themselves.
    pub(super) fn resolve_forward_references(&mut self) {
        let all = std::mem::take(&mut self.deferred);
        let mut ready: Vec<&Deferred> = all.iter().rev().collect();
        let mut blocked: HashMap<String, Vec<(&Deferred, MissingTexture)>> = HashMap::new();
        while let Some(definition) = ready.pop() {
            match self.define(definition) {
                Err(error) => {
                    if let Deferred::Texture(directive) = definition {
                        self.recovery.lose(&directive.name);
                    }
                    self.report(error);
                }
                Ok(Some(missing)) => {
                    blocked.entry(missing.name.clone()).or_default().push((definition, missing));
                }
                Ok(None) => {
                    if let Deferred::Texture(directive) = definition {
                        let unblocked = blocked.remove(&directive.name).unwrap_or_default();
                        ready.extend(unblocked.into_iter().map(|(definition, _)| definition));
                    }
                }
            }
        }
        self.report_missing_textures(&blocked);
    }

    fn report_missing_textures(
        &mut self,
        blocked: &HashMap<String, Vec<(&Deferred, MissingTexture)>>,
    ) {
        // The texture that each blocked texture lacks, by the name of the blocked one.
        let mut lacks: HashMap<&str, &MissingTexture> = HashMap::new();
        for (definition, missing) in blocked.values().flatten() {
            if let Deferred::Texture(directive) = definition {
                lacks.insert(&directive.name, missing);
            }
        }
        let mut all_missing: Vec<&MissingTexture> =
            blocked.values().flatten().map(|(_, missing)| missing).collect();
        all_missing.sort_by_key(|missing| &missing.at);
        let is_undefined = |missing: &MissingTexture| !lacks.contains_key(missing.name.as_str());
        let mut any_undefined = false;
        for missing in all_missing.iter().filter(|missing| is_undefined(missing)) {
            any_undefined = true;
            if !self.recovery.is_lost(&missing.name) {
                self.report(self.library.undefined((*missing).clone()));
            }
        }
        let Some(mut missing) = all_missing.first().filter(|_| !any_undefined) else { return };
        // Only cycles are left. After as many steps as there are blocked textures, the chain is in
        // one.
        for _ in 0..lacks.len() {
            missing = lacks.get(missing.name.as_str()).unwrap_or(missing);
        }
        let found = format!("the texture \"{}\" is defined by itself", missing.name);
        self.report(SceneError::at(missing.at.clone(), found, "break the cycle of textures"));
    }
}
