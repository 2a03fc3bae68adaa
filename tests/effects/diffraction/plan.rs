//! Plans with diffraction, and renders of whole scenes and of crops.

use petzval_render::job::Job;
use petzval_render::plan::{Effect, EffectSelection, OmissionError};
use petzval_render::prepare::{Changes, Prepared, prepare};
use petzval_render::{RenderOptions, render};
use petzval_scene_formats::pbrt;

use crate::support::{folder, root, write};

/// Prepares a render of a world, in metres, through a lens, with these changes.
fn job(lens: &str, film: &str, world: &str, changes: &Changes) -> Job {
    job_and_warnings(lens, film, world, changes).0
}

/// Prepares a render, and also returns its warnings.
fn job_and_warnings(lens: &str, film: &str, world: &str, changes: &Changes) -> (Job, String) {
    let folder = folder();
    let text = format!(
        "Film \"rgb\" {film} PixelFilter \"box\" Integrator \"path\" \"integer maxdepth\" 1
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 30
         \"float focusdistance\" 1000\nWorldBegin\n{world}",
        root().join("lenses").join(lens).display()
    );
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene of a test");
    let Prepared { job, warnings, .. } = prepare(description, changes).expect("a job");
    let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    (job, warnings.join("\n"))
}

/// A film of 3 um pixels.
const FINE: &str =
    "\"integer xresolution\" 120 \"integer yresolution\" 120 \"float diagonal\" 0.50912";

#[test]
fn a_landscape_at_f_22_needs_diffraction_and_a_portrait_wide_open_does_not() {
    let world = "LightSource \"infinite\"";
    let on = |f_number: Option<f64>, effects: &str| {
        let effects: EffectSelection = effects.parse().expect("effects");
        let film =
            "\"integer xresolution\" 60 \"integer yresolution\" 40 \"float diagonal\" 0.7211";
        let changes = Changes { f_number, effects, ..Changes::default() };
        job("dgauss.50mm.dat", film, world, &changes).plan.has(Effect::Diffraction)
    };
    // Pixels of 10 um, and Airy radii of 14.8 and 1.3 um.
    assert!(on(Some(22.0), "auto") && !on(None, "auto"));
    assert!(!on(Some(22.0), "-diffraction") && on(None, "+diffraction") && !on(Some(22.0), "none"));
}

#[test]
fn the_estimated_radius_equals_the_radius_in_the_picture() {
    // The radius that holds 83.8 % of the light of a star grows by the estimate of the plan, to a fifth:
    // the light is white and the pixels have a width.
    let world = "AreaLightSource \"diffuse\" \"rgb L\" [1e6 1e6 1e6] Translate 0 0 1000
        Shape \"sphere\" \"float radius\" 0.01";
    let seen = |effects: &str| {
        let changes = Changes {
            f_number: Some(22.0),
            effects: effects.parse().expect("effects"),
            samples: Some(64),
            ..Changes::default()
        };
        let job = job("dgauss.50mm.dat", FINE, world, &changes);
        let exposed = render(&job, RenderOptions { threads: 1, ..RenderOptions::default() })
            .expect("a picture");
        let picture = exposed.picture(&job);
        let mut light: Vec<(f64, f64)> = picture
            .pixels
            .iter()
            .enumerate()
            .map(|(i, pixel)| {
                let [x, y] = [i % 120, i / 120].map(|p| 3.0 * (p as f64 + 0.5 - 60.0));
                (x.hypot(y), f64::from(pixel[1]))
            })
            .collect();
        light.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all: f64 = light.iter().map(|(_, light)| light).sum();
        let mut inside = 0.0;
        let radius = light.iter().find(|(_, light)| {
            inside += light;
            inside > 0.838 * all
        });
        let estimate = match job.plan.effects.iter().find(|row| row.effect == Effect::Diffraction) {
            Some(row) => row.error,
            None => None,
        };
        let Some(OmissionError::Blur { um, .. }) = estimate else { panic!("{estimate:?}") };
        (radius.expect("light").0, um, all)
    };
    let (with, estimate, all) = seen("auto");
    let (without, same, before) = seen("none");
    println!("{estimate:.1} um estimated; {without:.1} um without, {with:.1} um with");
    assert_eq!(estimate, same);
    assert!(
        without < 5.0 && (with / estimate - 1.0).abs() < 0.2,
        "{with} um, {estimate} estimated"
    );
    assert!((all / before - 1.0).abs() < 0.03, "light is lost");
}

#[test]
fn a_bright_small_light_needs_diffraction() {
    // A grey floor, and a light of 2 pixels that is a million times as bright or not. At pixels of
    // 100 um no Airy disc is visible.
    let planned = |bright: f64| {
        let world = format!(
            "LightSource \"infinite\" AttributeBegin AreaLightSource \"diffuse\"
             \"rgb L\" [{bright} {bright} {bright}] Translate 0.3 0.2 50
             Shape \"sphere\" \"float radius\" 0.5 AttributeEnd"
        );
        let film = "\"integer xresolution\" 150 \"integer yresolution\" 100 \"float diagonal\" 18";
        let changes = Changes { f_number: Some(16.0), ..Changes::default() };
        let plan = job("dgauss.50mm.dat", film, &world, &changes).plan;
        plan.effects.into_iter().find(|row| row.effect == Effect::Diffraction).expect("a row")
    };
    let (bright, dim) = (planned(1e5), planned(10.0));
    assert!(bright.on && bright.reason.contains("the brightest light"), "{}", bright.reason);
    assert!(!dim.on && !dim.reason.contains("brightest light"), "{}", dim.reason);
}

#[test]
fn a_crop_equals_the_whole_picture_except_for_diffraction() {
    // With a sensor too: its noise depends on the pixel, not on the crop.
    let world = "LightSource \"infinite\" \"rgb L\" [0.4 0.5 0.6] Translate 0.06 0.02 40
        Material \"diffuse\" \"rgb reflectance\" [0.2 0.3 0.4] Shape \"sphere\" \"float radius\" 0.1";
    let film = "\"integer xresolution\" 60 \"integer yresolution\" 40 \"float diagonal\" 0.36";
    let taken = |effects: &str, sensor: Option<&str>, crop: Option<[[u32; 2]; 2]>| {
        let changes = Changes {
            f_number: Some(16.0),
            effects: effects.parse().expect("effects"),
            sensor: sensor.map(|options| options.parse().expect("a sensor")),
            samples: Some(16),
            crop,
            ..Changes::default()
        };
        let (job, warnings) = job_and_warnings("dgauss.50mm.dat", film, world, &changes);
        let exposed = render(&job, RenderOptions { threads: 1, ..RenderOptions::default() })
            .expect("a picture");
        (exposed.picture(&job).pixels, warnings)
    };
    let [low, high] = [[21, 11], [50, 32]];
    for (effects, sensor) in [
        ("-diffraction", None),
        ("-diffraction", Some("iso=3200,pixel=3")),
        ("-diffraction", Some("iso=3200,pixel=3,bayer=gbrg")),
        ("+diffraction", None),
    ] {
        let ((whole, whole_warnings), (part, part_warnings)) =
            (taken(effects, sensor, None), taken(effects, sensor, Some([low, high])));
        let inside = (low[1]..high[1]).flat_map(|y| (low[0]..high[0]).map(move |x| y * 60 + x));
        let inside: Vec<[f32; 3]> = inside.map(|i| whole[i as usize]).collect();
        let warns = "beyond the crop";
        assert!(!whole_warnings.contains(warns), "{whole_warnings}");
        if effects == "-diffraction" {
            assert!(inside == part, "{effects} {sensor:?}");
            assert!(!part_warnings.contains(warns), "{part_warnings}");
            continue;
        }
        assert!(part_warnings.contains(warns), "{part_warnings}");
        let bright = inside.iter().flatten().fold(0.0f32, |most, &v| most.max(v));
        // Airy's first dark ring has a radius of 2 pixels. The edge of the ball crosses that of the crop.
        for (margin, bound) in [(0, 0.15), (2, 0.03), (6, 0.01)] {
            let [width, height] = [high[0] - low[0], high[1] - low[1]].map(|n| n as usize);
            let deep = |i: &usize| {
                let [x, y] = [i % width, i / width];
                x.min(width - 1 - x).min(y).min(height - 1 - y) >= margin
            };
            let off = (0..width * height).filter(deep).flat_map(|i| {
                let (inside, part) = (inside[i], part[i]);
                (0..3).map(move |c| (inside[c] - part[c]).abs() / bright)
            });
            let off = off.fold(0.0, f32::max);
            println!("{margin} pixels inside a crop differs by {off:.5} of the brightest at most");
            assert!(off > 0.0 && off < bound, "{margin}: {off}");
        }
    }
}
