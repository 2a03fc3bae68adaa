//! Hairs through the four lenses: the mean of a picture beside that of a naive path tracer in f64,
//! which takes over nothing but the rays that leave the lens.

use std::f64::consts::PI;

use glam::DVec3;
use petzval_base::lanes::f32x8;
use petzval_base::rays::RayBatch;
use petzval_base::stats::LensStats;
use petzval_lens::LensColumns;
use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_render::prepare::prepare;
use petzval_render::shade::bsdf::HairParameters;
use petzval_scene::{CurveKind, CurveSegment};
use petzval_scene_formats::pbrt;

use super::naive::{NaiveHit, hits_between, point, slope};
use super::naive_hair::NaiveHair;
use crate::support::reference::{reference, within};
use crate::support::sampling::random_samples;
use crate::support::{Random, folder, in_parallel, lens, mean, picture, root, write};

/// Lenses with their focal lengths (mm).
const LENSES: [(&str, f64); 4] = [
    ("dgauss.50mm", 50.0),
    ("fisheye.10mm", 10.0),
    ("telephoto.250mm", 250.0),
    ("wide.22mm", 22.0),
];
/// Distance of the hairs, m.
const DISTANCE: f64 = 4.0;
/// Diagonal of the film, mm.
const DIAGONAL: f64 = 12.0;
const DEPTH: u32 = 3;
const SKY: [f64; 3] = [0.5, 0.6, 0.7];
/// Direction to the sun, and its irradiance.
const SUN: [f64; 3] = [1.0, 2.0, -2.0];
const SUNLIGHT: [f64; 3] = [3.0, 2.5, 2.0];
const HAIR: HairParameters<f32> = HairParameters {
    absorption: [0.1, 0.2, 0.5],
    eta: 1.55,
    beta_m: 0.7,
    beta_n: 0.7,
    tilt: 2.0,
    offset: 0.0,
};
/// Samples a pixel of the program's pictures, of 32 x 32 pixels, and waves of naive rays.
const SAMPLES: u32 = 400;
const WAVES: u32 = 260;
/// Largest [`SIGMAS`] standard errors relative to the mean.
const PRECISION: f64 = 0.01;
/// By chance, a comparison fails once in a million runs.
const SIGMAS: f64 = 5.0;
/// Parts of a segment with a bounding sphere each.
const PARTS: u32 = 16;

/// Returns hairs that hang down before the lens, as wide as its field.
fn hairs(focal_length: f64) -> Vec<CurveSegment> {
    let reach = DISTANCE * DIAGONAL / 2.0 / focal_length;
    let mut random = Random::new(12);
    (0..9)
        .map(|i| {
            let x = f64::from(i) / 4.0 - 1.0;
            let mut bend = |y: f64| {
                let [dx, dz] = [(); 2].map(|()| random.between(-0.25, 0.25));
                let p = DVec3::new(0.7 * x + dx, y, dz) * reach + DVec3::Z * DISTANCE;
                // As the file states it.
                p.as_vec3().as_dvec3()
            };
            let control = [bend(0.8), bend(0.3), bend(-0.3), bend(-0.8)];
            CurveSegment { control, width: [0.16 * reach, 0.08 * reach], normals: None }
        })
        .collect()
}

/// Returns the job of the hairs, or of a sky of radiance 1.
fn job(lens_name: &str, hairs: Option<&[CurveSegment]>) -> Job {
    let file = root().join(format!("lenses/{lens_name}.dat"));
    let diameter = lens(lens_name).rows.iter().find(|row| row.stop).map_or(5.0, |row| row.diameter);
    let list = |v: &[f64]| format!("{v:?}").replace(',', " ");
    let mut text = format!(
        r#"Film "rgb" "integer xresolution" 32 "integer yresolution" 32 "float diagonal" {DIAGONAL}
           PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
           Sampler "independent" "integer pixelsamples" {SAMPLES}
           Integrator "path" "integer maxdepth" {DEPTH}
           Camera "realistic" "string lensfile" "{}" "float aperturediameter" {diameter}
             "float focusdistance" {DISTANCE}
           WorldBegin
        "#,
        file.display()
    );
    let sky = if hairs.is_some() { SKY } else { [1.0; 3] };
    text += &format!("LightSource \"infinite\" \"rgb L\" {}\n", list(&sky));
    if hairs.is_some() {
        text += &format!(
            "LightSource \"distant\" \"point3 from\" {} \"point3 to\" [0 0 0] \"rgb L\" {}\n",
            list(&SUN),
            list(&SUNLIGHT)
        );
    }
    text += &format!(
        "Material \"hair\" \"rgb sigma_a\" {} \"float beta_m\" {} \"float beta_n\" {}\n",
        list(&HAIR.absorption.map(f64::from)),
        HAIR.beta_m,
        HAIR.beta_n
    );
    for hair in hairs.unwrap_or_default() {
        let points: Vec<f64> = hair.control.iter().flat_map(|p| p.to_array()).collect();
        let [from, to] = hair.width;
        text += &format!(
            "Shape \"curve\" \"point3 P\" {} \"float width0\" {from} \"float width1\" {to}\n",
            list(&points)
        );
    }
    let folder = folder();
    let description = pbrt::read(&write(&folder, "hairs.pbrt", &text)).expect("a scene");
    assert!(description.warnings.is_empty(), "{:#?}", description.warnings);
    prepare(description, &Default::default()).expect("a job").job
}

/// Hairs with bounding spheres around the parts of each.
struct NaiveWorld {
    hairs: Vec<CurveSegment>,
    spheres: Vec<(usize, u32, DVec3, f64)>,
    material: NaiveHair,
}

impl NaiveWorld {
    fn new(hairs: Vec<CurveSegment>) -> Self {
        let mut spheres = Vec::new();
        for (i, hair) in hairs.iter().enumerate() {
            for part in 0..PARTS {
                let at = |k: f64| point(hair, (f64::from(part) + k) / f64::from(PARTS));
                let centre = at(0.5);
                // The part is shorter than twice this, and no wider than the hair.
                let radius = at(0.0).distance(centre).max(at(1.0).distance(centre)) * 1.5;
                spheres.push((i, part, centre, radius + hair.width[0]));
            }
        }
        Self { hairs, spheres, material: NaiveHair::new(&HAIR) }
    }

    fn nearest(&self, origin: DVec3, along: DVec3) -> Option<(usize, NaiveHit)> {
        let mut nearest: Option<(usize, NaiveHit)> = None;
        for &(i, part, centre, radius) in &self.spheres {
            let offset = centre - origin;
            let t = offset.dot(along);
            if t < -radius || offset.length_squared() - t * t > radius * radius {
                continue;
            }
            let range = [part, part + 1].map(|k| f64::from(k) / f64::from(PARTS));
            for hit in hits_between(CurveKind::Flat, &self.hairs[i], range, 12, origin, along) {
                if nearest.is_none_or(|(_, nearest)| hit.t < nearest.t) {
                    nearest = Some((i, hit));
                }
            }
        }
        nearest
    }

    /// Returns the radiance along a ray. Directions are sampled uniformly.
    fn radiance(&self, mut origin: DVec3, mut along: DVec3, random: &mut Random) -> [f64; 3] {
        let (mut sum, mut left) = ([0.0; 3], [1.0; 3]);
        let sun = DVec3::from(SUN).normalize();
        for vertex in 0..=DEPTH {
            let Some((i, hit)) = self.nearest(origin, along) else {
                for c in 0..3 {
                    sum[c] += left[c] * SKY[c];
                }
                break;
            };
            if vertex == DEPTH {
                break;
            }
            let hair = &self.hairs[i];
            let x = slope(hair, hit.u).normalize();
            let z = (along - x * along.dot(x)).normalize();
            let y = z.cross(x);
            let local = |w: DVec3| [w.dot(x), w.dot(y), w.dot(z)];
            let material = self.material.at(hit.h.clamp(-1.0, 1.0));
            let [from, to] = hair.width;
            let width = from + (to - from) * hit.u;
            let away = width * (z.x.abs() + z.y.abs() + z.z.abs());
            let leave = |w: DVec3| origin + along * hit.t + z * away.copysign(w.dot(z));
            let wo = local(-along);
            if self.nearest(leave(sun), sun).is_none() {
                let value = material.value(wo, local(sun));
                for c in 0..3 {
                    sum[c] += left[c] * value[c] * SUNLIGHT[c];
                }
            }
            let (cos, turn) = (random.between(-1.0, 1.0), random.between(0.0, 2.0 * PI));
            let sin = (1.0 - cos * cos).sqrt();
            let next = DVec3::new(sin * turn.cos(), sin * turn.sin(), cos);
            let value = material.value(wo, local(next));
            left = [0, 1, 2].map(|c| left[c] * value[c] * 4.0 * PI);
            (origin, along) = (leave(next), next);
        }
        sum
    }
}

/// Returns the naive mean and its standard error, which `tests/references/curves.csv` keeps.
fn expected(name: &str, job: &Job, hairs: &[CurveSegment]) -> ([f64; 3], [f64; 3]) {
    let subject = (name, hairs, DIAGONAL, DEPTH, SKY, SUN, SUNLIGHT, HAIR.absorption, WAVES);
    let label = format!("hairs through {name}");
    let numbers = reference("curves", &label, subject, within(1e-3), || {
        let (mean, error) = naive(job, hairs.to_vec());
        [mean, error].concat()
    });
    ([0, 1, 2].map(|i| numbers[i]), [3, 4, 5].map(|i| numbers[i]))
}

/// Returns the weighted mean of the radiance over the rays of a camera, and its standard error.
fn naive(job: &Job, hairs: Vec<CurveSegment>) -> ([f64; 3], [f64; 3]) {
    let world = NaiveWorld::new(hairs);
    let mut random = Random::new(3);
    let (mut rays, mut columns) = (RayBatch::default(), LensColumns::default());
    let mut stats = LensStats::default();
    let (mut weights, mut means, mut squares) = (0.0, [0.0; 3], [0.0; 3]);
    for _ in 0..WAVES {
        let samples = random_samples(job.camera.film, &mut random);
        job.camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        let (mut weight, mut sum) = (0.0, [0.0; 3]);
        for i in 0..rays.len {
            let ray = rays.ray(i);
            let [origin, along] =
                [ray.origin, ray.direction].map(|v| DVec3::from_array(v.map(f64::from)));
            let radiance = world.radiance(origin, along.normalize(), &mut random);
            let share = f64::from(rays.throughput(i)[0]);
            weight += share;
            for c in 0..3 {
                sum[c] += share * radiance[c];
            }
        }
        weights += weight;
        for c in 0..3 {
            means[c] += sum[c];
            squares[c] += (sum[c] / weight).powi(2);
        }
    }
    let n = f64::from(WAVES);
    let mean = means.map(|sum| sum / weights);
    // The spread of the means of waves.
    let error = [0, 1, 2].map(|c| ((squares[c] / n - mean[c] * mean[c]).max(0.0) / n).sqrt());
    (mean, error)
}

#[test]
fn hairs_through_the_lenses_agree_with_a_naive_path_tracer() {
    in_parallel(&LENSES, |&(name, focal_length)| {
        let hairs = hairs(focal_length);
        let with_hairs = job(name, Some(&hairs));
        let found = mean(&picture(&with_hairs, Backend::Simd, 1));
        let white = mean(&picture(&job(name, None), Backend::Simd, 1));
        let (expected, error) = expected(name, &with_hairs, &hairs);
        for c in 0..3 {
            let (found, expected) = (found[c] / white[c], expected[c]);
            let off = (found / expected - 1.0).abs();
            let bound = SIGMAS * error[c] / expected;
            println!("{name}: {found:.5}, expected {expected:.5}, {off:.5} of {bound:.5}");
            assert!(bound < PRECISION, "{name}: known to {bound} only");
            assert!(off < PRECISION, "{name}: {found}, not {expected}");
            // The hairs cover much of the picture.
            assert!((expected / SKY[c] - 1.0).abs() > 0.02, "{name}: {expected}");
        }
    });
}
