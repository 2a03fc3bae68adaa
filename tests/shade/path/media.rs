//! Participating media: agreement with a naive path tracer, in front of an ideal camera and of the
//! four lenses.

use glam::DVec3;
use petzval_base::rays::{RayBatch, WAVE_SIZE};
use petzval_base::stats::LensStats;
use petzval_image::Picture;
use petzval_lens::LensColumns;
use petzval_render::Backend;
use petzval_render::job::Job;

use super::compare::{
    Estimate, agree, assert_same, expected_by, found, job_around, job_of, stored, well_known,
};
use super::material::NaiveMaterial;
use super::matter::{Cube, Matter};
use super::rooms::{glass, lit_room};
use super::world::{PointLike, Shape, World};
use crate::support::{LENSES, Random, picture, root, sampling::random_samples};

/// Voxels of random densities up to 4, in a cube of side 1.6 around the centre of the room.
fn smoke() -> Matter {
    let mut random = Random::new(5);
    let mut row = || (0..5).map(|_| random.between(0.0, 4.0)).collect::<Vec<f64>>();
    let voxels = (0..5).map(|_| (0..5).map(|_| row()).collect()).collect();
    let corner = DVec3::new(-0.8, -1.4, 2.0);
    Matter { voxels: Some(Cube { voxels, corner, side: 1.6 }), ..milk() }
}

/// A medium whose channels are absorbed differently.
fn milk() -> Matter {
    Matter::uniform([0.05, 0.2, 0.5], [1.25, 1.1, 0.8], 0.4)
}

/// A medium in which light of each channel goes a different distance.
fn amber() -> Matter {
    Matter::uniform([0.1, 0.5, 1.5], [1.8, 1.0, 0.2], 0.2)
}

/// A thin fog.
fn fog() -> Matter {
    Matter::uniform([0.01, 0.02, 0.03], [0.12, 0.11, 0.1], -0.3)
}

/// A ball of a medium in the room.
fn ball(material: NaiveMaterial, inside: usize, outside: Option<usize>) -> Shape {
    Shape::ball([0.0, -0.6, 2.8], 0.9, material).between(Some(inside), outside)
}

/// A room with media, and a point light.
fn room_with(media: Vec<Matter>, shapes: Vec<Shape>) -> World {
    let point = PointLike::Point { from: [1.2, 0.5, 1.5], intensity: [0.6, 0.5, 0.4] };
    World { media, lights: vec![point], ..lit_room(shapes) }
}

/// Six worlds with media.
fn worlds() -> Vec<(&'static str, World)> {
    let interface = || NaiveMaterial::Interface;
    let glowing = Matter { emits: [1.0, 2.0, 3.0], ..milk() };
    let hollow = Shape::ball([0.0, -0.6, 2.8], 0.5, interface()).between(None, Some(0));
    // A point light in a fog has an infinite variance.
    let foggy = World { media: vec![fog()], around: Some(0), ..lit_room([]) };
    vec![
        ("a ball", room_with(vec![amber()], vec![ball(interface(), 0, None)])),
        ("a glowing ball", room_with(vec![glowing], vec![ball(interface(), 0, None)])),
        ("a hollow ball", room_with(vec![milk()], vec![ball(interface(), 0, None), hollow])),
        ("a glass ball", room_with(vec![milk()], vec![ball(glass(0.0), 0, None)])),
        ("smoke", room_with(vec![smoke()], vec![ball(interface(), 0, None)])),
        ("fog", foggy),
    ]
}

#[test]
fn media_agree_with_a_naive_path_tracer() {
    for (name, world) in worlds() {
        println!("{name}");
        agree(&world, 5);
    }
}

/// A ball of a material under whose surface light scatters.
fn below(eta: f64) -> World {
    let matter = Matter::uniform([0.4, 1.2, 3.0], [9.6, 8.8, 7.0], 0.0);
    let material = NaiveMaterial::Below(eta, Box::new(matter));
    let ball = Shape::ball([0.0, -0.6, 2.8], 0.9, material);
    room_with(Vec::new(), vec![ball])
}

#[test]
fn subsurface_scattering_agrees_with_a_naive_random_walk() {
    for eta in [1.33, 1.6] {
        agree(&below(eta), 4);
    }
}

/// Without absorption, a convex body in uniform light is invisible.
#[test]
fn subsurface_scattering_loses_and_gains_no_light() {
    let text = r#"LightSource "infinite" "rgb L" [1 1 1]
        Material "subsurface" "rgb sigma_a" [0 0 0] "rgb sigma_s" [3 3 3] "float g" 0.5
        "float eta" ETA
        Translate 0 0 3 Shape "sphere" "float radius" 1.6"#;
    for eta in ["1.33", "1.7"] {
        let mut job = job_around("", &text.replace("ETA", eta), None, 40);
        job.samples.end = 64;
        let found = found(&job);
        for channel in 0..3 {
            let (mean, error) = (found.mean[channel], found.error[channel]);
            println!("{eta}: {mean} +- {error}");
            assert!(error < 1e-3 && (mean - 1.0).abs() < 5.0 * error + 1e-4, "{eta}: {mean}");
        }
    }
}

#[test]
fn nested_media_agree_with_a_naive_path_tracer() {
    let ball = ball(NaiveMaterial::Interface, 0, Some(1));
    let media = vec![milk(), fog()];
    agree(&World { media, around: Some(1), ..lit_room([ball]) }, 4);
}

/// Returns the scene of a world, one unit of which is a metre, around a lens of this folder.
fn scene_through(folder: &str, lens: &str, world: &World, depth: u32) -> String {
    format!(
        r#"Film "rgb" "integer xresolution" 64 "integer yresolution" 64 "float diagonal" 18
           PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
           Sampler "independent" "integer pixelsamples" 16
           Integrator "volpath" "integer maxdepth" {depth}
           {}
           Camera "realistic" "string lensfile" "{folder}/{lens}.dat"
               "float aperturediameter" 100 "float focusdistance" 2.6
           WorldBegin
           {}"#,
        world.prelude(),
        world.text()
    )
}

/// Checks that both path tracers agree on a world around a lens.
fn agree_through(lens: &str, world: &World, depth: u32) {
    let folder = root().join("lenses");
    let text = scene_through(folder.to_str().expect("text"), lens, world, depth);
    let job = job_of(&text, None);
    // The folder is another one on each machine.
    let subject = (crate::support::lens(lens), scene_through("", lens, world, depth));
    let label = format!("{lens}: {}, depth {depth}", world.summary());
    let expected = stored(&label, subject, || through(&job, world, depth));
    assert_same(well_known(job), expected);
}

/// Returns the estimate of the naive path tracer for the rays of a lens.
fn through(job: &Job, world: &World, depth: u32) -> Estimate {
    let mut random = Random::new(11);
    let (mut columns, mut rays) = (LensColumns::default(), Box::<RayBatch>::default());
    let mut sample = |random: &mut Random| -> Vec<[f64; 3]> {
        let samples = random_samples(job.camera.film, random);
        let mut stats = LensStats::default();
        job.camera.generate_rays::<f32>(&samples, &mut columns, &mut rays, &mut stats);
        let mut values = vec![[0.0; 3]; WAVE_SIZE];
        for i in 0..rays.len {
            let ray = rays.ray(i);
            let double = |v: [f32; 3]| DVec3::from(v.map(f64::from));
            // Rounded directions would leave hits on spheres beside their surface.
            let along = double(ray.direction).normalize();
            let light = world.radiance(double(ray.origin), along, depth, random);
            let share = rays.throughput(i).map(f64::from);
            values[rays.slot[i] as usize] = [0, 1, 2].map(|c| share[c] * light[c]);
        }
        values
    };
    expected_by(|| sample(&mut random))
}

#[test]
fn media_agree_through_the_four_lenses() {
    let worlds = worlds();
    let cases = [("dgauss.50mm", 2), ("telephoto.250mm", 4), ("wide.22mm", 5), ("fisheye.10mm", 3)];
    assert_eq!(cases.len(), LENSES.len());
    for (lens, world) in cases {
        let (name, world) = &worlds[world];
        println!("{lens}: {name}");
        agree_through(lens, world, 4);
    }
}

/// A ball that fills most of the field of each lens, under a sky and a sun. Most of its light has
/// walked below its surface, and half the field of the fisheye lens sees its limb.
fn before_the_lens() -> World {
    let matter = Matter::uniform([0.03, 0.08, 0.2], [2.97, 2.92, 2.8], 0.3);
    let material = NaiveMaterial::Below(1.33, Box::new(matter));
    let sun = PointLike::Distant { from: [2.0, 1.5, -2.0], irradiance: [1.0, 0.9, 0.8] };
    let shapes = vec![Shape::ball([0.1, -0.1, 1.5], 1.1, material)];
    World { shapes, lights: vec![sun], sky: Some([0.4, 0.5, 0.6]), ..World::default() }
}

#[test]
fn subsurface_scattering_agrees_through_the_four_lenses() {
    let world = before_the_lens();
    for (lens, _) in LENSES {
        agree_through(lens, &world, 3);
    }
}

#[test]
fn one_lane_and_eight_render_the_same_bits() {
    for (name, world) in worlds() {
        let mut job = job_around(&world.prelude(), &world.text(), None, 5);
        job.samples.end = 3;
        let [one, eight] = [Backend::Scalar, Backend::Simd].map(|lanes| picture(&job, lanes, 2));
        let bits = |picture: &Picture| {
            picture.pixels.iter().flatten().map(|v| v.to_bits()).collect::<Vec<u32>>()
        };
        assert!(bits(&one) == bits(&eight), "{name}");
    }
}
