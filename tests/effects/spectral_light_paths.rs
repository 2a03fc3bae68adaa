//! Light paths by wavelength: lamps, caustics and ghosts have the colours that camera paths find.

use crate::support::workspace::Workspace;
use crate::support::{folder, in_parallel, mean, mean_and_error, picture, root, write};
use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;

/// Prepares a scene of a text, with light paths to all that they can find.
fn job(text: &str, samples: u32, effects: &str) -> Job {
    let folder = folder();
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene of a test");
    let changes = Changes {
        samples: Some(samples),
        effects: effects.parse().expect("effects"),
        light_paths: Some(true),
        ..Changes::default()
    };
    prepare(description, &changes).expect("a job").job
}

/// A lamp of narrow lines that fills a part of the film, through a lens, on the film of a camera whose
/// filters tell its lines apart.
fn lamp(lens: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 24 \"integer yresolution\" 16
             \"string sensor\" \"nikon_d850\"
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float focusdistance\" 2
         WorldBegin
         AreaLightSource \"diffuse\" \"spectrum L\" \"stdillum-F11\"
         AttributeBegin Translate 0.1 0.05 2 Shape \"sphere\" \"float radius\" 0.15 AttributeEnd",
        root().join("lenses").join(lens).display()
    )
}

/// A green table, lit only by a lamp in a black tube, whose hole a ball of glass covers.
fn table(glass: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 24 \"integer yresolution\" 24 \"float diagonal\" 10
         LookAt 0 0.4 -0.6  0 0 0  0 1 0
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float focusdistance\" 0.72
         WorldBegin
         AttributeBegin
             AreaLightSource \"diffuse\" \"spectrum L\" \"stdillum-F2\"
             Translate 0 0.5 0 Rotate 90 1 0 0 Shape \"disk\" \"float radius\" 0.1
         AttributeEnd
         Material \"diffuse\" \"rgb reflectance\" [0 0 0]
         AttributeBegin Rotate 90 1 0 0
             Shape \"cylinder\" \"float radius\" 0.1 \"float zmin\" -0.51 \"float zmax\" -0.16
         AttributeEnd
         AttributeBegin Translate 0 0.16 0 Rotate 90 1 0 0
             Shape \"disk\" \"float radius\" 0.1 \"float innerradius\" 0.02
         AttributeEnd
         Material \"diffuse\"
             \"spectrum reflectance\" [400 0.04 480 0.08 510 0.5 550 0.55 580 0.2 700 0.1]
         Shape \"bilinearmesh\" \"point3 P\" [-0.2 0 -0.2  0.2 0 -0.2  -0.2 0 0.2  0.2 0 0.2]
         Material \"dielectric\" {glass}
         AttributeBegin Translate 0 0.1 0 Shape \"sphere\" \"float radius\" 0.05 AttributeEnd",
        root().join("lenses/dgauss.50mm.dat").display()
    )
}

/// Returns the mean of each channel over a picture and its standard error, by eight seeds.
fn light(first: &Job) -> [[f64; 2]; 3] {
    let seeds: Vec<u32> = (0..8).collect();
    let of_seed = |&seed: &u32| mean(&picture(&Job { seed, ..first.clone() }, Backend::Simd, 1));
    let means = in_parallel(&seeds, of_seed);
    [0, 1, 2].map(|c| mean_and_error(&means.iter().map(|m| m[c]).collect::<Vec<_>>()))
}

/// Checks that two kinds of paths find the same light: within five standard errors and 0.2 % of the
/// brightest channel, of which the errors are at most a part.
fn assert_same_light(found: [[f64; 2]; 3], expected: [[f64; 2]; 3], part: f64, what: &str) {
    println!("{what}: {found:?}, {expected:?}");
    let brightest = expected.iter().fold(0.0f64, |a, b| a.max(b[0]));
    for ([found, error], [expected, other]) in found.into_iter().zip(expected) {
        let error = error.hypot(other);
        assert!(error < part * brightest, "{what}: {found} +- {error} is too noisy");
        let off = (found - expected).abs();
        assert!(off < 5.0 * error + 2e-3 * brightest, "{what}: {found}, not {expected} +- {error}");
    }
}

/// Checks that red, green and blue alone would show other colours, by a part of the brightest channel.
fn assert_other_light(found: [f64; 3], expected: [[f64; 2]; 3], part: f64) {
    let brightest = expected.iter().fold(0.0f64, |a, b| a.max(b[0]));
    let off = found.into_iter().zip(expected).map(|(a, [b, _])| (a - b).abs() / brightest);
    assert!(off.fold(0.0, f64::max) > part, "{found:?} and {expected:?}");
}

#[test]
fn lamps_have_the_light_of_camera_paths() {
    let scene = lamp("triplet.toml");
    for dispersion in ["-dispersion", "+dispersion"] {
        let effects = |spectra| format!("{spectra},{dispersion},-ghosts,-diffraction,-fresnel");
        let mut by_light = job(&scene, 2048, &effects("+spectra"));
        by_light.caustics = None;
        let mut by_camera = Job { samples: 0..128, ..by_light.clone() };
        by_camera.lamp_images = None;
        by_light.lamp_images.as_mut().expect("a lamp in view").make_exclusive();
        let [found, expected] = [&by_light, &by_camera].map(light);
        assert_same_light(found, expected, 5e-3, dispersion);
        let in_rgb = job(&scene, 64, &effects("-spectra"));
        assert_other_light(mean(&picture(&in_rgb, Backend::Simd, 1)), expected, 0.05);
    }
}

#[test]
fn caustics_have_the_light_of_camera_paths() {
    // Glass of one index, and glass that ends two of three wavelengths.
    for (glass, noise) in [("\"float eta\" 1.5", 1.5e-2), ("\"spectrum eta\" \"glass-SF11\"", 3e-2)]
    {
        let effects = |spectra| format!("{spectra},-dispersion,-ghosts,-diffraction");
        let mut by_light = job(&table(glass), 2048, &effects("+spectra"));
        by_light.lamp_images = None;
        let mut by_camera = Job { samples: 0..512, ..by_light.clone() };
        by_camera.caustics = None;
        assert!(by_light.caustics.is_some(), "a caustic in view");
        let [found, expected] = [&by_light, &by_camera].map(light);
        assert_same_light(found, expected, noise, glass);
        let in_rgb = job(&table(glass), 256, &effects("-spectra"));
        assert_other_light(mean(&picture(&in_rgb, Backend::Simd, 1)), expected, 0.05);
    }
}

#[test]
fn pictures_are_equal_for_all_backends_threads_and_shards() {
    let glass = table("\"spectrum eta\" \"glass-SF11\"");
    for (scene, dispersion) in [(lamp("triplet.toml"), "+"), (glass, "-")] {
        let effects = format!("+spectra,+ghosts,{dispersion}dispersion,-diffraction");
        let job = job(&scene, 70, &effects);
        assert!(!job.light_strategies().is_empty(), "light paths");
        let whole = picture(&job, Backend::Simd, 1);
        assert_eq!(picture(&job, Backend::Simd, 2).pixels, whole.pixels, "two threads");
        assert_eq!(picture(&job, Backend::Scalar, 1).pixels, whole.pixels, "one lane");
        let workspace = Workspace::new();
        std::fs::write(workspace.path("scene.pbrt"), &scene).expect("a scene");
        let options = format!("--spp 70 --light-paths on --effects {effects}");
        workspace.merges_to_the_whole(&format!("render scene.pbrt {options}"));
    }
}
