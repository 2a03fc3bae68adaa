//! Radiometry: pictures whose brightness has a closed form.

use std::f64::consts::PI;

use crate::support::{folder, mean, rendered, write};

/// Returns the mean of a picture taken straight down at the world's origin from 1 unit above, with
/// a field of view of 1 degree.
fn looking_down(samples: u32, integrator: &str, world: &str) -> [f64; 3] {
    let text = format!(
        r#"Film "rgb" "integer xresolution" 16 "integer yresolution" 16
           Sampler "sobol" "integer pixelsamples" {samples}
           Integrator {integrator}
           LookAt 0 1 0  0 0 0  0 0 1
           Camera "perspective" "float fov" 1
           WorldBegin {world}"#
    );
    mean(&rendered(&text))
}

const FLOOR: &str = r#"Material "diffuse" "rgb reflectance" [0.5 0.25 0.8]
    Shape "trianglemesh" "point3 P" [-9 0 -9  9 0 -9  9 0 9  -9 0 9] "integer indices" [0 1 2 2 3 0]"#;
const DIRECT: &str = r#""directlighting""#;

fn assert_near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found} instead of {expected}");
    }
}

fn times(colour: [f64; 3], by: f64) -> [f64; 3] {
    colour.map(|c| c * by)
}

const REFLECTANCE: [f64; 3] = [0.5, 0.25, 0.8];

#[test]
fn a_floor_under_a_uniform_sky_shows_its_reflectance() {
    let sky = r#"LightSource "infinite" "rgb L" [2 2 2]"#;
    let found = looking_down(256, DIRECT, &format!("{sky} {FLOOR}"));
    assert_near(found, times(REFLECTANCE, 2.0), 1e-3);
}

#[test]
fn a_point_light_falls_off_with_the_square_of_the_distance() {
    let light = r#"LightSource "point" "rgb I" [3 3 3] "point3 from" [0 2 0]"#;
    let found = looking_down(16, DIRECT, &format!("{light} {FLOOR}"));
    assert_near(found, times(REFLECTANCE, 3.0 / 4.0 / PI), 1e-3);
}

#[test]
fn a_distant_light_falls_off_with_the_cosine() {
    let light =
        r#"LightSource "distant" "rgb L" [3 3 3] "point3 from" [3 4 0] "point3 to" [0 0 0]"#;
    let found = looking_down(16, DIRECT, &format!("{light} {FLOOR}"));
    assert_near(found, times(REFLECTANCE, 3.0 * 0.8 / PI), 1e-3);
}

#[test]
fn a_disk_light_has_the_closed_form_irradiance() {
    // On the axis of a disk of radius r at height h: E = pi L r^2 / (r^2 + h^2).
    let light = r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [7 7 7]
        Translate 0 2 0 Rotate 90 1 0 0 Shape "disk" "float radius" 1.5 AttributeEnd"#;
    let found = looking_down(1024, DIRECT, &format!("{light} {FLOOR}"));
    assert_near(found, times(REFLECTANCE, 7.0 * 2.25 / (2.25 + 4.0)), 5e-3);
}

#[test]
fn small_spheres_and_quads_emit_in_proportion_to_their_area() {
    // A small sphere of radius r at distance d: E = pi L r^2 / d^2, however it is transformed.
    let expected = times(REFLECTANCE, 100.0 * 0.05f64.powi(2) / 4.0);
    for shape in [
        r#"Shape "sphere" "float radius" 0.05"#,
        r#"Scale 0.05 0.05 0.05 Shape "sphere""#,
        r#"ReverseOrientation Scale -1 1 1 ReverseOrientation Shape "sphere" "float radius" 0.05"#,
    ] {
        let light = format!(
            r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [100 100 100]
               Translate 0 2 0 {shape} AttributeEnd"#
        );
        let found = looking_down(1024, DIRECT, &format!("{light} {FLOOR}"));
        assert_near(found, expected, 0.01);
    }
    // A quad of side 0.1 facing down: E = L A / d^2, minus 0.1 % due to its size.
    let quad = r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [100 100 100] Translate 0 2 0
        Shape "trianglemesh" "point3 P" [-.05 0 -.05  .05 0 -.05  .05 0 .05  -.05 0 .05]
        "integer indices" [0 1 2 2 3 0] AttributeEnd"#;
    let found = looking_down(1024, DIRECT, &format!("{quad} {FLOOR}"));
    assert_near(found, times(REFLECTANCE, 100.0 * 0.01 / 4.0 / PI), 0.01);
}

#[test]
fn area_lights_emit_from_one_side_by_default() {
    let quad = |more: &str, turn: &str| {
        format!(
            r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [100 100 100] {more}
               Translate 0 2 0 {turn} Rotate 90 1 0 0 Shape "disk" "float radius" 0.1 AttributeEnd"#
        )
    };
    let lit = |more: &str, turn: &str| {
        looking_down(64, DIRECT, &format!("{} {FLOOR}", quad(more, turn)))[0]
    };
    let down = lit("", "");
    assert!(down > 0.0);
    assert_eq!(lit("", "Rotate 180 1 0 0"), 0.0);
    assert_eq!(lit("", "ReverseOrientation"), 0.0);
    assert!((lit(r#""bool twosided" true"#, "Rotate 180 1 0 0") / down - 1.0).abs() < 0.01);
}

#[test]
fn many_lights_add_up() {
    let one = |x: f64, i: f64| {
        format!(r#"LightSource "point" "rgb I" [{i} {i} {i}] "point3 from" [{x} 2 0]"#)
    };
    let lights: String = (0..9).map(|i| one(0.001 * f64::from(i), f64::from(i + 1))).collect();
    let found = looking_down(1024, DIRECT, &format!("{lights} {FLOOR}"));
    assert_near(found, times(REFLECTANCE, 45.0 / 4.0 / PI), 2e-3);
}

#[test]
fn lights_appear_with_their_radiance() {
    let light = r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [3 4 5] "float scale" 2
        Rotate -90 1 0 0 Shape "disk" AttributeEnd"#;
    let found = looking_down(4, DIRECT, light);
    assert_near(found, [6.0, 8.0, 10.0], 1e-6);
    let sky = r#"LightSource "infinite" "rgb L" [1 2 3] "float scale" 2"#;
    assert_near(looking_down(4, DIRECT, sky), [2.0, 4.0, 6.0], 1e-6);
}

#[test]
fn a_path_over_no_surface_sees_emission_only() {
    let world = format!(
        r#"LightSource "infinite" "rgb L" [2 2 2] {FLOOR} AreaLightSource "diffuse" "rgb L" [3 3 3]
           Translate 0 0.5 0 Rotate -90 1 0 0 Shape "disk""#
    );
    let depth = r#""path" "integer maxdepth" 0"#;
    assert_near(looking_down(16, depth, &world), [3.0; 3], 1e-6);
    let floor = format!(r#"LightSource "infinite" "rgb L" [2 2 2] {FLOOR}"#);
    assert_eq!(looking_down(16, depth, &floor), [0.0; 3]);
}

#[test]
fn exposure_is_the_product_of_time_and_iso() {
    let text = r#"Film "rgb" "integer xresolution" 4 "integer yresolution" 4 "float iso" 400
        LookAt 0 1 0  0 0 0  0 0 1
        Camera "perspective" "float fov" 1 "float shutteropen" 0.5 "float shutterclose" 0.75
        WorldBegin LightSource "infinite" "rgb L" [1 1 1]"#;
    assert_near(mean(&rendered(text)), [1.0; 3], 1e-6);
}

#[test]
fn paths_in_an_emitting_sphere_sum_the_geometric_series() {
    // Inside a closed sphere that emits E and reflects rho everywhere, the radiance is the
    // geometric series E (1 + rho + rho^2 + ...). Paths over n surfaces give n + 1 terms.
    let emitting_sphere = r#"AreaLightSource "diffuse" "rgb L" [1 1 1] "bool twosided" true
        Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
        Translate 0 1.1 0 Shape "sphere" "float radius" 4"#;
    for (depth, expected) in [(1, 1.5), (2, 1.75), (3, 1.875), (30, 2.0)] {
        let integrator = format!(r#""path" "integer maxdepth" {depth}"#);
        let found = looking_down(256, &integrator, emitting_sphere);
        // Light samples very close to a surface are rare and bright, so the noise is a few per
        // cent.
        assert_near(found, [expected; 3], 0.02);
    }
}

#[test]
fn a_thin_lens_is_sharp_only_in_focus() {
    let line = |focus: f64| {
        let text = format!(
            r#"Film "rgb" "integer xresolution" 32 "integer yresolution" 32
               Sampler "sobol" "integer pixelsamples" 64 Integrator "directlighting"
               PixelFilter "box" LookAt 0 1 0  0 0 0  0 0 1
               Camera "perspective" "float fov" 40 "float lensradius" 0.1 "float focaldistance" {focus}
               WorldBegin LightSource "infinite" "rgb L" [1 1 1]
               Material "diffuse" "rgb reflectance" [0 0 0]
               Shape "trianglemesh" "point3 P" [0 0 -9  9 0 -9  9 0 9  0 0 9] "integer indices" [0 1 2 2 3 0]"#
        );
        let picture = rendered(&text);
        let row = &picture.pixels[16 * 32..17 * 32];
        row.iter().filter(|pixel| (0.02..0.98).contains(&pixel[0])).count()
    };
    assert!(line(1.0) <= 1, "the edge is sharp in focus");
    assert!(line(0.5) >= 6, "the edge is blurred out of focus");
}

#[test]
fn direct_light_is_visible_in_mirrors_and_through_panes() {
    // A mirror shows the wall behind the camera as it looks from behind the mirror.
    let seen = |camera: &str, mirror: &str, integrator: &str| {
        let text = format!(
            r#"Film "rgb" "integer xresolution" 32 "integer yresolution" 32
               Sampler "sobol" "integer pixelsamples" 256 Integrator {integrator}
               {camera} Camera "perspective" "float fov" 30
               WorldBegin AttributeBegin Translate 0 2 -1
               LightSource "point" "rgb I" [10 20 30] AttributeEnd {mirror}
               Material "diffuse" "rgb reflectance" [0.8 0.8 0.8]
               Shape "bilinearmesh" "point3 P" [9 -9 -3  -9 -9 -3  9 9 -3  -9 9 -3]"#
        );
        mean(&rendered(&text))
    };
    let quad = |z: &str| {
        format!(r#"Shape "bilinearmesh" "point3 P" [-1 -1 {z}  1 -1 {z}  -1 1 {z}  1 1 {z}]"#)
    };
    let direct = r#""directlighting" "integer maxdepth" 5"#;
    let there = seen("LookAt 0 0 6  0 0 0  0 1 0", "", direct);
    let silver = r#"Material "conductor" "rgb reflectance" [1 1 1] "float roughness" 0 "#;
    let mirror = silver.to_owned() + &quad("3");
    assert_near(seen("", &mirror, direct), there, 0.005);
    // The pane transmits (1 - F) / (1 + F) of the light, with F = 0.04 for an index of 1.5.
    let pane = mirror.clone() + r#"Material "thindielectric" "# + &quad("2");
    let passes = (1.0 - 0.04) / (1.0 + 0.04);
    let through = there.map(|c| c * passes * passes);
    let found = seen("", &pane, direct);
    // The pane itself reflects the wall as well, at nearly the same brightness.
    for c in 0..3 {
        assert!(found[c] > 0.99 * through[c] && found[c] < 1.02 * there[c], "{found:?} {there:?}");
    }
    // A path over one surface ends in the mirror.
    assert_eq!(seen("", &mirror, r#""path" "integer maxdepth" 1"#), [0.0; 3]);
}

#[test]
fn pictures_are_upright_and_not_mirrored() {
    // Red is to the right of the camera, green above: pbrt's camera space is left-handed.
    let world = r#"WorldBegin
        AttributeBegin AreaLightSource "diffuse" "rgb L" [1 0 0] "bool twosided" true
            Translate 2 0 4 Shape "sphere" "float radius" 0.5 AttributeEnd
        AttributeBegin AreaLightSource "diffuse" "rgb L" [0 1 0] "bool twosided" true
            Translate 0 1.2 4 Shape "sphere" "float radius" 0.5 AttributeEnd"#;
    let film = r#"Film "rgb" "integer xresolution" 30 "integer yresolution" 20 "float diagonal" 43.27
        Sampler "sobol" "integer pixelsamples" 16"#;
    let lens = crate::support::root().join("lenses/wide.22mm.dat");
    let real = format!(
        r#"Camera "realistic" "string lensfile" "{}" "float aperturediameter" 9 "float focusdistance" 4"#,
        lens.display()
    );
    for camera in [r#"Camera "perspective" "float fov" 50"#, &real] {
        let picture = rendered(&format!("{film} {camera} {world}"));
        let centre = |channel: usize| {
            let (mut x, mut y, mut sum) = (0.0, 0.0, 0.0);
            for (i, pixel) in picture.pixels.iter().enumerate() {
                x += (i % 30) as f32 * pixel[channel];
                y += (i / 30) as f32 * pixel[channel];
                sum += pixel[channel];
            }
            [x / sum, y / sum]
        };
        let ([red_x, red_y], [green_x, green_y]) = (centre(0), centre(1));
        assert!(red_x > 20.0 && (red_y - 9.5).abs() < 1.5, "{camera}: red at {red_x} {red_y}");
        assert!((green_x - 14.5).abs() < 1.5 && green_y < 8.0, "{camera}: {green_x} {green_y}");
    }
}

/// Returns the mean of the middle of a film under a uniform sky of radiance 1, behind a lens of these
/// surfaces.
fn under_a_sky(lens: &str, film: &str) -> f64 {
    let folder = folder();
    let lens = write(&folder, "lens.toml", lens);
    let text = format!(
        r#"Film "rgb" "integer xresolution" 16 "integer yresolution" 16 "float diagonal" 1
           Camera "realistic" "string lensfile" "{}" {film}
           Sampler "sobol" "integer pixelsamples" 64
           WorldBegin LightSource "infinite" "rgb L" [1 1 1]"#,
        lens.display()
    );
    let description =
        petzval_scene_formats::pbrt::read(&write(&folder, "sky.pbrt", text)).expect("a scene");
    let effects = "none".parse().expect("effects");
    let changes = petzval_render::prepare::Changes { effects, ..Default::default() };
    let job = petzval_render::prepare::prepare(description, &changes).expect("a job").job;
    mean(&crate::support::picture(&job, petzval_render::Backend::Simd, 1))[1]
}

/// A film in glass receives as much light as one behind a gap of 1 um: less than a thousandth is lost
/// by the gap, where the index enters squared. Without it, 56 % would be missing.
#[test]
fn a_film_in_a_medium_has_the_light_of_one_in_air() {
    let lens = |film: &str| {
        format!(
            "[[surface]]\nradius = 50\nthickness = 4\ndiameter = 12.3\nindex = 1.5168\nstop = true
             [[surface]]\nradius = -50\nthickness = 45\ndiameter = 30
             [[surface]]\nthickness = 2\ndiameter = 30\nindex = 1.5168\n{film}"
        )
    };
    let focus = "\"float focusdistance\" 100 \"float aperturediameter\" 12.3";
    let air = under_a_sky(&lens("[[surface]]\ndiameter = 30\nthickness = 0.001\n"), focus);
    let glass = under_a_sky(&lens(""), focus);
    assert!((glass / air - 1.0).abs() < 2e-3, "{glass} in glass, {air} in air");
    // pi / (4 N^2), with the f-number in air terms: 49.043 mm / 12.3 mm.
    let expected = PI / 4.0 / (49.043f64 / 12.3).powi(2);
    assert!((glass / expected - 1.0).abs() < 0.02, "{glass} instead of {expected}");
}

#[test]
fn a_stated_f_number_of_a_film_in_a_medium_opens_the_stop_as_in_air() {
    for medium in [1.0, 1.336, 1.5168] {
        let text = format!(
            "[[surface]]\nradius = 30\nthickness = 4\ndiameter = 20\nindex = 1.6\nstop = true
             [[surface]]\nradius = -60\ndiameter = 20\nindex = {medium}\n"
        );
        let folder = folder();
        let path = write(&folder, "lens.toml", &text);
        let lens = petzval_lens_formats::read(&path).expect("a lens");
        let stop = lens.f_number_diameter(8.0).expect("f/8");
        let first_order = petzval_lens::Paraxial::new(&lens);
        let expected = first_order.focal_length / 8.0;
        assert!((stop / expected - 1.0).abs() < 0.02, "index {medium}: {stop} mm, not {expected}");
        // f / N of a sky: the picture says so, too.
        let camera = "\"float focusdistance\" 100 \"float aperturediameter\" ";
        let seen = under_a_sky(&text, &format!("{camera} {stop}"));
        assert!((seen * 4.0 * 64.0 / PI - 1.0).abs() < 0.01, "index {medium}: {seen}");
    }
}
