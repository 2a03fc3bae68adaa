//! `petzval measure texture`: response to the fine random detail of dead leaves.

use std::fmt::Write as _;
use std::path::PathBuf;

use petzval_base::io::{ReadContext, path_excerpt};
use petzval_image::{Picture, Transfer};
use petzval_render::prepare::settings;
use petzval_report::measurement::MeasurementReport;
use petzval_tools::chart_analysis::TextureResponse;

use super::super::arguments::values::typed;
use super::super::{Failure, Outcome};
use super::results::ResultArguments;
use super::{Channel, region_text, region_within, title_of, with_source};

/// Arguments of `petzval measure texture`.
#[derive(Debug, clap::Args)]
pub(super) struct TextureArguments {
    /// Picture: .exr, .hdr, .pfm, .png, .jpg, .tif
    picture: PathBuf,
    /// Region that shows the whole square of leaves, in pixels of the file; X1 and Y1 are not included
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = typed(settings::crop))]
    region: [[u32; 2]; 2],
    /// Picture of the leaves, as petzval chart leaves writes it beside the scene
    #[arg(long, value_name = "PICTURE")]
    chart: PathBuf,
    /// Picture of the same chart with other noise, as of another --seed: the noise of neither counts as texture then
    #[arg(long, value_name = "PICTURE")]
    second: Option<PathBuf>,
    /// Channel to measure: luminance, red, green or blue
    #[arg(long, value_enum, default_value_t)]
    channel: Channel,
    #[command(flatten)]
    results: ResultArguments,
}

pub(super) fn run(arguments: &TextureArguments) -> Result<Outcome, Failure> {
    let TextureArguments { picture: path, region, chart, second, channel, results } = arguments;
    let context = ReadContext::default();
    let read = |path: &PathBuf| Picture::read_with(path, Transfer::Srgb, &context);
    let (picture, chart) = (read(path)?, read(chart)?);
    let name = format!("--region {}", region_text(*region));
    let place = region_within(&name, *region, &picture, path)?;
    let second = match second {
        None => None,
        Some(path) => {
            let second = read(path)?;
            region_within(&name, *region, &second, path)?;
            Some(second)
        }
    };
    let pictures = [&picture, second.as_ref().unwrap_or(&picture)];
    let texture = TextureResponse::measure(pictures, place, &chart, |pixel| channel.of(pixel))
        .map_err(|error| format!("{}: {error}", path_excerpt(path)))?;
    let report = MeasurementReport::of_texture(
        title_of("Texture", path),
        &texture,
        table(&texture, "  ", 12),
    );
    let json = with_source(texture.json(), path, Some(*region));
    results.finish(&context, &table(&texture, ",", 0), &report, &json)
}

/// Returns the response, a row for each frequency, in columns of at least this width.
fn table(texture: &TextureResponse, between: &str, width: usize) -> String {
    let mut text = format!("cycles/pixel{between}response\n");
    for [frequency, response] in &texture.response {
        let _ = writeln!(text, "{frequency:<width$.2}{between}{response:.4}");
    }
    text
}
