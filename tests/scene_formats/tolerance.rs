//! Irregular scenes that pbrt-v4 accepts: repeated parameters, names used before their definition, no
//! camera, files in the working directory, vertices of NaN.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::support::world::{colour, error, read, read_world, read_world_with_warnings};
use crate::support::{folder, petzval, promptly, write};
use petzval_scene::{Geometry, Material, MaterialModel, Scene};
use petzval_scene_formats::pbrt::CameraSpec;

/// Returns the red reflectance of a diffuse material.
fn red(material: &Material) -> f32 {
    match &material.model {
        MaterialModel::Diffuse { reflectance } => colour(reflectance)[0],
        other => panic!("{other:?}"),
    }
}

/// Returns the material of the first shape.
fn first(scene: &Scene) -> &Material {
    &scene.materials[scene.shapes[0].material as usize]
}

#[test]
fn the_last_of_several_parameters_of_a_name_counts() {
    let radius = |given: &str| {
        let bounds = read_world(&format!("Shape \"sphere\" {given}")).scene.bounds();
        bounds.expect("a sphere")[1].x.round()
    };
    assert_eq!(radius("\"float radius\" 1 \"float radius\" 3"), 3.0);
    assert_eq!(radius("\"float radius\" 3 \"integer radius\" 2"), 2.0);
    let text = "Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [0.25 0.25 0.25]\n\
                Material \"diffuse\" \"rgb reflectance\" [1 1 1] \"texture reflectance\" \"t\"\n\
                Shape \"sphere\"";
    assert_eq!(red(first(&read_world(text).scene)), 0.25);
    // Parameters of the directive override those of Attribute.
    let text = "Attribute \"shape\" \"float radius\" 7 \"float radius\" 5\nShape \"sphere\"";
    assert_eq!(read_world(text).scene.bounds().expect("a sphere")[1].x.round(), 5.0);
    assert_eq!(radius("\"float radius\" 1 \"float radius\" 4 \"float phimax\" 360"), 4.0);
}

const LATER: &str = "\nTexture \"deepest\" \"spectrum\" \"constant\" \"rgb value\" [0.5 0.5 0.5]\
                     \nTexture \"half\" \"float\" \"constant\" \"float value\" 0.5";

#[test]
fn textures_may_be_used_before_their_definition() {
    let deep = "Texture \"deep\" \"spectrum\" \"scale\" \"texture tex\" \"deeper\" \
                \"texture scale\" \"half\"\n\
                Texture \"deeper\" \"spectrum\" \"scale\" \"texture tex\" \"deepest\" \
                \"float scale\" 0.5";
    let uses = [
        "Material \"diffuse\" \"texture reflectance\" \"deep\" Shape \"sphere\"",
        "MakeNamedMaterial \"m\" \"string type\" \"diffuse\" \"texture reflectance\" \"deep\"\n\
         NamedMaterial \"m\" Shape \"sphere\"",
        "NamedMaterial \"m\" Shape \"sphere\"\n\
         MakeNamedMaterial \"m\" \"string type\" \"diffuse\" \"texture reflectance\" \"deep\"",
    ];
    for text in uses {
        let scene = read_world(&format!("{text}\n{deep}{LATER}")).scene;
        assert_eq!(red(first(&scene)), 0.125, "{text}");
    }
    let scene = read_world(&format!("Shape \"sphere\" \"texture alpha\" \"half\"{LATER}")).scene;
    let alpha = scene.shapes[0].alpha.as_ref().expect("an alpha");
    assert_eq!(colour(alpha)[0], 0.5);
    let two = "Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [0.75 0.75 0.75]\n\
               Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\"\n\
               Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [0.25 0.25 0.25]";
    assert_eq!(red(first(&read_world(two).scene)), 0.75, "an earlier texture takes precedence");
}

#[test]
fn undefined_textures_are_errors_at_their_use() {
    let named = "Shape \"sphere\"\nMaterial \"diffuse\" \"texture reflectance\" \"halv\"\n\
                 Texture \"half\" \"spectrum\" \"constant\"";
    let message = error(named);
    assert!(message.starts_with("test.pbrt:4:20: no texture \"halv\""), "{message}");
    assert!(message.contains("did you mean \"half\"?"), "{message}");
    let message = error("Shape \"sphere\" \"texture alpha\" \"x\"");
    assert!(message.starts_with("test.pbrt:3:16: no texture \"x\""), "{message}");
    let circle = "Texture \"a\" \"float\" \"scale\" \"texture tex\" \"b\"\n\
                  Texture \"b\" \"float\" \"scale\" \"texture tex\" \"a\"";
    let message = error(circle);
    assert!(message.starts_with("test.pbrt:3:29: the texture \"b\""), "{message}");
    assert!(message.contains("itself"), "{message}");
}

#[test]
fn many_textures_in_reverse_order_are_read_quickly() {
    let mut text = String::from("Material \"diffuse\" \"texture reflectance\" \"t0\"\n");
    for i in 0..20_000 {
        text += &format!("Texture \"t{i}\" \"spectrum\" \"mix\" \"float amount\" 0 ");
        text += &match i % 200 {
            199 => "\"rgb tex1\" [0.5 0.5 0.5]\n".to_owned(),
            _ => format!("\"texture tex1\" \"t{}\"\n", i + 1),
        };
    }
    let text = format!("{text} Shape \"sphere\"");
    let scene = promptly("20,000 textures", || read_world(&text)).scene;
    assert_eq!(red(first(&scene)), 0.5);
}

#[test]
fn a_mix_may_use_materials_that_are_defined_later() {
    let text = "Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" 0\n\
                Shape \"sphere\"\n\
                MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
                MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [1 1 1]";
    let scene = read_world(text).scene;
    let MaterialModel::Mix { materials, .. } = &first(&scene).model else { panic!("no mix") };
    assert_eq!(materials.map(|i| red(&scene.materials[i as usize])), [1.0, 0.0]);
    let message = error("Material \"mix\" \"string materials\" [\"a\" \"b\"]");
    assert!(message.contains("no material named \"a\""), "{message}");
}

#[test]
fn a_scene_without_a_camera_has_a_90_degree_pinhole_at_the_origin() {
    let text = "Translate 0 0 9\nWorldBegin\nTranslate 0 0 5 Shape \"sphere\"";
    let description = read(text).expect("a scene without a camera");
    let CameraSpec::Thin(thin) = description.camera else { panic!("a lens") };
    assert_eq!((thin.fov, thin.lens_radius), (Some(90.0), 0.0));
    assert_eq!(description.world_from_camera, Default::default());
    assert!(description.warnings.is_empty(), "{:#?}", description.warnings);
}

#[test]
fn options_are_read_with_and_without_their_type() {
    let seed = |option: &str| {
        let text = format!("{option}\nCamera \"perspective\"\nWorldBegin\nShape \"sphere\"");
        let description = read(&text).expect(option);
        (description.seed, description.warnings.len())
    };
    assert_eq!(seed("Option \"integer seed\" 7"), (7, 0));
    assert_eq!(seed("Option \"integer seed\" [7]"), (7, 0));
    assert_eq!(seed("Option \"seed\" 7"), (7, 0));
    assert_eq!(seed("Option \"rendercoordsys\" \"cameraworld\" Option \"seed\" 5"), (5, 0));
    assert_eq!(seed("Option \"string rendercoordsys\" \"world\""), (0, 0));
    assert_eq!(seed("Option \"disablepixeljitter\" false"), (0, 0));
    assert_eq!(seed("Option \"disable-pixel_jitter\" true"), (0, 1));
    assert_eq!(seed("Option \"disableWavelengthJitter\" true"), (0, 0));
    let message = read("Option \"sead\" 1").map(|_| ()).expect_err("a typo").to_string();
    assert!(message.contains("unknown option \"sead\"; did you mean \"seed\"?"), "{message}");
    let message = read("Option \"seed\" WorldBegin").map(|_| ()).expect_err("no value").to_string();
    assert!(message.contains("expected a value for \"seed\""), "{message}");
    let message = read("Option \"disablepixeljitter\" 3").map(|_| ()).expect_err("3").to_string();
    assert!(message.contains("of type bool"), "{message}");
}

const MESH: &str = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
                    property float z\nelement face 3\nproperty list uchar int vertex_indices\n\
                    end_header\n0 0 5\n1 0 5\n0 1 5\nnan 1 5\n1 inf 5\n\
                    3 0 1 2\n3 0 1 3\n4 0 1 2 4\n";

#[test]
fn triangles_with_nan_vertices_are_left_out() {
    let folder = folder();
    write(&folder, "mesh.ply", MESH);
    let text =
        "Camera \"perspective\"\nWorldBegin\nShape \"plymesh\" \"string filename\" \"mesh.ply\"";
    let description =
        petzval_scene_formats::pbrt::read(&write(&folder, "test.pbrt", text)).expect("it");
    let [warning] = &description.warnings[..] else { panic!("{:#?}", description.warnings) };
    assert_eq!(
        warning.message,
        "3 of the 4 triangles of a plymesh have vertices that are not finite numbers: \
         they are left out"
    );
    let [shape] = &description.scene.shapes[..] else { panic!("{:?}", description.scene.shapes) };
    let Geometry::Mesh(mesh) = &shape.geometry else { panic!("a quadric") };
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert!(mesh.positions.iter().flatten().all(|v| v.is_finite()), "{:?}", mesh.positions);
    let [low, high] = description.scene.bounds().expect("one triangle");
    assert_eq!([low.to_array(), high.to_array()], [[0.0, 0.0, 5.0], [1.0, 1.0, 5.0]]);
    let text = "Shape \"trianglemesh\" \"point3 P\" [0 0 5 1 0 5 0 1 5 1e39 0 0] \
                \"integer indices\" [0 1 2 1 2 3]";
    assert_eq!(read_world_with_warnings(text).warnings.len(), 1);
    assert_eq!(read_world_with_warnings(text).scene.bounds(), Some([low, high]));
}

/// Creates a scene `parts/scene.pbrt` with files in its folder and above it.
fn scene_in_subfolder() -> tempfile::TempDir {
    let folder = folder();
    std::fs::create_dir_all(folder.path().join("parts/more")).expect("folders");
    let mesh = MESH.replace("nan", "1").replace("inf", "0");
    write(&folder, "parts/beside.ply", &mesh);
    write(&folder, "above.ply", &mesh);
    let shape = |name: &str| format!("Shape \"plymesh\" \"string filename\" \"{name}\"\n");
    let absolute = folder.path().join("above.ply");
    let inner = shape("beside.ply") + &shape("above.ply") + &shape(&absolute.to_string_lossy());
    // Names in an included file are relative to the first file.
    write(&folder, "parts/more/inner.pbrt", inner);
    write(&folder, "listed.pbrt", shape("above.ply"));
    let text = "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4\nWorldBegin\n\
                LightSource \"infinite\"\n\
                Include \"more/inner.pbrt\"\nInclude \"listed.pbrt\"\n";
    write(&folder, "parts/scene.pbrt", text);
    folder
}

#[test]
fn files_are_looked_up_beside_the_scene_and_in_the_working_directory() {
    let folder = scene_in_subfolder();
    let arguments = ["render", "parts/scene.pbrt", "-o", "a.exr", "--spp", "1"];
    let (code, _, stderr) = petzval(folder.path(), &arguments);
    assert_eq!(code, 0, "{stderr}");
    let (code, _, stderr) = petzval(&folder.path().join("parts"), &["render", "scene.pbrt"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("inner.pbrt:2:17: above.ply: cannot read it"), "{stderr}");
}

#[cfg(unix)]
#[test]
fn a_scene_from_a_pipe_uses_files_of_the_working_directory() {
    let folder = scene_in_subfolder();
    let piped = |at: &Path| {
        let mut cat = Command::new("cat");
        cat.arg(folder.path().join("parts/scene.pbrt")).stdout(Stdio::piped());
        let mut cat = cat.spawn().expect("cat");
        let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
        command.args(["render", "/dev/stdin", "-o", "a.exr", "--spp", "1"]).current_dir(at);
        command.stdin(cat.stdout.take().expect("a pipe")).stdout(Stdio::null());
        let output = command.output().expect("the command starts");
        cat.wait().expect("cat ends");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    std::fs::copy(folder.path().join("above.ply"), folder.path().join("parts/above.ply"))
        .expect("a copy");
    File::create(folder.path().join("parts/listed.pbrt")).expect("a file");
    let (code, stderr) = piped(&folder.path().join("parts"));
    assert_eq!(code, Some(0), "{stderr}");
}

#[test]
fn parameters_without_effect_on_the_picture_cause_no_warning() {
    for text in [
        "Accelerator \"bvh\" \"string splitmethod\" \"hlbvh\" \"integer maxnodeprims\" 4",
        "Accelerator \"kdtree\" \"integer intersectcost\" 80",
        "Sampler \"bestcandidate\" \"integer pixelsamples\" 4",
        "Renderer \"sampler\"",
        "VolumeIntegrator \"emission\" \"float stepsize\" 1",
        "Film \"rgb\" \"bool savefp16\" false \"bool display\" true",
    ] {
        let description = read(&format!("{text}\nWorldBegin\nShape \"sphere\"")).expect(text);
        assert!(description.warnings.is_empty(), "{text}: {:#?}", description.warnings);
    }
    for text in [
        "Material \"plastic\" \"rgb Kd\" [0.1 0.2 0.3] \"rgb Ks\" [0.1 0.1 0.1]",
        "Material \"substrate\"",
        "Material \"glass\"",
        "Material \"metal\"",
        "Material \"mirror\"",
        "AreaLightSource \"diffuse\" \"integer samples\" 4",
        "LightSource \"infinite\" \"integer nsamples\" 4",
    ] {
        read_world(&format!("{text}\nShape \"sphere\""));
    }
    // Parameters that do change the picture still cause warnings.
    for text in [
        "Material \"uber\" \"rgb opacity\" [0.5 0.5 0.5]",
        "Material \"plastic\" \"texture bumpmap\" \"t\" \"float sigma\" 3",
        "Material \"disney\"",
    ] {
        let text = format!("Texture \"t\" \"float\" \"constant\"\n{text}\nShape \"sphere\"");
        match read(&format!("WorldBegin\n{text}")) {
            Ok(description) => assert!(!description.warnings.is_empty(), "{text}"),
            Err(error) => assert!(error.to_string().contains("sigma"), "{error}"),
        }
    }
}

#[test]
fn a_second_object_of_a_name_replaces_the_first_from_there_on() {
    let ball = |radius: f64| format!("Shape \"sphere\" \"float radius\" {radius}");
    let text = format!(
        "ObjectBegin \"a\" {} ObjectEnd\n\
         ObjectBegin \"b\" ObjectInstance \"a\" ObjectEnd\n\
         ObjectBegin \"a\" {} ObjectInstance \"b\" ObjectEnd\n\
         ObjectInstance \"a\"",
        ball(3.0),
        ball(1.0)
    );
    let description = read_world_with_warnings(&text);
    let [warning] = &description.warnings[..] else { panic!("{:#?}", description.warnings) };
    assert!(warning.message.contains("a second object \"a\""), "{warning:?}");
    // The nested instance is still the large ball, and nothing contains itself.
    let [low, high] = description.scene.bounds().expect("two balls");
    assert_eq!([low.x.round(), high.x.round()], [-3.0, 3.0]);
    let text = format!("ObjectBegin \"a\" {} ObjectEnd\n", ball(3.0));
    let text = format!("{text}ObjectBegin \"a\" {} ObjectEnd\nObjectInstance \"a\"", ball(1.0));
    let [low, high] = read_world_with_warnings(&text).scene.bounds().expect("a ball");
    assert_eq!([low.x.round(), high.x.round()], [-1.0, 1.0]);
}

#[test]
fn the_last_row_of_a_projective_matrix_is_left_out() {
    let of = |last: &str| {
        let matrix = format!("Transform [2 0 0 {last}  0 2 0 0  0 0 2 0  1 0 0 1]");
        read_world_with_warnings(&format!("{matrix}\nShape \"sphere\""))
    };
    let (plain, projective) = (of("0"), of("0.5"));
    assert!(plain.warnings.is_empty() && projective.warnings.len() == 1);
    assert_eq!(plain.scene.bounds(), projective.scene.bounds());
}
