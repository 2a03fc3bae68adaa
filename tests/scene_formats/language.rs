//! Directives of pbrt-v4: shapes, attributes, files and settings, with the defaults of its manual.

use std::io::Write;

use crate::support::world::{
    colour, error, read, read_world, read_world_with_warnings, roughness_and_remap,
};
use crate::support::{folder, write};
use flate2::Compression;
use flate2::write::GzEncoder;
use petzval_scene::filter::Profile;
use petzval_scene::{Geometry, MaterialModel, Shape};
use petzval_scene_formats::pbrt;
use petzval_scene_formats::pbrt::FilterSpec;

/// Reads the shapes of a world.
fn shapes(world: &str) -> Vec<Shape> {
    read_world(world).scene.shapes.to_vec()
}

#[test]
fn alpha_of_1_is_dropped() {
    let alpha = |given: &str| {
        let texture = "Texture \"t\" \"float\" \"constant\" \"float value\" 0.5";
        let shapes = shapes(&format!("{texture} Shape \"sphere\" {given}"));
        assert_eq!(shapes[0].is_opaque(), shapes[0].alpha.is_none());
        shapes[0].alpha.as_ref().map(|alpha| colour(alpha)[0])
    };
    assert_eq!(alpha(""), None);
    assert_eq!(alpha("\"float alpha\" 1"), None);
    assert_eq!(alpha("\"float alpha\" 0"), Some(0.0));
    assert_eq!(alpha("\"float alpha\" 0.75"), Some(0.75));
    assert_eq!(alpha("\"texture alpha\" \"t\""), Some(0.5));
}

/// Returns the number of triangles in the meshes of a world.
fn triangles(world: &str) -> usize {
    let count = |shape: &Shape| match &shape.geometry {
        Geometry::Mesh(mesh) => mesh.triangles.len(),
        Geometry::Patches(_) | Geometry::Curves(_) | Geometry::Quadric(_) => panic!("not a mesh"),
    };
    shapes(world).iter().map(count).sum()
}

const CORNERS: &str = "\"point3 P\" [1 1 1  1 -1 -1  -1 1 -1  -1 -1 1] \
                       \"integer indices\" [0 1 2  0 3 1  0 2 3  1 3 2]";

#[test]
fn meshes_of_every_kind_are_read() {
    assert_eq!(triangles(&format!("Shape \"loopsubdiv\" {CORNERS}")), 4 << 6);
    assert_eq!(triangles(&format!("Shape \"loopsubdiv\" {CORNERS} \"integer levels\" 0")), 4);
    let flat = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]";
    assert_eq!(triangles(flat), 2);
    let Geometry::Mesh(mesh) = &shapes(flat)[0].geometry else { panic!() };
    assert_eq!(mesh.uvs, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]);
    let twisted = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]";
    assert!(matches!(shapes(twisted)[0].geometry, Geometry::Patches(_)));
    let two = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0 0 2 0 1 2 0] \
               \"integer indices\" [0 1 2 3  2 3 4 5]";
    assert_eq!(triangles(two), 4);
    for name in ["cylinder", "disk", "sphere", "cone"] {
        let shape = &shapes(&format!("Shape \"{name}\" \"float phimax\" 90"))[0];
        assert!(matches!(shape.geometry, Geometry::Quadric(_)), "{name}");
    }
}

#[test]
fn curves_of_both_bases_and_degrees_are_read() {
    let ends = |given: &str| {
        let description =
            read_world_with_warnings(&format!("Shape \"curve\" \"float width\" 0.001 {given}"));
        assert!(description.warnings.is_empty(), "{:#?}", description.warnings);
        description.scene.bounds().unwrap().map(|p| (p.x * 100.0).round() / 100.0)
    };
    let line = "\"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0]";
    assert_eq!(ends(line), [0.0, 3.0]);
    assert_eq!(ends(&format!("{line} \"string basis\" \"bspline\"")), [1.0, 2.0]);
    let degree = "\"integer degree\" 2 \"string basis\" \"bspline\"";
    assert_eq!(ends(&format!("{line} {degree}")), [0.5, 2.5]);
    let line = "\"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0 4 0 0]";
    assert_eq!(ends(&format!("{line} \"integer degree\" 2")), [0.0, 4.0]);
    let ribbon = "\"string type\" \"ribbon\" \"normal N\" [0 0 1 0 0 1 0 1 1]";
    assert_eq!(ends(&format!("{line} \"integer degree\" 2 {ribbon}")), [0.0, 4.0]);
    for (given, expected) in [
        (line, "test.pbrt:3:15: 5 points of a curve; expected 4, and 3 more for each segment"),
        ("\"integer degree\" 4 \"point3 P\" [0 0 0]", "test.pbrt:3:15: a curve of degree 4"),
        ("", "test.pbrt:3:1: a curve without \"point3 P\""),
    ] {
        let message = error(&format!("Shape \"curve\" {given}"));
        assert!(message.starts_with(expected), "{message}");
    }
}

/// Returns the number of segments of each shape of curves in a world.
fn segments(world: &str) -> Vec<usize> {
    let count = |shape: &Shape| match &shape.geometry {
        Geometry::Curves(curves) => curves.segments().len(),
        Geometry::Mesh(_) | Geometry::Patches(_) | Geometry::Quadric(_) => 0,
    };
    shapes(world).iter().map(count).collect()
}

#[test]
fn consecutive_curves_of_one_material_are_one_shape() {
    let curve = "Shape \"curve\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0]\n";
    assert_eq!(segments(&curve.repeat(3)), [3]);
    let cylinder = curve.replace("\"curve\"", "\"curve\" \"string type\" \"cylinder\"");
    assert_eq!(segments(&format!("{curve}{cylinder}{cylinder}")), [1, 2]);
    let moved = format!("{curve}Translate 1 0 0\nRotate 30 1 2 3\nScale 2 2 2\n{curve}");
    assert_eq!(segments(&moved), [2]);
    // The kind, the material, the object, the side, an alpha and a light keep curves apart.
    for between in ["Material \"diffuse\"", "ReverseOrientation", "ObjectBegin \"a\""] {
        let end = if between.contains("Object") { "ObjectEnd" } else { "" };
        assert_eq!(segments(&format!("{curve}{between}\n{curve}{end}")), [1, 1], "{between}");
    }
    let thin = curve.replace("\"curve\"", "\"curve\" \"float alpha\" 0.5");
    assert_eq!(segments(&format!("{curve}{thin}{thin}{curve}")), [2, 1, 1]);
    assert_eq!(segments(&format!("{curve}AreaLightSource \"diffuse\"\n{curve}")), [1, 0]);
}

#[test]
fn curves_that_a_transform_stretches_are_in_an_object() {
    let curve = "Shape \"curve\" \"float width\" 0.2 \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0]\n";
    for (transform, height) in [("Scale 1 1 3", 0.3), ("Scale 1 1 -1", 0.1), ("Scale 3 3 3", 0.3)] {
        let scene = read_world(&format!("{transform}\n{curve}")).scene;
        let [low, high] = scene.bounds().unwrap();
        assert!((high.z - height).abs() < 1e-5 && (low.z + height).abs() < 1e-5, "{transform}");
    }
    let infinite = curve.replace("0.2", "1e300");
    let message = read_world_with_warnings(&infinite).warnings[0].to_string();
    assert!(message.contains("1 of the 1 segments of a curve"), "{message}");
}

#[test]
fn errors_in_shapes_name_their_position() {
    for (world, expected) in [
        ("Shape \"cylinder\" \"float zmin\" 1", "test.pbrt:3:18: a cylinder of height 0"),
        ("Shape \"bilinearmesh\"", "test.pbrt:3:1: a mesh without \"point3 P\""),
        (
            "Shape \"bilinearmesh\" \"point3 P\" [0 0 0] \"integer indices\" [0 0 0]",
            "test.pbrt:3:41: 3 indices; expected 4 for each face",
        ),
        (
            "Shape \"loopsubdiv\" \"integer levels\" 30 \"point3 P\" [0 0 0 1 0 0 0 1 0]",
            "test.pbrt:3:20: 1 triangles refined 30 times",
        ),
        (
            "Shape \"loopsubdiv\" \"float levels\" -1 \"point3 P\" [0 0 0 1 0 0 0 1 0]",
            "test.pbrt:3:20: 1 triangles refined -1 times",
        ),
    ] {
        let message = error(world);
        assert!(
            message.starts_with(expected),
            "{world}\n  found    {message}\n  expected {expected}"
        );
    }
    let bowtie = "Shape \"loopsubdiv\" \"point3 P\" [0 0 0 1 0 0 0 1 0 -1 0 0 0 -1 0] \
                  \"integer indices\" [0 1 2  0 3 4]";
    let message = read_world_with_warnings(bowtie).warnings[0].to_string();
    assert!(message.contains("a loopsubdiv where vertex 0 joins triangles"), "{message}");
}

#[test]
fn attributes_are_defaults_until_the_end_of_their_block() {
    let scene = read_world(
        "AttributeBegin\n\
         Attribute \"shape\" \"float alpha\" 0.5 \"float radius\" 3\n\
         Attribute \"shape\" \"float alpha\" 0.25\n\
         Attribute \"material\" \"float roughness\" 0.7\n\
         Material \"dielectric\" Shape \"sphere\" Shape \"sphere\" \"float alpha\" 0.1\n\
         Material \"diffuse\"\n\
         AttributeEnd\n\
         Shape \"sphere\"",
    )
    .scene;
    let alphas: Vec<_> =
        scene.shapes.iter().map(|s| s.alpha.as_ref().map(|alpha| colour(alpha)[0])).collect();
    assert_eq!(alphas, [Some(0.25), Some(0.1), None]);
    let MaterialModel::Dielectric { roughness, .. } =
        &scene.materials[scene.shapes[0].material as usize].model
    else {
        panic!()
    };
    assert_eq!(roughness_and_remap(roughness).0, [0.7; 2]);
    let Geometry::Quadric(ball) = &scene.shapes[0].geometry else { panic!() };
    assert!((ball.area() / (36.0 * std::f64::consts::PI) - 1.0).abs() < 1e-6);
    let message = error("Attribute \"shap\" \"float alpha\" 1");
    assert!(
        message.starts_with("test.pbrt:3:1: attributes of \"shap\"; did you mean"),
        "{message}"
    );
}

#[test]
fn unknown_options_are_refused() {
    let quiet = "Option \"string rendercoordsys\" \"world\" Option \"integer seed\" 7\n";
    let scene = "Camera \"perspective\" WorldBegin";
    let description = read(&format!("{quiet}{scene}")).unwrap();
    assert_eq!((description.seed, description.warnings.len()), (7, 0));
    let sampler = "Sampler \"independent\" \"integer seed\" 3\n";
    assert_eq!(read(&format!("{sampler}{quiet}{scene}")).unwrap().seed, 3);
    let message =
        read(&format!("Option \"bool disablepixeljitter\" true {scene}")).unwrap().warnings;
    assert_eq!(message.len(), 1);
    let message = read(&format!("Option \"integer sead\" 1 {scene}")).map(|_| ()).unwrap_err();
    assert!(
        message.to_string().contains("unknown option \"sead\"; did you mean \"seed\"?"),
        "{message}"
    );
}

#[test]
fn filters_have_the_defaults_of_pbrt() {
    let filter = |text: &str| {
        let description = read(&format!("{text} Camera \"perspective\" WorldBegin")).unwrap();
        assert!(description.warnings.is_empty(), "{:#?}", description.warnings);
        description.filter
    };
    let gaussian = FilterSpec { profile: Profile::Gaussian { sigma: 0.5 }, radius: [1.5; 2] };
    assert_eq!(filter(""), gaussian);
    assert_eq!(filter("PixelFilter \"gaussian\""), gaussian);
    assert_eq!(
        filter("PixelFilter \"box\""),
        FilterSpec { profile: Profile::Box, radius: [0.5; 2] }
    );
    assert_eq!(
        filter("PixelFilter \"triangle\""),
        FilterSpec { profile: Profile::Triangle, radius: [2.0; 2] }
    );
    let mitchell =
        FilterSpec { profile: Profile::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 }, radius: [2.0; 2] };
    assert_eq!(filter("PixelFilter \"mitchell\""), mitchell);
    assert_eq!(
        filter("PixelFilter \"sinc\" \"float xradius\" 3"),
        FilterSpec { profile: Profile::Sinc { tau: 3.0 }, radius: [3.0, 4.0] }
    );
    let old = "PixelFilter \"gaussian\" \"float xwidth\" 2 \"float ywidth\" 1 \"float alpha\" 8";
    assert_eq!(
        filter(old),
        FilterSpec { profile: Profile::Gaussian { sigma: 0.25 }, radius: [2.0, 1.0] }
    );
    let v2 = read("SurfaceIntegrator \"path\" Camera \"perspective\" WorldBegin").unwrap();
    assert_eq!(v2.filter, FilterSpec { profile: Profile::Box, radius: [0.5; 2] });
    let message = read("PixelFilter \"box\" \"float xradius\" 0 Camera \"perspective\" WorldBegin");
    assert!(message.is_err());
}

#[test]
fn integrators_and_films_are_read_by_name() {
    let of = |text: &str| read(&format!("{text} Camera \"perspective\" WorldBegin")).unwrap();
    for name in ["path", "volpath", "simplepath", "randomwalk", "simplevolpath"] {
        let default = of(&format!("Integrator \"{name}\""));
        let given = of(&format!("Integrator \"{name}\" \"integer maxdepth\" 9"));
        assert_eq!((default.path_limits.max_depth, given.path_limits.max_depth), (5, 9), "{name}");
        assert!(default.warnings.is_empty(), "{name}: {:#?}", default.warnings);
    }
    let bidirectional = of("Integrator \"bdpt\" \"integer maxdepth\" 7");
    assert_eq!((bidirectional.path_limits.max_depth, bidirectional.warnings.len()), (7, 1));
    let regular = of("Integrator \"path\" \"bool regularize\" true");
    assert!(regular.path_limits.regularize && regular.warnings.is_empty());
    assert!(!of("Integrator \"path\"").path_limits.regularize);
    assert!(of("Film \"gbuffer\" \"integer xresolution\" 9").film.gbuffer);
    assert!(!of("Film \"rgb\"").film.gbuffer);
    let spectral = of("Film \"spectral\" \"integer nbuckets\" 8 \"float lambdamin\" 400");
    let buckets = spectral.film.buckets.expect("buckets");
    assert_eq!((buckets.count(), buckets.range()), (8, [400.0, 830.0]));
    assert!(spectral.warnings.is_empty() && of("Film \"rgb\"").film.buckets.is_none());
}

#[test]
fn a_transform_that_differs_at_the_end_time_moves_the_shape() {
    let scene = "TransformTimes 0 1 ActiveTransform EndTime Translate 5 0 0 ActiveTransform All\n";
    let moving = read_world(&format!("{scene}Shape \"sphere\" Shape \"disk\""));
    // Shapes of equal motion form one instance.
    assert_eq!(moving.scene.animated_instances().len(), 1);
    let near = |found: [glam::Vec3; 2], low: f32, high: f32| {
        assert!((found[0].x - low).abs() < 1e-5 && (found[1].x - high).abs() < 1e-5, "{found:?}");
    };
    near(moving.scene.bounds().unwrap(), -1.0, 6.0);
    let mut still = moving.scene.clone();
    still.freeze(0.5);
    near(still.bounds().unwrap(), 1.5, 3.5);
    let start = "ActiveTransform StartTime Translate 5 0 0 ActiveTransform All Shape \"sphere\"";
    near(read_world(start).scene.bounds().unwrap(), -1.0, 6.0);
    // A motion that is undone is none, and the end of a block restores the active transforms.
    let still = read_world(&format!(
        "AttributeBegin {scene} AttributeEnd Shape \"sphere\"\n\
         AttributeBegin ActiveTransform EndTime AttributeEnd Translate 1 0 0 Shape \"sphere\"\n\
         ActiveTransform EndTime Translate 1 0 0 Translate -1 0 0 Shape \"sphere\""
    ));
    assert!(still.scene.animated_instances().is_empty());
}

#[test]
fn shapes_move_within_objects_and_objects_move() {
    let end = "ActiveTransform EndTime";
    let wheel = format!(
        "ObjectBegin \"wheel\" Shape \"sphere\" AttributeBegin {end} Translate 2 0 0 \
         ActiveTransform All Shape \"sphere\" Shape \"disk\" AttributeEnd ObjectEnd"
    );
    let one = read_world(&format!("{wheel} Translate 0 1 0 ObjectInstance \"wheel\""));
    assert_eq!(one.scene.animated_instances().len(), 1);
    let place = |description: &petzval_scene_formats::pbrt::Description, mover: usize, share| {
        description.scene.animated_instances()[mover].motion.at(share).translation.to_array()
    };
    assert_eq!(place(&one, 0, 0.5), [1.0, 1.0, 0.0]);
    let both = read_world(&format!("{wheel} {end} Translate 0 0 4 ObjectInstance \"wheel\""));
    assert_eq!(both.scene.animated_instances().len(), 2);
    assert_eq!([0, 1].map(|i| place(&both, i, 0.5)), [[0.0, 0.0, 2.0], [1.0, 0.0, 2.0]]);
    let nested = read_world(&format!(
        "{wheel} ObjectBegin \"car\" Translate 0 1 0 ObjectInstance \"wheel\" ObjectEnd\n\
         ObjectInstance \"car\" Translate 5 0 0 ObjectInstance \"car\""
    ));
    assert_eq!([0, 1].map(|i| place(&nested, i, 1.0)), [[2.0, 1.0, 0.0], [7.0, 1.0, 0.0]]);
}

#[test]
fn lights_do_not_move_and_a_warning_names_them() {
    let end = "ActiveTransform EndTime Translate 5 0 0 ActiveTransform All";
    let lights = read_world_with_warnings(&format!(
        "{end}\nLightSource \"point\"\nAreaLightSource \"diffuse\" Shape \"sphere\""
    ));
    let message: Vec<String> = lights.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(message.len(), 2, "{message:#?}");
    for (message, what) in message.iter().zip([
        "test.pbrt:4:1: a point light that moves is not supported yet: it stays at its start",
        "test.pbrt:5:27: a sphere with an area light that moves is not supported yet: it stays",
    ]) {
        assert!(message.contains(what), "{message}");
    }
    assert!(
        lights.scene.animated_instances().is_empty() && lights.scene.bounds().unwrap()[1].x < 1.1
    );
    let flat = read_world_with_warnings(
        "ActiveTransform EndTime ConcatTransform [1 0 0 0  0 0 0 0  0 0 1 0  0 0 0 1]\n\
         ActiveTransform All Shape \"sphere\"",
    );
    assert!(flat.warnings[0].message.contains("left out") && flat.scene.bounds().is_none());
}

#[test]
fn a_camera_has_a_shutter_and_may_move() {
    let of = |before: &str, camera: &str| {
        read(&format!("{before} Camera \"perspective\" {camera}\nWorldBegin"))
    };
    let shutter = of(
        "TransformTimes 1 3 ActiveTransform EndTime Translate 0 0 -2 ActiveTransform All",
        "\"float shutteropen\" 1 \"float shutterclose\" 1.5 \"float shutterramp\" [.125 .25] \
         \"float rollingshutter\" .02 \"string rollingdirection\" \"left\"",
    )
    .unwrap();
    assert_eq!([shutter.shutter.open, shutter.shutter.close], [1.0, 1.5]);
    assert_eq!(shutter.shutter.curve().unwrap().efficiency(), 0.625);
    assert_eq!(shutter.shutter.rolling.unwrap().to_string(), "20ms,left");
    assert_eq!(shutter.transform_times, [1.0, 3.0]);
    assert_eq!(shutter.camera_motion.at(0.5).translation.z, 1.0);
    let curve = of("", "\"float shuttercurve\" [0 1 1 0]").unwrap();
    assert!((curve.shutter.curve().unwrap().efficiency() - 2.0 / 3.0).abs() < 1e-12);
    let plain = of("", "").unwrap();
    assert_eq!(plain.shutter, petzval_scene::shutter::Shutter::default());
    for (before, camera, expected) in [
        ("TransformTimes 2 1", "", "expected the end after the start"),
        ("", "\"float shutterramp\" .6", "opens in 0.6 s and closes in 0.6 s"),
        ("", "\"float shutterramp\" -1", "expected 0 s or more"),
        ("", "\"float shutterramp\" [1 2 3]", "one time, or two: for opening and for closing"),
        ("", "\"float shuttercurve\" [0 2]", "expected 0 to 1"),
        ("", "\"float shuttercurve\" 1", "two fractions or more"),
        ("", "\"float shutterclose\" -1", "expected shutterclose after shutteropen"),
        ("", "\"string rollingdirection\" \"away\"", "expected down, up, left or right"),
        ("", "\"float rollingshutter\" -1", "expected 0 s or more"),
        ("ActiveTransform Middle", "", "expected StartTime, EndTime or All"),
    ] {
        let message = of(before, camera).map(|_| ()).expect_err(camera).to_string();
        assert!(message.contains(expected) && message.contains("test.pbrt:1:"), "{message}");
    }
}

#[test]
fn an_import_keeps_its_state_and_an_include_shares_it() {
    let folder = folder();
    let part = "Translate 5 0 0 Material \"dielectric\" Shape \"sphere\" \"float radius\" 1";
    write(&folder, "part.pbrt", part);
    let bounds = |directive: &str| {
        let text =
            format!("Camera \"perspective\" WorldBegin {directive} \"part.pbrt\" Shape \"disk\"");
        let scene = pbrt::read(&write(&folder, "test.pbrt", text)).unwrap().scene;
        assert_eq!(scene.shapes.len(), 2);
        let same = scene.shapes[0].material == scene.shapes[1].material;
        (scene.bounds().unwrap()[0].x.round(), same)
    };
    assert_eq!(bounds("Import"), (-1.0, false));
    assert_eq!(bounds("Include"), (4.0, true));
    for (part, expected) in [
        ("AttributeBegin", "part.pbrt:1:1: AttributeBegin without AttributeEnd"),
        ("\nAttributeEnd", "part.pbrt:2:1: AttributeEnd without AttributeBegin in its file"),
        ("Translate 1 2", "found the end of the file"),
        ("Import \"part.pbrt\"", "files include each other"),
    ] {
        write(&folder, "part.pbrt", part);
        let text =
            "Camera \"perspective\" WorldBegin AttributeBegin Import \"part.pbrt\" AttributeEnd";
        let message =
            pbrt::read(&write(&folder, "test.pbrt", text)).map(|_| ()).unwrap_err().to_string();
        assert!(message.contains(expected), "{part}: {message}");
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn gzip_files_are_unpacked() {
    let folder = folder();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0 1 0 0 0 1 0\n3 0 1 2\n";
    write(&folder, "mesh.ply.gz", gzip(ply.as_bytes()));
    write(&folder, "part.pbrt.gz", gzip(b"Shape \"plymesh\" \"string filename\" \"mesh.ply.gz\""));
    let text = "Camera \"perspective\" WorldBegin Include \"part.pbrt.gz\"";
    let scene = pbrt::read(&write(&folder, "test.pbrt.gz", gzip(text.as_bytes()))).unwrap().scene;
    assert_eq!(scene.shapes.len(), 1);
    // A truncated file, and one that unpacks to more than the limit.
    let whole = gzip(text.as_bytes());
    assert!(pbrt::read(&write(&folder, "cut.pbrt.gz", &whole[..whole.len() - 9])).is_err());
    let bomb = gzip(&vec![b' '; 40 << 20]);
    let message = pbrt::read(&write(&folder, "bomb.pbrt.gz", bomb)).map(|_| ()).unwrap_err();
    assert!(message.to_string().contains("it does not end"), "{message}");
}

#[test]
fn mutations_of_a_rich_scene_do_not_panic() {
    let good = format!(
        "Option \"integer seed\" 3 PixelFilter \"mitchell\" \"float B\" 0.2\n\
         Integrator \"volpath\" \"integer maxdepth\" 3 Film \"gbuffer\" \"integer xresolution\" 8\n\
         Camera \"perspective\" \"float fov\" 40 WorldBegin\n\
         Attribute \"shape\" \"float alpha\" 0.5 ActiveTransform EndTime Scale 1 2 3\n\
         ActiveTransform All CoordinateSystem \"a\" Rotate 30 1 0 0\n\
         MakeNamedMaterial \"a\" \"string type\" \"conductor\" \"spectrum eta\" \"metal-Ag-eta\"\n\
         MakeNamedMaterial \"b\" \"string type\" \"coateddiffuse\" \"float roughness\" 0.3\n\
         Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" 0.25\n\
         Shape \"loopsubdiv\" {CORNERS} \"integer levels\" 2\n\
         Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1] \"integer indices\" [0 1 2 3]\n\
         Shape \"cylinder\" \"float zmin\" -0.5 \"float phimax\" 200 ReverseOrientation\n\
         ObjectBegin \"o\" Shape \"disk\" \"float innerradius\" 0.5 ObjectEnd ObjectInstance \"o\"\n"
    );
    let folder = folder();
    pbrt::read(&write(&folder, "test.pbrt", &good)).unwrap();
    let mut random = crate::support::Random::new(4);
    for _ in 0..1_000 {
        let mut bytes = good.clone().into_bytes();
        for _ in 0..3 {
            let i = (random.next() * bytes.len() as f64) as usize;
            let j = (random.next() * bytes.len() as f64) as usize;
            match (random.next() * 4.0) as usize {
                0 => bytes[i] = (random.next() * 256.0) as u8,
                1 => drop(bytes.remove(i)),
                2 => bytes[i] = b"0123456789-.e\"[] "[(random.next() * 17.0) as usize],
                _ => bytes.swap(i, j),
            }
        }
        // The result may be an error or a scene.
        let _ = pbrt::read(&write(&folder, "test.pbrt", bytes));
    }
}
