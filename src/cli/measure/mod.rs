//! `petzval measure`: spatial frequency response of slanted edges, stars and texture, distortion, colours, tone, shading,
//! and the noise of a sensor.

mod colours;
mod greys;
mod grid;
mod noise;
mod region;
mod results;
mod shading;
mod star;
mod texture;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::{Subcommand, ValueEnum};
use colours::ColoursArguments;
use greys::GreysArguments;
use grid::GridArguments;
use noise::NoiseArguments;
use petzval_base::io::{ReadContext, path_excerpt};
use petzval_image::{Picture, Transfer};
use petzval_render::prepare::settings;
use petzval_report::measurement::MeasurementReport;
use petzval_tools::chart_analysis::{EdgeAxis, EdgeResponse, luminance};
use results::ResultArguments;
use serde_json::{Value, json};
use shading::ShadingArguments;
use star::StarArguments;
use texture::TextureArguments;

use super::arguments::values::{pixel_pitch, typed};
use super::{Failure, Outcome};

/// Arguments of `petzval measure`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(super) struct MeasureArguments {
    #[command(subcommand)]
    command: Option<MeasureCommand>,
    /// Picture: .exr, .hdr, .pfm, .png, .jpg, .tif
    #[arg(required = true)]
    picture: Option<PathBuf>,
    /// Region around one slanted edge, in pixels of the file; X1 and Y1 are not included. Give it again for
    /// another edge
    #[arg(long, value_name = "X0,Y0,X1,Y1", required = true, value_parser = typed(settings::crop))]
    edge: Vec<[[u32; 2]; 2]>,
    /// Channel to measure: luminance, red, green or blue
    #[arg(long, value_enum, default_value_t)]
    channel: Channel,
    /// Picture of a white chart, by which the picture is divided: the light of the lens falls off to the corners
    #[arg(long, value_name = "PICTURE")]
    flat: Option<PathBuf>,
    /// Pixel pitch (um), for frequencies in cycles/mm
    #[arg(long, value_name = "UM", value_parser = pixel_pitch)]
    pixel: Option<f64>,
    #[command(flatten)]
    results: ResultArguments,
}

#[derive(Debug, Subcommand)]
enum MeasureCommand {
    /// Measure colour errors from a picture of a colour checker
    Colours(ColoursArguments),
    /// Measure tone, noise and dynamic range from a picture of steps of grey
    Greys(GreysArguments),
    /// Measure distortion and lateral colour from a picture of a grid of dark dots
    Grid(GridArguments),
    /// Measure the noise of a sensor from pictures of uniform light (EMVA 1288): gain, read noise, DSNU,
    /// PRNU, full well
    Noise(NoiseArguments),
    /// Measure the falloff of light and colours from a picture of a white chart
    Shading(ShadingArguments),
    /// Measure the spatial frequency response of a sinusoidal Siemens star
    Star(StarArguments),
    /// Measure the response to texture from a picture of dead leaves
    Texture(TextureArguments),
}

/// A channel of a picture.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Channel {
    #[default]
    Luminance,
    Red,
    Green,
    Blue,
}

impl Channel {
    /// Returns the value of a pixel in linear sRGB.
    fn of(self, [r, g, b]: [f32; 3]) -> f64 {
        let [r, g, b] = [r, g, b].map(f64::from);
        match self {
            Self::Luminance => luminance([r, g, b]),
            Self::Red => r,
            Self::Green => g,
            Self::Blue => b,
        }
    }
}

pub(super) fn run(arguments: &MeasureArguments) -> Result<Outcome, Failure> {
    let MeasureArguments { command, picture, edge: regions, channel, flat, results, .. } =
        arguments;
    match command {
        Some(MeasureCommand::Colours(arguments)) => return colours::run(arguments),
        Some(MeasureCommand::Greys(arguments)) => return greys::run(arguments),
        Some(MeasureCommand::Shading(arguments)) => return shading::run(arguments),
        Some(MeasureCommand::Star(arguments)) => return star::run(arguments),
        Some(MeasureCommand::Grid(arguments)) => return grid::run(arguments),
        Some(MeasureCommand::Noise(arguments)) => return noise::run(arguments),
        Some(MeasureCommand::Texture(arguments)) => return texture::run(arguments),
        None => {}
    }
    let path = picture.as_ref().ok_or("expected the name of a picture")?;
    let context = ReadContext::default();
    let mut picture = Picture::read_with(path, Transfer::Srgb, &context)?;
    let file = path_excerpt(path);
    let mut places = Vec::new();
    for &[low, high] in regions {
        let name = format!("--edge {}", region_text([low, high]));
        places.push((name.clone(), region_within(&name, [low, high], &picture, path)?));
    }
    if let Some(flat) = flat {
        divide(&mut picture, flat, &places, &context)?;
    }
    let mut edges = Vec::new();
    for (name, region) in &places {
        let edge = EdgeResponse::measure(&picture, *region, |pixel| channel.of(pixel));
        edges.push(edge.map_err(|error| format!("{name} of {file}: {error}"))?);
    }
    let table: String =
        rows(&edges, EdgeResponse::frequencies()).iter().map(|row| row.join(",") + "\n").collect();
    let text = text_of(arguments, &edges);
    let report = MeasurementReport::of_edges(title_of("Slanted edges", path), &edges, text);
    results.finish(&context, &table, &report, &json_of(arguments, &edges))
}

/// Returns the value of an option that asks for a region.
pub(super) fn region_text([low, high]: [[u32; 2]; 2]) -> String {
    format!("{},{},{},{}", low[0], low[1], high[0], high[1])
}

/// Returns a region of a picture (pixels).
///
/// # Errors
/// Returns an error if it reaches beyond the picture. `name` is the option that asks for it.
fn region_within(
    name: &str,
    [low, high]: [[u32; 2]; 2],
    picture: &Picture,
    path: &Path,
) -> Result<[[usize; 2]; 2], Failure> {
    let [width, height] = picture.size;
    match (0..2).all(|i| low[i] < high[i] && high[i] as usize <= picture.size[i]) {
        true => Ok([low, high].map(|at| at.map(|n| n as usize))),
        false => Err(format!(
            "{name}: the picture {} has {width} x {height} pixels; expected X0,Y0,X1,Y1 within it",
            path_excerpt(path)
        )
        .into()),
    }
}

/// Divides a picture by that of a white chart, which must show white in these regions. Returns the mean luminance of
/// white there.
fn divide(
    picture: &mut Picture,
    flat: &Path,
    regions: &[(String, [[usize; 2]; 2])],
    context: &ReadContext,
) -> Result<f64, Failure> {
    let white = Picture::read_with(flat, Transfer::Srgb, context)?;
    let file = path_excerpt(flat);
    let ([width, height], expected) = (white.size, picture.size);
    if white.size != expected {
        return Err(format!(
            "--flat {file}: {width} x {height} pixels; expected {} x {}, as in the picture",
            expected[0], expected[1]
        )
        .into());
    }
    let (mut light, mut count) = (0.0, 0.0);
    for (_, [low, high]) in regions {
        for (y, x) in (low[1]..high[1]).flat_map(|y| (low[0]..high[0]).map(move |x| (y, x))) {
            let pixel = white.pixels[y * width + x];
            if pixel.iter().any(|&value| !(value > 0.0 && value.is_finite())) {
                return Err(format!(
                    "--flat {file}: pixel {x},{y} is {pixel:?}; expected light from a white chart, as of petzval chart \
                     flat"
                )
                .into());
            }
            light += luminance(pixel.map(f64::from));
            count += 1.0;
        }
    }
    for (pixel, white) in picture.pixels.iter_mut().zip(&white.pixels) {
        *pixel = [0, 1, 2].map(|c| pixel[c] / white[c]);
    }
    Ok(light / count)
}

/// Returns the responses: a row for each frequency, a column for each edge.
fn rows(edges: &[EdgeResponse], frequencies: impl Iterator<Item = f64>) -> Vec<Vec<String>> {
    let names = (1..=edges.len()).map(|i| format!("edge {i}"));
    let mut rows = vec![["cycles/pixel".to_owned()].into_iter().chain(names).collect()];
    rows.extend(frequencies.map(|frequency| {
        let responses = edges.iter().map(|edge| format!("{:.4}", edge.at(frequency)));
        [format!("{frequency:.2}")].into_iter().chain(responses).collect()
    }));
    rows
}

fn text_of(arguments: &MeasureArguments, edges: &[EdgeResponse]) -> String {
    let mut text = String::new();
    for (i, (edge, [low, high])) in edges.iter().zip(&arguments.edge).enumerate() {
        let along = match edge.axis {
            EdgeAxis::X => "x",
            EdgeAxis::Y => "y",
        };
        let frequency = |level: f64| match (edge.frequency_of(level), arguments.pixel) {
            (None, _) => "none below 2 cycles/pixel".to_owned(),
            (Some(f), None) => format!("{f:.3} cycles/pixel"),
            (Some(f), Some(pitch)) => {
                format!("{f:.3} cycles/pixel ({:.1} cycles/mm)", f / (pitch * 1e-3))
            }
        };
        let [dark, bright] = edge.levels;
        let _ = writeln!(
            text,
            "edge {} ({},{} to {},{}): frequencies along {along}, slant {:.2} degrees, levels {dark:.4} and \
             {bright:.4}, contrast {:.3}\n  MTF50 {}, MTF10 {}\n  rise from 10 to 90 % in {:.2} pixels",
            i + 1,
            low[0],
            low[1],
            high[0],
            high[1],
            edge.angle.abs(),
            edge.contrast(),
            frequency(0.5),
            frequency(0.1),
            edge.rise(),
        );
    }
    text.push('\n');
    // Every fifth frequency, up to Nyquist.
    for row in rows(edges, EdgeResponse::frequencies().step_by(5).take(11)) {
        let cells: String = row[1..].iter().map(|cell| format!("{cell:>10}")).collect();
        let _ = writeln!(text, "{:<14}{cells}", row[0]);
    }
    text
}

fn json_of(arguments: &MeasureArguments, edges: &[EdgeResponse]) -> Value {
    let one = |(edge, region): (&EdgeResponse, &[[u32; 2]; 2])| with_region(edge.json(), *region);
    json!({
        "picture": arguments.picture.as_ref().map(|path| path.display().to_string()),
        "pixel_um": arguments.pixel,
        "edges": edges.iter().zip(&arguments.edge).map(one).collect::<Vec<Value>>(),
    })
}

/// Returns the title of a report on a file.
fn title_of(measured: &str, path: &Path) -> String {
    format!("{measured} of {}", path.display())
}

/// Returns a result as JSON with the picture, and the region of it, that it was measured in.
fn with_source(mut found: Value, picture: &Path, region: Option<[[u32; 2]; 2]>) -> Value {
    found["picture"] = json!(picture.display().to_string());
    match region {
        Some(region) => with_region(found, region),
        None => found,
    }
}

fn with_region(mut found: Value, region: [[u32; 2]; 2]) -> Value {
    found["region"] = json!(region.as_flattened());
    found
}
