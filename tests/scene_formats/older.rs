//! Spellings of pbrt-v2 and v3, with the translation of `pbrt --upgrade`.

use crate::support::world::{colour, read, read_world, read_world_with_warnings};
use petzval_scene::{Light, Material, MaterialModel, Scene};
use petzval_scene_formats::pbrt::{CameraSpec, Description};

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
    let message = crate::support::world::error(&half);
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
            [Light::Point(point)] => point.intensity.clone(),
            other => panic!("{other:?}"),
        }
    };
    let [old, new] = [
        intensity("\"blackbody I\" [5500 125] \"rgb scale\" [2 2 2]"),
        intensity("\"blackbody I\" 5500 \"float scale\" 250"),
    ];
    for channel in 0..3 {
        assert!((old.rgb[channel] / new.rgb[channel] - 1.0).abs() < 1e-5, "{old:?} {new:?}");
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
            petzval_scene::Geometry::Mesh(mesh) => mesh.uvs.clone(),
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

/// Reads a scene of pbrt-v3: its film is an image.
fn read_v3(world: &str) -> Description {
    let text = format!("Film \"image\"\nCamera \"perspective\"\nWorldBegin\n{world}\nWorldEnd");
    read(&text).expect(world)
}

#[test]
fn unused_parameters_of_older_files_are_a_warning_and_of_new_ones_an_error() {
    let world = "Material \"matte\" \"rgb Kd\" [.5 .5 .5] \"rgb Ks\" [.2 .2 .2]\n\
        LightSource \"point\" \"bool castshadows\" \"true\"\nShape \"sphere\" \"float forked\" 3";
    let scene = read_v3(world);
    let messages: Vec<&str> = scene.warnings.iter().map(|w| w.message.as_str()).collect();
    for name in ["\"Ks\" of Material", "\"castshadows\" of LightSource", "\"forked\" of Shape"] {
        assert!(
            messages.iter().any(|m| m.contains(name) && m.contains("left out")),
            "{messages:?}"
        );
    }
    assert!(read(&format!("Camera \"perspective\"\nWorldBegin\n{world}")).is_err());
    // Each sign of an older dialect counts.
    for before in ["Film \"image\"", "SurfaceIntegrator \"path\""] {
        assert!(read(&format!("{before}\nWorldBegin\n{world}")).is_ok(), "{before}");
    }
    let text = format!("WorldBegin\n{world}\n");
    assert!(read(&format!("{text}WorldEnd # the end")).is_ok());
    assert!(read(&format!("{text}# WorldEnd\n")).is_err());
}

#[test]
fn shapes_override_parameters_of_their_material_before_v4() {
    let world = "Material \"matte\" \"rgb Kd\" [.1 .1 .1]\nShape \"sphere\" \"rgb Kd\" [.8 .1 .1]\n\
        MakeNamedMaterial \"a\" \"string type\" \"matte\" \"rgb Kd\" [.2 .2 .2]\n\
        AttributeBegin\nNamedMaterial \"a\"\nShape \"sphere\" \"rgb Kd\" [.3 .3 .3]\n\
        Shape \"sphere\" \"float radius\" 2\nAttributeEnd\nShape \"sphere\" \"float radius\" 3";
    let Description { scene, warnings, .. } = read_v3(world);
    assert!(warnings.is_empty(), "{warnings:#?}");
    let found: Vec<[f32; 3]> = scene
        .shapes
        .iter()
        .map(|shape| match &scene.materials[shape.material as usize].model {
            MaterialModel::Diffuse { reflectance } => colour(reflectance),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(found, [[0.8, 0.1, 0.1], [0.3; 3], [0.2; 3], [0.1; 3]]);
    assert!(read(&format!("WorldBegin\n{world}")).is_err(), "pbrt-v4 refuses it");
}

#[test]
fn attributes_and_objects_share_one_stack_before_v4() {
    let object = "AttributeBegin\nTranslate 5 0 0\nObjectBegin \"a\"\nTranslate 0 7 0\n\
        Shape \"sphere\"\nAttributeEnd\nObjectEnd\n";
    let Description { scene, warnings, .. } =
        read_v3(&format!("{object}ObjectInstance \"a\"\nShape \"sphere\""));
    assert!(warnings.is_empty(), "{warnings:#?}");
    // The object stands where it was defined, and the transforms before it are restored.
    let [low, high] = scene.bounds().expect("bounds");
    assert!(low.abs_diff_eq(glam::Vec3::NEG_ONE, 1e-5), "{low}");
    assert!(high.abs_diff_eq(glam::Vec3::new(6.0, 8.0, 1.0), 1e-5), "{high}");
    assert!(read(&format!("WorldBegin\n{object}Shape \"sphere\"")).is_err());
    // Transforms have a stack of their own.
    let crossed = "Translate 1 0 0\nTransformBegin\nTranslate 2 0 0\nAttributeBegin\n\
        Translate 4 0 0\nTransformEnd\nShape \"sphere\" \"float radius\" 0.5\nAttributeEnd\n\
        Shape \"sphere\" \"float radius\" 0.25";
    let shapes = read_v3(crossed).scene.shapes;
    let middle = |i: usize| match &shapes[i].geometry {
        petzval_scene::Geometry::Quadric(sphere) => sphere.whole_sphere().expect("one").centre.x,
        _ => panic!("no sphere"),
    };
    assert_eq!([middle(0), middle(1)], [3.0, 1.0]);
    let open = read_v3("AttributeBegin\nShape \"sphere\"");
    assert!(open.warnings[0].message.contains("AttributeBegin without AttributeEnd"));
}

#[test]
fn an_area_light_on_no_material_shines_before_v4() {
    let world = "AttributeBegin\nMaterial \"none\"\nAreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n\
        Shape \"sphere\"\nAttributeEnd\nLookAt 0 0 5 0 0 0 0 1 0";
    let text = |film: &str| {
        format!(
            "Film \"{film}\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
             LookAt 0 0 -5 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" 10\n\
             Sampler \"random\" \"integer pixelsamples\" 4\nWorldBegin\n{world}\n"
        )
    };
    let picture = crate::support::rendered(&text("image"));
    assert!(picture.pixels.iter().flatten().all(|&v| (v - 1.0).abs() < 1e-5));
    assert!(crate::support::rendered(&text("rgb")).pixels.iter().flatten().all(|&v| v == 0.0));
    // Rays pass through it: behind the lamp, the sky shines.
    let sky = text("image") + "LightSource \"infinite\" \"rgb L\" [2 2 2]\n";
    let picture = crate::support::rendered(&sky);
    assert!(picture.pixels.iter().flatten().all(|&v| (v - 3.0).abs() < 1e-4));
}

#[test]
fn a_shutter_of_no_time_is_a_still_picture_before_v4() {
    let camera = "Camera \"perspective\" \"float shutteropen\" 0.5 \"float shutterclose\" 0.5\n";
    let scene = read(&format!("Film \"image\"\n{camera}WorldBegin\nShape \"sphere\"")).expect("v3");
    assert_eq!(scene.shutter.open, 0.5);
    assert!(scene.shutter.time() > 0.0 && scene.shutter.time() < 1e-6);
    let CameraSpec::Thin(thin) = scene.camera else { panic!("a lens") };
    assert_eq!(thin.exposure_time, 1.0);
    assert!(read(&format!("{camera}WorldBegin\nShape \"sphere\"")).is_err());
}

#[test]
fn an_empty_name_of_a_picture_is_none() {
    for light in [
        "LightSource \"infinite\" \"rgb L\" [1 1 1] \"string filename\" \"\"",
        "LightSource \"infinite\" \"rgb L\" [1 1 1] \"string mapname\" [\"\"]",
        "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"string filename\" \"\"",
        "Material \"diffuse\" \"string normalmap\" \"\"",
    ] {
        read_world(&format!("{light}\nShape \"sphere\""));
    }
}

#[test]
fn measured_surfaces_of_v2_have_a_substitute() {
    for file in ["a.brdf", "b.BINARY"] {
        let world = format!(
            "Material \"measured\" \"string filename\" \"{file}\" \"rgb Kd\" [.1 .2 .3]\nShape \"sphere\""
        );
        let Description { scene, warnings, .. } = read_v3(&world);
        assert!(warnings.iter().any(|w| w.message.contains("not supported")), "{warnings:#?}");
        let MaterialModel::Diffuse { reflectance } = &last(&scene).model else { panic!("{file}") };
        assert_eq!(colour(reflectance), [0.1, 0.2, 0.3]);
    }
}

#[test]
fn kdsubsurface_is_a_subsurface_of_its_reflectance() {
    let model = |scene: &Scene| match &last(scene).model {
        MaterialModel::Subsurface { interior, .. } => (interior.medium, interior.eta),
        other => panic!("{other:?}"),
    };
    let old =
        "Material \"kdsubsurface\" \"rgb Kd\" [.8 .5 .2] \"rgb mfp\" [2 2 2] \"float index\" 1.4";
    let new = "Material \"subsurface\" \"rgb reflectance\" [.8 .5 .2] \"rgb mfp\" [2 2 2] \"float eta\" 1.4";
    let scene = |material: &str| read_world(&format!("{material}\nShape \"sphere\"")).scene;
    assert_eq!(model(&scene(old)), model(&scene(new)));
}

#[test]
fn ambient_occlusion_is_the_share_of_the_sky() {
    // Under an endless plane, nothing is seen; beside a wall at right angles, half.
    let text = "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4\n\
        LookAt 0 0 1e-3 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" 1\n\
        Sampler \"independent\" \"integer pixelsamples\" 256\n\
        Integrator \"ambientocclusion\"\nWorldBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
        AreaLightSource \"diffuse\" \"rgb L\" [9 9 9]\nShape \"disk\" \"float radius\" 50\n\
        Translate -0.002 0 0\nRotate 90 0 1 0\nShape \"disk\" \"float radius\" 50\n";
    let mean = crate::support::mean(&crate::support::rendered(text));
    assert!((mean[0] - 0.5).abs() < 0.03, "{mean:?}");
}

#[test]
fn goniometric_pictures_of_v3_have_any_size_and_ies_files_are_read() {
    let folder = crate::support::folder();
    let lamp = "TILT=NONE\n1 1000 1 2 1 1 2 0 0 0 1 1 50\n0 90\n0\n100 0\n";
    crate::support::write(&folder, "lamp.IES", lamp);
    let pixels = vec![[2.0; 3]; 12];
    let picture = petzval_image::Picture { size: [6, 2], pixels };
    crate::support::write(&folder, "map.pfm", pfm(&picture));
    let light = |head: &str, light: &str| {
        let text = format!("{head}\nWorldBegin\nLightSource \"goniometric\" {light}");
        let scene =
            petzval_scene_formats::pbrt::read(&crate::support::write(&folder, "a.pbrt", text));
        scene.map(|scene| match &scene.scene.lights.all[0] {
            Light::Point(light) => light.clone(),
            other => panic!("{other:?}"),
        })
    };
    let down = light("", "\"string filename\" \"lamp.IES\"").expect("an IES file");
    assert!(down.towards(glam::Vec3::NEG_Y)[0] > 98.0);
    assert_eq!(down.towards(glam::Vec3::Y)[0], 0.0);
    let map = light("Film \"image\"", "\"string mapname\" \"map.pfm\"").expect("a map of v3");
    assert!((map.towards(glam::Vec3::X)[0] - 2.0).abs() < 1e-5);
    let none = light("Film \"image\"", "\"rgb I\" [3 3 3]").expect("no map");
    assert_eq!(none.towards(glam::Vec3::X), [3.0; 3]);
    assert!(light("", "\"string filename\" \"map.pfm\"").is_err());
}

/// Returns a picture as a PFM file.
fn pfm(picture: &petzval_image::Picture) -> Vec<u8> {
    let [width, height] = picture.size;
    let values = picture.pixels.iter().flatten().flat_map(|v| v.to_le_bytes());
    format!("PF\n{width} {height}\n-1\n").into_bytes().into_iter().chain(values).collect()
}
