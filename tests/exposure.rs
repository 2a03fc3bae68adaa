//! Focus and f-number from the command line, and the brightness that follows.

mod support;

use std::f64::consts::PI;

use petzval::job::{Changes, prepare};
use petzval::lens::Model;
use petzval::render::{Backend, Job};
use petzval::scene::pbrt;
use support::{LENSES, folder, mean, picture, root, write};

/// The centre of the film of a lens under a uniform sky of radiance 1.
fn centre(lens: &str, changes: &Changes) -> Job {
    let folder = folder();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 40 "integer yresolution" 40 "float diagonal" 4
           Sampler "sobol" "integer pixelsamples" 256
           Camera "realistic" "string lensfile" "{}/lenses/{lens}.dat"
               "float aperturediameter" 100 "float focusdistance" 5
           WorldBegin LightSource "infinite" "rgb L" [1 1 1]"#,
        root().display()
    );
    let description = pbrt::read(&write(&folder, "sky.pbrt", text)).expect("a scene");
    let crop = Some([[18, 18], [22, 22]]);
    prepare(description, &Changes { crop, ..changes.clone() }).expect("a job").0
}

#[test]
fn brightness_follows_the_f_number() {
    for (name, _) in LENSES {
        for f_number in [5.6, 8.0, 11.0, 16.0, 22.0] {
            let focus = Some(f64::INFINITY);
            let job =
                centre(name, &Changes { focus, f_number: Some(f_number), ..Changes::default() });
            let found = mean(&picture(&job, Backend::Simd, 2))[0];
            let expected = PI / (4.0 * f_number * f_number);
            println!("{name} f/{f_number}: {:.4}", found / expected);
            assert!(
                (found / expected - 1.0).abs() < 0.01,
                "{name} f/{f_number}: {found} {expected}"
            );
        }
    }
}

#[test]
fn the_film_moves_to_where_the_asked_distance_is_sharp() {
    for (name, _) in LENSES {
        for metres in [2.0, 5.0, 100.0] {
            let job = centre(name, &Changes { focus: Some(metres), ..Changes::default() });
            let Model::Real(lens) = &job.camera.model else { panic!("{name} is a real lens") };
            let before = lens.paraxial.focus_of_film(lens.film_distance);
            let from_film = before + lens.paraxial.length + lens.film_distance;
            assert!((from_film / (metres * 1e3) - 1.0).abs() < 1e-6, "{name}: {from_film} mm");
        }
    }
}
