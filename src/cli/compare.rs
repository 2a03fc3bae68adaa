//! `petzval compare`: error metrics between two pictures.

use std::path::PathBuf;

use petzval_base::io::{Outputs, ReadContext, path_excerpt};
use petzval_image::{EncodingOptions, ImageError, ImageFormat, Picture, PictureWindow, Transfer};
use petzval_tools::metric::{DynamicRange, Measurement, Metric, measure};
use serde_json::{Map, Value, json};

use super::arguments::values::limit;
use super::outputs::claim_writable;
use super::{Failure, Outcome};

/// Arguments of `petzval compare`.
#[derive(Debug, clap::Args)]
pub(super) struct CompareArguments {
    /// Picture: .exr, .hdr, .pfm, .png, .jpg, .tif
    picture: PathBuf,
    /// Reference picture
    reference: PathBuf,
    /// Metrics to compute, any of mse, relmse, mape, flip, psnr; all by default
    #[arg(long, value_name = "METRIC", value_delimiter = ',')]
    metric: Vec<Metric>,
    /// Write a map of the first metric
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Exit with code 1 if the first metric is larger (psnr: smaller) than this
    #[arg(long, value_name = "X", value_parser = limit, allow_hyphen_values = true)]
    fail_above: Option<f64>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &CompareArguments) -> Result<Outcome, Failure> {
    let CompareArguments { picture: a, reference: b, metric, map, fail_above, json, .. } =
        arguments;
    let context = ReadContext::default();
    let read = |path| Picture::read_with(path, Transfer::Srgb, &context);
    let (picture, reference) = (read(a)?, read(b)?);
    let map = match map {
        Some(map) => {
            ImageFormat::of(map)?;
            Some(claim_writable(&Outputs::beside(&context.files()), map, "--map")?)
        }
        None => None,
    };
    if picture.size != reference.size {
        let [[w, h], [v, g]] = [picture.size, reference.size];
        return Err(format!(
            "{} has {w} x {h} pixels and {} {v} x {g}; only pictures of one size can be compared",
            a.display(),
            b.display()
        )
        .into());
    }
    for (path, picture) in [(a, &picture), (b, &reference)] {
        if let Some(i) = picture.pixels.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
            let [x, y] = [i % picture.size[0], i / picture.size[0]];
            let found = format!("pixel {x},{y} is {:?}, which is not finite", picture.pixels[i]);
            return Err(ImageError::Malformed { path: path.clone(), found }.into());
        }
    }
    let is_display = |path| ImageFormat::of(path).is_ok_and(|format| !format.is_linear());
    let range = if is_display(a) && is_display(b) { DynamicRange::Low } else { DynamicRange::High };
    let metrics = if metric.is_empty() { &Metric::ALL[..] } else { metric };
    let mut values = Vec::new();
    let mut first_map = None;
    for &metric in metrics {
        let Measurement { value, map } = measure(metric, &picture, &reference, range)?;
        if value.is_nan() {
            let (name, [a, b]) = (metric.name(), [a, b].map(|path| path_excerpt(path)));
            let problem =
                "is not finite; expected pictures that are not empty, with values far below 3e38";
            return Err(format!("{name} of {a} and {b} {problem}").into());
        }
        values.push((metric, value));
        first_map.get_or_insert(map);
    }
    if let (Some(file), Some(errors)) = (map, first_map) {
        let most = errors.iter().copied().fold(0.0, f32::max).max(f32::MIN_POSITIVE);
        // FLIP is at most 1; the other metrics are scaled by their largest value.
        let scale = if metrics[0] == Metric::Flip { 1.0 } else { 1.0 / most };
        let pixels = errors.iter().map(|&error| heat(error * scale)).collect();
        let size = picture.size;
        let window = PictureWindow { origin: [0, 0], frame: size.map(|n| n as u32) };
        Picture { size, pixels }.write(&file, window, EncodingOptions::default(), &Vec::new())?;
    }
    let text = if *json {
        let finite = |&(metric, value): &(Metric, f64)| {
            (metric.name().to_owned(), if value.is_finite() { json!(value) } else { json!("inf") })
        };
        format!("{:#}\n", Value::Object(values.iter().map(finite).collect::<Map<_, _>>()))
    } else {
        values.iter().map(|(metric, value)| format!("{:<8}{value:.6e}\n", metric.name())).collect()
    };
    super::print(&text)?;
    let limit = fail_above.unwrap_or(f64::INFINITY);
    let (metric, value) = values[0];
    let failed = match metric.higher_is_better() {
        true => value < limit && fail_above.is_some(),
        false => value > limit,
    };
    if failed {
        let side = if metric.higher_is_better() { "below" } else { "above" };
        say!("petzval: {} is {value:.6}, {side} {limit}", metric.name());
        return Ok(Outcome::Different);
    }
    Ok(Outcome::Done)
}

/// Maps 0..1 to black, red, yellow and white in even steps of the display, as linear light.
fn heat(value: f32) -> [f32; 3] {
    let v = 3.0 * value.clamp(0.0, 1.0);
    [v, v - 1.0, v - 2.0].map(|c| petzval_image::srgb_decode(c.clamp(0.0, 1.0)))
}
