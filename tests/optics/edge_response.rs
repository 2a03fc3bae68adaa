//! Slanted edges in pictures through real lenses, against the lens's modulation transfer.

use petzval_base::sinc::sinc;
use petzval_lens::{Band, LensModel, RealLens, SpectralLine};
use petzval_lens_formats::LensOptions;
use petzval_optics::{
    ConditionChoices, FieldRays, FrequencyAxis, ImageQuality, ImagingConditions, ImagingGrid,
    ObjectPoint, TransferMethod,
};
use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_scene::luminance;
use petzval_scene_formats::pbrt;
use petzval_spectrum::xyz_from_srgb;
use petzval_tools::chart_analysis::{EdgeAxis, EdgeResponse};

use crate::support::reference::by_tier;
use crate::support::{folder, picture, root, write};

/// Distance from the film to the chart (m).
const DISTANCE: f64 = 2.0;
/// Width and height of the film (mm) and of the picture: pixels of 8 um. Its upper half reaches as far from the axis as
/// the corners of the small format do.
const FILM: [f64; 2] = [36.0, 44.0];
const RESOLUTION: [u32; 2] = [4500, 5500];
const PITCH: f64 = 0.008;
/// Heights of the image (mm): in the middle, at 0.7 of the field of the small format, and near its corner.
const HEIGHTS: [f64; 3] = [0.0, 15.1, 20.6];
/// Side of a region (pixels), in which the edge crosses 7 pixels: all of its rows are measured.
const SIDE: u32 = 100;
const DEGREES: f64 = 4.012;

/// A lens file of the repository, its f-number, and the light through it.
type Lens = (&'static str, f64, Light);

/// Light through a lens.
#[derive(Clone, Copy, Debug)]
enum Light {
    /// That of the d line.
    Design,
    /// That of a wavelength (nm).
    Line(f64),
    /// White light, which the lens disperses.
    White,
}

/// Prepares the picture of a region: a black card before a bright sky, whose edge passes a point of the chart (m).
fn job(lens: Lens, axis: EdgeAxis, at: [f64; 2], crop: [[u32; 2]; 2]) -> Job {
    let (lens, f_number, light) = lens;
    let (sin, cos) = DEGREES.to_radians().sin_cos();
    // Along the edge, and from it over the card.
    let [along, across] = match axis {
        EdgeAxis::X => [[sin, cos], [-cos, sin]],
        EdgeAxis::Y => [[cos, sin], [-sin, cos]],
    };
    let reach = 0.2;
    let corner = |u: f64, v: f64| [0, 1].map(|i| at[i] + reach * (u * along[i] + v * across[i]));
    let points: Vec<String> =
        [corner(-1.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(-1.0, 1.0)]
            .iter()
            .map(|[x, y]| format!("{x:.12} {y:.12} {DISTANCE}"))
            .collect();
    let folder = folder();
    let text = format!(
        r#"Film "rgb" "integer xresolution" {} "integer yresolution" {} "float diagonal" {:.12}
           PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
           Sampler "zsobol" "integer pixelsamples" 2048
           Integrator "path" "integer maxdepth" 1
           Camera "realistic" "string lensfile" "{}/lenses/{lens}" "float focusdistance" {DISTANCE}
           WorldBegin
           LightSource "infinite" "rgb L" [1 1 1]
           Material "diffuse" "rgb reflectance" [0 0 0]
           Shape "trianglemesh" "point3 P" [{}] "integer indices" [0 1 2 0 2 3]"#,
        RESOLUTION[0],
        RESOLUTION[1],
        FILM[0].hypot(FILM[1]),
        root().display(),
        points.join(" ")
    );
    let description = pbrt::read(&write(&folder, "edge.pbrt", text)).expect("a scene");
    let (effects, wavelengths) = match light {
        Light::Design => ("none", vec![]),
        Light::Line(wavelength) => ("none", vec![wavelength]),
        Light::White => ("+dispersion", vec![]),
    };
    let effects = effects.parse().expect("a selection");
    let lens_options = LensOptions { wavelengths, ..LensOptions::default() };
    let lens = Some(root().join("lenses").join(lens));
    let f_number = Some(f_number);
    let changes =
        Changes { lens, lens_options, crop: Some(crop), f_number, effects, ..Changes::default() };
    prepare(description, &changes).expect("a job").job
}

fn real_lens(job: &Job) -> &RealLens {
    match &job.camera.model {
        LensModel::Real(lens) => lens,
        _ => panic!("a real lens"),
    }
}

/// The loop of lens, light and picture: contrast within a hundredth up to Nyquist.
#[test]
fn edges_in_pictures_have_the_modulation_of_lens_and_pixels() {
    let lenses: [Lens; 5] = [
        ("dgauss.50mm.dat", 4.0, Light::Design),
        ("double-gauss.50mm.toml", 5.6, Light::White),
        ("double-gauss.50mm.toml", 5.6, Light::Line(450.0)),
        ("telephoto.250mm.dat", 8.0, Light::Design),
        ("double-gauss.50mm.toml", 5.6, Light::Line(650.0)),
    ];
    for lens in lenses.into_iter().take(by_tier(3, 5)) {
        let name = format!("{} in {:?}", lens.0, lens.2);
        let middle = RESOLUTION.map(|n| n / 2);
        let whole = [[0, 0], RESOLUTION];
        let first = job(lens, EdgeAxis::X, [0.0; 2], whole);
        let lens_of_job = real_lens(&first);
        let choices = ConditionChoices {
            film_distance: Some(lens_of_job.film_distance),
            image_height: Some(HEIGHTS[2]),
            ..ConditionChoices::default()
        };
        let mut conditions =
            ImagingConditions::new(&lens_of_job.prescription, choices).expect("a film");
        conditions.object_distance =
            (DISTANCE - lens_of_job.front_depth) / lens_of_job.units_per_mm;
        let grid = ImagingGrid { fields: 2, pupil: 128, threads: 2 };
        let quality =
            ImageQuality::new(&lens_of_job.prescription, conditions, grid).expect("glasses");
        // Luminance weighs the bands of white light.
        let line = |band: &Band| SpectralLine {
            nm: band.wavelength,
            weight: xyz_from_srgb(band.response)[1],
        };
        let lines: Vec<SpectralLine> = lens_of_job.bands.iter().map(line).collect();
        let trace_field = |height: f64| match lens.2 {
            Light::White => {
                let field = quality.trace_field_in(&lens_of_job.prescription, &lines, height, 128);
                field.expect("glasses").expect("light")
            }
            _ => quality.trace_field(height, 128).expect("light"),
        };
        for height in HEIGHTS {
            let field = quality.trace_field(height, 128).expect("light");
            // The region shows other fields too.
            let step = f64::from(SIDE) * PITCH / 5.0;
            let fields: Vec<FieldRays> =
                (-2..=2).map(|i| trace_field(height + step * f64::from(i))).collect();
            let Some(ObjectPoint::Near(object)) = field.chief(0).map(|chief| chief.object) else {
                panic!("an object on a plane")
            };
            // The picture shows the upper half of the chart in its upper half.
            let at = [object[0].abs(), object[1].abs()].map(|mm| mm * lens_of_job.units_per_mm);
            let y = f64::from(middle[1]) - field.reference.point[1].abs() / PITCH;
            let low = [middle[0] - SIDE / 2, y.round() as u32 - SIDE / 2];
            let crop = [low, low.map(|n| n + SIDE)];
            for axis in [EdgeAxis::X, EdgeAxis::Y] {
                // The light falls off to the corners, as on a flat field without the card.
                let flat = picture(&job(lens, axis, [9.0; 2], crop), Backend::Simd, 2);
                let mut seen = picture(&job(lens, axis, at, crop), Backend::Simd, 2);
                for (seen, flat) in seen.pixels.iter_mut().zip(&flat.pixels) {
                    *seen = [luminance(*seen) / luminance(*flat); 3];
                }
                let region = [[0, 0], [SIDE as usize; 2]];
                let edge = EdgeResponse::measure(&seen, region, |pixel| f64::from(pixel[1]));
                let edge = edge.unwrap_or_else(|error| panic!("{name} {height} {axis:?}: {error}"));
                assert_eq!(edge.axis, axis);
                assert!((edge.angle.abs() - DEGREES).abs() < 0.5, "{}", edge.angle);
                let (sin, cos) = edge.angle.to_radians().sin_cos();
                let mut worst: f64 = 0.0;
                for i in 1..=20 {
                    let f = 0.025 * f64::from(i);
                    let pixel = sinc(f * cos) * sinc(f * sin);
                    // The small part of the frequency in the other direction blurs on its own: to second order.
                    let parts = match axis {
                        EdgeAxis::X => [f * cos, f * sin.abs()],
                        EdgeAxis::Y => [f * sin.abs(), f * cos],
                    };
                    let near = fields.iter().map(|field| {
                        let axes = [FrequencyAxis::X, FrequencyAxis::Y];
                        let part = |(f, axis): (f64, FrequencyAxis)| {
                            field
                                .modulation(f / PITCH, axis, TransferMethod::Geometric, 0.0)
                                .expect("light")
                        };
                        parts.into_iter().zip(axes).map(part).product::<f64>()
                    });
                    let modulation = near.sum::<f64>() / fields.len() as f64;
                    let off = edge.at(f) - modulation * pixel;
                    worst = worst.max(off.abs());
                    println!("{f:.3} {:.4} {:.4} {off:+.4}", edge.at(f), modulation * pixel);
                }
                println!("{name} at {height} mm, {axis:?}: {worst:.4}");
                assert!(worst < 0.01, "{name} at {height} mm, {axis:?}: {worst}");
            }
        }
    }
}
