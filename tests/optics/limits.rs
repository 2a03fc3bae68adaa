//! Reports of `petzval lens` on lenses without an image and on glasses outside their wavelengths.

use std::fmt::Write as _;
use std::path::Path;

use crate::support::{folder, petzval, root, write};
use petzval_lens::Prescription;
use petzval_lens_formats::parse_toml;

/// Returns a biconvex lens of this medium with its stop in front and the rows of `rest` behind.
fn biconvex(medium: &str, rest: &str) -> String {
    format!(
        "[[surface]]\ndiameter = 6\nstop = true\nthickness = 1\n\
         [[surface]]\nradius = 50\nthickness = 3\ndiameter = 12\n{medium}\n\
         [[surface]]\nradius = -50\ndiameter = 12\n{rest}\n"
    )
}

fn parsed(text: &str) -> Prescription {
    parse_toml(Path::new("test.toml"), text).expect("a lens of a test")
}

/// Runs `petzval lens`. Returns its exit code, standard output and standard error.
fn report(text: &str, options: &[&str]) -> (i32, String, String) {
    let folder = folder();
    write(&folder, "lens.toml", text);
    petzval(folder.path(), &[&["lens", "lens.toml"], options].concat())
}

#[test]
fn a_lens_without_an_image_still_has_a_report() {
    // A lens whose last surface, the film, lies just behind the focus, and a diverging lens.
    let film = biconvex("index = 1.5", "thickness = 49.6\n[[surface]]\ndiameter = 12");
    let diverging = biconvex("index = 1.5", "").replace("radius = 50", "radius = -50");
    for (text, focal) in [(film, "50.5"), (diverging.replace("= -50\ndi", "= 50\ndi"), "-49.5")] {
        for options in [&["--focus", "inf"][..], &[]] {
            let (code, stdout, _) = report(&text, options);
            assert_eq!(code, 0, "{options:?}: {stdout}");
            for known in ["radius", "focal length", "back focal distance", "exit pupil position"] {
                assert!(stdout.contains(known), "{options:?}: no {known} in {stdout}");
            }
            let line = stdout.lines().find(|line| line.starts_with("focal length")).expect("one");
            assert!(line.contains(focal), "{line}");
            assert!(stdout.contains("not known: "), "{options:?}: {stdout}");
            assert!(
                stdout.contains("no real image") && stdout.contains("leave it out"),
                "{stdout}"
            );
            assert_ne!(options.is_empty(), stdout.contains("  none\n"), "{options:?}: {stdout}");
        }
    }
}

#[test]
fn the_report_says_when_all_rays_are_blocked() {
    // First-order optics has an image, but all real rays are blocked.
    let text =
        biconvex("index = 1.5", "thickness = 1\n[[surface]]\ndiameter = 1\nobstruction = 0.99")
            .replace("diameter = 6", "diameter = 6\nobstruction = 5.9");
    let (code, stdout, _) = report(&text, &["--focus", "inf"]);
    assert!(code == 0 && stdout.contains("no ray from a point on the axis"), "{stdout}");
    let film = |name: &str| stdout.lines().find(|line| line.starts_with(name)).expect("a line");
    let none = ["film distance   ", "film distance, real rays"].map(|n| film(n).contains("none"));
    assert_eq!(none, [false, true], "{stdout}");
}

#[test]
fn a_focus_that_is_too_near_stays_an_error() {
    let (code, _, stderr) = report(&biconvex("index = 1.5", ""), &["--focus", "10mm"]);
    assert!(code == 2 && stderr.contains("the nearest it can is"), "{stderr}");
}

/// Indices of germanium from 8 to 12 um.
const GERMANIUM: &str = "index = [[8000, 4.0053], [10000, 4.0032], [12000, 4.0023]]";

#[test]
fn a_glass_outside_its_wavelengths_is_named_with_both_ranges() {
    let of = |medium: &str, used| parsed(&biconvex(medium, "")).index_warnings(used);
    let d = [587.5618; 2];
    for (medium, used, expected) in [
        (
            GERMANIUM,
            d,
            "behind surface 2 the table of indices covers 8000 to 12000 nm; at 587.6 nm",
        ),
        ("index = [[546.1, 1.5]]", d, "the table of indices covers 546.1 nm; at 587.6 nm"),
        ("index = 4.003", d, "the index 4.003 is taken at the d line, 587.6 nm"),
        (
            "index = 1.5",
            [500.0, 600.0],
            "states no dispersion, only the index at 587.6 nm; at 500 to 600 nm",
        ),
        (
            "glass = \"N-BK7\"",
            [400.0, 3000.0],
            "N-BK7 is known from 300 to 2500 nm; at 400 to 3000 nm",
        ),
        ("glass = \"PMMA\"", [1200.0; 2], "PMMA is known from 365 to 1060 nm; at 1200 nm"),
        (
            "index = 1.5\nabbe = 60",
            [1000.0; 2],
            "the Abbe number describes the index from 380 to 780 nm; at 1000 nm",
        ),
    ] {
        let message = of(medium, used);
        assert!(message.len() == 1 && message[0].contains(expected), "{medium}: {message:?}");
    }
    for (medium, used) in [
        (GERMANIUM, [8000.0, 12000.0]),
        ("index = [[587.6, 1.5]]", d),
        ("index = 1.9", d),
        ("glass = \"N-BK7\"", [400.0, 704.0]),
        ("index = 1.5\nabbe = 60", [400.0, 704.0]),
    ] {
        let message = of(medium, used);
        assert!(message.is_empty(), "{medium}: {message:?}");
    }
}

#[test]
fn a_wavelength_outside_a_glass_is_an_error_where_light_is_traced() {
    let folder = folder();
    write(&folder, "ge.toml", biconvex(GERMANIUM, ""));
    write(&folder, "rays.csv", "0,0,60,0,0,-1,9000\n0,0,60,0,0,-1,587.56\n");
    let mut scene = String::new();
    let _ = write!(
        scene,
        "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4 \"float diagonal\" 5\n\
         Camera \"realistic\" \"string lensfile\" \"ge.toml\" \"float aperturediameter\" 6 \
         \"float focusdistance\" 2\nSampler \"independent\" \"integer pixelsamples\" 1\n\
         WorldBegin\nLightSource \"infinite\"\n"
    );
    write(&folder, "scene.pbrt", scene);
    let runs: [&[&str]; 3] = [
        &["lens", "trace", "ge.toml", "--rays", "rays.csv"],
        &["plan", "scene.pbrt"],
        &["render", "scene.pbrt", "-o", "out.exr"],
    ];
    for arguments in runs {
        let (code, _, stderr) = petzval(folder.path(), arguments);
        let error = "behind surface 2: the medium given by a table of indices is known from 8000 to \
                     12000 nm, not at 587.6 nm; choose a wavelength in this range";
        assert!(code == 2 && stderr.contains(error), "{arguments:?}: {stderr}");
    }
    // The summary shows the indices of the file.
    let (code, _, stderr) = petzval(folder.path(), &["lens", "ge.toml"]);
    let warning = "behind surface 2 the table of indices covers 8000 to 12000 nm; at 587.6 ";
    assert!(code == 0 && stderr.matches(warning).count() == 1, "{stderr}");
}

#[test]
fn lenses_of_the_repository_cover_the_visible_wavelengths() {
    for lens in ["dgauss.50mm.dat", "triplet.toml", "phone.toml", "anamorphic.toml"] {
        let (code, stdout, stderr) = petzval(root(), &["lens", &format!("lenses/{lens}")]);
        assert!(code == 0 && !stderr.contains("warning"), "{stderr}");
        let line = stdout.lines().find(|line| line.starts_with("wavelength")).expect("one");
        let constant = lens.ends_with(".dat");
        assert_eq!(line.contains("states no dispersion"), constant, "{line}");
    }
}

#[test]
fn eyes_afocal_lenses_and_films_inside_the_lens_have_a_useful_report() {
    let surface = |keys: &str| format!("[[surface]]\n{keys}\n");
    let stop = surface("stop = true\ndiameter = 4\nthickness = 2");
    let eye = stop.clone() + &surface("radius = 5.6\ndiameter = 8\nindex = 1.336");
    let afocal = stop.clone()
        + &surface("radius = 20\ndiameter = 8\nindex = 1.5\nthickness = 90")
        + &surface("radius = -10\ndiameter = 8");
    let inside = stop
        + &surface("radius = 10\ndiameter = 8\nindex = 1.5\nthickness = 35")
        + &surface("diameter = 8");
    // f = n R / (n - 1) behind and R / (n - 1) before; a rod of n (R1 - R2) / (n - 1) is afocal.
    for (text, expected) in [
        (
            &eye,
            &[
                "index before the film             1.3360",
                "rear focal length",
                "22.2667 mm",
                "16.6667 mm",
            ][..],
        ),
        (
            &afocal,
            &["focal length                      afocal", "angular magnification", "not known: "],
        ),
        (&inside, &["20.0000 mm", "not known: ", "no real image"]),
    ] {
        let (code, stdout, stderr) = report(text, &["--focus", "inf"]);
        assert_eq!(code, 0, "{stdout}{stderr}");
        for words in expected {
            assert!(stdout.contains(words), "no {words} in {stdout}");
        }
    }
}
