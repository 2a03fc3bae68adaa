//! Optical Bench: states, the stated f-number, aspheres, field stops and cover glasses.

use petzval_lens::Paraxial;

use super::{BENCH, parsed};

#[test]
fn every_state_has_its_distances_and_the_first_is_read() {
    let text =
        BENCH.replace("Bf\t40", "Focal Length\t70\t80\tundefined\nd2\t2\t2.5\t3\nBf\t40\t41\t42");
    let text =
        text.replace("Infinity\n", "Infinity\tInfinity\t500\n").replace("-60\t2\t", "-60\td2\t");
    let lens = parsed("a.txt", &text).unwrap();
    assert_eq!((lens.rows[1].thickness, lens.stated_focal_length), (2.0, Some(70.0)));
    let states = &lens.design.configurations;
    let focal: Vec<_> = states.iter().map(|state| state.focal_length).collect();
    assert_eq!(focal, [Some(70.0), Some(80.0), None]);
    let film: Vec<_> = states.iter().map(|state| state.film_distance).collect();
    assert_eq!(film, [Some(40.0), Some(41.0), Some(42.0)]);
    assert_eq!(states[2].object_distance, Some(500.0));
    let gap = states[2].settings.iter().find(|setting| setting.row == 1).unwrap();
    assert_eq!(gap.value, 3.0);
    // A state without all distances is left out, and the note says which.
    let lens = parsed("a.txt", &text.replace("2.5", "undefined")).unwrap();
    assert_eq!(lens.design.configurations.len(), 2);
    assert!(lens.design.notes[0].contains("state 2 of 3 is left out: the file gives it no d2"));
}

#[test]
fn the_stated_f_number_sets_the_stop() {
    let lens = parsed("a.txt", &BENCH.replace("Bf\t40", "F-Number\t11\nBf\t40")).unwrap();
    assert!((Paraxial::new(&lens).f_number() - 11.0).abs() < 1e-9);
    assert!(lens.rows[2].diameter < 10.0);
}

#[test]
fn coefficients_have_the_powers_that_the_constants_say() {
    let with = |constants: &str, line: &str| {
        let text = BENCH.replace("[constants]\n", &format!("[constants]\n{constants}"));
        parsed("a.txt", &format!("{text}[aspherical data]\n{line}\n")).unwrap().rows[3].clone()
    };
    let row = with("", "4\t-30\t-0.5\t1e-5\t\t3e-9");
    assert_eq!((row.conic, row.asphere), (-0.5, vec![(4, 1e-5), (8, 3e-9)]));
    let row = with("AsphericalA2\n", "4\t-30\t0\t1e-5\t2e-7");
    assert_eq!(row.asphere, [(2, 1e-5), (4, 2e-7)]);
    let row = with("AsphericalOddCount\t2\n", "4\t-30\t0\t3e-6\t4e-6\t5e-7\t6e-8\t8e-9\t1e-12");
    let powers: Vec<u32> = row.asphere.iter().map(|term| term.0).collect();
    assert_eq!(powers, [3, 4, 5, 6, 8, 10]);
    let row = with("", "No\tR\tk\tA4\tA8\n4\t-30\t-1\t1e-5\t2e-9");
    assert_eq!((row.conic, row.asphere), (-1.0, vec![(4, 1e-5), (8, 2e-9)]));
}

#[test]
fn field_stops_clip_and_cover_glasses_refract() {
    let text = BENCH.replace("3AS\tAS\t3", "FS\tFS\t1\t\t11\n3AS\tAS\t2");
    let text = text.replace("Bf\t\t16\n", "30\t\t16\n6\tCG\t2\t1.5\t30\t64\n7\tCG\tBf\t\t30\n");
    let lens = parsed("a.txt", &text).unwrap();
    assert_eq!((lens.rows.len(), lens.stop()), (8, 3));
    assert_eq!((lens.rows[2].diameter, lens.rows[6].index), (11.0, 1.5));
    assert!(lens.rows[2].radius.is_infinite());
}
