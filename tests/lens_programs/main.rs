//! Lens files of optical-design programs: one lens in three formats, what is refused, and damage.

#[path = "../support/mod.rs"]
mod support;

use petzval::io::ReadContext;
use petzval::lens::{
    LensError, LensOptions, LensRay, Paraxial, Prescription, Side, read, read_with, sequence,
    trace_one,
};
use support::{folder, write};

const ZMX: &str = include_str!("../fuzz/corpus/lens/singlet.zmx");
const SEQ: &str = include_str!("../fuzz/corpus/lens/singlet.seq");
const OSLO: &str = include_str!("../fuzz/corpus/lens/singlet.len");

fn parsed(name: &str, text: impl AsRef<[u8]>) -> Result<Prescription, LensError> {
    let folder = folder();
    read(&write(&folder, name, text))
}

fn approximated(name: &str, text: &str) -> Prescription {
    let folder = folder();
    let context = ReadContext::default().approximating(true);
    read_with(&write(&folder, name, text), &context).expect("an approximation")
}

fn focal_length(lens: &Prescription) -> f64 {
    Paraxial::new(lens).focal_length
}

/// Focal length of a lens of radii 50 and -50 mm, thickness 5 mm and index 1.5, by the lensmaker's
/// equation.
fn lensmaker() -> f64 {
    let (r1, r2, d, n) = (50.0, -50.0, 5.0, 1.5);
    1.0 / ((n - 1.0) * (1.0 / r1 - 1.0 / r2 + (n - 1.0) * d / (n * r1 * r2)))
}

#[test]
fn one_lens_in_three_formats_has_the_focal_length_of_the_lensmaker() {
    for (name, text) in [("a.zmx", ZMX), ("a.seq", SEQ), ("a.len", OSLO)] {
        let lens = parsed(name, text).expect(name);
        assert!((focal_length(&lens) - lensmaker()).abs() < 1e-9, "{name}");
        assert_eq!((lens.name.as_str(), lens.rows.len(), lens.stop()), ("singlet", 2, 0), "{name}");
        assert_eq!(lens.design.film_distance, Some(49.0), "{name}");
        assert_eq!(lens.design.object_distance, Some(f64::INFINITY), "{name}");
    }
}

#[test]
fn content_decides_and_units_scale_everything() {
    assert!((focal_length(&parsed("a.dat", ZMX).expect("by content")) - lensmaker()).abs() < 1e-9);
    for (name, text, unit) in [
        ("a.zmx", ZMX.replace("UNIT MM", "UNIT IN"), 25.4),
        ("a.seq", SEQ.replace("DIM M", "DIM C"), 10.0),
        ("a.len", OSLO.replace("UNI 1.0", "UNI 25.4"), 25.4),
    ] {
        let lens = parsed(name, text).expect(name);
        assert!((focal_length(&lens) - unit * lensmaker()).abs() < 1e-9 * unit, "{name}");
    }
}

#[test]
fn terms_that_are_not_simulated_are_named_and_noted_if_allowed() {
    let cases = [
        ("a.zmx", ZMX.replace("EVENASPH", "GRINSUR3"), ":15:8: surface 1 of the type GRINSUR3"),
        ("a.zmx", ZMX.replace("  STOP", "  SPID 3 4 0"), ":14:3: the aperture SPID of surface 1"),
        ("a.seq", SEQ.replace("  STO\n", "  STO\n  YTO\n"), ":16:3: the command YTO"),
        ("a.len", OSLO.replace("AST", "AST\nCVX 0.1"), ":15:5: the command CVX"),
    ];
    for (name, text, expected) in cases {
        let error = parsed(name, &text).expect_err(name).to_string();
        assert!(error.contains(expected) && error.contains("--approximate"), "{error}");
        let notes = approximated(name, &text).design.notes;
        assert!(notes.iter().any(|note| note.contains("not simulated")), "{name}: {notes:?}");
    }
    let grating = ZMX.replace("EVENASPH", "DGRATING");
    assert!(parsed("a.zmx", grating).is_ok(), "a grating without lines");
}

#[test]
fn malformed_and_damaged_files_are_errors() {
    let wide: Vec<u8> = ZMX.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(parsed("a.zmx", &wide).is_ok());
    let error = |name: &str, text: &str| parsed(name, text).expect_err(name).to_string();
    assert!(error("a.zmx", &ZMX.replace("CURV 0.02", "CURV x")).contains(":16:8: \"x\""));
    assert!(error("a.zmx", &ZMX.replace("MODE SEQ", "MODE NSC")).contains("MODE SEQ"));
    assert!(error("a.zmx", &ZMX.replace("DISZ 5\n", "DISZ 1e300\n")).contains("thickness"));
    for (name, text) in [("a.zmx", ZMX), ("a.seq", SEQ), ("a.len", OSLO)] {
        for end in 0..text.len() {
            let _ = parsed(name, &text[..end]);
        }
    }
    for end in (0..wide.len()).step_by(7) {
        let _ = parsed("a.zmx", &wide[..end]);
    }
    for (name, head, part) in [
        ("a.zmx", "MODE SEQ\n", "SURF 1\n"),
        ("a.seq", "RDM\n", "S 0 0\n"),
        ("a.len", "LEN NEW \"\" 1 1\n", "NXT\n"),
    ] {
        let many = head.to_owned() + &part.repeat(100_000);
        assert!(error(name, &many).contains("more than 1000 surfaces"), "{name}");
    }
}

/// Reads a singlet whose surface 1 has these lines in place of its own.
fn with_front(lines: &str) -> Prescription {
    let (before, rest) = ZMX.split_once("SURF 1\n").expect("surface 1");
    let (_, behind) = rest.split_once("SURF 2\n").expect("surface 2");
    parsed("a.zmx", format!("{before}SURF 1\n{lines}SURF 2\n{behind}")).expect("a lens")
}

#[test]
fn germanium_has_its_index_in_the_far_infrared_and_none_in_visible_light() {
    let infrared = ZMX
        .replace("WAVM 1 0.5875618 1", "WAVM 1 10.0 1")
        .replace("GLAS ___BLANK 1 0 1.5 60 0", "GLAS GERMANIUM 0 0 1.5 40 0");
    let lens = parsed("a.zmx", &infrared).expect("an infrared lens");
    // Index at 10 um: Icenogle, Platt and Wolfe 1976, Appl. Opt. 15, 2348: 4.0043 at 20 degrees.
    assert!((lens.rows[0].index - 4.004).abs() < 2e-3, "{}", lens.rows[0].index);
    assert_eq!(lens.design.primary_wavelength(), 10_000.0);
    let visible = infrared.replace("WAVM 1 10.0 1", "WAVM 1 0.55 1");
    let error = parsed("a.zmx", &visible).expect_err("opaque").to_string();
    assert!(error.contains("not at 550 nm") && error.contains("--wavelengths"), "{error}");
    let lens = approximated("a.zmx", &visible);
    assert!(lens.design.notes.iter().any(|note| note.contains("nearest end")));
    let folder = folder();
    let path = write(&folder, "a.zmx", &visible);
    let chosen = LensOptions { wavelengths: vec![8e3, 10e3, 12e3], ..LensOptions::default() };
    let lens = chosen.read(&path, &ReadContext::default()).expect("at 10 um");
    assert!((lens.rows[0].index - 4.004).abs() < 2e-3);
}

#[test]
fn an_extended_asphere_counts_its_terms_in_units_of_its_radius() {
    let lens = with_front(
        "  STOP\n  TYPE XASPHERE\n  CURV 0.02\n  XDAT 1 2 0 0\n  XDAT 2 10 0 0\n  XDAT 3 0.5 0 0\n  \
         XDAT 4 -0.25 0 0\n  XDAT 5 9 0 0\n  DISZ 5\n  GLAS ___BLANK 1 0 1.5 60 0\n  DIAM 8 1\n",
    );
    let expected = [(2, 0.5 / 100.0), (4, -0.25 / 1e4)];
    assert_eq!(lens.rows[0].asphere.len(), 2, "the third term is not counted");
    for ((power, a), (expected_power, b)) in lens.rows[0].asphere.iter().zip(expected) {
        assert!(*power == expected_power && (a - b).abs() < 1e-18);
    }
}

#[test]
fn biconics_and_toroids_have_their_radius_along_x() {
    for kind in ["BICONICX", "TOROIDAL"] {
        let lens = with_front(&format!(
            "  STOP\n  TYPE {kind}\n  CURV 0.02\n  PARM 1 25\n  DISZ 5\n  \
             GLAS ___BLANK 1 0 1.5 60 0\n  DIAM 8 1\n"
        ));
        let [x, y] = lens.rows[0].curvatures();
        assert!((x - 0.04).abs() < 1e-15 && (y - 0.02).abs() < 1e-15, "{kind}: {x} {y}");
    }
}

/// Traces the ray along the axis of the scene to the rear vertex: position and direction there.
fn axial_ray(lens: &Prescription) -> ([f64; 3], [f64; 3]) {
    let surfaces = sequence::<f64>(lens, Side::Scene(10.0));
    let start = LensRay::<f64>::new([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let end = trace_one::<f64>(start, &surfaces).expect("passes");
    (end.p, end.t)
}

#[test]
fn a_coordinate_break_moves_all_that_follows() {
    let broken = |parameters: &str, after: &str| {
        let (before, rest) = ZMX.split_once("SURF 1\n").expect("surface 1");
        parsed(
            "a.zmx",
            format!("{before}SURF 1\n  TYPE COORDBRK\n{parameters}  DISZ 0\n{after}SURF 9\n{rest}"),
        )
        .expect("a lens")
    };
    // The lens stands 1 mm higher: the ray meets it below its axis and is bent upwards.
    let (p, t) = axial_ray(&broken("  PARM 2 1\n", ""));
    assert!(p[1] < -0.9 && p[1] > -1.0 && t[1] > 0.01, "{p:?} {t:?}");
    let (p, t) = axial_ray(&broken("  PARM 1 1\n", ""));
    assert!(p[0] < -0.9 && t[0] > 0.01, "{p:?} {t:?}");
    // A lens tilted about x by a positive angle: right-handed, +y turns towards +z. In its axes the
    // ray then goes towards +y.
    let (_, t) = axial_ray(&broken("  PARM 3 2\n", ""));
    assert!(t[1] > 0.0, "{t:?}");
    // A fold by a mirror between two breaks of 45 degrees is no change on the axis.
    let fold = broken(
        "  PARM 3 45\n",
        "SURF 7\n  TYPE STANDARD\n  DISZ 0\n  GLAS MIRROR 0 0\n  DIAM 20 1\nSURF 8\n  TYPE COORDBRK\n  \
         PARM 3 45\n  DISZ -30\n",
    );
    // Behind a mirror the media and spaces of the file are negative.
    assert_eq!(fold.rows[0].thickness, -30.0);
    assert!(fold.rows[0].mirror && fold.is_misaligned());
}

#[test]
fn a_cover_glass_that_touches_the_film_holds_the_film() {
    let (before, _) = ZMX.split_once("SURF 3\n").expect("surface 3");
    let text = format!(
        "{}SURF 3\n  TYPE STANDARD\n  DISZ 1\n  GLAS ___BLANK 1 0 1.5 60 0\n  DIAM 8 1\nSURF 4\n  \
         TYPE STANDARD\n  DISZ 0\n  DIAM 8 1\nSURF 5\n  TYPE STANDARD\n  DISZ 0\n",
        before.replace("DISZ 49", "DISZ 48")
    );
    let lens = parsed("a.zmx", text).expect("a lens");
    assert_eq!((lens.rows.len(), lens.rear().index), (3, 1.5));
    assert_eq!(lens.design.film_distance, Some(1.0));
    assert!(lens.design.notes.iter().any(|note| note.contains("touches the film")));
    // The image distance in air is 1 mm / 1.5 longer than to the cover.
    let behind = Paraxial::new(&lens).back_focal_distance / 1.5 + 48.0;
    let bare = Paraxial::new(&parsed("b.zmx", ZMX).expect("a lens")).back_focal_distance;
    assert!((behind - bare).abs() < 1e-9, "{behind} {bare}");
}

#[test]
fn an_ignored_surface_is_left_out_with_its_space() {
    let ignored =
        "SURF 1\n  TYPE STANDARD\n  IGNR 1\n  CURV 0.1\n  DISZ 7\n  GLAS ___BLANK 1 0 1.7 30 0\n";
    let text = ZMX.replacen("SURF 1\n", &format!("{ignored}SURF 2\n"), 1);
    let lens = parsed("a.zmx", &text).expect("a lens");
    assert_eq!(lens.rows.len(), 2);
    assert!((focal_length(&lens) - lensmaker()).abs() < 1e-9);
    assert_eq!(lens.design.notes, ["surface 1 is ignored, as the file says"]);
    let kept = parsed("a.zmx", text.replace("IGNR 1", "IGNR 0")).expect("a lens");
    assert_eq!(kept.rows.len(), 3);
}

#[test]
fn special_surfaces_and_zoomed_glasses_of_code_v_are_refused_by_name() {
    for (line, part) in [
        ("SPS ODD", "the command SPS ODD of a surface is not simulated"),
        ("GLA NBK7_SCHOTT NSF6_SCHOTT", "a zoomed glass is not simulated"),
    ] {
        let at = SEQ.find("\nSI ").expect("an image");
        let text = format!("{}\n{line}{}", &SEQ[..at], &SEQ[at..]);
        let error = parsed("a.seq", &text).expect_err(line).to_string();
        assert!(error.contains(part), "{error}");
    }
}
