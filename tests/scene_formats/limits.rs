//! Scenes of excessive size: each is refused quickly, or is read with bounded cost.

use std::fmt::Write;

use crate::support::world::{error, read, read_world};
use crate::support::{Random, folder, petzval, promptly, root, write};
use glam::{DVec3, Vec3};
use petzval_base::rays::{Hit, Ray};
use petzval_scene::{
    Geometry, Material, Mesh, SceneBuilder, ShapeSpec, TraversalStack, split_patches,
};
use wide::f32x8;

#[test]
fn a_camera_too_far_from_the_origin_is_refused() {
    let camera = |scale: &str| {
        let place = format!("LookAt 3 4 -5  0 0 0  0 1 0 Scale {scale} {scale} {scale}");
        read(&format!("{place}\nCamera \"perspective\"\nWorldBegin\nShape \"sphere\"")).map(|_| ())
    };
    assert!(camera("1e-12").is_ok());
    let message = camera("1e-30").expect_err("it is too far out").to_string();
    assert!(message.contains("test.pbrt:2:1: a camera at a distance of 5"), "{message}");
    assert!(message.contains("expected at most 1e18"), "{message}");
}

#[test]
fn rays_from_too_far_away_hit_nothing() {
    let scene = read_world("Shape \"sphere\" Shape \"disk\" Translate 2 2 2 Shape \"cone\"").scene;
    let mut stack = TraversalStack::default();
    for far in [1e19, 1e30, 3e38] {
        for origin in [[far, far, -far], [far, 0.0, 0.0], [0.0, far, 1.0]] {
            for direction in [[-0.6, -0.8, 0.0], [0.0, 1e-8, 1.0], [-1e-20, -1.0, 0.3]] {
                let ray = Ray { origin, direction, t_max: f32::INFINITY };
                let hit = scene.closest::<f32x8>(&ray, &mut stack);
                assert_eq!(hit.shape, Hit::MISS.shape, "{ray:?}");
                assert!(!scene.occluded::<f32x8>(&ray, &mut stack), "{ray:?}");
            }
        }
    }
    let ray = Ray { origin: [0.0, 0.0, -1e6], direction: [0.0, 0.0, 1.0], t_max: f32::INFINITY };
    assert!(scene.occluded::<f32x8>(&ray, &mut stack), "a ray from closer misses");
}

/// Returns points of a zigzag curve.
fn zigzag(points: usize) -> String {
    (0..points).fold(String::new(), |mut text, i| {
        let _ = write!(text, "{} {} {} ", i, i % 7, i * 5 % 11);
        text
    })
}

#[test]
fn shapes_that_exceed_the_memory_are_refused_quickly() {
    let triangle = "Shape \"loopsubdiv\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \
                    \"integer indices\" [0 1 2] \"integer levels\"";
    let copies = |count: usize| "ObjectInstance \"a\" Translate 1 0 0\n".repeat(count);
    let thousands = format!(
        "ObjectBegin \"b\" Shape \"sphere\" ObjectEnd\nObjectBegin \"a\"\n{}ObjectEnd\n{}",
        copies(1000).replace("\"a\"", "\"b\""),
        copies(3000)
    );
    let blocks = "AttributeBegin\n".repeat(1_000_000);
    let curve = format!(
        "AreaLightSource \"diffuse\" Shape \"curve\" \"float width\" 0.01 \"point3 P\" [{}]",
        zigzag(90_001)
    );
    let sheet = root().join("tests/pbrt_language/sheet.ply");
    let displaced = format!(
        "Texture \"h\" \"float\" \"bilerp\"\nShape \"plymesh\" \"string filename\" \"{}\" \
         \"texture displacement\" \"h\" \"float edgelength\" 1e-30",
        sheet.display()
    );
    for (name, world, refused) in [
        ("displaced", displaced, "4:1: a displaced mesh of"),
        ("curve", curve, "3:27: a curve of 30000 segments: it takes 2.4"),
        ("level", format!("{triangle} 11"), "3:1: 4194304 triangles: it takes 1."),
        ("levels", format!("{triangle} 8\n").repeat(20), "a loopsubdiv: it takes"),
        ("copies", thousands, "an instance of an object: it takes"),
        ("blocks", blocks, "nested blocks: it takes"),
    ] {
        let folder = folder();
        write(&folder, "a.pbrt", format!("Camera \"perspective\"\nWorldBegin\n{world}"));
        let arguments = ["render", "a.pbrt", "-o", "a.exr", "--spp", "1", "--memory", "400MB"];
        let (code, _, stderr) = promptly(name, || petzval(folder.path(), &arguments));
        assert_eq!(code, 2, "{name}: {stderr}");
        assert!(stderr.contains("a.pbrt:") && stderr.contains(refused), "{name}: {stderr}");
        assert!(stderr.contains("and there are 400 MB") && stderr.contains("--memory"), "{stderr}");
    }
}

#[test]
fn files_that_include_each_other_are_refused_quickly() {
    let folder = folder();
    for i in 0..12 {
        write(&folder, &format!("{i}.pbrt"), format!("Include \"{}.pbrt\"\n", i + 1).repeat(10));
    }
    write(&folder, "12.pbrt", "");
    let path = write(&folder, "a.pbrt", "WorldBegin\nInclude \"0.pbrt\"");
    let message = promptly("a million million files", || petzval_scene_formats::pbrt::read(&path));
    let message = message.map(|_| ()).expect_err("too many").to_string();
    assert!(
        message.contains("included files of") && message.contains("include each other"),
        "{message}"
    );
}

#[test]
fn a_small_file_may_be_included_often() {
    let folder = folder();
    write(&folder, "tiny.pbrt", "# nothing\n");
    let many = "Include \"tiny.pbrt\"\n".repeat(100_000);
    let path = write(&folder, "a.pbrt", format!("WorldBegin\n{many}Shape \"sphere\""));
    let scene = promptly("100,000 inclusions", || petzval_scene_formats::pbrt::read(&path));
    assert_eq!(scene.expect("a scene").scene.shapes.len(), 1);
}

#[test]
fn mixes_nest_up_to_64_levels() {
    let diffuse = "MakeNamedMaterial \"m0\" \"string type\" \"diffuse\"\n";
    let mixes = |count: u32| {
        (1..=count).fold(diffuse.to_owned(), |mut text, i| {
            let below = i - 1;
            let _ = write!(text, "MakeNamedMaterial \"m{i}\" \"string type\" \"mix\" ");
            let _ = writeln!(text, "\"string materials\" [\"m{below}\" \"m{below}\"]");
            text
        })
    };
    read_world(&mixes(64));
    let message = error(&mixes(2000));
    assert!(message.starts_with("test.pbrt:68:45: a mix of 65 nested mixes"), "{message}");
    let last = "Material \"mix\" \"string materials\" [\"m64\" \"m0\"]";
    let message = error(&format!("{}{last}", mixes(64)));
    assert!(message.contains("a mix of 65 nested mixes"), "{message}");
}

#[test]
fn a_polygon_of_sixty_thousand_corners_is_read_quickly() {
    let corners = 60_000;
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {corners}\nproperty float x\nproperty float y\n\
         property float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n"
    );
    for i in 0..corners {
        let (y, x) = (f64::from(i) * std::f64::consts::TAU / f64::from(corners)).sin_cos();
        let _ = writeln!(text, "{x} {y} 0");
    }
    text += &(0..corners).fold(format!("{corners}"), |mut text, i| {
        let _ = write!(text, " {i}");
        text
    });
    let folder = folder();
    write(&folder, "polygon.ply", text);
    let scene = "WorldBegin\nShape \"plymesh\" \"string filename\" \"polygon.ply\"";
    let path = write(&folder, "a.pbrt", scene);
    let scene =
        promptly("a polygon", || petzval_scene_formats::pbrt::read(&path)).expect("a disk").scene;
    let mut stack = TraversalStack::default();
    for (x, there) in [(0.0, true), (0.7, true), (0.999, true), (1.001, false)] {
        let ray = Ray { origin: [x, 0.01, -1.0], direction: [0.0, 0.0, 1.0], t_max: f32::INFINITY };
        assert_eq!(scene.occluded::<f32x8>(&ray, &mut stack), there, "{x}");
    }
}

/// Returns a lattice of squares of side 1 with these heights, and its bilinear patches.
fn lattice(side: u32, mut height: impl FnMut() -> f64) -> (Mesh, Vec<[u32; 4]>) {
    let row = side + 1;
    let at = |i: u32| [(i % row) as f32, (i / row) as f32];
    let positions = (0..row * row).map(|i| [at(i)[0], at(i)[1], height() as f32]).collect();
    let corner = |i: u32| i / side * row + i % side;
    let patches = (0..side * side).map(corner).map(|a| [a, a + 1, a + row, a + row + 1]).collect();
    (Mesh { positions, ..Mesh::default() }, patches)
}

#[test]
fn a_quad_is_divided_as_finely_as_it_is_bent() {
    let mut random = Random::new(5);
    let mut count = |side: u32, height: f64, uvs: bool| {
        let (mut mesh, patches) = lattice(side, || height * random.next());
        if uvs {
            mesh.uvs = mesh.positions.iter().map(|[x, y, _]| [*x, *y]).collect();
        }
        let curved = split_patches(&mut mesh, &patches).tessellate(1 << 20);
        (mesh.triangles.len() + curved.triangles.len()) as f64 / f64::from(side * side)
    };
    for uvs in [false, true] {
        assert_eq!(count(1, 1e-4, uvs), 2.0, "a quad that is almost flat");
        assert_eq!(count(100, 1e-3, uvs), 2.0, "quads of a large mesh that are almost flat");
        assert!(count(1, 2.0, uvs) > 100.0, "a twisted quad");
        // A quarter of a million quads.
        assert!(count(517, 2.0, uvs) < 4.0, "too many twisted quads for fine triangles");
    }
}

#[test]
fn twisted_quads_become_triangles_only_if_they_emit_light() {
    let one = "Shape \"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 1]\n";
    let light = "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n";
    let shapes = read_world(&format!("{one}{light}{one}")).scene.shapes;
    let Geometry::Patches(mesh) = &shapes[0].geometry else { panic!("no patches") };
    assert_eq!(mesh.patches.len(), 1);
    let Geometry::Mesh(mesh) = &shapes[1].geometry else { panic!("no triangles") };
    assert!(mesh.triangles.len() > 1000, "{}", mesh.triangles.len());
}

#[test]
fn a_mesh_of_twisted_quads_takes_less_memory_than_one_of_as_many_triangles() {
    let mut random = Random::new(11);
    let side = 100;
    let (mut mesh, patches) = lattice(side, || random.next());
    let curved = split_patches(&mut mesh, &patches);
    let count = curved.patches.len();
    assert!(count > 9500 && count + mesh.triangles.len() / 2 == 10_000, "{count}");
    let scene = |geometry: Geometry| {
        let mut builder = SceneBuilder::default();
        let material = builder.add_material(Material::diffuse([0.5; 3]));
        builder.add_shape(ShapeSpec::new(geometry, material));
        builder.build().unwrap().bytes()
    };
    let triangles = scene(Geometry::Mesh(curved.tessellate(0)));
    let patches = scene(Geometry::Patches(curved));
    assert!(patches < 180 * count && patches < triangles, "{patches} {triangles}");
}

#[test]
fn the_error_of_divided_quads_is_relative_to_the_size_of_the_mesh() {
    let mut random = Random::new(7);
    let side = 12;
    let (mut mesh, patches) = lattice(side, || random.next());
    let heights: Vec<f64> = mesh.positions.iter().map(|p| f64::from(p[2])).collect();
    let exact = |p: DVec3| {
        let [i, j] = [p.x, p.y].map(|v| (v as u32).min(side - 1));
        let h = |i: u32, j: u32| heights[(j * (side + 1) + i) as usize];
        let (u, v) = (p.x - f64::from(i), p.y - f64::from(j));
        let along = |j: u32| h(i, j) * (1.0 - u) + h(i + 1, j) * u;
        along(j) * (1.0 - v) + along(j + 1) * v
    };
    let curved = split_patches(&mut mesh, &patches).tessellate(1 << 20);
    let mut worst = 0f64;
    for mesh in [&mesh, &curved] {
        for i in 0..mesh.triangles.len() as u32 {
            let [a, b, c]: [DVec3; 3] = mesh.corners(i).map(Vec3::as_dvec3);
            for p in [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0] {
                worst = worst.max((p.z - exact(p)).abs());
            }
        }
    }
    // 2e-5 of the diagonal of the mesh.
    let allowed = 2e-5 * f64::from(side) * 2f64.sqrt();
    assert!(worst < 1.05 * allowed, "{worst:e} of {allowed:e}");
    assert!(worst > 0.2 * allowed, "finer than necessary: {worst:e} of {allowed:e}");
    let triangles = mesh.triangles.len() + curved.triangles.len();
    assert!(triangles < 150_000, "{triangles}");
}
