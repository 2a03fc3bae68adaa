//! `petzval measure greys`: tone, noise and dynamic range from a picture of steps of grey.

use std::fmt::Write as _;
use std::path::PathBuf;

use petzval_base::io::{ReadContext, path_excerpt};
use petzval_image::{Picture, Transfer};
use petzval_render::prepare::settings;
use petzval_report::measurement::MeasurementReport;
use petzval_tools::chart_analysis::GreySteps;

use super::super::arguments::values::typed;
use super::super::{Failure, Outcome};
use super::results::ResultArguments;
use super::{divide, region_text, region_within, title_of, with_source};

/// Arguments of `petzval measure greys`.
#[derive(Debug, clap::Args)]
pub(super) struct GreysArguments {
    /// Picture: .exr, .hdr, .pfm, .png, .jpg, .tif
    picture: PathBuf,
    /// Region that the steps fill, without the frame of the chart, in pixels of the file; X1 and Y1 are not included
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = typed(settings::crop))]
    region: [[u32; 2]; 2],
    /// Picture of a white chart, by which the picture is divided: the light of the lens falls off to the corners
    #[arg(long, value_name = "PICTURE")]
    flat: Option<PathBuf>,
    #[command(flatten)]
    results: ResultArguments,
}

pub(super) fn run(arguments: &GreysArguments) -> Result<Outcome, Failure> {
    let GreysArguments { picture: path, region, flat, results } = arguments;
    let context = ReadContext::default();
    let mut picture = Picture::read_with(path, Transfer::Srgb, &context)?;
    let name = format!("--region {}", region_text(*region));
    let place = region_within(&name, *region, &picture, path)?;
    if let Some(flat) = flat {
        // Only the falloff is divided out: values keep their distance from saturation.
        let white = divide(&mut picture, flat, &[(name.clone(), place)], &context)? as f32;
        picture.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|value| value * white));
    }
    let greys = GreySteps::measure(&picture, place)
        .map_err(|error| format!("{name} of {}: {error}", path_excerpt(path)))?;
    let report =
        MeasurementReport::of_greys(title_of("Tone and noise", path), &greys, text_of(&greys));
    let json = with_source(greys.json(), path, Some(*region));
    results.finish(&context, &table(&greys), &report, &json)
}

fn table(greys: &GreySteps) -> String {
    let mut text = "step,reflectance,red,green,blue,noise,snr,deviation_stops\n".to_owned();
    for (i, step) in greys.steps.iter().enumerate() {
        let deviation = greys.deviation(step).map_or(String::new(), |d| format!("{d:.4}"));
        let [r, g, b] = step.mean;
        let _ = writeln!(
            text,
            "{},{:.6},{r:.6e},{g:.6e},{b:.6e},{:.6e},{:.4},{deviation}",
            i + 1,
            step.reflectance,
            step.noise,
            step.signal_to_noise()
        );
    }
    text
}

fn text_of(greys: &GreySteps) -> String {
    let range = match greys.dynamic_range() {
        Some(stops) => {
            format!("{stops:.2} stops, from the value 1 to a signal-to-noise ratio of 1")
        }
        None => "beyond the darkest step, whose signal-to-noise ratio is above 1".to_owned(),
    };
    let mut text = format!(
        "exposure {:.4}: the value of a reflectance of 1\ndynamic range {range}\n\n\
         step  reflectance     value     noise  SNR (dB)  from linear (stops)\n",
        greys.scale
    );
    for (i, step) in greys.steps.iter().enumerate() {
        let deviation = greys.deviation(step).map_or("dark".to_owned(), |d| format!("{d:+.3}"));
        let _ = writeln!(
            text,
            "{:>4}  {:>11.5}  {:>8.5}  {:>8.5}  {:>8.1}  {deviation:>19}",
            i + 1,
            step.reflectance,
            step.value(),
            step.noise,
            20.0 * step.signal_to_noise().log10()
        );
    }
    text
}
