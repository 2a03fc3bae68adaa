//! Spectral films: the radiance in buckets of wavelength beside the colours, and the files that hold it.

use crate::support::workspace::{Workspace, finish, signal};
use crate::support::{folder, petzval, write};
use exr::prelude::{AttributeValue, read_all_flat_layers_from_file};
use petzval_image::{ImageLayer, Picture, SPECTRAL_LAYER};
use petzval_render::film::SampleId;
use petzval_render::job::{Job, StopCriteria};
use petzval_render::plan::{DecidedBy, Effect};
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{Backend, RenderOptions, RenderOutput, render, replay};
use petzval_scene_formats::pbrt;
use petzval_spectrum::{
    Buckets, Spectrum, colour_matching, d65, luminosity_integral, named_spectrum, srgb_from_xyz,
};

/// A wall of a material under a sky, on a spectral film.
fn wall(buckets: &str, sky: &str, material: &str) -> String {
    format!(
        "Film \"spectral\" {buckets} \"integer xresolution\" 8 \"integer yresolution\" 8
         Integrator \"path\" \"integer maxdepth\" 2 Camera \"perspective\" \"float fov\" 4
         WorldBegin LightSource \"infinite\" {sky} Material {material}
         Shape \"bilinearmesh\" \"point3 P\" [-1 -1 5  1 -1 5  -1 1 5  1 1 5]"
    )
}

fn job(text: &str, changes: Changes) -> Job {
    let folder = folder();
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene of a test");
    prepare(description, &Changes { holds_spectra: true, ..changes }).expect("a job").job
}

fn taken(job: &Job, threads: usize, backend: Backend) -> RenderOutput {
    let options = RenderOptions { threads, backend, ..RenderOptions::default() };
    render(job, options).expect("a render that is not stopped")
}

/// Renders a scene with 64 samples, which take each set of wavelengths once.
fn rendered(text: &str) -> (Job, RenderOutput) {
    let job = job(text, Changes { samples: Some(64), ..Changes::default() });
    let output = taken(&job, 1, Backend::Simd);
    (job, output)
}

/// Returns the layer of spectra of a render.
fn spectrum(job: &Job, output: &RenderOutput) -> ImageLayer {
    let layers = output.layers(job).into_iter();
    layers.into_iter().find(|layer| layer.name == SPECTRAL_LAYER).expect("a spectral layer")
}

/// Returns the mean of each bucket over the picture.
fn means(job: &Job, output: &RenderOutput) -> Vec<f64> {
    let mean =
        |values: &Vec<f32>| values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
    spectrum(job, output).channels.iter().map(|(_, values)| mean(values)).collect()
}

/// Returns the mean of a quantity over each bucket, by steps of 0.1 nm or less.
fn integrals(buckets: &Buckets, value: impl Fn(f64) -> f64) -> Vec<f64> {
    let steps = (10.0 * buckets.width()).ceil();
    let mean = |middle: f64| {
        let nm = |i: u32| middle + buckets.width() * ((f64::from(i) + 0.5) / steps - 0.5);
        (0..steps as u32).map(|i| value(nm(i))).sum::<f64>() / steps
    };
    buckets.middles().into_iter().map(mean).collect()
}

/// Checks means of buckets, within a share of the largest.
fn assert_near(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let most = expected.iter().copied().fold(0.0, f64::max);
    for (found, wanted) in found.iter().zip(expected) {
        let off = (found - wanted).abs() / most;
        assert!(off < tolerance, "{what}: {found}, not {wanted}, of {expected:?}");
    }
}

/// Returns the linear sRGB of the spectrum of a pixel.
fn colour(buckets: &Buckets, spectrum: &ImageLayer, pixel: usize) -> [f64; 3] {
    let mut xyz = [0.0; 3];
    for (nm, (_, values)) in buckets.middles().into_iter().zip(&spectrum.channels) {
        let light = f64::from(values[pixel]) * buckets.width() / luminosity_integral();
        xyz = [0, 1, 2].map(|c| xyz[c] + light * colour_matching(nm)[c]);
    }
    srgb_from_xyz(xyz)
}

/// Checks that the colours of a picture are those of its spectra, within a share of the largest channel.
fn assert_colours_of_spectra(job: &Job, output: &RenderOutput, tolerance: f64) {
    let buckets = *job.buckets().expect("a spectral film").buckets();
    let (picture, spectrum) = (output.picture(job), spectrum(job, output));
    for (pixel, rgb) in picture.pixels.iter().enumerate() {
        let found = colour(&buckets, &spectrum, pixel);
        let most = rgb.iter().fold(0.0f32, |a, &b| a.max(b.abs()));
        for (found, &wanted) in found.into_iter().zip(rgb) {
            let off = (found - f64::from(wanted)).abs();
            assert!(off <= tolerance * f64::from(most), "pixel {pixel}: {found}, not {wanted}");
        }
    }
}

#[test]
fn a_grey_wall_in_daylight_has_the_spectrum_of_daylight() {
    let grey = "\"diffuse\" \"rgb reflectance\" [0.4 0.4 0.4]";
    let day = d65();
    let luminance = day.to_xyz()[1];
    for asked in [
        "",
        "\"integer nbuckets\" 31 \"float lambdamin\" 395 \"float lambdamax\" 705",
        "\"integer nbuckets\" 192",
        "\"integer nbuckets\" 1 \"float lambdamin\" 530 \"float lambdamax\" 534.5",
    ] {
        let (job, output) = rendered(&wall(asked, "\"rgb L\" [1 1 1]", grey));
        let spectra = job.plan.effects.iter().find(|one| one.effect == Effect::Spectra);
        let spectra = spectra.expect("a decision");
        assert!(spectra.on && spectra.by == DecidedBy::Scene, "{spectra:?}");
        let buckets = job.buckets().expect("a spectral film").buckets();
        let expected = integrals(buckets, |nm| 0.4 * day.at(nm) / luminance);
        assert_near(&means(&job, &output), &expected, 2e-3, asked);
    }
}

#[test]
fn a_pigment_under_a_lamp_has_the_spectrum_of_both() {
    let reflectance = Spectrum::samples(vec![
        [400.0, 0.04],
        [580.0, 0.05],
        [600.0, 0.3],
        [620.0, 0.7],
        [700.0, 0.8],
    ]);
    let reflectance = reflectance.expect("in order");
    let paint = "\"diffuse\" \"spectrum reflectance\" [400 0.04 580 0.05 600 0.3 620 0.7 700 0.8]";
    for name in ["stdillum-A", "stdillum-F2"] {
        let lamp = named_spectrum(name).expect("a known spectrum");
        let luminance = lamp.to_xyz()[1];
        let sky = format!("\"spectrum L\" \"{name}\"");
        let (job, output) = rendered(&wall("", &sky, paint));
        let buckets = job.buckets().expect("a spectral film").buckets();
        let expected = integrals(buckets, |nm| lamp.at(nm) / luminance * reflectance.at(nm));
        assert_near(&means(&job, &output), &expected, 0.02, name);
    }
}

/// A sky that a mirror shows, brighter than the limit of the film in a part of the samples.
const COLOURS: &str = "PixelFilter \"mitchell\" Integrator \"path\" \"integer maxdepth\" 4
     Camera \"perspective\" \"float fov\" 40 WorldBegin
     LightSource \"infinite\" \"spectrum L\" \"stdillum-F2\"
     LightSource \"point\" \"blackbody I\" 2500 \"float scale\" 30 \"point3 from\" [1 2 2]
     Material \"diffuse\" \"spectrum reflectance\" [400 0.04 580 0.05 600 0.3 620 0.7 700 0.8]
     Translate 0 0 5 Shape \"sphere\" \"float radius\" 1
     Material \"conductor\" \"spectrum eta\" \"metal-Cu-eta\" \"spectrum k\" \"metal-Cu-k\"
     Translate 1.6 0 0 Shape \"sphere\" \"float radius\" 1";

#[test]
fn the_colours_are_those_of_the_spectra() {
    let film = "Film \"spectral\" \"integer nbuckets\" 192 \"integer xresolution\" 72
                \"integer yresolution\" 16 \"float maxcomponentvalue\" 1.1 ";
    let (job, output) = rendered(&format!("{film}{COLOURS}"));
    assert_colours_of_spectra(&job, &output, 0.01);
    // The same with samples where they are needed.
    let stop_criteria = StopCriteria { noise: Some(0.05), time: None };
    let changes = Changes { samples: Some(256), stop_criteria, ..Changes::default() };
    let adaptive = self::job(&format!("{film}{COLOURS}"), changes);
    let output = taken(&adaptive, 2, Backend::Simd);
    let reached = output.convergence.expect("a noise");
    assert!(reached.min_spp < reached.max_spp, "{reached:?}");
    assert_colours_of_spectra(&adaptive, &output, 0.01);
}

#[test]
fn a_balanced_camera_changes_the_colours_and_no_spectrum() {
    let film = |more: &str| {
        format!(
            "Film \"spectral\" \"integer xresolution\" 12 \"integer yresolution\" 8 {more} {COLOURS}"
        )
    };
    let [plain, camera] = ["", "\"string sensor\" \"canon_eos_5d\" \"float whitebalance\" 4000"]
        .map(|more| rendered(&film(more)));
    assert_eq!(spectrum(&plain.0, &plain.1), spectrum(&camera.0, &camera.1));
    assert_ne!(plain.1.picture(&plain.0).pixels, camera.1.picture(&camera.0).pixels);
}

#[test]
fn neither_buckets_nor_threads_nor_lanes_change_a_bit() {
    let film = "Film \"rgb\" \"integer xresolution\" 40 \"integer yresolution\" 40 ";
    let text = format!("{film}{COLOURS}");
    let changes = |buckets: Option<u32>| Changes {
        samples: Some(9),
        effects: "+spectra".parse().expect("effects"),
        buckets: buckets.map(|count| Some(Buckets::new(count, [400.0, 700.0]).expect("buckets"))),
        ..Changes::default()
    };
    let plain = job(&text, changes(None));
    let spectral = job(&text, changes(Some(12)));
    let output = taken(&spectral, 1, Backend::Simd);
    let expected = taken(&plain, 1, Backend::Simd).picture(&plain);
    assert_eq!(output.picture(&spectral), expected);
    for (threads, backend) in [(3, Backend::Simd), (2, Backend::Scalar)] {
        let other = taken(&spectral, threads, backend);
        assert_eq!(spectrum(&spectral, &other), spectrum(&spectral, &output));
    }
    // A crop is that part of the whole.
    let crop = Some([[5, 7], [22, 31]]);
    let part = job(&text, Changes { crop, ..changes(Some(12)) });
    let cropped = spectrum(&part, &taken(&part, 2, Backend::Simd));
    let whole = spectrum(&spectral, &output);
    for ((_, part), (_, whole)) in cropped.channels.iter().zip(&whole.channels) {
        for (i, value) in part.iter().enumerate() {
            assert_eq!(value.to_bits(), whole[(7 + i / 17) * 40 + 5 + i % 17].to_bits());
        }
    }
}

/// Camera paths, lamp images, caustics and ghosts, whether the lens and the scene disperse or not.
#[test]
fn all_light_adds_to_colours_and_spectra_alike() {
    let workspace = Workspace::new();
    let scene = std::fs::read_to_string(workspace.path("scene.pbrt")).expect("a scene");
    let scene = scene.replace("\"rgb L\" [0.2 0.25 0.3]", "\"spectrum L\" \"stdillum-F11\"");
    let ball = "Translate 0.7 0 0 Shape \"sphere\" \"float radius\" 0.3";
    for (glass, effects, light_paths) in [
        ("glass-SF11", "+dispersion,-ghosts,-diffraction", false),
        ("glass-SF11", "+dispersion,+ghosts,-diffraction", true),
        ("", "-dispersion,+ghosts,-diffraction", true),
    ] {
        let glass = match glass {
            "" => format!("\nMaterial \"dielectric\" {ball}"),
            named => format!("\nMaterial \"dielectric\" \"spectrum eta\" \"{named}\" {ball}"),
        };
        std::fs::write(workspace.path("scene.pbrt"), format!("{scene}{glass}")).expect("a scene");
        let description = pbrt::read(&workspace.path("scene.pbrt")).expect("a scene");
        let changes = Changes {
            samples: Some(32),
            resolution: Some([36, 25]),
            effects: effects.parse().expect("effects"),
            light_paths: Some(light_paths),
            // The lens of the course has no Abbe numbers.
            assume_vd: true,
            buckets: Some(Some(Buckets::new(192, [360.0, 830.0]).expect("buckets"))),
            ..Changes::default()
        };
        let job = prepare(description, &changes).expect("a job").job;
        assert_eq!(job.plan.has(Effect::Dispersion), effects.starts_with('+'));
        assert_eq!(job.light_strategies().len(), if light_paths { 3 } else { 0 }, "{effects}");
        assert_colours_of_spectra(&job, &taken(&job, 2, Backend::Simd), 0.03);
    }
}

/// Replays of all samples of a pixel add up to what the picture has.
#[test]
fn replayed_samples_add_to_the_buckets_of_their_pixel() {
    let film = "Film \"spectral\" \"integer nbuckets\" 9 \"integer xresolution\" 12
                \"integer yresolution\" 8 ";
    let changes = Changes { samples: Some(5), ..Changes::default() };
    let job = job(&format!("{film}{COLOURS}"), changes);
    let spectrum = spectrum(&job, &taken(&job, 2, Backend::Simd));
    let (at, mut sums) = ([6, 4], vec![0.0; 9]);
    for number in 0..5 {
        let sample = SampleId::new(at, number, job.seed);
        let replay = replay(&job, Backend::Scalar, sample).expect("a sample");
        assert_eq!(replay.buckets.len(), 9);
        sums.iter_mut().zip(replay.buckets).for_each(|(sum, added)| *sum += added);
    }
    assert!(sums.iter().any(|&sum| sum > 0.0), "{sums:?}");
    for ((_, values), sum) in spectrum.channels.iter().zip(sums) {
        let mean = f64::from(values[at[1] as usize * 12 + at[0] as usize]);
        assert!((mean - sum / 5.0).abs() <= 1e-6 * mean.abs(), "{mean}, not {}", sum / 5.0);
    }
}

#[test]
fn shards_add_up() {
    let render = "render scene.pbrt --buckets 6@400..700 --effects +ghosts --resolution 48x32";
    Workspace::new().merges_to_the_whole(&format!("{render} --spp 70"));
}

#[test]
fn stopped_renders_go_on_to_the_same_bits() {
    let workspace = Workspace::new();
    // Long enough to be stopped on a fast machine: a second or more.
    for criterion in ["--spp 8000", "--noise 0.004"] {
        let render = format!(
            "render scene.pbrt -o a.exr --resolution 40x24 --buckets 6@400..700 {criterion} \
             --light-paths off --effects -ghosts,-diffraction"
        );
        workspace.run_ok(&render);
        let whole = workspace.contents("a.exr");
        let names = whole.channels.iter().map(|(name, _)| name.as_str());
        assert_eq!(names.filter(|name| name.starts_with("S0.")).count(), 6);
        let mut child = workspace.start(&format!("{render} --checkpoint 2ms"));
        // A tile of 32 x 24 pixels with its buckets takes 55 KB.
        workspace.wait_for_file(&mut child, "a.exr.checkpoint", 50_000);
        signal(&child, "INT");
        let (code, stderr) = finish(child);
        assert_eq!(code, 130, "{stderr}");
        let partial = workspace.contents("a.partial.exr");
        assert_eq!(partial.channels.len(), whole.channels.len());
        let stderr = workspace.run_ok(&format!("{render} --resume"));
        assert!(stderr.contains("resuming from a.exr.checkpoint"), "{stderr}");
        assert_eq!(workspace.contents("a.exr"), whole, "{criterion}");
    }
}

#[test]
fn files_have_the_layout_of_spectral_openexr_and_are_read_as_colours() {
    let folder = folder();
    let buckets = "\"integer nbuckets\" 4 \"float lambdamin\" 400 \"float lambdamax\" 700.5";
    let grey = "\"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]";
    write(&folder, "a.pbrt", wall(buckets, "\"rgb L\" [1 1 1]", grey));
    let run = |arguments: &str| {
        let (code, _, stderr) =
            petzval(folder.path(), &arguments.split_whitespace().collect::<Vec<_>>());
        assert_eq!(code, 0, "{arguments}: {stderr}");
        stderr
    };
    let stderr = run("render a.pbrt --spp 64 -o a.exr");
    assert!(stderr.contains("4 buckets of wavelength from 400 to 700.5 nm"), "{stderr}");
    let path = folder.path().join("a.exr");
    let image = read_all_flat_layers_from_file(&path).expect("a picture");
    let layer = &image.layer_data[0];
    let names: Vec<String> =
        layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
    let spectra = ["S0.437,562nm", "S0.512,688nm", "S0.587,812nm", "S0.662,938nm"];
    assert_eq!(names, [&["B", "G", "R"][..], &spectra].concat());
    let attributes = || image.attributes.other.iter().chain(&layer.attributes.other);
    let text = |wanted: &str| match attributes().find(|(name, _)| **name == *wanted) {
        Some((_, AttributeValue::Text(text))) => text.to_string(),
        other => panic!("{wanted}: {other:?}"),
    };
    assert_eq!(text("spectralLayoutVersion"), "1.0");
    assert_eq!(text("emissiveUnits"), "W.m^-2.sr^-1");
    // Readers of colours pass over the spectra.
    let spectral = Picture::read(&path).expect("a picture");
    run("render a.pbrt --spp 64 -o b.exr --buckets none --effects +spectra");
    assert_eq!(spectral, Picture::read(&folder.path().join("b.exr")).expect("a picture"));
    run("compare a.exr b.exr --fail-above 0");
    // The array has the values of the channels.
    run("render a.pbrt --spp 64 -o a.npy");
    let array = std::fs::read(folder.path().join("a.npy")).expect("an array");
    let start = 10 + usize::from(u16::from_le_bytes([array[8], array[9]]));
    assert!(String::from_utf8_lossy(&array[..start]).contains("(8, 8, 4,)"));
    let values = array[start..].as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
    let values: Vec<f32> = values.collect();
    for (bucket, name) in spectra.iter().enumerate() {
        let channel = layer.channel_data.list.iter().find(|c| c.name.to_string() == *name);
        let expected: Vec<f32> = channel.expect("a channel").sample_data.values_as_f32().collect();
        let found: Vec<f32> = values.iter().copied().skip(bucket).step_by(4).collect();
        assert_eq!(found, expected, "{name}");
    }
    run("render a.pbrt --spp 1 -o c.npy --buckets none");
    let array = std::fs::read(folder.path().join("c.npy")).expect("an array");
    assert!(String::from_utf8_lossy(&array[..80]).contains("(8, 8, 3,)"));
    let stderr = run("render a.pbrt --spp 1 -o a.png");
    assert!(stderr.contains("a.png shows the colours alone; name a picture.exr"), "{stderr}");
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let workspace = Workspace::new();
    for buckets in ["0", "193", "x", "16@", "16@300..700", "16@700..400", "16@500..500.5", "-4"] {
        workspace.refuses(&format!("render scene.pbrt -o a.exr --buckets={buckets}"), "expected");
    }
    let given = "render scene.pbrt --buckets 16";
    workspace.refuses(
        &format!("{given} -o a.exr --effects -spectra"),
        "--buckets 16@360..830: --effects turns spectra off",
    );
    workspace.refuses(&format!("{given} -o a.exr --passband 500..550"), "sees one colour");
    workspace.refuses(&format!("{given} -o a.png"), "a.png: only EXR holds layers");
    workspace.refuses("render scene.pbrt -o a.npy --aov depth", "a.npy: only EXR holds layers");
    let text = std::fs::read_to_string(workspace.path("scene.pbrt")).expect("a scene");
    let film = |more: &str| {
        let spectral = format!("Film \"spectral\" {more}");
        std::fs::write(workspace.path("scene.pbrt"), text.replacen("Film \"rgb\"", &spectral, 1))
            .expect("a scene");
    };
    film("");
    workspace.refuses(
        "render scene.pbrt -o a.exr --effects none",
        "the film of the scene has 16 buckets of wavelength, and --effects turns spectra off, without \
         which light has no wavelengths; with --buckets none it is an RGB film",
    );
    let rgb = "render scene.pbrt -o a.exr --effects none --buckets none --spp 1 --resolution 6x4";
    workspace.run_ok(rgb);
    film("\"integer nbuckets\" 500");
    workspace.refuses("render scene.pbrt -o a.exr", "expected a whole number from 1 to 192");
    film("\"float lambdamin\" 300");
    workspace.refuses(
        "render scene.pbrt -o a.exr",
        "buckets from 300 to 830 nm; expected two wavelengths from 360 to 830 nm",
    );
}
