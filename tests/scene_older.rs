//! Spellings of pbrt-v2 and v3, with the translation of `pbrt --upgrade`.

mod support;

use petzval::scene::pbrt::{CameraSpec, Description};
use petzval::scene::{Light, Material, MaterialModel, Scene};
use support::world::{colour, read, read_world, read_world_with_warnings};

/// Reads a scene, which must not cause a warning, with these directives before its world.
fn silent(directives: &str) -> Description {
    let description =
        read(&format!("{directives}\nWorldBegin\nShape \"sphere\"")).expect(directives);
    assert!(description.warnings.is_empty(), "{directives}: {:#?}", description.warnings);
    description
}

/// Returns the material of the last shape of a world.
fn last(scene: &Scene) -> &Material {
    let shape = scene.shapes.last().expect("a shape");
    &scene.materials[shape.material as usize]
}

#[test]
fn the_film_of_v3_is_upgraded() {
    let film = silent("Film \"image\" \"float scale\" 2 \"float maxsampleluminance\" 10").film;
    assert_eq!((film.iso, film.max_component), (200.0, Some(10.0)));
    let film = silent("Film \"image\"").film;
    assert_eq!((film.iso, film.max_component), (100.0, None));
    let film = silent("Film \"rgb\" \"float iso\" 50 \"string sensor\" \"cie1931\"").film;
    assert_eq!(film.iso, 50.0);
    assert_eq!(film.camera_sensor, None);
}

#[test]
fn settings_without_a_meaning_today_are_left_out_silently() {
    for text in [
        "Sampler \"halton\" \"bool samplepixelcenter\" \"true\" \"integer pixelsamples\" 4",
        "Sampler \"maxmindist\" \"integer dimensions\" 4",
        "Integrator \"path\" \"float rrthreshold\" 1 \"string lightsamplestrategy\" \"spatial\"",
        "Integrator \"directlighting\" \"string strategy\" \"all\" \"integer maxdepth\" 5",
        "Camera \"perspective\" \"float fov\" 40",
        "PixelFilter \"gaussian\" \"float alpha\" 2 \"float xwidth\" 2 \"float ywidth\" 2",
        "Renderer \"sampler\"\nSurfaceIntegrator \"path\"\nVolumeIntegrator \"single\"\n\
         Accelerator \"grid\" \"bool refineimmediately\" \"true\"",
        "TransformBegin\nTranslate 1 2 3\nTransformEnd",
    ] {
        silent(text);
    }
    let text = "Integrator \"sppm\" \"integer numiterations\" 8 \"integer imagewritefrequency\" 4\nWorldBegin";
    let warnings = read(text).expect("a scene").warnings;
    let [warning] = &warnings[..] else { panic!("{warnings:#?}") };
    assert!(warning.message.contains("path is used"), "{warning}");
}

#[test]
fn half_of_the_field_of_view_is_read() {
    let CameraSpec::Thin(thin) = silent("Camera \"perspective\" \"float halffov\" 20").camera
    else {
        panic!("a lens")
    };
    assert_eq!(thin.fov, Some(40.0));
}

const TWO: &str = "MakeNamedMaterial \"a\" \"string type\" \"matte\" \"color Kd\" [1 0 0]\n\
                   MakeNamedMaterial \"b\" \"string type\" \"matte\" \"color Kd\" [0 0 1]\n";

#[test]
fn the_amount_of_a_mix_is_that_of_its_first_material_in_v3() {
    let names = "\"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\"";
    for (mix, expected) in [
        (format!("Material \"mix\" {names} \"rgb amount\" [0.25 0.5 0.75]"), 0.5),
        (format!("Material \"mix\" {names} \"float amount\" 0.25"), 0.25),
        (format!("Material \"mix\" {names}"), 0.5),
        (
            format!(
                "Texture \"t\" \"color\" \"constant\" \"color value\" [0.125 0.125 0.125]\n\
                 MakeNamedMaterial \"m\" \"string type\" \"mix\" {names} \"texture amount\" \"t\"\n\
                 NamedMaterial \"m\""
            ),
            0.125,
        ),
    ] {
        let scene = read_world(&format!("{TWO}{mix}\nShape \"sphere\"")).scene;
        let MaterialModel::Mix { materials, amount } = &last(&scene).model else { panic!("{mix}") };
        let blue = materials.map(|index| match &scene.materials[index as usize].model {
            MaterialModel::Diffuse { reflectance } => colour(reflectance)[2],
            other => panic!("{other:?}"),
        });
        assert_eq!(blue, [1.0, 0.0], "as in pbrt-v4, the second has the amount: {mix}");
        assert_eq!(colour(amount)[0], expected, "{mix}");
    }
    let half = format!("{TWO}Material \"mix\" \"string namedmaterial1\" \"a\"");
    let message = support::world::error(&half);
    assert!(message.contains("a mix without \"string materials\"; expected the names of two"));
}

#[test]
fn plastic_without_gloss_is_diffuse_and_opacity_of_1_is_opaque() {
    for name in ["plastic", "uber"] {
        let gloss = |ks: &str| {
            let world =
                format!("Material \"{name}\" \"rgb Kd\" [0.1 0.2 0.3] {ks}\nShape \"sphere\"");
            last(&read_world(&world).scene).model.clone()
        };
        let MaterialModel::Diffuse { reflectance } = gloss("\"rgb Ks\" [0 0 0]") else {
            panic!("{name}")
        };
        assert_eq!(colour(&reflectance), [0.1, 0.2, 0.3]);
        for ks in ["", "\"rgb Ks\" [0 0 0.1]", "\"float Ks\" 0.1"] {
            assert!(matches!(gloss(ks), MaterialModel::CoatedDiffuse { .. }), "{name} {ks}");
        }
    }
    let opacity = |given: &str| {
        let world = format!("Material \"uber\" {given}\nShape \"sphere\"");
        read_world_with_warnings(&world).warnings.len()
    };
    assert_eq!(opacity("\"rgb opacity\" [1 1 1]"), 0);
    assert_eq!(opacity("\"color opacity\" [1 1 0.5]"), 1);
}

#[test]
fn black_bodies_have_a_scale_behind_their_temperature() {
    let intensity = |given: &str| {
        let scene = read_world(&format!("LightSource \"point\" {given}\nShape \"sphere\"")).scene;
        match &scene.lights.all[..] {
            [Light::Point(point)] => point.intensity,
            other => panic!("{other:?}"),
        }
    };
    let [old, new] = [
        intensity("\"blackbody I\" [5500 125] \"rgb scale\" [2 2 2]"),
        intensity("\"blackbody I\" 5500 \"float scale\" 250"),
    ];
    for channel in 0..3 {
        assert!((old[channel] / new[channel] - 1.0).abs() < 1e-5, "{old:?} {new:?}");
    }
}

#[test]
fn types_and_shapes_of_older_scenes_are_read() {
    let mesh = |coordinates: &str| {
        let world = format!(
            "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] \
             \"normal N\" [0 0 1 0 0 1 0 0 1] {coordinates} \"bool discarddegenerateUVs\" \"true\""
        );
        let scene = read_world(&world).scene;
        match &scene.shapes[0].geometry {
            petzval::scene::Geometry::Mesh(mesh) => mesh.uvs.clone(),
            other => panic!("{other:?}"),
        }
    };
    let expected = mesh("\"point2 uv\" [0 0 1 0 0 1]");
    assert_eq!(expected[1], [1.0, 0.0]);
    for other in ["\"float uv\" [0 0 1 0 0 1]", "\"float st\" [0 0 1 0 0 1]"] {
        assert_eq!(mesh(other), expected, "{other}");
    }
    read_world(
        "Texture \"a\" \"color\" \"checkerboard\" \"color tex1\" [1 1 1] \"xyz tex2\" [0.1 0.1 0.1]\n\
         Texture \"b\" \"float\" \"scale\" \"float tex1\" 1 \"float tex2\" 0.5\n\
         Material \"matte\" \"texture Kd\" \"a\" \"texture bumpmap\" \"b\"\nShape \"sphere\"",
    );
    let volume = "Volume \"homogeneous\" \"color sigma_a\" [1 1 1] \"point p0\" [0 0 0]";
    let warnings = read_world_with_warnings(volume).warnings;
    assert!(warnings[0].message.ends_with("the medium is left out"), "{warnings:#?}");
}

#[test]
fn parameters_of_v4_are_accepted() {
    silent(
        "Film \"rgb\" \"float maxcomponentvalue\" 10 \"bool savefp16\" true\nColorSpace \"rec2020\"",
    );
    let text = "Integrator \"volpath\" \"bool regularize\" true\nWorldBegin";
    let description = read(text).expect("a scene");
    assert!(description.path_limits.regularize && description.warnings.is_empty());
    read_world(
        "Attribute \"shape\" \"float radius\" 0.5\nAttribute \"light\" \"float scale\" 2\n\
         Attribute \"material\" \"float roughness\" 0.1\nAttribute \"texture\" \"float uscale\" 2\n\
         Attribute \"medium\" \"float scale\" 2\nShape \"sphere\"",
    );
}
