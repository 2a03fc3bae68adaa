//! What a picture takes of the memory is known before it is rendered, and bounded.
#![cfg(target_os = "linux")]

mod support;

use petzval::image::{Encoding, Notes, Picture, Window};
use petzval::memory::budget;
use support::kept::Studio;

/// Bytes of a size as it is said: "23 MB", "1.54 GB".
fn bytes(said: &str) -> f64 {
    let mut words = said.split_whitespace();
    let number: f64 = words.next().and_then(|word| word.parse().ok()).expect("a number");
    match words.next().map(|unit| unit.trim_end_matches([',', ')', ';'])) {
        Some("MB") => 1e6 * number,
        Some("GB") => 1e9 * number,
        other => panic!("{other:?} is no unit"),
    }
}

/// What a command took at most, and what was expected.
fn taken(said: &str) -> [f64; 2] {
    let line = said.lines().find_map(|line| line.strip_prefix("memory: ")).expect("what it took");
    let (most, expected) = line.split_once(" at most; expected was about ").expect("both");
    [bytes(most), bytes(expected)]
}

#[test]
fn no_render_takes_more_than_was_expected_nor_much_less() {
    let studio = Studio::new();
    for (words, most) in [
        ("a.exr --spp 1 --effects none --resolution 72x50", 2.0),
        ("a.exr --spp 1 --effects none --resolution 1800x1200", 1.5),
        ("a.png --spp 1 --effects none --resolution 1200x1000", 1.5),
        ("a.petzval --shard 1/2 --spp 2 --effects none --resolution 1200x1000", 1.5),
        ("a.exr --spp 1 --effects none --resolution 400x300 --threads 40", 2.0),
        ("a.exr --spp 16 --noise 1 --effects none --resolution 700x500", 1.5),
        ("a.exr --spp 1 --effects none --resolution 700x600 --aov depth,position,variance", 1.5),
        ("a.exr --spp 16 --noise 1 --effects none --resolution 500x400 --aov depth,albedo", 1.5),
        ("a.exr --spp 1 --effects +diffraction --resolution 700x500", 1.5),
        ("a.exr --spp 1 --effects +ghosts,-diffraction --resolution 900x600", 1.5),
        ("a.exr --spp 1 --effects +sensor,-diffraction --sensor --resolution 1000x800", 1.5),
    ] {
        let threads = if words.contains("--threads") { "" } else { " --threads 2" };
        let said = studio.done(&format!("render scene.pbrt -o {words}{threads}"));
        let [taken, expected] = taken(&said);
        println!("{words}: {} of {} MB", taken / 1e6, expected / 1e6);
        assert!(taken <= expected, "{words}: {taken} of {expected}: {said}");
        assert!(expected <= most * taken, "{words}: {taken} of {expected}: {said}");
    }
}

#[test]
fn a_render_beyond_its_memory_is_refused_at_the_start() {
    let studio = Studio::new();
    let words = "render scene.pbrt -o a.exr --effects none --resolution 6000x4000 --memory";
    let (code, said) = studio.run(&format!("{words} 300MB"));
    assert_eq!(code, 2, "{said}");
    for part in ["film 576 MB", "--memory allows 300 MB", "--resolution", "--crop"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert!(studio.names().is_empty(), "{:?}", studio.names());
    let (code, said) = studio.run(&format!("{words} plenty"));
    assert!(code == 2 && said.contains("8GiB, 500MB or 2G"), "{said}");
}

#[test]
fn a_scene_is_refused_by_the_sizes_that_it_declares() {
    let studio = Studio::new();
    let picture = image::DynamicImage::new_rgb8(2000, 1500);
    let textures = |count: usize| {
        let one = |i: usize| {
            picture.save(studio.path(&format!("{i}.png"))).expect("a picture");
            format!("Texture \"{i}\" \"spectrum\" \"imagemap\" \"string filename\" \"{i}.png\"\n")
        };
        let scene = std::fs::read_to_string(studio.path("scene.pbrt")).expect("the scene");
        let textures: String = (0..count).map(one).collect();
        scene.replace("WorldBegin", &format!("WorldBegin\n{textures}"))
    };
    let words = "textures.pbrt -o a.exr --spp 1 --effects none";
    for (count, code) in [(3, 0), (9, 2)] {
        std::fs::write(studio.path("textures.pbrt"), textures(count)).expect("a file");
        let (found, said) = studio.run(&format!("render {words} --memory 80MB"));
        assert_eq!(found, code, "{count} of 9 MB: {said}");
        if code != 0 {
            let known = said.contains("textures.pbrt:") && said.contains(".png");
            assert!(known && said.contains("it takes 9 MB of memory beside the"), "{said}");
        }
    }
    // Its vertices take more than its faces and its file.
    let vertices = "0 0 0\n".repeat(300_000);
    let head = "ply\nformat ascii 1.0\nelement vertex 300000\nproperty float x\nproperty float y\n\
                property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header";
    std::fs::write(studio.path("many.ply"), format!("{head}\n{vertices}3 0 1 2\n"))
        .expect("a file");
    let scene = std::fs::read_to_string(studio.path("scene.pbrt")).expect("the scene");
    let mesh = "Shape \"plymesh\" \"string filename\" \"many.ply\"";
    std::fs::write(studio.path("mesh.pbrt"), format!("{scene}\n{mesh}")).expect("a file");
    let (code, said) = studio.run("render mesh.pbrt -o a.exr --memory 3MB");
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("many.ply: it takes 4 MB of memory"), "{said}");
}

#[test]
fn a_merge_takes_no_more_for_more_parts() {
    let studio = Studio::new();
    let size = "--spp 12 --effects none --resolution 640x480";
    let merge = |shards: u32| {
        let names: Vec<String> = (1..=shards)
            .map(|shard| {
                let name = format!("{shards}-{shard}.petzval");
                studio
                    .done(&format!("render scene.pbrt -o {name} {size} --shard {shard}/{shards}"));
                name
            })
            .collect();
        taken(&studio.done(&format!("merge {} -o {shards}.exr --memory 1GiB", names.join(" "))))
    };
    let ([few, _], [many, expected]) = (merge(2), merge(12));
    assert!(many <= few + 3e6 && many <= expected, "{few}, {many} of {expected}");
    let (code, said) = studio.run("merge 2-1.petzval 2-2.petzval -o b.exr --memory 12MB");
    assert!(code == 2 && said.contains("--memory allows 12 MB"), "{said}");
}

#[test]
fn a_sweep_takes_the_memory_of_one_picture_and_its_sheet() {
    let studio = Studio::new();
    let sweep = "render scene.pbrt --spp 1 --effects none --resolution 1600x1000 --threads 2 \
                 --sweep seed=1..6:6 -o {seed}.exr --memory";
    let said = studio.done(&format!("{sweep} 110MB"));
    assert!(!said.contains("warning"), "{said}");
    let sheet = image::open(studio.path("sweep.png")).expect("a sheet").into_rgb8();
    let light = sheet.pixels().filter(|pixel| pixel.0[0] != pixel.0[2]).count();
    assert!(light > 0, "its pictures are on it");
    let (code, said) = studio.run(&format!("{sweep} 40MB --resume"));
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("seed 1: this takes") && said.contains("contact sheet"), "{said}");
}

#[test]
fn pictures_that_are_looked_at_and_dropped_take_no_memory_for_good() {
    let studio = Studio::new();
    let (path, size) = (studio.path("a.exr"), [400, 400]);
    let picture = Picture { size, pixels: vec![[0.5; 3]; size[0] * size[1]] };
    let window = Window { origin: [0, 0], frame: size.map(|n| n as u32) };
    picture.write(&path, window, Encoding::default(), &Notes::new()).expect("a file");
    let read = || Picture::read(&path, true).map(|picture| picture.size);
    // Of this process only: all others here are of their own.
    budget::allow(3_000_000);
    for _ in 0..20 {
        assert_eq!(budget::lent(read).expect("there is memory"), size);
    }
    let kept = (0..20).filter(|_| read().is_ok()).count();
    assert!((1..20).contains(&kept), "{kept} pictures in 3 MB");
}
