//! Paths of thousands of steps: directions keep their length, and no sample is lost.

use petzval_render::film::SampleId;
use petzval_render::{Backend, replay};

use super::compare::{found, job_of};

/// Largest error of the length of a direction after any number of steps. A step rounds it by about
/// 1.5e-7 (one Newton step and the transforms to and from a shading frame, in f32).
const LENGTH_ERROR: f64 = 5e-7;

/// Returns a scene inside a ball of radius 4 with this inner surface. The camera looks from its middle.
fn inside(wall: &str, contents: &str) -> String {
    format!(
        r#"Film "rgb" "integer xresolution" 4 "integer yresolution" 4
           PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
           Integrator "volpath" "integer maxdepth" 5
           {wall}
           Shape "sphere" "float radius" 4
           {contents}"#
    )
}

/// A mirror that reflects all light.
const MIRROR: &str = r#"Material "conductor" "float k" 1e4 "float eta" 1"#;

/// Returns the scenes: a wall that holds the light in, and what scatters it. The steps of a path must
/// exceed `least` in one of the samples at least.
fn scenes() -> Vec<(&'static str, String, usize)> {
    let camera = r#"Camera "perspective" "float fov" 60
                    WorldBegin LightSource "point" "rgb I" [1 1 1] "#;
    let hold = |contents: &str| inside(&format!("{camera} {MIRROR}"), contents);
    let ball = |material: &str| {
        let ball =
            r#"AttributeBegin Translate 0.3 0.2 1.5 Shape "sphere" "float radius" 1 AttributeEnd"#;
        format!("{material} {ball}")
    };
    let medium = |g: f64| {
        inside(
            &format!(
                r#"MakeNamedMedium "m" "string type" "homogeneous" "rgb sigma_s" [9 9 9]
                   "rgb sigma_a" [0 0 0] "float g" {g}
                   MediumInterface "" "m"
                   {camera} MediumInterface "m" ""
                   {MIRROR}"#
            ),
            "",
        )
    };
    let rough = r#"Material "conductor" "float k" 1e4 "float eta" 1 "float roughness" 0.3"#;
    let coat = r#"Material "coatedconductor" "float conductor.k" 1e4 "float conductor.eta" 1
                  "float interface.roughness" 0 "float g" 0.9 "rgb albedo" [1 1 1] "float thickness" 2
                  "integer maxdepth" 10000"#;
    let diffuse = r#"Material "diffuse" "rgb reflectance" [1 1 1]"#;
    let hair = format!(
        r#"{diffuse} Shape "sphere" "float radius" 3.5
           Material "hair" "rgb sigma_a" [0 0 0]
           Shape "curve" "point3 P" [-2 -2 1  -1 2 2  1 -2 2  2 2 1] "float width" 0.8"#
    );
    vec![
        ("mirrors", hold(""), 12_000),
        ("glass", hold(&ball(r#"Material "dielectric" "float eta" 1.5"#)), 500),
        ("a thin sheet", hold(&ball(r#"Material "thindielectric""#)), 500),
        ("rough glass", hold(&ball(r#"Material "dielectric" "float roughness" 0.2"#)), 10),
        ("rough metal", hold(&ball(rough)), 10),
        ("a coat", hold(&ball(coat)), 10),
        ("skin", hold(&ball(r#"Material "subsurface" "rgb reflectance" [1 1 1]"#)), 10),
        ("hair", hold(&hair), 10),
        ("fog", medium(0.0), 10_000),
        ("fog that scatters forwards", medium(0.9), 10_000),
        ("fog that scatters backwards", medium(-0.8), 10_000),
    ]
}

#[test]
fn directions_keep_their_length_over_ten_thousand_steps() {
    for (name, text, least) in scenes() {
        let mut job = job_of(&text, None);
        // Only now: pilots and surveys need no long paths.
        job.path_limits.max_depth = 12_000;
        let (mut longest, mut worst) = (0, 0.0f64);
        for sample in 0..4 {
            let id = SampleId::new([1 + sample % 2, 1 + sample / 2], sample, job.seed);
            let backend = if sample % 2 == 0 { Backend::Simd } else { Backend::Scalar };
            let Some(replay) = replay(&job, backend, id) else { continue };
            assert!(replay.value.is_some(), "{name}: the sample {sample} is finite");
            longest = longest.max(replay.steps.len());
            for step in &replay.steps {
                let length2: f64 = step.ray.direction.iter().map(|&x| f64::from(x).powi(2)).sum();
                worst = worst.max((length2.sqrt() - 1.0).abs());
                assert!(
                    worst < LENGTH_ERROR,
                    "{name}: {worst:e} after {} steps",
                    replay.steps.len()
                );
            }
        }
        println!("{name}: {longest} steps, an error of {worst:.1e}");
        assert!(longest >= least, "{name}: {longest} steps");
    }
}

/// A ball that scatters all light of a uniform sky cannot be seen, however thick it is. A bound of 5
/// standard errors would be met by chance alone, since each path that leaves carries exactly the sky.
#[test]
fn thick_fog_loses_no_light() {
    for sigma in [5, 20, 100] {
        for g in [0.0, 0.8, -0.5] {
            let text = format!(
                r#"Film "rgb" "integer xresolution" 16 "integer yresolution" 16
                   PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
                   Sampler "independent" "integer pixelsamples" 8
                   Integrator "volpath" "integer maxdepth" 1000000
                   LookAt 0 0 5  0 0 0  0 1 0
                   Camera "perspective" "float fov" 18
                   WorldBegin
                   LightSource "infinite" "rgb L" [1 1 1]
                   MakeNamedMedium "m" "string type" "homogeneous" "rgb sigma_a" [0 0 0]
                   "rgb sigma_s" [{sigma} {sigma} {sigma}] "float g" {g}
                   MediumInterface "m" "" Material "interface" Shape "sphere" "float radius" 1"#
            );
            let mean = found(&job_of(&text, None)).mean;
            assert!(mean.iter().all(|c| (c - 1.0).abs() < 1e-4), "{sigma}, {g}: {mean:?}");
        }
    }
}
