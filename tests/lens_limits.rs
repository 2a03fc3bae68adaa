//! Reports of `petzval lens` on lenses of which not all can be known: no image, or indices outside
//! the wavelengths of their data.

mod support;

use std::fmt::Write as _;
use std::path::Path;

use petzval::lens::{Prescription, parse_toml};
use support::{folder, petzval, root, write};

/// A biconvex lens of this medium with its stop in front, and `rest` behind.
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

/// The exit code of the command for a lens, its output and its messages.
fn told(text: &str, options: &[&str]) -> (i32, String, String) {
    let folder = folder();
    write(&folder, "lens.toml", text);
    petzval(folder.path(), &[&["lens", "lens.toml"], options].concat())
}

#[test]
fn a_lens_that_forms_no_image_still_tells_its_data() {
    // The last surface of the file is the film, a hair behind the focus; and a diverging lens.
    let film = biconvex("index = 1.5", "thickness = 49.6\n[[surface]]\ndiameter = 12");
    let diverging = biconvex("index = 1.5", "").replace("radius = 50", "radius = -50");
    for (text, focal) in [(film, "50.5"), (diverging.replace("= -50\ndi", "= 50\ndi"), "-49.5")] {
        for options in [&["--focus", "inf"][..], &[]] {
            let (code, printed, _) = told(&text, options);
            assert_eq!(code, 0, "{options:?}: {printed}");
            for known in ["radius", "focal length", "back focal distance", "exit pupil position"] {
                assert!(printed.contains(known), "{options:?}: no {known} in {printed}");
            }
            let line = printed.lines().find(|line| line.starts_with("focal length")).expect("one");
            assert!(line.contains(focal), "{line}");
            assert!(printed.contains("not known: "), "{options:?}: {printed}");
            assert!(
                printed.contains("no real image") && printed.contains("leave it out"),
                "{printed}"
            );
            assert_ne!(options.is_empty(), printed.contains("  none\n"), "{options:?}: {printed}");
        }
    }
}

#[test]
fn rays_that_all_end_are_said_to() {
    // First-order optics sees an image; all real rays are totally reflected or miss.
    let text =
        biconvex("index = 1.5", "thickness = 1\n[[surface]]\ndiameter = 1\nobstruction = 0.99")
            .replace("diameter = 6", "diameter = 6\nobstruction = 5.9");
    let (code, printed, _) = told(&text, &["--focus", "inf"]);
    assert!(code == 0 && printed.contains("no ray from a point on the axis"), "{printed}");
    let film = |name: &str| printed.lines().find(|line| line.starts_with(name)).expect("a line");
    let none = ["film distance   ", "film distance, real rays"].map(|n| film(n).contains("none"));
    assert_eq!(none, [false, true], "{printed}");
}

#[test]
fn a_focus_that_is_too_near_stays_an_error() {
    let (code, _, said) = told(&biconvex("index = 1.5", ""), &["--focus", "10"]);
    assert!(code == 2 && said.contains("the nearest it can is"), "{said}");
}

/// A table of germanium for 8 to 12 um.
const GERMANIUM: &str = "index = [[8000, 4.0053], [10000, 4.0032], [12000, 4.0023]]";

#[test]
fn glass_in_light_that_its_data_do_not_cover_is_named_with_both_ranges() {
    let of = |medium: &str, used| parsed(&biconvex(medium, "")).doubtful_indices(used);
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
            "says nothing of dispersion but the index at 587.6 nm; at 500 to 600 nm",
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
        let said = of(medium, used);
        assert!(said.len() == 1 && said[0].contains(expected), "{medium}: {said:?}");
    }
    for (medium, used) in [
        (GERMANIUM, [8000.0, 12000.0]),
        ("index = [[587.6, 1.5]]", d),
        ("index = 1.9", d),
        ("glass = \"N-BK7\"", [400.0, 704.0]),
        ("index = 1.5\nabbe = 60", [400.0, 704.0]),
    ] {
        let said = of(medium, used);
        assert!(said.is_empty(), "{medium}: {said:?}");
    }
}

#[test]
fn lens_trace_plan_and_render_warn_alike() {
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
    let runs: [&[&str]; 4] = [
        &["lens", "ge.toml"],
        &["lens", "trace", "ge.toml", "--rays", "rays.csv"],
        &["plan", "scene.pbrt"],
        &["render", "scene.pbrt", "-o", "out.exr"],
    ];
    for arguments in runs {
        let (code, _, said) = petzval(folder.path(), arguments);
        let warning = "behind surface 2 the table of indices covers 8000 to 12000 nm; at 587.6 ";
        assert!(code == 0 && said.contains(warning), "{arguments:?}: {said}");
        assert_eq!(said.matches(warning).count(), 1, "{arguments:?}: {said}");
    }
}

#[test]
fn lenses_of_the_repository_are_used_in_light_that_their_data_cover() {
    for lens in ["dgauss.50mm.dat", "triplet.toml", "phone.toml", "anamorphic.toml"] {
        let (code, printed, said) = petzval(root(), &["lens", &format!("lenses/{lens}")]);
        assert!(code == 0 && !said.contains("warning"), "{said}");
        let line = printed.lines().find(|line| line.starts_with("wavelength")).expect("one");
        let constant = lens.ends_with(".dat");
        assert_eq!(line.contains("says nothing of dispersion"), constant, "{line}");
    }
}
