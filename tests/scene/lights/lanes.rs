//! Light sampling and surface points of eight lanes, of one lane, and of the functions for single
//! rays: the same numbers.

use glam::Vec3;
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{HitBatch, NO_INDEX, Ray, RayBatch, SortedColumn, WAVE_SIZE};
use petzval_scene::{
    GlossyLobe, LightColumns, LightInputs, LightSamples, LobeColumns, Reception, Scene,
    SurfaceColumns, SurfaceInputs, TraversalStack, VectorColumns, store_vector,
};

use super::{patchwork, read};
use crate::support::Random;

const WORLD: &str = r#"
    LightSource "point" "rgb I" [8 6 4] "point3 from" [1 3 2]
    LightSource "spot" "rgb I" [9 9 20] "point3 from" [-2 2 1] "point3 to" [0 0 5]
    LightSource "distant" "rgb L" [1 1 1] "point3 from" [-1 2 -1]
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [3 2 1] "bool twosided" true
        Shape "trianglemesh" "point3 P" [-2 3 3  2 3 3  2 2.5 6  -2 2.5 6 -2 3 3.001]
            "integer indices" [0 1 2 0 2 3 0 4 1]
        AttributeBegin Translate 2 1 3 Rotate 40 1 0 0 Scale 1 2 1 Shape "disk" "float radius" 0.7 AttributeEnd
        AttributeBegin Translate -2 0 3 Shape "sphere" "float radius" 0.6 AttributeEnd
        AttributeBegin Translate 0 -3 0 Shape "sphere" "float radius" 9 AttributeEnd
        AttributeBegin Translate -3 1 5 Shape "cylinder" "float radius" 0.3 AttributeEnd
        Translate 3 1 5 Shape "disk" "float phimax" 120
    AttributeEnd
    AttributeBegin
        AreaLightSource "diffuse" "string filename" "light.exr"
        Shape "trianglemesh" "point3 P" [-4 3 3  4 3 3  4 2.5 9] "point2 uv" [0 0 1 0 1 1]
            "float alpha" 0.5
    AttributeEnd
    ObjectBegin "thing"
        Shape "sphere" "float radius" 0.5
        Shape "trianglemesh" "point3 P" [-1 -1 0  1 -1 0  0 1 0] "normal N" [0 0 -1 0.2 0 -1 0 0.3 -1]
            "point2 uv" [0 0 3 0 1 2]
    ObjectEnd
    AttributeBegin Translate 0 0 4 Rotate 30 1 2 3 Scale 1 2 0.5 ObjectInstance "thing" AttributeEnd
    AttributeBegin Translate 1 -0.5 2 ObjectInstance "thing" AttributeEnd
    Shape "cone" "float radius" 2
    Shape "bilinearmesh" "point3 P" [-5 -1 -5  5 -1 -5  -5 -1.2 9  5 -1 9]
"#;

fn scene() -> Scene {
    read(&[("light.exr", &patchwork([8, 8]))], WORLD).expect("a scene")
}

/// Rays from a point in all directions, and what they hit. The order of the hits is shuffled.
fn hits(scene: &Scene) -> (RayBatch, HitBatch, Vec<u32>) {
    let (mut random, mut rays) = (Random::new(4), RayBatch::default());
    for i in 0..WAVE_SIZE as u32 {
        let mut number = || random.between(-1.0, 1.0) as f32;
        let direction = Vec3::new(number(), number(), number()).normalize();
        let ray =
            Ray { origin: [0.1, 0.4, 1.0], direction: direction.to_array(), t_max: f32::INFINITY };
        rays.push(ray, [1.0; 3], i);
    }
    let mut hits = HitBatch::default();
    scene.intersect::<f32x8>(&rays, &mut hits, &mut TraversalStack::default());
    let mut order: Vec<u32> =
        (0..rays.len as u32).filter(|&i| hits[i as usize].shape != NO_INDEX).collect();
    order.sort_by_key(|i| i.wrapping_mul(0x9e37_79b9));
    assert!(order.len() > 900, "{}", order.len());
    (rays, hits, order)
}

fn surfaces<R: Real<Scalar = f32>>(
    scene: &Scene,
    (rays, hits, order): &(RayBatch, HitBatch, Vec<u32>),
    derivatives: bool,
) -> Box<SurfaceColumns> {
    let mut columns = Box::<SurfaceColumns>::default();
    scene.load_surfaces::<R>(&SurfaceInputs { rays, hits, order, derivatives }, 0, &mut columns);
    columns
}

#[test]
fn surface_points_of_eight_lanes_are_those_of_one() {
    let scene = scene();
    let wave = hits(&scene);
    for derivatives in [false, true] {
        let eight = surfaces::<f32x8>(&scene, &wave, derivatives);
        let one = surfaces::<f32>(&scene, &wave, derivatives);
        for (at, &i) in wave.2.iter().enumerate() {
            let [a, b] = [&eight, &one].map(|columns| columns.points::<f32>(at));
            assert_eq!(format!("{a:?}"), format!("{b:?}"), "entry {at}");
            let (ray, hit) = (wave.0.ray(i as usize), wave.1[i as usize]);
            let (_, point) = scene.surface(&ray, &hit);
            let apart = Vec3::from(a.position) - point.position;
            assert!(apart.abs().cmple(point.error + Vec3::splat(1e-6)).all(), "{apart}, {hit:?}");
            assert!(Vec3::from(a.normal).distance(point.normal) < 1e-5, "{hit:?}");
            assert!(Vec3::from(a.shading_normal).distance(point.shading_normal) < 1e-5, "{hit:?}");
            if derivatives {
                let [a, b] = [&eight, &one].map(|columns| columns.derivatives::<f32>(at));
                assert_eq!(format!("{a:?}"), format!("{b:?}"), "entry {at}");
                let expected = scene.surface_derivatives(&ray, &hit);
                let off = (Vec3::from(a.dp[0]) - expected.dp[0]).length();
                assert!(off <= 1e-4 * expected.dp[0].length(), "{hit:?}: {a:?} {expected:?}");
            }
        }
    }
}

/// Samples a light for every entry.
fn lights<R: Real<Scalar = f32>>(scene: &Scene, inputs: &LightInputs) -> Box<LightSamples> {
    let mut samples = Box::<LightSamples>::default();
    scene.sample_lights::<R>(inputs, &mut LightColumns::default(), &mut samples);
    samples
}

#[test]
fn light_samples_of_eight_lanes_are_those_of_one_and_of_single_points() {
    let scene = scene();
    let wave = hits(&scene);
    let surfaces = surfaces::<f32x8>(&scene, &wave, false);
    let mut random = Random::new(8);
    let mut numbers: Box<[[SortedColumn<f32>; 2]; 2]> = Box::default();
    for column in numbers.as_flattened_mut() {
        column.iter_mut().for_each(|u| *u = (random.next() as f32).min(1.0 - f32::EPSILON));
    }
    let mut facing = VectorColumns::default();
    for at in 0..wave.2.len() {
        let normal = surfaces.shading_normal(at);
        store_vector::<f32>(&mut facing, at, if at % 3 == 0 { [0.0; 3] } else { normal });
    }
    let entries: Vec<u32> = (0..wave.2.len() as u32).filter(|at| at % 5 != 1).collect();
    // A sixth of the surfaces that receive light from one side are glossy.
    let mut lobes: Box<(VectorColumns, [SortedColumn<f32>; 2])> = Box::default();
    let (wo, [alpha2, share]) = &mut *lobes;
    for at in 0..wave.2.len() {
        let tilt = Vec3::new(0.4, -0.3, 0.2);
        let towards = (Vec3::from(surfaces.shading_normal(at)) + tilt).normalize();
        store_vector::<f32>(wo, at, towards.to_array());
        alpha2[at] = [1e-6, 0.01, 0.3][at / 9 % 3];
        share[at] = if at % 9 == 4 { 0.9 } else { 0.0 };
    }
    let lobes = LobeColumns { wo, alpha2, share };
    let inputs = LightInputs {
        surfaces: &surfaces,
        facing: &facing,
        lobes: Some(lobes),
        choice: &numbers[0],
        u: &numbers[1],
        entries: &entries,
    };
    let eight = lights::<f32x8>(&scene, &inputs);
    let one = lights::<f32>(&scene, &inputs);
    let mut found = 0;
    for at in entries.iter().map(|&at| at as usize) {
        let vector = |columns: &VectorColumns| [0, 1, 2].map(|axis| columns[axis][at]);
        let row = |samples: &LightSamples| {
            let LightSamples { wi, radiance, density, shadow, shadow_end } = samples;
            let lit = vector(radiance) != [0.0; 3];
            let ray = lit.then(|| (vector(shadow).map(f32::to_bits), shadow_end[at].to_bits()));
            let rest = [vector(wi), vector(radiance)].map(|v| v.map(f32::to_bits));
            (rest, density[at].to_bits(), ray)
        };
        assert_eq!(row(&eight), row(&one), "entry {at}");
        let pair = |i: usize| [numbers[i][0][at], numbers[i][1][at]];
        let point = surfaces.points::<f32>(at).into();
        let lobe = GlossyLobe::new(vector(wo), alpha2[at], share[at]);
        let reception = Reception { facing: vector(&facing), lobe };
        let sample = scene.sample_light(&point, reception, pair(0), pair(1));
        let radiance = vector(&eight.radiance);
        let Some(sample) = sample.filter(|sample| sample.radiance != [0.0; 3]) else {
            assert_eq!(radiance, [0.0; 3], "entry {at}");
            continue;
        };
        found += 1;
        for channel in 0..3 {
            let expected = sample.radiance[channel] / sample.density;
            let off = (radiance[channel] - expected).abs();
            assert!(off <= 1e-5 * expected, "entry {at}: {radiance:?}, {sample:?}");
        }
        let wi = Vec3::from(vector(&eight.wi));
        assert!(wi.distance(sample.direction.normalize()) < 1e-6, "entry {at}");
        assert_eq!(eight.density[at].is_infinite(), sample.singular, "entry {at}");
    }
    assert!(found > 200, "{found} samples");
}
