//! Losses in pictures against their estimates.

use petzval_image::Picture;
use petzval_lens::{Coating, LensModel, PupilSampling, RealLens};
use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;

use crate::support::{folder, lens, picture, root, write};

/// Returns the centre of a picture by a double Gauss under a uniform sky.
fn sky(changes: &Changes) -> Job {
    let folder = folder();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 16 "integer yresolution" 16 "float diagonal" 2
           Sampler "sobol" "integer pixelsamples" 64
           Camera "realistic" "string lensfile" "{}/lenses/dgauss.50mm.dat"
               "float aperturediameter" 100 "float focusdistance" 5
           WorldBegin LightSource "infinite" "rgb L" [1 1 1]"#,
        root().display()
    );
    let description = pbrt::read(&write(&folder, "sky.pbrt", text)).expect("a scene");
    prepare(description, changes).expect("a job").job
}

fn coated(coating: Coating) -> Job {
    sky(&Changes { coating: Some(coating), ..Changes::default() })
}

fn real(job: &Job) -> &RealLens {
    let LensModel::Real(lens) = &job.camera.model else { panic!("a real lens") };
    lens
}

fn middle(picture: &Picture) -> f64 {
    picture.pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>()
        / picture.pixels.len() as f64
}

#[test]
fn a_picture_darkens_by_the_estimated_share() {
    let clear = sky(&Changes::default());
    assert!(!real(&clear).fresnel, "losses are on by default");
    let clear = middle(&picture(&clear, Backend::Simd, 1));
    for coating in [Coating::Bare, Coating::Mgf2, Coating::Broadband] {
        let job = coated(coating.clone());
        let estimate = real(&job).transmittance([0.0; 2]).expect("light");
        let found = middle(&picture(&job, Backend::Simd, 1)) / clear;
        println!("{coating:?}: {estimate:.5} estimated, {found:.5} of the light in the picture");
        // The samples are the same with and without losses: the difference is the variation of
        // losses in the pupil.
        assert!((found / estimate - 1.0).abs() < 2e-4, "{coating:?}: {found}, not {estimate}");
        let over = real(&job).throughput(1.0).expect("light");
        assert!((over.mean / estimate - 1.0).abs() < 2e-4, "{over:?}");
        assert!(over.range[0] <= over.mean && over.mean <= over.range[1], "{over:?}");
        assert_eq!(over.on_axis, estimate);
    }
}

#[test]
fn one_lane_and_eight_give_the_same_picture_with_losses() {
    let job = coated(Coating::Mgf2);
    assert_eq!(
        picture(&job, Backend::Simd, 2).pixels,
        picture(&job, Backend::Scalar, 1).pixels,
        "bit for bit"
    );
}

#[test]
fn a_lens_with_perfect_coatings_gives_the_picture_without_losses() {
    let off = sky(&Changes::default());
    let mut on = sky(&Changes::default());
    let LensModel::Real(lens) = &mut on.camera.model else { panic!("a real lens") };
    let mut prescription = lens.prescription.clone();
    prescription.rows.iter_mut().for_each(|row| row.coating = Some(Coating::Perfect));
    let remade = RealLens::new(
        prescription,
        lens.film_distance,
        1.2,
        PupilSampling::Pupil,
        1e-3,
        lens.front_depth,
    );
    **lens = remade;
    lens.fresnel = true;
    let mut plain = off;
    let LensModel::Real(lens) = &mut plain.camera.model else { panic!("a real lens") };
    let prescription = lens.prescription.clone();
    **lens = RealLens::new(
        prescription,
        lens.film_distance,
        1.2,
        PupilSampling::Pupil,
        1e-3,
        lens.front_depth,
    );
    let (plain, on) = (picture(&plain, Backend::Simd, 1), picture(&on, Backend::Simd, 1));
    assert_eq!(plain.pixels, on.pixels, "bit for bit");
}

#[test]
fn a_fisheye_loses_more_light_off_the_axis() {
    let lens = RealLens::new(lens("fisheye.10mm"), 23.192, 21.6, PupilSampling::Pupil, 1e-3, 0.0);
    let over = lens.throughput(21.6).expect("light");
    println!("{over:?}");
    assert!(over.range[0] < 0.99 * over.range[1], "{over:?}");
    assert!(over.range[0] > 0.3 && over.range[1] < 0.8, "{over:?}");
}
