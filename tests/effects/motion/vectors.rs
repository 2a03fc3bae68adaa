//! Motion vectors against the images of a small disc when the shutter opens and when it closes.

use petzval_image::ImageLayer;
use petzval_render::aov::Aov;
use petzval_render::plan::EffectSelection;
use petzval_render::prepare::Changes;
use petzval_render::{RenderOptions, render};
use petzval_scene::shutter::ShutterSettings;

use super::world::job;
use crate::support::root;

const SIZE: [usize; 2] = [240, 160];

/// Returns a scene with a disc. `camera` are the directives before the camera.
fn scene(lens: &str, diagonal: f64, camera: &str, world: &str) -> String {
    let camera_text = match lens {
        "pinhole" => "Camera \"perspective\" \"float fov\" 40".to_owned(),
        "sphere" => "Camera \"spherical\"".to_owned(),
        "meridians" => "Camera \"spherical\" \"string mapping\" \"equirectangular\"".to_owned(),
        "parallel" => "Camera \"orthographic\"".to_owned(),
        lens => format!(
            "Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 2 \
             \"float focusdistance\" 2",
            root().join("lenses").join(lens).display()
        ),
    };
    let [width, height] = SIZE;
    format!(
        "Film \"rgb\" \"integer xresolution\" {width} \"integer yresolution\" {height}\n\
         \"float diagonal\" {diagonal} PixelFilter \"box\" Sampler \"zsobol\" \"integer pixelsamples\" 32\n\
         Integrator \"path\" \"integer maxdepth\" 1\n\
         {camera}\n{camera_text} \"float shutteropen\" 0.25 \"float shutterclose\" 0.75\n\
         WorldBegin LightSource \"infinite\" \"rgb L\" [1 1 1]\n{world}"
    )
}

/// Returns the layers of motion and of coverage.
fn layers(text: &str, changes: Changes) -> Vec<ImageLayer> {
    let changes = Changes { layers: vec![Aov::Motion, Aov::Cryptomatte], ..changes };
    let job = job(text, &changes);
    let options = RenderOptions { threads: 2, ..RenderOptions::default() };
    render(&job, options).expect("a picture").layers(&job)
}

/// Returns the sum of a function over the pixels that the disc covers, weighted by its coverage, over that of the
/// weights. The disc is the only object.
fn mean_over_disc(layers: &[ImageLayer], value: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
    let matte = layers.iter().find(|layer| layer.name == "CryptoObject00").expect("a matte");
    let coverage = &matte.channels[1].1;
    let mut sums = [0.0; 3];
    for (pixel, &share) in coverage.iter().enumerate() {
        let [x, y] = value(pixel);
        let share = f64::from(share);
        sums = [sums[0] + share, sums[1] + share * x, sums[2] + share * y];
    }
    assert!(sums[0] > 5.0, "the disc covers {} pixels", sums[0]);
    [sums[1] / sums[0], sums[2] / sums[0]]
}

/// Checks the mean motion of a disc against the way of its image.
fn check(what: &str, text: &str) {
    let centre = |when: f64| {
        let settings = ShutterSettings {
            open: Some(when - 1e-6),
            time: Some(2e-6),
            ..ShutterSettings::default()
        };
        let layers = layers(text, Changes { shutter: Some(settings), ..Changes::default() });
        mean_over_disc(&layers, |pixel| [pixel % SIZE[0], pixel / SIZE[0]].map(|at| at as f64))
    };
    let (from, to) = (centre(0.25), centre(0.75));
    let expected = [0, 1].map(|i| to[i] - from[i]);
    let way = expected[0].hypot(expected[1]);
    assert!(way > 10.0, "{what}: the image moves by {expected:?}");
    for effects in ["+motion", "-motion"] {
        let effects: EffectSelection = effects.parse().expect("a selection");
        let layers = layers(text, Changes { effects, ..Changes::default() });
        let motion = layers.iter().find(|layer| layer.name == "motion").expect("a layer");
        let [x, y] = [0, 1].map(|i| &motion.channels[i].1);
        let found = mean_over_disc(&layers, |pixel| [x, y].map(|values| f64::from(values[pixel])));
        let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
        assert!(off < 0.005 * way, "{what}: {found:?}, expected {expected:?}");
    }
}

fn disc(from: [f64; 3], to: [f64; 3], radius: f64) -> String {
    let [a, b, c] = from;
    let [d, e, f] = to;
    format!(
        "AttributeBegin ActiveTransform StartTime Translate {a} {b} {c}\n\
         ActiveTransform EndTime Translate {d} {e} {f} ActiveTransform All\n\
         Shape \"disk\" \"float radius\" {radius} AttributeEnd\n"
    )
}

#[test]
fn vectors_of_a_moving_disc_are_the_way_of_its_image() {
    let cases = [
        ("pinhole", 43.0, [-0.5, 0.1, 2.0], [0.1, 0.4, 2.0], 0.06),
        ("dgauss.50mm.dat", 43.0, [-0.5, 0.1, 2.0], [0.1, 0.3, 2.0], 0.05),
        ("anamorphic.toml", 43.0, [0.5, 0.1, 2.0], [-0.1, -0.2, 2.0], 0.05),
        ("fisheye.6mm.toml", 30.0, [1.6, 0.3, 0.6], [1.0, -0.6, 1.2], 0.08),
        // So near that the entrance pupil moves on with the angle.
        ("fisheye.6mm.toml", 30.0, [0.11, 0.02, 0.16], [0.06, -0.05, 0.19], 0.01),
        ("sphere", 43.0, [1.0, 0.2, 0.3], [0.6, 0.4, 1.0], 0.1),
    ];
    for (lens, diagonal, from, to, radius) in cases {
        check(lens, &scene(lens, diagonal, "", &disc(from, to, radius)));
    }
}

#[test]
fn vectors_of_a_resting_disc_before_a_turning_camera_are_the_way_of_its_image() {
    let turning = "ActiveTransform EndTime Rotate 9 0.3 1 0.4 ActiveTransform All";
    let resting = "Translate 0.1 0.1 2 Shape \"disk\" \"float radius\" 0.05";
    for lens in ["dgauss.50mm.dat", "wide.22mm.dat"] {
        check(lens, &scene(lens, 43.0, turning, resting));
    }
}

#[test]
fn the_sky_moves_with_a_turning_camera_and_rests_with_a_resting_one() {
    // The whole motion turns the camera by 8 degrees about the vertical, the exposure by 4.
    let text = |camera: &str| scene("pinhole", 43.0, camera, "");
    let turning = "ActiveTransform EndTime Rotate 8 0 1 0 ActiveTransform All";
    let motion = |text: &str| layers(text, Changes::default()).swap_remove(0);
    let turned = motion(&text(turning));
    // The shorter side of the picture sees 40 degrees.
    let focal_length = 80.0 / 20.0_f64.to_radians().tan();
    let expected = 2.0 * focal_length * 2.0_f64.to_radians().tan();
    let middle = SIZE[0] * SIZE[1] / 2 + SIZE[0] / 2;
    let [x, y] = [0, 1].map(|i| turned.channels[i].1[middle]);
    assert!((f64::from(x).abs() / expected - 1.0).abs() < 2e-3, "{x}, expected {expected}");
    assert!(y.abs() < 0.05, "{y}");
    let resting = motion(&text(""));
    assert!(resting.channels.iter().all(|(_, values)| values.iter().all(|&v| v == 0.0)));
}

#[test]
fn a_picture_of_all_directions_continues_beyond_its_edges() {
    // The left edge is at +x.
    let world =
        disc([2.0, 0.0, 0.1], [2.0, 0.0, -0.1], 0.3).replace("Shape \"disk\"", "Shape \"sphere\"");
    let layers = layers(&scene("meridians", 43.0, "", &world), Changes::default());
    let motion = layers.iter().find(|layer| layer.name == "motion").expect("a layer");
    let [x, y] = [0, 1].map(|i| &motion.channels[i].1);
    let largest = x.iter().map(|v| v.abs()).fold(0.0, f32::max);
    // 0.1 m at 1.7 to 2 m, in 240 pixels for the whole circle.
    assert!((1.8..2.4).contains(&largest), "{largest}");
    assert!(y.iter().all(|v| v.abs() < 0.3));
}

#[test]
fn parallel_rays_see_no_motion_of_the_sky() {
    let turning = "ActiveTransform EndTime Rotate 8 0 1 0 ActiveTransform All";
    let sky = layers(&scene("parallel", 43.0, turning, ""), Changes::default());
    assert!(sky[0].channels.iter().all(|(_, values)| values.iter().all(|&v| v == 0.0)));
    check("parallel", &scene("parallel", 43.0, "", &disc([-0.5, 0.1, 2.0], [0.1, 0.4, 2.0], 0.2)));
}
