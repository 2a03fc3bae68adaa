//! Ghosts of kinds of lights, their independence of threads, and the estimate of the plan.

use petzval_lens::{Coating, LensModel};
use petzval_render::Backend;
use petzval_render::film::Frame;
use petzval_render::job::Job;
use petzval_render::light_tracing::ghosts::{estimate, pairs};
use petzval_render::plan::{Effect, OmissionError};

use super::{LENS, PIXELS, blocks, coated, ghosts, green, job};
use crate::support::picture;

#[test]
fn only_surfaces_that_reflect_make_pairs() {
    let job = job(LENS, "", "none", 1);
    let LensModel::Real(lens) = &job.camera.model else { panic!("a real lens") };
    let mut lens = lens.prescription.clone();
    // The stop, row 2, does not reflect.
    assert_eq!(pairs(&lens), [[0, 1], [0, 3], [1, 3], [0, 4], [1, 4], [3, 4]]);
    lens.rows[3].coating = Some(Coating::Perfect);
    assert_eq!(pairs(&lens), [[0, 1], [0, 4], [1, 4]]);
}

/// Returns a point light, a small ball and a distant light of intensity 1 in one direction, 1 m away.
fn lights() -> [String; 3] {
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
fn balls_points_and_distant_lights_cause_the_same_ghosts() {
    let sum = |world: &str| ghosts(&job(LENS, world, "none", 16), 4096).iter().sum::<f64>();
    let [point, ball, far] = lights().map(|world| sum(&world));
    println!("{point} {ball} {far}");
    assert!((ball / point - 1.0).abs() < 0.01, "{ball}, not {point}");
    // At 1 m the light is not parallel, and the front of the lens, 60 mm before the origin of the
    // camera, is closer.
    assert!((far / point - 1.0).abs() < 0.2, "{far}, not {point}");
}

#[test]
fn an_occluded_light_has_no_ghosts() {
    let [point, ..] = lights();
    let wall = r#"AttributeBegin Translate 0 0 0.5 Shape "disk" "float radius" 3 AttributeEnd"#;
    assert!(estimate(&job(LENS, &point, "none", 1).light_path_input()).is_some());
    assert!(
        estimate(&job(LENS, &format!("{point}\n{wall}"), "none", 1).light_path_input()).is_none()
    );
}

/// Returns a light and a surface that it lights.
fn lit() -> String {
    let [point, ..] = lights();
    let wall = r#"AttributeBegin Translate 0 0 3.1 Shape "disk" "float radius" 3 AttributeEnd"#;
    format!("{point}\n{wall}")
}

#[test]
fn ghosts_do_not_depend_on_threads_lanes_or_parts() {
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
    let of = |samples| green(&picture(&Job { samples, ..job.clone() }, Backend::Simd, 1));
    let halves = [of(0..16), of(16..32)];
    for (i, whole) in green(&whole).iter().enumerate() {
        let mean = (halves[0][i] + halves[1][i]) / 2.0;
        assert!((mean - whole).abs() < 1e-5 * whole.abs(), "{mean} {whole}");
    }
}

#[test]
fn the_estimated_brightness_of_ghosts_equals_that_in_the_picture() {
    let with = job(LENS, &lit(), "auto", 4096);
    let decision = with.plan.effects.iter().find(|d| d.effect == Effect::Ghosts).expect("a row");
    println!("{decision:?}");
    let Some(OmissionError::Signal(estimate)) = decision.error else {
        panic!("an estimate: {decision:?}")
    };
    assert!(decision.on && estimate > 1.0, "{decision:?}");
    let without = green(&picture(&job(LENS, &lit(), "-ghosts", 256), Backend::Simd, 1));
    let mean = without.iter().sum::<f64>() / without.len() as f64;
    let most = blocks(&ghosts(&with, 4096), 4).into_iter().fold(0.0, f64::max);
    let seen = 100.0 * most / mean;
    println!("{estimate:.2} % estimated, {seen:.2} % found");
    assert!(estimate / seen < 1.5 && seen / estimate < 1.5, "{estimate} {seen}");
}

#[test]
fn a_good_coating_turns_ghosts_off() {
    let job = job(&coated("broadband"), &lit(), "auto", 1);
    let decision = job.plan.effects.iter().find(|d| d.effect == Effect::Ghosts).expect("a row");
    println!("{decision:?}");
    let Some(OmissionError::Signal(estimate)) = decision.error else {
        panic!("an estimate: {decision:?}")
    };
    assert!(!decision.on && job.ghosts.is_none() && estimate < 1.0, "{decision:?}");
}
