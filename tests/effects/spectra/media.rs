//! Media whose coefficients are spectra: light is absorbed, scattered and emitted as integrals over the wavelength
//! say.

use super::{assert_colour, ball, colour, rendered};
use crate::support::mean;
use petzval_spectrum::{Spectrum, named_spectrum, uplift_reflectance, wavelength_bands};

/// Absorption of a red dye, which falls to a tenth within 40 nm.
const DYE: [[f64; 2]; 4] = [[400.0, 1.2], [560.0, 1.0], [600.0, 0.1], [700.0, 0.1]];
/// Scattering of small particles.
const HAZE: [[f64; 2]; 4] = [[360.0, 2.0], [480.0, 0.8], [580.0, 0.4], [830.0, 0.1]];

fn spectrum(samples: &[[f64; 2]]) -> Spectrum {
    Spectrum::samples(samples.to_vec()).expect("in order")
}

/// Writes samples as a parameter of a scene file.
fn written(samples: &[[f64; 2]]) -> String {
    let words: Vec<String> = samples.iter().map(|[nm, value]| format!("{nm} {value}")).collect();
    format!("[{}]", words.join(" "))
}

fn lamp(name: &str) -> (String, impl Fn(f64) -> f64) {
    let spectrum = named_spectrum(name).expect("a lamp");
    let luminance = spectrum.to_xyz()[1];
    (format!("\"spectrum L\" \"{name}\""), move |nm| spectrum.at(nm) / luminance)
}

/// A camera that looks along z through a slab between z = 2 and 3, whose side is at x = 0.5.
fn slab(depth: u32, light: &str, medium: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8 PixelFilter \"box\"
         Integrator \"volpath\" \"integer maxdepth\" {depth} Camera \"perspective\" \"float fov\" 0.5
         WorldBegin {light}
         MakeNamedMedium \"dye\" \"string type\" \"homogeneous\" {medium}
         Material \"interface\" MediumInterface \"\" \"dye\"
         Shape \"bilinearmesh\" \"point3 P\" [-1 -1 2  0.5 -1 2  -1 1 2  0.5 1 2]
         MediumInterface \"dye\" \"\"
         Shape \"bilinearmesh\" \"point3 P\" [-1 -1 3  0.5 -1 3  -1 1 3  0.5 1 3]
         Shape \"bilinearmesh\" \"point3 P\" [0.5 -1 2  0.5 1 2  0.5 -1 3  0.5 1 3]"
    )
}

/// Checks a scene with spectra against a colour, and that others are wrong: RGB, and with spectra the scene whose
/// medium has the RGB of its spectra.
fn assert_only_spectra_are_right(
    scene: impl Fn(&str) -> String,
    medium: [(&str, &Spectrum); 2],
    samples: u32,
    expected: [f64; 3],
) {
    let [spectral, rgb] = [false, true].map(|in_rgb| {
        let parameters = medium.map(|(name, spectrum)| match (in_rgb, spectrum) {
            (false, Spectrum::Samples(samples)) => {
                format!("\"spectrum {name}\" {}", written(samples))
            }
            _ => {
                let [r, g, b] = spectrum.reflectance();
                format!("\"rgb {name}\" [{r} {g} {b}]")
            }
        });
        scene(&parameters.join(" "))
    });
    assert_colour(&rendered(&spectral, samples, "+spectra"), expected, &spectral);
    let brightest = expected.into_iter().fold(0.0, f64::max);
    for (scene, effects) in [(&spectral, "-spectra"), (&rgb, "+spectra")] {
        let found = mean(&rendered(scene, 1024, effects));
        let counts = |c: &usize| expected[*c] > 0.2 * brightest;
        let worst = (0..3).filter(counts).map(|c| (found[c] / expected[c] - 1.0).abs());
        let worst = worst.fold(0.0, f64::max);
        println!("{effects}: off by {worst:.3}");
        assert!(worst > 0.02, "{scene}: {found:?} with {effects} for {expected:?}");
    }
}

/// A medium that does not scatter.
const CLEAR: Spectrum = Spectrum::Constant(0.0);

#[test]
fn a_dye_before_lamps_absorbs_by_wavelength() {
    let dye = spectrum(&DYE);
    for name in ["stdillum-F2", "stdillum-F11"] {
        let (light, radiance) = lamp(name);
        let scene = |medium: &str| slab(4, &format!("LightSource \"infinite\" {light}"), medium);
        let expected = colour(|nm| radiance(nm) * (-dye.at(nm)).exp());
        let medium = [("sigma_a", &dye), ("sigma_s", &CLEAR)];
        assert_only_spectra_are_right(scene, medium, 16_384, expected);
    }
}

#[test]
fn a_medium_glows_by_wavelength() {
    let (_, radiance) = lamp("stdillum-F11");
    let dye = spectrum(&DYE);
    let glow = "\"spectrum Le\" \"stdillum-F11\"";
    let scene = |medium: &str| slab(1, "", &format!("{medium} {glow}"));
    let expected = colour(|nm| radiance(nm) * (1.0 - (-dye.at(nm)).exp()));
    assert_only_spectra_are_right(scene, [("sigma_a", &dye), ("sigma_s", &CLEAR)], 64, expected);
}

#[test]
fn haze_beside_a_lamp_scatters_once_by_wavelength() {
    // Light comes from the side: all of it passes 0.5 of the medium before it scatters.
    let (dye, haze) = (spectrum(&DYE), spectrum(&HAZE));
    let (light, radiance) = lamp("stdillum-F11");
    let light = format!(
        "LightSource \"distant\" {light} \"point3 from\" [1 0 0] \"point3 to\" [0 0 0]
         \"float scale\" 10"
    );
    let scattered = |nm: f64| {
        let (s, t) = (haze.at(nm), dye.at(nm) + haze.at(nm));
        let phase = 0.25 * std::f64::consts::FRAC_1_PI;
        10.0 * radiance(nm) * phase * s * (-0.5 * t).exp() * (1.0 - (-t).exp()) / t
    };
    let scene = |medium: &str| slab(1, &light, medium);
    let medium = [("sigma_a", &dye), ("sigma_s", &haze)];
    assert_only_spectra_are_right(scene, medium, 16_384, colour(scattered));
}

/// Media of one kind whose coefficients are given in two ways.
fn grids_and_clouds(coefficients: &str) -> [String; 2] {
    let grid = "\"string type\" \"uniformgrid\" \"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 1
         \"float density\" [0.5 1]";
    [grid, "\"string type\" \"cloud\""].map(|kind| {
        format!(
            "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8
             Integrator \"volpath\" \"integer maxdepth\" 5 Camera \"perspective\" \"float fov\" 20
             WorldBegin LightSource \"infinite\" \"spectrum L\" \"stdillum-F11\" Translate -0.5 -0.5 3
             MakeNamedMedium \"dye\" {kind} {coefficients} \"point3 p0\" [0 0 0] \"point3 p1\" [1 1 1]
             Material \"interface\" MediumInterface \"dye\" \"\" Translate 0.5 0.5 0.5
             Shape \"sphere\" \"float radius\" 0.5"
        )
    })
}

#[test]
fn spectra_that_are_constant_are_grey() {
    let flat = |name: &str, value: f64| format!("\"spectrum {name}\" [300 {value} 900 {value}] ");
    let grey = |name: &str, value: f64| format!("\"rgb {name}\" [{value} {value} {value}] ");
    let of = |number: &dyn Fn(&str, f64) -> String| {
        let both = number("sigma_a", 0.3) + &number("sigma_s", 1.2);
        let [grid, cloud] = grids_and_clouds(&both);
        let below = |parameters: String| {
            let sky = "\"spectrum L\" \"stdillum-F11\"";
            ball(sky, &format!("\"subsurface\" {parameters}"))
        };
        let diffuse = number("reflectance", 0.4) + &number("mfp", 0.2);
        [slab(4, "LightSource \"infinite\"", &both), grid, cloud, below(both), below(diffuse)]
    };
    for (spectra, rgb) in of(&flat).into_iter().zip(of(&grey)) {
        assert_eq!(rendered(&spectra, 70, "+spectra"), rendered(&rgb, 70, "+spectra"), "{rgb}");
    }
}

/// A blue and a red lamp see the medium at their wavelengths.
#[test]
fn light_below_a_surface_scatters_by_wavelength() {
    let lamps = ["[400 0 405 1 580 1 585 0]", "[615 0 620 1 750 1 755 0]"];
    for parameters in [
        [("sigma_a", [0.5, 0.1]), ("sigma_s", [4.0, 10.0])],
        [("reflectance", [0.2, 0.8]), ("mfp", [0.2, 0.1])],
    ] {
        let of = |value: &dyn Fn(&str, [f64; 2]) -> String| {
            parameters.map(|(name, values)| value(name, values)).join(" ")
        };
        let spectral =
            of(&|name, [a, b]| format!("\"spectrum {name}\" [360 {a} 589 {a} 611 {b} 830 {b}]"));
        for (i, lamp) in lamps.into_iter().enumerate() {
            let at = |i: usize| of(&|name, values| format!("\"float {name}\" {}", values[i]));
            let seen = |parameters: &str| {
                let lamp = format!("\"spectrum L\" {lamp}");
                let seen = mean(&rendered(
                    &ball(&lamp, &format!("\"subsurface\" {parameters}")),
                    4096,
                    "+spectra",
                ));
                seen.into_iter().fold(0.0, f64::max)
            };
            let [found, expected, wrong] = [&spectral, &at(i), &at(1 - i)].map(|p| seen(p));
            println!("{spectral} under {lamp}: {found}, {expected}, {wrong}");
            assert!((found / expected - 1.0).abs() < 0.02, "{spectral}: {found}, not {expected}");
            assert!((wrong / expected - 1.0).abs() > 0.2, "{spectral} cannot fail");
        }
    }
    // The reflectance of a colour becomes a spectrum before it becomes coefficients.
    let colour = [0.8, 0.3, 0.1];
    let bands = wavelength_bands().iter().zip(*uplift_reflectance(colour).values());
    let samples: Vec<[f64; 2]> =
        bands.map(|(band, r)| [0.5 * (band.range[0] + band.range[1]), r.into()]).collect();
    let [rgb, spectral] = [
        "\"rgb reflectance\" [0.8 0.3 0.1]",
        &format!("\"spectrum reflectance\" {}", written(&samples)),
    ]
    .map(|parameters| {
        let material = format!("\"subsurface\" {parameters} \"float mfp\" 0.1");
        let scene = ball("\"spectrum L\" \"stdillum-F11\"", &material);
        mean(&rendered(&scene, 1024, "+spectra"))
    });
    println!("{rgb:?}, {spectral:?}");
    for c in 0..3 {
        assert!((rgb[c] / spectral[c] - 1.0).abs() < 0.005, "{rgb:?}, not {spectral:?}");
    }
}
