//! Conversion of lens files: a round trip is the identity.

mod support;

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use petzval::lens::{
    Configuration, CoordinateBreak, Design, FieldKind, Fields, Glass, Iris, Pose, Prescription,
    Quantity, Setting, SpectralLine, TiltDecenter, TransverseAxis, find_glass, parse_toml,
    write_lens,
};
use support::{LENSES, folder, lens, petzval, row, write};

fn again(lens: &Prescription) -> Prescription {
    let path = Path::new("again.toml");
    let text = write_lens(path, lens).expect("TOML holds every lens");
    parse_toml(path, &text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

#[test]
fn every_lens_of_the_repository_survives() {
    for (name, _) in LENSES {
        let lens = lens(name);
        assert_eq!(again(&lens), lens, "{name}");
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
    rows[2] = petzval::lens::Row { mirror: true, index: 1.5, ..rows[1].clone() };
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
        wavelengths: vec![
            SpectralLine { nm: 486.1, weight: 1.0 },
            SpectralLine { nm: 550.0 + third, weight: third },
        ],
        primary: 1,
        fields: Some(Fields { kind: FieldKind::ImageHeight, points: vec![[0.0, third]] }),
        object_distance: Some(f64::INFINITY),
        film_distance: Some(third),
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
        notes: Vec::new(),
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
    assert!(err.contains("expected .toml or .dat"), "{err}");
    let (code, _, err) = convert("k.toml", "k.toml");
    assert_eq!(code, 2, "{err}");
}
