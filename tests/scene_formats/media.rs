//! Media in scene files: errors, warnings, the plan's switch, and replays.

use crate::support::{folder, mean, picture, write};
use petzval_image::Picture;
use petzval_render::film::SampleId;
use petzval_render::job::Job;
use petzval_render::plan::Effect;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{Backend, replay};
use petzval_scene_formats::pbrt;

const BALL: &str = "Material \"interface\" Translate 0 0 4 Shape \"sphere\"";
const FOG: &str = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"";

/// Returns a scene file with directives before the world, and in it.
fn text(before: &str, world: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 12 \"integer yresolution\" 12
         Sampler \"independent\" \"integer pixelsamples\" 4\n{before}
         Camera \"perspective\" \"float fov\" 40
         WorldBegin LightSource \"infinite\" \"rgb L\" [ 1 0.8 0.6 ]
         LightSource \"point\" \"point3 from\" [ 3 3 0 ]\n{world}"
    )
}

fn read(text: &str) -> Result<pbrt::Description, pbrt::SceneErrors> {
    let folder = folder();
    pbrt::read(&write(&folder, "scene.pbrt", text))
}

fn job(text: &str, changes: &Changes) -> Job {
    prepare(read(text).expect("a scene"), changes).expect("a job").job
}

fn bits(picture: &Picture) -> Vec<u32> {
    picture.pixels.iter().flatten().map(|value| value.to_bits()).collect()
}

#[test]
fn mistakes_have_a_location_and_a_remedy() {
    let grid = "MakeNamedMedium \"g\" \"string type\" \"uniformgrid\"";
    for (world, found) in [
        ("MakeNamedMedium \"fog\"".to_owned(), "a medium without \"string type\""),
        ("MakeNamedMedium \"fog\" \"string type\" \"foggy\"".to_owned(), "unknown MakeNamedMedium"),
        (format!("{FOG} MediumInterface \"fgo\" \"\""), "did you mean \"fog\"?"),
        (format!("{FOG} \"float g\" 2"), "an asymmetry \"g\" of 2"),
        (format!("{FOG} \"float scale\" -1"), "\"scale\" is -1"),
        (format!("{FOG} \"string preset\" \"Wholemilc\""), "did you mean \"Wholemilk\"?"),
        (format!("{FOG} \"float density\" 1"), "unknown parameter \"density\""),
        (grid.to_owned(), "a grid without \"float density\""),
        (format!("{grid} \"float density\" [1 2 3] \"integer nx\" 2"), "3 values for \"density\""),
        (format!("{grid} \"float density\" 1 \"point3 p1\" [1 1 0]"), "flat"),
        (
            format!("{grid} \"float density\" 1 \"float temperature\" 1 \"rgb Le\" [1 1 1]"),
            "\"Le\" and \"temperature\" together",
        ),
        ("MakeNamedMedium \"c\" \"string type\" \"rgbgrid\"".to_owned(), "\"rgb sigma_a\""),
        ("MakeNamedMedium \"c\" \"string type\" \"nanovdb\"".to_owned(), "\"string filename\""),
        (
            "MakeNamedMedium \"c\" \"string type\" \"nanovdb\" \"string filename\" \"a.nvdb\""
                .to_owned(),
            "a.nvdb: cannot read it",
        ),
        ("Material \"subsurface\" \"rgb sigma_a\" [1 1 1]".to_owned(), "without \"sigma_s\""),
        ("Material \"subsurface\" \"string name\" \"Skin3\"".to_owned(), "did you mean \"Skin1\"?"),
    ] {
        let fault = read(&text("", &world)).expect_err(&world).to_string();
        assert!(fault.contains(found), "{world}: {fault}, not {found}");
        assert!(fault.contains("scene.pbrt:7:"), "{world}: {fault}");
    }
}

#[test]
fn the_integrator_path_leaves_media_out_with_a_warning() {
    let world = format!("{FOG} MediumInterface \"fog\" \"\" {BALL}");
    let with = |integrator: &str| {
        let text = text(&format!("Integrator \"{integrator}\""), &world);
        read(&text).expect("a scene")
    };
    let description = with("path");
    assert!(!description.scene.has_media());
    let [warning] = &description.warnings[..] else { panic!("{:?}", description.warnings) };
    assert!(warning.message.contains("volpath"), "{}", warning.message);
    let description = with("volpath");
    assert!(description.scene.has_media() && description.warnings.is_empty());
    // A medium that nothing refers to costs nothing.
    let unused = text("Integrator \"volpath\"", &format!("{FOG} {BALL}"));
    let description = read(&unused).expect("a scene");
    assert!(!description.scene.has_media());
}

#[test]
fn without_the_effect_light_passes_as_in_a_scene_without_media() {
    let inside = text("", &format!("{FOG} MediumInterface \"fog\" \"\" {BALL}"));
    let without = job(&text("", ""), &Changes::default());
    let effects = "-media".parse().expect("a list");
    let off = job(&inside, &Changes { effects, ..Changes::default() });
    let on = job(&inside, &Changes::default());
    assert!(on.plan.has(Effect::Media) && !off.plan.has(Effect::Media));
    let [without, off, on] = [without, off, on].map(|job| bits(&picture(&job, Backend::Simd, 1)));
    assert_eq!(without, off);
    assert_ne!(off, on);
}

#[test]
fn replays_in_media_have_the_bits_of_the_picture() {
    let grid = "MakeNamedMedium \"fog\" \"string type\" \"uniformgrid\" \"float density\" [1 2 3 4]
        \"integer nx\" 2 \"integer ny\" 2 \"point3 p0\" [-1 -1 3] \"point3 p1\" [1 1 5]";
    let ball = |medium: &str| format!("{medium} MediumInterface \"fog\" \"\" {BALL}");
    let skin = "Material \"subsurface\" \"float scale\" 1 Translate 0 0 4 Shape \"sphere\"";
    for world in [ball(FOG), ball(grid), skin.to_owned()] {
        let mut job = job(&text("", &world), &Changes::default());
        job.samples = 0..1;
        let pixels = picture(&job, Backend::Simd, 1).pixels;
        let mut collisions = 0;
        for (i, pixel) in (0u32..).zip(&pixels) {
            let name = SampleId::new([i % 12, i / 12], 0, job.seed);
            let found = replay(&job, Backend::Scalar, name).expect("a replay");
            let value = found.value.expect("a value");
            assert_eq!(value.map(|v| v as f32), *pixel, "{world}, pixel {i}");
            let last = found.steps.last().expect("a step");
            assert_eq!(last.radiance, found.radiance);
            collisions += found.steps.iter().filter(|step| step.collision.is_some()).count();
        }
        assert!(collisions > 0 || world.contains("subsurface"), "{world}");
    }
}

#[test]
fn a_texture_below_a_surface_is_a_warning_unless_it_is_constant() {
    let world = |texture: &str| {
        format!(
            "Texture \"t\" \"spectrum\" {texture} Material \"subsurface\" \"texture reflectance\" \"t\"
             Shape \"sphere\""
        )
    };
    let read = |world: &str| read(&text("", world)).expect("a scene");
    let constant = read(&world("\"constant\" \"rgb value\" [0.2 0.3 0.4]"));
    assert!(constant.scene.has_media() && constant.warnings.is_empty());
    let varies = read(&world("\"checkerboard\""));
    let [warning] = &varies.warnings[..] else { panic!("{:?}", varies.warnings) };
    assert!(warning.message.contains("a texture in a subsurface material"), "{}", warning.message);
    assert!(!varies.scene.has_media());
}

#[test]
fn coefficients_beyond_the_range_are_refused() {
    let fault = read(&text("", &format!("{FOG} \"float scale\" 1e38 \"rgb sigma_a\" [9 9 9]")));
    let fault = fault.expect_err("too large").to_string();
    assert!(fault.contains("expected at most 1e9"), "{fault}");
}

/// Shadow rays end just before the light, also those that have crossed interfaces on the way.
#[test]
fn a_clear_medium_between_a_light_and_a_floor_takes_no_light() {
    let scene = |inside: &str| {
        format!(
            "Film \"rgb\" \"integer xresolution\" 32 \"integer yresolution\" 32
             Sampler \"independent\" \"integer pixelsamples\" 16
             Integrator \"volpath\" \"integer maxdepth\" 1
             LookAt 0 -3.4 1.2  0 0 0.3  0 0 1 Camera \"perspective\" \"float fov\" 40
             WorldBegin
             AttributeBegin AreaLightSource \"diffuse\" Shape \"bilinearmesh\" \"point3 P\"
             [-0.6 -0.6 2.48  -0.6 0.6 2.48  0.6 -0.6 2.48  0.6 0.6 2.48] AttributeEnd
             Shape \"bilinearmesh\" \"point3 P\" [-2 -2 0  2 -2 0  -2 2 0  2 2 0]
             {inside}"
        )
    };
    let sheets: String = [0.7, 1.1, 1.4, 1.9]
        .map(|z| {
            format!("Shape \"bilinearmesh\" \"point3 P\" [-3 -3 {z} 3 -3 {z} -3 3 {z} 3 3 {z}]\n")
        })
        .concat();
    let clear = format!(
        "{FOG} \"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [0 0 0] MediumInterface \"fog\" \"\"
         Material \"interface\" {sheets}"
    );
    let [without, with] = ["", &clear].map(|inside| {
        let job = job(&scene(inside), &Changes::default());
        assert_eq!(job.scene.has_media(), !inside.is_empty());
        mean(&picture(&job, Backend::Simd, 1))[0]
    });
    assert!(without > 0.01 && (with / without - 1.0).abs() < 1e-4, "{with}, not {without}");
}

/// Emission and absorption of a homogeneous medium are integrated, not sampled.
#[test]
fn a_glowing_ball_has_the_radiance_of_its_chord() {
    let scene = |depth: u32| {
        format!(
            "Film \"rgb\" \"integer xresolution\" 1 \"integer yresolution\" 1
             PixelFilter \"box\" \"float xradius\" 0.5 \"float yradius\" 0.5
             Integrator \"volpath\" \"integer maxdepth\" {depth}
             Camera \"perspective\" \"float fov\" 0.1 WorldBegin
             {FOG} \"rgb Le\" [1 2 3] \"rgb sigma_a\" [0.7 0.001 4] \"rgb sigma_s\" [0 0 0]
             MediumInterface \"fog\" \"\" {BALL}"
        )
    };
    let [pixel] = picture(&job(&scene(1), &Changes::default()), Backend::Simd, 1).pixels[..] else {
        panic!("one pixel")
    };
    for (found, (light, absorbs)) in pixel.into_iter().zip([(1.0, 0.7), (2.0, 0.001), (3.0, 4.0)]) {
        let expected = light * -(-2.0f64 * absorbs).exp_m1();
        assert!((f64::from(found) / expected - 1.0).abs() < 1e-4, "{found}, not {expected}");
    }
    // As in pbrt-v4, paths that may not scatter see no glow.
    let dark = picture(&job(&scene(0), &Changes::default()), Backend::Simd, 1);
    assert_eq!(dark.pixels, [[0.0; 3]]);
}
