//! The reader of a scene: runs the directives of a file and collects the scene that they describe.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;

use super::camera::CameraDirective;
use super::curves::OpenCurves;
use super::description::{Description, FilmSpec, FilterSpec};
use super::film::{FilmKind, film_spec};
use super::forward_references::Deferred;
use super::graphics_state::{Block, GraphicsState, OpenBlock};
use super::include::Included;
use super::lexer::{Lexer, LexerPosition, Token, TokenKind};
use super::materials::NamedMaterial;
use super::media::NamedMedia;
use super::memory::granted;
use super::moving_shapes::MovingObject;
use super::objects::Object;
use super::params::Params;
use super::recovery::{Recovery, action, probable_directive};
use super::repeated_meshes::Repeated;
use super::scene_errors::SceneErrors;
use super::texture_library::TextureLibrary;
use super::{Dialect, SceneError, WarningLog};
use petzval_base::io::{HeldMemory, Location, ReadContext};
use petzval_scene::filter::Profile;
use petzval_scene::{Material, PathLimits, SceneBuilder};

/// Reads a scene file and all files that it includes.
///
/// # Errors
/// Returns all errors of the scene, up to 20, if a file cannot be read or its text is not valid.
pub fn read(path: &Path) -> Result<Description, SceneErrors> {
    read_with(path, &ReadContext::default())
}

/// Reads a scene file within a memory budget.
///
/// # Errors
/// Returns all errors of the scene, up to 20, if a file cannot be read, its text is not valid, or
/// the scene exceeds the budget.
pub fn read_with(path: &Path, context: &ReadContext) -> Result<Description, SceneErrors> {
    let mut reader = SceneReader::open(path, context)?;
    reader.run();
    reader.finish()
}

/// The state of the reader between two directives.
pub(super) struct SceneReader {
    /// The memory budget and the log of files.
    pub(super) context: ReadContext,
    /// The folder of the scene file, to which paths are relative.
    pub(super) folder: Arc<Path>,
    /// The files that are being read, each included by the one before it.
    pub(super) lexers: Vec<Lexer>,
    pub(super) peeked: Option<Token>,
    /// The number of files that are being read, and the position in the last, after the last parameter.
    pub(super) params_end: Option<(usize, LexerPosition)>,
    /// The location of the current directive.
    pub(super) at: Location,

    pub(super) state: GraphicsState,
    pub(super) open_blocks: Vec<OpenBlock>,
    pub(super) memory_of_blocks: HeldMemory,
    pub(super) coordinate_systems: HashMap<String, [DAffine3; 2]>,
    pub(super) in_world: bool,
    /// Whether `WorldEnd` has been read.
    pub(super) ended: bool,
    pub(super) dialect: Dialect,

    pub(super) film: Option<(FilmKind, Params)>,
    pub(super) camera: CameraDirective,
    /// Samples a pixel.
    pub(super) samples: Option<u32>,
    pub(super) sampler_seed: Option<u32>,
    /// The seed of `Option`, which counts if the sampler has none.
    pub(super) option_seed: Option<u32>,
    /// Factor of the edge lengths of displaced meshes.
    pub(super) displacement_edge_scale: f64,
    pub(super) filter: Option<FilterSpec>,
    pub(super) path_limits: Option<PathLimits>,
    /// The times of the start and the end transform (s).
    pub(super) transform_times: [f64; 2],

    pub(super) library: TextureLibrary,
    /// Textures, materials and alphas that name a texture that is not defined yet.
    pub(super) deferred: Vec<Deferred>,
    pub(super) materials: HashMap<String, NamedMaterial>,
    pub(super) media: NamedMedia,
    /// Whether the integrator of the scene ignores media.
    pub(super) ignores_media: bool,
    /// Whether the integrator of the scene computes ambient occlusion.
    pub(super) ambient_occlusion: bool,
    pub(super) objects: HashMap<String, Object>,
    /// The name of the object between `ObjectBegin` and `ObjectEnd`.
    pub(super) open_object: Option<String>,
    /// Copies of objects in the world, nested ones included.
    pub(super) instance_count: usize,
    /// Numbers of triangles, quadrics and instances by the object that they belong to; `None` is
    /// the world.
    pub(super) primitive_counts: HashMap<Option<u32>, u64>,
    pub(super) included: Included,
    pub(super) repeated: Repeated,
    pub(super) moving_object: Option<MovingObject>,
    pub(super) open_curves: Option<OpenCurves>,
    /// The shapes with an area light, and their locations.
    pub(super) emitters: Vec<(u32, Location)>,
    pub(super) builder: SceneBuilder,

    pub(super) warnings: WarningLog,
    pub(super) recovery: Recovery,
}

impl SceneReader {
    fn open(path: &Path, context: &ReadContext) -> Result<Self, SceneError> {
        let text = context.bytes(path)?;
        let lexer = Lexer::new(Arc::from(path), Arc::new(text));
        lexer.check_language()?;
        let dialect = if lexer.has_world_end() { Dialect::V3 } else { Dialect::V4 };
        let folder = path.parent().unwrap_or(Path::new(""));
        let reader = Self::new(lexer.here(), folder, context)?;
        Ok(Self { lexers: vec![lexer], dialect, ..reader })
    }

    /// Returns a reader that is at no file. File names are relative to `folder`.
    pub(super) fn new(
        at: Location,
        folder: &Path,
        context: &ReadContext,
    ) -> Result<Self, SceneError> {
        let mut builder = SceneBuilder::default();
        let material = builder.add_material(Material::diffuse([0.5; 3]));
        let folder = Arc::from(folder);
        let camera = CameraDirective::default_at(at.clone(), Arc::clone(&folder), context.clone());
        let memory_of_blocks = granted(&at, "a scene", context.hold(0))?;
        Ok(Self {
            context: context.clone(),
            folder,
            peeked: None,
            params_end: None,
            at,
            lexers: Vec::new(),
            state: GraphicsState::new(material),
            open_blocks: Vec::new(),
            memory_of_blocks,
            coordinate_systems: HashMap::new(),
            in_world: false,
            ended: false,
            dialect: Dialect::V4,
            film: None,
            camera,
            samples: None,
            sampler_seed: None,
            option_seed: None,
            displacement_edge_scale: 1.0,
            filter: None,
            path_limits: None,
            transform_times: [0.0, 1.0],
            library: TextureLibrary::default(),
            deferred: Vec::new(),
            materials: HashMap::new(),
            media: NamedMedia::default(),
            ignores_media: false,
            ambient_occlusion: false,
            objects: HashMap::new(),
            open_object: None,
            instance_count: 0,
            primitive_counts: HashMap::new(),
            included: Included::default(),
            repeated: Repeated::default(),
            moving_object: None,
            open_curves: None,
            emitters: Vec::new(),
            builder,
            warnings: WarningLog::default(),
            recovery: Recovery::default(),
        })
    }

    /// Runs all directives. Reports their errors.
    fn run(&mut self) {
        while !self.ended && !self.recovery.stopped {
            match self.directive() {
                Ok(true) => {}
                Ok(false) => break,
                Err(error) => self.recover(error),
            }
        }
    }

    /// Runs the next directive. Returns false at the end of the file.
    fn directive(&mut self) -> Result<bool, SceneError> {
        self.recovery.begin();
        let Some(token) = self.next()? else { return Ok(false) };
        self.at = self.location(&token);
        if token.kind == TokenKind::End {
            self.end_import()?;
            return Ok(true);
        }
        let shown = token.kind.shown();
        let TokenKind::Name(name) = token.kind else {
            let found = format!("{shown} in place of a directive");
            return self.refuse(found, "expected Shape, Material, Translate ...");
        };
        match action(&name) {
            Some(action) => action(self)?,
            None => {
                let expected = match probable_directive(&name) {
                    Some(probable) => format!("did you mean \"{probable}\"?"),
                    None => "expected Shape, Material, Translate ...".to_owned(),
                };
                let unknown = self.refuse(format!("unknown directive \"{shown}\""), &expected);
                self.run_probable(&name);
                return unknown;
            }
        }
        Ok(true)
    }

    /// Reports what is missing at the end of the file.
    fn check_end(&mut self) {
        match self.open_blocks.pop() {
            Some(OpenBlock { block, at, .. })
                if self.dialect.is_older() && block != Block::Import =>
            {
                let kind = format!("{0}Begin without {0}End", block.name());
                self.warnings.warn(&at, &kind, || format!("{kind}: it ends with the file"));
            }
            Some(open) if !self.recovery.blocks_mismatch => self.report(open.unclosed()),
            _ => {}
        }
        if !self.in_world {
            let here = self.lexers.first().map_or_else(|| self.at.clone(), Lexer::here);
            let empty = self.lexers.first().is_some_and(|lexer| lexer.text().is_empty());
            let [found, expected] = match empty {
                true => [
                    "the file ends without WorldBegin: it is empty",
                    "expected a scene in the language of pbrt",
                ],
                false => [
                    "the file ends without WorldBegin",
                    "write it before the first shape, material, texture or light",
                ],
            };
            self.report(SceneError::at(here, found, expected));
        }
        self.require_named_materials();
        self.require_named_media();
        self.resolve_forward_references();
        for error in self.library.image_files.read(&self.context) {
            self.report(error);
        }
    }

    pub(super) fn finish(mut self) -> Result<Description, SceneErrors> {
        if !self.recovery.stopped {
            self.check_end();
        }
        for (shape, at) in std::mem::take(&mut self.emitters) {
            if self.dialect.is_older() {
                self.builder.keep_interface_emission(shape);
            } else if self.builder.remove_interface_emission(shape) {
                let feature = "an area light on an interface";
                self.warnings.unsupported(&at, feature, "the shape emits no light");
            }
        }
        if self.ignores_media && self.builder.remove_media() {
            let instead = "pbrt-v4's does not scatter in media either; use \"volpath\"";
            self.warnings.unsupported(&self.at, "a medium in a scene of this integrator", instead);
        }
        if self.ambient_occlusion {
            self.builder.whiten();
        }
        let film = match &self.film {
            Some((kind, params)) => film_spec(*kind, params),
            None => Ok(FilmSpec::default()),
        };
        let film = self.report_any(film);
        let (camera, shutter) = (self.camera.spec(self.dialect), self.camera.shutter(self.dialect));
        let (camera, shutter) = (self.report_any(camera), self.report_any(shutter));
        let at = self.at.clone();
        let scene = std::mem::take(&mut self.builder).build();
        let scene = self.report_any(scene.map_err(|source| SceneError::TooLarge { at, source }));
        let errors = self.recovery.take();
        let (None, Some(film), Some(camera), Some(shutter), Some(scene)) =
            (&errors, film, camera, shutter, scene)
        else {
            return Err(errors.unwrap_or_default());
        };
        // pbrt-v2 computes direct light only unless told otherwise, pbrt-v4 traces paths.
        let direct_only = self.dialect == Dialect::V2;
        let path_limits = PathLimits { max_depth: 5, direct_only, regularize: false };
        let CameraDirective { params, motion, .. } = self.camera;
        Ok(Description {
            camera,
            film,
            world_from_camera: motion.at(0.0),
            camera_motion: motion,
            transform_times: self.transform_times,
            shutter,
            camera_at: params.at,
            samples: self.samples.unwrap_or(16),
            seed: self.sampler_seed.or(self.option_seed).unwrap_or(0),
            filter: self.filter.unwrap_or(match self.dialect {
                Dialect::V4 | Dialect::V3 => {
                    FilterSpec { profile: Profile::Gaussian { sigma: 0.5 }, radius: [1.5; 2] }
                }
                Dialect::V2 => FilterSpec { profile: Profile::Box, radius: [0.5; 2] },
            }),
            path_limits: self.path_limits.unwrap_or(path_limits),
            scene,
            warnings: self.warnings.into_warnings(),
            files: self.context.files(),
            context: self.context,
        })
    }
}
