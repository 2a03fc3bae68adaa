//! Scene reader: directives, warnings and errors.

use crate::support::{folder, mean, rendered, write, write_picture};
use petzval_scene_formats::pbrt;
use petzval_scene_formats::pbrt::{CameraSpec, Description, RealisticSpec, SceneErrors};

fn read(text: &str) -> Result<Description, SceneErrors> {
    let folder = folder();
    pbrt::read(&write(&folder, "test.pbrt", text))
}

const HEAD: &str = "Camera \"perspective\"\nWorldBegin\n";

/// Returns the error for a scene with this text from its third line on, without the folder.
fn error(world: &str) -> String {
    let text = match read(&format!("{HEAD}{world}")) {
        Ok(_) => panic!("accepted: {world}"),
        Err(error) => error.to_string(),
    };
    text[text.find("test.pbrt").unwrap_or(0)..].to_owned()
}

#[test]
fn errors_name_line_column_and_the_closest_name() {
    let cases = [
        ("Shpe \"sphere\"", "test.pbrt:3:1: unknown directive \"Shpe\"; did you mean \"Shape\"?"),
        ("Shape \"spere\"", "test.pbrt:3:1: unknown Shape \"spere\"; did you mean \"sphere\"?"),
        ("Shape \"xyzzy\"", "test.pbrt:3:1: unknown Shape \"xyzzy\"; known are trianglemesh, "),
        (
            "Shape \"sphere\" \"float radios\" 2",
            "test.pbrt:3:16: unknown parameter \"radios\" of Shape \"sphere\"; did you mean \"radius\"?",
        ),
        ("Shape \"sphere\"\n  \"flot radius\" 2", "test.pbrt:4:3: unknown parameter type \"flot\""),
        ("Shape \"sphere\" \"radius\" 2", "test.pbrt:3:16: found \"radius\"; expected a parameter"),
        ("Shape \"sphere\" \"float radius\" -2", "test.pbrt:3:16: \"radius\" is -2; expected more"),
        ("Shape \"sphere\" \"float radius\" [1 2]", "test.pbrt:3:16: 2 values for \"radius\""),
        (
            "Shape \"sphere\" \"string radius\" \"2\"",
            "test.pbrt:3:16: \"string radius\" with these",
        ),
        (
            "Shape \"sphere\" \"float radius\" [1",
            "test.pbrt:3:1: the file ends here; expected a value",
        ),
        (
            "Shape \"sphere\" \"float radius\" 1e999",
            "test.pbrt:3:31: the number 1e999 is out of range",
        ),
        ("Translate 1 2", "test.pbrt:3:1: the file ends here; expected 3 numbers"),
        ("Translate 1 2 x", "test.pbrt:3:15: found x; expected 3 numbers"),
        ("Translate 1 2 3x", "test.pbrt:3:15: \"3x\" is neither a number nor a directive"),
        ("Scale 1 0 1", "test.pbrt:3:1: Scale by 0"),
        ("Rotate 10 0 0 0", "test.pbrt:3:1: Rotate about no axis"),
        ("LookAt 1 1 1 1 1 1 0 1 0", "test.pbrt:3:1: LookAt from a point to itself"),
        ("Material \"matte", "test.pbrt:3:10: a quoted string that does not end"),
        ("\"sphere\"", "test.pbrt:3:1: \"sphere\" in place of a directive"),
        ("AttributeEnd", "test.pbrt:3:1: AttributeEnd without AttributeBegin"),
        ("AttributeBegin\nTransformEnd", "test.pbrt:4:1: TransformEnd inside the AttributeBegin"),
        ("\nAttributeBegin", "test.pbrt:4:1: AttributeBegin without AttributeEnd"),
        (
            "ObjectBegin \"a\"\nObjectInstance \"a\"\nObjectEnd",
            "test.pbrt:4:1: object \"a\" contains",
        ),
        ("ObjectInstance \"tre\"", "test.pbrt:3:1: no object \"tre\""),
        ("NamedMaterial \"gold\"", "test.pbrt:3:1: no material named \"gold\""),
        ("Material \"matte\" \"texture Kd\" \"wood\"", "test.pbrt:3:18: no texture \"wood\""),
        ("Include \"no.pbrt\"", "test.pbrt:3:1: cannot read "),
        ("Shape \"plymesh\" \"string filename\" \"no.ply\"", "test.pbrt:3:17: "),
        (
            "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"no.png\"",
            "test.pbrt:3:32: cannot read the picture ",
        ),
        (
            "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]",
            "test.pbrt:3:52: the index 3; expected indices from 0 to below 3",
        ),
        (
            "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1] \"integer indices\" [0 1 2]",
            "test.pbrt:3:22: 8 numbers for \"point3 P\"; expected a positive multiple of 3",
        ),
        ("Film \"rgb\"", "test.pbrt:3:1: Film after WorldBegin"),
        ("WorldBegin", "test.pbrt:3:1: a second WorldBegin"),
    ];
    for (world, expected) in cases {
        let message = error(world);
        assert!(
            message.starts_with(expected),
            "{world}\n  found    {message}\n  expected {expected}"
        );
    }
}

#[test]
fn missing_parts_of_a_scene_are_errors() {
    for (text, expected) in [
        ("", "the file ends without WorldBegin"),
        ("Shape \"sphere\"", "Shape before WorldBegin"),
        ("Camera \"realistic\" WorldBegin", "a realistic camera without a lens"),
        ("Camera \"perspective\" \"float fov\" 180 WorldBegin", "a field of view of 180"),
        ("Film \"rgb\" \"integer xresolution\" 0 Camera \"perspective\" WorldBegin", "xresolution"),
        (
            "Camera \"perspective\" \"float shutteropen\" 1 \"float shutterclose\" 1 WorldBegin",
            "a shutter that is open for 0 s",
        ),
    ] {
        let message = read(text).map(|_| ()).expect_err(text).to_string();
        assert!(message.contains(expected), "{text}: {message}");
    }
}

#[test]
fn unsupported_features_are_warnings_that_name_the_replacement() {
    let description = read(&format!(
        "{HEAD}Material \"disney\" \"rgb mfp\" [1 1 1]\nMaterial \"disney\"\n\
         Material \"fourier\"\nMaterial \"uber\" \"rgb opacity\" [0 0 0]\n\
         Shape \"sphere\" \"texture shadowalpha\" \"holes\"\nLightSource \"infinite\"\n"
    ))
    .unwrap();
    let messages: Vec<String> = description.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(messages.len(), 4, "each feature has one warning: {messages:#?}");
    for (message, (line, expected)) in messages.iter().zip([
        ("3:1", "Material \"disney\" is not supported yet: a diffuse surface"),
        ("5:1", "Material \"fourier\" is not supported yet: a diffuse surface"),
        ("6:17", "\"opacity\" of Material \"uber\" is not supported yet: the surface is opaque"),
        ("7:16", "\"shadowalpha\" of Shape \"sphere\" is not supported yet: alpha alone decides"),
    ]) {
        assert!(message.contains(&format!("test.pbrt:{line}: {expected}")), "{message}");
    }
    assert_eq!(description.scene.shapes.len(), 1);
}

#[test]
fn the_scenes_of_the_repository_are_read_without_warnings() {
    for scene in ["dgauss", "fisheye", "telephoto", "wide", "snowman", "atelier"] {
        let path = crate::support::root().join(format!("scenes/{scene}.pbrt"));
        let description = pbrt::read(&path).expect(scene);
        assert!(description.warnings.is_empty(), "{scene}: {:#?}", description.warnings);
    }
}

#[test]
fn both_dialects_of_the_realistic_camera_are_read() {
    let v2 = read(
        "Film \"image\" \"integer xresolution\" [30] \"integer yresolution\" [20]\n\
         Sampler \"lowdiscrepancy\" \"integer pixelsamples\" [7]\n\
         Scale 1000 1000 1000\n\
         Camera \"realistic\" \"string specfile\" \"a.dat\" \"float filmdistance\" 36.77\n\
         \"float aperture_diameter\" 17.1 \"float filmdiag\" 70 \"float hither\" [0.001 ]\n\
         \"float yon\" [1e+30 ] \"float shutteropen\" [0 ] \"float shutterclose\" [0 ]\n\
         WorldBegin\nMaterial \"matte\" \"color Kd\" [ .2 .2 .5 ]\nWorldEnd",
    )
    .unwrap();
    let CameraSpec::Realistic(RealisticSpec::V2 { aperture, film_distance, film_diagonal, .. }) =
        v2.camera
    else {
        panic!("{:?}", v2.camera)
    };
    assert_eq!([aperture, film_distance, film_diagonal], [17.1, 36.77, 70.0]);
    assert_eq!((v2.film.resolution, v2.samples, v2.path_limits.direct_only), ([30, 20], 7, true));

    let v4 = read(
        "Film \"rgb\" \"float diagonal\" 43.27 \"float cropwindow\" [0.25 0.5 0 1] \"float iso\" 200\n\
         Camera \"realistic\" \"string lensfile\" \"a.dat\" \"float aperturediameter\" 5\n\
         \"float focusdistance\" 3 \"float shutterclose\" 0.5\nWorldBegin",
    )
    .unwrap();
    let CameraSpec::Realistic(RealisticSpec::V4 { aperture, focus, exposure_time, .. }) = v4.camera
    else {
        panic!("{:?}", v4.camera)
    };
    assert_eq!([aperture, focus, exposure_time], [5.0, 3.0, 0.5]);
    assert_eq!(v4.film.bounds, [[320, 0], [640, 720]]);
    assert_eq!((v4.film.diagonal, v4.film.iso, v4.path_limits.max_depth), (43.27, 200.0, 5));
}

/// Returns the mean colour of a picture that looks down on the origin.
fn mean_from_above(world: &str) -> [f64; 3] {
    mean(&rendered(&format!(
        "Film \"rgb\" \"integer xresolution\" 32 \"integer yresolution\" 32\n\
         Sampler \"sobol\" \"integer pixelsamples\" 16\nIntegrator \"directlighting\"\n\
         LookAt 0 10 0  0 0 0  0 0 1\nCamera \"perspective\" \"float fov\" 20\nWorldBegin\n\
         LightSource \"infinite\" \"rgb L\" [0 0 0]\n\
         AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"bool twosided\" true\n{world}"
    )))
}

#[test]
fn transforms_nest_and_end_as_in_pbrt() {
    let unit = mean_from_above("Shape \"sphere\" \"float radius\" 0.5")[0];
    assert!(unit > 0.01);
    for world in [
        "Translate 3 0 0 Translate -3 0 0 Shape \"sphere\" \"float radius\" 0.5",
        "TransformBegin Translate 3 0 0 TransformEnd Shape \"sphere\" \"float radius\" 0.5",
        "AttributeBegin Scale 9 9 9 AttributeEnd Shape \"sphere\" \"float radius\" 0.5",
        "Scale 0.5 0.5 0.5 Shape \"sphere\"",
        "Translate 1 2 3 Identity Scale 0.5 0.5 0.5 Shape \"sphere\"",
        "Transform [0.5 0 0 0  0 0.5 0 0  0 0 0.5 0  0 0 0 1] Shape \"sphere\"",
        "Translate 7 7 7 CoordinateSystem \"there\" Identity Scale 9 9 9 \
         CoordSysTransform \"there\" Translate -7 -7 -7 Shape \"sphere\" \"float radius\" 0.5",
        "CoordSysTransform \"camera\" Translate 0 0 10 Shape \"sphere\" \"float radius\" 0.5",
        "ConcatTransform [1 0 0 0  0 1 0 0  0 0 1 0  2 0 0 1] Translate -2 0 0 Rotate 33 0 1 0 \
         Shape \"sphere\" \"float radius\" 0.5",
    ] {
        let found = mean_from_above(world)[0];
        assert!((found / unit - 1.0).abs() < 0.03, "{world}: {found} instead of {unit}");
    }
    // LookAt as a world transform moves the scene in front of the eye.
    let eye = "Translate 0 0 -5 LookAt 0 0 0  0 0 -5  0 1 0 Translate 0 0 -5 \
               Shape \"sphere\" \"float radius\" 0.5";
    assert!(mean_from_above(eye)[0] > 0.0);
}

#[test]
fn instances_nest() {
    let floor = |shape: &str| {
        mean(&rendered(&format!(
            "Film \"rgb\" \"integer xresolution\" 32 \"integer yresolution\" 32\n\
             Sampler \"sobol\" \"integer pixelsamples\" 16\nIntegrator \"directlighting\"\n\
             LookAt 0 10 0  0 0 0  0 0 1\nCamera \"perspective\" \"float fov\" 30\nWorldBegin\n\
             LightSource \"distant\" \"point3 from\" [0 1 0] \"point3 to\" [0 0 0]\n{shape}"
        )))[0]
    };
    let disk = "Rotate -90 1 0 0 Shape \"disk\" \"float radius\" 0.4";
    let plain: String = [(-1, -1), (-1, 1), (1, -1), (1, 1)]
        .map(|(x, z)| format!("AttributeBegin Translate {x} 0 {z} {disk} AttributeEnd "))
        .concat();
    let nested = format!(
        "ObjectBegin \"one\" {disk} ObjectEnd\n\
         ObjectBegin \"two\" Translate 0 0 -1 ObjectInstance \"one\" Translate 0 0 2 \
         ObjectInstance \"one\" ObjectEnd\n\
         AttributeBegin Translate -1 0 0 ObjectInstance \"two\" AttributeEnd\n\
         Translate 1 0 0 ObjectInstance \"two\""
    );
    let (plain, nested) = (floor(&plain), floor(&nested));
    assert!(plain > 0.01 && (nested / plain - 1.0).abs() < 0.01, "{nested} instead of {plain}");
}

#[test]
fn textures_are_upright() {
    // The upper half of the picture is white. v points up in pbrt-v4, and down in the v2 dialect.
    let folder = folder();
    let mut pixels = vec![[1.0f32; 3]; 8];
    pixels.extend([[0.0; 3]; 8]);
    let picture = petzval_image::Picture { size: [4, 4], pixels };
    let path = folder.path().join("half.png");
    write_picture(&picture, &path);
    let seen = |v: &str| {
        let text = format!(
            "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
             Integrator \"directlighting\" LookAt 0 1 0  0 0 0  0 0 1\n\
             Camera \"perspective\" \"float fov\" 1\nWorldBegin\n\
             LightSource \"infinite\" \"rgb L\" [1 1 1]\n\
             Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{}\"\n\
             Material \"diffuse\" \"texture reflectance\" \"t\"\n\
             Shape \"trianglemesh\" \"point3 P\" [-9 0 -9 9 0 -9 9 0 9 -9 0 9]\n\
             \"point2 uv\" [0.5 {v} 0.5 {v} 0.5 {v} 0.5 {v}] \"integer indices\" [0 1 2 2 3 0]",
            path.display()
        );
        mean(&rendered(&text))[0]
    };
    assert!(seen("0.7") > 0.99 && seen("0.3") < 0.01);
}

#[test]
fn a_sky_is_read_from_a_radiance_picture() {
    // The sky is dark below the horizon and 2 above. In the layout of pbrt-v2 z is up and the zenith at
    // the top.
    let folder = folder();
    let path = folder.path().join("sky.hdr");
    let half = |v: f32| vec![image::Rgb([v, v / 2.0, v / 4.0]); 32 * 8];
    let pixels = [half(2.0), half(0.0)].concat();
    image::codecs::hdr::HdrEncoder::new(std::fs::File::create(&path).unwrap())
        .encode(&pixels, 32, 16)
        .unwrap();
    let floor = |turn: &str| {
        mean(&rendered(&format!(
            "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
             Sampler \"sobol\" \"integer pixelsamples\" 64\n\
             Integrator \"directlighting\" LookAt 0 1 0  0 0 0  0 0 1\n\
             Camera \"perspective\" \"float fov\" 1\nWorldBegin\n\
             AttributeBegin {turn} LightSource \"infinite\" \"string filename\" \"{}\" AttributeEnd\n\
             Material \"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]\n\
             Shape \"trianglemesh\" \"point3 P\" [-9 0 -9 9 0 -9 9 0 9 -9 0 9]\n\
             \"integer indices\" [0 1 2 2 3 0]",
            path.display()
        )))
    };
    for (found, expected) in floor("Rotate -90 1 0 0").into_iter().zip([1.0, 0.5, 0.25]) {
        // One of sixteen rows of texels blends across the horizon.
        assert!((found / expected - 1.0).abs() < 0.02, "{found} instead of {expected}");
    }
    assert!(floor("Rotate 90 1 0 0")[0] < 0.02);
}

#[test]
fn checkerboards_and_scaled_textures_have_their_mean() {
    let colour = |texture: &str| {
        mean(&rendered(&format!(
            "Film \"rgb\" \"integer xresolution\" 32 \"integer yresolution\" 32\n\
             Sampler \"sobol\" \"integer pixelsamples\" 16\nIntegrator \"directlighting\"\n\
             LookAt 0 1 0  0 0 0  0 0 1\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\n\
             LightSource \"infinite\" \"rgb L\" [1 1 1]\n{texture}\n\
             Material \"diffuse\" \"texture reflectance\" \"t\"\n\
             Shape \"trianglemesh\" \"point3 P\" [-2 0 -2 2 0 -2 2 0 2 -2 0 2]\n\
             \"point2 uv\" [0 0 1 0 1 1 0 1] \"integer indices\" [0 1 2 2 3 0]"
        )))
    };
    let checks = "\"checkerboard\" \"rgb tex1\" [0.9 0.5 0.1] \"rgb tex2\" [0.1 0.1 0.3] \
                  \"float uscale\" 64 \"float vscale\" 64";
    let found = colour(&format!("Texture \"t\" \"spectrum\" {checks}"));
    for (found, expected) in found.into_iter().zip([0.5, 0.3, 0.2]) {
        assert!((found - expected).abs() < 0.02, "{found} instead of {expected}");
    }
    let found = colour(&format!(
        "Texture \"c\" \"spectrum\" {checks}\nTexture \"t\" \"color\" \"scale\" \
         \"texture tex1\" \"c\" \"color tex2\" [0.5 0.5 0.5]"
    ));
    for (found, expected) in found.into_iter().zip([0.25, 0.15, 0.1]) {
        assert!((found - expected).abs() < 0.01, "{found} instead of {expected}");
    }
}

#[test]
fn includes_are_relative_to_the_scene_and_may_not_form_a_cycle() {
    let folder = folder();
    write(&folder, "shape.pbrt", "Shape \"sphere\"");
    let scene = write(
        &folder,
        "test.pbrt",
        format!("{HEAD}Include \"shape.pbrt\"\nInclude \"shape.pbrt\""),
    );
    assert_eq!(pbrt::read(&scene).unwrap().scene.shapes.len(), 2);
    write(&folder, "shape.pbrt", "Include \"shape.pbrt\"");
    let message = pbrt::read(&scene).map(|_| ()).unwrap_err().to_string();
    assert!(message.contains("files include each other"), "{message}");
    write(&folder, "shape.pbrt", "Shape \"sphere\"\n  Shpe");
    let message = pbrt::read(&scene).map(|_| ()).unwrap_err().to_string();
    assert!(message.contains("shape.pbrt:2:3: unknown directive"), "{message}");
}

/// Returns the lists of a trianglemesh, and the same mesh as a PLY file: a ball of 8 by 16 quads.
fn ball() -> (String, String) {
    let (rows, columns) = (8, 16);
    let (mut points, mut uvs, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..=rows {
        for column in 0..=columns {
            let [v, u] = [row as f64 / rows as f64, column as f64 / columns as f64];
            let (latitude, longitude) = (std::f64::consts::PI * v, std::f64::consts::TAU * u);
            let [x, y] = [longitude.cos(), longitude.sin()].map(|part| part * latitude.sin());
            points.push([x, y, latitude.cos()]);
            uvs.push([u, v]);
            if row < rows && column < columns {
                let corner = row * (columns + 1) + column;
                let below = corner + columns + 1;
                faces.extend([[corner, below, below + 1], [corner, below + 1, corner + 1]]);
            }
        }
    }
    let words =
        |values: &[f64]| -> String { values.iter().map(|value| format!("{value:.6} ")).collect() };
    let indices: String = faces.as_flattened().iter().map(|corner| format!("{corner} ")).collect();
    let list = format!(
        "\"integer indices\" [{indices}] \"point3 P\" [{0}] \"normal N\" [{0}] \"point2 uv\" [{1}]",
        words(points.as_flattened()),
        words(uvs.as_flattened())
    );
    let mut ply = format!("ply\nformat ascii 1.0\nelement vertex {}\n", points.len());
    for name in ["x", "y", "z", "nx", "ny", "nz", "u", "v"] {
        ply += &format!("property float {name}\n");
    }
    ply += &format!("element face {}\nproperty list uchar int vertex_indices\n", faces.len());
    ply += "end_header\n";
    for (point, uv) in points.iter().zip(&uvs) {
        ply += &format!("{}{}{}\n", words(point), words(point), words(uv));
    }
    for [a, b, c] in &faces {
        ply += &format!("3 {a} {b} {c}\n");
    }
    (list, ply)
}

#[test]
fn many_inclusions_of_a_mesh_are_instances_that_look_like_its_copies() {
    let (list, ply) = ball();
    let folder = folder();
    write(&folder, "ball.ply", &ply);
    let materials = [
        "Material \"diffuse\" \"rgb reflectance\" [0.6 0.4 0.2]",
        "Material \"conductor\" \"float roughness\" 0.1",
        "MediumInterface \"fog\" \"\" Material \"interface\"",
        "ReverseOrientation MediumInterface \"\" \"fog\" Material \"dielectric\"",
    ];
    let place = |i: usize| {
        let [x, y] = [(i % 8) as f64 - 3.5, (i / 8 % 6) as f64 - 2.5];
        let flip = if i.is_multiple_of(3) { "-0.3" } else { "0.35" };
        format!("AttributeBegin Translate {x} {y} 9 Rotate {} 1 2 3 Scale {flip} 0.4 0.3", 31 * i)
    };
    let head = "Film \"rgb\" \"integer xresolution\" 64 \"integer yresolution\" 48
        Sampler \"sobol\" \"integer pixelsamples\" 16 Integrator \"volpath\" \"integer maxdepth\" 6
        Camera \"perspective\" \"float fov\" 36 WorldBegin LightSource \"infinite\" \"rgb L\" [1 1 1]
        LightSource \"distant\" \"point3 from\" [1 1 -1] \"rgb L\" [1 1 1]
        MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [2 2 2]
        \"rgb sigma_a\" [0.5 0.5 0.5]\n";
    let shapes = [format!("Shape \"trianglemesh\" {list}"), plymesh("ball.ply")];
    // Walks in media take their random numbers from the bits of rays.
    let cases = [(&materials[..2], 0.002, 0.02), (&materials[2..], 0.02, 1.0)];
    for (shape, (materials, in_mean, largest_part)) in
        shapes.iter().flat_map(|shape| cases.map(|case| (shape, case)))
    {
        let (mut included, mut copied) = (head.to_owned(), head.to_owned());
        for (number, material) in materials.iter().enumerate() {
            write(&folder, &format!("ball{number}.inc"), format!("{material}\n{shape}"));
        }
        for i in 0..48 {
            let (place, number) = (place(i), i / 5 % materials.len());
            included += &format!("{place} Include \"ball{number}.inc\" AttributeEnd\n");
            // Each copy has a source of its own, so that all are read.
            let own = match shape.contains("ball.ply") {
                true => plymesh(&format!("ball{i}.ply")),
                false => shape.clone(),
            };
            write(&folder, &format!("ball{i}.ply"), &ply);
            copied += &format!("{place} {}\n{own} AttributeEnd\n", materials[number]);
        }
        let read = |name: &str, text: String| {
            let description = pbrt::read(&write(&folder, name, text)).expect("a scene");
            let job = petzval_render::prepare::prepare(description, &Default::default())
                .expect("a job")
                .job;
            let picture = crate::support::picture(&job, petzval_render::Backend::Simd, 1);
            (job.scene.shapes.len(), picture)
        };
        let (few, shared) = read("included.pbrt", included);
        let (all, plain) = read("copied.pbrt", copied);
        // Of each material, the first copy, 8 whose text is known, and one object.
        assert_eq!([all, few], [48, 10 * materials.len()], "{shape:.40}");
        let [shared_mean, plain_mean] = [&shared, &plain].map(|picture| mean(picture)[1]);
        let far = shared.pixels.iter().zip(&plain.pixels);
        let far = far.filter(|(a, b)| (a[1] - b[1]).abs() > 0.02).count();
        let off = (shared_mean / plain_mean - 1.0).abs();
        assert!(off < in_mean, "{shared_mean} and {plain_mean}");
        // Rounding of the last bit turns some paths at edges.
        let far = far as f64 / shared.pixels.len() as f64;
        assert!(far <= largest_part, "{far} of the pixels differ");
    }
}

fn plymesh(name: &str) -> String {
    format!("Shape \"plymesh\" \"string filename\" \"{name}\"")
}

#[test]
fn lamps_alpha_and_textures_of_included_meshes_stay_those_of_each_inclusion() {
    let (list, _) = ball();
    let folder = folder();
    write(&folder, "lamp.inc", format!("Shape \"trianglemesh\" {list} \"float alpha\" 0.5"));
    let text = "Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [0.5 0.5 0.5]
        Material \"diffuse\" \"texture reflectance\" \"t\"\n";
    write(&folder, "textured.inc", format!("{text}Shape \"trianglemesh\" {list}"));
    let mut world = HEAD.to_owned();
    for i in 0..20 {
        world += &format!(
            "AttributeBegin Translate {i} 0 0 AreaLightSource \"diffuse\"
             Include \"lamp.inc\" AttributeEnd
             AttributeBegin Translate {i} 3 0 Include \"lamp.inc\" AttributeEnd
             AttributeBegin Translate {i} 6 0 Include \"textured.inc\" AttributeEnd\n"
        );
    }
    let scene = pbrt::read(&write(&folder, "test.pbrt", world)).expect("a scene").scene;
    assert_eq!(scene.lights.all.len(), 20);
    assert_eq!(scene.shapes.len(), 60);
    let with_alpha = scene.shapes.iter().filter(|shape| !shape.is_opaque()).count();
    assert_eq!(with_alpha, 40);
    // The material of a texture is made anew, as the texture may be another.
    assert_eq!(scene.materials.len(), 1 + 20);
}

#[test]
fn nesting_is_limited() {
    let chain = |link: &dyn Fn(u32) -> String| (1..2000).map(link).collect::<String>();
    let objects = chain(&|i| {
        let before = i - 1;
        format!("ObjectBegin \"o{i}\" ObjectInstance \"o{before}\" ObjectEnd\n")
    });
    let message = error(&format!("ObjectBegin \"o0\" Shape \"sphere\" ObjectEnd\n{objects}"));
    assert!(message.contains("33 nested objects"), "{message}");
    // Repeated doubling: 2^26 instances are refused.
    let doubled = chain(&|i| {
        let before = format!("ObjectInstance \"o{}\" ", i - 1);
        format!("ObjectBegin \"o{i}\" {before}{before} ObjectEnd\n")
    });
    let message = error(&format!("ObjectBegin \"o0\" Shape \"sphere\" ObjectEnd\n{doubled}"));
    assert!(message.contains("instances of objects"), "{message}");
    let textures = chain(&|i| {
        let before = i - 1;
        format!(
            "Texture \"t{i}\" \"color\" \"scale\" \"texture tex1\" \"t{before}\" \
             \"texture tex2\" \"t{before}\"\n"
        )
    });
    let message = error(&format!("Texture \"t0\" \"color\" \"constant\"\n{textures}"));
    assert!(message.contains("a texture of more than 1000 parts"), "{message}");
}

#[test]
fn features_that_pbrt_knows_are_never_errors() {
    for world in [
        "Material \"fourier\"",
        "Volume \"homogeneous\"",
        "ObjectBegin \"a\" Shape \"sphere\" ObjectEnd\n\
         ConcatTransform [1 0 0 0 0 0 0 0 0 0 1 0 0 0 0 1] ObjectInstance \"a\"",
        "WorldEnd\nWorldBegin",
    ] {
        let description = read(&format!("{HEAD}{world}")).expect(world);
        assert!(!description.warnings.is_empty(), "{world}: no warning");
    }
}

#[test]
fn a_line_of_a_million_numbers_is_read_quickly() {
    // Without a time limit: counting columns from the start of the line would take minutes.
    let points = "0 0 0  1 0 0  0 1 0 ".repeat(120_000);
    let indices: String = (0..360_000).map(|i| format!("{i} ")).collect();
    let scene = format!(
        "{HEAD}Shape \"trianglemesh\" \"point3 P\" [{points}] \"integer indices\" [{indices}] é Shpe"
    );
    let message = read(&scene).map(|_| ()).unwrap_err().to_string();
    let column = scene.lines().nth(2).unwrap().chars().position(|c| c == 'é').unwrap() + 1;
    assert!(
        message.contains(&format!("test.pbrt:3:{column}: ")),
        "{}",
        &message[..200.min(message.len())]
    );
}

#[test]
fn mutated_scenes_do_not_panic() {
    let good = std::fs::read(crate::support::root().join("scenes/dgauss.pbrt")).unwrap();
    let folder = folder();
    let lens = std::fs::read(crate::support::root().join("scenes/cones.pbrt")).unwrap();
    write(&folder, "cones.pbrt", lens);
    let mut random = crate::support::Random::new(9);
    for _ in 0..3_000 {
        let mut bytes = good.clone();
        for _ in 0..4 {
            let i = (random.next() * bytes.len() as f64) as usize;
            match (random.next() * 3.0) as usize {
                0 => bytes[i] = (random.next() * 256.0) as u8,
                1 => drop(bytes.remove(i)),
                _ => {
                    let j = (random.next() * bytes.len() as f64) as usize;
                    bytes.swap(i, j);
                }
            }
        }
        let path = write(&folder, "test.pbrt", bytes);
        // The result may be an error or a scene.
        let _ = pbrt::read(&path);
    }
}
