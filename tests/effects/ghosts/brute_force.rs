//! Naive tracer of every path with two reflections, and the comparison of ghosts with it.

use glam::DVec3;
use petzval_lens::{Coating, LensModel, Pose, Prescription};
use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_spectrum::{
    BAND_RANGE, BANDS, D_LINE, LightBand, bands, colour_matching, named_spectrum, srgb_from_xyz,
};

use super::{FILM, FOCUS, LENS, PIXELS, blocks, coated, ghosts, green, job, picture_of_ghosts};
use crate::support::reference::{reference, within};
use crate::support::thin_film::{films, reflectances};
use crate::support::{Random, picture};

/// A ray of the naive tracer, in mm. +z points to the film; the front vertex is at z = 0.
#[derive(Clone, Copy)]
struct NaiveRay {
    p: [f64; 3],
    d: [f64; 3],
    share: f64,
    /// Wavelength (nm).
    nm: f64,
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Traces light until it leaves the lens towards the film after two reflections. `next` is the next row;
/// `forward` is true towards the film.
fn trace_reflections(
    lens: &Prescription,
    ray: NaiveRay,
    next: i32,
    forward: bool,
    reflections: u32,
    found: &mut impl FnMut(NaiveRay),
) {
    if next < 0 {
        return;
    }
    let rows = &lens.rows;
    if next as usize == rows.len() {
        if reflections == 2 {
            found(ray);
        }
        return;
    }
    let row = &rows[next as usize];
    let vertex: f64 = rows[..next as usize].iter().map(|row| row.thickness).sum();
    let onward = if forward { next + 1 } else { next - 1 };
    let at = |s: f64| [0, 1, 2].map(|i| ray.p[i] + s * ray.d[i]);
    let (p, normal) = if row.radius.is_infinite() {
        (at((vertex - ray.p[2]) / ray.d[2]), [0.0, 0.0, 1.0])
    } else if row.conic != 0.0 || row.axis.is_some() || !row.asphere.is_empty() {
        // Newton's method finds the intersection.
        let mut s = (vertex - ray.p[2]) / ray.d[2];
        for _ in 0..8 {
            let [x, y, z] = at(s);
            let [gx, gy] = row.gradient(x, y);
            s -= (z - vertex - row.sag_at(x, y)) / (ray.d[2] - gx * ray.d[0] - gy * ray.d[1]);
        }
        let p = at(s);
        let [gx, gy] = row.gradient(p[0], p[1]);
        let length = (1.0 + gx * gx + gy * gy).sqrt();
        (p, [-gx / length, -gy / length, 1.0 / length])
    } else {
        let centre = [0.0, 0.0, vertex + row.radius];
        let m = [0, 1, 2].map(|i| ray.p[i] - centre[i]);
        let (b, c) = (dot(m, ray.d), dot(m, m) - row.radius * row.radius);
        let disc = b * b - c;
        if disc <= 0.0 {
            return;
        }
        // The intersection on the cap at the vertex.
        let near = |s: &f64| (at(*s)[2] - vertex).abs() < row.radius.abs();
        let Some(s) = [-b - disc.sqrt(), -b + disc.sqrt()].into_iter().find(near) else { return };
        let p = at(s);
        (p, [0, 1, 2].map(|i| (p[i] - centre[i]) / row.radius))
    };
    if p[0].hypot(p[1]) > row.diameter / 2.0 {
        return;
    }
    let [before, behind] = lens.indices(next as usize);
    let (n, n_after) = if forward { (before, behind) } else { (behind, before) };
    if n == n_after {
        return trace_reflections(lens, NaiveRay { p, ..ray }, onward, forward, reflections, found);
    }
    // The normal points against the ray.
    let facing = if dot(normal, ray.d) > 0.0 { normal.map(|v| -v) } else { normal };
    let cos = -dot(facing, ray.d);
    let sin2 = (n / n_after).powi(2) * (1.0 - cos * cos);
    let reflectance = if sin2 >= 1.0 {
        1.0
    } else {
        let films = match &row.coating {
            Some(Coating::Stack(stack)) => films(stack, [n, n_after], ray.nm),
            _ => Vec::new(),
        };
        let [s, p] = reflectances(n, &films, n_after, cos.min(1.0).acos());
        (s + p) / 2.0
    };
    if reflections < 2 {
        let d = [0, 1, 2].map(|i| ray.d[i] + 2.0 * cos * facing[i]);
        let share = ray.share * reflectance;
        let back = if forward { next - 1 } else { next + 1 };
        trace_reflections(
            lens,
            NaiveRay { p, d, share, ..ray },
            back,
            !forward,
            reflections + 1,
            found,
        );
    }
    if sin2 < 1.0 {
        let ratio = n / n_after;
        let along = ratio * cos - (1.0 - sin2).sqrt();
        let d = [0, 1, 2].map(|i| ratio * ray.d[i] + along * facing[i]);
        let share = ray.share * (1.0 - reflectance);
        trace_reflections(
            lens,
            NaiveRay { p, d, share, ..ray },
            onward,
            forward,
            reflections,
            found,
        );
    }
}

/// Returns the film irradiance by pixel of a point light of intensity 1 and a wavelength (nm), at a point in
/// camera space, mm, through a lens that is tilted and decentred as a whole.
fn brute_force(job: &Job, pose: Pose, light: [f64; 3], nm: f64, side: u32) -> Vec<f64> {
    let LensModel::Real(lens) = &job.camera.model else { panic!("a real lens") };
    let square = lens.prescription.centred();
    let half = square.rows[0].diameter / 2.0;
    let motion = pose.transform();
    let light = DVec3::new(light[0], light[1], lens.front_depth / lens.units_per_mm - light[2]);
    let light = motion.inverse().transform_point3(light).to_array();
    let film_at = square.length() + lens.film_distance;
    let mut numbers = Random::new(5);
    let mut film = vec![0.0; PIXELS * PIXELS];
    let pixel = FILM / PIXELS as f64;
    // Points are uniform in a square in front of the front surface, which every ray to it crosses. All in
    // the frame of the lens.
    for i in 0..side * side {
        let cell = [i % side, i / side];
        let [x, y] = cell.map(|cell| {
            let share = (f64::from(cell) + numbers.next()) / f64::from(side);
            (2.0 * share - 1.0) * 1.2 * half
        });
        let p = [x, y, -1.0];
        let d = [0, 1, 2].map(|i| p[i] - light[i]);
        let length = dot(d, d).sqrt();
        let d = d.map(|v| v / length);
        // Irradiance of the square, in units of the camera, for a light of 1 W/sr.
        let flux =
            d[2] / (length * length * lens.units_per_mm * lens.units_per_mm) * (2.4 * half).powi(2);
        let ray = NaiveRay { p, d, share: flux / f64::from(side * side), nm };
        let mut found = |NaiveRay { p, d, share, .. }: NaiveRay| {
            let p = motion.transform_point3(p.into());
            let d = motion.transform_vector3(d.into());
            let [x, y, _] = (p + d * ((film_at - p.z) / d.z)).to_array();
            let column = ((FILM / 2.0 - x) / pixel).floor();
            let row = ((FILM / 2.0 + y) / pixel).floor();
            let inside = |i: f64| i >= 0.0 && i < PIXELS as f64;
            if inside(column) && inside(row) {
                film[row as usize * PIXELS + column as usize] += share / (pixel * pixel);
            }
        };
        trace_reflections(&square, ray, 0, true, 0, &mut found);
    }
    film
}

/// A point outside the field of view, so that only ghosts of its light reach the film (camera space, m).
const OUTSIDE: [f64; 3] = [0.35, 0.2, 1.0];
/// Effects that the naive tracer leaves out.
const WITHOUT: &str = "-ghosts,-fresnel,-dispersion,-diffraction";

fn point_light([x, y, z]: [f64; 3]) -> String {
    format!(r#"LightSource "point" "rgb I" [1 1 1] "point3 from" [{x} {y} {z}]"#)
}

/// Compares ghosts of a point light with brute force, block by block, which `tests/references/ghosts.csv`
/// keeps. The pose is that of the whole lens.
fn compare(name: &str, lens: &str, pose: Pose, from: [f64; 3]) {
    let Pose { decentre, tilt } = pose;
    let group = format!("[[askew]]\nsurfaces = [1, 5]\ndecentre = {decentre:?}\ntilt = {tilt:?}\n");
    let lens = format!("{lens}{group}");
    let job = job(&lens, &point_light(from), WITHOUT, 16);
    let dark = green(&picture(&job, Backend::Simd, 1));
    assert!(dark.iter().all(|&v| v == 0.0), "the light itself is in the picture");
    let found = blocks(&ghosts(&job, 16_384), 8);
    let scale = job.camera.imaging_ratio;
    let subject = (&lens, from, PIXELS, FILM, FOCUS);
    let expected =
        reference("ghosts", &format!("{name}, 16 blocks"), subject, within(1e-4), || {
            let film = brute_force(&job, pose, from.map(|v| 1e3 * v), D_LINE, 1200);
            blocks(&film, 8).iter().map(|light| light * scale).collect()
        });
    let most = expected.iter().fold(0.0, |a: f64, &b| a.max(b));
    let sums = [&found, &expected].map(|blocks| blocks.iter().sum::<f64>());
    println!("{sums:?}, brightest block {most}");
    assert!(most > 0.0 && (sums[0] / sums[1] - 1.0).abs() < 0.005, "{sums:?}");
    for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
        let allowed = 0.01 * expected + 0.003 * most;
        assert!((found - expected).abs() < allowed, "block {i}: {found}, not {expected}");
    }
}

#[test]
fn ghosts_of_a_point_light_agree_with_brute_force() {
    compare("spheres", LENS, Pose::ALIGNED, OUTSIDE);
}

#[test]
fn ghosts_of_every_kind_of_surface_agree_with_brute_force() {
    let shaped = LENS
        .replacen("radius = 40.0", "radius = 40.0\nconic = -1.5", 1)
        .replacen("radius = -90.0", "radius = -90.0\nasphere = [[4, 1e-5], [6, -2e-8]]", 1)
        .replacen("radius = 70.0", "radius = 70.0\nasphere = [[3, 2e-4], [4, 1e-5]]", 1)
        .replacen("radius = -60.0", "radius = -60.0\naxis = \"x\"", 1);
    compare("surfaces of every kind", &shaped, Pose::ALIGNED, OUTSIDE);
}

#[test]
fn ghosts_of_a_tilted_lens_agree_with_brute_force() {
    let pose = Pose { decentre: [6.0, -2.0], tilt: [4.0, 8.0] };
    compare("tilted lens", LENS, pose, OUTSIDE);
}

/// Quarter, half and quarter wave: green light passes, violet and red are reflected.
const FILMS: &str = r#"
    [[coating]]
    name = "three layers"
    layers = [
        { index = 1.38, thickness = 99.6 },
        { index = 2.15, thickness = 127.9 },
        { index = 1.7, thickness = 80.9 },
    ]
"#;

/// Returns the light of all ghosts of films of three layers under a white point light, in each of [`bands`]:
/// by brute force, which `tests/references/ghosts.csv` keeps.
fn ghosts_by_band(lens: &str, job: &Job) -> Vec<f64> {
    let subject = (lens, OUTSIDE, PIXELS, FILM, FOCUS);
    reference("ghosts", "three layers, bands", subject, within(1e-4), || {
        let of_band = |band: &LightBand| {
            let light = OUTSIDE.map(|v| 1e3 * v);
            let film = brute_force(job, Pose::ALIGNED, light, band.wavelength, 300);
            film.iter().sum::<f64>() * job.camera.imaging_ratio
        };
        bands().iter().map(of_band).collect()
    })
}

/// Lamps of other spectra than daylight.
#[test]
fn ghosts_by_wavelength_are_those_of_brute_force() {
    let lens = coated("three layers") + FILMS;
    let [x, y, z] = OUTSIDE;
    for name in ["stdillum-A", "stdillum-F2"] {
        let lamp =
            format!(r#"LightSource "point" "spectrum I" "{name}" "point3 from" [{x} {y} {z}]"#);
        let job = job(&lens, &lamp, &format!("+spectra,{WITHOUT}"), 1);
        let picture = picture_of_ghosts(&job, 16_384);
        let by_band = ghosts_by_band(&lens, &job);
        let step = bands()[1].wavelength - bands()[0].wavelength;
        // Cubic between the middles of the bands (Lagrange); the lens is traced at no wavelength beyond them.
        let ghosts_at = |nm: f64| {
            let x = (nm.clamp(BAND_RANGE[0], BAND_RANGE[1]) - bands()[0].wavelength) / step;
            let first = ((x - 1.0).max(0.0) as usize).min(by_band.len() - 4);
            let weight = |i: usize| {
                let others = (first..first + 4).filter(|&k| k != i);
                others.map(|k| (x - k as f64) / (i as f64 - k as f64)).product::<f64>()
            };
            (first..first + 4).map(|i| weight(i) * by_band[i]).sum::<f64>()
        };
        let spectrum = named_spectrum(name).expect("a known lamp");
        let mut expected = [0.0; 3];
        let (mut luminance, steps) = (0.0, 4700);
        for i in 0..steps {
            let nm = 360.0 + 0.1 * (f64::from(i) + 0.5);
            let xyz = colour_matching(nm).map(|v| v * spectrum.at(nm));
            luminance += xyz[1];
            let rgb = srgb_from_xyz(xyz);
            (0..3).for_each(|c| expected[c] += rgb[c] * ghosts_at(nm));
        }
        let expected = expected.map(|v| v / luminance);
        let most = expected.iter().fold(0.0f64, |a, &b| a.max(b));
        for (channel, expected) in expected.into_iter().enumerate() {
            let found: f64 = picture.pixels.iter().map(|p| f64::from(p[channel])).sum();
            println!("{name}, channel {channel}: {found:.6e}, {expected:.6e}");
            let allowed = 0.01 * expected.abs() + 0.002 * most;
            assert!((found - expected).abs() < allowed, "{name}: {found}, not {expected}");
        }
    }
}

#[test]
fn ghosts_of_coated_surfaces_have_the_hue_of_their_films() {
    let lens = coated("three layers") + FILMS;
    let job = job(&lens, &point_light(OUTSIDE), WITHOUT, 1);
    let picture = picture_of_ghosts(&job, 16_384);
    let mut expected = [0.0; 3];
    for (light, LightBand { response, .. }) in ghosts_by_band(&lens, &job).iter().zip(bands()) {
        (0..3).for_each(|c| expected[c] += response[c] * light / BANDS as f64);
    }
    for (channel, expected) in expected.into_iter().enumerate() {
        let found: f64 = picture.pixels.iter().map(|pixel| f64::from(pixel[channel])).sum();
        println!("channel {channel}: {found:.6e}, {expected:.6e}");
        assert!((found / expected - 1.0).abs() < 0.01, "channel {channel}: {found}, {expected}");
    }
}
