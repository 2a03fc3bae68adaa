//! Ghosts against brute force: every way that light can take through a lens of two elements, by
//! textbook formulas.

mod support;

use glam::DVec3;
use petzval::film::{FilmSums, Frame};
use petzval::ghosts::{pairs, survey};
use petzval::image::Picture;
use petzval::job::{Changes, prepare};
use petzval::lanes::f32x8;
use petzval::lens::{Coating, Model, Pose, Prescription};
use petzval::plan::{Effect, Harm};
use petzval::render::{Backend, Job, Progress};
use petzval::scene::pbrt;
use petzval::spectrum::bands;
use petzval::stats::Stats;
use support::{Random, folder, picture, write};

/// Two uncoated elements and a stop between them.
const LENS: &str = r#"
name = "two elements"
[[surface]]
radius = 40.0
thickness = 5.0
diameter = 24.0
index = 1.6
coating = "none"
[[surface]]
radius = -90.0
thickness = 4.0
diameter = 24.0
[[surface]]
stop = true
thickness = 4.0
diameter = 14.0
[[surface]]
radius = 70.0
thickness = 4.0
diameter = 22.0
index = 1.7
[[surface]]
radius = -60.0
thickness = 30.0
diameter = 22.0
"#;

const PIXELS: usize = 32;
/// Side of the film, mm.
const FILM: f64 = 30.0;
/// Film behind the rear vertex, mm; the scene's focus is chosen for it.
const FOCUS: f64 = 3.0;

fn job(lens: &str, world: &str, effects: &str, samples: u32) -> Job {
    let folder = folder();
    write(&folder, "two.toml", lens);
    let text = format!(
        r#"Film "rgb" "integer xresolution" {PIXELS} "integer yresolution" {PIXELS}
               "float diagonal" {} "float iso" 100
           PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
           Sampler "sobol" "integer pixelsamples" {samples}
           Camera "realistic" "string lensfile" "two.toml"
               "float aperturediameter" 14 "float focusdistance" {FOCUS}
           WorldBegin {world}"#,
        FILM * 2f64.sqrt()
    );
    let description = pbrt::read(&write(&folder, "two.pbrt", text)).expect("a scene");
    let changes = Changes { effects: effects.parse().expect("effects"), ..Changes::default() };
    prepare(description, &changes).expect("a job").0
}

/// A ray of the naive twin: mm, +z to the film, the front vertex at z = 0.
#[derive(Clone, Copy)]
struct Naive {
    p: [f64; 3],
    d: [f64; 3],
    share: f64,
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Follows light to where it leaves the lens for the film after two mirrorings. `next` is the row
/// ahead, `forward` whether it goes to the film.
fn follow(
    lens: &Prescription,
    ray: Naive,
    next: i32,
    forward: bool,
    mirrorings: u32,
    found: &mut impl FnMut(Naive),
) {
    if next < 0 {
        return;
    }
    let rows = &lens.rows;
    if next as usize == rows.len() {
        if mirrorings == 2 {
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
        // Newton's way to where the ray is on the surface.
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
        // The cap at the vertex.
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
        return follow(lens, Naive { p, ..ray }, onward, forward, mirrorings, found);
    }
    // Against the ray.
    let facing = if dot(normal, ray.d) > 0.0 { normal.map(|v| -v) } else { normal };
    let cos = -dot(facing, ray.d);
    let sin2 = (n / n_after).powi(2) * (1.0 - cos * cos);
    let reflectance = if sin2 >= 1.0 {
        1.0
    } else {
        let cos_after = (1.0 - sin2).sqrt();
        let s = (n * cos - n_after * cos_after) / (n * cos + n_after * cos_after);
        let p = (n_after * cos - n * cos_after) / (n_after * cos + n * cos_after);
        (s * s + p * p) / 2.0
    };
    if mirrorings < 2 {
        let d = [0, 1, 2].map(|i| ray.d[i] + 2.0 * cos * facing[i]);
        let share = ray.share * reflectance;
        let back = if forward { next - 1 } else { next + 1 };
        follow(lens, Naive { p, d, share }, back, !forward, mirrorings + 1, found);
    }
    if sin2 < 1.0 {
        let ratio = n / n_after;
        let along = ratio * cos - (1.0 - sin2).sqrt();
        let d = [0, 1, 2].map(|i| ratio * ray.d[i] + along * facing[i]);
        let share = ray.share * (1.0 - reflectance);
        follow(lens, Naive { p, d, share }, onward, forward, mirrorings, found);
    }
}

/// Film irradiance by pixel of the light of a lamp of intensity 1 at a place of the camera's
/// space, mm, behind a lens that stands askew as a whole.
fn brute_force(job: &Job, pose: Pose, lamp: [f64; 3], side: u32) -> Vec<f64> {
    let Model::Real(lens) = &job.camera.model else { panic!("a real lens") };
    let square = lens.prescription.centred();
    let half = square.rows[0].diameter / 2.0;
    let motion = pose.motion();
    let lamp = DVec3::new(lamp[0], lamp[1], lens.front / lens.unit - lamp[2]);
    let lamp = motion.inverse().transform_point3(lamp).to_array();
    let film_at = square.length() + lens.film_distance;
    let mut numbers = Random::new(5);
    let mut film = vec![0.0; PIXELS * PIXELS];
    let pixel = FILM / PIXELS as f64;
    // Evenly over a square before the front surface, which every ray to it crosses: they come from
    // near the axis. All in the frame of the lens.
    for i in 0..side * side {
        let cell = [i % side, i / side];
        let [x, y] = cell.map(|cell| {
            let share = (f64::from(cell) + numbers.next()) / f64::from(side);
            (2.0 * share - 1.0) * 1.2 * half
        });
        let p = [x, y, -1.0];
        let d = [0, 1, 2].map(|i| p[i] - lamp[i]);
        let length = dot(d, d).sqrt();
        let d = d.map(|v| v / length);
        // Irradiance of the square, in the square of the camera's units to a lamp of W/sr.
        let flux = d[2] / (length * length * lens.unit * lens.unit) * (2.4 * half).powi(2);
        let ray = Naive { p, d, share: flux / f64::from(side * side) };
        let mut found = |Naive { p, d, share }: Naive| {
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
        follow(&square, ray, 0, true, 0, &mut found);
    }
    film
}

fn green(picture: &Picture) -> Vec<f64> {
    picture.pixels.iter().map(|pixel| f64::from(pixel[1])).collect()
}

/// Means over squares of pixels.
fn blocks(pixels: &[f64], side: usize) -> Vec<f64> {
    let count = PIXELS / side;
    let mut means = vec![0.0; count * count];
    for (i, value) in pixels.iter().enumerate() {
        let (x, y) = (i % PIXELS / side, i / PIXELS / side);
        means[y * count + x] += value / (side * side) as f64;
    }
    means
}

/// The ghosts alone, of all pairs, in green.
fn ghosts(job: &Job, samples: u32) -> Vec<f64> {
    let Model::Real(lens) = &job.camera.model else { panic!("a real lens") };
    let ghosts = survey(job).expect("ghosts").all(lens, &bands());
    let job = Job { samples: 0..samples, ..job.clone() };
    let mut film = FilmSums::new(job.frame, false);
    ghosts.expose::<f32x8>(
        &job,
        job.samples.clone(),
        &mut film,
        &mut Stats::default(),
        &Progress::default(),
    );
    green(&film.picture(samples))
}

/// Compares ghosts of a lamp with brute force, block by block; the lens stands so as a whole.
fn compare(lens: &str, pose: Pose, from: [f64; 3]) {
    let [x, y, z] = from;
    let world = format!(r#"LightSource "point" "rgb I" [1 1 1] "point3 from" [{x} {y} {z}]"#);
    let Pose { decentre, tilt } = pose;
    let askew = format!("[[askew]]\nsurfaces = [1, 5]\ndecentre = {decentre:?}\ntilt = {tilt:?}\n");
    let lens = format!("{lens}{askew}");
    let job = job(&lens, &world, "-ghosts,-fresnel,-dispersion,-diffraction", 16);
    let dark = green(&picture(&job, Backend::Simd, 2));
    assert!(dark.iter().all(|&v| v == 0.0), "the lamp itself is not seen");
    let found = blocks(&ghosts(&job, 16_384), 8);
    let scale = job.camera.imaging_ratio;
    let expected = brute_force(&job, pose, from.map(|v| 1e3 * v), 1200);
    let expected: Vec<f64> = blocks(&expected, 8).iter().map(|light| light * scale).collect();
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
fn the_ghosts_of_a_lamp_are_as_bright_as_by_brute_force() {
    // Beside the field of view, so that only ghosts come to the film.
    compare(LENS, Pose::SQUARE, [0.35, 0.2, 1.0]);
}

#[test]
fn every_kind_of_surface_mirrors_as_its_normal_says() {
    let shaped = LENS
        .replacen("radius = 40.0", "radius = 40.0\nconic = -1.5", 1)
        .replacen("radius = -90.0", "radius = -90.0\nasphere = [[4, 1e-5], [6, -2e-8]]", 1)
        .replacen("radius = 70.0", "radius = 70.0\nasphere = [[3, 2e-4], [4, 1e-5]]", 1)
        .replacen("radius = -60.0", "radius = -60.0\naxis = \"x\"", 1);
    compare(&shaped, Pose::SQUARE, [0.35, 0.2, 1.0]);
}

#[test]
fn a_front_surface_that_stands_askew_takes_as_much_light() {
    let pose = Pose { decentre: [6.0, -2.0], tilt: [4.0, 8.0] };
    compare(LENS, pose, [0.35, 0.2, 1.0]);
}

#[test]
fn only_surfaces_that_reflect_make_pairs() {
    let job = job(LENS, "", "none", 1);
    let Model::Real(lens) = &job.camera.model else { panic!("a real lens") };
    let mut lens = lens.prescription.clone();
    // Not the stop: [0, 1], [0, 3], [1, 3], [0, 4], [1, 4], [3, 4].
    assert_eq!(pairs(&lens), [[0, 1], [0, 3], [1, 3], [0, 4], [1, 4], [3, 4]]);
    lens.rows[3].coating = Some(Coating::Perfect);
    assert_eq!(pairs(&lens), [[0, 1], [0, 4], [1, 4]]);
}

/// A lamp of three kinds at the same place, 1 m away, with the same intensity of 1.
fn lamps() -> [String; 3] {
    let [x, y, z] = [0.35f64, 0.2, 1.0];
    let distance2 = x * x + y * y + z * z;
    let radius: f64 = 0.004;
    let radiance = 1.0 / (std::f64::consts::PI * radius * radius);
    let far = 1.0 / distance2;
    [
        format!(r#"LightSource "point" "rgb I" [1 1 1] "point3 from" [{x} {y} {z}]"#),
        format!(
            r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [{radiance} {radiance} {radiance}]
               Translate {x} {y} {z} Shape "sphere" "float radius" {radius} AttributeEnd"#
        ),
        format!(
            r#"LightSource "distant" "rgb L" [{far} {far} {far}]
               "point3 from" [{x} {y} {z}] "point3 to" [0 0 0]"#
        ),
    ]
}

#[test]
fn balls_points_and_far_lights_make_the_same_ghosts() {
    let sum = |world: &str| ghosts(&job(LENS, world, "none", 16), 4096).iter().sum::<f64>();
    let [point, ball, far] = lamps().map(|world| sum(&world));
    println!("{point} {ball} {far}");
    assert!((ball / point - 1.0).abs() < 0.01, "{ball}, not {point}");
    // From 1 m away the front of the lens, 60 mm before the camera's origin, is nearer and the
    // light is not parallel.
    assert!((far / point - 1.0).abs() < 0.2, "{far}, not {point}");
}

#[test]
fn what_stands_before_the_lamp_takes_its_ghosts() {
    let [point, ..] = lamps();
    let wall = r#"AttributeBegin Translate 0 0 0.5 Shape "disk" "float radius" 3 AttributeEnd"#;
    assert!(survey(&job(LENS, &point, "none", 1)).is_some());
    assert!(survey(&job(LENS, &format!("{point}\n{wall}"), "none", 1)).is_none());
}

/// A lamp and something to see it on.
fn lit() -> String {
    let [point, ..] = lamps();
    let wall = r#"AttributeBegin Translate 0 0 3.1 Shape "disk" "float radius" 3 AttributeEnd"#;
    format!("{point}\n{wall}")
}

#[test]
fn ghosts_are_the_same_for_threads_lanes_and_parts() {
    let job = job(LENS, &lit(), "+ghosts", 32);
    assert!(job.ghosts.is_some());
    let whole = picture(&job, Backend::Simd, 2);
    assert_eq!(whole.pixels, picture(&job, Backend::Scalar, 1).pixels, "bit for bit");
    let part = Job { frame: Frame { low: [3, 5], high: [20, 17], ..job.frame }, ..job.clone() };
    let part = picture(&part, Backend::Simd, 2);
    for y in 0..12 {
        let row = (y + 5) * PIXELS + 3;
        assert_eq!(part.pixels[y * 17..(y + 1) * 17], whole.pixels[row..row + 17]);
    }
    let of = |samples| green(&picture(&Job { samples, ..job.clone() }, Backend::Simd, 2));
    let halves = [of(0..16), of(16..32)];
    for (i, whole) in green(&whole).iter().enumerate() {
        let mean = (halves[0][i] + halves[1][i]) / 2.0;
        assert!((mean - whole).abs() < 1e-5 * whole.abs(), "{mean} {whole}");
    }
}

#[test]
fn the_plan_says_how_bright_ghosts_are() {
    let with = job(LENS, &lit(), "auto", 4096);
    let decision = with.plan.effects.iter().find(|d| d.effect == Effect::Ghosts).expect("a row");
    println!("{decision:?}");
    let Some(Harm::Signal(said)) = decision.error else { panic!("an estimate: {decision:?}") };
    assert!(decision.on && said > 1.0, "{decision:?}");
    let without = green(&picture(&job(LENS, &lit(), "-ghosts", 256), Backend::Simd, 2));
    let mean = without.iter().sum::<f64>() / without.len() as f64;
    let most = blocks(&ghosts(&with, 4096), 4).into_iter().fold(0.0, f64::max);
    let seen = 100.0 * most / mean;
    println!("{said:.2} % said, {seen:.2} % seen");
    assert!(said / seen < 1.5 && seen / said < 1.5, "{said} {seen}");
}

#[test]
fn a_good_coating_makes_ghosts_not_worth_it() {
    let coated = LENS
        .replace("\ncoating = \"none\"", "")
        .replace("index = 1.", "coating = \"broadband\"\nindex = 1.");
    // The faces behind glass too.
    let lens = coated.replace("radius = -90.0", "radius = -90.0\ncoating = \"broadband\"");
    let lens = lens.replace("radius = -60.0", "radius = -60.0\ncoating = \"broadband\"");
    let job = job(&lens, &lit(), "auto", 1);
    let decision = job.plan.effects.iter().find(|d| d.effect == Effect::Ghosts).expect("a row");
    println!("{decision:?}");
    let Some(Harm::Signal(said)) = decision.error else { panic!("an estimate: {decision:?}") };
    assert!(!decision.on && job.ghosts.is_none() && said < 1.0, "{decision:?}");
}
