//! Errors of foreign lens files: place, finding and remedy; and what --approximate leaves out.

use petzval_base::io::ReadContext;
use petzval_lens_formats::{read, read_with};

use super::{BENCH, CSV, DEEPLENS, DIFF_OPTICS, FX, GEOPTER, ISET, approximated, optiland, parsed};
use crate::support::{folder, write};

#[test]
fn errors_name_line_and_column() {
    let optiland = optiland();
    let cases: [(&str, &str, &str, &str, &str); 17] = [
        ("a.txt", BENCH, "-60\t2", "-60\td2", ":9:7: a thickness \"d2\" without a value"),
        ("a.txt", BENCH, "-60", "x60", ":9:3: \"x60\" is not a finite number"),
        ("a.txt", BENCH, "1.6\t", "0.6\t", ":8:8: index 0.6"),
        ("a.txt", BENCH, "[constants]", "[constants]\nAsphericalX", ":4:1: an unknown form"),
        ("a.fx", FX, "-60 2", "-60 d2", ":6:5: a thickness \"d2\" without a value"),
        ("a.fx", FX, "-60 2 1 10 0 AIR SPHERICAL", "-60", ":6:1: 1 columns, and no thickness"),
        ("a.fx", FX, "0 AIR SPHERICAL\n0", "0 AIR TORIC\n0", ":6:18: the geometry \"TORIC\""),
        ("a.json", ISET, "-60", "[-60, 60, 1]", ":3:16: 3 numbers"),
        ("a.json", ISET, "\"ior\": 1.6", "\"ior\": [[1, 2]]", ":2:43: a list of 1 values"),
        ("a.json", ISET, "-60", "1e-9", ":3:16: radius 1e-9"),
        ("a.json", DEEPLENS, "1.6/60", "1.6/x", ":2:57: an unknown glass \"1.6/x\""),
        ("a.json", DEEPLENS, "Aspheric", "Cubic", ":6:14: a surface of the type \"Cubic\""),
        ("a.json", GEOPTER, "1.6:60", "GLASSY", ":3:43: an unknown glass \"GLASSY\""),
        ("a.json", &optiland, "\"z\": 6", "\"rx\": 1, \"z\": 6", ":4:135: a tilted"),
        ("a.csv", CSV, "-60;2", "-60;two", ":3:5: \"two\" is not a finite number"),
        ("a.txt", DIFF_OPTICS, "S 6", "B 6", ":5:1: a surface of the type \"B\""),
        ("a.txt", DIFF_OPTICS, "S 6 -60 20 AIR", "S 6 -60", ":5:1: 3 columns"),
    ];
    for (name, text, good, bad, expected) in cases {
        assert!(text.contains(good), "{good}");
        let error = parsed(name, &text.replacen(good, bad, 1)).expect_err(bad).to_string();
        assert!(error.contains(expected), "{bad}\n  found    {error}\n  expected {expected}");
    }
}

#[test]
fn features_that_are_not_simulated_are_left_out_only_on_request() {
    for (text, good, bad, note) in [
        (
            ISET,
            "{\"name\"",
            "{\"microlens\": {\"a\": 1}, \"name\"",
            "line 1: an array of microlenses",
        ),
        (DEEPLENS, "\"Aspheric\"", "\"Cubic\"", "line 6: a surface of the type \"Cubic\""),
    ] {
        let text = text.replacen(good, bad, 1);
        let error = parsed("a.json", &text).expect_err(note).to_string();
        assert!(error.contains("is not simulated") && error.contains("'approximate'"), "{error}");
        let lens = approximated("a.json", &text).expect(note);
        assert_eq!(
            lens.design.notes,
            [format!("{note} is not simulated; the lens is read without it")]
        );
    }
}

#[test]
fn two_radii_of_iset_are_a_biconic() {
    let text = ISET.replacen("-60", "[60, -60]", 1);
    let [x, y] = parsed("a.json", &text).expect("a biconic").rows[1].curvatures();
    assert!((x - 1.0 / 60.0).abs() < 1e-15 && (y + 1.0 / 60.0).abs() < 1e-15, "{x} {y}");
    let same = ISET.replacen("-60", "[-60, -60]", 1);
    let expected = parsed("a.json", ISET).expect("a lens").rows;
    assert_eq!(parsed("a.json", &same).expect("a lens").rows, expected);
}

/// A catalogue with one glass: n^2 = 4 at all wavelengths.
const CATALOGUE: &str = "CC mine\nNM MYGLASS 1 0 2.0 50 0 1\nCD 4 0 0 0 0 0\nLD 0.3 2.5\n";

#[test]
fn every_reader_knows_the_glasses_of_the_users_catalogue() {
    let folder = folder();
    let catalogue = write(&folder, "mine.agf", CATALOGUE);
    let context = ReadContext::default().with_catalogues([catalogue]);
    for (name, text) in [
        ("a.json", DEEPLENS.replacen("1.6/60", "MYGLASS", 1)),
        ("b.json", GEOPTER.replacen("1.6:60", "MYGLASS", 1)),
        ("a.txt", DIFF_OPTICS.replacen("1.6/60", "MYGLASS", 1)),
        ("a.csv", CSV.replacen("X1;1.6;60", "MYGLASS;;", 1)),
    ] {
        let path = write(&folder, name, &text);
        let error = read(&path).expect_err(name).to_string();
        assert!(error.contains("MYGLASS"), "{name}: {error}");
        let lens = read_with(&path, &context).expect(name);
        assert!((lens.rows[0].index - 2.0).abs() < 1e-12, "{name}");
    }
}
