//! Conversion of lens files: a round trip is the identity.

use std::path::Path;

use crate::support::{LENSES, folder, lens, petzval, row, write};
use glam::{DAffine3, DMat3, DVec3};
use petzval_lens::{
    Configuration, CoordinateBreak, Design, FieldKind, Fields, Iris, Pose, Prescription, Quantity,
    Setting, SpectralLine, TiltDecenter, TransverseAxis,
};
use petzval_lens_formats::{parse_toml, write_lens};
use petzval_spectrum::{Glass, find_glass};

fn again(lens: &Prescription) -> Prescription {
    let path = Path::new("again.toml");
    let text = write_lens(path, lens).expect("TOML holds every lens").text;
    parse_toml(path, &text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

#[test]
fn every_lens_of_the_repository_survives() {
    for (name, _) in LENSES {
        let lens = lens(name);
        assert_eq!(again(&lens), lens, "{name}");
    }
}

/// Wavelengths, a field and conjugates with many digits.
fn design(third: f64) -> Design {
    Design {
        wavelengths: vec![
            SpectralLine { nm: 486.1, weight: 1.0 },
            SpectralLine { nm: 550.0 + third, weight: third },
        ],
        primary: 1,
        fields: Some(Fields { kind: FieldKind::ImageHeight, points: vec![[0.0, third]] }),
        object_distance: Some(f64::INFINITY),
        film_distance: Some(third),
        ..Design::default()
    }
}

#[test]
fn every_property_survives_with_every_digit() {
    let third = 1.0 / 3.0;
    let mut rows = vec![row(30.0 + third, 2.0 * third, 1.5, 10.0); 7];
    rows[0].asphere = vec![(4, third * 1e-9), (3, -1e-300)];
    rows[0].conic = -third;
    rows[1].axis = Some(TransverseAxis::X);
    rows[1].glass = Glass::Abbe { nd: 1.5, vd: 60.0 + third };
    rows[2] = petzval_lens::Row { mirror: true, index: 1.5, ..rows[1].clone() };
    rows[2].obstruction = third;
    rows[3].glass = Glass::Catalogue(find_glass("N-BK7").expect("listed"));
    rows[4].glass = Glass::Table([[400.0, 1.5 + third], [700.0, 1.4]].into());
    rows[5].stop = true;
    rows[5].radius = f64::INFINITY;
    rows[5].iris = Iris::Blades { count: 7, rotation: third, curvature: 0.5 };
    rows[6].pose = Pose { decentre: [third, 0.0], tilt: [0.0, third] };
    let mut lens =
        Prescription::new("quotes \" and \\ and \u{1} and \u{e9}", rows).expect("a lens");
    lens.source = Some("a patent\nof two lines".into());
    lens.tilt_decenters = vec![TiltDecenter {
        rows: [1, 3],
        pose: Pose { decentre: [0.1, third], tilt: [1.0, 2.0] },
    }];
    let rotation = DMat3::from_rotation_x(0.3) * DMat3::from_rotation_z(third);
    let transform = DAffine3::from_mat3_translation(rotation, DVec3::new(third, 0.0, -1.0));
    lens.breaks =
        vec![CoordinateBreak { row: 3, transform }, CoordinateBreak { row: 7, transform }];
    lens.design = Design {
        configurations: vec![Configuration {
            name: "near".into(),
            focal_length: Some(third),
            f_number: Some(2.8),
            object_distance: Some(100.0),
            magnification: Some(-third),
            film_distance: Some(10.0),
            settings: vec![
                Setting { row: 2, quantity: Quantity::Thickness, value: third },
                Setting { row: 3, quantity: Quantity::Curvature, value: -third },
                Setting { row: 4, quantity: Quantity::Diameter, value: 3.0 },
            ],
        }],
        ..design(third)
    };
    let lens = lens.at_wavelength(550.0 + third).expect("in range");
    assert_eq!(again(&lens), lens);
}

#[test]
fn a_table_holds_what_it_can_and_names_what_it_cannot() {
    let folder = folder();
    write(&folder, "a.dat", "10.5 2 1.5 8\n-30 1 1 8\n0 1 0 6\n-20 0 1 8\n");
    let convert =
        |from: &str, to: &str| petzval(folder.path(), &["lens", "convert", from, "-o", to]);
    for (from, to) in [("a.dat", "b.toml"), ("b.toml", "c.dat"), ("c.dat", "d.toml")] {
        let (code, out, err) = convert(from, to);
        assert_eq!((code, out.as_str(), err.as_str()), (0, "", ""), "{from}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("written");
    assert_eq!(
        read("b.toml").lines().skip(1).collect::<Vec<_>>(),
        read("d.toml").lines().skip(1).collect::<Vec<_>>()
    );
    write(
        &folder,
        "k.toml",
        "[[surface]]\nradius = 9\nconic = -1\ndiameter = 2\nindex = 1.5\n[[surface]]\nstop = true\ndiameter = 2\n",
    );
    let (code, _, err) = convert("k.toml", "k.dat");
    assert_eq!(code, 2);
    assert!(
        err.contains("k.dat: a .dat table cannot hold a conic (surface 1); write a .toml file"),
        "{err}"
    );
    let (code, _, err) = convert("k.toml", "k.txt");
    assert_eq!(code, 2);
    assert!(err.contains("expected .toml, .zmx or .dat"), "{err}");
    let (code, _, err) = convert("k.toml", "k.toml");
    assert_eq!(code, 2, "{err}");
}

/// Writes a lens as a .zmx file and reads it back; returns it with the notes of the writer.
fn through_zmx(lens: &Prescription) -> (Prescription, Vec<String>) {
    let folder = folder();
    let path = folder.path().join("again.zmx");
    let written = write_lens(&path, lens).expect("a .zmx file holds it");
    let read = petzval_lens_formats::read(&write(&folder, "again.zmx", &written.text));
    (read.unwrap_or_else(|error| panic!("{error}\n{}", written.text)), written.notes)
}

#[test]
fn every_lens_of_the_repository_survives_a_zmx_file() {
    for (name, _) in LENSES {
        let lens = lens(name);
        let (read, notes) = through_zmx(&lens);
        assert_eq!(read.rows.len(), lens.rows.len(), "{name}");
        assert_eq!(read.name, lens.name);
        for (i, (new, old)) in read.rows.iter().zip(&lens.rows).enumerate() {
            let old = petzval_lens::Row { iris: Iris::Round, coating: None, ..old.clone() };
            let said = notes.iter().any(|n| n.contains(&format!("behind surface {},", i + 1)));
            let glass = if said { new.glass.clone() } else { old.glass.clone() };
            let thickness = if i + 1 == read.rows.len() { new.thickness } else { old.thickness };
            // Model glasses state an index at the d line only.
            let index = if said { new.index } else { old.index };
            assert!((index - old.index).abs() < 1e-6, "{name}, row {i}: {index}");
            assert_eq!(*new, petzval_lens::Row { glass, thickness, index, ..old }, "{name} {i}");
        }
        assert!(read.design.film_distance.is_some(), "{name}");
        assert_eq!(read.design.notes, Vec::<String>::new(), "{name}");
    }
}

#[test]
fn a_zmx_file_holds_all_shapes_glasses_states_and_wavelengths() {
    let third = 1.0 / 3.0;
    let mut rows = vec![row(30.5, 2.0 * third, 1.5, 10.0); 10];
    rows[0].asphere = vec![(4, third * 1e-9), (6, -1e-30)];
    rows[0].conic = -third;
    rows[1].asphere = vec![(3, 1e-6), (4, third * 1e-7)];
    rows[2].asphere = vec![(4, 1e-7), (20, third * 1e-25)];
    rows[3].asphere = vec![(3, 1e-7), (9, third * 1e-15)];
    // The lens is in its first state.
    rows[3].radius = (-third).recip();
    rows[3].diameter = 5.0;
    rows[4].diameter = 3.0;
    rows[2].thickness = 0.3;
    rows[4].across = Some(petzval_lens::CrossSection::Biconic { radius: -70.25, conic: third });
    rows[5].across = Some(petzval_lens::CrossSection::Toroid { radius: f64::INFINITY });
    rows[5].asphere = vec![(4, 1e-8)];
    rows[6] = petzval_lens::Row { mirror: true, index: 1.5, ..rows[6].clone() };
    rows[6].obstruction = third;
    rows[7].glass = Glass::Catalogue(find_glass("N-BK7").expect("listed"));
    rows[7].thickness = -4.0;
    rows[8].glass = Glass::model(1.6, 40.0 + third, 0.003);
    rows[8].thickness = -0.3;
    rows[9].stop = true;
    rows[9].radius = f64::INFINITY;
    rows[9].index = 1.0;
    rows[9].thickness = 0.0;
    let mut lens = Prescription::new("all", rows).expect("a lens");
    lens.source = Some("a patent".into());
    let state = |name: &str, value: f64| Configuration {
        name: name.into(),
        object_distance: Some(100.0 * value),
        film_distance: Some(10.0 + value),
        settings: vec![
            Setting { row: 3, quantity: Quantity::Curvature, value: -third * value },
            Setting { row: 4, quantity: Quantity::Diameter, value: 3.0 * value },
            Setting { row: 2, quantity: Quantity::Thickness, value: 0.3 * value },
            Setting { row: 8, quantity: Quantity::Thickness, value: -0.3 * value },
        ],
        ..Configuration::default()
    };
    lens.design =
        Design { configurations: vec![state("1", 1.0), state("2", 1.7)], ..design(third) };
    lens.design.object_distance = Some(100.0);
    lens.design.film_distance = Some(11.0);
    let lens = lens.at_wavelength(550.0 + third).expect("in range");
    let (mut read, notes) = through_zmx(&lens);
    assert_eq!(notes, Vec::<String>::new());
    let state =
        "the lens is in configuration 1 of 2, the current one of the file; 'zoom' chooses another";
    assert_eq!(read.design.notes, [state]);
    read.design.notes.clear();
    let mut expected = lens;
    for lens in [&mut read, &mut expected] {
        lens.rows[9].thickness = 0.0;
        for state in &mut lens.design.configurations {
            state.settings.sort_by_key(|setting| (setting.row, setting.quantity as u32));
        }
    }
    assert_eq!(read, expected);
}

#[test]
fn a_zmx_file_holds_tilts_and_folds_as_coordinate_breaks() {
    let mut rows = vec![row(30.0, 3.0, 1.5, 10.0), row(-40.0, 5.0, 1.0, 10.0)];
    rows.extend([row(f64::INFINITY, -20.0, 1.0, 8.0), row(50.0, -2.0, 1.6, 8.0)]);
    rows.push(row(-50.0, 0.0, 1.0, 8.0));
    rows[2].mirror = true;
    rows[0].stop = true;
    let mut lens = Prescription::new("fold", rows).expect("a lens");
    lens.design.film_distance = Some(30.0);
    let turn = DMat3::from_rotation_x(0.3) * DMat3::from_rotation_z(0.2);
    let tilt = DAffine3::from_mat3_translation(turn, DVec3::new(0.5, 0.0, -1.0));
    lens.breaks = [(2, tilt), (3, tilt), (5, tilt)]
        .map(|(row, transform)| CoordinateBreak { row, transform })
        .to_vec();
    let same = |lens: &Prescription| {
        let (read, notes) = through_zmx(lens);
        assert_eq!(notes, Vec::<String>::new());
        let places = |lens: &Prescription| {
            let mut places = lens.surface_transforms();
            let film = lens.travel_before(lens.rows.len()) * 30.0;
            places.push(lens.film_axis() * DAffine3::from_translation(DVec3::Z * film));
            places
        };
        for (new, old) in places(&read).iter().zip(places(lens)) {
            assert!(new.abs_diff_eq(old, 1e-11), "{new} {old}");
        }
        read
    };
    let read = same(&lens);
    assert_eq!(read.breaks.len(), 3);
    for (new, old) in read.breaks.iter().zip(&lens.breaks) {
        assert!(new.row == old.row && new.transform.abs_diff_eq(old.transform, 1e-12));
    }
    lens.tilt_decenters =
        vec![TiltDecenter { rows: [0, 1], pose: Pose { decentre: [0.1, 0.2], tilt: [1.0, 2.0] } }];
    lens.rows[3].pose = Pose { decentre: [0.25, 0.0], tilt: [0.0, 3.0] };
    same(&lens);
}

#[test]
fn a_zmx_file_names_what_it_does_not_hold() {
    let mut rows = vec![row(30.0, 3.0, 1.5, 10.0), row(-40.0, 5.0, 1.0, 10.0)];
    rows[0].glass = Glass::Table([[400.0, 1.52], [700.0, 1.5]].into());
    rows[0].coating = Some(petzval_lens::Coating::default());
    rows[1].stop = true;
    rows[1].iris = Iris::Blades { count: 7, rotation: 0.0, curvature: 0.0 };
    let mut lens = Prescription::new("lossy", rows).expect("a lens");
    lens.stated_focal_length = Some(33.0);
    lens.stated_f_number = Some(1.0);
    let (_, notes) = through_zmx(&lens);
    for part in [
        "paraxial focus",
        "iris; the opening is round (surface 2)",
        "coatings (surface 1)",
        "f-number 1 ",
        "focal length 33 mm",
        "behind surface 1, the medium given by a table",
    ] {
        assert!(notes.iter().any(|note| note.contains(part)), "{part}: {notes:#?}");
    }
    lens.rows[0].across = Some(petzval_lens::CrossSection::Biconic { radius: 1e3, conic: 0.0 });
    lens.rows[0].asphere = vec![(4, 1e-6)];
    let error = write_lens(Path::new("a.zmx"), &lens).unwrap_err().to_string();
    assert!(
        error.contains("a.zmx: a .zmx file has no surface of the shape of surface 1"),
        "{error}"
    );
}
