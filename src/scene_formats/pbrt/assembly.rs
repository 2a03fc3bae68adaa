//! Scenes that a program has in memory: triangles and pictures as arrays, with the materials and lights of
//! the scene language.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::SceneError;
use super::description::Description;
use super::memory::granted;
use super::params::{Param, Params, Values};
use super::reader::SceneReader;
use super::scene_errors::SceneErrors;
use super::texture_library::TextureType;
use petzval_base::io::{ContentDigest, Location, ReadContext};
use petzval_image::{ImageSamples, Picture, Raster};
use petzval_scene::{
    Geometry, ImageTexture, Mapping, Mesh, MipMap, ShapeSpec, Texture, TextureFilter, Wrap,
};

/// Name of the arrays among the inputs of a picture.
const INPUT: &str = "the scene of arrays";

/// A camera with a real lens, its film and its samples.
#[derive(Clone, Debug)]
pub struct ViewSpec {
    /// The lens file, read when the scene is prepared.
    pub lens: PathBuf,
    /// Eye, target and up, in world space (m): left-handed, y up.
    pub look_at: [[f64; 3]; 3],
    /// Distance from the film to the plane in focus (m).
    pub focus: f64,
    /// Width and height (pixels).
    pub resolution: [u32; 2],
    /// Diagonal of the film (mm).
    pub diagonal: f64,
    /// Samples a pixel.
    pub spp: u32,
    /// Largest number of bounces of a path.
    pub max_depth: u32,
}

/// Triangles with a material.
#[derive(Clone, Debug)]
pub struct MeshSpec {
    /// Vertices, in world space (m).
    pub vertices: Vec<[f32; 3]>,
    /// Indices of three vertices for each triangle.
    pub faces: Vec<[u32; 3]>,
    /// Shading normals by vertex, of any length.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Texture coordinates by vertex; (0, 0) is the lower left corner of a picture.
    pub uv: Option<Vec<[f32; 2]>>,
    /// The material.
    pub material: KindSpec,
    /// Radiance (r, g, b), if the mesh is a light.
    pub emission: Option<[f64; 3]>,
}

/// A material or a light: a kind of the scene language, and its parameters by name.
#[derive(Clone, Debug)]
pub struct KindSpec {
    /// The kind, such as `diffuse`.
    pub kind: String,
    /// The parameters.
    pub parameters: Vec<(String, ParameterValue)>,
}

/// The value of a parameter.
#[derive(Clone, Debug)]
pub enum ParameterValue {
    /// A number.
    Number(f64),
    /// A colour: red, green and blue.
    Colour([f64; 3]),
    /// A point in world space.
    Point([f64; 3]),
    /// A text. Names of files are relative to the working directory.
    Text(String),
    /// Yes or no.
    Flag(bool),
    /// A picture of linear light, which repeats beyond its edges.
    Picture(Picture),
}

/// A scene that grows by the parts of a program, and is then what a reader makes of a scene file.
///
/// ```
/// use petzval_scene_formats::pbrt::{KindSpec, MeshSpec, ParameterValue, SceneAssembly, ViewSpec};
///
/// let view = ViewSpec {
///     lens: "lenses/dgauss.50mm.dat".into(),
///     look_at: [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
///     focus: 2.0,
///     resolution: [60, 40],
///     diagonal: 43.27,
///     spp: 16,
///     max_depth: 5,
/// };
/// let kind = |kind: &str, name: &str, colour| KindSpec {
///     kind: kind.to_owned(),
///     parameters: vec![(name.to_owned(), ParameterValue::Colour(colour))],
/// };
/// let mut scene = SceneAssembly::new(&view, &Default::default())?;
/// scene.add_light("the sky", kind("infinite", "L", [0.4, 0.45, 0.5]));
/// scene.add_mesh("the wall", MeshSpec {
///     vertices: vec![[-3.0, -3.0, 4.0], [3.0, -3.0, 4.0], [0.0, 3.0, 4.0]],
///     faces: vec![[0, 2, 1]],
///     normals: None,
///     uv: None,
///     material: kind("diffuse", "reflectance", [0.6, 0.3, 0.2]),
///     emission: None,
/// });
/// assert_eq!(scene.finish()?.film.resolution, [60, 40]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SceneAssembly {
    reader: SceneReader,
    digest: ContentDigest,
}

impl SceneAssembly {
    /// Begins a scene with its camera. The context is that of a reader of a scene file.
    ///
    /// # Errors
    /// Returns an error if the memory budget has nothing left. Errors of the parts are those of
    /// [`Self::finish`].
    pub fn new(view: &ViewSpec, context: &ReadContext) -> Result<Self, SceneErrors> {
        let reader = SceneReader::new(place("the scene"), Path::new(""), context)?;
        let mut assembly = Self { reader, digest: ContentDigest::default() };
        // The lens file is an input of its own.
        let ViewSpec { lens: _, look_at, focus, resolution, diagonal, spp, max_depth } = view;
        assembly.digest.add(&[look_at.as_flattened(), &[*focus, *diagonal]].concat());
        assembly.digest.add(&[resolution[0], resolution[1], *spp, *max_depth]);
        let set = assembly.set_view(view);
        assembly.reader.report_any(set);
        let begun = assembly.reader.world_begin();
        assembly.reader.report_any(begun);
        Ok(assembly)
    }

    fn set_view(&mut self, view: &ViewSpec) -> Result<(), SceneError> {
        let reader = &mut self.reader;
        let number = |argument: &str, kind: &str, name: &str, value: f64| Param {
            kind: kind.to_owned(),
            name: name.to_owned(),
            values: Values::Numbers(vec![value]),
            at: place(argument),
        };
        let [width, height] = view.resolution.map(f64::from);
        let film = vec![
            number("resolution", "integer", "xresolution", width),
            number("resolution", "integer", "yresolution", height),
            number("diagonal", "float", "diagonal", view.diagonal),
        ];
        reader.set_film("rgb", reader.params_of(film))?;
        let samples = vec![number("spp", "integer", "pixelsamples", f64::from(view.spp))];
        reader.set_sampler("zsobol", reader.params_of(samples))?;
        let depth = vec![number("max_depth", "integer", "maxdepth", f64::from(view.max_depth))];
        reader.set_path_integrator(reader.params_of(depth))?;
        reader.at = place("look_at");
        reader.look(view.look_at.map(DVec3::from_array))?;
        let lens = Values::Texts(vec![view.lens.to_string_lossy().into_owned()]);
        let (kind, name) = ("string".to_owned(), "lensfile".to_owned());
        let camera = vec![
            Param { kind, name, values: lens, at: place("lens") },
            number("focus", "float", "focusdistance", view.focus),
        ];
        reader.set_camera("realistic", reader.params_of(camera))
    }

    /// Adds a light. Messages call it by `name`.
    pub fn add_light(&mut self, name: &str, light: KindSpec) {
        self.add(name, |assembly| {
            let (kind, params) = assembly.select(light)?;
            assembly.reader.add_light_source(&kind, params)
        });
    }

    /// Adds a mesh. Messages call it by `name`.
    pub fn add_mesh(&mut self, name: &str, mesh: MeshSpec) {
        self.add(name, |assembly| assembly.mesh(name, mesh));
    }

    /// Returns the scene.
    ///
    /// # Errors
    /// Returns all errors of the parts, up to 20.
    pub fn finish(self) -> Result<Description, SceneErrors> {
        let Self { mut reader, digest } = self;
        reader.at = place("the scene");
        reader.context.log_digest(Path::new(INPUT), &digest);
        reader.finish()
    }

    /// Adds a part and notes its error, unless an earlier one has made the scene meaningless.
    fn add(&mut self, name: &str, part: impl FnOnce(&mut Self) -> Result<(), SceneError>) {
        if !self.reader.recovery.stopped {
            self.reader.at = place(name);
            let added = part(self);
            self.reader.report_any(added);
        }
    }

    fn mesh(&mut self, name: &str, spec: MeshSpec) -> Result<(), SceneError> {
        self.digest.add(&spec.vertices);
        self.digest.add(&spec.faces);
        self.digest.add(spec.normals.as_deref().unwrap_or_default());
        self.digest.add(spec.uv.as_deref().unwrap_or_default());
        self.digest.add(spec.emission.as_slice());
        if let Some(fault) = spec.fault() {
            return self.reader.refuse(fault, "");
        }
        let MeshSpec { vertices, faces, normals, uv, material, emission } = spec;
        let emission = match emission {
            Some(radiance) => {
                let radiance = ("L".to_owned(), ParameterValue::Colour(radiance));
                let params = self.params(vec![radiance])?;
                Some(self.reader.emission(&params)?)
            }
            None => None,
        };
        let mut mesh = Mesh {
            positions: vertices,
            triangles: faces,
            normals: normals.unwrap_or_default(),
            uvs: uv.unwrap_or_default(),
            ..Mesh::default()
        };
        // Normals become unit vectors.
        mesh.transform(&DAffine3::IDENTITY, false);
        self.reader.at = place(&format!("the material of {name}"));
        let (kind, params) = self.select(material)?;
        let material = self.reader.unnamed_material(&kind, params)?;
        self.reader.at = place(name);
        let geometry = Geometry::Mesh(mesh);
        self.reader.claim_shape("mesh", None, &geometry)?;
        let name = Some(name.to_owned());
        self.reader.add_shape(ShapeSpec { emission, name, ..ShapeSpec::new(geometry, material) });
        Ok(())
    }

    fn select(&mut self, spec: KindSpec) -> Result<(String, Params), SceneError> {
        self.digest.add(spec.kind.as_bytes());
        Ok((spec.kind, self.params(spec.parameters)?))
    }

    /// Returns parameters in the terms of the scene language, at the current place. Pictures become
    /// textures.
    fn params(&mut self, given: Vec<(String, ParameterValue)>) -> Result<Params, SceneError> {
        let mut all = Vec::new();
        for (name, value) in given {
            self.digest.add(name.as_bytes());
            let (kind, values) = match value {
                ParameterValue::Number(number) => ("float", Values::Numbers(vec![number])),
                ParameterValue::Colour(colour) => ("rgb", Values::Numbers(colour.to_vec())),
                ParameterValue::Point(point) => ("point3", Values::Numbers(point.to_vec())),
                ParameterValue::Text(text) => ("string", Values::Texts(vec![text])),
                ParameterValue::Flag(flag) => ("bool", Values::Booleans(vec![flag])),
                ParameterValue::Picture(picture) => {
                    let texture = self.texture(&name, picture)?;
                    ("texture", Values::Texts(vec![texture]))
                }
            };
            self.digest.add(format!("{kind} {values:?}").as_bytes());
            let (kind, at) = (kind.to_owned(), self.reader.at.clone());
            all.push(Param { kind, name, values, at });
        }
        Ok(self.reader.params_of(all))
    }

    /// Defines the texture of a parameter, and returns its name.
    fn texture(&mut self, parameter: &str, picture: Picture) -> Result<String, SceneError> {
        let reader = &mut self.reader;
        let Picture { size, pixels } = picture;
        self.digest.add(&size);
        self.digest.add(&pixels);
        if pixels.is_empty() || pixels.len() != size[0] * size[1] {
            let found = format!("{} pixels of \"{parameter}\"", pixels.len());
            return reader.refuse(found, &format!("expected {} x {}, 1 or more", size[0], size[1]));
        }
        let is_finite = |pixel: &[f32; 3]| pixel.iter().all(|v| v.is_finite());
        if let Some(i) = pixels.iter().position(|pixel| !is_finite(pixel)) {
            let [x, y] = [i % size[0], i / size[0]];
            return reader
                .refuse(format!("the pixel {x}, {y} of \"{parameter}\" is not finite"), "");
        }
        let samples = ImageSamples::Floats(pixels.into_flattened());
        let raster = Raster { size, channels: 3, samples };
        let [kept, working] = MipMap::more_bytes(size, raster.channels, true);
        let (what, bytes) = (format!("the texture \"{parameter}\""), raster.bytes() + kept);
        let held = granted(&reader.at, &what, reader.context.hold(bytes + working))?;
        let mipmap = MipMap::new(raster);
        granted(&reader.at, &what, held.keep(bytes))?;
        let image = ImageTexture {
            picture: mipmap.into(),
            mapping: Mapping::default(),
            wrap: Wrap::Repeat,
            filter: TextureFilter::Bilinear,
            max_anisotropy: None,
            top_down: false,
            scale: 1.0,
            invert: false,
        };
        let name = format!("{parameter} of {}", reader.at);
        let key = (TextureType::Spectrum, name.clone());
        reader.library.textures.insert(key, Texture::Image(Arc::new(image)));
        Ok(name)
    }
}

impl MeshSpec {
    /// Returns the reason why the arrays are no mesh, if there is one.
    fn fault(&self) -> Option<String> {
        let count = self.vertices.len();
        let columns = [
            ("vertices", Some(self.vertices.as_flattened()), 3),
            ("normals", self.normals.as_ref().map(|normals| normals.as_flattened()), 3),
            ("uv", self.uv.as_ref().map(|uv| uv.as_flattened()), 2),
        ];
        for (name, numbers, width) in columns {
            let Some(numbers) = numbers else { continue };
            if numbers.len() != width * count {
                return Some(format!("{} {name} for {count} vertices", numbers.len() / width));
            }
            if !numbers.iter().all(|v| v.is_finite()) {
                return Some(format!("{name} are not all finite"));
            }
        }
        if self.vertices.is_empty() || self.faces.is_empty() {
            return Some("the mesh has no vertices or no faces".to_owned());
        }
        let is_beyond = |&index: &u32| index as usize >= count;
        let beyond = self.faces.as_flattened().iter().any(is_beyond);
        beyond.then(|| format!("faces name vertices beyond the {count} there are"))
    }
}

/// Returns the location of a part that has no lines.
fn place(name: &str) -> Location {
    Location { file: Arc::from(Path::new(name)), line: 0, column: 0 }
}
