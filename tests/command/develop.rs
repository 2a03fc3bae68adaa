//! The command `develop`.

use petzval_image::{Picture, RawFile, WhiteBalance};

use crate::support::{folder, petzval, root, write};

/// A camera that looks at a plane of three colours.
const SCENE: &str = r#"
    Film "rgb" "integer xresolution" 48 "integer yresolution" 32
    Sampler "independent" "integer pixelsamples" 4
    PixelFilter "box"
    Camera "orthographic" "float screenwindow" [0 3 0 2]
    WorldBegin
    LightSource "infinite" "rgb L" [1 1 1]
    Material "diffuse" "rgb reflectance" [0.7 0.3 0.1]
    Shape "trianglemesh" "point3 P" [0 0 1 1 0 1 1 2 1 0 2 1] "integer indices" [0 1 2 0 2 3]
    Material "diffuse" "rgb reflectance" [0.2 0.5 0.3]
    Shape "trianglemesh" "point3 P" [1 0 1 2 0 1 2 2 1 1 2 1] "integer indices" [0 1 2 0 2 3]
    Material "diffuse" "rgb reflectance" [0.4 0.4 0.9]
    Shape "trianglemesh" "point3 P" [2 0 1 3 0 1 3 2 1 2 2 1] "integer indices" [0 1 2 0 2 3]
"#;
const QUIET: &str = "iso=100,well=1e9,read=0,bits=16";

#[test]
fn a_developed_picture_is_that_of_the_sensor() {
    let folder = folder();
    let at = folder.path();
    write(&folder, "a.pbrt", SCENE);
    for pattern in ["rggb", "bggr", "grbg", "gbrg"] {
        let bayer = format!("--bayer={pattern}");
        let raw =
            petzval(at, &["render", "a.pbrt", "-q", "-o", "a.dng", &bayer, "--sensor", QUIET]);
        assert_eq!(raw.0, 0, "{}", raw.2);
        let picture = petzval(at, &["render", "a.pbrt", "-q", "-o", "a.exr", "--sensor", QUIET]);
        assert_eq!(picture.0, 0, "{}", picture.2);
        let (code, _, stderr) = petzval(at, &["develop", "a.dng", "-o", "b.exr"]);
        assert_eq!(code, 0, "{stderr}");
        assert!(
            stderr.contains("b.exr: 48 x 32 pixels, white is light of 0.3127,0.3290"),
            "{stderr}"
        );
        let [found, expected] =
            ["b.exr", "a.exr"].map(|name| Picture::read(&at.join(name)).unwrap());
        for (i, (a, b)) in found.pixels.iter().zip(&expected.pixels).enumerate() {
            // Away from the borders of the colours; readings have photon noise.
            if (4..12).contains(&(i % 16)) {
                let off = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
                assert!(off < 1e-3, "{pattern} {i}: {a:?}, not {b:?}");
            }
        }
    }
    // Linear light has no tone.
    let (_, _, stderr) =
        petzval(at, &["develop", "a.dng", "-o", "c.exr", "--tone", "filmic", "--half"]);
    assert!(stderr.contains("--exposure and --tone are for PNG"), "{stderr}");
    let (code, _, stderr) =
        petzval(at, &["develop", "a.dng", "-o", "c.jpg", "--exposure", "auto", "--half"]);
    assert!(
        code == 0 && stderr.contains("exposure ") && stderr.contains("--half is for EXR"),
        "{stderr}"
    );
    let warm = ["develop", "a.dng", "-o", "warm.exr", "--white-balance", "auto"];
    let (code, _, stderr) = petzval(at, &warm);
    assert_eq!(code, 0, "{stderr}");
    // The mean of the three colours is grey.
    let warm = Picture::read(&at.join("warm.exr")).unwrap();
    let means = [0, 1, 2].map(|c| warm.pixels.iter().map(|pixel| pixel[c]).sum::<f32>());
    assert!((0..3).all(|c| (means[c] / means[1] - 1.0).abs() < 0.02), "{means:?}");
    // Files for display have the exposure and the tone that are asked for.
    let (code, _, stderr) = petzval(
        at,
        &[
            "develop",
            "a.dng",
            "-o",
            "b.png",
            "--exposure",
            "1",
            "--bit-depth",
            "16",
            "--tone",
            "linear",
        ],
    );
    assert_eq!(code, 0, "{stderr}");
    let [display, linear] = ["b.png", "b.exr"].map(|name| Picture::read(&at.join(name)).unwrap());
    for (a, b) in display.pixels.iter().zip(&linear.pixels) {
        let off = (0..3).map(|c| (a[c] - (2.0 * b[c]).clamp(0.0, 1.0)).abs()).fold(0.0, f32::max);
        assert!(off < 1e-4, "{a:?} and {b:?}");
    }
}

#[test]
fn saturated_photosites_are_white() {
    let folder = folder();
    let at = folder.path();
    let bright = SCENE.replace("[1 1 1]", "[6 6 6]").replace(
        "\"integer yresolution\" 32",
        "\"integer yresolution\" 32 \"string sensor\" \"nikon_d850\"",
    );
    write(&folder, "a.pbrt", &bright);
    let raw = petzval(at, &["render", "a.pbrt", "-q", "-o", "a.dng", "--bayer", "--sensor", QUIET]);
    assert_eq!(raw.0, 0, "{}", raw.2);
    let raw = RawFile::read(&at.join("a.dng"), &Default::default()).unwrap();
    let pixel = raw.develop(WhiteBalance::Off).unwrap().picture.pixels[48 * 16 + 40];
    // All channels of the third colour are saturated.
    assert!(pixel.iter().all(|value| (value - 1.0).abs() < 1e-4), "{pixel:?}");
    // Below the base speed the full well comes before white: the exposure of the file says so.
    let slow = QUIET.replace("iso=100", "iso=80");
    let raw = petzval(at, &["render", "a.pbrt", "-q", "-o", "a.dng", "--bayer", "--sensor", &slow]);
    assert_eq!(raw.0, 0, "{}", raw.2);
    let raw = RawFile::read(&at.join("a.dng"), &Default::default()).unwrap();
    let pixel = raw.develop(WhiteBalance::Off).unwrap().picture.pixels[48 * 16 + 40];
    assert!(pixel.iter().all(|value| (value - 0.8).abs() < 1e-4), "{pixel:?}");
}

#[test]
fn faults_have_a_remedy() {
    let folder = folder();
    let at = folder.path();
    write(&folder, "a.pbrt", SCENE);
    let raw = petzval(at, &["render", "a.pbrt", "-q", "-o", "a.dng", "--bayer", "--sensor", QUIET]);
    assert_eq!(raw.0, 0, "{}", raw.2);
    let mut bytes = std::fs::read(at.join("a.dng")).unwrap();
    std::fs::write(at.join("cut.dng"), &bytes[..2000]).unwrap();
    // The entries of both colour matrices get another tag.
    for tag in [50721_u16, 50722] {
        let entry = [&tag.to_le_bytes()[..], &10_u16.to_le_bytes(), &9_u32.to_le_bytes()].concat();
        if let Some(at) = bytes.windows(8).position(|window| window == entry) {
            bytes[at] = 0;
        }
    }
    std::fs::write(at.join("grey.dng"), &bytes).unwrap();
    std::fs::copy(root().join("README.md"), at.join("text.dng")).unwrap();
    for (arguments, expected) in [
        ("a.dng -o a.dng", "a DNG holds no developed picture"),
        ("a.dng -o b.gif", "names no picture format"),
        ("a.dng -o missing/b.png", "cannot write missing/b.png"),
        ("a.dng -o b.jpg --bit-depth 16", "--bit-depth is for PNG"),
        ("a.dng -o b.png --white-balance warm", "x,y, auto or as-shot"),
        ("a.dng -o b.png --white-balance off", "x,y, auto or as-shot"),
        ("a.dng -o b.png --white-balance 0.72,0.27", "expected a temperature"),
        ("none.dng -o b.png", "none.dng"),
        ("cut.dng -o b.png", "cut off"),
        ("text.dng -o b.png", "not a TIFF file"),
        ("grey.dng -o b.png", "no colour matrix"),
        ("a.pbrt -o b.png", "known are .dng"),
    ] {
        let words: Vec<&str> = ["develop"].into_iter().chain(arguments.split(' ')).collect();
        let (code, _, stderr) = petzval(at, &words);
        assert_eq!(code, 2, "{arguments}: {stderr}");
        assert!(stderr.contains(expected), "{arguments}: {stderr}");
    }
    let (code, _, stderr) = petzval(at, &["measure", "a.dng", "--edge", "0,0,20,20"]);
    assert!(code == 2 && stderr.contains("develop it first"), "{stderr}");
}
