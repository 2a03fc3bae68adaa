//! Lens files of optical-design programs: one lens in three formats, what is refused, and damage.

#[path = "../support/mod.rs"]
mod support;

use petzval::io::ReadContext;
use petzval::lens::{LensError, Paraxial, Prescription, read, read_with};
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
        ("a.zmx", ZMX.replace("  STOP", "  SQAP 3 4 0"), ":14:3: the aperture SQAP of surface 1"),
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
