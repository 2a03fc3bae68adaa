//! The Material, MakeNamedMaterial and NamedMaterial directives.

use std::sync::Arc;

use super::attributes::Target;
use super::directive_kinds::Selected;
use super::forward_references::Deferred;
use super::material_builder::MaterialBuilder;
use super::material_kinds::{MATERIAL, MaterialKind};
use super::params::{Param, Params, Values};
use super::reader::SceneReader;
use super::repeated_meshes::RepeatedMaterial;
use super::{SceneError, suggestion_or};
use petzval_base::io::{Location, hint};
use petzval_image::Transfer;
use petzval_scene::{ImageMap, Mapping, Material, MaterialModel, Wrap};

/// A material that is defined or used by name.
pub(super) struct NamedMaterial {
    pub(super) index: u32,
    /// Its directive, in a file of pbrt-v3 or older.
    directive: Option<Arc<MaterialDirective>>,
    /// The location of its first use, until it is defined.
    pub(super) forward_reference: Option<Location>,
    /// Depth of nested mixes, itself included.
    pub(super) mix_depth: u32,
}

/// The kind and the parameters of a material.
pub(super) struct MaterialDirective {
    kind: String,
    params: Params,
}

/// A checked material, whose textures may not be defined yet.
pub(super) struct MaterialDraft {
    /// `None` if the kind is not supported.
    kind: Option<MaterialKind>,
    params: Params,
    normal_map: Option<ImageMap>,
    /// The materials of a mix.
    mixed: Mixed,
}

/// The two materials of a mix, and the depth of nested mixes that it makes.
#[derive(Clone, Copy, Default)]
struct Mixed {
    materials: [u32; 2],
    depth: u32,
}

/// Limit of the depth of nested mixes: each level costs every ray a random number.
const MAX_MIX_DEPTH: u32 = 64;

/// Whether a material has a name.
#[derive(Clone, Copy, PartialEq)]
enum Naming {
    Named,
    Unnamed,
}

impl SceneReader {
    pub(super) fn material(&mut self) -> Result<(), SceneError> {
        self.require_in_world("Material")?;
        let kind = self.string()?;
        let place = self.kept_place(Target::Material);
        let params = self.params()?;
        let directive = self.older_directive(&kind, &params);
        let space = self.state.colour_space;
        // A material without textures and other materials is the same at each inclusion of its file.
        let place = place.filter(|_| params.all.iter().all(|param| param.kind != "texture"));
        let known = place.and_then(|place| self.repeated.materials.get(&place));
        if let Some(known) = known.filter(|known| known.space == space) {
            self.state.material = known.index;
            self.state.material_directive = directive;
            return Ok(());
        }
        let draft = self.draft_material(&kind, params, Naming::Unnamed)?;
        let index = self.builder.add_material(Material::diffuse([0.5; 3]));
        if let (Some(place), 0) = (place, draft.mixed.depth) {
            self.repeated.materials.insert(place, RepeatedMaterial { index, space });
        }
        self.state.material = index;
        self.state.material_directive = directive;
        self.define_or_defer(Deferred::Material { index, draft })
    }

    pub(super) fn make_named_material(&mut self) -> Result<(), SceneError> {
        self.require_in_world("MakeNamedMaterial")?;
        let name = self.string()?;
        let mut params = self.params()?;
        let Some(kind) = params.text("type")?.map(str::to_owned) else {
            return self.refuse(
                "a named material without \"string type\"",
                "expected a kind, such as diffuse",
            );
        };
        params.all.retain(|param| param.name != "type");
        let directive = self.older_directive(&kind, &params);
        let draft = self.draft_material(&kind, params, Naming::Named)?;
        let index = match self.materials.get(&name) {
            Some(NamedMaterial { index, forward_reference: Some(_), .. }) => *index,
            _ => self.builder.add_material(Material::diffuse([0.5; 3])),
        };
        self.builder.name_material(index, &name);
        let mix_depth = draft.mixed.depth;
        let named = NamedMaterial { index, directive, forward_reference: None, mix_depth };
        self.materials.insert(name, named);
        self.define_or_defer(Deferred::Material { index, draft })
    }

    /// Selects a named material, which may be defined later: pbrt-v4 looks names up at the end of
    /// the file.
    pub(super) fn named_material(&mut self) -> Result<(), SceneError> {
        self.require_in_world("NamedMaterial")?;
        let name = self.string()?;
        let at = self.at.clone();
        let directive = self.materials.get(&name).and_then(|named| named.directive.clone());
        self.state.material_directive = directive;
        self.state.material = self.material_index(name, &at);
        Ok(())
    }

    /// Returns the directive of a material, which shapes may override in files of pbrt-v3 and older.
    fn older_directive(&self, kind: &str, params: &Params) -> Option<Arc<MaterialDirective>> {
        let (kind, params) = (kind.to_owned(), params.clone());
        self.dialect.is_older().then(|| Arc::new(MaterialDirective { kind, params }))
    }

    /// Takes the parameters of a shape that the current material reads and the shape does not, and
    /// returns the material with them, or the current one if there are none. `is_own` tells the
    /// parameters of the shape.
    pub(super) fn overridden_material(
        &mut self,
        params: &mut Params,
        is_own: impl Fn(&str) -> bool,
    ) -> Result<u32, SceneError> {
        let Some(directive) = self.state.material_directive.clone() else {
            return Ok(self.state.material);
        };
        let overrides = |name: &str| !is_own(name) && MATERIAL.reads_param(&directive.kind, name);
        let (own, taken): (Vec<Param>, Vec<Param>) =
            std::mem::take(&mut params.all).into_iter().partition(|p| !overrides(&p.name));
        params.all = own;
        if taken.is_empty() {
            return Ok(self.state.material);
        }
        let mut all = directive.params.clone();
        all.all.retain(|param| taken.iter().all(|other| other.name != param.name));
        all.all.extend(taken);
        self.unnamed_material(&directive.kind, all)
    }

    /// Adds a material without a name and returns its index.
    pub(super) fn unnamed_material(
        &mut self,
        kind: &str,
        params: Params,
    ) -> Result<u32, SceneError> {
        let draft = self.draft_material(kind, params, Naming::Unnamed)?;
        let index = self.builder.add_material(Material::diffuse([0.5; 3]));
        self.define_or_defer(Deferred::Material { index, draft })?;
        Ok(index)
    }

    /// Returns the index of a named material, which may be defined later.
    fn material_index(&mut self, name: String, at: &Location) -> u32 {
        let Self { materials, builder, .. } = self;
        let named = materials.entry(name).or_insert_with(|| NamedMaterial {
            index: builder.add_material(Material::diffuse([0.5; 3])),
            directive: None,
            forward_reference: Some(at.clone()),
            mix_depth: 0,
        });
        named.index
    }

    /// Reports each material that is used by a name but never defined.
    pub(super) fn require_named_materials(&mut self) {
        let undefined = self.materials.iter().filter_map(|(name, named)| {
            let at = named.forward_reference.clone()?;
            (!self.recovery.is_lost(name)).then(|| (at, name.clone()))
        });
        let mut undefined: Vec<(Location, String)> = undefined.collect();
        undefined.sort();
        let expected = "expected a name that MakeNamedMaterial defines";
        for (at, name) in undefined {
            let behind = suggestion_or(self.material_hint(&name), expected);
            let found = format!("no material named \"{name}\"{behind}");
            self.report(SceneError::at(at, found, ""));
        }
    }

    /// Returns "; did you mean ...?" for the name of a material that is not defined, or nothing.
    fn material_hint(&self, name: &str) -> String {
        let defined = self.materials.iter().filter(|(_, named)| named.forward_reference.is_none());
        hint(name, defined.map(|(name, _)| name.as_str()))
    }

    /// Checks all of a material but its textures.
    fn draft_material(
        &mut self,
        kind: &str,
        mut params: Params,
        naming: Naming,
    ) -> Result<MaterialDraft, SceneError> {
        // An opacity of 1 is no loss.
        let is_one =
            |values: &Values| matches!(values, Values::Numbers(v) if v.iter().all(|&c| c == 1.0));
        params.all.retain(|param| param.name != "opacity" || !is_one(&param.values));
        let Selected { kind, params, .. } = self.check_kind(&MATERIAL, kind, params)?;
        let normal_map = match kind {
            Some(_) => self.normal_map(&params)?,
            None => None,
        };
        let mixed = match kind {
            Some(MaterialKind::Mix) => self.mixed(&params, naming)?,
            _ => Mixed::default(),
        };
        Ok(MaterialDraft { kind, params, normal_map, mixed })
    }

    /// Makes a material, once its textures are defined.
    pub(super) fn build_material(&mut self, draft: &MaterialDraft) -> Result<Material, SceneError> {
        let Self { library, warnings, .. } = self;
        let mut builder = MaterialBuilder { params: &draft.params, library, warnings };
        let Some(kind) = draft.kind else { return Ok(Material::new(builder.substitute())) };
        let model = match kind {
            MaterialKind::Model(read) => read(&mut builder)?,
            MaterialKind::Mix => {
                let materials = draft.mixed.materials;
                MaterialModel::Mix { materials, amount: builder.amount()? }
            }
        };
        let bump = match builder.maybe_number("displacement")? {
            Some(bump) => Some(bump),
            None => builder.maybe_number("bumpmap")?,
        };
        // As in pbrt-v4, hairs have neither bumps nor a normal map.
        let (bump, normal_map) = match model {
            MaterialModel::Hair(_) => (None, None),
            _ => (bump, draft.normal_map.clone()),
        };
        Ok(Material { bump, normal_map, ..Material::new(model) })
    }

    /// Reads the materials of a mix. As in pbrt-v4, those of a named mix must be defined before it,
    /// so that no mix contains itself.
    fn mixed(&mut self, params: &Params, naming: Naming) -> Result<Mixed, SceneError> {
        let expected = "expected the names of two";
        let old = (params.text("namedmaterial1")?, params.text("namedmaterial2")?);
        let names = match (params.texts("materials")?, old) {
            (Some([first, second]), _) => [first.as_str(), second.as_str()],
            // The amount of pbrt-v3 is that of its first material, of pbrt-v4 that of its second.
            (None, (Some(first), Some(second))) => [second, first],
            (Some(names), _) => {
                let found = format!("a mix of {} materials", names.len());
                return Err(params.refuse("materials", found, expected));
            }
            (None, _) => {
                let found = "a mix without \"string materials\"";
                return Err(params.refuse("materials", found, expected));
            }
        };
        let given = if old.0.is_some() { "namedmaterial1" } else { "materials" };
        let at = params.location(given);
        let mut mixed = Mixed { materials: [0; 2], depth: 1 };
        for (material, name) in mixed.materials.iter_mut().zip(names) {
            *material = match (self.materials.get(name), name) {
                (Some(NamedMaterial { index, forward_reference: None, mix_depth, .. }), _) => {
                    mixed.depth = mixed.depth.max(mix_depth + 1);
                    *index
                }
                (_, "interface") => {
                    self.builder.add_material(Material::new(MaterialModel::Interface))
                }
                _ if naming == Naming::Unnamed || self.recovery.is_lost(name) => {
                    self.material_index(name.to_owned(), &at)
                }
                _ => {
                    let found = format!("no material named \"{name}\"{}", self.material_hint(name));
                    let expected = "define the materials of a mix before it";
                    return Err(params.refuse("materials", found, expected));
                }
            };
        }
        if mixed.depth > MAX_MIX_DEPTH {
            let found = format!("a mix of {} nested mixes", mixed.depth);
            return Err(params.refuse("materials", found, "expected at most 64: mix fewer"));
        }
        Ok(mixed)
    }

    fn normal_map(&mut self, params: &Params) -> Result<Option<ImageMap>, SceneError> {
        // Only PNG and TIFF can be linear: pbrt-v4, which reads no TIFF, decodes other 8-bit images from sRGB even
        // here.
        let is_linear = |name: &str| {
            let name = name.to_lowercase();
            [".png", ".tif", ".tiff"].iter().any(|end| name.ends_with(end))
        };
        let transfer = match params.text("normalmap")? {
            Some(name) if !is_linear(name) => Transfer::Srgb,
            Some(_) | None => Transfer::Linear,
        };
        let picture = self.library.whole_image(params, "normalmap", transfer)?;
        Ok(picture.map(|picture| ImageMap {
            picture,
            mapping: Mapping::default(),
            wrap: Wrap::Repeat,
            top_down: false,
            scale: 1.0,
            invert: false,
        }))
    }
}
