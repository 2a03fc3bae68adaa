//! Tables of pbrt, ISET and crayg, and the JSON of ISET: stops, media, cylinders and columns.

use petzval_lens::{Paraxial, TransverseAxis};

use super::{FX, ISET, TABLE, parsed};

#[test]
fn a_stop_on_a_flat_face_refracts() {
    // R = 25.84 and n = 1.5168: f = R / (n - 1) = 50 mm, in air behind the stop.
    for index in ["0", "1"] {
        for gap in ["0", "30"] {
            let table = format!("25.84 4 1.5168 20\n0 {gap} {index} 20\n");
            let lens = parsed("a.dat", &table).unwrap();
            assert!((Paraxial::new(&lens).focal_length - 50.0).abs() < 1e-9, "{index} {gap}");
        }
        let json = format!(
            "{{\"surfaces\": [{{\"radius\": 25.84, \"thickness\": 4, \"ior\": 1.5168, \
             \"semi_aperture\": 10}}, {{\"radius\": 0, \"thickness\": 0, \"ior\": {index}, \
             \"semi_aperture\": 10}}]}}"
        );
        let lens = parsed("a.json", &json).unwrap();
        assert!((Paraxial::new(&lens).focal_length - 50.0).abs() < 1e-9, "{index}");
    }
}

#[test]
fn comments_have_several_signs_and_flat_faces_are_no_second_stop() {
    let expected = parsed("a.dat", TABLE).unwrap();
    let commented =
        format!("% a lens\n// of ISET\n\t77.5\t\n{}", TABLE.replace("20\n", "20 % mm\n"));
    let lens = parsed("a.dat", &commented).unwrap();
    assert_eq!((&lens.rows[..], lens.stated_focal_length), (&expected.rows[..], Some(77.5)));
    let flat =
        parsed("a.dat", "40 6 1.6 20\n0 2 1 20\n0 3 0 10\n-30 2 1.7 16\n0 40 1 16\n").unwrap();
    assert_eq!(flat.stop(), 2);
    assert!(flat.rows[1].radius.is_infinite() && flat.rows[1].index == 1.0);
}

#[test]
fn words_behind_the_numbers_make_cylinders() {
    let lens = parsed("a.dat", &TABLE.replace("1.7 16", "1.7 16 CYLINDER_X")).unwrap();
    assert_eq!(lens.rows[3].axis, Some(TransverseAxis::X));
    let fx = FX.replace("1.7 8 30 UNKNOWN SPHERICAL", "1.7 8 30 UNKNOWN CYLINDER_Y");
    assert_eq!(parsed("a.fx", &fx).unwrap().rows[3].axis, Some(TransverseAxis::Y));
}

#[test]
fn square_terms_that_bend_nothing_are_of_the_fourth_power() {
    let with =
        |line: &str| parsed("a.fx", &format!("{FX}[Aspheric Coefficients]\n{line}\n")).unwrap();
    let lens = with("3: k=-1 a2=0 a4=1E-06 a6=2e-9");
    assert_eq!(
        (lens.rows[3].conic, &lens.rows[3].asphere[..]),
        (-1.0, &[(4, 1e-6), (6, 2e-9)][..])
    );
    let lens = with("3: k=0 a2=1E-03 a4=1e-6");
    assert_eq!(lens.rows[3].asphere, [(2, 1e-3), (4, 1e-6)]);
    let lens = with("3: k=0 a2=1E-06 a4=2e-9");
    assert_eq!(lens.rows[3].asphere, [(4, 1e-6), (6, 2e-9)]);
    assert!(lens.design.notes[0].contains("powers 4, 6"), "{:?}", lens.design.notes);
}

#[test]
fn the_f_number_closes_a_wider_stop() {
    let fx = FX.replace("[Surfaces]", "Maximum F Number: 16\n[Surfaces]");
    assert!((Paraxial::new(&parsed("a.fx", &fx).unwrap()).f_number() - 16.0).abs() < 1e-9);
    let fx = FX.replace("[Surfaces]", "Maximum F Number: 2\n[Surfaces]");
    assert_eq!(parsed("a.fx", &fx).unwrap().rows[2].diameter, 10.0);
}

#[test]
fn semi_diameters_beyond_the_radius_are_diameters() {
    let lens = parsed("a.fx", &FX.replace("1.7 8 ", "1.7 32 ")).unwrap();
    assert_eq!((lens.rows[3].diameter, lens.rows[0].diameter), (32.0, 10.0));
    assert!(lens.design.notes[0].contains("holds diameters: 1 of 5"), "{:?}", lens.design.notes);
    // The rim of a rounded hemisphere is none of them.
    let lens = parsed("a.fx", &FX.replace("1.7 8 ", "1.7 30.2 ")).unwrap();
    assert_eq!(lens.rows[0].diameter, 20.0);
}

#[test]
fn a_table_of_indices_disperses_and_a_focal_length_in_metres_is_one() {
    let json = ISET.replace("\"ior\": 1.6,", "\"ior\": [[480, 580, 660], [1.61, 1.6, 1.59]],");
    let lens = parsed("a.json", &json).unwrap();
    assert!(lens.rows[0].glass.disperses() && (lens.rows[0].index - 1.6).abs() < 2e-3);
    let json = ISET.replace("{\"name\"", "{\"metadata\": {\"focalLength\": 0.08}, \"name\"");
    assert_eq!(parsed("a.json", &json).unwrap().stated_focal_length, Some(80.0));
}
