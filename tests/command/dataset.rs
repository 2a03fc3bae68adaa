//! `petzval dataset`: draws, pairs, the manifest, and what is refused.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::workspace::Contents;
use crate::support::{folder, petzval, root, write};
use petzval::Picture;
use serde_json::Value;

/// A textured wall behind a small lamp at a known place.
const WORLD: &str = r#"
LightSource "infinite" "rgb L" [ 0.2 0.2 0.2 ]
AttributeBegin
    AreaLightSource "diffuse" "rgb L" [ 40 40 40 ]
    Translate 0.35 0.22 2
    Shape "sphere" "float radius" 0.02
AttributeEnd
Texture "checks" "spectrum" "checkerboard" "float uscale" 30 "float vscale" 30
Material "diffuse" "texture reflectance" "checks"
Shape "bilinearmesh" "point3 P" [ -4 -4 4  4 -4 4  -4 4 4  4 4 4 ]
"#;

pub(super) fn scene(folder: &tempfile::TempDir, options: &str) -> PathBuf {
    let lens = root().join("lenses/dgauss.50mm.dat");
    let text = format!(
        "Film \"rgb\" \"float diagonal\" 43\n{options}\nCamera \"realistic\" \"string lensfile\" \
         \"{}\" \"float aperturediameter\" 12 \"float focusdistance\" 2\nWorldBegin\n{WORLD}",
        lens.display()
    );
    write(folder, "scene.pbrt", text)
}

/// Runs a specification, which names `scene.pbrt` in the same folder.
pub(super) fn run(folder: &Path, spec: &str, more: &[&str]) -> (i32, String, String) {
    fs::write(folder.join("spec.toml"), spec).expect("a file");
    petzval(folder, &[&["dataset", "spec.toml", "-o", "out"], more].concat())
}

pub(super) fn rows(folder: &Path) -> Vec<Value> {
    let mut rows = Vec::new();
    let mut manifests: Vec<_> = fs::read_dir(folder.join("out"))
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|found| found == "jsonl"))
        .collect();
    manifests.sort();
    for path in manifests {
        let text = fs::read_to_string(path).expect("a manifest");
        rows.extend(text.lines().map(|line| serde_json::from_str::<Value>(line).expect("a row")));
    }
    rows.sort_by_key(|row| row["pair"].as_u64());
    rows
}

pub(super) fn read(folder: &Path, pair: u32, kind: &str) -> Picture {
    Picture::read(&folder.join(format!("out/{pair:06}.{kind}.exr"))).expect("a picture")
}

#[test]
fn a_list_of_another_length_is_refused_and_a_failure_leaves_nothing() {
    let folder = folder();
    scene(&folder, "");
    let draw = "[draw]\nscene = \"scene.pbrt\"\n";
    for (spec, expected) in [
        (format!("pairs = 1\nresolution = [16, 12, 99]\n{draw}"), "expected 2 numbers, found 3"),
        (format!("pairs = 1\nresolution = [16]\n{draw}"), "expected 2 numbers, found 1"),
        (format!("pairs = 1\n{draw}move = [0.1, 0.1, 0.1, 9.0]\n"), "or three in brackets"),
        (format!("pairs = 1\n{draw}lens = \"missing.dat\"\n"), "missing.dat"),
    ] {
        let (code, _, log) = run(folder.path(), &spec, &[]);
        assert!(code == 2 && log.contains(expected), "{log}");
        assert!(!folder.path().join("out").exists(), "{spec}");
    }
}

/// Checks that the means of both halves of the pupil add up to the mean of a channel of the picture, but for
/// pixels that saturate.
fn halves_add_up(path: &Path, channel: &str) {
    let channels = Contents::read(path).channels;
    let values = |name: &str| -> Vec<f64> {
        let (_, bits) = channels.iter().find(|(found, _)| found == name).expect(name);
        bits.iter().map(|bits| f64::from(f32::from_bits(*bits))).collect()
    };
    let whole = values(channel);
    let mean = |values: &[f64]| {
        let unsaturated = values.iter().zip(&whole).filter(|(_, whole)| **whole < 0.9);
        unsaturated.map(|(value, _)| value).sum::<f64>() / whole.len() as f64
    };
    let [left, right] = ["left", "right"].map(|half| mean(&values(&format!("{half}.{channel}"))));
    let whole = mean(&whole);
    assert!(left > 0.3 * whole && right > 0.3 * whole, "{left} {right} {whole}");
    assert!(((left + right) / whole - 1.0).abs() < 0.005, "{left} + {right}, not {whole}");
}

#[test]
fn a_sensor_file_stands_beside_the_specification() {
    let folder = folder();
    scene(&folder, "");
    write(&folder, "camera.toml", "well = 5000\nbits = 10\n");
    let spec = |sensor: &str| {
        format!(
            "pairs = 1\nresolution = [16, 12]\nspp = 1\n[draw]\nscene = \"scene.pbrt\"\n[degraded]\nsensor = \
             \"{sensor}\"\n"
        )
    };
    let (code, _, log) = run(folder.path(), &spec("camera.toml,read=4"), &[]);
    assert_eq!(code, 0, "{log}");
    let settings = rows(folder.path())[0]["sensor"]["settings"].to_string();
    assert!(settings.contains("well=5000,read=4,bits=10"), "{settings}");
    write(&folder, "camera.toml", "well = 0\n");
    let (code, _, log) = run(folder.path(), &spec("camera.toml"), &[]);
    assert!(
        code == 2 && log.contains("line 7, column 10") && log.contains("camera.toml:1:8: well"),
        "{log}"
    );
    let (code, _, log) = run(folder.path(), &spec("well=x"), &[]);
    assert!(
        code == 2 && log.contains("line 7, column 10") && log.contains("well: expected"),
        "{log}"
    );
}

#[test]
fn mosaics_are_developed_as_the_command_does() {
    let folder = folder();
    scene(&folder, "");
    let spec = |degraded: &str| {
        format!(
            "pairs = 2\nresolution = [40, 30]\nspp = 4\n[draw]\nscene = \"scene.pbrt\"\n[degraded]\n{degraded}\n"
        )
    };
    let sensor = "sensor = \"bayer=grbg,iso=400\"\ndevelop = \"filmic\"";
    let (code, _, log) = run(folder.path(), &spec(sensor), &[]);
    assert_eq!(code, 0, "{log}");
    let rows = rows(folder.path());
    assert_eq!(rows.len(), 2);
    for (pair, row) in (0..).zip(&rows) {
        for (kind, name) in [("dng", "raw.dng"), ("developed", "developed.png")] {
            let path = folder.path().join(format!("out/{pair:06}.{name}"));
            assert_eq!(row["files"][kind]["bytes"], path.metadata().expect("a file").len());
        }
        let dng = format!("out/{pair:06}.raw.dng");
        let words = ["develop", &dng, "-o", "again.png", "--tone", "filmic"];
        let (code, _, stderr) = petzval(folder.path(), &words);
        assert_eq!(code, 0, "{stderr}");
        let again = Picture::read(&folder.path().join("again.png")).expect("a picture");
        let path = folder.path().join(format!("out/{pair:06}.developed.png"));
        assert_eq!(Picture::read(&path).expect("a picture").pixels, again.pixels);
    }
    for (degraded, expected) in [
        ("develop = \"linear\"", "add bayer=rggb"),
        ("sensor = \"bayer=quad-rggb\"\ndevelop = \"linear\"", "add bayer=rggb"),
        ("sensor = \"bayer\"\ndevelop = \"flat\"", "expected linear or filmic"),
    ] {
        let (code, _, log) = run(folder.path(), &spec(degraded), &[]);
        assert!(code == 2 && log.contains(expected), "{degraded}: {log}");
    }
}

const DRAWN: &str = "
pairs = 5
seed = 3
resolution = [40, 30]
spp = 4
layers = [\"depth\", \"coc\", \"dual_pixel\"]
[draw]
scene = \"scene.pbrt\"
focus = { from = 1.0, to = 4.0 }
fstop = { from = 1.2, to = 8.0, log = true }
light = { from = -3.0, to = 0.0 }
move = 0.05
turn = [2.0, 2.0, 5.0]
[degraded]
sensor = \"bayer\"
";

#[test]
fn pairs_do_not_depend_on_their_order_and_continue() {
    let folders = [folder(), folder()];
    for folder in &folders {
        scene(folder, "");
    }
    let [whole, parts] = folders.each_ref().map(|folder| folder.path());
    let (code, _, log) = run(whole, DRAWN, &[]);
    assert_eq!(code, 0, "{log}");
    assert_eq!(rows(whole).len(), 5);

    // The second of two shards first, then an interrupted row and a lost file.
    for shard in ["2/2", "1/2"] {
        let (code, _, log) = run(parts, DRAWN, &["--shard", shard, "--threads", "1"]);
        assert_eq!(code, 0, "{log}");
    }
    let manifest = parts.join("out/manifest.00001-of-00002.jsonl");
    let mut text = fs::read_to_string(&manifest).expect("a manifest");
    assert_eq!(text.lines().count(), 3);
    text.push_str("{\"pair\":");
    fs::write(&manifest, text).expect("a file");
    fs::remove_file(parts.join("out/000002.raw.exr")).expect("a file");
    let (code, _, log) = run(parts, DRAWN, &["--shard", "1/2"]);
    assert!(code == 0 && log.contains("2 of 3 pairs are done"), "{log}");
    assert!(log.contains("000002:") && !log.contains("000000:"), "{log}");

    for pair in 0..5 {
        for kind in ["clean", "degraded", "raw"] {
            assert_eq!(read(whole, pair, kind), read(parts, pair, kind), "{kind} of {pair}");
        }
        halves_add_up(&whole.join(format!("out/{pair:06}.raw.exr")), "Y");
        halves_add_up(&parts.join(format!("out/{pair:06}.raw.exr")), "Y");
        halves_add_up(&whole.join(format!("out/{pair:06}.degraded.exr")), "G");
    }
    let drawn = |name: &str| -> Vec<f64> {
        rows(whole).iter().map(|row| row["metadata"][name].as_f64().expect("a number")).collect()
    };
    assert!(
        drawn("focus").iter().all(|focus| (0.99..4.01).contains(focus)),
        "{:?}",
        drawn("focus")
    );
    let open = 1.9;
    for row in rows(whole) {
        let n = row["f_number"].as_f64().expect("a number");
        assert!((open..8.0).contains(&n), "the lens opens no wider: {n}");
        let iso = row["sensor"]["iso"].as_f64().expect("a number");
        let light = row["light_stops"].as_f64().expect("a number");
        assert!((iso / 100.0 * light.exp2() - 1.0).abs() < 1e-9, "{iso} at {light} stops");
    }
    // All pictures have the exposure of the scene's stop, whatever was drawn; the wall fills them.
    let means: Vec<f64> =
        (0..5).map(|pair| crate::support::mean(&read(whole, pair, "clean"))[1]).collect();
    let [low, high] = means
        .iter()
        .fold([f64::MAX, 0.0], |[low, high], mean| [f64::min(low, *mean), f64::max(high, *mean)]);
    assert!(high / low < 1.5, "{means:?}");

    // Every pair has a draw of its own, and another seed draws others.
    for name in ["seed", "f_number", "light_stops", "move_m", "turn_degrees"] {
        let all: BTreeSet<String> = rows(whole).iter().map(|row| row[name].to_string()).collect();
        assert_eq!(all.len(), 5, "{name}: {all:?}");
    }
    let drawn = |spec: &str| run(parts, spec, &["--dry-run"]).1;
    assert_ne!(drawn(DRAWN), drawn(&DRAWN.replace("seed = 3", "seed = 4")));

    // Another specification does not mix with these pairs; more pairs of the same do.
    let (code, _, log) = run(whole, &DRAWN.replace("seed = 3", "seed = 4"), &[]);
    assert!(code == 2 && log.contains("manifest.jsonl:1: this row is of another"), "{log}");
    let (code, _, log) = run(whole, &DRAWN.replace("pairs = 5", "pairs = 6"), &[]);
    assert!(code == 0 && log.contains("5 of 6 pairs are done"), "{log}");
    assert_eq!(rows(whole).len(), 6);
}

#[test]
fn the_two_pictures_share_their_samples() {
    let folder = folder();
    scene(&folder, "");
    let same = "pairs = 1\nresolution = [40, 30]\nspp = 4\n[draw]\nscene = \"scene.pbrt\"\n\
                [clean]\ncamera = \"lens\"\n[degraded]\neffects = \"none\"\n";
    let (code, _, log) = run(folder.path(), same, &[]);
    assert_eq!(code, 0, "{log}");
    let [clean, degraded] = ["clean", "degraded"].map(|kind| read(folder.path(), 0, kind));
    assert_eq!(clean, degraded, "nothing degrades it");
    // At the exposure of the scene it is the picture of a render with this seed.
    let seed = rows(folder.path())[0]["seed"].to_string();
    let arguments = ["render", "scene.pbrt", "--resolution", "40x30", "--spp", "4", "--effects"];
    let (code, _, log) = petzval(
        folder.path(),
        &[&arguments[..], &["none", "--seed", &seed, "-o", "one.exr"]].concat(),
    );
    assert_eq!(code, 0, "{log}");
    let one = Picture::read(&folder.path().join("one.exr")).expect("a picture");
    for (a, b) in clean.pixels.as_flattened().iter().zip(one.pixels.as_flattened()) {
        assert!((a - b).abs() <= 1e-5 * b.abs(), "{a} and {b}");
    }
}

/// Colours are no fault of a lens: a lamp that needs spectra has them in both pictures. The buckets of a film
/// are left out.
#[test]
fn the_two_pictures_share_their_colours() {
    let folder = folder();
    let path = scene(&folder, "");
    let lit = fs::read_to_string(&path).expect("a scene").replace(
        "\"rgb L\" [ 0.2 0.2 0.2 ]",
        "\"spectrum L\" \"stdillum-F11\"\nMaterial \"diffuse\" \"rgb reflectance\" [0.7 0.2 0.1]",
    );
    let filmed = lit.replace("Film \"rgb\"", "Film \"spectral\"");
    fs::write(&path, filmed).expect("a file");
    let spec = "pairs = 1\nresolution = [40, 30]\nspp = 64\n[draw]\nscene = \"scene.pbrt\"\n\
                [clean]\ncamera = \"lens\"\n";
    let (code, _, log) = run(folder.path(), spec, &[]);
    assert_eq!(code, 0, "{log}");
    let row = &rows(folder.path())[0];
    for kind in ["clean", "degraded"] {
        let effects = row[kind]["effects"].as_array().expect("a list");
        assert!(effects.contains(&"spectra".into()), "{kind}: {row}");
    }
}

#[test]
fn exposure_scales_ghosts_and_light_paths_too() {
    let folder = folder();
    scene(&folder, "\"float iso\" 200");
    let spec = |exposure: &str| {
        format!(
            "pairs = 1\nresolution = [40, 30]\nspp = 16\nexposure = {exposure}\n[draw]\n\
             scene = \"scene.pbrt\"\nfstop = 4.0\n[degraded]\neffects = \"+ghosts,-diffraction\"\n"
        )
    };
    let taken = ["0.0", "2.0"].map(|exposure| {
        let _ = fs::remove_dir_all(folder.path().join("out"));
        let (code, _, log) = run(folder.path(), &spec(exposure), &[]);
        assert_eq!(code, 0, "{log}");
        assert!(rows(folder.path())[0]["degraded"]["effects"].to_string().contains("ghosts"));
        ["clean", "degraded"].map(|kind| read(folder.path(), 0, kind))
    });
    for kind in 0..2 {
        let [one, four] = [&taken[0][kind], &taken[1][kind]];
        for (a, b) in one.pixels.as_flattened().iter().zip(four.pixels.as_flattened()) {
            assert!((4.0 * a - b).abs() <= 1e-5 * b.abs() + 1e-9, "4 times {a} and {b}");
        }
    }
}

#[test]
fn the_stop_changes_no_brightness() {
    let folder = folder();
    let path = scene(&folder, "");
    let text = fs::read_to_string(&path).expect("a scene");
    let world = text.find("WorldBegin").expect("a world");
    let sky = "WorldBegin\nLightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\n";
    write(&folder, "scene.pbrt", format!("{}{sky}", &text[..world]));
    let middle = |camera: &str, stop: &str| {
        let _ = fs::remove_dir_all(folder.path().join("out"));
        let spec = format!(
            "pairs = 1\nresolution = [9, 9]\nspp = 1024\n[draw]\nscene = \"scene.pbrt\"\n{stop}\n\
             [clean]\ncamera = \"{camera}\"\n[degraded]\neffects = \"none\"\n"
        );
        let (code, _, log) = run(folder.path(), &spec, &[]);
        assert_eq!(code, 0, "{log}");
        ["clean", "degraded"].map(|kind| read(folder.path(), 0, kind).pixels[40][1])
    };
    let [expected, own] = middle("lens", "");
    assert_eq!(expected, own);
    for (camera, stop) in [("pinhole", "fstop = 2.5"), ("deep", "fstop = 8.0")] {
        for found in middle(camera, stop) {
            assert!((found / expected - 1.0).abs() < 0.005, "{camera} {stop}: {found}, {expected}");
        }
    }
}

/// Returns the sum of the squared differences of neighbours in a row, relative to that of the squares.
fn sharpness(picture: &Picture) -> f64 {
    let [width, _] = picture.size;
    let difference = |row: &[[f32; 3]]| {
        row.windows(2).map(|pair| f64::from(pair[1][1] - pair[0][1]).powi(2)).sum::<f64>()
    };
    let all: f64 = picture.pixels.chunks(width).map(difference).sum();
    all / picture.pixels.iter().map(|pixel| f64::from(pixel[1]).powi(2)).sum::<f64>()
}

#[test]
fn the_deep_picture_is_sharp_where_the_lens_is_out_of_focus() {
    let folder = folder();
    scene(&folder, "");
    let spec = "
        pairs = 1
        resolution = [120, 80]
        spp = 512
        [draw]
        scene = \"scene.pbrt\"
        focus = 0.5
        fstop = 2.1
        [clean]
        camera = \"deep\"
        effects = \"none\"
        [degraded]
        effects = \"none\"
    ";
    let (code, _, said) = run(folder.path(), spec, &[]);
    assert_eq!(code, 0, "{said}");
    let [clean, degraded] =
        ["clean", "degraded"].map(|kind| sharpness(&read(folder.path(), 0, kind)));
    // The checks are 11 pixels wide, and the lens blurs them over about 8.
    assert!(clean > 2.0 * degraded, "{clean} {degraded}");
}

#[test]
fn what_is_wrong_is_named_with_its_place() {
    let folder = folder();
    scene(&folder, "");
    let good = "pairs = 1\n[draw]\nscene = \"scene.pbrt\"\n";
    for (spec, expected) in [
        ("pairs = 1\n", "missing field `draw`"),
        ("pairs = 0\n[draw]\nscene = \"scene.pbrt\"\n", "pairs = 0: expected 1 to 10000000"),
        ("pairs = 1\nspps = 4\n[draw]\nscene = \"scene.pbrt\"\n", "line 2, column 1"),
        ("pairs = 1\nspps = 4\n[draw]\nscene = \"scene.pbrt\"\n", "unknown field `spps`"),
        (&format!("{good}fstop = \"fast\"\n"), "expected a value, a list of values, or a range"),
        (&format!("{good}fstop = []\n"), "draw.fstop has no values"),
        (&format!("{good}fstop = [4.0, nan]\n"), "draw.fstop = NaN: expected a number above 0"),
        (&format!("{good}focus = {{ from = 4.0, to = 1.0 }}\n"), "expected from <= to"),
        (&format!("{good}focus = \"far\"\n"), "found \"far\"; expected a distance in m"),
        (&format!("{good}light = -2.0\n"), "add sensor = \"\" to [degraded]"),
        (&format!("{good}turn = [1.0, 2.0]\n"), "expected a number, or three in brackets"),
        (&format!("{good}[degraded]\neffects = \"+gosts\"\n"), "gosts"),
        (&format!("{good}[clean]\neffects = \"all\"\n"), "clean.effects: a pinhole has no effects"),
        (&format!("{good}[clean]\ncamera = \"fisheye\"\n"), "expected one of `pinhole`"),
        ("layers = [\"dept\"]\npairs = 1\n[draw]\nscene = \"scene.pbrt\"\n", "no layer \"dept\""),
        ("pairs = 1\n[draw]\nscene = \"none.pbrt\"\n", "none.pbrt"),
        (&format!("{good}lens = \"none.dat\"\n"), "none.dat"),
    ] {
        let (code, _, log) = run(folder.path(), spec, &[]);
        assert!(code == 2 && log.contains(expected), "{spec}\ngives {code} and\n{log}");
        assert!(!log.contains("panicked"), "{log}");
    }
    let (code, _, log) = petzval(folder.path(), &["dataset", "missing.toml", "-o", "out"]);
    assert!(code == 2 && log.contains("missing.toml"), "{log}");
    // A camera without a lens has nothing to degrade.
    let text = fs::read_to_string(folder.path().join("scene.pbrt")).expect("a scene");
    let from = text.find("Camera").expect("a camera");
    let to = text.find("WorldBegin").expect("a world");
    let plain = format!("{}Camera \"perspective\"\n{}", &text[..from], &text[to..]);
    write(&folder, "scene.pbrt", plain);
    let (code, _, log) = run(folder.path(), good, &[]);
    assert!(code == 2 && log.contains("no lens file"), "{log}");
}

#[test]
fn a_dry_run_draws_and_writes_nothing() {
    let folder = folder();
    scene(&folder, "");
    let (code, out, log) = run(folder.path(), DRAWN, &["--dry-run"]);
    assert!(
        code == 0 && out.lines().count() == 5 && out.contains("000004  scene.pbrt"),
        "{out}{log}"
    );
    assert!(!folder.path().join("out").exists());
}

#[test]
fn every_recipe_runs() {
    let recipes: Vec<PathBuf> = fs::read_dir(root().join("scenes/datasets"))
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    assert!(recipes.len() >= 5, "{recipes:?}");
    crate::support::in_parallel(&recipes, |recipe| {
        let folder = folder();
        let scenes = root().join("scenes");
        let up = |by: &Path| format!("\"{}/", by.display());
        let text = fs::read_to_string(recipe).expect("a recipe");
        let text = text.replace("\"../../", &up(root())).replace("\"../", &up(&scenes));
        let text = text.replace("pairs = 200", "pairs = 1").replace("[512, 512]", "[32, 24]");
        let number = text.find("spp = ").expect("samples");
        let (before, after) = text.split_at(number);
        let spec = format!("{before}spp = 4\n{}", &after[after.find('\n').expect("a line")..]);
        let (code, _, log) = run(folder.path(), &spec, &[]);
        assert_eq!(code, 0, "{}: {log}", recipe.display());
        let row = rows(folder.path()).remove(0);
        let effects = |kind: &str| row[kind]["effects"].to_string();
        let name = recipe.file_stem().expect("a name").to_string_lossy();
        let [clean, degraded] = ["clean", "degraded"].map(effects);
        match name.as_ref() {
            "bokeh" => assert_eq!(row["clean_camera"], "deep"),
            "flare" => assert!(degraded.contains("ghosts") && !clean.contains("ghosts")),
            "colour" => assert!(degraded.contains("dispersion") && !clean.contains("dispersion")),
            "rolling" => {
                assert!(degraded.contains("rolling_shutter") && !clean.contains("rolling_shutter"));
            }
            "noise" => {
                let raw = read(folder.path(), 0, "raw");
                assert!(raw.pixels.iter().all(|pixel| pixel[0] == pixel[2]), "a mosaic is grey");
                assert_eq!(read(folder.path(), 0, "clean"), read(folder.path(), 0, "degraded"));
            }
            other => panic!("no test of {other}"),
        }
    });
}
