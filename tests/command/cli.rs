//! The command line: pictures, errors and exit codes.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::support::{folder, root, write};

fn petzval(arguments: &[&str]) -> Output {
    command(arguments).output().expect("the command starts")
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
    command.args(arguments).current_dir(root()).stdin(Stdio::null());
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Asserts that the command fails with exit code 2, nothing on standard output, and this error.
fn refuses(arguments: &[&str], expected: &str) {
    let output = petzval(arguments);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    assert!(stderr.contains(expected), "{arguments:?}\n  found    {stderr}\n  expected {expected}");
    assert!(output.stdout.is_empty() && !stderr.contains("panicked"), "{arguments:?}: {stderr}");
}

fn small<'a>(output: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
    let output = output.to_str().expect("a plain path");
    let mut arguments =
        vec!["render", "scenes/dgauss.pbrt", "--resolution", "40x30", "--spp", "16"];
    arguments.extend(["-o", output]);
    arguments.extend(more);
    arguments
}

#[cfg(target_os = "linux")]
#[test]
fn help_that_cannot_be_written_is_an_error() {
    for arguments in [&["--help"][..], &["render", "--help"], &["--version"]] {
        let full = std::fs::File::options().write(true).open("/dev/full").expect("a full device");
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_petzval"));
        let output = command.args(arguments).stdout(full).output().expect("the command starts");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains("No space left"), "{stderr}");
    }
}

#[test]
fn a_scene_becomes_a_picture_with_its_attributes() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    let output = petzval(&small(&path, &["--threads", "1"]));
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(output.stdout.is_empty(), "standard output is not empty");
    for (line, expected) in stderr.lines().zip([
        "picture: 40 x 30 pixels, 16 samples a pixel; Double Gauss, 50 mm f/2, f/2.00, focus 4.01 m",
        "time:    ",
        "plan:    no effects are simulated",
        "file:    ",
        "next:    petzval view scenes/dgauss.pbrt",
    ]) {
        assert!(line.starts_with(expected), "{stderr}");
    }
    assert_eq!(stderr.lines().count(), 5, "{stderr}");
    assert!(stderr.contains("a.exr, linear light, 32-bit floats\n"), "{stderr}");
    assert!(
        !stderr.contains('\r') && !stderr.contains('\u{1b}'),
        "a progress bar without a terminal: {stderr:?}"
    );

    let meta = exr::meta::MetaData::read_from_file(&path, true).unwrap();
    let own = &meta.headers[0].own_attributes;
    assert!((own.aperture.unwrap() - 2.003).abs() < 1e-3);
    assert!((own.focus.unwrap() - 4.0097).abs() < 1e-3);
    assert_eq!(own.iso_speed, Some(100.0));
    assert!(own.software_name.as_ref().unwrap().to_string().starts_with("petzval "));
    let number = |name: &str| match own.other.get(&exr::meta::attribute::Text::from(name)) {
        Some(exr::meta::attribute::AttributeValue::F32(v)) => *v,
        other => panic!("{name}: {other:?}"),
    };
    assert!((number("effectiveFocalLength") - 50.008).abs() < 1e-3);
    assert!((number("filmDistance") - 36.306).abs() < 1e-3);
    assert_eq!([number("samplesPerPixel"), number("seed")], [16.0, 0.0]);
    let attribute = |name: &str| match own.other.get(&exr::meta::attribute::Text::from(name)) {
        Some(exr::meta::attribute::AttributeValue::Text(v)) => v.to_string(),
        other => panic!("{name}: {other:?}"),
    };
    assert_eq!(attribute("lensModel"), "Double Gauss, 50 mm f/2");
    assert!(attribute("commandLine").contains("--resolution 40x30 --spp 16"));
}

#[test]
fn a_png_and_a_jpeg_look_like_the_exr() {
    let folder = folder();
    let read = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        assert!(petzval(&small(&path, more)).status.success());
        petzval_image::Picture::read(&path).unwrap()
    };
    let exr = read("a.exr", &[]);
    let half = read("half.exr", &["--half"]);
    let png = read("a.png", &["--exposure", "0"]);
    let jpeg = read("a.jpg", &["--exposure", "0"]);
    let brighter = read("b.png", &["--exposure", "-1"]);
    let auto = read("c.png", &["--exposure", "auto"]);
    let code = |v: f32| petzval_image::srgb_encode(v) * 255.0;
    let (mut jpeg_off, mut white) = (0.0, 0);
    for (i, pixel) in exr.pixels.iter().enumerate() {
        for (c, &linear) in pixel.iter().enumerate() {
            // The PNG holds the nearest code, at most half a code off.
            assert!((code(png.pixels[i][c]) - code(linear)).abs() <= 0.51, "pixel {i}");
            assert!((code(brighter.pixels[i][c]) - code(linear / 2.0)).abs() <= 0.51, "pixel {i}");
            assert!((half.pixels[i][c] - linear).abs() <= linear * 1e-3 + 1e-7, "pixel {i}");
            jpeg_off += (code(jpeg.pixels[i][c]) - code(linear)).abs();
        }
        white += usize::from(auto.pixels[i].iter().all(|&v| v > 0.99));
    }
    assert!(
        jpeg_off / (3.0 * exr.pixels.len() as f32) < 4.0,
        "the JPEG differs by {jpeg_off} in all"
    );
    assert!(white > 0 && white < exr.pixels.len() / 20, "{white} white pixels");
    // The sRGB chunk tells viewers the colour space.
    let bytes = std::fs::read(folder.path().join("a.png")).unwrap();
    assert!(bytes.windows(4).any(|w| w == b"sRGB"));
}

#[test]
fn verbose_prints_tables_quiet_nothing_and_lines_fit_the_terminal() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    let run = |more: &[&str], columns: &str| {
        let output = command(&small(&path, more)).env("COLUMNS", columns).output().unwrap();
        assert!(output.status.success());
        text(&output.stderr)
    };
    let all = run(&["-v"], "200");
    for expected in ["ns/sample", "intersect", "% of the rays leave the lens", "memory: ", "next: "]
    {
        assert!(all.contains(expected), "{expected}: {all}");
    }
    assert_eq!(run(&["--quiet"], "200"), "");
    let narrow = run(&[], "60");
    // Words, such as the name of the file, are not broken.
    let wide = |line: &&str| line.chars().count() > 60 && !line.contains(".exr");
    assert_eq!(narrow.lines().find(wide), None, "{narrow}");
    assert!(narrow.lines().count() > 5, "{narrow}");
    let plan = |columns: &str| {
        let output = command(&["plan", "scenes/dgauss.pbrt"]).env("COLUMNS", columns).output();
        text(&output.unwrap().stdout)
    };
    for columns in [60, 100, 120] {
        let table = plan(&columns.to_string());
        let wide = |line: &&str| line.chars().count() > columns.max(68);
        assert_eq!(table.lines().find(wide), None, "{table}");
        assert!(table.contains(" ms ") || table.contains(" s "), "{table}");
    }
    // Errors are printed in any case.
    let output = petzval(&["render", "no.pbrt", "--quiet"]);
    assert!(text(&output.stderr).contains("cannot read no.pbrt"));
}

#[test]
fn the_automatic_exposure_is_printed_and_stored_to_lock_a_series() {
    let folder = folder();
    let path = folder.path().join("a.png");
    let output = petzval(&small(&path, &[]));
    let stderr = text(&output.stderr);
    let found = stderr.split("; --exposure=").nth(1).expect("an exposure");
    let stops = found.split(' ').next().expect("a number");
    let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
    let reader = reader.read_info().unwrap();
    let notes = &reader.info().utf8_text;
    let stored = notes.iter().find(|note| note.keyword == "displayExposure").expect("a note");
    let stored: f64 = stored.get_text().unwrap().parse().unwrap();
    assert!((stored - stops.parse::<f64>().unwrap()).abs() <= 0.0051, "{stored}: {stderr}");
    let again = folder.path().join("b.png");
    let output = petzval(&small(&again, &["--exposure", &format!("{stops}EV")]));
    assert!(output.status.success(), "{}", text(&output.stderr));
    let [one, other] =
        [&path, &again].map(|path| petzval_image::Picture::read(path).unwrap().pixels);
    let far = one.iter().zip(&other).filter(|(a, b)| (a[1] - b[1]).abs() > 0.02).count();
    assert_eq!(far, 0, "the locked picture is as bright");
    let filmic = folder.path().join("c.png");
    assert!(petzval(&small(&filmic, &["--tone", "filmic"])).status.success());
    let filmic = petzval_image::Picture::read(&filmic).unwrap().pixels;
    let clipped = |pixels: &[[f32; 3]]| pixels.iter().filter(|p| p.contains(&1.0)).count();
    assert!(clipped(&filmic) < clipped(&one), "{} and {}", clipped(&filmic), clipped(&one));
    refuses(&small(&again, &["--tone", "log"]), "expected linear or filmic");
}

/// Returns the notes of a PNG by name, or those of a JPEG from its comments.
fn stored_notes(path: &Path) -> std::collections::BTreeMap<String, String> {
    if path.extension().is_some_and(|extension| extension == "png") {
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let reader = png::Decoder::new(file).read_info().unwrap();
        let notes = &reader.info().utf8_text;
        return notes.iter().map(|n| (n.keyword.clone(), n.get_text().unwrap())).collect();
    }
    let bytes = std::fs::read(path).unwrap();
    let (mut notes, mut at) = (std::collections::BTreeMap::new(), 2);
    // Segments up to the start of the scan.
    while bytes[at + 1] != 0xda {
        let length = usize::from(u16::from_be_bytes([bytes[at + 2], bytes[at + 3]]));
        if bytes[at + 1] == 0xfe {
            let comment = text(&bytes[at + 4..at + 2 + length]);
            let (name, value) = comment.split_once(": ").expect("a name");
            notes.insert(name.to_owned(), value.to_owned());
        }
        at += 2 + length;
    }
    notes
}

#[test]
fn a_jpeg_stores_what_a_png_stores() {
    let folder = folder();
    let [png, jpeg] = ["a.png", "a.jpg"].map(|name| {
        let path = folder.path().join(name);
        assert!(petzval(&small(&path, &[])).status.success());
        assert_eq!(petzval_image::Picture::read(&path).unwrap().size, [40, 30]);
        stored_notes(&path)
    });
    assert!(png.contains_key("displayExposure") && png.contains_key("lensModel"), "{png:?}");
    for (name, value) in png.iter().filter(|(name, _)| *name != "commandLine") {
        assert_eq!(jpeg.get(name), Some(value), "{name}");
    }
}

#[test]
fn white_balance_makes_a_grey_card_neutral_and_can_be_locked() {
    let folder = folder();
    let render = |kelvin: u32, name: &str, more: &[&str]| {
        let scene = format!(
            "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16
             Sampler \"sobol\" \"integer pixelsamples\" 16
             Camera \"perspective\" \"float fov\" 20 WorldBegin
             LightSource \"infinite\" \"blackbody L\" {kelvin} \"float illuminance\" 3
             Material \"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]
             Translate 0 0 2 Shape \"disk\" \"float radius\" 5"
        );
        let scene = write(&folder, "card.pbrt", scene);
        let path = folder.path().join(name);
        let mut arguments = vec!["render", scene.to_str().unwrap(), "-o", path.to_str().unwrap()];
        arguments.extend(more);
        let output = petzval(&arguments);
        let stderr = text(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {stderr}");
        let picture = petzval_image::Picture::read(&path).unwrap();
        let codes = picture.pixels[8 * 16 + 8].map(|v| petzval_image::srgb_encode(v) * 255.0);
        (codes, stderr)
    };
    let neutral = |codes: [f32; 3]| {
        let [low, high] = [f32::min, f32::max].map(|of| codes.into_iter().reduce(of).unwrap());
        assert!(low > 60.0 && high < 250.0, "{codes:?}");
        high - low <= 2.0
    };
    for name in ["a.png", "a.jpg"] {
        assert!(!neutral(render(3200, name, &["--exposure", "0"]).0));
        assert!(neutral(render(3200, name, &["--exposure=0", "--white-balance", "3200K"]).0));
        let (codes, stderr) = render(3200, name, &["--exposure=0", "--white-balance", "auto"]);
        assert!(neutral(codes), "{codes:?}");
        let white = stderr.split("--white-balance=").nth(1).expect("a white").split(' ').next();
        let white = white.expect("a white");
        let stored = stored_notes(&folder.path().join(name));
        assert_eq!(stored.get("displayWhite").map(String::as_str), Some(white));
        let locked = ["--exposure=0", "--white-balance", white];
        assert_eq!(render(3200, name, &locked).0, codes, "{white}");
        let plain = render(6504, name, &["--exposure", "0"]).0;
        for light in ["D65", "6500K"] {
            let daylight = render(6504, name, &["--exposure=0", "--white-balance", light]).0;
            let off = [0, 1, 2].map(|c| (plain[c] - daylight[c]).abs()).into_iter();
            assert!(off.fold(0.0, f32::max) <= 1.01, "{light}: {plain:?} and {daylight:?}");
        }
    }
    let path = folder.path().join("b.png");
    for bad in ["12K", "cool", "0.3", "0.9,0.9", "nan,nan", "D66", "1e9K"] {
        refuses(&small(&path, &["--white-balance", bad]), "expected a temperature");
    }
    refuses(&small(&path, &["--bayer", "--white-balance", "D50"]), "has no colours yet");
}

#[test]
fn an_opacity_is_written_to_exr_and_png_and_refused_elsewhere() {
    let folder = folder();
    let [png, jpeg] = ["a.png", "a.jpg"].map(|name| folder.path().join(name));
    let output = petzval(&small(&png, &["--aov", "alpha"]));
    assert!(output.status.success(), "{}", text(&output.stderr));
    let file = std::io::BufReader::new(std::fs::File::open(&png).unwrap());
    let colour = png::Decoder::new(file).read_info().unwrap().info().color_type;
    assert_eq!(colour, png::ColorType::Rgba);
    refuses(
        &small(&jpeg, &["--aov", "alpha"]),
        "only EXR holds layers, PNG and TIFF the layer alpha",
    );
    refuses(&small(&png, &["--aov", "alpha,depth"]), "only EXR holds layers");
}

#[test]
fn a_quantity_with_its_unit_means_the_same_in_every_command() {
    let folder = folder();
    let pixels = |more: &[&str]| {
        let path = folder.path().join("unit.exr");
        let output = petzval(&small(&path, more));
        assert!(output.status.success(), "{more:?}: {}", text(&output.stderr));
        petzval_image::Picture::read(&path).unwrap().pixels
    };
    let plain = pixels(&["--focus", "2", "--fstop", "8", "--film-diagonal", "30"]);
    let units = pixels(&["--focus", "2000mm", "--fstop", "f/8", "--film-diagonal", "3cm"]);
    assert!(plain == units, "2 is 2 m, 8 is f/8, and 30 is 30 mm");
    let plan = |more: &[&str]| {
        let output = petzval(&[&["plan", "scenes/dgauss.pbrt", "--json"], more].concat());
        assert!(output.status.success(), "{more:?}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    assert_eq!(
        plan(&["--focus", "0.85", "--shutter", "time=1/60"]),
        plan(&["--focus", "85cm", "--shutter", "time=1/60s"])
    );
    let lens = |more: &[&str]| {
        let output = petzval(&[&["lens", "lenses/dgauss.50mm.dat"], more].concat());
        assert!(output.status.success(), "{more:?}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    assert_eq!(lens(&["--focus", "2", "--stop", "8"]), lens(&["--focus", "2m", "--stop", "8mm"]));
    assert_eq!(lens(&["--fstop", "4"]), lens(&["--fstop", "f/4"]));
    assert!(lens(&["--fstop", "4"]).contains("f-number, marginal ray            4.0000"));
    // A distance that was meant in mm is not taken in metres.
    for command in ["lens", "lens report", "lens tolerance", "lens calibrate"] {
        let mut words: Vec<&str> = command.split(' ').collect();
        words.extend(["lenses/dgauss.50mm.dat", "--focus", "2000"]);
        refuses(&words, "a number alone is in metres; write 2000mm, or 2000m");
    }
    refuses(&small(&folder.path().join("a.exr"), &["--focus", "2kg"]), "such as 2m or 850mm");
    refuses(&small(&folder.path().join("a.exr"), &["--fstop", "8mm"]), "such as 2.8 or f/2.8");
}

#[test]
fn short_help_is_short_and_options_stand_in_groups() {
    let help = |flag: &str| text(&petzval(&["render", flag]).stdout);
    let [short, long] = ["-h", "--help"].map(help);
    for heading in ["Picture:", "Lens:", "Camera:", "Effects:", "Large jobs:", "Messages:"] {
        for text in [&short, &long] {
            assert_eq!(
                text.lines().filter(|line| *line == heading).count(),
                1,
                "{heading}: {text}"
            );
        }
    }
    let lines = [&short, &long].map(|text| text.lines().count());
    assert!(2 * lines[0] < lines[1], "{lines:?}");
    assert!(long.contains("A number alone is in metres") && !short.contains("in metres"));
}

#[test]
fn a_lens_for_a_small_film_says_so_and_offers_a_film_that_it_fills() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    let run = |more: &[&str]| {
        let output = petzval(&small(&path, more));
        assert!(output.status.success(), "{more:?}: {}", text(&output.stderr));
        text(&output.stderr)
    };
    let stderr = run(&["--lens", "lenses/phone.toml"]);
    let offered = stderr.split("--film-diagonal ").nth(1).expect("an offer");
    let offered = offered.split(' ').next().expect("a length");
    let fitted = run(&["--lens", "lenses/phone.toml", "--film-diagonal", offered]);
    assert!(!fitted.contains("--film-diagonal"), "{fitted}");
    let picture = petzval_image::Picture::read(&path).unwrap();
    // The sky of the scene is black, and its ground is not.
    assert!(picture.pixels[40 * 29][1] > 0.0, "the lower left corner is black");
    assert!(!run(&["--lens", "lenses/dgauss.50mm.dat"]).contains("--film-diagonal"));
}

#[test]
fn a_crop_knows_where_it_lies() {
    let folder = folder();
    let path = folder.path().join("crop.exr");
    assert!(petzval(&small(&path, &["--crop", "4,6,20,21"])).status.success());
    let meta = exr::meta::MetaData::read_from_file(&path, true).unwrap();
    let header = &meta.headers[0];
    assert_eq!((header.layer_size.0, header.layer_size.1), (16, 15));
    let position = header.own_attributes.layer_position;
    assert_eq!((position.0, position.1), (4, 6));
    let display = header.shared_attributes.display_window;
    assert_eq!((display.size.0, display.size.1), (40, 30));
}

#[test]
fn errors_end_with_exit_code_2_and_advice() {
    let folder = folder();
    let out = folder.path().join("x.exr");
    let out = out.to_str().unwrap();
    refuses(&["render", "scenes/no.pbrt", "-o", out], "cannot read scenes/no.pbrt");
    refuses(&["render", "scenes", "-o", out], "cannot read scenes");
    refuses(&["render", "scenes/dgauss.pbrt", "-o", "x.webp"], "known are .exr, .png, .jpg");
    let render = |more: &[&'static str]| [&["render", "scenes/dgauss.pbrt"], more].concat();
    refuses(&render(&["-o", "x.dng"]), "x.dng: DNG holds the mosaic of a sensor; add --bayer");
    refuses(&render(&["-o", "x.dng", "--sensor"]), "add --bayer, or name a picture.exr or .tif");
    for (name, bits, problem) in [
        ("x.jpg", "16", "x.jpg: --bit-depth is for PNG, and this file has 8 bits"),
        ("x.tif", "8", "x.tif: --bit-depth is for PNG, and this file has 16 bits"),
        ("x.exr", "16", "--bit-depth is for PNG, and this file has floats"),
        ("x.png", "12", "expected 8 or 16"),
    ] {
        refuses(&render(&["-o", name, "--bit-depth", bits]), problem);
    }
    refuses(&["render", "scenes/dgauss.pbrt", "-o", "no/such/x.exr"], "name another file with -o");
    refuses(&["render", "scenes/dgauss.pbrt", "-o", folder.path().to_str().unwrap()], "");
    refuses(
        &["render", "scenes/dgauss.pbrt", "-o", out, "--lens", "no.dat"],
        "cannot read the lens",
    );
    refuses(&["render", "scenes/dgauss.pbrt", "-o", out, "--lens", "README.md"], "README.md:");
    refuses(&["render", "scenes/dgauss.pbrt", "-o", out, "--crop", "9,9,9,9"], "leaves nothing");
    refuses(&["render", "scenes/dgauss.pbrt", "-o", out, "--crop", "0,0,301,9"], "leaves nothing");
    refuses(&["render", "scenes/dgauss.pbrt", "-o", out, "--crop", "a"], "four whole numbers");
    refuses(&["render", "scenes/dgauss.pbrt", "-o", out, "--resolution", "0x9"], "expected WxH");
    refuses(
        &["render", "scenes/dgauss.pbrt", "-o", out, "--resolution", "99999x9"],
        "expected WxH",
    );
    refuses(&["render", "scenes/dgauss.pbrt", "-o", out, "--spp", "0"], "--spp");
    refuses(&["render", "scenes/dgauss.pbrt", "-o", out, "--exposure", "x"], "expected stops");
    refuses(&["render", "scenes/dgauss.pbrt", "-o", out, "--threads", "0"], "--threads");
    refuses(
        &["render", "scenes/dgauss.pbrt", "-o", out, "--resolution", "65536x65536"],
        "is too large; render it in parts",
    );
    let pinhole = "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"";
    let pinhole = write(&folder, "pinhole.pbrt", pinhole);
    let pinhole = pinhole.to_str().unwrap();
    refuses(
        &["render", pinhole, "-o", out, "--lens", "lenses/wide.22mm.dat"],
        "pinhole.pbrt:1:1: --lens is given, but this camera has no lens file",
    );
    refuses(&["render", pinhole, "-o", out, "--fstop", "8"], "--fstop is given, but this camera");
    refuses(
        &["render", "scenes/dgauss.pbrt", "-o", out, "--fstop", "1.4"],
        "Double Gauss, 50 mm f/2 opens to f/2.00 and no wider",
    );
    refuses(&["render", "scenes/dgauss.pbrt", "-o", out, "--fstop", "inf"], "an f-number such as");
    refuses(&["render", "scenes/dgauss.pbrt", "-o", out, "--focus", "-1"], "a distance above 0");
    refuses(
        &["render", "scenes/dgauss.pbrt", "-o", out, "--focus", "0.1"],
        "the lens cannot focus at 100.0000 mm from the film; the nearest it can is",
    );
    refuses(&["render", "/dev/zero", "-o", out], "cannot read /dev/zero: it is a device");
    for length in ["nan", "-3", "0", "x"] {
        refuses(
            &["lens", "lenses/dgauss.50mm.dat", "--focus", length],
            "expected a distance above 0 such as 2m or 850mm (a number alone is in m), or inf",
        );
        refuses(
            &["lens", "lenses/dgauss.50mm.dat", "--film-distance", length],
            "expected a length",
        );
    }
    refuses(&["rendr"], "unrecognized subcommand");
    refuses(&["lens", "no.dat"], "cannot read the lens no.dat");
    refuses(&["lens", "lenses/dgauss.50mm.dat", "--stop", "18"], "at most 17.1 mm");
    refuses(&["lens", "lenses/dgauss.50mm.dat", "--focus", "10mm"], "the nearest it can is");
    assert!(!Path::new(out).exists());
    let near = std::fs::read_to_string(root().join("scenes/dgauss.pbrt")).unwrap();
    let near = near
        .replace("4.0097476", "0.05")
        .replace("../lenses", &format!("{}/lenses", root().display()));
    write(&folder, "cones.pbrt", "");
    let near = write(&folder, "near.pbrt", near);
    refuses(&["render", near.to_str().unwrap(), "-o", out], "the lens cannot focus at 50.0000 mm");
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_without_permission_is_named_before_the_render() {
    // Root may write to any folder but those of /proc.
    refuses(&["render", "scenes/dgauss.pbrt", "-o", "/proc/petzval.exr"], "cannot write /proc");
}

#[test]
fn an_existing_picture_survives_an_error() {
    let folder = folder();
    let path = write(&folder, "old.exr", "precious");
    let mut arguments = small(&path, &[]);
    arguments[1] = "scenes/no.pbrt";
    assert_eq!(petzval(&arguments).status.code(), Some(2));
    assert_eq!(std::fs::read(&path).unwrap(), b"precious");
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(names.len(), 1, "no temporary files stay behind");
}

#[cfg(target_os = "linux")]
#[test]
fn warnings_that_cannot_be_written_do_not_stop_the_render() {
    let folder = folder();
    let scene = "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
                 Camera \"perspective\"\nOption \"bool forcediffuse\" true\nWorldBegin\nLightSource \"infinite\"";
    let scene = write(&folder, "warns.pbrt", scene);
    let out = folder.path().join("a.exr");
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let status = command(&["render", scene.to_str().unwrap(), "-o", out.to_str().unwrap()])
        .stderr(full)
        .status()
        .unwrap();
    assert_eq!(status.code(), Some(0));
    assert!(out.exists());
}

#[test]
fn a_picture_replaces_an_older_one_in_one_step() {
    let folder = folder();
    let path = write(&folder, "old.exr", "precious");
    // A hard link to the old file keeps its content: the file itself is not written to.
    let link = folder.path().join("link");
    std::fs::hard_link(&path, &link).unwrap();
    assert!(petzval(&small(&path, &[])).status.success());
    assert_eq!(std::fs::read(&link).unwrap(), b"precious");
    assert!(std::fs::read(&path).unwrap().len() > 1000);
}

#[test]
fn the_lens_command_prints_a_report() {
    let output =
        petzval(&["lens", "lenses/dgauss.50mm.dat", "--film-distance", "36.77", "--focus", "inf"]);
    let stderr = text(&output.stdout);
    assert!(output.status.success());
    for expected in
        ["29.4750", "stop", "50.3582 mm", "2.0302", "36.1059 mm", "3845.7717 mm", "24.8051"]
    {
        assert!(stderr.contains(expected), "{expected} is not in\n{stderr}");
    }
}

#[test]
fn a_black_picture_comes_with_a_reason() {
    let folder = folder();
    let scene = "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
                 Camera \"perspective\"\nWorldBegin\nTranslate 0 0 3 Shape \"sphere\"";
    let scene = write(&folder, "dark.pbrt", scene);
    let out = folder.path().join("dark.exr");
    let output = petzval(&["render", scene.to_str().unwrap(), "-o", out.to_str().unwrap()]);
    assert!(output.status.success());
    let stderr = text(&output.stderr);
    assert!(stderr.contains("the picture is black: the scene has no light"), "{stderr}");
}

const ADVICE: &str = "RUSTFLAGS=\"-C target-cpu=x86-64\" cargo build --release";

#[test]
fn an_old_cpu_ends_with_advice() {
    let output = command(&["--version"]).env("PETZVAL_PRETEND_OLD_CPU", "1").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains(ADVICE));
}

#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[test]
#[ignore = "needs qemu-x86_64, in Debian's qemu-user; .ci/run runs it"]
fn an_emulated_old_cpu_ends_with_advice() {
    for cpu in ["core2duo", "Nehalem", "IvyBridge"] {
        let output = Command::new("qemu-x86_64")
            .args(["-cpu", cpu, env!("CARGO_BIN_EXE_petzval"), "--version"])
            .output()
            .expect("qemu-x86_64 is installed");
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{cpu}: {stderr}");
        assert!(stderr.contains(ADVICE), "{cpu}: {stderr}");
    }
}

#[cfg(target_arch = "x86_64")]
#[test]
fn only_a_build_without_avx2_says_that_it_is_slow() {
    let lens = root().join("lenses/dgauss.50mm.dat");
    let stderr = text(&petzval(&["lens", lens.to_str().unwrap()]).stderr);
    let notices = stderr.lines().filter(|line| line.contains("portable build")).count();
    assert_eq!(notices, usize::from(cfg!(not(target_feature = "avx2"))), "{stderr}");
}

#[test]
fn a_stage_without_rays_has_no_time_per_ray() {
    let folder = folder();
    let lens = root().join("lenses/dgauss.50mm.dat").display().to_string();
    let scene = format!(
        "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\
         Camera \"realistic\" \"string lensfile\" \"{lens}\"\n\
         WorldBegin LightSource \"infinite\" \"rgb L\" [1 1 1]"
    );
    let scene = write(&folder, "sky.pbrt", scene);
    let out = folder.path().join("sky.exr");
    let run = petzval(&["render", scene.to_str().unwrap(), "-v", "-o", out.to_str().unwrap()]);
    let log = String::from_utf8(run.stderr).unwrap();
    let line = log.lines().find(|line| line.starts_with("occlude ")).expect("a stage");
    let cells: Vec<&str> = line.split_whitespace().collect();
    assert_eq!([cells[1], cells[4]], ["0", "-"], "{line}");
}
