//! Small worlds, told twice: to the naive path tracer and, as a scene file, to the real one.

use std::fmt::Write;

use glam::DVec3;

use crate::matter::{Colour, Matter};

/// The form of a shape.
#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// A corner and two sides, along u and v; its normal is u x v.
    Quad([f64; 3], [f64; 3], [f64; 3]),
    /// Centre and radius.
    Ball([f64; 3], f64),
}

#[derive(Clone, Debug)]
pub struct Shape {
    pub form: Form,
    pub matter: Matter,
    pub emits: Colour,
    pub two_sided: bool,
    /// Whether its normal is turned around.
    pub reversed: bool,
    /// Alphas of a checkerboard of squares of 1/4 in u and v; of the first one alone on balls.
    pub alpha: [f64; 2],
}

/// A light at one point, or parallel.
#[derive(Clone, Copy, Debug)]
pub enum Lamp {
    Point {
        from: [f64; 3],
        intensity: Colour,
    },
    /// Angles of the end of the cone and of the fade before it, degrees.
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

/// What is seen from the origin towards +z in a square view of 60 degrees.
#[derive(Clone, Debug, Default)]
pub struct World {
    pub shapes: Vec<Shape>,
    pub lamps: Vec<Lamp>,
    pub sky: Option<Colour>,
    /// Multiplies the sky; a square of all directions, row 0 at the top.
    pub picture: Option<Vec<Vec<Colour>>>,
}

pub const FIELD: f64 = 60.0;

impl Shape {
    pub fn quad(corner: [f64; 3], u: [f64; 3], v: [f64; 3], matter: Matter) -> Self {
        Self::new(Form::Quad(corner, u, v), matter)
    }

    pub fn ball(centre: [f64; 3], radius: f64, matter: Matter) -> Self {
        Self::new(Form::Ball(centre, radius), matter)
    }

    fn new(form: Form, matter: Matter) -> Self {
        let emits = [0.0; 3];
        Self { form, matter, emits, two_sided: false, reversed: false, alpha: [1.0; 2] }
    }

    pub fn shining(self, emits: Colour) -> Self {
        Self { emits, ..self }
    }

    pub fn text(&self, name: usize) -> String {
        let mut text = material(&self.matter, &name.to_string());
        if self.emits != [0.0; 3] {
            let (l, both) = (list(&self.emits), self.two_sided);
            writeln!(text, r#"AreaLightSource "diffuse" "rgb L" {l} "bool twosided" {both}"#)
                .unwrap();
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

/// The directives of a material; `name` makes those of its textures its own.
fn material(matter: &Matter, name: &str) -> String {
    let (before, kind) = kind(matter, name);
    format!("{before}Material {kind}\n")
}

/// What must stand before the directive, and its words.
fn kind(matter: &Matter, name: &str) -> (String, String) {
    let mut before = String::new();
    let words = match matter {
        Matter::Diffuse(r) => format!(r#""diffuse" "rgb reflectance" {}"#, list(r)),
        Matter::Board(a, b) => {
            let board = board("spectrum", &list(a), &list(b));
            writeln!(before, r#"Texture "board{name}" {board}"#).unwrap();
            format!(r#""diffuse" "texture reflectance" "board{name}""#)
        }
        Matter::Sheet(r, t) => format!(
            r#""diffusetransmission" "rgb reflectance" {} "rgb transmittance" {}"#,
            list(r),
            list(t)
        ),
        Matter::Metal { alpha, eta, k } => format!(
            r#""conductor" "rgb eta" {} "rgb k" {} "float roughness" {alpha} "bool remaproughness" false"#,
            list(eta),
            list(k)
        ),
        Matter::Glass { alpha, eta } => format!(
            r#""dielectric" "float eta" {eta} "float roughness" {alpha} "bool remaproughness" false"#
        ),
        Matter::Pane(eta) => format!(r#""thindielectric" "float eta" {eta}"#),
        Matter::Varnish { alpha, reflectance } => format!(
            r#""coateddiffuse" "rgb reflectance" {} "float roughness" {alpha} "bool remaproughness" false"#,
            list(reflectance)
        ),
        Matter::Mix(amount, both) => {
            let mut names = String::new();
            for (i, matter) in both.iter().enumerate() {
                let part = format!("{name}part{i}");
                let (textures, words) = kind(matter, &part);
                let (kind, params) = words.split_once(' ').unwrap();
                write!(
                    before,
                    r#"{textures} MakeNamedMaterial "{part}" "string type" {kind} {params} "#
                )
                .unwrap();
                write!(names, r#" "{part}""#).unwrap();
            }
            format!(r#""mix" "string materials" [{names}] "float amount" {amount}"#)
        }
        Matter::Bent([u, v], matter) => {
            let (textures, words) = kind(matter, name);
            let both = u + v;
            writeln!(
                before,
                r#"{textures} Texture "height{name}" "float" "bilerp" "float v00" 0 "float v10" {u}
                   "float v01" {v} "float v11" {both}"#
            )
            .unwrap();
            format!(r#"{words} "texture displacement" "height{name}""#)
        }
    };
    (before, words)
}

impl Lamp {
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
    /// The part of the scene file after WorldBegin.
    pub fn text(&self) -> String {
        let mut text = self.lights();
        for (name, shape) in self.shapes.iter().enumerate() {
            text += &shape.text(name);
        }
        text
    }

    /// The lights that are no shapes; a picture of the sky stands in sky.pfm.
    pub fn lights(&self) -> String {
        let mut text = String::new();
        for lamp in &self.lamps {
            writeln!(text, "{}", lamp.text()).unwrap();
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

    /// The picture of the sky as a PFM file, whose rows begin at the bottom.
    pub fn pfm(&self) -> Option<Vec<u8>> {
        let picture = self.picture.as_ref()?;
        let mut file = format!("PF\n{} {}\n-1.0\n", picture[0].len(), picture.len()).into_bytes();
        for value in picture.iter().rev().flatten().flatten() {
            file.extend((*value as f32).to_le_bytes());
        }
        Some(file)
    }
}
