//! Scenes that a program assembles: the same as those of scene files, and what is refused.

use crate::support::{folder, write, write_picture};
use petzval_base::io::ReadContext;
use petzval_image::Picture;
use petzval_scene_formats::pbrt::{
    self, Description, KindSpec, MeshSpec, ParameterValue, SceneAssembly, SceneErrors, ViewSpec,
};

fn kind<const N: usize>(kind: &str, parameters: [(&str, ParameterValue); N]) -> KindSpec {
    let parameters = parameters.map(|(name, value)| (name.to_owned(), value)).to_vec();
    KindSpec { kind: kind.to_owned(), parameters }
}

fn wall(material: KindSpec) -> MeshSpec {
    MeshSpec {
        vertices: vec![[-3.0, -3.0, 4.0], [3.0, -3.0, 4.0], [3.0, 3.0, 4.0], [-3.0, 3.0, 4.0]],
        faces: vec![[0, 2, 1], [0, 3, 2]],
        normals: Some(vec![[0.3, 0.0, -0.4]; 4]),
        uv: Some(vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
        material,
        emission: None,
    }
}

fn view() -> ViewSpec {
    ViewSpec {
        lens: "lens.dat".into(),
        look_at: [[0.1, 0.2, -0.5], [0.0, 0.0, 1.0], [0.0, 1.0, 0.1]],
        focus: 2.5,
        resolution: [60, 40],
        diagonal: 30.0,
        spp: 8,
        max_depth: 3,
    }
}

fn sky() -> KindSpec {
    kind("infinite", [("L", ParameterValue::Colour([0.4, 0.45, 0.5]))])
}

fn picture() -> Picture {
    let pixels = (0..12).map(|i| [0.1 * i as f32, 0.9 - 0.05 * i as f32, 0.5]).collect();
    Picture { size: [4, 3], pixels }
}

fn assembled(view: &ViewSpec, meshes: Vec<MeshSpec>) -> Result<Description, SceneErrors> {
    let mut scene = SceneAssembly::new(view, &ReadContext::default())?;
    scene.add_light("light 0", sky());
    for (i, mesh) in meshes.into_iter().enumerate() {
        scene.add_mesh(&format!("mesh {i}"), mesh);
    }
    scene.finish()
}

#[test]
fn an_assembled_scene_is_that_of_the_same_scene_file() {
    let folder = folder();
    write_picture(&picture(), folder.path().join("a.exr"));
    let shape = "Shape \"trianglemesh\" \"point3 P\" [-3 -3 4  3 -3 4  3 3 4  -3 3 4] \
        \"integer indices\" [0 2 1 0 3 2] \"point2 uv\" [0 0 1 0 1 1 0 1] \
        \"normal N\" [.3 0 -.4 .3 0 -.4 .3 0 -.4 .3 0 -.4]";
    let text = format!(
        "Film \"rgb\" \"integer xresolution\" 60 \"integer yresolution\" 40 \"float diagonal\" 30
         Sampler \"zsobol\" \"integer pixelsamples\" 8
         Integrator \"path\" \"integer maxdepth\" 3
         LookAt .1 .2 -.5  0 0 1  0 1 .1
         Camera \"realistic\" \"string lensfile\" \"lens.dat\" \"float focusdistance\" 2.5
         WorldBegin
         LightSource \"infinite\" \"rgb L\" [.4 .45 .5]
         Texture \"a\" \"spectrum\" \"imagemap\" \"string filename\" \"a.exr\"
         Material \"coateddiffuse\" \"texture reflectance\" \"a\" \"float roughness\" .2
         {shape}
         Material \"diffuse\"
         AreaLightSource \"diffuse\" \"rgb L\" [3 2 1]
         {shape}"
    );
    let read = pbrt::read(&write(&folder, "test.pbrt", text)).expect("a scene");
    let coated = [
        ("reflectance", ParameterValue::Picture(picture())),
        ("roughness", ParameterValue::Number(0.2)),
    ];
    let lamp = MeshSpec { emission: Some([3.0, 2.0, 1.0]), ..wall(kind("diffuse", [])) };
    let made = assembled(&view(), vec![wall(kind("coateddiffuse", coated)), lamp]);
    let mut made = made.expect("a scene");
    // Meshes of a program have names, triangles of a scene file have none.
    assert_eq!(
        [0, 1].map(|shape| made.scene.names.shape(shape).into_owned()),
        ["mesh 0", "mesh 1"]
    );
    made.scene.names = read.scene.names.clone();
    assert_eq!(format!("{:?}", made.scene), format!("{:?}", read.scene));
    assert_eq!(made.world_from_camera, read.world_from_camera);
    assert_eq!((made.film, made.samples), (read.film, read.samples));
    assert_eq!(format!("{:?}", made.path_limits), format!("{:?}", read.path_limits));
    assert!(made.warnings.is_empty(), "{:?}", made.warnings);
}

#[test]
fn all_errors_name_their_parts() {
    let material = |given| wall(kind("diffuse", [("reflectance", given)]));
    let good = || wall(kind("diffuse", []));
    let nan = Picture { size: [1, 1], pixels: vec![[f32::NAN; 3]] };
    let short = Picture { size: [2, 1], pixels: vec![[0.5; 3]] };
    let meshes = vec![
        MeshSpec { faces: vec![[0, 1, 4]], ..good() },
        MeshSpec { faces: Vec::new(), ..good() },
        MeshSpec { uv: Some(vec![[0.0; 2]]), ..good() },
        MeshSpec { vertices: vec![[f32::NAN; 3]; 4], ..good() },
        MeshSpec { emission: Some([-1.0; 3]), ..good() },
        wall(kind("marble", [])),
        material(ParameterValue::Flag(true)),
        material(ParameterValue::Picture(nan)),
        material(ParameterValue::Picture(short)),
        good(),
    ];
    let view = ViewSpec { focus: -1.0, ..view() };
    let errors = assembled(&view, meshes).map(drop).expect_err("faults").to_string();
    let lines: Vec<&str> = errors.lines().collect();
    let expected = [
        "mesh 0: faces name vertices beyond the 4 there are",
        "mesh 1: the mesh has no vertices or no faces",
        "mesh 2: 1 uv for 4 vertices",
        "mesh 3: vertices are not all finite",
        "mesh 4: a colour below 0",
        "the material of mesh 5: unknown Material \"marble\"",
        "the material of mesh 6: \"bool reflectance\"",
        "the material of mesh 7: the pixel 0, 0 of \"reflectance\" is not finite",
        "the material of mesh 8: 1 pixels of \"reflectance\"; expected 2 x 1",
        "focus: \"focusdistance\" is -1; expected more than 0",
    ];
    assert_eq!(lines.len(), expected.len(), "{errors}");
    for (line, expected) in lines.iter().zip(expected) {
        assert!(line.starts_with(expected), "{line}\nin place of\n{expected}");
    }
}

#[test]
fn equal_arrays_alone_are_equal_inputs() {
    let digest = |view: &ViewSpec, mesh: MeshSpec| {
        let files = assembled(view, vec![mesh]).expect("a scene").files;
        let inputs: Vec<_> = files.iter().map(|(_, digest)| digest.map(str::to_owned)).collect();
        assert!(inputs.len() == 1 && inputs[0].is_some(), "{inputs:?}");
        inputs
    };
    let textured =
        |picture| wall(kind("diffuse", [("reflectance", ParameterValue::Picture(picture))]));
    let first = digest(&view(), textured(picture()));
    assert_eq!(
        digest(&ViewSpec { lens: "other.dat".into(), ..view() }, textured(picture())),
        first
    );
    let mut pixel = picture();
    pixel.pixels[7][1] += 1e-6;
    let others = [
        digest(&ViewSpec { focus: 2.6, ..view() }, textured(picture())),
        digest(&view(), textured(pixel)),
        digest(&view(), MeshSpec { faces: vec![[0, 2, 1], [0, 2, 3]], ..textured(picture()) }),
        digest(&view(), MeshSpec { normals: None, ..textured(picture()) }),
    ];
    assert!(others.iter().all(|other| *other != first), "{others:?}");
}
