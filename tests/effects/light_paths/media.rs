//! Light paths through media: fog around the camera, and clouds before a lamp.

use petzval_render::Backend;
use petzval_render::prepare::Changes;

use super::cases::{Case, assert_same_bits, assert_same_light, case, job, light, light_by_channel};
use crate::support::picture;
use crate::support::reference::by_tier;
use crate::support::workspace::Workspace;

/// A lamp.
const LAMP: &str = r#"
    LightSource "infinite" "rgb L" [0.05 0.05 0.1]
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [60 50 25]
        Translate 0.1 0.1 4 Shape "sphere" "float radius" 0.15
    AttributeEnd"#;

/// A larger lamp behind a ball of mist and a cloud that fills a box.
const CLOUDS: &str = r#"
    LightSource "infinite" "rgb L" [0.05 0.05 0.1]
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [8 7 3]
        Translate 0.1 0.1 4 Shape "sphere" "float radius" 0.4
    AttributeEnd
    MakeNamedMedium "mist" "string type" "homogeneous"
        "rgb sigma_a" [0.3 0.1 0.1] "rgb sigma_s" [0.2 0.5 0.7]
    MakeNamedMedium "cloud" "string type" "uniformgrid"
        "integer nx" 2 "integer ny" 2 "integer nz" 2 "float density" [0.1 1 0.5 0.2  0.9 0 0.3 1]
        "point3 p0" [-1 -1 2.5] "point3 p1" [1 1 3.5] "rgb sigma_a" [0.5 0.5 0.5] "rgb sigma_s" [1 1 1]
    Material "interface"
    AttributeBegin
        MediumInterface "mist" ""
        Translate 0.1 0.1 1.5 Shape "sphere" "float radius" 0.5
    AttributeEnd
    AttributeBegin
        MediumInterface "cloud" ""
        Shape "trianglemesh"
            "point3 P" [-1 -1 2.5  1 -1 2.5  1 1 2.5  -1 1 2.5  -1 -1 3.5  1 -1 3.5  1 1 3.5  -1 1 3.5]
            "integer indices" [0 2 1 0 3 2  4 5 6 4 6 7  0 1 5 0 5 4  2 3 7 2 7 6  1 2 6 1 6 5  0 4 7 0 7 3]
    AttributeEnd"#;

const FOG: &str = r#"
    Integrator "volpath" "integer maxdepth" 1
    MakeNamedMedium "fog" "string type" "homogeneous"
        "rgb sigma_a" [0.02 0.04 0.08] "rgb sigma_s" [0.02 0.02 0.1]
    MediumInterface "" "fog""#;

const CLEAR: &str = r#"Integrator "volpath" "integer maxdepth" 1"#;

pub fn cases() -> Vec<Case> {
    let focus = "\"float focusdistance\" 2 \"float aperturediameter\" 12";
    let with = |effects: &str| Changes {
        effects: effects.parse().expect("effects"),
        ..Changes::default()
    };
    vec![
        Case {
            before: FOG,
            changes: with("+media,-ghosts,-diffraction"),
            ..case("fog", "dgauss.50mm.dat", focus, LAMP)
        },
        Case {
            before: CLEAR,
            filter: "\"gaussian\" \"float xradius\" 2 \"float yradius\" 2",
            changes: with("+media,-ghosts,-diffraction"),
            ..case("clouds", "wide.22mm.dat", focus, CLOUDS)
        },
        Case {
            before: CLEAR,
            changes: with("+media,+dispersion,-ghosts,-diffraction"),
            ..case("clouds and colours", "triplet.toml", focus, CLOUDS)
        },
    ]
}

#[test]
fn light_paths_change_no_light_of_media() {
    assert_same_light(&cases(), [1024, 128, by_tier(128, 384)], 1.3e-3, light_by_channel);
}

#[test]
fn media_take_light_of_lamps() {
    for case in cases() {
        let [with, without] = [true, false].map(|media| {
            let mut job = job(&case, true, 1, 64);
            assert!(job.scene.has_media() && job.lamp_images.is_some(), "{}", case.name);
            if !media {
                job.scene.remove_media();
            }
            light(&picture(&job, Backend::Simd, 1))
        });
        assert!(with < 0.9 * without, "{}: {with} and {without}", case.name);
    }
}

#[test]
fn the_picture_of_media_is_the_same_for_all_threads_lanes_and_crops() {
    cases().iter().for_each(assert_same_bits);
}

#[test]
fn shards_have_the_light_of_a_whole_render_of_media() {
    let workspace = Workspace::new();
    let lens = crate::support::root().join("lenses/dgauss.50mm.dat");
    let text = format!(
        r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32 {FOG}
           Camera "realistic" "string lensfile" "{}" "float focusdistance" 3
           WorldBegin {LAMP}"#,
        lens.display()
    );
    std::fs::write(workspace.path("fog.pbrt"), text).expect("a scene");
    workspace.merges_to_the_whole(
        "render fog.pbrt --spp 90 --light-paths on --effects +media,-ghosts,-diffraction",
    );
}
