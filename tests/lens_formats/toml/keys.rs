//! Meaning and defaults of keys.

use std::fmt::Write as _;
use std::path::Path;

use petzval_image::Picture;
use petzval_lens::{ApertureMask, Coating, Iris, MaskConvention, Row, TransverseAxis};
use petzval_lens_formats::read;
use petzval_spectrum::{D_LINE, Glass, find_glass};

use super::{by_line, parsed, singlet, stopped};
use crate::support::{LENSES, folder, lens, write, write_picture};

fn iris(keys: &str) -> Iris {
    stopped(keys).unwrap().rows[2].iris.clone()
}

#[test]
fn every_key_is_read() {
    let lens = parsed(
        "name = \"All\"\nsource = \"a test\"\nfocal_length = 50\nf_number = 2.8\n\
         [[surface]]\nradius = 30\nthickness = -2.5\ndiameter = 8\nindex = 1.5\nabbe = 60\n\
         conic = -0.5\nasphere = [[4, 1e-5], [5, -2e-6]]\ncoating = \"MgF2\"\nobstruction = 2\n\
         [[surface]]\nradius = -inf\ndiameter = 0x10\naxis = \"y\"\n\
         [[surface]]\nradius = 0\ndiameter = 6\nstop = true\n",
    )
    .unwrap();
    assert_eq!(lens.name, "All");
    assert_eq!(lens.source.as_deref(), Some("a test"));
    assert_eq!(lens.stated_focal_length, Some(50.0));
    assert_eq!(lens.stated_f_number, Some(2.8));
    let first = Row {
        radius: 30.0,
        thickness: -2.5,
        diameter: 8.0,
        index: 1.5,
        glass: Glass::Abbe { nd: 1.5, vd: 60.0 },
        conic: -0.5,
        asphere: vec![(4, 1e-5), (5, -2e-6)],
        coating: Some(Coating::Mgf2),
        obstruction: 2.0,
        ..Row::default()
    };
    let second = Row { diameter: 16.0, axis: Some(TransverseAxis::Y), ..Row::default() };
    let stop = Row { diameter: 6.0, stop: true, ..Row::default() };
    assert_eq!(lens.rows[..], [first, second, stop]);
}

#[test]
fn missing_keys_have_defaults() {
    let lens = singlet("diameter = 8").unwrap();
    assert_eq!(lens.name, "test");
    assert_eq!((lens.source, lens.stated_focal_length, lens.stated_f_number), (None, None, None));
    assert_eq!(lens.rows[0], Row { diameter: 8.0, ..Row::default() });
}

#[test]
fn the_course_lenses_are_the_same_in_both_formats() {
    for (name, _) in LENSES {
        let dat = lens(name);
        let mut text = format!("name = \"{}\"\n", dat.name);
        for row in &dat.rows {
            let Row { radius, thickness, index, diameter, stop, .. } = row;
            let _ = write!(
                text,
                "[[surface]]\nradius = {radius:?}\nthickness = {thickness:?}\nindex = {index:?}\n\
                 diameter = {diameter:?}\nstop = {stop}\n"
            );
        }
        assert_eq!(parsed(&text).unwrap(), dat, "{name}");
    }
}

#[test]
fn a_glass_name_gives_index_and_dispersion() {
    let row = &singlet("diameter = 8\nglass = \"schott n-bk7\"").unwrap().rows[0];
    assert_eq!(row.glass, Glass::Catalogue(find_glass("N-BK7").unwrap()));
    // The published value, to its rounding.
    assert!((row.index - 1.5168).abs() < 1e-5);
    assert_eq!(row.glass.index(1.0, D_LINE), Ok(row.index));
    // The e, F' and g lines of Schott's data sheet.
    for (nm, n) in [(546.0740, 1.51872), (479.9914, 1.52283), (435.8343, 1.52668)] {
        assert!((row.glass.index(1.0, nm).unwrap() - n).abs() < 1e-5, "{nm}");
    }
}

#[test]
fn a_table_of_indices_is_sorted_and_gives_the_index_at_the_d_line() {
    let row = &singlet("diameter = 8\nindex = [[700, 1.51], [450, 1.53], [587.5618, 1.52]]")
        .unwrap()
        .rows[0];
    assert_eq!(row.index, 1.52);
    assert_eq!(row.glass, Glass::Table([[450.0, 1.53], [D_LINE, 1.52], [700.0, 1.51]].into()));
    let alone = &singlet("diameter = 8\nindex = [[500, 1.6]]").unwrap().rows[0];
    assert_eq!((alone.index, alone.glass.disperses()), (1.6, false));
}

#[test]
fn a_stop_is_in_the_medium_before_it_by_default() {
    let cemented = |stop: &str| {
        parsed(&format!(
            "[[surface]]\nradius = 30\ndiameter = 8\nglass = \"F2\"\n\
             [[surface]]\nstop = true\ndiameter = 6\n{stop}\n[[surface]]\ndiameter = 8\n"
        ))
    };
    let silent = cemented("").unwrap();
    assert_eq!(silent.rows[1].index, silent.rows[0].index);
    assert_eq!(silent.rows[1].glass, silent.rows[0].glass);
    assert_eq!(cemented("glass = \"F2\"").unwrap(), silent);
    // With another medium the plane stop refracts.
    for (keys, index) in [("glass = \"SF6\"", 1.80518), ("index = 1", 1.0)] {
        assert!((cemented(keys).unwrap().rows[1].index - index).abs() < 1e-5, "{keys}");
    }
}

#[test]
fn a_stop_may_be_a_glass_surface() {
    let lens = parsed(
        "[[surface]]\nradius = 30\ndiameter = 8\nstop = true\nglass = \"F2\"\n\
         [[surface]]\ndiameter = 8\n",
    )
    .unwrap();
    assert_eq!(lens.stop(), 0);
    assert_eq!(lens.rows[0].radius, 30.0);
    assert!(lens.rows[0].index > 1.6);
    // A single surface is a lens too, and so is an aspheric plate.
    assert!(parsed("[[surface]]\nradius = 9\ndiameter = 8\nstop = true\nindex = 1.5").is_ok());
    let plate = "[[surface]]\nasphere = [[4, 1e-4]]\ndiameter = 8\nstop = true\nindex = 1.5";
    assert_eq!(parsed(plate).unwrap().rows[0].index, 1.5);
}

#[test]
fn the_iris_has_blades_or_a_shape() {
    assert_eq!(iris(""), Iris::Round);
    assert_eq!(iris("aperture = \"circular\""), Iris::Round);
    assert_eq!(iris("blades = 6"), Iris::Blades { count: 6, rotation: 0.0, curvature: 0.0 });
    assert_eq!(
        iris("blades = 7\nrotation = -15.5\ncurvature = 0.25"),
        Iris::Blades { count: 7, rotation: -15.5, curvature: 0.25 }
    );
    for name in ["gaussian", "square", "pentagon", "star"] {
        let mask = ApertureMask::named(name).unwrap();
        assert_eq!(mask.transmission.len(), mask.size * mask.size);
        assert_eq!(iris(&format!("aperture = \"{name}\"")), Iris::Mask(mask));
    }
}

/// Writes a picture of one row per entry.
fn picture(path: &Path, size: [usize; 2], pixels: Vec<[f32; 3]>) {
    write_picture(&Picture { size, pixels }, path);
}

#[test]
fn a_picture_beside_the_lens_is_an_aperture() {
    let folder = folder();
    let lens = |picture: &str| {
        let text = format!(
            "[[surface]]\nradius = 30\ndiameter = 8\nindex = 1.5\n[[surface]]\ndiameter = 8\n\
             [[surface]]\nstop = true\ndiameter = 6\naperture = \"{picture}\"\n"
        );
        read(&write(&folder, "masked.toml", text))
    };
    let nan = f32::NAN;
    let pixels = vec![[0.25, 0.5, 0.75], [9.0; 3], [-1.0; 3], [nan, 1.0, 1.0]];
    picture(&folder.path().join("mask.exr"), [2, 2], pixels);
    let expected = [0.5, 1.0, 0.0, 0.0].into();
    let mask = ApertureMask {
        name: "mask.exr".into(),
        size: 2,
        transmission: expected,
        convention: MaskConvention::Physical,
        is_shape: false,
    };
    assert_eq!(lens("mask.exr").unwrap().rows[2].iris, Iris::Mask(mask));

    picture(&folder.path().join("wide.png"), [2, 1], vec![[1.0; 3]; 2]);
    picture(&folder.path().join("black.png"), [2, 2], vec![[0.0; 3]; 4]);
    write(&folder, "broken.png", "no picture");
    for (name, expected) in [
        ("wide.png", "it has 2 x 1 pixels; an aperture is square"),
        ("black.png", "it is black"),
        ("broken.png", "cannot read the picture"),
        ("missing.png", "cannot read the picture"),
    ] {
        let error = lens(name).unwrap_err().to_string();
        assert!(
            by_line(&error).contains("masked.toml:10: ") && error.contains(expected),
            "{error}"
        );
    }
}

#[test]
fn the_extension_chooses_the_reader() {
    let folder = folder();
    let toml = "[[surface]]\nradius = 9\ndiameter = 8\nstop = true\nindex = 1.5\n";
    let dat = "10 2 1.5 8\n-30 1 1 8\n0 1 0 6\n";
    for name in ["a.toml", "b.TOML"] {
        assert_eq!(read(&write(&folder, name, toml)).unwrap().rows.len(), 1, "{name}");
    }
    for name in ["a.dat", "a.txt", "a"] {
        assert_eq!(read(&write(&folder, name, dat)).unwrap().rows.len(), 3, "{name}");
    }
    let error = read(&write(&folder, "c.toml", dat)).unwrap_err().to_string();
    assert!(by_line(&error).contains("c.toml:1: "), "{error}");
    let windows = toml.replace('\n', "\r\n");
    assert!(read(&write(&folder, "d.toml", format!("\u{feff}{windows}"))).is_ok());
}
