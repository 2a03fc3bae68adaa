//! Digests of what the command computes, to prove that a change of the source changes no pixel.
//!
//! Renders small pictures with the built command, runs its other subcommands, and prints one line
//! `digest  name` for each output. Run it before and after the change and compare:
//!
//!     cargo bench --bench digests >before.txt
//!     ... change the source ...
//!     cargo bench --bench digests >after.txt; diff before.txt after.txt
//!
//! `cargo bench --bench digests -- dgauss` runs only the cases whose names contain the word, and
//! `PETZVAL=/path/to/petzval` names another program to run instead of the one that cargo builds.
//!
//! A digest covers the pixels of a picture in all its channels, with their names. It does not cover
//! the metadata, which holds the command line and the version; one case digests the names and the
//! numbers of the metadata. Reports get two digests: of the text, and of the numbers in it, which
//! stay when only the wording changes.
//!
//! The digests are not stored in the repository: the mathematical functions of another CPU, system
//! or compiler may round otherwise, so only digests of one machine are comparable.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use exr::prelude::FlatSamples;

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

/// Every scene of `scenes/` that is complete in itself.
const SCENES: [&str; 8] =
    ["atelier", "dgauss", "fisheye", "night", "propeller", "snowman", "telephoto", "wide"];

/// Layers that are recorded while the picture is rendered. The layers of the lens, which need a real
/// lens and take seconds each, are a case of `OPTIONS`.
const LAYERS: [&str; 8] =
    ["depth", "position", "normal", "albedo", "object", "material", "variance", "samples"];

/// Lens files, with the z of the film and the reach across the rear element of the rays that are
/// traced through them, mm.
const LENSES: [(&str, f64, f64); 7] = [
    ("anamorphic.toml", 150.0, 10.0),
    ("dgauss.50mm.dat", 105.0, 13.0),
    ("fisheye.10mm.dat", 55.0, 5.0),
    ("phone.toml", 6.5, 3.4),
    ("telephoto.250mm.dat", 210.0, 20.0),
    ("triplet.toml", 60.0, 6.0),
    ("wide.22mm.dat", 85.0, 12.0),
];

/// Options that select other paths through the renderer: name of the case, scene, options.
const OPTIONS: &str = "\
scalar backend              | dgauss    | --effects none --backend scalar
scalar backend, path traced | atelier   | --effects none --backend scalar
scalar backend, motion      | propeller | --backend scalar
scalar backend, adaptive    | night     | --effects none --backend scalar --spp 16 --noise 0.2
one thread                  | dgauss    | --effects none --threads 1
ghosts in adaptive sampling | night     | --effects +ghosts,-diffraction --spp 16 --noise 0.2
layers of the lens          | dgauss    | --aov coc --aov vignetting
dispersion                  | dgauss    | --assume-vd --effects +dispersion,+fresnel
dispersion, a TOML lens     | dgauss    | --lens lenses/triplet.toml --effects +dispersion
scalar backend, dispersion  | dgauss    | --assume-vd --effects +dispersion,+fresnel --backend scalar
anamorphic                  | dgauss    | --lens lenses/anamorphic.toml
aspheres                    | dgauss    | --lens lenses/phone.toml --effects +ghosts
coating                     | wide      | --coating broadband --effects +fresnel,+ghosts
tilted and shifted film     | dgauss    | --film-tilt 3,-2 --film-shift 2,1
focus on a pixel            | telephoto | --focus auto@20,20 --fstop 8
focus as in pbrt-v4         | dgauss    | --focus-model pbrt --focus 2.5
rear pupil                  | fisheye   | --pupil rear
passband                    | dgauss    | --passband 500..560
sensor with a Bayer mosaic  | dgauss    | --sensor iso=800,read=3 --bayer
rolling shutter             | propeller | --rolling-shutter 4ms,left --shutter time=1/100,ramp=1ms
crop                        | dgauss    | --crop 10,5,40,31 --seed 7
half floats                 | dgauss    | --half";

fn main() -> Outcome {
    let filter = std::env::args().skip(1).find(|word| !word.starts_with("--")).unwrap_or_default();
    let program = std::env::var_os("PETZVAL").unwrap_or(env!("CARGO_BIN_EXE_petzval").into());
    let bench = Bench { program: program.into(), folder: tempfile::tempdir()?, filter };
    scenes(&bench)?;
    options(&bench)?;
    parts(&bench)?;
    resume(&bench)?;
    sweep(&bench)?;
    lenses(&bench)?;
    reports(&bench)
}

/// Digests every scene without effects, with the effects of its plan, with all effects, and with adaptive
/// sampling.
fn scenes(bench: &Bench) -> Outcome {
    for scene in SCENES {
        let small = format!("scenes/{scene}.pbrt --resolution 60x44");
        // Diffraction takes a second for small pixels, and ten times as long for large ones.
        let crop =
            format!("scenes/{scene}.pbrt --resolution 600x440 --crop 270,198,330,242 --spp 4");
        let layers: String = LAYERS.map(|layer| format!(" --aov {layer}")).concat();
        let noise = "--spp 24 --noise 0.08 --aov variance --aov samples";
        bench
            .picture(&format!("{scene}, no effects"), &format!("{small} --spp 4 --effects none"))?;
        bench.picture(&format!("{scene}, planned effects"), &format!("{crop}{layers}"))?;
        bench.picture(&format!("{scene}, all effects"), &format!("{crop} --effects all"))?;
        bench.picture(&format!("{scene}, adaptive"), &format!("{small} --effects none {noise}"))?;
    }
    Ok(())
}

/// Digests every row of [`OPTIONS`], pictures with an exposure, and the metadata of a picture.
fn options(bench: &Bench) -> Outcome {
    for row in OPTIONS.lines() {
        let [name, scene, options] = row.split('|').map(str::trim).collect::<Vec<_>>()[..] else {
            return Err(format!("{row}: expected a name, a scene and options").into());
        };
        let spp = if options.contains("--spp") { "" } else { "--spp 4" };
        let all = format!("scenes/{scene}.pbrt --resolution 60x44 {spp} {options}");
        bench.picture(&format!("{scene}, {name}"), &all)?;
    }
    for kind in ["png", "jpg"] {
        let render = "render scenes/dgauss.pbrt --resolution 60x44 --spp 4 --exposure auto -o";
        bench.digest(&format!("dgauss as {kind}"), |bench| {
            pixels(&bench.written(render, &format!("a.{kind}"))?)
        })?;
    }
    bench.digest("dgauss, metadata", |bench| {
        metadata(
            &bench.written("render scenes/dgauss.pbrt --resolution 60x44 --spp 4 -o", "a.exr")?,
        )
    })
}

/// Digests a picture merged from parts. It equals the picture that is rendered at once.
fn parts(bench: &Bench) -> Outcome {
    let scene = "scenes/dgauss.pbrt --resolution 60x44 --spp 8 --aov variance --aov depth";
    bench.picture("dgauss, at once", scene)?;
    bench.digest("dgauss, three shards merged", |bench| {
        let mut merge = String::from("merge");
        for shard in 1..=3 {
            let render = format!("render {scene} --shard {shard}/3 -o");
            let part = bench.written(&render, &format!("{shard}.petzval"))?;
            let _ = write!(merge, " {}", part.display());
        }
        pixels(&bench.written(&(merge + " -o"), "merged.exr")?)
    })
}

/// Digests a render that is killed after its first checkpoint and resumed. It equals one without a break.
fn resume(bench: &Bench) -> Outcome {
    let scene = "scenes/dgauss.pbrt --resolution 300x300 --spp 480 --effects none";
    bench.picture("dgauss, without a break", scene)?;
    bench.digest("dgauss, killed and resumed", |bench| {
        let output = bench.folder.path().join("resumed.exr");
        let render = format!("render {scene} --checkpoint 1s -o {}", output.display());
        let checkpoint = bench.folder.path().join("resumed.exr.checkpoint");
        let mut child = bench.command(&render).stderr(Stdio::null()).spawn()?;
        while !checkpoint.exists() {
            if child.try_wait()?.is_some() {
                return Err("the render ended before its first checkpoint".into());
            }
            sleep(Duration::from_millis(20));
        }
        child.kill()?;
        child.wait()?;
        bench.run(&(render + " --resume"))?;
        pixels(&output)
    })
}

/// Digests the pictures of a sweep and their contact sheet.
fn sweep(bench: &Bench) -> Outcome {
    bench.digest("dgauss, sweep", |bench| {
        let folder = bench.folder.path().display();
        bench.run(&format!(
            "render scenes/dgauss.pbrt --resolution 60x44 --spp 4 --sweep fstop=2.8,5.6 \
             --sweep focus=2,6 -o {folder}/{{fstop}}-{{focus}}.exr --contact {folder}/sheet.png"
        ))?;
        let mut all = blake3::Hasher::new();
        for name in ["2.8-2.exr", "2.8-6.exr", "5.6-2.exr", "5.6-6.exr", "sheet.png"] {
            all.update(pixels(&bench.folder.path().join(name))?.as_bytes());
        }
        Ok(short(&all))
    })
}

/// Digests rays through every lens of `lenses/`, in both precisions, and the report of each lens.
fn lenses(bench: &Bench) -> Outcome {
    for (file, film, reach) in LENSES {
        let rays = bench.folder.path().join("rays.csv");
        fs::write(&rays, random_rays(film, reach))?;
        for precision in ["f32", "f64"] {
            let trace = format!(
                "lens trace lenses/{file} --rays {} --precision {precision}",
                rays.display()
            );
            bench.digest(&format!("{file}, rays in {precision}"), |bench| {
                Ok(short(blake3::Hasher::new().update(bench.run(&trace)?.as_bytes())))
            })?;
        }
        bench.report(&format!("{file}, report"), &format!("lens lenses/{file}"))?;
    }
    bench.report("dgauss.50mm.dat, vignetting", "lens lenses/dgauss.50mm.dat --vignetting")?;
    bench.digest("dgauss.50mm.dat, drawing", |bench| {
        let svg = bench.written("lens lenses/dgauss.50mm.dat --draw", "lens.svg")?;
        Ok(short(blake3::Hasher::new().update(&fs::read(svg)?)))
    })?;
    bench.digest("wide.22mm.dat, point spread", |bench| {
        pixels(&bench.written("lens lenses/wide.22mm.dat --stop 4 --psf", "psf.png")?)
    })
}

/// Digests plans, replays of one sample and a comparison, as JSON.
fn reports(bench: &Bench) -> Outcome {
    for scene in SCENES {
        let plan = format!("plan scenes/{scene}.pbrt --resolution 60x44 --spp 4 --json");
        bench.report(&format!("{scene}, plan"), &plan)?;
    }
    for scene in ["dgauss", "atelier", "propeller"] {
        let replay = format!(
            "replay scenes/{scene}.pbrt --resolution 60x44 --pixel 30,30 --sample 1 --json"
        );
        bench.report(&format!("{scene}, replay"), &replay)?;
    }
    bench.report("compare", "compare scenes/gallery/wide.jpg scenes/gallery/fisheye.jpg --json")
}

/// Program to run, folder for its outputs, and the cases to run: those whose names contain `filter`.
struct Bench {
    program: PathBuf,
    folder: tempfile::TempDir,
    filter: String,
}

impl Bench {
    fn command(&self, words: &str) -> Command {
        let mut command = Command::new(&self.program);
        command.args(words.split_whitespace()).stdin(Stdio::null());
        command
    }

    /// Runs the program and returns what it prints to standard output.
    fn run(&self, words: &str) -> Outcome<String> {
        let output = self.command(words).output()?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            return Err(format!("petzval {words}: {}\n{said}", output.status).into());
        }
        Ok(String::from_utf8(output.stdout)?)
    }

    /// Runs the program with the name of a file to write as the last word.
    fn written(&self, words: &str, file: &str) -> Outcome<PathBuf> {
        let path = self.folder.path().join(file);
        self.run(&format!("{words} {}", path.display()))?;
        Ok(path)
    }

    fn digest(&self, name: &str, make: impl FnOnce(&Self) -> Outcome<String>) -> Outcome {
        if name.contains(&self.filter) {
            println!("{}  {name}", make(self)?);
        }
        Ok(())
    }

    /// Digests the pixels of a render.
    fn picture(&self, name: &str, words: &str) -> Outcome {
        self.digest(name, |bench| {
            pixels(&bench.written(&format!("render {words} --checkpoint off -o"), "a.exr")?)
        })
    }

    /// Digests a text and the numbers in it.
    fn report(&self, name: &str, words: &str) -> Outcome {
        if !name.contains(&self.filter) {
            return Ok(());
        }
        let text = self.run(words)?;
        let mut numbers = blake3::Hasher::new();
        let parts = text.split(|c: char| !c.is_ascii_digit() && c != '.' && c != '-');
        for number in parts.filter(|part| part.contains(|c: char| c.is_ascii_digit())) {
            numbers.update(number.as_bytes()).update(b" ");
        }
        println!("{}  {name}, text", short(blake3::Hasher::new().update(text.as_bytes())));
        println!("{}  {name}, numbers", short(&numbers));
        Ok(())
    }
}

/// Returns 64 bits of a digest in hexadecimal, which suffice against accidental collisions.
fn short(digest: &blake3::Hasher) -> String {
    digest.finalize().to_hex()[..16].to_owned()
}

/// Digests the pixels of a picture: of an EXR every channel bit for bit, with its name.
fn pixels(path: &Path) -> Outcome<String> {
    let mut digest = blake3::Hasher::new();
    if path.extension().is_none_or(|extension| extension != "exr") {
        let picture = image::open(path)?;
        let kind = format!("{:?} {} {}", picture.color(), picture.width(), picture.height());
        return Ok(short(digest.update(kind.as_bytes()).update(picture.as_bytes())));
    }
    let image = exr::prelude::read_all_flat_layers_from_file(path)?;
    for layer in &image.layer_data {
        digest.update(format!("{:?} {:?}", layer.size, layer.attributes.layer_position).as_bytes());
        for channel in &layer.channel_data.list {
            digest.update(format!("{} ", channel.name).as_bytes());
            match &channel.sample_data {
                FlatSamples::F16(all) => {
                    all.iter().for_each(|v| feed(&mut digest, v.to_le_bytes()))
                }
                FlatSamples::F32(all) => {
                    all.iter().for_each(|v| feed(&mut digest, v.to_le_bytes()))
                }
                FlatSamples::U32(all) => {
                    all.iter().for_each(|v| feed(&mut digest, v.to_le_bytes()))
                }
            }
        }
    }
    Ok(short(&digest))
}

fn feed<const N: usize>(digest: &mut blake3::Hasher, bytes: [u8; N]) {
    digest.update(&bytes);
}

/// Digests the names and types of an EXR's attributes, and the values of those that are not text.
/// Each attribute is a name and a type that end in zero, a length of four bytes, and the value.
fn metadata(path: &Path) -> Outcome<String> {
    let bytes = fs::read(path)?;
    let mut rest = bytes.get(8..).ok_or("the file is too short for an EXR")?;
    let mut attributes = Vec::new();
    loop {
        let [mut name, mut kind] = [&[][..]; 2];
        for word in [&mut name, &mut kind] {
            let end = rest.iter().position(|&byte| byte == 0).ok_or("the header has no end")?;
            (*word, rest) = (&rest[..end], &rest[end + 1..]);
            if word.is_empty() {
                break;
            }
        }
        if name.is_empty() {
            break;
        }
        let (length, after) = rest.split_first_chunk().ok_or("the header has no end")?;
        let length = u32::from_le_bytes(*length) as usize;
        let value = after.get(..length).ok_or("an attribute is longer than the file")?;
        rest = &after[length..];
        let value = if kind == b"string" { &[] } else { value };
        attributes.push([name, b" ", kind, b" ", value].concat());
    }
    attributes.sort();
    Ok(short(blake3::Hasher::new().update(&attributes.concat())))
}

/// Returns a CSV of rays from a film at `film` mm to a square of half side `reach` mm about the rear
/// element, of three wavelengths.
fn random_rays(film: f64, reach: f64) -> String {
    let mut state = 1u64;
    let mut random = |size: f64| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        size * ((state >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
    };
    let mut text = String::from("x,y,z,dx,dy,dz,wavelength_nm\n");
    for wavelength in [450, 587, 650] {
        for _ in 0..400 {
            let [x, y, u, v] = [reach, reach, reach, reach].map(&mut random);
            let [dx, dy, dz] = [u - x, v - y, -0.4 * film];
            let _ = writeln!(text, "{x},{y},{film},{dx},{dy},{dz},{wavelength}");
        }
    }
    text
}
