//! From words to a scene: the graphics state and the directives that change it.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::SceneError;
use super::appearance::{Dialect, Library};
use super::description::{CameraSpec, Description, FilmSpec, RealisticSpec, ThinSpec};
use super::params::{Param, Params, Values, kind_hint, kind_of};
use super::shapes;
use super::token::{Lexer, Token, Word};
use super::vocabulary::{Entry, entry};
use crate::scene::{Geometry, Material, SceneBuilder, Texture};
use crate::source::{Location, Unreadable, Warning, hint};

/// Files that may include each other in a chain.
const MOST_NESTED: usize = 32;
/// Copies of objects in one scene.
const MOST_INSTANCES: usize = 1 << 26;
/// Pixels on one side of a picture.
const MOST_PIXELS: u32 = 1 << 16;

/// Reads a scene file and all that it includes.
///
/// # Errors
/// Where a file cannot be read or its text is not what it should be.
pub fn read(path: &Path) -> Result<Description, SceneError> {
    let mut reader = Reader::new(path)?;
    reader.run()?;
    reader.finish()
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
    ("SurfaceIntegrator", Reader::integrator),
    ("VolumeIntegrator", |r| r.leave_out("VolumeIntegrator")),
    ("Renderer", |r| r.leave_out("Renderer")),
    ("Accelerator", |r| r.leave_out("Accelerator")),
    ("Identity", |r| {
        r.state.ctm = DAffine3::IDENTITY;
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
    ("TransformTimes", |r| {
        r.numbers::<2>()?;
        r.warn_here("TransformTimes", "nothing moves: the transforms at the start are used");
        Ok(())
    }),
    ("AttributeBegin", |r| r.begin(Block::Attribute)),
    ("AttributeEnd", |r| r.end(Block::Attribute)),
    ("TransformBegin", |r| r.begin(Block::Transform)),
    ("TransformEnd", |r| r.end(Block::Transform)),
    ("ObjectBegin", Reader::object_begin),
    ("ObjectEnd", Reader::object_end),
    ("ObjectInstance", Reader::object_instance),
    ("Include", Reader::include),
    ("Import", Reader::include),
    ("WorldBegin", Reader::world_begin),
    ("WorldEnd", |_| Ok(())),
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
        r.string()?;
        if matches!(r.peek()?, Some(Word::Text(_))) {
            r.string()?;
        }
        r.warn_here("MediumInterface", "there are no media");
        Ok(())
    }),
    ("ColorSpace", |r| {
        if r.string()? != "srgb" {
            r.warn_here("ColorSpace", "colours are read as sRGB primaries");
        }
        Ok(())
    }),
    ("Option", |r| {
        r.params()?;
        r.warn_here("Option", "the option is left out");
        Ok(())
    }),
    ("Attribute", |r| {
        r.string()?;
        r.params()?;
        r.warn_here("Attribute", "the attributes are left out");
        Ok(())
    }),
];

/// What AttributeBegin saves.
#[derive(Clone)]
struct State {
    ctm: DAffine3,
    reversed: bool,
    material: u32,
    /// Radiance and whether both sides shine.
    area_light: Option<([f32; 3], bool)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Block {
    Attribute,
    Transform,
    Object,
}

impl Block {
    fn name(self) -> &'static str {
        match self {
            Self::Attribute => "Attribute",
            Self::Transform => "Transform",
            Self::Object => "Object",
        }
    }
}

/// An object, and the copies of other objects in it.
struct Object {
    index: u32,
    nested: Vec<(String, DAffine3)>,
    copies: usize,
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

struct Reader {
    folder: PathBuf,
    files: Vec<Lexer>,
    pending: Option<Token>,
    at: Location,

    state: State,
    saved: Vec<(Block, State, Location)>,
    systems: HashMap<String, DAffine3>,
    in_world: bool,
    dialect: Dialect,

    film: Option<Params>,
    camera: Option<(String, Params, DAffine3)>,
    samples: Option<u32>,
    seed: u32,
    max_depth: Option<u32>,

    library: Library,
    materials: HashMap<String, u32>,
    objects: HashMap<String, Object>,
    object: Option<String>,
    instances: usize,
    builder: SceneBuilder,

    warnings: Vec<Warning>,
    warned: HashSet<String>,
}

/// The bytes of a file.
fn load(path: &Path) -> Result<Vec<u8>, Unreadable> {
    fs::read(path).map_err(|source| Unreadable { path: path.to_owned(), source })
}

impl Reader {
    fn new(path: &Path) -> Result<Self, SceneError> {
        let text = load(path)?;
        let lexer = Lexer::new(Arc::from(path), text);
        let mut builder = SceneBuilder::default();
        let material = builder.material(Material { reflectance: Texture::Constant([0.5; 3]) });
        Ok(Self {
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            pending: None,
            at: lexer.here(),
            files: vec![lexer],
            state: State { ctm: DAffine3::IDENTITY, reversed: false, material, area_light: None },
            saved: Vec::new(),
            systems: HashMap::new(),
            in_world: false,
            dialect: Dialect::V4,
            film: None,
            camera: None,
            samples: None,
            seed: 0,
            max_depth: None,
            library: Library::default(),
            materials: HashMap::new(),
            objects: HashMap::new(),
            object: None,
            instances: 0,
            builder,
            warnings: Vec::new(),
            warned: HashSet::new(),
        })
    }

    fn run(&mut self) -> Result<(), SceneError> {
        while let Some(token) = self.next()? {
            let at = self.place(&token);
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

    // Words

    /// The next word; at the end of an included file, of the one that includes it.
    fn next(&mut self) -> Result<Option<Token>, SceneError> {
        if let Some(token) = self.pending.take() {
            return Ok(Some(token));
        }
        while let Some(file) = self.files.last_mut() {
            if let Some(token) = file.token()? {
                return Ok(Some(token));
            }
            if self.files.len() == 1 {
                return Ok(None);
            }
            self.files.pop();
        }
        Ok(None)
    }

    fn peek(&mut self) -> Result<Option<&Word>, SceneError> {
        if self.pending.is_none() {
            self.pending = self.next()?;
        }
        Ok(self.pending.as_ref().map(|token| &token.word))
    }

    fn place(&self, token: &Token) -> Location {
        self.files.last().map_or_else(|| self.at.clone(), |file| file.place(token))
    }

    /// An error at a word that is not what was expected.
    fn unexpected(&self, token: Option<Token>, expected: &str) -> SceneError {
        match token {
            Some(token) => {
                let at = self.place(&token);
                SceneError::at(at, format!("found {}", token.word.shown()), expected)
            }
            None => SceneError::at(self.at.clone(), "the file ends here", expected),
        }
    }

    fn string(&mut self) -> Result<String, SceneError> {
        match self.next()? {
            Some(Token { word: Word::Text(text), .. }) => Ok(text),
            other => Err(self.unexpected(other, "expected a string in quotes")),
        }
    }

    /// N numbers, in brackets or not.
    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], SceneError> {
        let expected = format!("expected {N} numbers");
        let bracket = matches!(self.peek()?, Some(Word::Open));
        if bracket {
            self.next()?;
        }
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            match self.next()? {
                Some(Token { word: Word::Number(value), .. }) => *number = value,
                other => return Err(self.unexpected(other, &expected)),
            }
        }
        if bracket {
            match self.next()? {
                Some(Token { word: Word::Close, .. }) => {}
                other => return Err(self.unexpected(other, &format!("{expected} and a ]"))),
            }
        }
        Ok(numbers)
    }

    /// A parameter list: as many `"type name" values` as follow.
    fn params(&mut self) -> Result<Params, SceneError> {
        let mut all = Vec::new();
        while matches!(self.peek()?, Some(Word::Text(_))) {
            let Some(token) = self.next()? else { break };
            let at = self.place(&token);
            let Word::Text(declaration) = &token.word else { break };
            let words: Vec<&str> = declaration.split_whitespace().collect();
            let [kind, name] = words[..] else {
                let found = format!("found {}", token.word.shown());
                return Err(SceneError::at(at, found, "expected a parameter \"type name\""));
            };
            let Some(known) = kind_of(kind) else {
                let found = format!("unknown parameter type \"{kind}\"{}", kind_hint(kind));
                return Err(SceneError::at(at, found, ""));
            };
            let values = self.values(name)?;
            all.push(Param { kind: known.to_owned(), name: name.to_owned(), values, at });
        }
        Ok(Params { all, at: self.at.clone() })
    }

    /// One value, or several in brackets.
    fn values(&mut self, name: &str) -> Result<Values, SceneError> {
        let expected = format!("expected a value for \"{name}\", or several of one kind in [ ]");
        let bracket = matches!(self.peek()?, Some(Word::Open));
        if bracket {
            self.next()?;
        }
        let mut values: Option<Values> = None;
        loop {
            let token = self.next()?;
            let word = token.as_ref().map(|token| token.word.clone());
            match (word, &mut values) {
                (Some(Word::Close), _) if bracket => break,
                (Some(Word::Number(v)), None) => values = Some(Values::Numbers(vec![v])),
                (Some(Word::Number(v)), Some(Values::Numbers(all))) => all.push(v),
                (Some(Word::Text(v)), None) => values = Some(Values::Texts(vec![v])),
                (Some(Word::Text(v)), Some(Values::Texts(all))) => all.push(v),
                (Some(Word::Name(v)), known) if v == "true" || v == "false" => match known {
                    None => values = Some(Values::Truths(vec![v == "true"])),
                    Some(Values::Truths(all)) => all.push(v == "true"),
                    _ => return Err(self.unexpected(token, &expected)),
                },
                _ => return Err(self.unexpected(token, &expected)),
            }
            if !bracket {
                break;
            }
        }
        Ok(values.unwrap_or(Values::Numbers(Vec::new())))
    }

    /// The name and parameters of a directive, checked against the vocabulary. `None` where it
    /// is known but not supported; the warning is then given.
    fn kind(
        &mut self,
        directive: &'static str,
    ) -> Result<(&'static Entry, String, Params, bool), SceneError> {
        let name = self.string()?;
        let params = self.params()?;
        self.check(directive, name, params)
    }

    fn check(
        &mut self,
        directive: &'static str,
        name: String,
        params: Params,
    ) -> Result<(&'static Entry, String, Params, bool), SceneError> {
        let entry = entry(directive, &name, &params)?;
        if let Some(instead) = entry.instead {
            self.warn(params.at.clone(), &format!("{directive} \"{name}\""), instead);
            return Ok((entry, name, params, false));
        }
        let mut left = Vec::new();
        entry.check(&params, |param, instead| {
            left.push((param.at.clone(), param.name.clone(), instead));
        })?;
        for (at, param, instead) in left {
            self.warn(at, &format!("\"{param}\" of {directive} \"{name}\""), instead);
        }
        Ok((entry, name, params, true))
    }

    /// Notes once what is not supported and what is done instead.
    fn warn(&mut self, at: Location, what: &str, instead: &str) {
        if self.warned.insert(what.to_owned()) {
            let message = format!("{what} is not supported yet: {instead}");
            self.warnings.push(Warning { at, message });
        }
    }

    fn warn_here(&mut self, what: &str, instead: &str) {
        self.warn(self.at.clone(), what, instead);
    }

    fn leave_out(&mut self, directive: &'static str) -> Result<(), SceneError> {
        self.kind(directive).map(|_| ())
    }

    fn refuse<T>(&self, found: impl Into<String>, expected: &str) -> Result<T, SceneError> {
        Err(SceneError::at(self.at.clone(), found, expected))
    }

    fn before_world(&self, what: &str) -> Result<(), SceneError> {
        match self.in_world {
            true => self.refuse(format!("{what} after WorldBegin"), "it belongs before"),
            false => Ok(()),
        }
    }

    fn after_world(&self, what: &str) -> Result<(), SceneError> {
        match self.in_world {
            false => self.refuse(format!("{what} before WorldBegin"), "it belongs after"),
            true => Ok(()),
        }
    }

    // Transforms

    fn translate(&mut self) -> Result<(), SceneError> {
        let by = DVec3::from_array(self.numbers::<3>()?);
        self.concat(DAffine3::from_translation(by))
    }

    fn scale(&mut self) -> Result<(), SceneError> {
        let by = DVec3::from_array(self.numbers::<3>()?);
        if by.min_element().abs() == 0.0 || by.cmpeq(DVec3::ZERO).any() {
            return self.refuse("Scale by 0", "a scale that flattens space cannot be undone");
        }
        self.concat(DAffine3::from_scale(by))
    }

    fn rotate(&mut self) -> Result<(), SceneError> {
        let [angle, x, y, z] = self.numbers::<4>()?;
        let Some(axis) = DVec3::new(x, y, z).try_normalize() else {
            return self.refuse("Rotate about no axis", "expected an angle and an axis");
        };
        self.concat(DAffine3::from_axis_angle(axis, angle.to_radians()))
    }

    fn look_at(&mut self) -> Result<(), SceneError> {
        let n = self.numbers::<9>()?;
        let eye = DVec3::new(n[0], n[1], n[2]);
        let up = DVec3::new(n[6], n[7], n[8]);
        let Some(forward) = (DVec3::new(n[3], n[4], n[5]) - eye).try_normalize() else {
            return self.refuse("LookAt from a point to itself", "expected two points");
        };
        let Some(right) = up.cross(forward).try_normalize() else {
            return self.refuse("LookAt along its up vector", "expected another up");
        };
        let turn = DMat3::from_cols(right, forward.cross(right), forward);
        self.concat(DAffine3::from_mat3_translation(turn, eye).inverse())
    }

    fn matrix(&mut self, concat: bool) -> Result<(), SceneError> {
        let m = self.numbers::<16>()?;
        if [m[3], m[7], m[11]] != [0.0; 3] || m[15] == 0.0 {
            return self.refuse("a projective matrix", "expected a last row of 0 0 0 1");
        }
        let column = |i: usize| DVec3::new(m[i], m[i + 1], m[i + 2]) / m[15];
        let affine = DAffine3 {
            matrix3: DMat3::from_cols(column(0), column(4), column(8)),
            translation: column(12),
        };
        if !concat {
            self.state.ctm = DAffine3::IDENTITY;
        }
        self.concat(affine)
    }

    fn concat(&mut self, by: DAffine3) -> Result<(), SceneError> {
        self.state.ctm *= by;
        if self.state.ctm.is_finite() {
            return Ok(());
        }
        self.refuse("a transform out of range", "its numbers are no longer finite")
    }

    fn coordinate_system(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        self.systems.insert(name, self.state.ctm);
        Ok(())
    }

    fn use_coordinate_system(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        match self.systems.get(&name) {
            Some(ctm) => {
                self.state.ctm = *ctm;
                Ok(())
            }
            None => {
                let hint = hint(&name, self.systems.keys().map(String::as_str));
                self.refuse(format!("no coordinate system \"{name}\"{hint}"), "")
            }
        }
    }

    fn active_transform(&mut self) -> Result<(), SceneError> {
        match self.next()? {
            Some(Token { word: Word::Name(name), .. })
                if ["StartTime", "EndTime", "All"].contains(&name.as_str()) =>
            {
                self.warn_here("ActiveTransform", "nothing moves: every transform counts");
                Ok(())
            }
            other => Err(self.unexpected(other, "expected StartTime, EndTime or All")),
        }
    }

    // Blocks

    fn begin(&mut self, block: Block) -> Result<(), SceneError> {
        self.saved.push((block, self.state.clone(), self.at.clone()));
        Ok(())
    }

    fn end(&mut self, block: Block) -> Result<(), SceneError> {
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

    fn object_begin(&mut self) -> Result<(), SceneError> {
        self.after_world("ObjectBegin")?;
        let name = self.string()?;
        if self.object.is_some() {
            return self.refuse("ObjectBegin inside ObjectBegin", "close the first one before");
        }
        self.begin(Block::Object)?;
        let index = self.builder.object();
        self.objects.insert(name.clone(), Object { index, nested: Vec::new(), copies: 1 });
        self.object = Some(name);
        Ok(())
    }

    fn object_end(&mut self) -> Result<(), SceneError> {
        self.end(Block::Object)?;
        self.object = None;
        Ok(())
    }

    fn object_instance(&mut self) -> Result<(), SceneError> {
        self.after_world("ObjectInstance")?;
        let name = self.string()?;
        let Some(object) = self.objects.get(&name) else {
            let hint = hint(&name, self.objects.keys().map(String::as_str));
            return self.refuse(format!("no object \"{name}\"{hint}"), "");
        };
        let copies = object.copies;
        if self.object.as_ref() == Some(&name) {
            return self.refuse(format!("object \"{name}\" contains itself"), "");
        }
        let ctm = self.state.ctm;
        let total = match self.object.as_ref().and_then(|open| self.objects.get_mut(open)) {
            Some(open) => {
                open.nested.push((name, ctm));
                open.copies = open.copies.saturating_add(copies);
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
        if total > MOST_INSTANCES {
            return self
                .refuse(format!("{total} copies of objects"), "expected at most 67 million");
        }
        Ok(())
    }

    fn include(&mut self) -> Result<(), SceneError> {
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

    fn world_begin(&mut self) -> Result<(), SceneError> {
        self.before_world("a second WorldBegin")?;
        self.in_world = true;
        self.state.ctm = DAffine3::IDENTITY;
        self.systems.insert("world".to_owned(), DAffine3::IDENTITY);
        Ok(())
    }

    // Before the world

    fn film(&mut self) -> Result<(), SceneError> {
        self.before_world("Film")?;
        let (_, _, params, _) = self.kind("Film")?;
        self.film = Some(params);
        Ok(())
    }

    fn sampler(&mut self) -> Result<(), SceneError> {
        self.before_world("Sampler")?;
        let (_, _, params, supported) = self.kind("Sampler")?;
        if !supported {
            return Ok(());
        }
        let most = 1 << 30;
        let strata =
            match (params.count_of("xsamples", 1 << 15)?, params.count_of("ysamples", 1 << 15)?) {
                (None, None) => None,
                (x, y) => Some(x.unwrap_or(4) * y.unwrap_or(4)),
            };
        self.samples = params.count_of("pixelsamples", most)?.or(strata);
        self.seed = params.float("seed", 0.0)?.clamp(0.0, f64::from(u32::MAX)) as u32;
        Ok(())
    }

    fn filter(&mut self) -> Result<(), SceneError> {
        self.before_world("PixelFilter")?;
        let (_, _, params, supported) = self.kind("PixelFilter")?;
        for name in ["xwidth", "ywidth", "xradius", "yradius"] {
            if supported && params.float(name, 0.5)? != 0.5 {
                self.warn_here("a box filter of another radius than 0.5", "0.5 is used");
            }
        }
        Ok(())
    }

    fn integrator(&mut self) -> Result<(), SceneError> {
        self.before_world("Integrator")?;
        let (_, name, params, supported) = self.kind("Integrator")?;
        let asked = if supported { params.maybe_float("maxdepth")? } else { None };
        let depth = asked.unwrap_or(5.0);
        if !(0.0..=1e6).contains(&depth) || depth.fract() != 0.0 {
            let found = format!("\"maxdepth\" is {depth}");
            return Err(params.refuse("maxdepth", found, "expected a whole number from 0"));
        }
        // Direct lighting follows mirrors to maxdepth, and there are none yet.
        self.max_depth = Some(if name == "directlighting" { 1 } else { depth as u32 });
        Ok(())
    }

    fn camera(&mut self) -> Result<(), SceneError> {
        self.before_world("Camera")?;
        let (_, name, params, _) = self.kind("Camera")?;
        let world_from_camera = self.state.ctm.inverse();
        if !world_from_camera.is_finite() {
            return self.refuse("a camera transform that cannot be inverted", "");
        }
        if name == "realistic" && params.find("specfile").is_some() {
            self.dialect = Dialect::V2;
        }
        self.systems.insert("camera".to_owned(), world_from_camera);
        self.camera = Some((name, params, world_from_camera));
        Ok(())
    }

    // In the world

    fn light_source(&mut self) -> Result<(), SceneError> {
        self.after_world("LightSource")?;
        let (_, name, params, supported) = self.kind("LightSource")?;
        if supported {
            let mut spectra = Vec::new();
            let light = self.library.light(
                &name,
                &params,
                &self.state.ctm,
                self.dialect,
                &self.folder,
                &mut |name, instead| spectra.push((name.to_owned(), instead.to_owned())),
            )?;
            self.warn_spectra(spectra);
            self.builder.light(light);
        }
        Ok(())
    }

    fn warn_spectra(&mut self, found: Vec<(String, String)>) {
        for (name, instead) in found {
            self.warn_here(&format!("a spectrum for \"{name}\""), &instead);
        }
    }

    fn area_light(&mut self) -> Result<(), SceneError> {
        self.after_world("AreaLightSource")?;
        let (_, _, params, _) = self.kind("AreaLightSource")?;
        let mut spectra = Vec::new();
        let mut warn =
            |name: &str, instead: &str| spectra.push((name.to_owned(), instead.to_owned()));
        let radiance = params.colour("L", &mut warn)?.unwrap_or([1.0; 3]);
        let scale = match params.find("scale") {
            Some(param) if param.kind != "float" => params.colour("scale", &mut warn)?,
            _ => Some([params.float("scale", 1.0)? as f32; 3]),
        };
        let scale = scale.unwrap_or([1.0; 3]);
        self.warn_spectra(spectra);
        let two_sided = params.truth("twosided")?.unwrap_or(false);
        self.state.area_light = Some(([0, 1, 2].map(|i| radiance[i] * scale[i]), two_sided));
        Ok(())
    }

    fn texture(&mut self) -> Result<(), SceneError> {
        self.after_world("Texture")?;
        let name = self.string()?;
        let kind = self.string()?;
        if !["float", "color", "spectrum", "rgb"].contains(&kind.as_str()) {
            let found = format!("a texture of type \"{kind}\"");
            return self.refuse(found, "expected float, color or spectrum");
        }
        let (_, class, params, supported) = self.kind("Texture")?;
        let texture = if supported {
            let mut spectra = Vec::new();
            let texture = self.library.texture(
                &class,
                &params,
                self.dialect,
                &self.folder,
                &mut |name, instead| spectra.push((name.to_owned(), instead.to_owned())),
            )?;
            self.warn_spectra(spectra);
            texture
        } else {
            Texture::Constant([0.5; 3])
        };
        self.library.textures.insert(name, texture);
        Ok(())
    }

    fn material(&mut self) -> Result<(), SceneError> {
        self.after_world("Material")?;
        let name = self.string()?;
        let params = self.params()?;
        self.state.material = self.surface(name, params)?;
        Ok(())
    }

    fn make_named_material(&mut self) -> Result<(), SceneError> {
        self.after_world("MakeNamedMaterial")?;
        let name = self.string()?;
        let mut params = self.params()?;
        let Some(kind) = params.text("type")?.map(str::to_owned) else {
            return self.refuse("a named material without \"string type\"", "");
        };
        params.all.retain(|param| param.name != "type");
        let material = self.surface(kind, params)?;
        self.materials.insert(name, material);
        Ok(())
    }

    fn named_material(&mut self) -> Result<(), SceneError> {
        self.after_world("NamedMaterial")?;
        let name = self.string()?;
        match self.materials.get(&name) {
            Some(material) => {
                self.state.material = *material;
                Ok(())
            }
            None => {
                let hint = hint(&name, self.materials.keys().map(String::as_str));
                self.refuse(format!("no material named \"{name}\"{hint}"), "")
            }
        }
    }

    fn surface(&mut self, name: String, params: Params) -> Result<u32, SceneError> {
        let (_, _, params, supported) = self.check("Material", name, params)?;
        let mut spectra = Vec::new();
        let mut warn =
            |name: &str, instead: &str| spectra.push((name.to_owned(), instead.to_owned()));
        let mut reflectance = None;
        for name in ["Kd", "reflectance"] {
            let found = self.library.colour_or_texture(&params, name, &mut warn);
            // What is not supported is not checked either: it may call another thing Kd.
            reflectance = reflectance.or(if supported { found? } else { found.unwrap_or(None) });
        }
        self.warn_spectra(spectra);
        let reflectance = reflectance.unwrap_or(Texture::Constant([0.5; 3]));
        Ok(self.builder.material(Material { reflectance }))
    }

    fn shape(&mut self) -> Result<(), SceneError> {
        self.after_world("Shape")?;
        let (_, name, params, supported) = self.kind("Shape")?;
        if !supported {
            return Ok(());
        }
        let State { ctm, reversed, material, area_light } = self.state;
        let Some(geometry) = shapes::make(&name, &params, &ctm, reversed, &self.folder)? else {
            self.warn_here(&format!("a {name} that its transform flattens"), "it is left out");
            return Ok(());
        };
        self.add_shape(geometry, material, area_light);
        Ok(())
    }

    fn add_shape(
        &mut self,
        geometry: Geometry,
        material: u32,
        area_light: Option<([f32; 3], bool)>,
    ) {
        let object = self.object.as_ref().and_then(|name| self.objects.get(name));
        let object = object.map(|object| object.index);
        if object.is_some() && area_light.is_some() {
            self.warn_here("an area light inside an object", "the shape does not shine");
        }
        self.builder.shape(geometry, material, area_light, object);
    }

    // The end

    fn finish(self) -> Result<Description, SceneError> {
        let missing = |what: &str| {
            let here = self.files.first().map_or_else(|| self.at.clone(), Lexer::here);
            SceneError::at(here, format!("the file ends without {what}"), "")
        };
        if !self.in_world {
            return Err(missing("WorldBegin"));
        }
        let Some((name, params, world_from_camera)) = &self.camera else {
            return Err(missing("a Camera"));
        };
        let film = film_spec(self.film.as_ref())?;
        let camera = match name.as_str() {
            "realistic" => realistic(params, &self.folder)?,
            "perspective" => thin(params)?,
            _ => CameraSpec::Thin(ThinSpec {
                fov: 90.0,
                aspect: None,
                lens_radius: 0.0,
                focal_distance: 1e6,
                depth: [0.0, f64::INFINITY],
                exposure_time: 1.0,
            }),
        };
        // pbrt-v2 gathers direct light unless told otherwise, pbrt-v4 follows paths.
        let depth = if self.dialect == Dialect::V2 { 1 } else { 5 };
        Ok(Description {
            camera,
            film,
            world_from_camera: *world_from_camera,
            camera_at: params.at.clone(),
            samples: self.samples.unwrap_or(16),
            seed: self.seed,
            max_depth: self.max_depth.unwrap_or(depth),
            scene: self.builder.build(),
            warnings: self.warnings,
        })
    }
}

fn film_spec(params: Option<&Params>) -> Result<FilmSpec, SceneError> {
    let Some(params) = params else {
        let resolution = [1280, 720];
        let bounds = [[0, 0], resolution];
        return Ok(FilmSpec { resolution, diagonal: 35.0, bounds, filename: None, iso: 100.0 });
    };
    let resolution = [
        params.count_of("xresolution", MOST_PIXELS)?.unwrap_or(1280),
        params.count_of("yresolution", MOST_PIXELS)?.unwrap_or(720),
    ];
    let mut bounds = [[0, 0], resolution];
    // Both give x0 x1 y0 y1: one in shares of the picture, one in pixels.
    for (name, kind, unit) in
        [("cropwindow", "float", resolution.map(f64::from)), ("pixelbounds", "integer", [1.0, 1.0])]
    {
        let Some(window) = params.numbers(name, &[kind])? else { continue };
        let [x0, x1, y0, y1] = *window else {
            let found = format!("{} numbers", window.len());
            return Err(params.refuse(name, found, "expected x0 x1 y0 y1"));
        };
        let pixel = |v: f64, axis: usize| {
            (v * unit[axis]).ceil().clamp(0.0, f64::from(resolution[axis])) as u32
        };
        bounds = [[pixel(x0, 0), pixel(y0, 1)], [pixel(x1, 0), pixel(y1, 1)]];
        if bounds[0][0] >= bounds[1][0] || bounds[0][1] >= bounds[1][1] {
            return Err(params.refuse(name, "a window without pixels", "expected x0 x1 y0 y1"));
        }
    }
    Ok(FilmSpec {
        resolution,
        diagonal: params.positive("diagonal", 35.0)?,
        bounds,
        filename: params.text("filename")?.map(PathBuf::from),
        iso: params.positive("iso", 100.0)?,
    })
}

fn realistic(params: &Params, folder: &Path) -> Result<CameraSpec, SceneError> {
    if let Some(file) = params.text("specfile")? {
        return Ok(CameraSpec::Realistic(RealisticSpec::V2 {
            lens: folder.join(file),
            aperture: params.positive("aperture_diameter", 1.0)?,
            film_distance: params.positive("filmdistance", 70.0)?,
            film_diagonal: params.positive("filmdiag", 35.0)?,
            depth: depth_range(params, [0.001, 1e30])?,
        }));
    }
    let Some(file) = params.text("lensfile")? else {
        return Err(params.refuse(
            "lensfile",
            "a realistic camera without a lens",
            "expected \"string lensfile\" (pbrt-v4) or \"string specfile\" (pbrt-v2)",
        ));
    };
    Ok(CameraSpec::Realistic(RealisticSpec::V4 {
        lens: folder.join(file),
        aperture: params.positive("aperturediameter", 1.0)?,
        focus: params.positive("focusdistance", 10.0)?,
        exposure_time: exposure_time(params)?,
    }))
}

fn thin(params: &Params) -> Result<CameraSpec, SceneError> {
    let fov = params.positive("fov", 90.0)?;
    if fov >= 180.0 {
        return Err(params.refuse(
            "fov",
            format!("a field of view of {fov}"),
            "expected below 180",
        ));
    }
    if params.numbers("screenwindow", &["float"])?.is_some_and(|w| w != [-1.0, 1.0, -1.0, 1.0]) {
        let expected = "only -1 1 -1 1 is supported; set fov instead";
        return Err(params.refuse("screenwindow", "a window off the centre", expected));
    }
    let lens_radius = params.float("lensradius", 0.0)?;
    if lens_radius < 0.0 {
        let found = format!("a lens radius of {lens_radius}");
        return Err(params.refuse("lensradius", found, "expected 0 or more"));
    }
    let aspect = match params.find("frameaspectratio") {
        Some(_) => Some(params.positive("frameaspectratio", 1.0)?),
        None => None,
    };
    Ok(CameraSpec::Thin(ThinSpec {
        fov,
        aspect,
        lens_radius,
        focal_distance: params.positive("focaldistance", 1e6)?,
        depth: depth_range(params, [0.0, f64::INFINITY])?,
        exposure_time: exposure_time(params)?,
    }))
}

fn depth_range(params: &Params, default: [f64; 2]) -> Result<[f64; 2], SceneError> {
    let [near, far] = [params.float("hither", default[0])?, params.float("yon", default[1])?];
    if near < 0.0 || near >= far {
        let found = format!("hither {near} and yon {far}");
        return Err(params.refuse("hither", found, "expected 0 or more, and less than yon"));
    }
    Ok([near, far])
}

fn exposure_time(params: &Params) -> Result<f64, SceneError> {
    let time = params.float("shutterclose", 1.0)? - params.float("shutteropen", 0.0)?;
    if time > 0.0 {
        return Ok(time);
    }
    let found = format!("a shutter that is open for {time} s");
    Err(params.refuse("shutterclose", found, "expected shutterclose after shutteropen"))
}
