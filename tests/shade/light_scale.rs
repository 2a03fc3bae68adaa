//! Independence of the unit of light: lights scaled by a factor give the picture scaled by the factor, by
//! the same decisions and the same samples.

use crate::support::{folder, root, write};
use petzval_image::Picture;
use petzval_render::job::{Job, StopCriteria};
use petzval_render::plan::OmissionError;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{Convergence, RenderOptions, render};
use petzval_scene_formats::pbrt;

/// Factors of about a millionth and a million: powers of two, which scale floats exactly, and others.
const FACTORS: [f64; 4] = [1.0 / 1_048_576.0, 1_048_576.0, 1e-6, 1e6];

/// Prepares a render of a room at night through a real lens: lights in and out of view, near and far, and
/// a rough metal. Every light is scaled.
fn job(factor: f64, changes: Changes) -> Job {
    let folder = folder();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 60 "integer yresolution" 40 "float diagonal" 43.27
           LookAt 0 0 0  0 0 1  0 1 0
           Camera "realistic" "string lensfile" "{}/lenses/dgauss.50mm.dat"
             "float aperturediameter" 17 "float focusdistance" 4
           WorldBegin
           LightSource "infinite" "rgb L" [0.004 0.005 0.006] "float scale" {factor}
           LightSource "distant" "rgb L" [0.004 0.004 0.008] "point3 from" [1 3 -1] "float scale" {factor}
           LightSource "point" "rgb I" [0.05 0.04 0.03] "point3 from" [-0.5 0.5 2] "float scale" {factor}
           LightSource "spot" "float power" 2 "point3 from" [0.5 0.9 2] "point3 to" [0.3 -0.3 4]
             "float scale" {factor}
           AttributeBegin
             AreaLightSource "diffuse" "rgb L" [900 800 500] "float scale" {factor}
             Translate 0.7 0.5 5 Shape "sphere" "float radius" 0.02
           AttributeEnd
           AttributeBegin
             AreaLightSource "diffuse" "float power" 0.02 "float scale" {factor}
             Translate -0.6 0.9 4 Rotate 90 1 0 0 Shape "disk" "float radius" 0.01
           AttributeEnd
           Material "diffuse" "rgb reflectance" [0.7 0.6 0.5]
           Shape "trianglemesh" "point3 P" [-3 -1 1  -3 -1 9  3 -1 9  3 -1 1]
             "integer indices" [0 1 2 0 2 3]
           Material "conductor" "float roughness" 0.3
           Translate -0.3 -0.3 4 Shape "sphere" "float radius" 0.4"#,
        root().display()
    );
    let path = write(&folder, "room.pbrt", text);
    prepare(pbrt::read(&path).expect("a scene"), &changes).expect("a job").job
}

/// Returns the decision about each effect with its source, and the error of leaving the effect out.
fn decisions(factor: f64) -> Vec<(String, f64)> {
    let plan = job(factor, Changes::default()).plan;
    let decision = |decision: &petzval_render::plan::Decision| {
        let harm = match decision.error {
            Some(OmissionError::Signal(percent)) => percent,
            Some(OmissionError::Colour { difference, .. }) => difference,
            Some(OmissionError::Blur { pixels, .. }) => pixels,
            None => 0.0,
        };
        (format!("{} {} {:?}", decision.effect.name(), decision.on, decision.by), harm)
    };
    plan.effects.iter().map(decision).collect()
}

#[test]
fn the_same_effects_are_planned_in_any_unit_of_light() {
    let expected = decisions(1.0);
    assert!(expected.iter().any(|(decision, _)| decision == "ghosts true Scene"), "{expected:?}");
    for factor in FACTORS {
        for ((found, harm), (decision, expected)) in decisions(factor).iter().zip(&expected) {
            assert_eq!(found, decision, "lights times {factor:e}");
            let off = (harm - expected).abs();
            assert!(off <= 1e-3 * expected, "lights times {factor:e}: {found} by {harm}");
        }
    }
}

/// Renders an adaptive picture, divides it by the factor, and returns how it ended.
fn adaptive(factor: f64) -> (Picture, Convergence) {
    let until = StopCriteria { noise: Some(0.04), time: None };
    let effects = "+ghosts,-diffraction".parse().expect("an effect");
    let job = job(factor, Changes { stop_criteria: until, effects, ..Changes::default() });
    let exposed =
        render(&job, RenderOptions { threads: 1, ..RenderOptions::default() }).expect("a render");
    let reached = exposed.convergence.expect("a convergence");
    let mut picture = exposed.picture(&job);
    for value in picture.pixels.as_flattened_mut() {
        *value = (f64::from(*value) / factor) as f32;
    }
    (picture, reached)
}

#[test]
fn an_adaptive_render_takes_the_same_samples_in_any_unit_of_light() {
    let (expected, reached) = adaptive(1.0);
    assert!(
        reached.max_spp > 2 * reached.min_spp,
        "all pixels have the same number of samples: {reached:?}"
    );
    for factor in FACTORS {
        let (picture, found) = adaptive(factor);
        if factor.log2().fract() == 0.0 {
            assert_eq!(found, reached, "lights times {factor:e}");
            assert!(picture == expected, "lights times {factor:e}");
            continue;
        }
        // Rounding differs, so single samples may choose another light.
        let near = |one: f64, other: f64| (one / other - 1.0).abs() < 0.01;
        assert!(
            near(found.mean_spp, reached.mean_spp),
            "lights times {factor:e}: {found:?}, {reached:?}"
        );
        assert!(
            near(found.noise, reached.noise),
            "lights times {factor:e}: {found:?}, {reached:?}"
        );
        let sums = [&picture, &expected].map(|picture| {
            picture.pixels.as_flattened().iter().map(|&value| f64::from(value)).sum::<f64>()
        });
        assert!(near(sums[0], sums[1]), "lights times {factor:e}: {sums:?}");
    }
}
