//! Lens files in the .dat format: accepted forms, and the errors of the others.

use std::path::Path;

use crate::support::{LENSES, folder, lens, write};
use petzval_base::io::ReadContext;
use petzval_lens::{LensError, Prescription};
use petzval_lens_formats::{parse_dat, read, read_with};

fn parsed(text: &str) -> Result<Prescription, LensError> {
    let lines: Vec<&str> = text.lines().collect();
    parse_dat(Path::new("test.dat"), &lines)
}

const GOOD: &str = "# a lens\n10 2 1.5 8\n-30 1 1 8 # trailing words\n0 1 0 6\n-20 0 1 8\n";

#[test]
fn both_column_conventions_give_the_same_lens() {
    let after = parsed("10 2 1.5 8\n-30 1 1 8\n0 3 0 6\n20 4 1.6 8\n-20 0 1 8").unwrap();
    let before = parsed("10 0 1.5 8\n-30 2 1 8\n0 1 0 6\n20 3 1.6 8\n-20 4 1 8").unwrap();
    assert_eq!(after, before);
    let thicknesses: Vec<f64> = after.rows.iter().map(|row| row.thickness).collect();
    assert_eq!(thicknesses, [2.0, 1.0, 3.0, 4.0, 0.0]);
    // Files of pbrt give the distance to the film in the last row.
    let to_film = parsed("10 2 1.5 8\n-30 1 1 8\n0 3 0 6\n20 4 1.6 8\n-20 40 1 8").unwrap();
    assert_eq!(to_film.rows[..4], after.rows[..4]);
}

#[test]
fn a_lens_in_memory_is_read_like_its_file() {
    let folder = folder();
    let file = read(&write(&folder, "good.dat", GOOD)).unwrap();
    let context = ReadContext::default()
        .with_lens("earlier".into(), *b"")
        .with_lens("good".into(), GOOD.as_bytes());
    // A context for data that is dropped after use has it, too.
    let context = context.temporary();
    assert_eq!(read_with("good".as_ref(), &context).unwrap(), file);
    let inputs: Vec<_> =
        context.files().iter().map(|(path, digest)| (path.to_owned(), digest.is_some())).collect();
    assert_eq!(inputs, [("good".into(), true)]);
    let broken = context.with_lens("good".into(), *b"10 2 1.5\n");
    let error = read_with("good".as_ref(), &broken).unwrap_err().to_string();
    assert!(error.starts_with("good:1:"), "{error}");
    assert!(matches!(read_with("earlier".as_ref(), &broken), Err(LensError::Io { .. })));
}

#[test]
fn the_stop_is_in_air_unless_its_row_has_an_index() {
    let lens = parsed(GOOD).unwrap();
    assert_eq!(lens.stop(), 2);
    assert_eq!(lens.rows[2].index, 1.0);
    assert!(lens.rows[2].radius.is_infinite());
    let inside = parsed("10 2 1.5 8\n0 1 1.5 6\n-30 1 1 8").unwrap();
    assert_eq!(inside.rows[1].index, 1.5);
}

#[test]
fn malformed_rows_are_refused_with_their_line() {
    let cases = [
        ("10 2 1.5 8\n-30 one 1 8\n0 0 0 6", "test.dat:2: \"one\" is not a finite number"),
        ("10 2 1.5 8\n-30 nan 1 8\n0 0 0 6", "test.dat:2: \"nan\" is not a finite number"),
        ("10 2 1.5 8\n-30 1e999 1 8\n0 0 0 6", "test.dat:2: \"1e999\" is not a finite number"),
        ("10 2 1.5\n0 1 0 6\n-30 0 1 8", "test.dat:1: 3 columns; expected four"),
        ("10 2 1.5 8 9\n0 1 0 6\n-30 0 1 8", "test.dat:1: 5 columns; expected four"),
        ("10 2 1.5 8\n-30 0 1 8", "test.dat:2: the table ends without a stop"),
        ("10 2 1.5 8\n-3 1 1 6\n0 1 0 6\n\n0 1 0 6\n9 0 1 8", "test.dat:5: a second stop"),
        ("10 2 1.5 -8\n0 1 0 6\n-30 0 1 8", "test.dat:1: diameter -8"),
        ("10 2 1.5 0\n0 1 0 6\n-30 0 1 8", "test.dat:1: diameter 0"),
        ("10 2 0.9 8\n0 1 0 6\n-30 0 1 8", "test.dat:1: index 0.9"),
        ("10 2 1.5 8\n-30 1 0 8\n0 1 0 6", "test.dat:2: index 0"),
        ("10 2 1.5 8\n-3 1 1 6.1\n0 0 0 6", "test.dat:2: diameter 6.1 on a sphere of radius -3"),
        ("", "test.dat:1: no surface in the file"),
        ("# only words\n", "test.dat:1: no surface in the file"),
        ("0 0 0 5", "test.dat:1: a stop without any glass"),
    ];
    for (text, expected) in cases {
        let error = parsed(text).expect_err(text).to_string();
        assert!(error.starts_with(expected), "{text:?}\n  found    {error}\n  expected {expected}");
    }
}

#[test]
fn an_endless_line_is_refused_before_it_fills_the_memory() {
    let folder = folder();
    let path = write(&folder, "long.dat", "");
    // A sparse file: a gigabyte of zero bytes behind one good line.
    let file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    std::io::Write::write_all(&mut &file, b"10 2 1.5 8\n").unwrap();
    file.set_len(1 << 30).unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(error.contains("long.dat:2: the file is larger than 1 MiB"), "{error}");
}

#[test]
fn the_error_for_a_missing_file_names_it() {
    let error = read(Path::new("no/such.dat")).unwrap_err().to_string();
    assert!(error.starts_with("cannot read the lens no/such.dat: "), "{error}");
}

#[test]
fn random_bytes_do_not_panic() {
    let good = GOOD.as_bytes();
    let mut random = crate::support::Random::new(3);
    for _ in 0..20_000 {
        let mut bytes = good.to_vec();
        for _ in 0..3 {
            let i = (random.next() * bytes.len() as f64) as usize;
            bytes[i] = (random.next() * 256.0) as u8;
        }
        let text = String::from_utf8_lossy(&bytes).into_owned();
        // First-order optics must accept every lens that the reader accepts.
        if let Ok(lens) = parsed(&text) {
            let _ = petzval_lens::Paraxial::new(&lens);
        }
    }
}

#[test]
fn the_repository_holds_the_four_course_lenses() {
    // Number of surfaces, and sums of radii, thicknesses and diameters as checksums of the tables.
    let facts = [
        ("dgauss.50mm", 11, 590.325, 32.04, 228.5),
        ("fisheye.10mm", 12, 151.1369, 33.4461, 135.72),
        ("telephoto.250mm", 7, 206.4825, 102.78, 276.0),
        ("wide.22mm", 13, -122.48764, 33.37114, 164.912),
    ];
    for ((name, _), (fact, rows, radii, distances, diameters)) in LENSES.iter().zip(facts) {
        assert_eq!(*name, fact);
        let lens = lens(name);
        let sum = |f: fn(&petzval_lens::Row) -> f64| lens.rows.iter().map(f).sum::<f64>();
        let radius = |row: &petzval_lens::Row| if row.stop { 0.0 } else { row.radius };
        assert_eq!(lens.rows.len(), rows);
        assert!((sum(radius) - radii).abs() < 1e-3, "{name}: radii {}", sum(radius));
        assert!((lens.length() - distances).abs() < 1e-3, "{name}: length {}", lens.length());
        assert!((sum(|r| r.diameter) - diameters).abs() < 1e-3, "{name}: diameters");
    }
}

#[test]
fn a_number_alone_before_the_rows_is_the_focal_length() {
    let rows = parsed(GOOD).unwrap().rows;
    for first in ["50.000\t\t", "  50 # mm", "# focal length\n\n50"] {
        let lens = parsed(&format!("{first}\n{GOOD}")).expect(first);
        assert_eq!(lens.stated_focal_length, Some(50.0), "{first:?}");
        assert_eq!(lens.rows, rows);
    }
    assert_eq!(parsed(GOOD).unwrap().stated_focal_length, None);
    // Other programs write the number of rows there.
    let counted = parsed(&format!("4 # lens size\n{GOOD}")).unwrap();
    assert_eq!((counted.stated_focal_length, counted.rows), (None, rows));
    for (text, expected) in [
        ("0\n10 2 1.5 8\n0 1 0 6\n-30 0 1 8", "test.dat:1: a focal length of 0"),
        ("50\n60\n10 2 1.5 8\n0 1 0 6\n-30 0 1 8", "test.dat:2: 1 column; expected four"),
        ("10 2 1.5 8\n50\n0 1 0 6\n-30 0 1 8", "test.dat:2: 1 column; expected four"),
        ("50", "test.dat:1: no surface in the file"),
    ] {
        let error = parsed(text).expect_err(text).to_string();
        assert!(error.starts_with(expected), "{text:?}\n  found    {error}");
    }
}

#[test]
fn a_byte_order_mark_is_skipped() {
    let folder = folder();
    let path = write(&folder, "marked.dat", "\u{feff}10 2 1.5 8\n-30 1 1 8\n0 1 0 6\n-20 0 1 8\n");
    assert_eq!(read(&path).unwrap().rows, parsed(GOOD).unwrap().rows);
}

#[test]
fn foreign_files_are_recognised_and_the_error_says_what_to_do() {
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 1234\n";
    let cases: [(&str, Vec<u8>, &str, &str); 5] = [
        ("a.dat", pointer.into(), ":1:1: a Git LFS pointer", "git lfs pull"),
        ("a.toml", pointer.into(), ":1:1: a Git LFS pointer", "git lfs pull"),
        ("a.json", "\n {\"surfaces\": [1, 2]}".into(), ":2:16: no \"radius\"", "expected a member"),
        ("a.dat", "[\n  {\"radius\": 3}\n]".into(), ":1:1: JSON without a lens", "ISET"),
        ("a.dat", "<!DOCTYPE html>\n<html>".into(), ":1:1: a web page", "download"),
    ];
    for (name, bytes, found, advice) in cases {
        let folder = folder();
        let path = write(&folder, name, &bytes);
        let error = read(&path).expect_err(name).to_string();
        let message =
            error.strip_prefix(&path.display().to_string()).expect("it begins with the file");
        assert!(message.starts_with(found) && message.contains(advice), "{name}: {message}");
        let (code, _, _) = crate::support::petzval(folder.path(), &["lens", name]);
        assert_eq!(code, 2, "{name}");
    }
}

#[test]
fn a_lens_in_toml_is_read_by_its_content_whatever_its_name() {
    let text = "# mine\n[[surface]]\nradius = 30\ndiameter = 8\nindex = 1.5\n[[surface]]\nstop = true\n\
                diameter = 6\n";
    let folder = folder();
    let expected = read(&write(&folder, "a.toml", text)).expect("a lens");
    for name in ["a.dat", "a.txt", "a"] {
        assert_eq!(read(&write(&folder, name, text)).expect(name).rows, expected.rows, "{name}");
    }
    let wrong = text.replace("index = 1.5", "index = 0.5");
    let error = read(&write(&folder, "b.dat", &wrong)).expect_err("no index").to_string();
    assert!(error.contains("b.dat:5:9: index 0.5"), "{error}");
}
