//! Zoom and focus states: given ones, states between them, and focus by moving groups.

use std::path::Path;

use crate::support::{folder, petzval, write};
use petzval_lens::{FocusError, FocusModel, Paraxial, Prescription, Zoom};
use petzval_lens_formats::parse_toml;

const DIAGONAL: f64 = 43.0;

/// A negative group before a positive one, of -80 and 50 mm: the gap between them zooms.
const ZOOM: &str = r#"
name = "two groups"
[[surface]]
radius = -82.688
thickness = 1
diameter = 30
index = 1.5168
[[surface]]
radius = 82.688
thickness = 40
diameter = 30
[[surface]]
stop = true
diameter = 20
thickness = 1
[[surface]]
radius = 51.68
thickness = 3
diameter = 30
index = 1.5168
[[surface]]
radius = -51.68
diameter = 30

[[configuration]]
name = "wide"
film_distance = 82
f_number = 5
thickness = [[2, 60]]
[[configuration]]
name = "tele"
film_distance = 110
f_number = 8
thickness = [[2, 20]]
[[configuration]]
object_distance = 500
film_distance = 82
thickness = [[2, 64]]
[[configuration]]
object_distance = 500
film_distance = 110
thickness = [[2, 25]]
"#;

fn zoom() -> Prescription {
    parse_toml(Path::new("zoom.toml"), ZOOM).expect("a lens")
}

fn at(mm: f64) -> (Prescription, Option<String>) {
    zoom().at_zoom(&Zoom::FocalLength(mm)).expect("in range")
}

#[test]
fn a_given_state_is_taken_as_it_is_and_sets_the_stop() {
    for (name, gap, f_number) in [("wide", 60.0, 5.0), ("TELE", 20.0, 8.0), ("2", 20.0, 8.0)] {
        let (lens, note) = zoom().at_zoom(&Zoom::State(name.to_owned())).expect("a state");
        assert_eq!((lens.rows[1].thickness, note), (gap, None), "{name}");
        assert!((Paraxial::new(&lens).f_number() - f_number).abs() < 1e-9, "{name}");
    }
}

#[test]
fn a_state_between_two_has_the_focal_length_that_is_asked_for_and_says_so() {
    let range = zoom().zoom_range();
    assert!(range[0] < 46.0 && range[1] > 78.0, "{range:?}");
    for mm in [50.0, 60.0, 70.0] {
        let (lens, note) = at(mm);
        assert!((Paraxial::new(&lens).focal_length - mm).abs() < 1e-9, "{mm}");
        assert!((20.0..60.0).contains(&lens.rows[1].thickness));
        assert!(note.is_some_and(|note| note.contains("interpolated")));
    }
}

#[test]
fn a_focal_length_out_of_range_is_an_error_that_names_the_range() {
    let error = zoom().at_zoom(&Zoom::FocalLength(200.0)).expect_err("too long").to_string();
    assert!(error.contains("no focal length of 200 mm") && error.contains(" to "), "{error}");
    let error = zoom().at_zoom(&Zoom::State("macro".into())).expect_err("no state").to_string();
    assert!(error.contains("\"macro\"") && error.contains("\"wide\", \"tele\""), "{error}");
    let prime = crate::support::lens("dgauss.50mm");
    let error = prime.at_zoom(&Zoom::FocalLength(50.0)).expect_err("a prime").to_string();
    assert!(error.contains("one focal length"), "{error}");
}

#[test]
fn focus_moves_the_group_and_leaves_the_film() {
    for mm in [46.0, 60.0, 78.0] {
        let (lens, _) = at(mm);
        let focus = |mm: f64| lens.focus_by_groups(mm, FocusModel::Sharpest, DIAGONAL);
        let (distant, film) = focus(f64::INFINITY).expect("moves groups").expect("an image");
        for distance in [2e3, 1e4, 1e5] {
            let (moved, same_film) = focus(distance).expect("moves groups").expect("in range");
            assert!((same_film - film).abs() < 1e-9, "the film stays");
            assert!(moved.rows[1].thickness != distant.rows[1].thickness);
            let sharp = FocusModel::Sharpest.film(&moved, distance, DIAGONAL).expect("sharp");
            assert!((sharp - film).abs() < 1e-6, "{mm} mm at {distance}: {sharp} {film}");
        }
        match focus(300.0) {
            Some(Err(FocusError::TooNear { nearest, .. })) => assert!(nearest > 300.0),
            other => panic!("focused at 300 mm: {other:?}"),
        }
    }
}

#[test]
fn the_command_focuses_by_groups() {
    let folder = folder();
    write(&folder, "zoom.toml", ZOOM);
    for distance in [2000.0, 5000.0] {
        let focused = zoom().focus_by_groups(distance, FocusModel::Sharpest, DIAGONAL);
        let (moved, film) = focused.expect("moves groups").expect("in range");
        let (code, out, err) =
            petzval(folder.path(), &["lens", "zoom.toml", "--focus", &format!("{distance}mm")]);
        assert_eq!(code, 0, "{err}");
        let focal = Paraxial::new(&moved).focal_length;
        assert!(out.contains(&format!("{focal:.4} mm")), "{focal}: {out}");
        assert!(out.contains(&format!("{film:.4} mm  (behind rear vertex; the file")), "{out}");
    }
}

#[test]
fn a_lens_without_focus_states_moves_its_film() {
    let lens = crate::support::lens("dgauss.50mm");
    assert!(lens.focus_by_groups(1e3, FocusModel::Sharpest, DIAGONAL).is_none());
}

#[test]
fn the_command_shows_and_converts_a_zoom_setting() {
    let folder = folder();
    write(&folder, "zoom.toml", ZOOM);
    let (code, out, err) = petzval(folder.path(), &["lens", "zoom.toml", "--zoom", "60mm"]);
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("60.0000 mm") && err.contains("interpolated"), "{out}{err}");
    let convert = ["lens", "convert", "zoom.toml", "--zoom", "tele", "-o", "tele.toml"];
    let (code, _, err) = petzval(folder.path(), &convert);
    assert_eq!(code, 0, "{err}");
    let (_, out, _) = petzval(folder.path(), &["lens", "tele.toml"]);
    assert!(out.contains("20.0000"), "{out}");
    let (code, _, err) = petzval(folder.path(), &["lens", "zoom.toml", "--zoom", "10"]);
    assert_eq!(code, 2);
    assert!(err.contains("--zoom: zoom.toml: two groups has no focal length of 10 mm"), "{err}");
}

#[test]
fn the_f_number_of_a_picture_is_that_at_infinity_wherever_groups_move() {
    let folder = folder();
    write(&folder, "zoom.toml", ZOOM);
    let scene = crate::support::root().join("scenes/snowman.pbrt").display().to_string();
    let exposure = |focus: &str| {
        let options = ["--lens", "zoom.toml", "--zoom", "wide", "--fstop", "8", "--focus", focus];
        let size = ["--resolution", "12x8", "--spp", "1", "--effects", "none", "-v", "-o", "a.exr"];
        let arguments = [&["render", scene.as_str()][..], &options, &size].concat();
        let (code, _, err) = petzval(folder.path(), &arguments);
        assert_eq!(code, 0, "{err}");
        let line = err.lines().find(|line| line.starts_with("exposure")).map(str::to_owned);
        line.unwrap_or_else(|| panic!("no exposure: {err}"))
    };
    let distant = exposure("inf");
    assert_eq!(exposure("3"), distant);
    assert!(distant.contains("f/8") || distant.contains("f/7.9"), "{distant}");
}
