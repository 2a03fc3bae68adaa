//! `petzval measure shading`: falloff of light and colours from a picture of white.

use std::fmt::Write as _;
use std::path::PathBuf;

use petzval_base::io::{ReadContext, path_excerpt};
use petzval_image::{Picture, Transfer};
use petzval_report::measurement::MeasurementReport;
use petzval_tools::chart_analysis::{Shading, ShadingZone};

use super::super::{Failure, Outcome};
use super::results::ResultArguments;
use super::{title_of, with_source};

/// Rings of the table, of equal width.
const RINGS: usize = 10;

/// Arguments of `petzval measure shading`.
#[derive(Debug, clap::Args)]
pub(super) struct ShadingArguments {
    /// Picture of a white chart: .exr, .hdr, .pfm, .png, .jpg, .tif
    picture: PathBuf,
    #[command(flatten)]
    results: ResultArguments,
}

pub(super) fn run(arguments: &ShadingArguments) -> Result<Outcome, Failure> {
    let ShadingArguments { picture: path, results } = arguments;
    let context = ReadContext::default();
    let picture = Picture::read_with(path, Transfer::Srgb, &context)?;
    let shading =
        Shading::measure(&picture).map_err(|error| format!("{}: {error}", path_excerpt(path)))?;
    let report =
        MeasurementReport::of_shading(title_of("Shading", path), &shading, text_of(&shading));
    let json = with_source(shading.json(), path, None);
    results.finish(&context, &table(&shading), &report, &json)
}

fn table(shading: &Shading) -> String {
    let mut text = "x,y,field,light,red_over_green,blue_over_green\n".to_owned();
    for ShadingZone { middle: [x, y], field, light, colour } in &shading.zones {
        let colour = colour.map_or(",".to_owned(), |[red, blue]| format!("{red:.5},{blue:.5}"));
        let _ = writeln!(text, "{x:.1},{y:.1},{field:.4},{light:.5},{colour}");
    }
    text
}

fn text_of(shading: &Shading) -> String {
    let stops = |light: f64| format!("{:.2} % ({:+.3} stops)", 100.0 * light, light.log2());
    let corners = shading.corners();
    let [upper_left, upper_right, lower_left, lower_right] = corners.map(|zone| stops(zone.light));
    let mut text = format!(
        "light relative to the middle, {} x {} zones\n\
         corners (at {:.2} of the field): upper left {upper_left}, upper right {upper_right}, lower left {lower_left}, \
         lower right {lower_right}\n\
         least over most {:.4}, largest change of red or blue over green {:.4}\n\n\
         field        zones  light (%)   stops  red/green  blue/green\n",
        shading.size[0],
        shading.size[1],
        corners[0].field,
        shading.uniformity(),
        shading.colour_shading(),
    );
    for ring in 0..RINGS {
        let [low, high] = [ring, ring + 1].map(|i| i as f64 / RINGS as f64);
        let zones: Vec<&ShadingZone> =
            shading.zones.iter().filter(|zone| zone.field >= low && zone.field < high).collect();
        if zones.is_empty() {
            continue;
        }
        let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        let light = mean(zones.iter().map(|zone| zone.light).collect());
        let colours: Vec<[f64; 2]> = zones.iter().filter_map(|zone| zone.colour).collect();
        let ratio = |i: usize| match colours.is_empty() {
            true => "dark".to_owned(),
            false => format!("{:.4}", mean(colours.iter().map(|colour| colour[i]).collect())),
        };
        let _ = writeln!(
            text,
            "{low:.1} to {high:.1}  {:>7}  {:>9.2}  {:>+6.3}  {:>9}  {:>10}",
            zones.len(),
            100.0 * light,
            light.log2(),
            ratio(0),
            ratio(1),
        );
    }
    text
}
