//! Errors in keys and files.

use petzval_lens::Paraxial;
use petzval_lens_formats::read;

use super::{by_line, parsed, singlet, stopped};
use crate::support::{Random, folder, root, write};

#[test]
fn errors_name_line_and_column() {
    for (text, expected) in [
        ("surface = 3", "test.toml:1:11: surface is not a list"),
        ("\n  f_number = 0", "test.toml:2:14: f_number is 0"),
        ("name = \"\u{e9}\u{e9}\"; x = 1", "test.toml:1:12: "),
        ("[[surface]]\nradius = [1, 2]", "test.toml:2:10: radius is an array"),
        ("[[surface]]\ndiameter = 5\n   radus = 1", "test.toml:3:4: unknown key"),
        ("[[surface]]\ndiameter = 5", "test.toml:2:13: the lens ends without a stop"),
    ] {
        let error = parsed(text).expect_err(text).to_string();
        assert!(error.starts_with(expected), "{text:?}: {error}, not {expected}");
    }
}

#[test]
fn malformed_keys_are_refused_with_their_line() {
    let long = "x".repeat(100);
    let cases = [
        ("", "1: no surface in the file; expected [[surface]]"),
        ("# only words\n", "1: no surface in the file"),
        ("surface = 3", "1: surface is not a list"),
        ("surface = []", "1: surface is not a list"),
        ("surface = [\n 3]", "2: a surface without keys"),
        ("name = \"a\"\n[surface]\nradius = 3", "2: surface is not a list"),
        ("name = 3", "1: name is a number; expected a string"),
        ("\nf_number = 0", "2: f_number is 0; expected a number above 0"),
        ("focal_length = nan", "1: focal_length is nan"),
        ("focal_lenght = 5", "1: unknown key \"focal_lenght\"; did you mean \"focal_length\"?"),
        ("[[surfaces]]\nradius = 3", "1: unknown key \"surfaces\"; did you mean \"surface\"?"),
        ("name = \"a\"\nname = \"b\"", "2: duplicate key; expected TOML"),
        ("10 2 1.5 8\n", "1: "),
        ("[[surface]]\nradius =\n", "2: "),
        ("[[surface]]\nradius = 10 mm\n", "2: "),
        ("[[surface]]\ndiameter = 5\n\n[[surface]]\ndiameter = 5\n", "5: the lens ends without"),
        ("[[surface]]\ndiameter = 5\nstop = true\n", "1: a stop without any glass"),
        (
            "[[surface]]\nindex = 1.5\nradius = 9\ndiameter = 5\nstop = true\n\n\
             [[surface]]\nstop = true\ndiameter = 5\nindex = 1.5",
            "8: a second stop; a lens has one",
        ),
    ];
    for (text, expected) in cases {
        let error = parsed(text).expect_err(text).to_string();
        let expected = format!("test.toml:{expected}");
        assert!(
            by_line(&error).starts_with(&expected),
            "{text:?}\n  found    {error}\n  expected {expected}"
        );
    }
    // Keys of a surface. The first key is in line 2.
    let cases = [
        ("", "1: a surface without diameter"),
        ("\nradius = 5", "1: a surface without diameter"),
        ("diameter = 8\nradus = 3", "3: unknown key \"radus\"; did you mean \"radius\"?"),
        ("diameter = 8\nthikness = 3", "3: unknown key \"thikness\"; did you mean \"thickness\"?"),
        ("glas = 'F2'\ndiameter = 8\nxyzzy = 3", "2: unknown key \"glas\"; did you mean \"glass\""),
        ("diameter = 8\nxyzzy = 3", "3: unknown key \"xyzzy\"; known are radius, thickness"),
        ("diameter = 0", "2: diameter is 0; expected the full clear diameter"),
        ("diameter = -8", "2: diameter is -8"),
        ("diameter = inf", "2: diameter is inf"),
        ("diameter = '8'", "2: diameter is a string; expected a number"),
        ("diameter = 1e999", "2: diameter is inf"),
        ("diameter = 8\nradius = nan", "3: radius is nan"),
        ("diameter = 8\nthickness = inf", "3: thickness is inf"),
        ("diameter = 8\nradius = [3]", "3: radius is an array"),
        ("diameter = 8.1\nradius = -4", "2: diameter 8.1 on a radius of -4; a clear diameter"),
        ("diameter = 8\nradius = 4.5\nconic = 1", "2: diameter 8 on a radius of 4.5; a conic"),
        ("diameter = 8\nindex = 0.9", "3: index 0.9; expected 1 (air) to 10"),
        ("diameter = 8\nindex = inf", "3: index inf; expected 1 (air) to 10"),
        ("diameter = 8\nindex = []", "3: an empty table of indices"),
        (
            "diameter = 8\nindex = [[500, 1.5],\n[600]]",
            "4: an entry of index is not a pair of finite numbers",
        ),
        ("diameter = 8\nindex = [[500, 1.5],\n[600, 11]]", "4: index 11; expected"),
        ("diameter = 8\nindex = [[0.5, 1.5]]", "3: wavelength 0.5; expected nm"),
        ("diameter = 8\nindex = [[500, 1.5],\n[500, 1.6]]", "4: wavelength 500 is stated twice"),
        ("diameter = 8\nindex = [[500, 1.5]]\nabbe = 50", "4: abbe beside a table"),
        ("diameter = 8\nindex = 1.5\nabbe = 0", "4: abbe is 0; expected 5 to 200"),
        ("diameter = 8\nabbe = 50", "3: abbe without index"),
        ("diameter = 8\nglass = 'F2'\nindex = 1.5", "4: index beside glass"),
        (
            "diameter = 8\nglass = 'LAK22'",
            "3: no glass \"LAK22\" in the catalogue; did you mean \"N-LAK22\"",
        ),
        ("diameter = 8\nglass = 1.5", "3: glass is a number; expected a string"),
        ("diameter = 8\nasphere = [[4, 1e-5], [4.5, 1]]", "3: power 4.5; expected a whole"),
        ("diameter = 8\nasphere = [[1, 1e-5]]", "3: power 1; expected a whole"),
        ("diameter = 8\nasphere = [[31, 1e-5]]", "3: power 31; expected a whole"),
        ("diameter = 8\nasphere = [[4, 1],\n[4, 2]]", "4: power 4 is stated twice"),
        ("diameter = 8\nasphere = 4", "3: asphere is a number; expected [[power"),
        ("diameter = 8\nasphere = [[4, inf]]", "3: an entry of asphere is not a pair of finite"),
        ("diameter = 8\nasphere = [[20, 1e300]]", "3: an asphere with an infinite sag"),
        ("diameter = 8\naxis = 'z'", "3: axis is \"z\"; expected \"x\" or \"y\""),
        ("diameter = 8\naxis = 'x'\nconic = 1", "4: conic and axis on one surface"),
        ("diameter = 8\nasphere = []\naxis = 'x'", "3: asphere and axis on one surface"),
        ("diameter = 8\nobstruction = 8", "3: obstruction is 8; expected 0 to less"),
        ("diameter = 8\nobstruction = -1", "3: obstruction is -1"),
        ("diameter = 8\nstop = 1", "3: stop is a number; expected true or false"),
        ("diameter = 8\nblades = 6", "3: blades on a surface that is not the stop"),
        ("diameter = 8\naperture = 'star'", "3: aperture on a surface that is not the stop"),
        ("diameter = 8\ncoating = true", "3: coating is true; expected a string"),
        (
            "diameter = 8\ncoating = 'mgf'",
            "3: coating is \"mgf\"; did you mean \"mgf2\"?; expected",
        ),
        ("diameter = 8\ncoating = 'mgf2'", "3: mgf2 between indices 1 and 1; leave it out"),
        ("diameter = 8\nradius.a = 3", "3: radius is a table"),
        ("diameter = 8\nradius = 1979-05-27", "3: radius is a datetime"),
        ("diameter = 99999999999999999999\nradius = 3", "2: "),
    ];
    for (keys, expected) in cases {
        let error = singlet(keys).expect_err(keys).to_string();
        let expected = format!("test.toml:{expected}");
        assert!(
            by_line(&error).starts_with(&expected),
            "{keys:?}\n  found    {error}\n  expected {expected}"
        );
    }
    // Keys of the stop. The first key is in line 10.
    let cases = [
        ("blades = 2", "10: blades is 2; expected a whole number from 3 to 64"),
        ("blades = 5.5", "10: blades is 5.5"),
        ("blades = 65", "10: blades is 65"),
        ("rotation = 5", "10: rotation without blades"),
        ("blades = 6\ncurvature = 1.5", "11: curvature is 1.5; expected 0"),
        ("blades = 6\nrotation = inf", "11: rotation is inf"),
        ("blades = 6\naperture = 'star'", "11: aperture beside blades"),
        ("aperture = 'sqare'", "10: aperture is \"sqare\"; did you mean \"square\"?"),
        ("aperture = ''", "10: aperture is \"\""),
        ("aperture = 5", "10: aperture is a number"),
    ];
    for (keys, expected) in cases {
        let error = stopped(keys).expect_err(keys).to_string();
        let expected = format!("test.toml:{expected}");
        assert!(
            by_line(&error).starts_with(&expected),
            "{keys:?}\n  found    {error}\n  expected {expected}"
        );
    }
    let error = singlet(&format!("{long} = 3")).unwrap_err().to_string();
    assert!(error.contains("xxx…xxx") && !error.contains(&long), "{error}");
}

#[test]
fn files_that_are_too_long_or_too_deep_are_refused() {
    let folder = folder();
    let long = "#\n".repeat(1 << 20);
    let error = read(&write(&folder, "long.toml", long)).unwrap_err().to_string();
    assert!(error.contains("long.toml:524289: the file is larger than 1 MiB"), "{error}");
    // Long values of keys that are compared with known names.
    for key in ["glass", "aperture", "axis", "x"] {
        let text = format!("{key} = '{}'", "y".repeat(900_000));
        assert!(singlet(&format!("diameter = 8\n{text}")).is_err());
        assert!(stopped(&text).is_err());
    }
    for (open, close) in [("[", "]"), ("{a=", "}"), ("a.", ""), ("[[", "")] {
        let count = 300_000;
        let text = format!("a = {}1{}", open.repeat(count), close.repeat(count));
        assert!(parsed(&text).is_err());
        assert!(parsed(&open.repeat(count)).is_err());
    }
}

#[test]
fn random_bytes_do_not_panic() {
    let good = std::fs::read(root().join("lenses/phone.toml")).unwrap();
    let mut random = Random::new(5);
    for _ in 0..5_000 {
        let mut bytes = good.clone();
        for _ in 0..3 {
            let i = (random.next() * bytes.len() as f64) as usize;
            bytes[i] = match random.next() {
                share if share < 0.5 => b"0123456789.-=[]#\"\n"[(share * 36.0) as usize],
                _ => (random.next() * 256.0) as u8,
            };
        }
        let text = String::from_utf8_lossy(&bytes);
        // First-order optics must accept every lens that the reader accepts.
        if let Ok(lens) = parsed(&text) {
            let _ = Paraxial::new(&lens);
        }
    }
}
