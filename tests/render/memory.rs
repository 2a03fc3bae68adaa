//! Memory of a render: estimated before it starts, and bounded.
#![cfg(target_os = "linux")]

use crate::support::workspace::Workspace;
use crate::support::write_picture;
use petzval_base::io::ReadContext;
use petzval_image::{Picture, Transfer};

/// Parses a size such as "23 MB" or "1.54 GB" to bytes.
fn bytes(text: &str) -> f64 {
    let mut arguments = text.split_whitespace();
    let number: f64 = arguments.next().and_then(|word| word.parse().ok()).expect("a number");
    match arguments.next().map(|unit| unit.trim_end_matches([',', ')', ';'])) {
        Some("MB") => 1e6 * number,
        Some("GB") => 1e9 * number,
        other => panic!("{other:?} is no unit"),
    }
}

/// Returns the peak memory of a command and the estimate, bytes.
fn peak_and_estimate(stderr: &str) -> [f64; 2] {
    let line =
        stderr.lines().find_map(|line| line.strip_prefix("memory: ")).expect("a line about memory");
    let (most, expected) = line.split_once(" at most; expected about ").expect("both");
    [bytes(most), bytes(expected)]
}

#[test]
fn the_memory_of_a_render_is_close_to_its_estimate_and_not_above() {
    let workspace = Workspace::new();
    for (arguments, most) in [
        ("a.exr --spp 1 --effects none --resolution 72x50", 2.0),
        ("a.exr --spp 1 --effects none --resolution 1800x1200", 1.5),
        ("a.png --spp 1 --effects none --resolution 1200x1000", 1.5),
        ("a.petzval --shard 1/2 --spp 2 --effects none --resolution 1200x1000", 1.5),
        // Enough work that each thread takes part on a busy machine.
        ("a.exr --spp 32 --effects none --resolution 400x300 --threads 40", 2.0),
        ("a.exr --spp 16 --noise 1 --effects none --resolution 700x500", 1.5),
        ("a.exr --spp 1 --effects none --resolution 700x600 --aov depth,position,variance", 1.5),
        ("a.exr --spp 16 --noise 1 --effects none --resolution 500x400 --aov depth,albedo", 1.5),
        ("a.exr --spp 1 --effects +diffraction --resolution 700x500", 1.5),
        ("a.exr --spp 1 --effects +ghosts,-diffraction --resolution 900x600", 1.5),
        // Lamps touch few pixels of the film of light paths.
        ("a.exr --spp 4 --effects none --light-paths on --resolution 900x600", 2.0),
        ("a.exr --spp 1 --effects +sensor,-diffraction --sensor --resolution 1000x800", 1.5),
        ("a.exr --spp 1 --effects none --resolution 1000x800 --aov dual_pixel", 1.5),
        ("a.exr --spp 1 --effects none --resolution 700x600 --aov cryptomatte,motion", 1.5),
        ("a.exr --spp 1 --effects +sensor --sensor --resolution 1000x800 --aov dual_pixel", 1.5),
        ("a.exr --spp 1 --effects +diffraction --resolution 700x500 --aov dual_pixel", 1.5),
    ] {
        let threads = if arguments.contains("--threads") { "" } else { " --threads 2" };
        let paths = if arguments.contains("--light-paths") { "" } else { " --light-paths off" };
        let stderr =
            workspace.run_ok(&format!("render -v scene.pbrt -o {arguments}{threads}{paths}"));
        let [peak_and_estimate, expected] = peak_and_estimate(&stderr);
        println!("{arguments}: {} of {} MB", peak_and_estimate / 1e6, expected / 1e6);
        assert!(
            peak_and_estimate <= expected,
            "{arguments}: {peak_and_estimate} of {expected}: {stderr}"
        );
        assert!(
            expected <= most * peak_and_estimate,
            "{arguments}: {peak_and_estimate} of {expected}: {stderr}"
        );
    }
}

#[test]
fn a_render_beyond_its_memory_is_refused_at_the_start() {
    let workspace = Workspace::new();
    let arguments = "render scene.pbrt -o a.exr --effects none --resolution 6000x4000 --memory";
    let (code, stderr) = workspace.run(&format!("{arguments} 300MB"));
    assert_eq!(code, 2, "{stderr}");
    for part in ["film 576 MB", "--memory allows 300 MB", "--resolution", "--crop"] {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
    assert!(workspace.file_names().is_empty(), "{:?}", workspace.file_names());
    let (code, stderr) = workspace.run(&format!("{arguments} plenty"));
    assert!(code == 2 && stderr.contains("8GiB, 500MB or 2G"), "{stderr}");
}

#[test]
fn a_scene_is_refused_by_its_declared_sizes() {
    let workspace = Workspace::new();
    let picture = image::DynamicImage::new_rgb8(2000, 1500);
    let textures = |count: usize| {
        let one = |i: usize| {
            picture.save(workspace.path(&format!("{i}.png"))).expect("a picture");
            format!("Texture \"{i}\" \"spectrum\" \"imagemap\" \"string filename\" \"{i}.png\"\n")
        };
        let scene = std::fs::read_to_string(workspace.path("scene.pbrt")).expect("the scene");
        let textures: String = (0..count).map(one).collect();
        scene.replace("WorldBegin", &format!("WorldBegin\n{textures}"))
    };
    let arguments = "textures.pbrt -o a.exr --spp 1 --effects none";
    for (count, code) in [(3, 0), (12, 2)] {
        std::fs::write(workspace.path("textures.pbrt"), textures(count)).expect("a file");
        let (found, stderr) = workspace.run(&format!("render {arguments} --memory 100MB"));
        assert_eq!(found, code, "{count} of 9 MB: {stderr}");
        if code != 0 {
            let known = stderr.contains("textures.pbrt:") && stderr.contains(".png");
            assert!(known && stderr.contains("it takes 28 MB of memory beside the"), "{stderr}");
        }
    }
    // The vertices take more memory than the file.
    let vertices = "0 0 0\n".repeat(300_000);
    let head = "ply\nformat ascii 1.0\nelement vertex 300000\nproperty float x\nproperty float y\n\
                property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header";
    std::fs::write(workspace.path("many.ply"), format!("{head}\n{vertices}3 0 1 2\n"))
        .expect("a file");
    let scene = std::fs::read_to_string(workspace.path("scene.pbrt")).expect("the scene");
    let mesh = "Shape \"plymesh\" \"string filename\" \"many.ply\"";
    std::fs::write(workspace.path("mesh.pbrt"), format!("{scene}\n{mesh}")).expect("a file");
    let (code, stderr) = workspace.run("render mesh.pbrt -o a.exr --memory 3MB");
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("many.ply: it takes 4 MB of memory"), "{stderr}");
}

#[test]
fn the_memory_of_a_merge_does_not_grow_with_the_parts() {
    let workspace = Workspace::new();
    let size = "--spp 12 --effects none --resolution 640x480";
    let merge = |shards: u32| {
        let names: Vec<String> = (1..=shards)
            .map(|shard| {
                let name = format!("{shards}-{shard}.petzval");
                workspace.run_ok(&format!(
                    "render scene.pbrt -o {name} {size} --shard {shard}/{shards}"
                ));
                name
            })
            .collect();
        peak_and_estimate(
            &workspace
                .run_ok(&format!("merge -v {} -o {shards}.exr --memory 1GiB", names.join(" "))),
        )
    };
    let ([few, _], [many, expected]) = (merge(2), merge(12));
    // Less than the sums of one part more, however many blocks of the file wait to be written.
    let part = 640.0 * 480.0 * 24.0;
    assert!(many < few + part && many <= expected, "{few}, {many} of {expected}");
    let (code, stderr) = workspace.run("merge 2-1.petzval 2-2.petzval -o b.exr --memory 12MB");
    assert!(code == 2 && stderr.contains("--memory allows 12 MB"), "{stderr}");
}

#[test]
fn a_sweep_takes_the_memory_of_one_picture_and_the_sheet() {
    let workspace = Workspace::new();
    let sweep = "render scene.pbrt --spp 1 --effects none --resolution 1600x1000 --threads 2 \
                 --light-paths off --sweep seed=1..6:6 -o {seed}.exr --memory";
    let stderr = workspace.run_ok(&format!("{sweep} 110MB"));
    assert!(!stderr.contains("warning"), "{stderr}");
    let sheet = image::open(workspace.path("sweep.png")).expect("a sheet").into_rgb8();
    let light = sheet.pixels().filter(|pixel| pixel.0[0] != pixel.0[2]).count();
    assert!(light > 0, "the sheet is black");
    let (code, stderr) = workspace.run(&format!("{sweep} 40MB --resume"));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("seed 1: this takes") && stderr.contains("contact sheet"), "{stderr}");
}

#[test]
fn temporary_pictures_return_their_memory() {
    let workspace = Workspace::new();
    let (path, size) = (workspace.path("a.exr"), [400, 400]);
    let picture = Picture { size, pixels: vec![[0.5; 3]; size[0] * size[1]] };
    write_picture(&picture, &path);
    let read = |context: &ReadContext| {
        Picture::read_with(&path, Transfer::Srgb, context).map(|picture| picture.size)
    };
    let context = ReadContext::with_memory(3_000_000);
    for _ in 0..20 {
        assert_eq!(read(&context.temporary()).expect("there is memory"), size);
    }
    let kept = (0..20).filter(|_| read(&context).is_ok()).count();
    assert!((1..20).contains(&kept), "{kept} pictures in 3 MB");
}
