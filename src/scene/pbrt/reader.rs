//! From words to a scene: the graphics state and the directives that change it.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;

use super::blocks::{Block, Object, State};
use super::description::{CameraSpec, Description, FilmSpec, FilterSpec, ThinSpec};
use super::forward::Waiting;
use super::materials::Named;
use super::moving::Mover;
use super::params::Params;
use super::settings::{film_spec, realistic, thin};
use super::shutter::shutter;
use super::textures::Library;
use super::token::{Lexer, Token, Word};
use super::{Dialect, Notices, SceneError};
use crate::film::filter::Profile;
use crate::motion::Motion;
use crate::scene::{Material, SceneBuilder};
use crate::shade::Reach;
use crate::shutter::Shutter;
use crate::source::{Files, Location, bytes, hint, reading};
use crate::spectrum::ColourSpace;

/// Reads a scene file and all that it includes.
///
/// # Errors
/// Where a file cannot be read or its text is not what it should be.
pub fn read(path: &Path) -> Result<Description, SceneError> {
    let (description, files) = reading(|| {
        let mut reader = Reader::new(path)?;
        reader.run()?;
        reader.finish()
    });
    Ok(Description { files, ..description? })
}

/// What a directive does.
type Action = fn(&mut Reader) -> Result<(), SceneError>;

/// Every directive: its name and what it does.
const DIRECTIVES: &[(&str, Action)] = &[
    ("Film", Reader::film),
    ("Sampler", Reader::sampler),
    ("PixelFilter", Reader::filter),
    ("Camera", Reader::camera),
    ("Integrator", Reader::integrator),
    ("SurfaceIntegrator", |r| {
        // A directive of pbrt-v2 alone.
        r.dialect = Dialect::V2;
        r.integrator()
    }),
    ("VolumeIntegrator", |r| r.leave_out("VolumeIntegrator")),
    ("Renderer", |r| r.leave_out("Renderer")),
    ("Accelerator", |r| r.leave_out("Accelerator")),
    ("Identity", |r| {
        r.identity();
        Ok(())
    }),
    ("Translate", Reader::translate),
    ("Scale", Reader::scale),
    ("Rotate", Reader::rotate),
    ("LookAt", Reader::look_at),
    ("Transform", |r| r.matrix(false)),
    ("ConcatTransform", |r| r.matrix(true)),
    ("CoordinateSystem", Reader::coordinate_system),
    ("CoordSysTransform", Reader::use_coordinate_system),
    ("ReverseOrientation", |r| {
        r.state.reversed = !r.state.reversed;
        Ok(())
    }),
    ("ActiveTransform", Reader::active_transform),
    ("TransformTimes", Reader::transform_times),
    ("AttributeBegin", |r| r.begin(Block::Attribute)),
    ("AttributeEnd", |r| r.end(Block::Attribute)),
    ("TransformBegin", |r| r.begin(Block::Transform)),
    ("TransformEnd", |r| r.end(Block::Transform)),
    ("ObjectBegin", Reader::object_begin),
    ("ObjectEnd", Reader::object_end),
    ("ObjectInstance", Reader::object_instance),
    ("Include", Reader::include),
    ("Import", Reader::import),
    ("WorldBegin", Reader::world_begin),
    ("WorldEnd", |r| {
        if r.peek()?.is_some() {
            r.warn_here("what follows WorldEnd", "it is left out");
        }
        r.ended = true;
        Ok(())
    }),
    ("LightSource", Reader::light_source),
    ("AreaLightSource", Reader::area_light),
    ("Texture", Reader::texture),
    ("Material", Reader::material),
    ("MakeNamedMaterial", Reader::make_named_material),
    ("NamedMaterial", Reader::named_material),
    ("Shape", Reader::shape),
    ("MakeNamedMedium", |r| {
        r.string()?;
        r.params()?;
        r.warn_here("MakeNamedMedium", "there are no media");
        Ok(())
    }),
    ("MediumInterface", |r| {
        let mut media = !r.string()?.is_empty();
        if matches!(r.peek()?, Some(Word::Text(_))) {
            media |= !r.string()?.is_empty();
        }
        if media {
            r.warn_here("MediumInterface", "there are no media");
        }
        Ok(())
    }),
    ("ColorSpace", Reader::colour_space),
    ("Option", Reader::option),
    ("Attribute", Reader::attribute),
];

/// What the reader has come to.
pub(super) struct Reader {
    pub(super) folder: Arc<Path>,
    pub(super) files: Vec<Lexer>,
    pub(super) pending: Option<Token>,
    pub(super) at: Location,

    pub(super) state: State,
    pub(super) saved: Vec<(Block, State, Location)>,
    pub(super) systems: HashMap<String, [DAffine3; 2]>,
    pub(super) in_world: bool,
    pub(super) ended: bool,
    pub(super) dialect: Dialect,

    pub(super) film: Option<(String, Params)>,
    pub(super) camera: (String, Params, Motion),
    pub(super) samples: Option<u32>,
    /// Of the sampler, and of the options where the sampler names none.
    pub(super) seeds: [Option<u32>; 2],
    pub(super) filter: Option<FilterSpec>,
    pub(super) reach: Option<Reach>,
    pub(super) regularize: bool,
    /// When the current transforms count, s.
    pub(super) transform_times: [f64; 2],

    pub(super) library: Library,
    /// Uses of textures that are not made yet.
    pub(super) waiting: Vec<Waiting>,
    pub(super) materials: HashMap<String, Named>,
    pub(super) objects: HashMap<String, Object>,
    pub(super) object: Option<String>,
    pub(super) instances: usize,
    /// Triangles, other shapes and copies, by the object that they belong to.
    pub(super) items: HashMap<Option<u32>, u64>,
    /// Triangles that were cut from bilinear patches.
    pub(super) of_patches: u64,
    /// Files included so far, and their bytes.
    pub(super) included: [u64; 2],
    pub(super) mover: Option<Mover>,
    /// Shapes that shine, and where they stand.
    pub(super) emitters: Vec<(u32, Location)>,
    pub(super) builder: SceneBuilder,

    pub(super) notices: Notices,
}

impl Reader {
    fn new(path: &Path) -> Result<Self, SceneError> {
        let text = bytes(path)?;
        let lexer = Lexer::new(Arc::from(path), text);
        let mut builder = SceneBuilder::default();
        let material = builder.material(Material::diffuse([0.5; 3]));
        let (at, folder) = (lexer.here(), Arc::from(path.parent().unwrap_or(Path::new(""))));
        // Where a scene says nothing of its camera, pbrt-v4 takes this one.
        let camera =
            Params { all: Vec::new(), at: at.clone(), space: ColourSpace::default(), folder };
        Ok(Self {
            folder: camera.folder.clone(),
            pending: None,
            at,
            files: vec![lexer],
            state: State::new(material),
            saved: Vec::new(),
            systems: HashMap::new(),
            in_world: false,
            ended: false,
            dialect: Dialect::V4,
            film: None,
            camera: ("perspective".to_owned(), camera, Motion::still(DAffine3::IDENTITY)),
            samples: None,
            seeds: [None; 2],
            filter: None,
            reach: None,
            regularize: false,
            transform_times: [0.0, 1.0],
            library: Library::default(),
            waiting: Vec::new(),
            materials: HashMap::new(),
            objects: HashMap::new(),
            object: None,
            instances: 0,
            items: HashMap::new(),
            of_patches: 0,
            included: [0; 2],
            mover: None,
            emitters: Vec::new(),
            builder,
            notices: Notices::default(),
        })
    }

    fn run(&mut self) -> Result<(), SceneError> {
        while !self.ended
            && let Some(token) = self.next()?
        {
            let at = self.place(&token);
            if token.word == Word::End {
                self.at = at;
                self.end_import()?;
                continue;
            }
            let Word::Name(name) = &token.word else {
                let found = format!("{} where a directive should stand", token.word.shown());
                return Err(SceneError::at(at, found, "expected Shape, Material, Translate ..."));
            };
            let Some((_, action)) = DIRECTIVES.iter().find(|(known, _)| known == name) else {
                let hint = hint(name, DIRECTIVES.iter().map(|(known, _)| *known));
                let shown = token.word.shown();
                return Err(SceneError::at(at, format!("unknown directive \"{shown}\"{hint}"), ""));
            };
            self.at = at;
            action(self)?;
        }
        match self.saved.last() {
            Some((block, _, at)) => {
                let found = format!("{}Begin without {}End", block.name(), block.name());
                Err(SceneError::at(at.clone(), found, "the file ends before it is closed"))
            }
            None => Ok(()),
        }
    }

    fn finish(mut self) -> Result<Description, SceneError> {
        if !self.in_world {
            let here = self.files.first().map_or_else(|| self.at.clone(), Lexer::here);
            return Err(SceneError::at(here, "the file ends without WorldBegin", ""));
        }
        self.promises()?;
        self.forward_references()?;
        for (shape, at) in std::mem::take(&mut self.emitters) {
            if self.builder.darken_interface(shape) {
                let what = "an area light on an interface";
                self.notices.instead(&at, what, "the shape does not shine");
            }
        }
        let (name, params, camera_motion) = &self.camera;
        self.library.pictures.read()?;
        let film = match &self.film {
            Some((name, params)) => {
                FilmSpec { gbuffer: name == "gbuffer", ..film_spec(Some(params))? }
            }
            None => film_spec(None)?,
        };
        let camera = match name.as_str() {
            "realistic" => realistic(params, &self.folder)?,
            "perspective" => thin(params)?,
            _ => CameraSpec::Thin(ThinSpec {
                fov: 90.0,
                aspect: None,
                window: None,
                lens_radius: 0.0,
                focal_distance: 1e6,
                depth: [0.0, f64::INFINITY],
                exposure_time: 1.0,
            }),
        };
        let shutter = match name.as_str() {
            "realistic" | "perspective" => shutter(params)?,
            _ => Shutter::default(),
        };
        // pbrt-v2 gathers direct light unless told otherwise, pbrt-v4 follows paths.
        let reach = Reach { max_depth: 5, direct: self.dialect == Dialect::V2 };
        Ok(Description {
            camera,
            film,
            world_from_camera: camera_motion.at(0.0),
            camera_motion: camera_motion.clone(),
            transform_times: self.transform_times,
            shutter,
            camera_at: params.at.clone(),
            samples: self.samples.unwrap_or(16),
            seed: self.seeds[0].or(self.seeds[1]).unwrap_or(0),
            filter: self.filter.unwrap_or(match self.dialect {
                Dialect::V4 => {
                    FilterSpec { profile: Profile::Gaussian { sigma: 0.5 }, radius: [1.5; 2] }
                }
                Dialect::V2 => FilterSpec { profile: Profile::Box, radius: [0.5; 2] },
            }),
            regularize: self.regularize,
            reach: self.reach.unwrap_or(reach),
            scene: self.builder.build(),
            warnings: self.notices.warnings,
            files: Files::default(),
        })
    }
}
