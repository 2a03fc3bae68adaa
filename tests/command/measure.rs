//! The command `measure`.

use std::path::Path;

use petzval_image::{BitDepth, EncodingOptions, Picture, PictureWindow};

use crate::support::{folder, petzval, root};

/// Writes an edge through the middle of a picture, sharp but for its pixels, in this slope (pixels a row).
fn write_edge(folder: &Path, name: &str, slope: f64) {
    let size = [120_usize, 90];
    let share = |x: usize, y: usize| {
        let inside = (0..256).filter(|i| {
            let at = [x as f64 + f64::from(i % 16) / 16.0, y as f64 + f64::from(i / 16) / 16.0];
            at[0] + 1.0 / 32.0 > 60.0 + slope * (at[1] + 1.0 / 32.0 - 45.0)
        });
        inside.count() as f32 / 256.0
    };
    let pixel = |i: usize| {
        let share = share(i % size[0], i / size[0]);
        // Red has no edge.
        [0.5, 0.1 + 0.7 * share, 0.1 + 0.3 * share]
    };
    let picture = Picture { size, pixels: (0..size[0] * size[1]).map(pixel).collect() };
    let window = PictureWindow { origin: [0, 0], frame: size.map(|n| n as u32) };
    let bit_depth = name.ends_with("png").then_some(BitDepth::Sixteen);
    let encoding = EncodingOptions { bit_depth, ..EncodingOptions::default() };
    let file = petzval_base::io::OutputFile::new(folder.join(name), &Default::default());
    picture.write(&file.expect("a name"), window, encoding, &Vec::new()).expect("a file");
}

#[test]
fn sharp_edges_have_the_response_of_their_pixels() {
    let folder = folder();
    let at = folder.path();
    for name in ["a.exr", "a.png", "a.tif"] {
        write_edge(at, name, 0.1);
        let region = ["--edge", "20,5,100,85", "--edge", "25,0,95,90"];
        let more = ["--json", "--channel", "green", "--csv", "sfr.csv"];
        let (code, stdout, stderr) =
            petzval(at, &[&["measure", name], &region[..], &more].concat());
        assert_eq!(code, 0, "{stderr}");
        let found: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
        for edge in found["edges"].as_array().expect("edges") {
            assert_eq!(edge["axis"], "x");
            let number = |name: &str| edge[name].as_f64().expect("a number");
            // Half of sin(pi f) / (pi f).
            assert!((number("mtf50") - 0.6034).abs() < 0.02, "{name}: {edge}");
            assert!((number("slant_degrees").abs() - 5.71).abs() < 0.05, "{name}: {edge}");
            assert!((number("contrast") - 0.7 / 0.9).abs() < 1e-3, "{name}: {edge}");
            let response = edge["response"][25].as_f64().expect("a number");
            assert!((response - 0.9003).abs() < 0.006, "{name}: {response}");
        }
        let table = std::fs::read_to_string(at.join("sfr.csv")).expect("a table");
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!((lines[0], lines.len()), ("cycles/pixel,edge 1,edge 2", 102));
        assert!(lines[1].starts_with("0.00,1.0000,1.0000"), "{}", lines[1]);
    }
    let (code, stdout, _) =
        petzval(at, &["measure", "a.exr", "--edge", "20,5,100,85", "--pixel", "5um"]);
    assert_eq!(code, 0);
    assert!(
        stdout.contains("frequencies along x, slant 5.7") && stdout.contains(" cycles/mm)"),
        "{stdout}"
    );
    assert!(stdout.lines().any(|line| line.starts_with("0.50")), "{stdout}");
}

#[test]
fn what_cannot_be_measured_ends_with_exit_code_2_and_advice() {
    let folder = folder();
    let at = folder.path();
    write_edge(at, "a.exr", 0.1);
    write_edge(at, "straight.exr", 0.0);
    for (arguments, expected) in [
        ("a.exr", "--edge"),
        ("a.exr --edge 20,5,100", "four whole numbers"),
        ("a.exr --edge 20,5,121,85", "has 120 x 90 pixels; expected X0,Y0,X1,Y1 within it"),
        ("a.exr --edge 20,5,20,85", "expected X0,Y0,X1,Y1 within it"),
        ("a.exr --edge 20,5,30,85", "expected at least 20 x 20"),
        ("a.exr --edge 0,5,40,85", "has no edge"),
        ("a.exr --edge 20,5,100,85 --channel red", "has no edge"),
        ("a.exr --edge 20,5,100,85 --pixel 0", "expected a pitch"),
        ("a.exr --edge 20,5,100,85 --csv a.exr", "a.exr"),
        ("a.exr --edge 20,5,66,85", "choose a wider region"),
        ("straight.exr --edge 20,5,100,85", "slant the chart"),
        ("none.exr --edge 20,5,100,85", "none.exr"),
    ] {
        let words: Vec<&str> = ["measure"].into_iter().chain(arguments.split(' ')).collect();
        let (code, _, stderr) = petzval(at, &words);
        assert_eq!(code, 2, "{arguments}: {stderr}");
        assert!(stderr.contains(expected), "{arguments}: {stderr}");
    }
}

/// Renders uniform light of these values as raw files, two of each and 16 of none and of 0.25, and writes their list
/// with 80000 photons for the value 1.
fn photograph_uniform_light(at: &Path, sensor: &str, values: &[f64]) {
    let mut list = "n 14 400 400\n".to_owned();
    let mut seed = 0;
    for &value in [0.0].iter().chain(values) {
        let scene = format!(
            r#"Film "rgb" "integer xresolution" 400 "integer yresolution" 400
               Sampler "independent" "integer pixelsamples" 1
               Integrator "path" "integer maxdepth" 1
               Camera "perspective" "float fov" 40
               WorldBegin
               LightSource "infinite" "rgb L" [{value} {value} {value}]"#
        );
        std::fs::write(at.join("uniform.pbrt"), scene).expect("a scene");
        list += &match value {
            0.0 => "d 1e7\n".to_owned(),
            _ => format!("b 1e7 {}\n", 80_000.0 * value),
        };
        for _ in 0..if [0.0, 0.25].contains(&value) { 16 } else { 2 } {
            seed += 1;
            let (name, seed) = (format!("{seed}.dng"), seed.to_string());
            let more = ["--bayer", "--sensor", sensor, "--seed", &seed, "-q"];
            let arguments = [&["render", "uniform.pbrt", "-o", &name], &more[..]].concat();
            let (code, _, stderr) = petzval(at, &arguments);
            assert_eq!(code, 0, "{stderr}");
            list += &format!("i {name}\n");
        }
    }
    std::fs::write(at.join("list.txt"), list).expect("a list");
}

/// The loop of sensor, raw files and measurement: EMVA 1288.
#[test]
fn pictures_of_uniform_light_give_back_the_parameters_of_their_sensor() {
    let folder = folder();
    let at = folder.path();
    // At half of the base speed, 20000 electrons fill the well at half of the codes: at the value 0.5.
    let sensor = "iso=50,well=20000,read=4,dsnu=3,prnu=1,bits=14,black=1024";
    let mut values: Vec<f64> = (1..=18).map(|i| f64::from(i) / 40.0).collect();
    values.extend([0.48, 0.49, 0.495, 0.5, 0.51, 0.6]);
    photograph_uniform_light(at, sensor, &values);
    let (code, stdout, stderr) =
        petzval(at, &["measure", "noise", "list.txt", "--json", "--csv", "curve.csv"]);
    assert_eq!(code, 0, "{stderr}");
    let found: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
    let found = found["channels"].as_array().expect("channels").clone();
    let names: Vec<_> = found.iter().map(|channel| channel["channel"].as_str()).collect();
    assert_eq!(names, ["red", "green/red", "green/blue", "blue"].map(Some));
    let gain = (16383.0 - 1024.0) / 40_000.0;
    for (name, part, expected, tolerance) in [
        ("gain", "", gain, 0.005),
        ("dark_mean", "", 1024.0, 1e-4),
        ("dark_noise_electrons", "total", 4.0, 0.01),
        ("dsnu_electrons", "total", 3.0, 0.02),
        ("prnu_percent", "total", 1.0, 0.02),
        ("quantum_efficiency", "", 0.5, 0.005),
        ("full_well_electrons", "", 20_000.0, 0.005),
    ] {
        let number = |channel: &serde_json::Value| match part {
            "" => channel[name].as_f64().expect(name),
            part => channel[name][part].as_f64().expect(name),
        };
        let mean = found.iter().map(number).sum::<f64>() / 4.0;
        println!(
            "{name} {mean:.5}, put in {expected:.5}: {:+.2} %",
            100.0 * (mean / expected - 1.0)
        );
        assert!((mean / expected - 1.0).abs() < tolerance, "{name} {mean}, not {expected}");
        for channel in &found {
            let off = number(channel) / expected - 1.0;
            assert!(off.abs() < 3.0 * tolerance, "{name} {off} of {}", channel["channel"]);
        }
    }
    for channel in &found {
        // The noise is largest some deviations before the well is full: 141 electrons of light, 200 of PRNU.
        let saturation = channel["saturation_electrons"].as_f64().expect("a maximum");
        assert!((18_800.0..19_900.0).contains(&saturation), "{saturation}");
        assert!(channel["linearity_error_percent"].as_f64().expect("a line") < 0.1, "{channel}");
        assert!(channel["prnu_percent"]["row"].as_f64().expect("a number") < 0.05, "{channel}");
    }
    let curve = std::fs::read_to_string(at.join("curve.csv")).expect("a table");
    assert_eq!(curve.lines().count(), 1 + 4 * 24, "{curve}");
    assert!(curve.contains("\nblue,2000,2,"), "{curve}");
    let (code, stdout, _) = petzval(at, &["measure", "noise", "list.txt"]);
    assert!(
        code == 0 && stdout.contains("24 exposures of 200 x 200 photosites a channel"),
        "{stdout}"
    );
    assert!(stdout.contains("full well (e-)"), "{stdout}");

    // A table does not replace a picture, also if it is known from the list alone.
    let (code, _, stderr) = petzval(at, &["measure", "noise", "list.txt", "--csv", "17.dng"]);
    assert!(code == 2 && stderr.contains("17.dng"), "{stderr}");

    // What cannot be evaluated.
    write_edge(at, "colour.png", 0.1);
    std::fs::write(at.join("small.png"), png_of([30, 30], 30)).expect("a file");
    std::fs::write(at.join("plain.png"), png_of([60, 60], 60)).expect("a file");
    let whole = std::fs::read(at.join("1.dng")).expect("a file");
    std::fs::write(at.join("cut.dng"), &whole[..whole.len() / 2]).expect("a file");
    for (list, expected) in [
        (
            "b 1\ni 17.dng\ni 18.dng\n",
            "list.txt:1:1: no dark pictures of 1 ns; expected a set \"d 1\"",
        ),
        ("d 1\ni 1.dng\ni 2.dng\n", "list.txt: red: no pictures with light"),
        ("d 1\ni 1.dng\ni 2.dng\nb 1\ni 1.dng\ni 2.dng\n", "expected more light"),
        (
            "d 1\ni 17.dng\ni 18.dng\nb 1\ni 1.dng\ni 2.dng\n",
            "list.txt:4:1: red: the mean of pictures with light",
        ),
        ("d 1\ni 1.dng\n", "list.txt:1:1: the set has 1 of at least 2"),
        (
            "d 1\ni 1.dng\ni gone.dng\n",
            "list.txt:3:1: cannot read the picture gone.dng: No such file",
        ),
        ("d 1\ni 1.dng\ni 1.dng\n", "list.txt:3:1: the picture is in the set already"),
        ("d 1\ni 1.dng\ni uniform.pbrt\n", ".dng, .png, .tif and .tiff"),
        ("d 1\ni 1.dng\ni cut.dng\n", "it is cut off"),
        (
            "d 1\ni 1.dng\ni plain.png\n",
            "list.txt:3:1: plain.png has 60 x 60 pixels of 8 bits without filters; expected 400 x 400 pixels of 16 bits behind the filters RGGB",
        ),
        (
            "d 1\ni small.png\ni ./small.png\n",
            "list.txt:2:1: small.png has 30 x 30 pixels; expected at least 40 x 40",
        ),
        (
            "d 1\ni plain.png\ni ./plain.png\nb 1\ni bright.png\ni ./bright.png\n",
            "the noise does not grow with the light",
        ),
        (
            "d 1\ni 1.dng\ni colour.png\n",
            "list.txt:3:1: cannot read the picture colour.png: it is a picture in colours",
        ),
        ("", "list.txt: it lists no pictures"),
        ("pictures\n", "list.txt:1:1: expected a line that begins with b, d or i"),
    ] {
        std::fs::write(at.join("bright.png"), png_of([60, 60], 200)).expect("a file");
        std::fs::write(at.join("list.txt"), list).expect("a list");
        let (code, _, stderr) = petzval(at, &["measure", "noise", "list.txt"]);
        assert_eq!(code, 2, "{list}: {stderr}");
        assert!(stderr.contains(expected), "{list}: {stderr}");
    }
}

/// Returns a grey picture of this width and height, all of one code.
fn png_of([width, height]: [u32; 2], code: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    let image = image::GrayImage::from_pixel(width, height, image::Luma([code]));
    image
        .write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png)
        .expect("an encoder");
    bytes
}

/// Draws a chart, and returns the commands that it prints: to render and to measure it.
fn draw_chart(at: &Path, kind: &str) -> Vec<Vec<String>> {
    let lens = root().join("lenses/dgauss.50mm.dat").display().to_string();
    let film = "--film-size 36x24 --resolution 600x400 --focus 2m --fstop 8";
    let scene = format!("{kind}.pbrt");
    let words = ["chart", kind, &lens].into_iter().chain(film.split(' ')).chain(["-o", &scene]);
    let (code, stdout, stderr) = petzval(at, &words.collect::<Vec<_>>());
    assert_eq!(code, 0, "{stderr}");
    let words = |line: &str| line.split(' ').map(str::to_owned).collect();
    stdout.lines().map(words).collect()
}

#[test]
fn charts_are_rendered_and_measured_by_the_commands_that_they_print() {
    let folder = folder();
    let at = folder.path();
    let run = |command: &[String], more: &[&str]| {
        assert_eq!(command[0], "petzval");
        let words: Vec<&str> =
            command[1..].iter().map(String::as_str).chain(more.iter().copied()).collect();
        let (code, stdout, stderr) = petzval(at, &words);
        assert_eq!(code, 0, "{words:?}: {stderr}");
        stdout
    };
    let [flat, edges, grid, leaves] =
        ["flat", "edges", "grid", "leaves"].map(|kind| draw_chart(at, kind));
    assert_eq!([flat.len(), edges.len(), grid.len(), leaves.len()], [2; 4]);
    // Options of the lens file are those of the render too, which has the dispersion that lateral colour is.
    let lens = root().join("lenses/double-gauss.50mm.toml").display().to_string();
    let words =
        "--film-size 36x24 --resolution 600x400 --focus 2m --wavelengths 486.1,550,656.3 -o c.pbrt";
    let words: Vec<&str> = ["chart", "flat", &lens].into_iter().chain(words.split(' ')).collect();
    let (code, stdout, stderr) = petzval(at, &words);
    assert_eq!(code, 0, "{stderr}");
    let render =
        "petzval render c.pbrt -o c.exr --effects +dispersion --wavelengths=486.1,550,656.3\n";
    assert_eq!(stdout, format!("{render}petzval measure shading c.exr\n"));
    let command: Vec<String> = render.trim().split(' ').map(str::to_owned).collect();
    run(&command, &["--spp", "1", "-q"]);
    for commands in [&flat, &edges, &grid, &leaves] {
        run(&commands[0], &["--spp", "32", "-q"]);
    }
    let levels = |stdout: &str| -> Vec<f64> {
        let found: serde_json::Value = serde_json::from_str(stdout).expect("JSON");
        let edges = found["edges"].as_array().expect("edges");
        assert_eq!(edges.len(), 18);
        edges.iter().map(|edge| edge["levels"][1].as_f64().expect("a level")).collect()
    };
    // Without the falloff, all bright sides are those of the chart.
    let spread = |levels: &[f64]| {
        let [low, high] = [
            levels.iter().copied().fold(9.0, f64::min),
            levels.iter().copied().fold(0.0, f64::max),
        ];
        high / low
    };
    let seen = levels(&run(&edges[1], &["--json"]));
    let divided = levels(&run(&edges[1], &["--json", "--flat", "flat.exr"]));
    assert!(spread(&seen) > 1.1 && spread(&divided) < 1.02, "{seen:?} {divided:?}");
    assert!(divided.iter().all(|level| (level - 0.72).abs() < 0.02), "{divided:?}");

    // Pixels of 60 um see what the lens resolves: the response is that of the pixel.
    let second: Vec<String> =
        leaves[0].iter().map(|word| word.replace("leaves.exr", "second.exr")).collect();
    run(&second, &["--spp", "32", "-q", "--seed", "5"]);
    let text = run(&leaves[1], &["--second", "second.exr", "--csv", "texture.csv"]);
    let table = std::fs::read_to_string(at.join("texture.csv")).expect("a table");
    assert_eq!([text.lines().count(), table.lines().count()], [26, 26], "{text}");
    let last = table.lines().last().expect("a row");
    let response: f64 =
        last.split(',').nth(1).expect("a response").trim().parse().expect("a number");
    assert!(last.starts_with("0.50") && (response - 0.64).abs() < 0.02, "{last}");

    let text = run(&grid[1], &["--csv", "dots.csv"]);
    assert!(text.starts_with("187 dots in 17 columns and 11 rows"), "{text}");
    let table = std::fs::read_to_string(at.join("dots.csv")).expect("a table");
    assert_eq!(table.lines().count(), 188, "{table}");
    let found: serde_json::Value = serde_json::from_str(&run(&grid[1], &["--json"])).expect("JSON");
    let percent = found["distortion_percent"].as_f64().expect("a number");
    assert!((percent + 1.25).abs() < 0.05, "{percent}");

    for (arguments, expected) in [
        ("measure grid flat.exr", "flat.exr: 0 dark dots, of which 0 x 0 form a grid"),
        ("measure grid gone.exr", "gone.exr"),
        (
            "measure texture leaves.exr --region 0,0,999,9 --chart leaves.png",
            "leaves.exr has 600 x 400 pixels",
        ),
        (
            "measure texture leaves.exr --region 0,0,50,50 --chart leaves.png",
            "50 x 50 pixels; expected at least 64 x 64",
        ),
        (
            "measure texture leaves.exr --region 0,0,99,99 --chart plain.png",
            "the chart has 30 x 30 samples",
        ),
        ("measure grid grid.exr --csv grid.exr", "grid.exr"),
        ("measure edges.exr --edge 0,0,50,50 --flat gone.exr", "gone.exr"),
        (
            "measure edges.exr --edge 0,0,50,50 --flat plain.png",
            "--flat plain.png: 30 x 30 pixels; expected 600 x 400",
        ),
        (
            "measure edges.exr --edge 0,0,50,50 --flat black.png",
            "--flat black.png: pixel 0,0 is [0.0, 0.0, 0.0]; expected light from a white chart",
        ),
    ] {
        std::fs::write(at.join("plain.png"), png_of([30, 30], 200)).expect("a file");
        std::fs::write(at.join("black.png"), png_of([600, 400], 0)).expect("a file");
        let words: Vec<&str> = arguments.split(' ').collect();
        let (code, _, stderr) = petzval(at, &words);
        assert!(code == 2 && stderr.contains(expected), "{arguments}: {stderr}");
    }
    let lens = root().join("lenses/dgauss.50mm.dat").display().to_string();
    for (arguments, expected) in [
        (
            "edges LENS --film-size 36x24 --resolution 600x400 -o a.pbrt",
            "expected a finite --focus, such as 2m",
        ),
        (
            "edges LENS --film-size 36x24 --resolution 60x40 --focus 2m -o a.pbrt",
            "at least 400 x 400 pixels",
        ),
        ("grid LENS --film-size 36x24 --resolution 600x400 --focus 2m -o gone/a.pbrt", "gone"),
        ("grid LENS --film-size 36x24 --resolution 600x400 --focus 2m -o LENS", "dgauss.50mm.dat"),
        ("grid gone.dat --film-size 36x24 --resolution 600x400 --focus 2m -o a.pbrt", "gone.dat"),
        (
            "grid LENS --film-size 36x24 --resolution 600x400 --focus 2m -o a.exr",
            "expected the name of a scene",
        ),
        ("bars LENS --film-size 36x24 --resolution 600x400 --focus 2m -o a.pbrt", "bars"),
    ] {
        let words = arguments.split(' ').map(|word| if word == "LENS" { &lens } else { word });
        let (code, _, stderr) =
            petzval(at, &["chart"].into_iter().chain(words).collect::<Vec<_>>());
        assert!(code == 2 && stderr.contains(expected), "{arguments}: {stderr}");
        assert!(!at.join("a.pbrt").exists(), "{arguments}");
    }
}
