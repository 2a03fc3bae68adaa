//! Glass that disperses, as sheets, coats and the skin of a medium: its index counts by wavelength.

use super::{assert_colour, ball, colour, rendered};
use crate::support::mean;
use petzval_spectrum::{D_LINE, Spectrum, d65, named_spectrum};

/// A lamp of 8 nm, as a parameter and as a spectrum.
pub fn narrow_lamp(nm: f64) -> (String, Spectrum) {
    let [a, b, c, d] = [nm - 4.0, nm - 3.0, nm + 3.0, nm + 4.0];
    let spectrum = Spectrum::samples(vec![[a, 0.0], [b, 1.0], [c, 1.0], [d, 0.0]]);
    (format!("\"spectrum L\" [{a} 0 {b} 1 {c} 1 {d} 0]"), spectrum.expect("in order"))
}

/// Returns the share of light that a sheet reflects: r + t^2 r + t^2 r^3 + ... of both sides, with r as Fresnel has
/// it for unpolarised light.
fn sheet_reflectance(index: f64, angle: f64) -> f64 {
    let inside = (angle.sin() / index).asin();
    let (cos, cos_inside) = (angle.cos(), inside.cos());
    let s = (cos - index * cos_inside) / (cos + index * cos_inside);
    let p = (index * cos - cos_inside) / (index * cos + cos_inside);
    let once = 0.5 * (s * s + p * p);
    2.0 * once / (1.0 + once)
}

/// A sky that is seen by way of shapes.
fn sky(lamp: &str, shapes: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8 PixelFilter \"box\"
         Integrator \"path\" \"integer maxdepth\" 3 Camera \"perspective\" \"float fov\" 0.5
         WorldBegin LightSource \"infinite\" {lamp} {shapes}"
    )
}

#[test]
fn a_thin_sheet_reflects_as_fresnel_says_at_each_wavelength() {
    let glass = named_spectrum("glass-SF11").expect("a glass");
    let sheet = |degrees: f64| {
        format!(
            "Material \"diffuse\" \"rgb reflectance\" [0 0 0]
             Shape \"bilinearmesh\" \"point3 P\" [-1 -1 9  1 -1 9  -1 1 9  1 1 9]
             Translate 0 0 5 Rotate {degrees} 0 1 0
             Material \"thindielectric\" \"spectrum eta\" \"glass-SF11\"
             Shape \"bilinearmesh\" \"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]"
        )
    };
    for degrees in [0.0f64, 60.0] {
        let reflected = |nm: f64| sheet_reflectance(glass.index_at(nm), degrees.to_radians());
        let luminance = d65().to_xyz()[1];
        let expected = colour(|nm| d65().at(nm) / luminance * reflected(nm));
        let white = sky("\"spectrum L\" \"stdillum-D65\"", &sheet(degrees));
        assert_colour(&rendered(&white, 16_384, "+spectra"), expected, &white);
    }
    // Noise is 0.4 %: few bands have light of these lamps.
    for nm in [450.0, 550.0, 640.0] {
        let lamp = format!(
            "\"spectrum L\" [{} 0 {} 1 {} 1 {} 0]",
            nm - 15.0,
            nm - 14.0,
            nm + 14.0,
            nm + 15.0
        );
        let seen = |shapes: &str, samples: u32| {
            let seen = mean(&rendered(&sky(&lamp, shapes), samples, "+spectra"));
            seen.into_iter().fold(0.0, f64::max)
        };
        let found = seen(&sheet(0.0), 32_768) / seen("", 64);
        let expected = sheet_reflectance(glass.index_at(nm), 0.0);
        println!("{nm} nm: {found:.5}, not {expected:.5}");
        assert!((found / expected - 1.0).abs() < 0.01, "{nm} nm: {found}, not {expected}");
    }
    let at_d_line = sheet_reflectance(glass.index_at(D_LINE), 0.0);
    let in_blue = sheet_reflectance(glass.index_at(450.0), 0.0);
    assert!(in_blue > 1.03 * at_d_line, "the index at the d line would fail");
}

/// A blue and a red lamp see coats, and skins of media, of the index at their wavelengths.
#[test]
fn coats_and_skins_have_the_index_at_the_wavelength() {
    const ETA: &str = "[589 1.8 611 1.4]";
    let lamps = [
        ("\"spectrum L\" [400 0 405 1 580 1 585 0]", 1.8),
        ("\"spectrum L\" [615 0 620 1 750 1 755 0]", 1.4),
    ];
    for material in [
        "\"coateddiffuse\" \"rgb reflectance\" [0.3 0.3 0.3] \"float roughness\" 0.1 \"ETA",
        "\"coatedconductor\" \"rgb reflectance\" [0.5 0.5 0.5] \"float interface.roughness\" 0.2
         \"ETA",
        "\"subsurface\" \"float sigma_a\" 1 \"float sigma_s\" 4 \"ETA",
        "\"subsurface\" \"float reflectance\" 0.5 \"float mfp\" 0.1 \"ETA",
    ] {
        let eta = |kind: &str, values: &str| {
            let prefix = if material.contains("interface") { "interface." } else { "" };
            material.replace("\"ETA", &format!("\"{kind} {prefix}eta\" {values}"))
        };
        for (i, (lamp, index)) in lamps.into_iter().enumerate() {
            let other = lamps[1 - i].1;
            let seen = |samples: u32, parameters: String| {
                let scene = ball(lamp, &parameters);
                mean(&rendered(&scene, samples, "+spectra")).into_iter().fold(0.0, f64::max)
            };
            // One wavelength of three goes on: noise is 1 %, and 0.3 % with eight times the samples.
            let found = seen(4096, eta("spectrum", ETA));
            let [expected, wrong] =
                [index, other].map(|index| seen(2048, eta("float", &index.to_string())));
            println!("{material}: {found}, {expected}, {wrong}");
            assert!((found / expected - 1.0).abs() < 0.02, "{material}: {found}, not {expected}");
            assert!((wrong / expected - 1.0).abs() > 0.06, "{material} cannot fail: {wrong}");
        }
    }
}
