//! `petzval compare`

use petzval::image::{Encoding, Format, ImageError, Picture, Window};
use petzval::metric::{Metric, measure};
use petzval::source::{reading, shown};
use serde_json::{Map, Value, json};

use super::outputs::{check_distinct, check_writable};
use super::{CompareArguments, Failure, Outcome};

pub(super) fn run(arguments: &CompareArguments) -> Result<Outcome, Failure> {
    let CompareArguments { picture: a, reference: b, metric, map, fail_above, json, .. } =
        arguments;
    let (read, files) = reading(|| [a, b].map(|path| Picture::read(path, true)));
    let [picture, reference] = read;
    let [picture, reference] = [picture?, reference?];
    if let Some(map) = map {
        Format::of(map)?;
        check_distinct([map], "--map", &files)?;
        check_writable(map, "--map")?;
    }
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
            let found = format!("pixel {x},{y} is {:?}, which is no light", picture.pixels[i]);
            return Err(ImageError::Malformed { path: path.clone(), found }.into());
        }
    }
    let hdr = [a, b].iter().any(|path| !matches!(Format::of(path), Ok(Format::Png | Format::Jpeg)));
    let metrics = if metric.is_empty() { &Metric::ALL[..] } else { metric };
    let mut values = Vec::new();
    let mut first = None;
    for &metric in metrics {
        let (value, off) = measure(metric, &picture, &reference, hdr);
        if value.is_nan() {
            let (name, [a, b]) = (metric.name(), [a, b].map(|path| shown(path)));
            let problem = "is no number; expected pictures with pixels, and none near 3e38";
            return Err(format!("{name} of {a} and {b} {problem}").into());
        }
        values.push((metric, value));
        first.get_or_insert(off);
    }
    if let (Some(path), Some(off)) = (map, first) {
        let most = off.iter().copied().fold(0.0, f32::max).max(f32::MIN_POSITIVE);
        // FLIP has a scale of its own; the others are shown by the largest.
        let scale = if metrics[0] == Metric::Flip { 1.0 } else { 1.0 / most };
        let pixels = off.iter().map(|&off| heat(off * scale)).collect();
        let size = picture.size;
        let window = Window { origin: [0, 0], frame: size.map(|n| n as u32) };
        Picture { size, pixels }.write(path, window, Encoding::default(), &Vec::new())?;
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
    let (judged, value) = values[0];
    let failed = if judged.rises() { value < limit && fail_above.is_some() } else { value > limit };
    if failed {
        let over = if judged.rises() { "below" } else { "above" };
        say!("petzval: {} is {value:.6}, {over} {limit}", judged.name());
        return Ok(Outcome::Different);
    }
    Ok(Outcome::Done)
}

/// A colour for a number from 0, black, over red and yellow to 1, white: linear light of what
/// a display shows evenly.
fn heat(value: f32) -> [f32; 3] {
    let v = 3.0 * value.clamp(0.0, 1.0);
    [v, v - 1.0, v - 2.0].map(|c| petzval::image::srgb_decode(c.clamp(0.0, 1.0)))
}
