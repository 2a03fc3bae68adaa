//! Small worlds in two forms: data for the naive path tracer, and a scene file for the real one.

use std::fmt::Write;

use glam::DVec3;

use super::material::{Colour, NaiveMaterial};
use super::matter::Matter;

/// Geometry of a shape.
#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// A corner and two sides, along u and v. The normal is u x v.
    Quad([f64; 3], [f64; 3], [f64; 3]),
    /// Centre and radius.
    Ball([f64; 3], f64),
}

#[derive(Clone, Debug)]
pub struct Shape {
    pub form: Form,
    pub material: NaiveMaterial,
    pub emits: Colour,
    pub two_sided: bool,
    /// Whether the normal is flipped.
    pub reversed: bool,
    /// Indices of the media inside and outside, if they differ.
    pub sides: Option<[Option<usize>; 2]>,
    /// Alphas of a checkerboard with squares of 1/4 in u and v; balls use the first only.
    pub alpha: [f64; 2],
}

/// A light that no ray can hit.
#[derive(Clone, Copy, Debug)]
pub enum PointLike {
    Point {
        from: [f64; 3],
        intensity: Colour,
    },
    /// `cone` is the half-angle of the cone and `fade` the width of its penumbra (degrees).
    Spot {
        from: [f64; 3],
        to: [f64; 3],
        cone: f64,
        fade: f64,
        intensity: Colour,
    },
    Distant {
        from: [f64; 3],
        irradiance: Colour,
    },
}

/// A world, seen from the origin towards +z in a square view of 60 degrees.
#[derive(Clone, Debug, Default)]
pub struct World {
    pub shapes: Vec<Shape>,
    pub lights: Vec<PointLike>,
    pub media: Vec<Matter>,
    /// Index of the medium around the camera.
    pub around: Option<usize>,
    pub sky: Option<Colour>,
    /// Picture that multiplies the sky, an equal-area square of all directions, row 0 at the top.
    pub picture: Option<Vec<Vec<Colour>>>,
}

pub const FIELD: f64 = 60.0;

impl Shape {
    pub fn quad(corner: [f64; 3], u: [f64; 3], v: [f64; 3], material: NaiveMaterial) -> Self {
        Self::new(Form::Quad(corner, u, v), material)
    }

    pub fn ball(centre: [f64; 3], radius: f64, material: NaiveMaterial) -> Self {
        Self::new(Form::Ball(centre, radius), material)
    }

    fn new(form: Form, material: NaiveMaterial) -> Self {
        let emits = [0.0; 3];
        Self {
            form,
            material,
            emits,
            two_sided: false,
            reversed: false,
            sides: None,
            alpha: [1.0; 2],
        }
    }

    pub fn emitting(self, emits: Colour) -> Self {
        Self { emits, ..self }
    }

    /// The same shape between two media, inside and outside.
    pub fn between(self, inside: Option<usize>, outside: Option<usize>) -> Self {
        Self { sides: Some([inside, outside]), ..self }
    }

    pub fn text(&self, name: usize) -> String {
        let mut text = material(&self.material, &name.to_string());
        if self.emits != [0.0; 3] {
            let (l, both) = (list(&self.emits), self.two_sided);
            writeln!(text, r#"AreaLightSource "diffuse" "rgb L" {l} "bool twosided" {both}"#)
                .unwrap();
        }
        if let Some([inside, outside]) = self.sides {
            writeln!(text, "MediumInterface {} {}", medium(inside), medium(outside)).unwrap();
        }
        if self.reversed {
            text += "ReverseOrientation\n";
        }
        let alpha = match self.alpha {
            [1.0, 1.0] => String::new(),
            [a, b] if a == b => format!(r#""float alpha" {a}"#),
            [a, b] => {
                let board = board("float", &a.to_string(), &b.to_string());
                writeln!(text, r#"Texture "alpha{name}" {board}"#).unwrap();
                format!(r#""texture alpha" "alpha{name}""#)
            }
        };
        match self.form {
            Form::Quad(c, u, v) => {
                let [c, u, v] = [c, u, v].map(DVec3::from);
                let corners = [c, c + u, c + u + v, c + v].map(|p| p.to_array()).concat();
                let p = list(&corners);
                writeln!(
                    text,
                    r#"Shape "trianglemesh" "point3 P" {p} "point2 uv" [0 0 1 0 1 1 0 1]
                       "integer indices" [0 1 2 0 2 3] {alpha}"#
                )
            }
            Form::Ball([x, y, z], r) => {
                writeln!(text, r#"Translate {x} {y} {z} Shape "sphere" "float radius" {r} {alpha}"#)
            }
        }
        .unwrap();
        format!("AttributeBegin\n{text}AttributeEnd\n")
    }
}

/// Returns the name of a medium, in quotes.
fn medium(index: Option<usize>) -> String {
    index.map_or("\"\"".to_owned(), |index| format!("\"{index}\""))
}

fn list(numbers: &[f64]) -> String {
    format!("{numbers:?}").replace(',', " ")
}

fn board(kind: &str, first: &str, second: &str) -> String {
    let of = if kind == "float" { "float" } else { "rgb" };
    format!(
        r#""{kind}" "checkerboard" "{of} tex1" {first} "{of} tex2" {second}
           "float uscale" 4 "float vscale" 4"#
    )
}

/// Returns the directives of a material; `name` makes the names of its textures unique.
fn material(material: &NaiveMaterial, name: &str) -> String {
    let (before, parameters) = parameters(material, name);
    format!("{before}Material {parameters}\n")
}

/// Returns the directives that must precede a material's, and the parameters of its own.
fn parameters(material: &NaiveMaterial, name: &str) -> (String, String) {
    let mut before = String::new();
    let parameters_text = match material {
        NaiveMaterial::Diffuse(r) => format!(r#""diffuse" "rgb reflectance" {}"#, list(r)),
        NaiveMaterial::Checkerboard(a, b) => {
            let board = board("spectrum", &list(a), &list(b));
            writeln!(before, r#"Texture "board{name}" {board}"#).unwrap();
            format!(r#""diffuse" "texture reflectance" "board{name}""#)
        }
        NaiveMaterial::DiffuseTransmission(r, t) => format!(
            r#""diffusetransmission" "rgb reflectance" {} "rgb transmittance" {}"#,
            list(r),
            list(t)
        ),
        NaiveMaterial::Metal { alpha, eta, k } => format!(
            r#""conductor" "rgb eta" {} "rgb k" {} "float roughness" {alpha} "bool remaproughness" false"#,
            list(eta),
            list(k)
        ),
        NaiveMaterial::Glass { alpha, eta } => format!(
            r#""dielectric" "float eta" {eta} "float roughness" {alpha} "bool remaproughness" false"#
        ),
        NaiveMaterial::Below(eta, matter) => format!(
            r#""subsurface" "rgb sigma_a" {} "rgb sigma_s" {} "float g" {} "float eta" {eta}"#,
            list(&matter.absorbs),
            list(&matter.scatters),
            matter.g
        ),
        NaiveMaterial::Interface => r#""interface""#.to_owned(),
        NaiveMaterial::ThinSheet(eta) => format!(r#""thindielectric" "float eta" {eta}"#),
        NaiveMaterial::Coated { alpha, reflectance } => format!(
            r#""coateddiffuse" "rgb reflectance" {} "float roughness" {alpha} "bool remaproughness" false"#,
            list(reflectance)
        ),
        NaiveMaterial::Mix(amount, both) => {
            let mut names = String::new();
            for (i, material) in both.iter().enumerate() {
                let part = format!("{name}part{i}");
                let (textures, text) = parameters(material, &part);
                let (kind, params) = text.split_once(' ').unwrap();
                write!(
                    before,
                    r#"{textures} MakeNamedMaterial "{part}" "string type" {kind} {params} "#
                )
                .unwrap();
                write!(names, r#" "{part}""#).unwrap();
            }
            format!(r#""mix" "string materials" [{names}] "float amount" {amount}"#)
        }
        NaiveMaterial::Bumped([u, v], material) => {
            let (textures, text) = parameters(material, name);
            let both = u + v;
            writeln!(
                before,
                r#"{textures} Texture "height{name}" "float" "bilerp" "float v00" 0 "float v10" {u}
                   "float v01" {v} "float v11" {both}"#
            )
            .unwrap();
            format!(r#"{text} "texture displacement" "height{name}""#)
        }
    };
    (before, parameters_text)
}

impl PointLike {
    fn text(&self) -> String {
        match self {
            Self::Point { from, intensity } => {
                format!(
                    r#"LightSource "point" "rgb I" {} "point3 from" {}"#,
                    list(intensity),
                    list(from)
                )
            }
            Self::Spot { from, to, cone, fade, intensity } => format!(
                r#"LightSource "spot" "rgb I" {} "point3 from" {} "point3 to" {}
                   "float coneangle" {cone} "float conedeltaangle" {fade}"#,
                list(intensity),
                list(from),
                list(to)
            ),
            Self::Distant { from, irradiance } => format!(
                r#"LightSource "distant" "rgb L" {} "point3 from" {} "point3 to" [0 0 0]"#,
                list(irradiance),
                list(from)
            ),
        }
    }
}

impl World {
    /// Returns the kinds of its materials, for readers of the file of references.
    pub fn summary(&self) -> String {
        let mut kinds: Vec<String> = Vec::new();
        for shape in &self.shapes {
            let text = format!("{:?}", shape.material);
            let kind = text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
            if !kinds.iter().any(|known| known == kind) {
                kinds.push(kind.to_owned());
            }
        }
        format!("{} shapes of {}", self.shapes.len(), kinds.join(" "))
    }

    /// Returns the part of the scene file after WorldBegin.
    pub fn text(&self) -> String {
        let mut text = self.light_directives();
        if self.around.is_none() {
            text += &self.media_directives();
        }
        for (name, shape) in self.shapes.iter().enumerate() {
            text += &shape.text(name);
        }
        text
    }

    /// Returns the directives before the camera: those of the medium around it.
    pub fn prelude(&self) -> String {
        match self.around {
            Some(_) => {
                let media = self.media_directives();
                format!("{media}MediumInterface \"\" {}", medium(self.around))
            }
            None => String::new(),
        }
    }

    fn media_directives(&self) -> String {
        let media = self.media.iter().enumerate();
        media.map(|(name, matter)| matter.text(name)).collect()
    }

    /// Returns the directives of the lights that are not shapes. The sky's picture is sky.pfm.
    pub fn light_directives(&self) -> String {
        let mut text = String::new();
        for light in &self.lights {
            writeln!(text, "{}", light.text()).unwrap();
        }
        let picture = if self.picture.is_some() { r#""string filename" "sky.pfm""# } else { "" };
        if let Some([r, g, b]) = self.sky {
            match self.picture {
                Some(_) => writeln!(text, r#"LightSource "infinite" {picture} "float scale" {r}"#),
                None => writeln!(text, r#"LightSource "infinite" "rgb L" [{r} {g} {b}]"#),
            }
            .unwrap();
        }
        text
    }

    /// Returns the sky's picture as a PFM file, whose first row is the lowest.
    pub fn pfm(&self) -> Option<Vec<u8>> {
        let picture = self.picture.as_ref()?;
        let mut file = format!("PF\n{} {}\n-1.0\n", picture[0].len(), picture.len()).into_bytes();
        for value in picture.iter().rev().flatten().flatten() {
            file.extend((*value as f32).to_le_bytes());
        }
        Some(file)
    }
}
