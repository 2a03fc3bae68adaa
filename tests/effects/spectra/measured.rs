//! Measured surfaces by wavelength.

use std::collections::HashMap;

use super::*;

/// Wavelengths of the made-up measurements (nm), and a reflectance at each.
const WAVELENGTHS: [f32; 6] = [400.0, 480.0, 540.0, 590.0, 610.0, 700.0];
const RED: [f32; 6] = [0.1, 0.15, 0.1, 0.3, 0.9, 1.0];

/// Returns the place and the number of floats of each field of a `.bsdf` file.
fn fields(file: &[u8]) -> HashMap<String, (usize, usize)> {
    let number = |at: usize, bytes: usize| {
        (0..bytes).map(|k| (u64::from(file[at + k]) << (8 * k)) as usize).sum::<usize>()
    };
    let mut at = 18;
    let mut found = HashMap::new();
    for _ in 0..number(14, 4) {
        let length = number(at, 2);
        let name = String::from_utf8_lossy(&file[at + 2..at + 2 + length]).into_owned();
        at += 2 + length;
        let (dimensions, offset) = (number(at, 2), number(at + 3, 8));
        at += 11;
        let count = (0..dimensions).map(|k| number(at + 8 * k, 8)).product();
        at += 8 * dimensions;
        found.insert(name, (offset, count));
    }
    found
}

/// Returns a file whose reflection is that of another in its first wavelength, times a reflectance.
fn of_spectrum(reflectance: [f32; 6]) -> Vec<u8> {
    let mut file =
        std::fs::read(root().join("tests/pbrt_language/isotropic.bsdf")).expect("a file");
    let fields = fields(&file);
    let mut set = |at: usize, value: f32| file[at..at + 4].copy_from_slice(&value.to_le_bytes());
    let (offset, count) = fields["wavelengths"];
    assert_eq!(count, 6);
    (0..6).for_each(|k| set(offset + 4 * k, WAVELENGTHS[k]));
    let (offset, count) = fields["spectra"];
    let points = 12 * 12;
    for slice in 0..count / (6 * points) {
        for point in 0..points {
            let at = |k: usize| offset + 4 * ((slice * 6 + k) * points + point);
            let base = 0.5 + 0.1 * slice as f32 + 0.002 * point as f32;
            (0..6).for_each(|k| set(at(k), base * reflectance[k]));
        }
    }
    file
}

fn scene(folder: &tempfile::TempDir, name: &str, lamp: &str, reflectance: [f32; 6]) -> String {
    let file = write(folder, name, of_spectrum(reflectance));
    wall(lamp, &format!("\"measured\" \"string filename\" \"{}\"", file.display()))
}

#[test]
fn measured_surfaces_have_the_colours_of_their_spectra() {
    let folder = folder();
    let samples = WAVELENGTHS.into_iter().zip(RED).map(|(nm, r)| [f64::from(nm), f64::from(r)]);
    let red = Spectrum::samples(samples.collect()).expect("in order");
    let mut rgb_is_wrong = 0.0f64;
    for (lamp, light) in lamps() {
        let luminance = light.to_xyz()[1];
        let [tinted, white] = [("red.bsdf", RED), ("white.bsdf", [1.0; 6])]
            .map(|(name, reflectance)| scene(&folder, name, lamp, reflectance));
        let of = |text: &str, effects: &str| mean(&rendered(text, 4096, effects));
        let share = |effects: &str| {
            let [tinted, white] = [&tinted, &white].map(|text| of(text, effects));
            [0, 1, 2].map(|c| tinted[c] / white[c])
        };
        // Constant beyond the measured wavelengths, as in pbrt-v4.
        let reflected = |nm: f64| red.at(nm.clamp(400.0, 700.0));
        let expected = colour(|nm| light.at(nm) / luminance * reflected(nm));
        let lit = colour(|nm| light.at(nm) / luminance);
        // Channels of a narrow lamp are differences of larger numbers.
        let halves = lit.iter().map(|c| 0.5 * c);
        let brightest = expected.iter().copied().chain(halves).fold(0.0, f64::max);
        for (spectral, rgb, c) in share("+spectra")
            .into_iter()
            .zip(share("-spectra"))
            .zip(0..)
            .map(|((a, b), c)| (a, b, c))
        {
            let off = |found: f64| (found * lit[c] - expected[c]).abs() / brightest;
            assert!(
                off(spectral) < 0.003,
                "{lamp}, channel {c}: {spectral} of {lit:?}, {expected:?}"
            );
            rgb_is_wrong = rgb_is_wrong.max(off(rgb));
        }
    }
    assert!(rgb_is_wrong > 0.03, "{rgb_is_wrong}");
}

#[test]
fn the_plan_knows_the_spectra_of_measured_surfaces() {
    let folder = folder();
    for (lamp, reflectance, wanted) in [
        ("\"spectrum L\" \"stdillum-F11\"", RED, true),
        ("\"spectrum L\" \"stdillum-D65\"", RED, false),
        ("\"spectrum L\" \"stdillum-F11\"", [0.7; 6], false),
    ] {
        let text = scene(&folder, "surface.bsdf", lamp, reflectance);
        let job = job(&text, 1, "auto");
        assert_eq!(job.spectral.is_some(), wanted, "{lamp} {reflectance:?}");
    }
}

#[test]
fn measured_surfaces_by_wavelength_are_alike_in_every_lane_and_thread() {
    let folder = folder();
    let text = scene(&folder, "red.bsdf", "\"spectrum L\" \"stdillum-F2\"", RED);
    let job = job(&text, 6, "+spectra");
    let one = picture(&job, Backend::Scalar, 1);
    for (backend, threads) in [(Backend::Simd, 1), (Backend::Simd, 3)] {
        assert_eq!(picture(&job, backend, threads).pixels, one.pixels);
    }
}
