//! `petzval measure star`: spatial frequency response of a sinusoidal Siemens star.

use std::fmt::Write as _;

use petzval_base::io::ReadContext;
use petzval_report::measurement::MeasurementReport;
use petzval_tools::chart_analysis::{StarChart, StarResponse};

use super::super::{Failure, Outcome};
use super::region::{ChartRegion, RegionArguments};
use super::results::ResultArguments;
use super::{Channel, title_of};

/// Arguments of `petzval measure star`.
#[derive(Debug, clap::Args)]
pub(super) struct StarArguments {
    #[command(flatten)]
    region: RegionArguments,
    /// Cycles around the star
    #[arg(long, value_name = "N", default_value_t = StarChart::default().cycles as u32,
        value_parser = clap::value_parser!(u32).range(8..=720))]
    cycles: u32,
    /// Modulation of the star on its chart: 0.6 for a contrast of 4:1
    #[arg(long, value_name = "M", default_value_t = StarChart::default().modulation, value_parser = modulation)]
    modulation: f64,
    /// Channel to measure: luminance, red, green or blue
    #[arg(long, value_enum, default_value_t)]
    channel: Channel,
    #[command(flatten)]
    results: ResultArguments,
}

/// Parses a modulation.
fn modulation(text: &str) -> Result<f64, String> {
    let modulation = text.parse().ok().filter(|m: &f64| (0.01..=1.0).contains(m));
    modulation.ok_or_else(|| "expected a modulation from 0.01 to 1".to_owned())
}

pub(super) fn run(arguments: &StarArguments) -> Result<Outcome, Failure> {
    let StarArguments { region, channel, results, .. } = arguments;
    let context = ReadContext::default();
    let ChartRegion { picture, place, .. } = region.read(&context)?;
    let chart = StarChart { cycles: f64::from(arguments.cycles), modulation: arguments.modulation };
    let star = StarResponse::measure(&picture, place, chart, |pixel| channel.of(pixel))
        .map_err(|error| region.fault(&error))?;
    let report = MeasurementReport::of_star(
        title_of("Siemens star", &region.picture),
        &star,
        text_of(&star),
    );
    let json = region.with_source(star.json());
    results.finish(&context, &table(&star), &report, &json)
}

fn table(star: &StarResponse) -> String {
    let segments: Vec<String> = (0..star.rings.first().map_or(0, |ring| ring.segments.len()))
        .map(|i| format!("{} degrees", 22.5 + 45.0 * i as f64))
        .collect();
    let mut text = format!("cycles/pixel,mean,{}\n", segments.join(","));
    for ring in &star.rings {
        let segments: Vec<String> = ring.segments.iter().map(|r| format!("{r:.4}")).collect();
        let _ = writeln!(text, "{:.2},{:.4},{}", ring.frequency, ring.mean(), segments.join(","));
    }
    text
}

fn text_of(star: &StarResponse) -> String {
    let level = |level| {
        star.frequency_of(level)
            .map_or("none up to Nyquist".into(), |f| format!("{f:.3} cycles/pixel"))
    };
    let mut text = format!(
        "centre {:.2},{:.2}\nMTF50 {}, MTF10 {}\n\ncycles/pixel    mean   least    most\n",
        star.centre[0],
        star.centre[1],
        level(0.5),
        level(0.1)
    );
    let last = star.rings.len().saturating_sub(1);
    for ring in star
        .rings
        .iter()
        .enumerate()
        .filter(|(i, _)| (last - i).is_multiple_of(5))
        .map(|(_, ring)| ring)
    {
        let [least, most] = ring.range();
        let _ =
            writeln!(text, "{:<12.2}{:>8.4}{least:>8.4}{most:>8.4}", ring.frequency, ring.mean());
    }
    text
}
