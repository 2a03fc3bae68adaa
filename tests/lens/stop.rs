//! Stops that are also refracting surfaces, plane or curved.

use std::path::Path;

use crate::support::{folder, lens, oracle, petzval, root, write};
use petzval_lens::{
    BlockReason, LensError, LensRay, Paraxial, Prescription, Side, sequence, trace_one,
};
use petzval_lens_formats::{parse_dat, parse_toml};

fn toml(text: &str) -> Result<Prescription, LensError> {
    parse_toml(Path::new("test.toml"), text)
}

fn dat(text: &str) -> Result<Prescription, LensError> {
    let lines: Vec<&str> = text.lines().collect();
    parse_dat(Path::new("test.dat"), &lines)
}

/// N-BK7 with a radius of 25.84 mm: a focal length of 50 mm.
const CURVED: &str = "[[surface]]\nradius = 25.84\nthickness = 4\ndiameter = 20\n";

/// Returns a plano-convex lens whose rear plane face is the stop and has these keys.
fn plane_behind(keys: &str) -> String {
    format!("{CURVED}glass = \"N-BK7\"\n[[surface]]\ndiameter = 10\nstop = true\n{keys}\n")
}

#[test]
fn a_plane_face_behind_the_lens_can_be_the_stop() {
    for keys in ["", "index = 1.0", "radius = 0", "radius = inf\nindex = 1"] {
        let lens = toml(&plane_behind(keys)).expect(keys);
        let focal = Paraxial::new(&lens).focal_length;
        assert!((focal - 50.0).abs() < 5e-3, "{keys:?}: {focal}");
        assert_eq!(lens.rear().index, 1.0, "the film is in air");
    }
    let folder = folder();
    let path = write(&folder, "plano.toml", plane_behind(""));
    let (code, stdout, _) = petzval(folder.path(), &["lens", &path.to_string_lossy()]);
    let focal = stdout.lines().find(|line| line.starts_with("focal length")).expect("printed");
    assert!(code == 0 && focal.contains(" 50.00"), "{focal}");
    assert!(stdout.contains("plane stop"), "{stdout}");
}

#[test]
fn a_plane_face_in_front_can_be_the_stop() {
    let text = "[[surface]]\nthickness = 4\ndiameter = 10\nstop = true\nglass = \"N-BK7\"\n\
                [[surface]]\nradius = -25.84\ndiameter = 20\n";
    let lens = toml(text).unwrap();
    assert!((Paraxial::new(&lens).focal_length - 50.0).abs() < 5e-3);
    let index = lens.rows[0].index;
    let table = dat(&format!("0 4 {index} 10\n-25.84 0 1 20")).unwrap();
    assert_eq!(Paraxial::new(&table).focal_length, Paraxial::new(&lens).focal_length);
}

#[test]
fn a_table_may_give_the_index_behind_a_plane_stop() {
    let lens = dat("25.84 4 1.5168 20\n0 0 1 10").unwrap();
    assert!((Paraxial::new(&lens).focal_length - 50.0).abs() < 5e-3);
    // In the last row index 0 means air.
    assert_eq!(dat("25.84 4 1.5168 20\n0 0 0 10").unwrap().rows, lens.rows);
}

#[test]
fn a_plane_stop_refracts_and_blocks_as_in_the_oracle() {
    let behind = toml(&plane_behind("")).unwrap();
    let in_front = dat("0 4 1.5168 10\n-25.84 0 1 20").unwrap();
    for lens in [behind, in_front] {
        let surfaces = sequence::<f64>(&lens, Side::Film(47.0));
        let (mut through, mut ended) = (0, 0);
        for i in -20..=20 {
            let start = [1.0, 2.0, 0.0];
            let towards = oracle::unit([0.01 * f64::from(i), 0.02, 1.0]);
            let traced = trace_one::<f64>(LensRay::new(start, towards), &surfaces);
            match (traced, oracle::trace_spheres(&lens, 47.0, start, towards)) {
                (Ok(ray), Ok([p, d])) => {
                    through += 1;
                    for axis in 0..3 {
                        assert!((ray.p[axis] - p[axis]).abs() < 1e-12);
                        assert!((ray.t[axis] - d[axis]).abs() < 1e-12);
                    }
                }
                (Err(end), Err(row)) => {
                    ended += 1;
                    let reason =
                        if row == lens.stop() { BlockReason::Stop } else { BlockReason::Clip };
                    assert_eq!((end.row, end.reason), (row, reason));
                }
                (traced, told) => panic!("{towards:?}: {traced:?}, not {told:?}"),
            }
        }
        assert!(through > 5 && ended > 5, "{through} and {ended}");
    }
}

#[test]
fn a_plane_stop_between_two_glasses_must_name_its_medium() {
    let between = |keys: &str| {
        toml(&format!(
            "{CURVED}index = 1.5\n[[surface]]\nstop = true\nthickness = 1\ndiameter = 10\n{keys}\n\
             [[surface]]\nradius = -30\nthickness = 2\ndiameter = 20\nindex = 1.6\n\
             [[surface]]\nradius = -60\ndiameter = 20\n"
        ))
    };
    let error = between("").unwrap_err().to_string();
    assert!(
        error.starts_with("test.toml:6:1: a plane stop behind a medium of index 1.5"),
        "{error}"
    );
    assert!(error.contains("index = 1.5") && error.contains("index = 1 "), "{error}");
    assert_eq!(between("index = 1.5").unwrap().rows[1].index, 1.5);
    assert_eq!(between("index = 1").unwrap().rows[1].index, 1.0);
    // An index of 0 in a table is air, as pbrt's surfaces behind the stop take it.
    let lens = dat("25.84 4 1.5 20\n0 1 0 10\n-30 2 1.6 20\n-60 0 1 20").unwrap();
    assert_eq!(lens.rows[1].index, 1.0);
    // Without room behind the stop there is no air, as in the pupil of an eye.
    let eye = dat("25.84 4 1.5 20\n0 0 0 10\n-30 2 1.6 20\n-60 0 1 20").unwrap();
    assert_eq!(eye.rows[1].index, 1.5);
}

/// Makers round: the course's lens of 50 mm and f/2 opens to f/2.02, and is asked for f/2.
#[test]
fn an_f_number_within_three_percent_of_the_widest_means_the_widest() {
    let lens = lens("dgauss.50mm");
    let open = petzval_lens::RealRayFocus::new(&lens).f_number().expect("an image");
    let wide = lens.rows[lens.stop()].diameter;
    for asked in [2.0, 0.971 * open] {
        let diameter = lens.f_number_diameter(asked).expect("an f-number of the lens");
        assert!((diameter / wide - 1.0).abs() < 1e-9, "f/{asked}: {diameter} mm of {wide} mm");
    }
    assert_eq!(lens.rounded_f_number(2.0).map(|rounded| rounded.open), Some(open));
    for asked in [1.0, 0.969 * open, open, 2.8] {
        assert_eq!(lens.rounded_f_number(asked), None, "f/{asked}");
    }
    assert!(lens.f_number_diameter(0.969 * open).is_err());
}

#[test]
fn a_sweep_of_the_round_f_numbers_of_the_help_runs() {
    let folder = folder();
    let scene = root().join("scenes/dgauss.pbrt");
    let arguments = "--sweep fstop=2,8 --spp 1 --resolution 12x12 -o f{fstop}.exr".split(' ');
    let lens = root().join("lenses/dgauss.50mm.dat");
    let [scene, lens] = [&scene, &lens].map(|path| path.to_str().expect("a path"));
    let mut all = vec!["render", scene, "--lens", lens];
    all.extend(arguments);
    let (code, _, stderr) = petzval(folder.path(), &all);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("f/2 is the widest of this lens, which opens to f/2.02"), "{stderr}");
}
