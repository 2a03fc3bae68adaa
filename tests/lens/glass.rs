//! Dispersion of glasses against published data, from the catalogue to the rays of a picture.

use std::fmt::Write as _;

use crate::support::{folder, oracle, petzval, row, write};
use glam::DAffine3;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{RayBatch, SampleBatch};
use petzval_base::sampler::{Dimension, sample_2d};
use petzval_base::stats::LensStats;
use petzval_lens::{
    Camera, LensColumns, LensModel, LensRay, Paraxial, Prescription, PupilSampling, RealLens, Row,
    Side, sequence, trace_one,
};
use petzval_spectrum::LightBand;
use petzval_spectrum::{C_LINE, D_LINE, F_LINE, Glass, find_glass};

/// The g line of mercury, nm.
const G_LINE: f64 = 435.8343;

/// Refractive indices at the g, F, d and C lines: data sheets of Schott, Ohara and Hoya, and Malitson
/// (1965).
const PUBLISHED: &[(&str, [f64; 4])] = &[
    ("N-BK7", [1.52668, 1.52238, 1.51680, 1.51432]),
    ("F2", [1.64202, 1.63208, 1.62004, 1.61503]),
    ("SF6", [1.84707, 1.82775, 1.80518, 1.79609]),
    ("N-SF11", [1.82533, 1.80651, 1.78472, 1.77596]),
    ("S-BSL7", [1.52621, 1.52191, 1.51633, 1.51386]),
    ("S-TIH6", [1.84729, 1.82777, 1.80518, 1.79611]),
    ("S-FPL51", [1.50451, 1.50123, 1.49700, 1.49514]),
    ("BSC7", [1.52667, 1.52237, 1.51680, 1.51432]),
    ("FCD1", [1.50451, 1.50123, 1.49700, 1.49514]),
    ("F_SILICA", [1.46669, 1.46313, 1.45846, 1.45637]),
];

/// Rounding of the indices in data sheets. A difference of two has twice this error.
const ROUNDING: f64 = 6e-6;

fn published(name: &str) -> [f64; 4] {
    PUBLISHED.iter().find(|(listed, _)| *listed == name).expect("a glass of the table").1
}

/// Returns a biconvex lens of 50 mm radii with its stop in front.
fn singlet(index: f64, glass: Glass) -> Prescription {
    let front = Row { glass, ..row(50.0, 5.0, index, 20.0) };
    let rows = vec![row(0.0, 1.0, 1.0, 10.0), front, row(-50.0, 0.0, 1.0, 20.0)];
    Prescription::new("singlet", rows).expect("one stop")
}

/// Returns the singlet of a glass of the catalogue.
fn of_glass(name: &str) -> Prescription {
    let glass = find_glass(name).expect("listed");
    singlet(glass.nd(), Glass::Catalogue(glass))
}

/// Returns the singlet of a medium without dispersion.
fn of_index(index: f64) -> Prescription {
    singlet(index, Glass::Constant)
}

#[test]
fn glasses_have_their_published_indices_at_four_lines() {
    for &(name, indices) in PUBLISHED {
        for (nm, index) in [G_LINE, F_LINE, D_LINE, C_LINE].into_iter().zip(indices) {
            let found = of_glass(name).at_wavelength(nm).unwrap().rows[1].index;
            assert!((found - index).abs() < ROUNDING, "{name} at {nm} nm: {found}, not {index}");
        }
        let [blue, red] =
            [F_LINE, C_LINE].map(|nm| of_glass(name).at_wavelength(nm).unwrap().rows[1].index);
        let spread = indices[1] - indices[3];
        assert!((blue - red - spread).abs() < 2.0 * ROUNDING, "{name}: {} {spread}", blue - red);
    }
}

#[test]
fn glasses_have_their_published_indices_in_the_near_ultraviolet_and_infrared() {
    // The i and t lines of the data sheets, where terms matter that are negligible in the visible.
    for (name, i, t) in [("N-BK7", 1.53627, 1.50731), ("F2", 1.66623, 1.60279)] {
        for (nm, index) in [(365.0146, i), (1013.98, t)] {
            let found = of_glass(name).at_wavelength(nm).unwrap().rows[1].index;
            assert!((found - index).abs() < ROUNDING, "{name} at {nm} nm: {found}, not {index}");
        }
    }
}

#[test]
fn abbe_numbers_tables_and_guesses_give_their_dispersion() {
    let spread = |lens: &Prescription| {
        let [blue, red] = [F_LINE, C_LINE].map(|nm| lens.at_wavelength(nm).unwrap().rows[1].index);
        blue - red
    };
    for &(name, [_, blue, green, red]) in PUBLISHED {
        let vd = (green - 1.0) / (blue - red);
        let by_abbe = spread(&singlet(green, Glass::Abbe { nd: green, vd }));
        assert!((by_abbe - (blue - red)).abs() < 1e-12, "{name}: {by_abbe}");
        let table = [[C_LINE, red], [D_LINE, green], [F_LINE, blue]];
        let mut table = table.to_vec();
        table.reverse();
        let tabled = singlet(green, Glass::Table(table.clone().into()));
        assert!((spread(&tabled) - (blue - red)).abs() < 1e-12, "{name}");
        // Interpolated indices follow the glass to a fiftieth of its dispersion.
        for nm in [510.0, 546.074, 620.0] {
            let [found, exact] = [&tabled, &of_glass(name)]
                .map(|lens| lens.at_wavelength(nm).unwrap().rows[1].index);
            assert!((found - exact).abs() < 0.02 * (blue - red), "{name} at {nm}: {found} {exact}");
        }
        let mut guessed = of_index(green);
        let glass = guessed.assume_dispersion()[0].clone();
        let [_, vd] = glass.published.unwrap();
        let estimate = (green - 1.0) / vd;
        assert!((spread(&guessed) / estimate - 1.0).abs() < 2e-3, "{name}: {}", glass.name);
    }
}

#[test]
fn chromatic_focal_shift_follows_the_published_indices() {
    for &(name, indices) in PUBLISHED {
        let focal = |lens: &Prescription| Paraxial::new(lens).focal_length;
        let [blue, red] =
            [F_LINE, C_LINE].map(|nm| focal(&of_glass(name).at_wavelength(nm).unwrap()));
        // The lensmaker's equation for a thick lens.
        let [expected_blue, expected_red] = [indices[1], indices[3]].map(|n| {
            let power: f64 = (n - 1.0) * (2.0 / 50.0 - (n - 1.0) * 5.0 / (n * 50.0 * 50.0));
            power.recip()
        });
        let (found, expected) = (red - blue, expected_red - expected_blue);
        // The rounding of data sheets is a quarter of a percent of a small dispersion.
        assert!((found / expected - 1.0).abs() < 4e-3, "{name}: {found} mm, not {expected} mm");
    }
}

#[test]
fn lens_trace_refracts_each_wavelength_by_its_published_index() {
    let folder = folder();
    for name in ["F2", "N-BK7", "S-TIH6", "FCD1"] {
        // Several makers have an F2.
        let glass = name.replace("F2", "Schott F2");
        let file = format!(
            "[[surface]]\nstop = true\ndiameter = 10\nthickness = 1\n\
             [[surface]]\nradius = 50\nthickness = 5\ndiameter = 20\nglass = \"{glass}\"\n\
             [[surface]]\nradius = -50\ndiameter = 20\n"
        );
        write(&folder, "lens.toml", file);
        let lines = [G_LINE, F_LINE, D_LINE, C_LINE];
        let mut rays = String::new();
        for nm in lines {
            let _ = writeln!(rays, "3,1,51,-0.01,0.02,-1,{nm}");
        }
        write(&folder, "rays.csv", rays);
        let arguments = ["lens", "trace", "lens.toml", "--rays", "rays.csv", "--precision", "f64"];
        let (code, stdout, stderr) = petzval(folder.path(), &arguments);
        assert!(code == 0 && !stderr.contains("warning"), "{stderr}");
        assert_eq!(stdout.lines().count(), 4);
        for ((line, nm), index) in stdout.lines().zip(lines).zip(published(name)) {
            let found: Vec<f64> =
                line.split(',').map(|word| word.parse().expect("a number")).collect();
            // For the oracle the film is at the start of the ray.
            let traced =
                oracle::trace_spheres(&of_index(index), 45.0, [3.0, 1.0, 0.0], [-0.01, 0.02, 1.0]);
            let [_, exact] = traced.expect("the ray comes through");
            for axis in 0..2 {
                let off = (found[3 + axis] - exact[axis]).abs();
                // The effect of the rounding of the data sheet.
                assert!(off < 2e-6, "{name} at {nm} nm: {off} rad off");
            }
        }
    }
}

#[test]
fn rays_of_a_picture_refract_by_the_published_index_of_their_band() {
    let (film, points) = (45.0, [[2.0f32, 1.0], [-4.0, 0.5], [0.0, 0.0]]);
    for name in ["F2", "N-BK7", "S-TIH6", "FCD1"] {
        let [_, blue, _, red] = published(name);
        let mut lens = RealLens::new(of_glass(name), film, 5.0, PupilSampling::Pupil, 1.0, 0.0);
        let band = |wavelength| LightBand { wavelength, response: [1.0; 3] };
        lens.disperse(&[band(F_LINE), band(C_LINE)]);
        let camera = Camera {
            model: LensModel::Real(Box::new(lens)),
            film: [10.0, 10.0],
            world_from_camera: DAffine3::IDENTITY,
            imaging_ratio: 1.0,
            depth: [0.0, f64::INFINITY],
        };
        for (band, index) in [blue, red].into_iter().enumerate() {
            let mut samples = SampleBatch { len: 240, band, ..SampleBatch::default() };
            for i in 0..samples.len {
                for axis in 0..2 {
                    samples.film[axis][i] = points[i % 3][axis];
                    samples.pupil[axis][i] = sample_2d(0, i as u32, Dimension::Pupil)[axis];
                }
            }
            let mut rays = RayBatch::default();
            let mut stats = LensStats::default();
            camera.generate_rays::<f32x8>(
                &samples,
                &mut LensColumns::default(),
                &mut rays,
                &mut stats,
            );
            assert!(rays.len > 150, "{} rays", rays.len);
            // Trace back through a lens of the published index, to the film point.
            let back = sequence::<f64>(&of_index(index), Side::Scene(0.0));
            for i in 0..rays.len {
                let ray = rays.ray(i);
                let [x, y, z] = ray.origin.map(f64::from);
                let [dx, dy, dz] = oracle::unit(ray.direction.map(f64::from));
                let ray_back = LensRay::new([x, y, -z], [-dx, -dy, dz]);
                let there = trace_one::<f64>(ray_back, &back).expect("it goes back the same way");
                let way = (film - there.p[2]) / there.t[2];
                let point = points[rays.slot[i] as usize % 3];
                for axis in 0..2 {
                    let landed = (there.p[axis] + way * there.t[axis]).abs();
                    let off = 1e3 * (landed - f64::from(point[axis].abs())).abs();
                    // Rounding of the data sheet and of f32.
                    assert!(off < 0.2, "{name}, band {band}: {off} um off");
                }
            }
        }
    }
}

#[test]
fn a_guess_is_a_crown_for_positive_and_a_flint_for_negative_elements() {
    let of = |radius: f64| {
        let mut lens = of_index(1.62);
        (lens.rows[1].radius, lens.rows[2].radius) = (radius, -radius);
        lens.assume_dispersion()[0].published
    };
    let [[_, crown], [_, flint]] = [50.0, -50.0].map(|radius| of(radius).unwrap());
    assert!(crown > 55.0 && flint < 40.0, "{crown} and {flint}");
}

/// A glass that no maker has, and a lens of it.
const CROWN: &str = "NM CROWN-1 2 0 1.5 60\nCD 1.2245 0.0105\nLD 0.35 2.0\n";
const CROWN_LENS: &str = "[[surface]]\nradius = 50\nthickness = 5\ndiameter = 20\nglass = \"crown1\"\n\
    [[surface]]\nradius = -50\nthickness = 1\ndiameter = 20\n[[surface]]\ndiameter = 10\nstop = true\n";

#[test]
fn a_catalogue_of_the_user_gives_its_glass_to_every_command_that_opens_a_lens() {
    let folder = folder();
    write(&folder, "own.agf", CROWN);
    write(&folder, "lens.toml", CROWN_LENS);
    write(&folder, "rays.csv", "0,0,60,0,0,-1\n");
    write(
        &folder,
        "scene.pbrt",
        "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4\n\
         Camera \"realistic\" \"string lensfile\" \"lens.toml\" \"float aperturediameter\" 5 \
         \"float focusdistance\" 2\nSampler \"independent\" \"integer pixelsamples\" 1\n\
         WorldBegin\nLightSource \"infinite\"\n",
    );
    let commands: [&[&str]; 4] = [
        &["lens", "lens.toml"],
        &["lens", "trace", "lens.toml", "--rays", "rays.csv"],
        &["plan", "scene.pbrt"],
        &["render", "scene.pbrt", "-o", "out.exr"],
    ];
    for command in commands {
        let (code, _, stderr) = petzval(folder.path(), command);
        assert!(code == 2 && stderr.contains("no glass \"crown1\""), "{command:?}: {stderr}");
        for catalogue in ["own.agf", "."] {
            let with = [command, &["--catalogue", catalogue]].concat();
            let (code, _, stderr) = petzval(folder.path(), &with);
            assert_eq!(code, 0, "{with:?}: {stderr}");
        }
        let with = [command, &["--catalogue", "lens.toml"]].concat();
        let (code, _, stderr) = petzval(folder.path(), &with);
        let error = "lens.toml:1: no glass in the file; expected an AGF catalogue";
        assert!(code == 2 && stderr.contains(error), "{with:?}: {stderr}");
    }
}
