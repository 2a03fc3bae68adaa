//! Light that glass absorbs, against Lambert's law along the paths of an oracle and of replayed rays.

use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;
use petzval_base::lanes::f32x8;
use petzval_base::rays::SampleBatch;
use petzval_base::sampler::{Dimension, sample_2d};
use petzval_lens::{
    Camera, Fidelity, LensModel, LensRay, Prescription, PupilSampling, RealLens, RealRayFocus, Row,
    Side, ghost_sequence, sequence_at, trace_ghost, trace_one,
};
use petzval_spectrum::{CatalogueGlass, D_LINE, Glass, find_glass, parse_agf};
use petzval_tools::bench::lens_wave::batch as lens_batch;

use crate::coating::rays::{oblique_rays, weights_at};
use crate::support::{LENSES, folder, lens, oracle, petzval, root, row, write};

/// A catalogue of one glass: N-BK7 by its formula, with our own internal transmittances of 25 mm.
const DARK: &str = "CC our own\nNM DARK 2 517642 1.5168 64.17 0 1\n\
    CD 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653\nLD 0.3 2.5\n\
    IT 0.40 0.20 25\nIT 0.55 0.50 25\nIT 0.70 0.90 25\n";

fn dark() -> Arc<CatalogueGlass> {
    let glasses = parse_agf(Path::new("dark.agf"), DARK.as_bytes()).expect("a catalogue");
    Arc::new(glasses.into_iter().next().expect("a glass"))
}

/// Returns the glass with the formula of another one, for lenses that keep their indices.
fn with_index(index: f64) -> Glass {
    let formula = petzval_spectrum::Formula::Samples([[D_LINE, index]].into());
    Glass::Catalogue(Arc::new(CatalogueGlass { formula, ..(*dark()).clone() }))
}

/// Makes every glass of a lens absorb.
fn darkened(mut lens: Prescription) -> Prescription {
    for row in &mut lens.rows {
        if row.index > 1.0 {
            row.glass = with_index(row.index);
        }
    }
    lens
}

fn passed(mm: f64, nm: f64) -> f64 {
    (-dark().absorption.coefficient(nm) * mm).exp()
}

/// A plate of 10 mm behind a stop.
fn plate() -> Prescription {
    let mut front = row(f64::INFINITY, 10.0, 1.5168, 40.0);
    front.coating = Some(petzval_lens::Coating::Perfect);
    front.glass = Glass::Catalogue(dark());
    let back = Row { glass: Glass::Constant, index: 1.0, thickness: 0.0, ..front.clone() };
    let mut lens = Prescription::new("plate", vec![row(0.0, 1.0, 1.0, 40.0), front, back]);
    lens.as_mut().expect("one stop").rows[1].index = dark().nd();
    lens.expect("one stop")
}

#[test]
fn a_plate_absorbs_by_its_thickness_and_the_angle_inside() {
    let lens = plate();
    for nm in [380.0, 400.0, 475.0, 550.0, 640.0, 700.0, 900.0] {
        for degrees in [0.0f64, 20.0, 50.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let rays = [[[-20.0 * sin, 0.0, 0.0], [sin, 0.0, cos]]];
            let inside = (1.0 - (sin / lens.rows[1].index).powi(2)).sqrt();
            let expected = passed(10.0 / inside, nm);
            let found = weights_at::<f64>(&lens, 15.0, nm, &rays)[0].expect("it passes");
            assert!(
                (found / expected - 1.0).abs() < 2e-6,
                "{nm} nm, {degrees}: {found} {expected}"
            );
        }
    }
    // The line of the catalogue itself.
    let straight = [[[0.0; 3], [0.0, 0.0, 1.0]]];
    let found = weights_at::<f64>(&lens, 15.0, 550.0, &straight)[0].expect("it passes");
    assert!((found - 0.5f64.powf(10.0 / 25.0)).abs() < 2e-6, "{found}");
}

#[test]
fn a_ghost_crosses_a_plate_three_times() {
    let lens = plate();
    let path = ghost_sequence::<f32>(&lens, [1, 2], 550.0);
    let mut batch = lens_batch::<f32x8>(&[[[0.0; 3], [0.0, 0.0, 1.0]]]);
    let came = trace_ghost::<f32x8>(&mut batch, &path);
    let once = lens.transmittance(1);
    assert_eq!((came, once), (1, 1.0));
    // Its faces reflect nothing; bare ones do.
    assert_eq!(batch.weight[0], 0.0);
    let mut bare = lens.clone();
    bare.rows.iter_mut().for_each(|row| row.coating = None);
    let mut clear = bare.clone();
    clear.rows[1].glass = Glass::Constant;
    let weight = |lens: &Prescription| {
        let mut batch = lens_batch::<f32x8>(&[[[0.0; 3], [0.0, 0.0, 1.0]]]);
        trace_ghost::<f32x8>(&mut batch, &ghost_sequence::<f32>(lens, [1, 2], 550.0));
        f64::from(batch.weight[0])
    };
    let share = weight(&bare) / weight(&clear);
    assert!((share / passed(30.0, 550.0) - 1.0).abs() < 3e-6, "{share}");
}

#[test]
fn oblique_rays_are_absorbed_as_in_the_oracle_in_every_precision() {
    for (name, film) in LENSES {
        let clear = lens(name);
        let dark = darkened(clear.clone());
        let rays = oblique_rays(&clear, film, 9);
        let all = weights_at::<f64>(&clear, film, D_LINE, &rays);
        let wide = weights_at::<f64>(&dark, film, D_LINE, &rays);
        let packets = weights_at::<f32x8>(&dark, film, D_LINE, &rays);
        assert_eq!(packets, weights_at::<f32>(&dark, film, D_LINE, &rays), "{name}: lanes differ");
        let (mut through, mut least) = (0, 1.0f64);
        for (i, [p, t]) in rays.iter().enumerate() {
            let (Some(all), Some(wide), Some(single)) = (all[i], wide[i], packets[i]) else {
                continue;
            };
            let mut share = 1.0;
            let mut last = None;
            let met = oracle::trace_spheres_visiting(&clear, film, *p, *t, |row, _, point| {
                if let Some(last) = last
                    && clear.rows[row].index > 1.0
                {
                    let d: [f64; 3] = std::array::from_fn(|k| point[k] - (last as [f64; 3])[k]);
                    share *= passed(oracle::dot(d, d).sqrt(), D_LINE);
                }
                last = Some(point);
            });
            met.expect("the ray leaves the lens");
            least = least.min(share);
            assert!((wide / all - share).abs() < 2e-6, "{name} ray {i}: {wide} / {all}, {share}");
            assert!((single - wide).abs() < 1e-5, "{name} ray {i}: {single}, not {wide}");
            through += 1;
        }
        assert!(through > 100 && least < 0.9, "{name}: {through} rays, {least}");
    }
}

/// Returns a camera of a lens that absorbs, with losses, in one wavelength.
fn camera(lens: Prescription, nm: f64) -> Camera {
    let film = RealRayFocus::new(&lens).film_distance(f64::INFINITY).expect("an image");
    let mut lens = RealLens::new(lens, film, 4.0, PupilSampling::Pupil, 1.0, 0.0);
    lens.disperse(&[petzval_spectrum::LightBand { wavelength: nm, response: [1.0; 3] }]);
    lens.fresnel = true;
    Camera {
        model: LensModel::Real(Box::new(lens)),
        film: [4.0; 2],
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}

fn sample(i: u32) -> SampleBatch {
    let mut samples = SampleBatch { len: 1, ..SampleBatch::default() };
    let ([x, y], pupil) = (sample_2d(3, i, Dimension::Film), sample_2d(3, i, Dimension::Pupil));
    (samples.film[0][0], samples.film[1][0]) = (4.0 * x - 2.0, 4.0 * y - 2.0);
    (samples.pupil[0][0], samples.pupil[1][0]) = (pupil[0], pupil[1]);
    samples
}

/// A mirror behind glass (Mangin 1876): light crosses the glass twice.
const MANGIN: &str = "name = \"Mangin mirror\"\n\
    [[surface]]\nradius = -150\nthickness = 6\ndiameter = 30\nindex = 1.5168\nstop = true\n\
    [[surface]]\nradius = -230\nthickness = -6\ndiameter = 32\nmirror = true\n\
    [[surface]]\nradius = -150\nthickness = 0\ndiameter = 30\n";

#[test]
fn aspheres_cylinders_tilts_and_mirrors_absorb_along_the_way_of_their_rays() {
    let folder = folder();
    let mangin = petzval_lens_formats::read(&write(&folder, "mangin.toml", MANGIN));
    let file = |name: &str| petzval_lens_formats::read(&root().join("lenses").join(name));
    let mut tilted = file("triplet.toml").expect("a lens");
    tilted.rows[2].pose.tilt = [2.0, -1.0];
    tilted.rows[4].pose.decentre = [0.2, 0.3];
    for lens in [
        file("phone.toml").expect("a lens"),
        file("anamorphic.toml").expect("a lens"),
        mangin.expect("a lens"),
        tilted,
    ] {
        let name = lens.name.clone();
        let absorbing = darkened(lens.clone());
        let mut lens = lens;
        lens.rows.iter_mut().for_each(|row| row.glass = Glass::Constant);
        for nm in [400.0, D_LINE] {
            let [clear, dark] = [&lens, &absorbing].map(|lens| camera(lens.clone(), nm));
            let exact = dark.with_fidelity(Fidelity::Double);
            let mut through = 0;
            for i in 0..200 {
                let path = dark.ray_path(&sample(i)).expect("a lit point");
                let (Ok(end), Some(all)) = (&path.end, clear.ray_path(&sample(i))) else {
                    continue;
                };
                let Ok(all) = &all.end else { continue };
                let mut share = 1.0;
                for pair in path.crossings.windows(2) {
                    let [from, to] = [&pair[0], &pair[1]].map(|c| c.point.expect("it passes"));
                    let way: f64 = (0..3).map(|k| (to[k] - from[k]).powi(2)).sum();
                    if pair[1].index[0] > 1.0 {
                        share *= passed(way.sqrt(), nm);
                    }
                }
                let found = end.weight / all.weight;
                assert!((found - share).abs() < 2e-5, "{name} {nm} {i}: {found}, not {share}");
                let double =
                    exact.ray_path(&sample(i)).expect("a lit point").end.expect("it passes");
                assert!((double.weight / end.weight - 1.0).abs() < 1e-4, "{name} {i}");
                assert!(share < 0.99, "{name} {i}: {share}");
                through += 1;
            }
            assert!(through > 20, "{name}: {through}");
        }
    }
}

#[test]
fn glass_without_transmittances_and_traces_without_losses_absorb_nothing() {
    let ray = [[[0.1, 0.2, 0.0], [0.0, 0.0, 1.0]]];
    let dark = plate();
    let mut clear = dark.clone();
    clear.rows[1].glass = Glass::from(find_glass("N-BK7").expect("listed"));
    clear.rows[1].index = dark.rows[1].index;
    assert_eq!(weights_at::<f32x8>(&clear, 15.0, 550.0, &ray)[0], Some(1.0));
    let surfaces = sequence_at::<f64>(&dark, Side::Film(15.0), 550.0);
    assert_eq!(trace_one(LensRay::new(ray[0][0], ray[0][1]), &surfaces).expect("free").weight, 1.0);
}

#[test]
fn the_t_stop_has_the_absorption_of_its_wavelength() {
    let folder = folder();
    write(&folder, "dark.agf", DARK);
    let text = "name = \"singlet\"\nwavelengths = [[400, 1], [550, 1], [700, 1]]\n\
        [[surface]]\nradius = inf\nthickness = 1\ndiameter = 10\nstop = true\n\
        [[surface]]\nradius = 50\nthickness = 12\ndiameter = 20\nglass = \"DARK\"\n\
        [[surface]]\nradius = -50\nthickness = 0\ndiameter = 20\n";
    write(&folder, "lens.toml", text);
    let arguments = ["lens", "lens.toml", "--catalogue", "dark.agf", "--coating", "perfect"];
    let (code, out, err) = petzval(folder.path(), &arguments);
    assert_eq!(code, 0, "{err}");
    for nm in [400.0, 550.0, 700.0] {
        // Rays fill a disk of radius 5 mm: the mean sag of each face is 5^2 / (4 r).
        let expected = 100.0 * passed(12.0 - 2.0 * 25.0 / 200.0, nm);
        let lines = out.lines().filter(|line| line.contains("% transmitted"));
        let shares: Vec<f64> = lines
            .map(|line| line.split(" % transmitted").next().expect("text"))
            .map(|line| line.rsplit(['(', ' ']).next().expect("a number").parse().expect(line))
            .collect();
        assert_eq!(shares.len(), 3, "{out}");
        assert!(shares.iter().any(|share| (share - expected).abs() < 0.1), "{nm}: {shares:?}");
    }
    assert!(out.contains("absorption of 1 glass"), "{out}");
}

#[test]
fn a_lens_keeps_its_absorption_in_a_file() {
    let folder = folder();
    write(&folder, "dark.agf", DARK);
    let text = "[[surface]]\nradius = 50\nthickness = 12\ndiameter = 20\nglass = \"DARK\"\nstop = true\n\
        [[surface]]\nradius = -50\nthickness = 0\ndiameter = 20\n";
    write(&folder, "lens.toml", text);
    let arguments = ["lens", "convert", "lens.toml", "--catalogue", "dark.agf", "-o", "other.toml"];
    let (code, _, err) = petzval(folder.path(), &arguments);
    assert_eq!(code, 0, "{err}");
    let read = petzval_lens_formats::read(&folder.path().join("other.toml")).expect("a lens");
    for nm in [380.0, 400.0, 480.0, 620.0, 800.0] {
        assert_eq!(read.rows[0].glass.absorption(nm), dark().absorption.coefficient(nm));
    }
    let file = folder.path().join("other.toml");
    let text = std::fs::read_to_string(&file).expect("text");
    std::fs::write(&file, text.replace("0.5, 25", "1.5, 25")).expect("a file");
    let (code, _, err) = petzval(folder.path(), &["lens", "other.toml"]);
    assert!(code == 2 && err.contains("the share 1.5 of 25 mm at 550 nm"), "{code}: {err}");
}

#[test]
fn an_invalid_transmittance_is_left_out_with_a_warning() {
    let folder = folder();
    write(&folder, "dark.agf", DARK.replace("IT 0.55 0.50 25", "IT 0.55 -999 25\nIT 0.56 0.5"));
    let text = "[[surface]]\nradius = 50\nthickness = 12\ndiameter = 20\nglass = \"DARK\"\nstop = true\n\
        [[surface]]\nradius = -50\nthickness = 0\ndiameter = 20\n";
    write(&folder, "lens.toml", text);
    let (code, _, err) = petzval(folder.path(), &["lens", "lens.toml", "--catalogue", "dark.agf"]);
    assert_eq!(code, 0, "{err}");
    assert!(
        err.contains("2 IT lines of dark DARK, the first in line 6") && err.contains("surface 1"),
        "{err}"
    );
}

#[test]
fn a_report_has_the_transmittance_of_each_wavelength_and_field() {
    let folder = folder();
    write(&folder, "dark.agf", DARK);
    let text = "name = \"singlet\"\nwavelengths = [[400, 1], [550, 1], [700, 1]]\n\
        [[fields]]\nkind = \"angle\"\npoints = [[0, 0], [0, 10]]\n\
        [[surface]]\nradius = inf\nthickness = 1\ndiameter = 4\nstop = true\n\
        [[surface]]\nradius = 50\nthickness = 12\ndiameter = 20\nglass = \"DARK\"\ncoating = \"perfect\"\n\
        [[surface]]\nradius = -50\nthickness = 0\ndiameter = 20\ncoating = \"perfect\"\n";
    write(&folder, "lens.toml", text);
    let arguments =
        ["lens", "report", "lens.toml", "--catalogue", "dark.agf", "--json", "transmittance"];
    let (code, out, err) = petzval(folder.path(), &arguments);
    assert_eq!(code, 0, "{err}");
    let section: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    let rows = |table: usize| -> Vec<Vec<f64>> {
        let rows = section["tables"][table]["rows"].as_array().expect("rows");
        let numbers = |row: &serde_json::Value| {
            let cells = row.as_array().expect("cells").iter();
            cells.map(|cell| cell.as_f64().expect("a number")).collect()
        };
        rows.iter().map(numbers).collect()
    };
    let axial = rows(0);
    // Rays fill a disk of radius 2 mm: the mean sag of each face is 2^2 / (4 r).
    let expected = |nm: f64| passed(12.0 - 2.0 * 4.0 / 200.0, nm);
    // The text of the lens has the same T-stops.
    let (_, text, _) = petzval(folder.path(), &["lens", "lens.toml", "--catalogue", "dark.agf"]);
    let stops = text.lines().filter(|line| line.contains("% transmitted"));
    let stops: Vec<f64> = stops
        .map(|line| line.trim_start_matches("T-stop").split_whitespace().next().expect("a number"))
        .map(|word| word.parse().expect("a number"))
        .collect();
    for row in &axial {
        assert!((row[1] / expected(row[0]) - 1.0).abs() < 2e-3, "{row:?}");
        assert!(stops.iter().any(|stop| (row[2] / stop - 1.0).abs() < 2e-4), "{row:?}, {stops:?}");
    }
    let fields = rows(1);
    for (i, row) in axial.iter().enumerate() {
        assert_eq!(fields[0][1 + i], row[1]);
        // Oblique rays cross more glass, the darker the more.
        let edge = fields[fields.len() - 1][1 + i] / row[1];
        assert!(edge < 1.0 && edge > 0.9, "{} nm: {edge}", row[0]);
    }
}
