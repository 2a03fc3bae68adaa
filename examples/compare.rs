//! Measures how far a picture is from a reference: relative mean squared error, and FLIP.
//!
//!     cargo run --release --example compare -- PICTURE REFERENCE
//!
//! Reads .exr, .hdr, .pfm, .png and .jpg. Both pictures must have the same size.

use std::error::Error;
use std::path::Path;

use petzval_image::Picture;
use petzval_tools::metric::{DynamicRange, Measurement, Metric, measure};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [picture, reference] = arguments.as_slice() else {
        return Err("usage: compare PICTURE REFERENCE".into());
    };
    let [a, b] = [picture, reference].map(|path| Picture::read(Path::new(path)));
    let (a, b) = (a?, b?);

    // FLIP of a picture that a display cannot show is a maximum over exposures.
    let is_hdr = |path: &String| [".exr", ".hdr", ".pfm"].iter().any(|end| path.ends_with(end));
    let range = match is_hdr(picture) || is_hdr(reference) {
        true => DynamicRange::High,
        false => DynamicRange::Low,
    };
    for metric in [Metric::RelMse, Metric::Flip] {
        let Measurement { value, map } = measure(metric, &a, &b, range)?;
        let (worst, most) = map.iter().enumerate().fold((0, f32::MIN), |worst, (i, &error)| {
            if error > worst.1 { (i, error) } else { worst }
        });
        let [x, y] = [worst % a.size[0], worst / a.size[0]];
        println!("{:<8}{value:.6}  largest at pixel {x},{y}: {most:.6}", metric.name());
    }
    Ok(())
}
