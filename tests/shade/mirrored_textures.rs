//! Texture filtering in mirrors and through glass: as sharp as plain squares without a texture.

use crate::support::{folder, picture, write};
use petzval_image::Picture;
use petzval_render::Backend;
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;

/// Number of squares along a side of the board.
const SQUARES: u32 = 12;
/// Reflectances of the squares.
const REFLECTANCES: [f64; 2] = [0.1, 0.8];
/// Texels along a side of a square.
const TEXELS: u32 = 32;
/// Side of the rendered picture, pixels.
const SIDE: u32 = 64;

/// Returns a board from (-1, -1, 0) to (1, 1, 0), of quads of their own reflectance or with a texture.
fn board(texture: Option<&str>) -> String {
    let diffuse = |reflectance: &str| format!("Material \"diffuse\" {reflectance}\n");
    let quad = |[x, y]: [f64; 2], side: f64| {
        let (right, top) = (x + side, y + side);
        format!(
            "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
                \"point3 P\" [{x} {y} 0  {right} {y} 0  {right} {top} 0  {x} {top} 0]
                \"point2 uv\" [0 0 1 0 1 1 0 1]\n"
        )
    };
    if let Some(texture) = texture {
        return texture.to_owned()
            + &diffuse("\"texture reflectance\" \"t\"")
            + &quad([-1.0; 2], 2.0);
    }
    let side = 2.0 / f64::from(SQUARES);
    let mut text = String::new();
    for i in 0..SQUARES {
        for j in 0..SQUARES {
            let r = REFLECTANCES[((i + j) % 2) as usize];
            text += &diffuse(&format!("\"rgb reflectance\" [{r} {r} {r}]"));
            text += &quad([i, j].map(|k| -1.0 + side * f64::from(k)), side);
        }
    }
    text
}

/// Returns lights on both sides of the board.
fn lights() -> String {
    let places = [[2.5, 0.5], [-2.5, 0.5], [2.5, -0.5], [-2.5, -0.5]];
    let light = |[x, z]: [f64; 2]| {
        format!("LightSource \"point\" \"point3 from\" [{x} 0 {z}] \"rgb I\" [9 9 9]\n")
    };
    places.map(light).concat()
}

/// Returns the board as a PNG with linear codes of the reflectances.
fn board_picture() -> Vec<u8> {
    let side = SQUARES * TEXELS;
    let code = |x: u32, y: u32| {
        let odd = (x / TEXELS + y / TEXELS + SQUARES - 1) % 2;
        (REFLECTANCES[odd as usize] * 255.0).round() as u8
    };
    let picture = image::GrayImage::from_fn(side, side, |x, y| image::Luma([code(x, y)]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).expect("a picture in memory");
    bytes.into_inner()
}

/// Renders a board in a world, from a camera at the origin that looks along +z.
fn render_board(world: &str, texture: Option<&str>) -> Picture {
    let folder = folder();
    write(&folder, "board.png", board_picture());
    let text = format!(
        r#"Film "rgb" "integer xresolution" {SIDE} "integer yresolution" {SIDE}
           PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
           Sampler "independent" "integer pixelsamples" 64
           Integrator "path" "integer maxdepth" 6
           Camera "perspective" "float fov" 16
           WorldBegin
           {}"#,
        // Only the board can occlude the lights, so the picture has no noise of shadows.
        world.replace("BOARD", &(lights() + &board(texture)))
    );
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene");
    picture(&prepare(description, &Changes::default()).expect("a job").job, Backend::Simd, 1)
}

/// Returns the root mean square of green, after subtraction of another picture or of the mean.
fn rms(picture: &Picture, other: Option<&Picture>) -> f64 {
    let green =
        |picture: &Picture| picture.pixels.iter().map(|p| f64::from(p[1])).collect::<Vec<_>>();
    let pixels = green(picture);
    let n = pixels.len() as f64;
    let mean = pixels.iter().sum::<f64>() / n;
    let other = other.map_or_else(|| vec![mean; pixels.len()], green);
    (pixels.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / n).sqrt()
}

/// Asserts that every texture gives the picture of the board of squares.
fn assert_sharp(name: &str, world: &str) {
    let truth = render_board(world, None);
    let contrast = rms(&truth, None);
    println!("{name}: contrast {contrast:.3}");
    assert!(contrast > 0.03, "{name}: the squares have a contrast of {contrast}");
    let checks = format!(
        "Texture \"t\" \"spectrum\" \"checkerboard\" \"float uscale\" {SQUARES} \"float vscale\" {SQUARES}
             \"rgb tex1\" [{a} {a} {a}] \"rgb tex2\" [{b} {b} {b}]\n",
        a = REFLECTANCES[0],
        b = REFLECTANCES[1]
    );
    let image = |filter: &str| {
        format!(
            "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"board.png\"
                 \"string encoding\" \"linear\" \"string filter\" \"{filter}\"\n"
        )
    };
    let textures = ["point", "bilinear", "trilinear", "ewa"].map(|filter| (filter, image(filter)));
    for (texture, text) in textures.into_iter().chain([("checkerboard", checks)]) {
        let off = rms(&render_board(world, Some(&text)), Some(&truth)) / contrast;
        println!("{name}, {texture}: off by {:.1} % of the contrast", 100.0 * off);
        // A footprint is an eighth of a pixel wide, a square five pixels.
        assert!(off < 0.08, "{name}, {texture}: off by {off} of the contrast");
    }
}

#[test]
fn a_texture_in_direct_view_is_sharp() {
    assert_sharp("direct", "Translate 0 0 7.4641 BOARD");
}

#[test]
fn a_texture_in_a_plane_mirror_is_sharp() {
    // The mirror deflects the view by 150 degrees. The board is beside the camera, which lies in its
    // plane.
    assert_sharp(
        "mirror",
        r#"AttributeBegin
               Translate 0 0 4   Rotate 15 0 1 0
               Material "conductor" "float roughness" 0
               Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
                   "point3 P" [-3 -3 0  3 -3 0  3 3 0  -3 3 0]
           AttributeEnd
           Translate -1.73205 0 1   Rotate 30 0 1 0   BOARD"#,
    );
}

#[test]
fn a_texture_in_a_concave_mirror_is_sharp() {
    assert_sharp(
        "hollow mirror",
        r#"AttributeBegin
               Translate 2 0 -8
               Material "conductor" "float roughness" 0
               Shape "sphere" "float radius" 12 "float zmin" 0
           AttributeEnd
           Translate 1.17 0 0.43   Rotate -19 0 1 0   Scale 0.4 0.4 0.4   BOARD"#,
    );
}

#[test]
fn a_texture_through_a_pane_and_a_ball_of_glass_is_sharp() {
    assert_sharp(
        "pane",
        r#"AttributeBegin
               Translate 0 0 4   Rotate 50 0 1 0
               Material "thindielectric"
               Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
                   "point3 P" [-3 -3 0  3 -3 0  3 3 0  -3 3 0]
           AttributeEnd
           Translate 0 0 7.5   BOARD"#,
    );
    assert_sharp(
        "ball",
        r#"AttributeBegin
               Translate 0 0 8
               Material "dielectric" "float eta" 1.5
               Shape "sphere" "float radius" 1.2
           AttributeEnd
           Translate 0 0 12   Scale 0.7 0.7 0.7   BOARD"#,
    );
}
