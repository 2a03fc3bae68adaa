//! `petzval measure greys`: tone, noise and dynamic range from a picture of steps of grey.

use std::fmt::Write as _;

use petzval_base::io::ReadContext;
use petzval_report::measurement::MeasurementReport;
use petzval_tools::chart_analysis::GreySteps;

use super::super::{Failure, Outcome};
use super::region::{ChartRegion, RegionArguments};
use super::results::ResultArguments;
use super::title_of;

/// Arguments of `petzval measure greys`.
#[derive(Debug, clap::Args)]
pub(super) struct GreysArguments {
    #[command(flatten)]
    region: RegionArguments,
    #[command(flatten)]
    results: ResultArguments,
}

pub(super) fn run(arguments: &GreysArguments) -> Result<Outcome, Failure> {
    let GreysArguments { region, results } = arguments;
    let context = ReadContext::default();
    let ChartRegion { mut picture, place, white } = region.read(&context)?;
    if let Some(white) = white {
        // Only the falloff is divided out: values keep their distance from saturation.
        let pixels = picture.pixels.iter_mut().flatten();
        pixels.for_each(|value| *value *= white as f32);
    }
    let greys = GreySteps::measure(&picture, place).map_err(|error| region.fault(&error))?;
    let report = MeasurementReport::of_greys(
        title_of("Tone and noise", &region.picture),
        &greys,
        text_of(&greys),
    );
    let json = region.with_source(greys.json());
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
