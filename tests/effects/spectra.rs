//! Spectra in pictures: colours are those of integrals over the wavelength, dispersion is where Snell's law
//! puts it, and pictures depend on the job alone.

mod crystal;
mod glass;
mod measured;
mod media;

use crate::support::workspace::Workspace;
use crate::support::{folder, mean, picture, root, write};
use petzval_image::Picture;
use petzval_lens::LensModel;
use petzval_render::film::{Frame, SampleId};
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{Backend, replay};
use petzval_scene_formats::pbrt;
use petzval_spectrum::{
    LightBand, Spectrum, WAVELENGTHS, blackbody, colour_matching, lens_bands, named_spectrum,
    srgb_from_xyz,
};

/// Prepares a scene of a text, with these effects.
fn job(text: &str, samples: u32, effects: &str) -> Job {
    let folder = folder();
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene of a test");
    let effects = effects.parse().expect("effects");
    let changes = Changes { samples: Some(samples), effects, ..Changes::default() };
    prepare(description, &changes).expect("a job").job
}

fn rendered(text: &str, samples: u32, effects: &str) -> Picture {
    picture(&job(text, samples, effects), Backend::Simd, 1)
}

/// A camera that sees nothing but one material, on a wall under a sky.
fn wall(sky: &str, material: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8 PixelFilter \"box\"
         Integrator \"path\" \"integer maxdepth\" 2 Camera \"perspective\" \"float fov\" 4
         WorldBegin LightSource \"infinite\" {sky} Material {material}
         Shape \"bilinearmesh\" \"point3 P\" [-1 -1 5  1 -1 5  -1 1 5  1 1 5]"
    )
}

/// A camera that sees nothing but a ball of one material, under a sky; light scatters below its surface.
fn ball(sky: &str, material: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8 PixelFilter \"box\"
         Integrator \"volpath\" \"integer maxdepth\" 6 Camera \"perspective\" \"float fov\" 4
         WorldBegin LightSource \"infinite\" {sky} Material {material}
         Translate 0 0 5 Shape \"sphere\""
    )
}

/// Returns the linear sRGB of a quantity by wavelength, by an integral in steps of 0.1 nm; that of light of
/// luminance 1 is relative to it.
pub fn colour(value: impl Fn(f64) -> f64) -> [f64; 3] {
    let (mut xyz, mut luminosity) = ([0.0; 3], 0.0);
    for i in 0..4700 {
        let nm = 360.05 + 0.1 * f64::from(i);
        let matching = colour_matching(nm);
        luminosity += matching[1];
        (0..3).for_each(|c| xyz[c] += value(nm) * matching[c]);
    }
    srgb_from_xyz(xyz.map(|v| v / luminosity))
}

/// Lamps, as a scene file has them and as spectra.
fn lamps() -> Vec<(&'static str, Spectrum)> {
    let named = |name: &str| named_spectrum(name).expect("a known spectrum");
    let mut lamps = vec![
        ("\"spectrum L\" \"stdillum-D65\"", named("stdillum-D65")),
        ("\"spectrum L\" \"stdillum-A\"", named("stdillum-A")),
        ("\"spectrum L\" \"stdillum-F2\"", named("stdillum-F2")),
        ("\"spectrum L\" \"stdillum-F11\"", named("stdillum-F11")),
        ("\"blackbody L\" 2000", blackbody(2000.0)),
        ("\"blackbody L\" 20000", blackbody(20_000.0)),
    ];
    let narrow = vec![[495.0, 0.0], [500.0, 1.0], [620.0, 0.2], [625.0, 0.0]];
    let spectrum = Spectrum::samples(narrow).expect("in order");
    lamps.push(("\"spectrum L\" [495 0 500 1 620 0.2 625 0]", spectrum));
    lamps
}

/// Checks a picture of one colour: within 0.5 % of it, and of the brightest channel where the colour is
/// outside the gamut.
fn assert_colour(found: &Picture, expected: [f64; 3], what: &str) {
    let brightest = expected.iter().fold(0.0f64, |a, &b| a.max(b.abs()));
    for (found, wanted) in mean(found).into_iter().zip(expected) {
        let off = (found - wanted).abs() / wanted.abs().max(0.05 * brightest);
        assert!(off < 0.005, "{what}: {found}, not {wanted} of {expected:?}");
    }
}

#[test]
fn pigments_under_lamps_have_the_colours_of_integrals() {
    let pigments = [
        vec![[400.0, 0.04], [580.0, 0.05], [600.0, 0.3], [620.0, 0.7], [700.0, 0.8]],
        vec![[400.0, 0.04], [480.0, 0.08], [510.0, 0.5], [550.0, 0.55], [580.0, 0.2], [700.0, 0.1]],
        vec![[360.0, 0.5], [830.0, 0.5]],
    ];
    for (lamp, light) in lamps() {
        let luminance = light.to_xyz()[1];
        for pigment in &pigments {
            let text: Vec<String> = pigment.iter().map(|[nm, r]| format!("{nm} {r}")).collect();
            let material = format!("\"diffuse\" \"spectrum reflectance\" [{}]", text.join(" "));
            let reflectance = Spectrum::samples(pigment.clone()).expect("in order");
            let expected = colour(|nm| light.at(nm) / luminance * reflectance.at(nm));
            let seen = rendered(&wall(lamp, &material), 64, "+spectra");
            assert_colour(&seen, expected, &format!("{material} under {lamp}"));
        }
    }
}

/// White is exact for the matrix of a camera, so both must agree; the colours of cameras are judged by rows
/// of `pbrt_language`.
#[test]
fn a_camera_sees_white_alike_in_rgb_and_by_wavelength() {
    let own = folder();
    let table = "nm,red,green,blue\n390,0,0,0\n460,0.02,0.1,0.35\n540,0.03,0.4,0.08\n\
        600,0.25,0.2,0.02\n700,0.01,0,0\n";
    let own = write(&own, "own.csv", table).display().to_string();
    for camera in ["canon_eos_5d", "nikon_d850", "sony_ilce_9", &own] {
        let sensor = format!("PixelFilter \"box\" Film \"rgb\" \"string sensor\" \"{camera}\"");
        let white = wall("\"rgb L\" [1 1 1]", "\"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]");
        let scene = white.replacen("Film \"rgb\"", &sensor, 1);
        let [rgb, spectral] = ["-spectra", "+spectra"].map(|e| mean(&rendered(&scene, 64, e)));
        for (found, wanted) in spectral.into_iter().zip(rgb) {
            assert!((found / wanted - 1.0).abs() < 1e-3, "{camera}: {spectral:?}, not {rgb:?}");
        }
    }
}

#[test]
fn metals_have_the_colours_of_their_indices() {
    // At normal incidence, but for 2 degrees.
    for metal in ["Au", "Cu", "CuZn", "Ag", "Al"] {
        let index = |part: &str| named_spectrum(&format!("metal-{metal}-{part}")).expect("a metal");
        let (eta, k) = (index("eta"), index("k"));
        let reflectance = |nm: f64| {
            let (n, k) = (eta.index_at(nm), k.index_at(nm));
            ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k)
        };
        let material = format!(
            "\"conductor\" \"spectrum eta\" \"metal-{metal}-eta\" \"spectrum k\"
             \"metal-{metal}-k\" \"float roughness\" 0"
        );
        for (lamp, light) in lamps() {
            let luminance = light.to_xyz()[1];
            let expected = colour(|nm| light.at(nm) / luminance * reflectance(nm));
            let seen = rendered(&wall(lamp, &material), 64, "+spectra");
            assert_colour(&seen, expected, &format!("{metal} under {lamp}"));
        }
    }
}

/// Paints, textures and lights that the scene file gives as RGB keep their colour in daylight.
#[test]
fn colours_in_daylight_stay_as_they_are() {
    let folder = folder();
    let image = Picture { size: [1, 1], pixels: vec![[0.6, 0.3, 0.1]] };
    crate::support::write_picture(&image, folder.path().join("texel.exr"));
    let texel = folder.path().join("texel.exr").display().to_string();
    let texture = format!(
        "\"diffuse\" \"rgb reflectance\" [0 0 0] Texture \"t\" \"spectrum\" \"imagemap\"
         \"string filename\" \"{texel}\" Material \"diffuse\" \"texture reflectance\" \"t\""
    );
    let white = "\"rgb L\" [1 1 1]";
    for (sky, material) in [
        (white, "\"diffuse\" \"rgb reflectance\" [0.8 0.35 0.05]"),
        (white, "\"diffuse\" \"rgb reflectance\" [0.1 0.5 0.5]"),
        (white, "\"conductor\" \"rgb reflectance\" [0.9 0.6 0.3] \"float roughness\" 0"),
        ("\"rgb L\" [4 2 0.5]", "\"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]"),
        ("\"rgb L\" [0.1 0.3 1]", "\"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]"),
        (white, &texture),
        (
            &format!("\"string filename\" \"{texel}\""),
            "\"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]",
        ),
    ] {
        let scene = wall(sky, material);
        let [rgb, spectral] = ["-spectra", "+spectra"].map(|e| mean(&rendered(&scene, 64, e)));
        for (found, wanted) in spectral.into_iter().zip(rgb) {
            assert!((found / wanted - 1.0).abs() < 0.003, "{scene}: {spectral:?}, not {rgb:?}");
        }
    }
}

/// A white sky and a white ball, through a lens.
fn furnace(lens: &str) -> String {
    format!(
        "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16 \"float diagonal\" 20
         Integrator \"path\" \"integer maxdepth\" 20 Camera \"realistic\" \"string lensfile\" \"{}\"
         \"float focusdistance\" 3 WorldBegin LightSource \"infinite\" \"rgb L\" [1 1 1]
         Material \"diffuse\" \"rgb reflectance\" [1 1 1] Translate 0 0 3
         Shape \"sphere\" \"float radius\" 0.3 Translate 0.5 0 0
         Material \"dielectric\" \"spectrum eta\" \"glass-SF11\" Shape \"sphere\" \"float radius\" 0.2",
        root().join("lenses").join(lens).display()
    )
}

#[test]
fn a_white_furnace_stays_white() {
    // Bands that share rays, through glass of one index.
    let scene = furnace("dgauss.50mm.dat");
    let [white, mut spectral] = ["-spectra", "+spectra"].map(|effects| job(&scene, 1024, effects));
    let LensModel::Real(lens) = &mut spectral.camera.model else { panic!("a lens") };
    lens.disperse(&lens_bands());
    let [white, found] = [&white, &spectral].map(|job| mean(&picture(job, Backend::Simd, 1)));
    for c in 0..3 {
        assert!((found[c] / white[c] - 1.0).abs() < 0.002, "{found:?} for {white:?}");
    }
}

#[test]
fn a_lens_that_disperses_passes_each_wavelength_as_it_does_alone() {
    // Pupil and magnification depend on the wavelength, and with them the irradiance: the picture is a sum
    // of those of single wavelengths, one in eight of the bands.
    let scene = furnace("triplet.toml");
    let together = mean(&rendered(&scene, 2048, "+spectra,+dispersion,-diffraction"));
    let mut expected = [0.0; 3];
    for bands in lens_bands().chunks(8) {
        let mut alone = job(&scene, 64, "-spectra,-dispersion,-diffraction");
        let LensModel::Real(lens) = &mut alone.camera.model else { panic!("a lens") };
        let middle = LightBand { wavelength: bands[4].wavelength, response: [1.0; 3] };
        lens.disperse(&[middle]);
        lens.bound_all_bands();
        let seen = mean(&picture(&alone, Backend::Simd, 1));
        for band in bands {
            (0..3).for_each(|c| expected[c] += seen[c] * band.response[c] / WAVELENGTHS as f64);
        }
    }
    for c in 0..3 {
        assert!((together[c] / expected[c] - 1.0).abs() < 0.002, "{together:?}, not {expected:?}");
    }
}

/// Apex angle of the prism (rad).
const APEX: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// Returns the direction (rad, from z towards x) in which a ray leaves the prism, whose base is towards +x,
/// for a ray that comes from the camera in a direction: by Snell's law at both faces.
fn through_prism(angle: f64, index: f64) -> f64 {
    // Angles from the normals of the faces, each of which leans towards -x by half the apex angle.
    let first = APEX / 2.0 - angle;
    let inside = (first.sin() / index).asin();
    let second = APEX - inside;
    (index * second.sin()).asin() - APEX / 2.0
}

#[test]
fn a_prism_spreads_lamps_where_snell_puts_them() {
    let glass = named_spectrum("glass-SF11").expect("a glass");
    // A lamp so far away that it is a point, seen by way of the prism in the middle of the picture at 550 nm.
    let towards = through_prism(0.0, glass.index_at(550.0));
    let (fov, pixels) = (4.0f64, 200usize);
    // The place in the picture where light of a wavelength is seen, by bisection of the angle at the camera.
    let place = |nm: f64| {
        let (mut low, mut high) = (-0.05, 0.05);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            // The more the ray leans away from the base, the more it is bent.
            let beyond = through_prism(middle, glass.index_at(nm)) > towards;
            if beyond { high = middle } else { low = middle }
        }
        pixels as f64 / 2.0 * (1.0 + low.tan() / (fov / 2.0).to_radians().tan())
    };
    // 24 columns of the picture of a lamp of 8 nm.
    let columns = |nm: f64, first: usize, samples: u32| {
        let distance = 1e6;
        let (x, z) = (distance * towards.sin(), distance * towards.cos());
        let scene = format!(
            "Film \"rgb\" \"integer xresolution\" {pixels} \"integer yresolution\" 7
             \"integer pixelbounds\" [{first} {} 0 7] PixelFilter \"box\"
             Integrator \"path\" \"integer maxdepth\" 6 Camera \"perspective\" \"float fov\" {fov}
             \"float screenwindow\" [-1 1 -0.035 0.035]
             WorldBegin AttributeBegin
             AreaLightSource \"diffuse\" \"spectrum L\" [{} 0 {} 1 {} 1 {} 0] \"float scale\" 1000
             Translate {x} 0 {z} Shape \"sphere\" \"float radius\" 900 AttributeEnd
             Material \"dielectric\" \"spectrum eta\" \"glass-SF11\"
             Shape \"trianglemesh\" \"point3 P\" [
                 {tip} -3 2  {left} -3 1  {left} -3 3  {tip} 3 2  {left} 3 1  {left} 3 3]
             \"integer indices\" [0 4 1 0 3 4  0 2 5 0 5 3  1 5 2 1 4 5  0 1 2  3 5 4]",
            first + 24,
            nm - 4.0,
            nm - 3.0,
            nm + 3.0,
            nm + 4.0,
            tip = -0.5 / (APEX / 2.0).tan(),
            left = 0.5 / (APEX / 2.0).tan(),
        );
        rendered(&scene, samples, "+spectra")
    };
    let first = |nm: f64| place(nm).round() as usize - 12;
    let mut places = Vec::new();
    for nm in [450.0, 550.0, 640.0] {
        let first = first(nm);
        let strength = |rgb: [f64; 3]| rgb.iter().map(|c| c.abs()).sum::<f64>();
        let seen = columns(nm, first, 16_384);
        let (mut sum, mut moment) = (0.0, 0.0);
        for (i, pixel) in seen.pixels.iter().enumerate() {
            let light = strength(pixel.map(f64::from));
            sum += light;
            moment += light * ((first + i % 24) as f64 + 0.5);
        }
        let (mut whole, mut expected) = (0.0, 0.0);
        for i in 0..80 {
            let at = nm - 3.95 + 0.1 * f64::from(i);
            let lamp = (4.0 - (at - nm).abs()).min(1.0);
            let weight = lamp * strength(srgb_from_xyz(colour_matching(at)));
            whole += weight;
            expected += weight * place(at);
        }
        places.push([moment / sum, expected / whole]);
    }
    println!("{places:?}");
    for [found, expected] in &places {
        assert!((found - expected).abs() < 0.1, "{places:?}");
    }
    assert!((places[0][0] - places[2][0]).abs() > 30.0, "blue and red are far apart: {places:?}");
    // No light goes where the index of another wavelength would send it.
    let elsewhere = columns(450.0, first(550.0), 1024);
    assert!(elsewhere.pixels.iter().all(|pixel| *pixel == [0.0; 3]), "blue light beside its place");
}

#[test]
fn glass_that_disperses_is_invisible_in_a_white_sky() {
    // One wavelength goes on for three: all light that enters leaves again.
    let scene = "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8 PixelFilter \"box\"
         Integrator \"path\" \"integer maxdepth\" 200 Camera \"perspective\" \"float fov\" 10 WorldBegin
         LightSource \"infinite\" \"rgb L\" [1 1 1] Translate 0 0 5
         Material \"dielectric\" \"spectrum eta\" \"glass-SF11\" Shape \"sphere\"";
    let seen = mean(&rendered(scene, 8192, "+spectra"));
    assert!(seen.into_iter().all(|c| (c - 1.0).abs() < 4e-3), "{seen:?}");
}

/// Two walls of different kinds, lamps, an image, fog and glass that disperses, through a lens.
fn everything() -> String {
    let lens = root().join("lenses/triplet.toml");
    format!(
        "Film \"rgb\" \"integer xresolution\" 40 \"integer yresolution\" 30 \"float diagonal\" 20
         Integrator \"path\" \"integer maxdepth\" 6 Camera \"realistic\" \"string lensfile\" \"{}\"
         \"float focusdistance\" 3 WorldBegin
         LightSource \"infinite\" \"rgb L\" [0.3 0.4 0.6]
         LightSource \"point\" \"blackbody I\" 2700 \"point3 from\" [1 2 1] \"float scale\" 3
         Material \"coateddiffuse\" \"rgb reflectance\" [0.8 0.3 0.2]
         Shape \"bilinearmesh\" \"point3 P\" [-4 -4 5  4 -4 5  -4 4 5  4 4 5]
         AttributeBegin AreaLightSource \"diffuse\" \"spectrum L\" \"stdillum-F11\" Translate 0 1 3
         Shape \"sphere\" \"float radius\" 0.2 AttributeEnd
         AttributeBegin Translate -0.3 0 3 Material \"dielectric\" \"spectrum eta\" \"glass-SF11\"
         Shape \"sphere\" \"float radius\" 0.25 AttributeEnd
         MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0.3 0.1 0.05]
         \"rgb sigma_s\" [0.5 0.8 1.2]
         AttributeBegin Translate 0.4 0 3 Material \"interface\" MediumInterface \"fog\" \"\"
         Shape \"sphere\" \"float radius\" 0.25 AttributeEnd
         Translate 0 -0.5 3 Material \"conductor\" \"float roughness\" 0.2
         Shape \"sphere\" \"float radius\" 0.25",
        lens.display()
    )
}

#[test]
fn pictures_are_equal_for_all_backends_threads_and_crops() {
    for effects in ["+spectra,+dispersion", "+spectra,-dispersion"] {
        let whole = job(&everything(), 40, &format!("{effects},-diffraction,-ghosts"));
        let simd = picture(&whole, Backend::Simd, 1);
        assert!(mean(&simd).into_iter().all(|c| c > 1e-5), "the picture is dark");
        assert_eq!(picture(&whole, Backend::Scalar, 1), simd, "{effects}: scalar");
        assert_eq!(picture(&whole, Backend::Simd, 3), simd, "{effects}: threads");
        let mut part = whole.clone();
        let [low, high] = [[7, 5], [29, 27]];
        part.frame = Frame { low, high, ..whole.frame };
        let crop = picture(&part, Backend::Simd, 2);
        for (i, pixel) in crop.pixels.iter().enumerate() {
            let [x, y] = [i % crop.size[0] + 7, i / crop.size[0] + 5];
            assert_eq!(*pixel, simd.pixels[y * 40 + x], "{effects}: pixel {x}, {y}");
        }
    }
}

#[test]
fn replayed_samples_add_up_to_their_pixel() {
    let job = job(&everything(), 12, "+spectra,+dispersion,-diffraction,-ghosts");
    let seen = picture(&job, Backend::Simd, 1);
    for [x, y] in [[3, 4], [20, 15], [17, 14], [25, 14]] {
        let mut sum = [0.0; 3];
        for sample in 0..12 {
            let name = SampleId::new([x, y], sample, job.seed);
            let replay = replay(&job, Backend::Simd, name).expect("a sample");
            let [short, middle, long] = replay.wavelengths.expect("three wavelengths");
            assert!(360.0 < short && short < middle && middle < long && long < 830.0);
            let value = replay.value.expect("a finite sample");
            (0..3).for_each(|c| sum[c] += value[c] / 12.0);
        }
        let pixel = seen.pixels[(y * 40 + x) as usize];
        for c in 0..3 {
            let off = (sum[c] - f64::from(pixel[c])).abs();
            assert!(off < 1e-5 * f64::from(pixel[c].abs()) + 1e-7, "{x}, {y}: {sum:?}, {pixel:?}");
        }
    }
}

#[test]
fn shards_add_up_and_a_stopped_picture_goes_on() {
    let workspace = Workspace::new();
    let render = "render scene.pbrt --spp 70 --effects +spectra --resolution 48x32";
    workspace.run_ok(&format!("{render} -o whole.exr"));
    for i in 1..=3 {
        workspace.run_ok(&format!("{render} -o {i}.petzval --shard {i}/3"));
    }
    workspace.run_ok("merge 3.petzval 1.petzval 2.petzval -o merged.exr");
    let [whole, merged] = ["whole.exr", "merged.exr"].map(|name| workspace.contents(name));
    let off = merged.difference(&whole);
    assert!(off < 1e-5, "differs by {off:e}");
}

/// Ten times the collisions of a usual picture in fog whose channels differ: no throughput overflows, and
/// light that nothing absorbs is not lost.
#[test]
fn white_fog_in_a_white_sky_is_invisible() {
    let scene = "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8
         Integrator \"volpath\" \"integer maxdepth\" 500 Camera \"perspective\" \"float fov\" 20 WorldBegin
         LightSource \"infinite\" \"rgb L\" [1 1 1]
         MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0 0 0]
         \"rgb sigma_s\" [2 5 9] Translate 0 0 5 Material \"interface\" MediumInterface \"fog\" \"\"
         Shape \"sphere\" \"float radius\" 1";
    let seen = mean(&rendered(scene, 1024, "+spectra"));
    assert!(seen.into_iter().all(|c| (c - 1.0).abs() < 0.01), "{seen:?}");
}
