//! The rays and the image of a place in the picture.

use serde_json::{Value, json};

use super::{View, status};

/// Returns the JSON of a path behind the token.
fn json_of(view: &View, path: &str) -> Value {
    let reply = view.get(&format!("/{}{path}", view.token), "");
    assert_eq!(status(&reply), 200, "{path}: {reply}");
    let (_, body) = reply.split_once("\r\n\r\n").expect("a body");
    serde_json::from_str(body).expect("JSON")
}

/// Returns the share of the rays with a fate.
fn share(rays: &Value, fate: &str) -> f64 {
    let fates = rays["fates"].as_array().expect("fates");
    let all: f64 = fates.iter().map(|fate| fate["share"].as_f64().expect("a share")).sum();
    assert!((all - 1.0).abs() < 1e-9, "{fates:?}");
    let found = fates.iter().find(|found| found["words"] == fate);
    found.map_or(0.0, |fate| fate["share"].as_f64().expect("a share"))
}

#[test]
fn the_bench_says_which_surfaces_end_the_rays_of_a_place() {
    let view = View::start("dgauss.pbrt", &["--resolution", "48x32", "--spp=1", "--fstop=8"]);
    view.client().finished(1);
    let middle = json_of(&view, "rays/0.5,0.5.json");
    assert!(middle["height"].as_f64().expect("a height") < 1e-9, "{}", middle["height"]);
    assert_eq!(middle["limits"], json!(["the stop", "the stop"]));
    let passing = share(&middle, "pass");
    assert!(passing > 0.0 && share(&middle, "the stop") > passing, "{}", middle["fates"]);

    view.client().set(json!({ "fstop": "2.1" }));
    let middle = json_of(&view, "rays/0.5,0.5.json");
    let wide = share(&middle, "pass");
    // By the ratio of the f-numbers, up to the aberrations of the pupil.
    assert!((wide / passing - 8.0 / 2.1).abs() < 0.4, "{wide} and {passing}");
    let aside = json_of(&view, "rays/0.8,0.3.json");
    let height = aside["height"].as_f64().expect("a height");
    // The diagonal of the film is 70 mm, and its sides are as 3 : 2.
    let unit = 70.0 / 3f64.hypot(2.0);
    assert!((height - unit * (0.3 * 3.0_f64).hypot(0.2 * 2.0)).abs() < 1e-6, "{height}");
    let limits = aside["limits"].as_array().expect("limits");
    let rim = |end: &Value| end.as_str().is_some_and(|end| end.starts_with("the rim of surface "));
    assert!(limits.iter().any(rim), "{limits:?}");
    assert!(share(&aside, "pass") < wide);
    let section = aside["section"].as_str().expect("a drawing");
    for (words, colour) in [("rays that pass", "#0072b2"), ("rays that a rim blocks", "#d55e00")] {
        assert!(section.contains(colour), "no {words} are drawn");
    }
}

#[test]
fn a_draft_shows_the_new_lens_before_the_picture_is_prepared() {
    let view = View::start("dgauss.pbrt", &["--resolution", "600x400", "--spp=1"]);
    let mut client = view.client();
    client.finished(1);
    let old = view.client().hear("state");
    let lens = "scenes/../lenses/wide.22mm.dat";
    client.send(&json!({ "type": "set", "options": { "lens": lens, "fstop": null } }));
    let generation = client.hear("set")["generation"].clone();
    let mut state = || loop {
        let state = client.hear("state");
        if state["generation"] == generation {
            break state;
        }
    };
    let draft = state();
    assert_eq!(draft["draft"], true, "{draft}");
    let [before, name] =
        [&old, &draft].map(|state| state["lens"]["name"].as_str().expect("a name").to_owned());
    assert_ne!(name, before);
    let focal_length = draft["lens"]["focal_length"].as_f64().expect("a length");
    assert!((focal_length - 22.0).abs() < 0.1, "{focal_length}");
    // The page asks for the section as soon as it knows the state.
    let section = json_of(&view, "rays/0.5,0.5.json")["section"].clone();
    assert!(section.as_str().expect("a drawing").contains(&format!("<title>{name}")), "{section}");
    assert_eq!(draft["plan"], old["plan"], "a draft has a plan of its own");
    let picture = state();
    assert_eq!([&picture["draft"], &picture["error"]], [&json!(false), &Value::Null]);
    assert_eq!(picture["lens"]["name"], draft["lens"]["name"]);
    assert_ne!(picture["plan"], old["plan"]);
}

#[test]
fn the_f_number_is_that_of_the_marginal_ray_as_fstop_counts_it() {
    let view = View::start("dgauss.pbrt", &["--resolution", "24x16", "--spp=1"]);
    let mut client = view.client();
    let mut stops = |lens: &str, stop: Value| {
        client.set(json!({ "lens": format!("scenes/../lenses/{lens}"), "fstop": stop }));
        let lens = view.client().hear("state")["lens"].clone();
        ["f_number", "widest_f_number"].map(|name| lens[name].as_f64().expect("an f-number"))
    };
    // First-order optics says 2.68 and 2.03.
    for (lens, open) in [("wide.22mm.dat", 2.7753), ("dgauss.50mm.dat", 2.0206)] {
        let [_, widest] = stops(lens, json!("8"));
        assert!((widest - open).abs() < 1e-3, "{lens}: {widest} instead of {open}");
        for (asked, expected) in [(2.0 * open, 2.0 * open), (open * 0.99, open)] {
            let [found, again] = stops(lens, json!(asked.to_string()));
            assert!((found - expected).abs() < 1e-3, "{lens}: {found} instead of {expected}");
            assert_eq!(again, widest);
        }
    }
}

#[test]
fn sections_of_the_drawer_are_too_small_for_words() {
    let view = View::small();
    let lenses = json_of(&view, "lenses.json");
    for lens in lenses.as_array().expect("lenses") {
        let path = lens["section"].as_str().expect("a path");
        let section = view.get(&format!("/{}{path}", view.token), "");
        assert!(section.contains("class=\"field\"") && !section.contains("<text"), "{section}");
    }
}

#[test]
fn the_image_of_a_place_is_blurred_by_defocus() {
    let view = View::start("dgauss.pbrt", &["--resolution", "48x32", "--spp=1", "--fstop=4"]);
    let mut client = view.client();
    let mut rms = |focus: &str| {
        client.set(json!({ "focus": focus }));
        let image = json_of(&view, "image/0.5,0.5.json");
        assert!(image["spot"].as_str().is_some_and(|svg| svg.contains("<circle")), "{image}");
        assert!(image["transfer"].as_str().is_some_and(|svg| svg.contains("cycles/mm")));
        image["rms"].as_f64().expect("a size")
    };
    // The image is that of the plane in focus, wherever it is.
    let (near, far) = (rms("0.7"), rms("20"));
    assert!(near > 0.0 && near < 30.0 && far > 0.0 && far < 30.0, "{near} and {far}");
    let corner = json_of(&view, "image/0.75,0.4.json");
    assert!(corner["rms"].as_f64().expect("a size") > far, "{}", corner["rms"]);
}

#[test]
fn the_depth_of_field_lies_around_the_focus_and_grows_with_the_stop() {
    let view = View::start("dgauss.pbrt", &["--resolution", "48x32", "--spp=1", "--focus=3"]);
    let mut client = view.client();
    let mut depth = |stop: &str| {
        client.set(json!({ "fstop": stop }));
        let state = view.client().hear("state");
        let depth = &state["depth_of_field"];
        [&depth["near"], &depth["far"]].map(|end| end.as_f64().expect("a distance"))
    };
    let ([near, far], [nearer, farther]) = (depth("4"), depth("8"));
    assert!(nearer < near && near < 3.0 && 3.0 < far && far < farther, "{near} to {far}");
    // 1 / near - 1 / far is proportional to the f-number.
    let ratio = (1.0 / nearer - 1.0 / farther) / (1.0 / near - 1.0 / far);
    assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
    // Wide open and near, aberrations move the sharpest film from the first-order one.
    client.set(json!({ "focus": "0.6", "fstop": "2.8" }));
    let state = view.client().hear("state");
    let depth = &state["depth_of_field"];
    let [near, far] = ["near", "far"].map(|end| depth[end].as_f64().expect("a distance"));
    assert!(near < 0.6 && 0.6 < far && far - near < 0.1, "{near} to {far}");
    client.set(json!({ "focus": "inf" }));
    assert_eq!(view.client().hear("state")["depth_of_field"]["far"], Value::Null);
}

#[test]
fn places_outside_the_picture_have_no_rays() {
    let view = View::small();
    view.client().finished(1);
    for place in ["2,0", "-0.1,0", "nan,0", "inf,0", "0.5", "0.5,0.5,0.5", ""] {
        for kind in ["rays", "image"] {
            assert_eq!(view.status(&format!("{kind}/{place}.json")), 404, "{kind}/{place}");
        }
    }
}
