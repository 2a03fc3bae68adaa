//! Lenses in TOML: what every key means, and what is refused with which words.

mod support;

use std::fmt::Write as _;
use std::path::Path;

use petzval::image::{Encoding, Picture, Window};
use petzval::lens::{
    Axis, Coating, Convention, D_LINE, Glass, Iris, LensError, Mask, Paraxial, Prescription, Row,
    catalogue, parse_toml, read,
};
use support::{LENSES, folder, lens, root, write};

fn parsed(text: &str) -> Result<Prescription, LensError> {
    parse_toml(Path::new("test.toml"), text)
}

/// A lens of a singlet with these keys and a stop behind it.
fn singlet(keys: &str) -> Result<Prescription, LensError> {
    parsed(&format!(
        "[[surface]]\n{keys}\n[[surface]]\nradius = -30\nthickness = 1\ndiameter = 8\n\
         [[surface]]\nstop = true\ndiameter = 6\n"
    ))
}

/// A lens of a singlet with a stop of these keys behind it.
fn stopped(keys: &str) -> Result<Prescription, LensError> {
    parsed(&format!(
        "[[surface]]\nradius = 30\ndiameter = 8\nindex = 1.5\n[[surface]]\ndiameter = 8\n\
         [[surface]]\nstop = true\ndiameter = 6\n{keys}\n"
    ))
}

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
        glass: Glass::Abbe { vd: 60.0 },
        conic: -0.5,
        asphere: vec![(4, 1e-5), (5, -2e-6)],
        coating: Some(Coating::Mgf2),
        obstruction: 2.0,
        ..Row::default()
    };
    let second = Row { diameter: 16.0, axis: Some(Axis::Y), ..Row::default() };
    let stop = Row { diameter: 6.0, stop: true, ..Row::default() };
    assert_eq!(lens.rows, [first, second, stop]);
}

#[test]
fn what_is_left_out_has_a_default() {
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
fn a_glass_has_its_index_and_its_dispersion_by_name() {
    let row = &singlet("diameter = 8\nglass = \"schott n-bk7\"").unwrap().rows[0];
    assert_eq!(row.glass, Glass::Catalogue(catalogue("N-BK7").unwrap()));
    // As published, to its rounding.
    assert!((row.index - 1.5168).abs() < 1e-5);
    assert_eq!(row.glass.index(row.index, D_LINE), row.index);
    // The e, F' and g lines of Schott's data sheet.
    for (nm, n) in [(546.0740, 1.51872), (479.9914, 1.52283), (435.8343, 1.52668)] {
        assert!((row.glass.index(row.index, nm) - n).abs() < 1e-5, "{nm}");
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

/// An error without its column.
fn by_line(error: &str) -> String {
    let (place, said) = error.split_once(": ").expect("a place, and what is wrong there");
    let (line, _) = place.rsplit_once(':').expect("a column");
    format!("{line}: {said}")
}

#[test]
fn errors_name_the_column() {
    for (text, expected) in [
        ("surface = 3", "test.toml:1:11: surface is no list"),
        ("\n  f_number = 0", "test.toml:2:14: f_number is 0"),
        ("name = \"\u{e9}\u{e9}\"; x = 1", "test.toml:1:12: "),
        ("[[surface]]\nradius = [1, 2]", "test.toml:2:10: radius is an array"),
        ("[[surface]]\ndiameter = 5\n   radus = 1", "test.toml:3:4: unknown key"),
        ("[[surface]]\ndiameter = 5", "test.toml:2:13: the lens ends without a stop"),
    ] {
        let error = parsed(text).expect_err(text).to_string();
        assert!(error.starts_with(expected), "{text:?} said {error}, not {expected}");
    }
}

#[test]
fn a_stop_stands_in_the_medium_before_it() {
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
    // Another medium makes a plane of it that refracts.
    for (keys, index) in [("glass = \"SF6\"", 1.80518), ("index = 1", 1.0)] {
        assert!((cemented(keys).unwrap().rows[1].index - index).abs() < 1e-5, "{keys}");
    }
}

#[test]
fn a_stop_can_be_a_surface_of_glass() {
    let lens = parsed(
        "[[surface]]\nradius = 30\ndiameter = 8\nstop = true\nglass = \"F2\"\n\
         [[surface]]\ndiameter = 8\n",
    )
    .unwrap();
    assert_eq!(lens.stop(), 0);
    assert_eq!(lens.rows[0].radius, 30.0);
    assert!(lens.rows[0].index > 1.6);
    // One alone is a lens too, and so is an aspheric plate.
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
        let mask = Mask::named(name).unwrap();
        assert_eq!(mask.transmission.len(), mask.size * mask.size);
        assert_eq!(iris(&format!("aperture = \"{name}\"")), Iris::Mask(mask));
    }
}

/// Writes a picture of one row per entry.
fn picture(path: &Path, size: [usize; 2], pixels: Vec<[f32; 3]>) {
    let window = Window { origin: [0, 0], frame: size.map(|n| n as u32) };
    Picture { size, pixels }.write(path, window, Encoding::default(), &Vec::new()).unwrap();
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
    let mask = Mask {
        name: "mask.exr".into(),
        size: 2,
        transmission: expected,
        convention: Convention::Physical,
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
fn what_is_malformed_is_refused_with_its_line() {
    let long = "x".repeat(100);
    let cases = [
        ("", "1: no surface in the file; expected [[surface]]"),
        ("# only words\n", "1: no surface in the file"),
        ("surface = 3", "1: surface is no list"),
        ("surface = []", "1: surface is no list"),
        ("surface = [\n 3]", "2: a surface without keys"),
        ("name = \"a\"\n[surface]\nradius = 3", "2: surface is no list"),
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
            "{text:?}\n  said     {error}\n  expected {expected}"
        );
    }
    // Keys of a surface; its first is in line 2.
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
        ("diameter = 8\nindex = [[500, 1.5],\n[600]]", "4: an entry of index is no pair"),
        ("diameter = 8\nindex = [[500, 1.5],\n[600, 11]]", "4: index 11; expected"),
        ("diameter = 8\nindex = [[0.5, 1.5]]", "3: wavelength 0.5; expected nm"),
        ("diameter = 8\nindex = [[500, 1.5],\n[500, 1.6]]", "4: wavelength 500 a second time"),
        ("diameter = 8\nindex = [[500, 1.5]]\nabbe = 50", "4: abbe beside a table"),
        ("diameter = 8\nindex = 1.5\nabbe = 0", "4: abbe is 0; expected 5 to 200"),
        ("diameter = 8\nabbe = 50", "3: abbe without index"),
        ("diameter = 8\nglass = 'F2'\nindex = 1.5", "4: index beside glass"),
        (
            "diameter = 8\nglass = 'BK7'",
            "3: no glass \"BK7\" in the catalogue; did you mean \"N-BK7\"",
        ),
        ("diameter = 8\nglass = 1.5", "3: glass is a number; expected a string"),
        ("diameter = 8\nasphere = [[4, 1e-5], [4.5, 1]]", "3: power 4.5; expected a whole"),
        ("diameter = 8\nasphere = [[1, 1e-5]]", "3: power 1; expected a whole"),
        ("diameter = 8\nasphere = [[21, 1e-5]]", "3: power 21; expected a whole"),
        ("diameter = 8\nasphere = [[4, 1],\n[4, 2]]", "4: power 4 a second time"),
        ("diameter = 8\nasphere = 4", "3: asphere is a number; expected [[power"),
        ("diameter = 8\nasphere = [[4, inf]]", "3: an entry of asphere is no pair of finite"),
        ("diameter = 8\nasphere = [[20, 1e300]]", "3: a coefficient that leads to infinity"),
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
            "{keys:?}\n  said     {error}\n  expected {expected}"
        );
    }
    // Keys of the stop; the first is in line 10.
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
            "{keys:?}\n  said     {error}\n  expected {expected}"
        );
    }
    let error = singlet(&format!("{long} = 3")).unwrap_err().to_string();
    assert!(error.contains("xxx…xxx") && !error.contains(&long), "{error}");
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

#[test]
fn no_file_is_too_long_or_too_deep() {
    let folder = folder();
    let long = "#\n".repeat(1 << 20);
    let error = read(&write(&folder, "long.toml", long)).unwrap_err().to_string();
    assert!(error.contains("long.toml:524289: the file goes on past 1 MiB"), "{error}");
    // Words that are compared with known ones.
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
fn no_garbage_panics() {
    let good = std::fs::read(root().join("lenses/phone.toml")).unwrap();
    let mut random = support::Random::new(5);
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
        // Whatever is accepted must also be fit for use.
        if let Ok(lens) = parsed(&text) {
            let _ = Paraxial::of(&lens);
        }
    }
}

#[test]
fn the_example_lenses_have_the_focal_lengths_they_state() {
    for (name, f_number) in [("phone", Some(3.5)), ("triplet", Some(5.0)), ("anamorphic", None)] {
        let lens = read(&root().join(format!("lenses/{name}.toml"))).unwrap();
        let paraxial = Paraxial::of(&lens);
        let stated = lens.stated_focal_length.unwrap();
        // The triplet was designed at 550 nm, where it has 50.00 mm; at the d line it has 50.02.
        assert!((paraxial.focal_length / stated - 1.0).abs() < 5e-4, "{name}");
        assert_eq!(lens.stated_f_number, f_number);
        if let Some(f_number) = f_number {
            assert!((paraxial.f_number() - f_number).abs() < 0.01, "{name}");
        }
        assert!(lens.source.is_some());
    }
}

#[test]
fn the_triplet_has_its_focal_length_at_the_wavelength_of_its_design() {
    let lens = read(&root().join("lenses/triplet.toml")).unwrap();
    let green = Paraxial::of(&lens.at_wavelength(550.0)).focal_length;
    assert!((green - 50.0).abs() < 5e-3, "{green}");
}

#[test]
fn the_phone_is_the_one_that_ray_optics_traces() {
    let lens = read(&root().join("lenses/phone.toml")).unwrap();
    let paraxial = Paraxial::of(&lens);
    assert!((paraxial.focal_length - 5.555).abs() < 5e-4);
    assert!((paraxial.back_focal_distance - 0.5678).abs() < 5e-5);
    // Heights and sags of the rays that its gallery lists, to their last digit.
    let traced = [
        (1, 1.0, 0.26119),
        (2, 0.84711, -0.0050525),
        (3, 1.00282, -0.32485),
        (4, 1.26980, -0.29095),
        (5, 1.39140, 0.022842),
        (6, 1.59925, 0.10915),
        (7, 1.70567, 0.25384),
        (8, 1.98752, 0.35893),
    ];
    for (i, height, sag) in traced {
        let ours = lens.rows[i].sag(height);
        assert!((ours - sag).abs() < 1e-5, "surface {i}: {ours} for {sag}");
    }
}

#[test]
fn the_anamorphic_focuses_both_planes_at_one_film() {
    let lens = read(&root().join("lenses/anamorphic.toml")).unwrap();
    let [x, y] = [Axis::X, Axis::Y].map(|plane| Paraxial::in_plane(&lens, plane));
    assert!((y.focal_length / x.focal_length - 4.0 / 3.0).abs() < 1e-3);
    // A thousandth of a millimetre is far below the depth of focus.
    assert!((x.back_focal_distance - y.back_focal_distance).abs() < 1e-3);
}
