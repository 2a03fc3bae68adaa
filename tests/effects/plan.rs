//! The plan of effects as JSON, and its estimates against pictures.

use crate::support::{mean, petzval, picture, root};
use petzval_lens::Coating;
use petzval_render::Backend;
use petzval_render::light_tracing::LightTracingSurvey;
use petzval_render::plan::{Effect, OmissionError, Plan};
use petzval_render::prepare::{Changes, FocusOn, prepare};
use petzval_scene_formats::pbrt;
use serde_json::Value;

fn effects(arguments: &[&str]) -> Vec<Value> {
    let (code, stdout, stderr) = petzval(root(), &[&["plan"], arguments, &["--json"]].concat());
    assert_eq!(code, 0, "{stderr}");
    let plan: Value = serde_json::from_str(&stdout).expect("JSON");
    plan["effects"].as_array().expect("a list").clone()
}

fn of<'a>(effects: &'a [Value], name: &str) -> &'a Value {
    effects.iter().find(|effect| effect["effect"] == name).expect("the effect")
}

#[test]
fn a_plan_has_a_row_of_source_and_reason_for_every_effect() {
    let effects = effects(&["scenes/dgauss.pbrt"]);
    let names: Vec<&str> = effects.iter().filter_map(|row| row["effect"].as_str()).collect();
    assert_eq!(names, Effect::ALL.map(Effect::name));
    for row in &effects {
        assert!(row["on"].is_boolean() && !row["reason"].as_str().unwrap_or("").is_empty());
        assert!(["scene", "lens", "flag"].iter().any(|by| row["by"] == *by), "{row}");
        assert!(row.get("error").is_some() && row.get("cost").is_some(), "{row}");
    }
}

#[test]
fn the_course_scenes_need_no_effects_except_ghosts_of_a_visible_light() {
    for scene in ["dgauss", "fisheye", "telephoto", "wide"] {
        let effects = effects(&[&format!("scenes/{scene}.pbrt")]);
        let needed: Vec<&str> = effects
            .iter()
            .filter(|row| row["on"] == true)
            .filter_map(|row| row["effect"].as_str())
            .collect();
        let expected: &[&str] = if scene == "fisheye" { &["ghosts"] } else { &[] };
        assert_eq!(needed, expected, "{scene}: {effects:#?}");
        let ghosts = of(&effects, "ghosts")["error"]["percent"].as_f64();
        println!("{scene}: {ghosts:?}");
        assert_eq!(ghosts > Some(1.0), scene == "fisheye");
    }
}

#[test]
fn the_first_picture_disperses_where_its_pixels_show_it() {
    for (pixels, on) in [("300x300", false), ("6000x6000", true)] {
        let effects = effects(&["scenes/dgauss.pbrt", "--resolution", pixels]);
        assert_eq!(of(&effects, "dispersion")["on"], on, "{pixels}: {effects:#?}");
    }
}

#[test]
fn nothing_is_measured_for_a_picture_whose_user_decides_all() {
    // Its lamp makes ghosts, so that everything can be measured.
    let plan = |effects: &str, light_paths| {
        let description = pbrt::read(&root().join("scenes/fisheye.pbrt")).expect("a scene");
        let effects = effects.parse().expect("a selection");
        let changes = Changes { effects, light_paths, ..Changes::default() };
        prepare(description, &changes).expect("a job").job.plan
    };
    let decided = plan("none", Some(false));
    // Measured effects have errors, costs and longer reasons.
    assert_eq!(decided.effects, Plan::unwanted().effects);
    assert_eq!(decided.light_paths.reason, LightTracingSurvey::unwanted().reason);
    assert_eq!(plan("none", Some(true)).effects, Plan::unwanted().effects);
    for open in [plan("none", None), plan("auto", Some(false))] {
        assert!(open.effects.iter().any(|decision| decision.cost.is_some()), "{open:?}");
    }
}

#[test]
fn costs_are_shares_of_the_render_and_reproducible() {
    let plan = |scene: &str| effects(&[&format!("scenes/{scene}.pbrt")]);
    let share = |effects: &[Value]| of(effects, "fresnel")["cost"]["percent"].as_f64();
    // The same lens in front of a plane under one light, and of a landscape under many.
    let (plane, landscape) = (plan("dgauss"), plan("snowman"));
    let [light, heavy] = [&plane, &landscape].map(|plan| share(plan).expect("a price"));
    println!("{light:.2} % and {heavy:.2} %");
    assert!(light / heavy > 2.0 && light / heavy < 9.0, "{light} % and {heavy} %");
    assert_eq!(landscape, plan("snowman"));
}

/// A cemented doublet of crown and flint, 100 mm at f/4.
const DOUBLET: &str = "[[surface]]\nradius = 61.36\nthickness = 6.0\ndiameter = 25.0
glass = \"N-BK7\"\nstop = true\n[[surface]]\nradius = -44.3\nthickness = 2.5
diameter = 25.0\nglass = \"N-SF5\"\n[[surface]]\nradius = -128.9\nthickness = 95.0
diameter = 25.0\n";

#[test]
fn a_narrow_passband_needs_no_dispersion() {
    let folder = crate::support::folder();
    let lens = crate::support::write(&folder, "doublet.toml", DOUBLET);
    let lens = lens.to_str().expect("a path");
    let doublet = [
        "scenes/atelier.pbrt",
        "--lens",
        lens,
        "--focus",
        "3",
        "--fstop",
        "4",
        "--resolution",
        "9000x6000",
    ];
    let dispersion =
        |more: &[&str]| of(&effects(&[&doublet[..], more].concat()), "dispersion").clone();
    let (colour, narrow) = (dispersion(&[]), dispersion(&["--passband", "545..555"]));
    println!("{colour}\n{narrow}");
    assert!(colour["on"] == true && narrow["on"] == false);
    let um = |row: &Value| row["error"]["um"].as_f64().expect("an estimate");
    assert!(um(&narrow) < um(&colour) / 5.0);
}

#[test]
fn a_requested_dispersion_guesses_unknown_glasses() {
    let lens = ["scenes/snowman.pbrt", "--lens", "lenses/dgauss.50mm.dat"];
    let known = effects(&lens);
    assert!(of(&known, "dispersion")["on"] == false && of(&known, "dispersion")["error"].is_null());
    let guessed = effects(&[&lens[..], &["--assume-vd", "--visible", "0.01px"]].concat());
    let row = of(&guessed, "dispersion");
    println!("{row}");
    assert!(row["on"] == true && row["by"] == "flag");
    assert!(row["reason"].as_str().expect("a reason").contains("guessed"));
    // With sensible guesses of its glasses a corrected lens is better than a single glass.
    let um = row["error"]["um"].as_f64().expect("an estimate");
    assert!((0.5..60.0).contains(&um), "{um}");
}

#[test]
fn visible_effects_depend_on_the_pixel_size() {
    let lens = ["scenes/snowman.pbrt", "--lens", "lenses/triplet.toml"];
    let coarse = effects(&[&lens[..], &["--visible", "100px"]].concat());
    let fine = effects(&[&lens[..], &["--visible", "0.001px"]].concat());
    assert_eq!(of(&coarse, "dispersion")["on"], false);
    assert_eq!(of(&fine, "dispersion")["on"], true);
    let um = |effects: &[Value]| of(effects, "dispersion")["error"]["um"].as_f64();
    assert!(um(&coarse) == um(&fine) && um(&fine) > Some(0.5), "{:?}", um(&fine));
    // The radius of the Airy disc is 1.22 lambda N.
    let radius = |fstop: &str| {
        let effects = effects(&["scenes/snowman.pbrt", "--fstop", fstop]);
        of(&effects, "diffraction")["error"]["um"].as_f64().expect("a radius")
    };
    assert!((radius("16") / radius("4") - 4.0).abs() < 0.05);
}

#[test]
fn the_estimated_loss_equals_that_in_the_picture() {
    let job = |coating| {
        let description = pbrt::read(&root().join("scenes/dgauss.pbrt")).expect("a scene");
        let resolution = Some([60, 60]);
        let changes = Changes { coating, resolution, samples: Some(256), ..Changes::default() };
        prepare(description, &changes).expect("a job").job
    };
    let (without, with) = (job(None), job(Some(Coating::Bare)));
    assert!(!without.plan.has(Effect::Fresnel) && with.plan.has(Effect::Fresnel));
    let estimate = |job: &petzval_render::job::Job| match job.plan.effects[1].error {
        Some(OmissionError::Signal(percent)) => percent / 100.0,
        other => panic!("{other:?}"),
    };
    let bright = |job| mean(&picture(job, Backend::Simd, 1))[1];
    let seen = 1.0 - bright(&with) / bright(&without);
    assert!((estimate(&with) - seen).abs() < 0.005, "{} estimated, {seen} found", estimate(&with));
}

#[test]
fn the_estimated_loss_of_a_shaped_stop_equals_that_in_the_picture() {
    let lens = std::fs::read_to_string(root().join("lenses/triplet.toml")).expect("a lens");
    let bladed =
        lens.replace("stop = true", "stop = true\nblades = 5\nrotation = 18\nobstruction = 1");
    // A small stop, so that no other surface blocks light.
    let bladed = bladed.replace("diameter = 7.6", "diameter = 4.0");
    let folder = crate::support::folder();
    let file = crate::support::write(&folder, "bladed.toml", bladed);
    let job = |effects: &str| {
        let description = pbrt::read(&root().join("scenes/dgauss.pbrt")).expect("a scene");
        let changes = Changes {
            lens: Some(file.clone()),
            focus: Some(FocusOn::Distance(3.0)),
            resolution: Some([40, 40]),
            samples: Some(16384),
            crop: Some([[20, 20], [21, 21]]),
            effects: effects.parse().expect("effects"),
            ..Changes::default()
        };
        prepare(description, &changes).expect("a job").job
    };
    let (with, without) = (job("-ghosts,-diffraction"), job("-iris,-ghosts,-diffraction"));
    let row = |job: &petzval_render::job::Job| {
        let row = job.plan.effects.iter().find(|row| row.effect == Effect::Iris);
        row.expect("a row").clone()
    };
    let Some(OmissionError::Signal(estimate)) = row(&with).error else {
        panic!("{:?}", row(&with))
    };
    assert!(row(&with).on && !row(&without).on);
    let middle = |job| picture(job, Backend::Simd, 1).pixels[0][1];
    let seen = 100.0 * (1.0 - f64::from(middle(&with) / middle(&without)));
    println!("{estimate:.2} % estimated, {seen:.2} % found");
    assert!((estimate - seen).abs() < 1.0, "{estimate} {seen}");
}

#[test]
fn a_street_at_night_needs_ghosts_and_diffraction() {
    let effects = effects(&["scenes/night.pbrt"]);
    for effect in ["ghosts", "diffraction", "iris"] {
        assert!(of(&effects, effect)["on"] == true, "{effects:#?}");
    }
    for effect in ["motion", "rolling_shutter", "tilt_shift", "sensor", "fresnel"] {
        assert!(of(&effects, effect)["on"] == false, "{effects:#?}");
    }
}

#[test]
fn invalid_effect_lists_are_refused() {
    for (arguments, expected) in [
        (&["plan", "scenes/dgauss.pbrt", "--effects", "+disperson"][..], "no effect \"disperson\""),
        (&["plan", "scenes/dgauss.pbrt", "--visible", "-1"], "expected a number of pixels"),
        (&["plan", "scenes/dgauss.pbrt", "--passband", "600..500"], "expected two wavelengths"),
        (&["plan", "scenes/nothing.pbrt"], "cannot read scenes/nothing.pbrt"),
    ] {
        let (code, stdout, stderr) = petzval(root(), arguments);
        assert!(code == 2 && stdout.is_empty() && stderr.contains(expected), "{stderr}");
    }
}

#[test]
fn an_even_loss_is_exposure_where_no_coating_is_known() {
    let job = |effects: &str, coating| {
        let description = pbrt::read(&root().join("scenes/wide.pbrt")).expect("a scene");
        let effects = effects.parse().expect("effects");
        let resolution = Some([60, 40]);
        let changes =
            Changes { coating, effects, resolution, samples: Some(256), ..Changes::default() };
        prepare(description, &changes).expect("a job").job
    };
    let row = |job: &petzval_render::job::Job| job.plan.effects[1].clone();
    // The layer is assumed where nothing names a coating, whether losses are simulated or not.
    let (auto, with) = (job("-ghosts", None), job("+fresnel,-ghosts", None));
    let named = job("-ghosts", Some(Coating::Mgf2));
    for decision in [row(&auto), row(&with)] {
        assert!(decision.reason.contains("a layer of MgF2 is assumed"), "{}", decision.reason);
    }
    assert!(!row(&auto).on && row(&with).on && row(&named).on);
    let percent = |job: &petzval_render::job::Job| match row(job).error {
        Some(OmissionError::Signal(percent)) => percent,
        other => panic!("{other:?}"),
    };
    let [uneven, loss] = [&auto, &named].map(percent);
    println!("{uneven} % uneven, {loss} % lost: {}", row(&auto).reason);
    assert!(row(&auto).reason.ends_with("below 1 %, so not visible"), "{}", row(&auto).reason);
    assert!(uneven < 1.0 && loss > 5.0, "{uneven} {loss}");
    // The picture loses what the layer takes, and at the same exposure differs by the unevenness.
    let [without, with] = [&auto, &with].map(|job| picture(job, Backend::Simd, 1));
    let seen = 100.0 * (1.0 - mean(&with)[1] / mean(&without)[1]);
    assert!((seen - loss).abs() < 1.0, "{loss} % estimated, {seen} % found");
}

#[test]
fn every_effect_that_stays_off_says_why() {
    let threshold = |row: &Value| row["reason"].as_str().expect("a reason").contains("not visible");
    for scene in ["dgauss", "fisheye", "telephoto", "wide", "night", "snowman", "atelier"] {
        for row in effects(&[&format!("scenes/{scene}.pbrt")]) {
            let error = &row["error"];
            if let Some(difference) = error["de2000"].as_f64() {
                // Spectra of colours that are given as RGB are guesses, which the user may take.
                let guessed = row["reason"].as_str().expect("a reason").contains("'+spectra'");
                let visible = difference >= 1.0;
                assert!(row["on"] == (visible && !guessed), "{scene}: {row}");
                assert!(!guessed || visible, "{scene}: {row}");
                // Metals of the atelier and lamps of the night are given by wavelength.
                let stated = ["atelier", "night"].contains(&scene);
                assert_eq!(row["on"], stated, "{scene}: {row}");
                continue;
            }
            let visible = error["percent"].as_f64().is_some_and(|percent| percent >= 1.0)
                || error["px"].as_f64().is_some_and(|pixels| pixels >= 0.5);
            match row["on"] == true {
                true => assert!(!threshold(&row), "{scene}: {row}"),
                // By the rule, an error that is seen turns the effect on.
                false => {
                    assert!(!visible && (error.is_null() || threshold(&row)), "{scene}: {row}")
                }
            }
        }
    }
}
