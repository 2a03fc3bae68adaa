//! Measures how far a picture is from a reference: relative mean squared error, and FLIP.
//!
//!     cargo run --release --example compare -- PICTURE REFERENCE
//!
//! Reads .exr, .hdr, .pfm, .png and .jpg. Both pictures must have the same size.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use petzval::image::Picture;
use petzval::metric::{Metric, measure};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [picture, reference] = words.as_slice() else {
        return Err("usage: compare PICTURE REFERENCE".into());
    };
    let [a, b] = [picture, reference].map(|path| Picture::read(Path::new(path), true));
    let (a, b) = (a?, b?);
    if a.size != b.size {
        return Err(format!("the sizes differ: {:?} and {:?} pixels", a.size, b.size).into());
    }

    // FLIP of a picture that a display cannot show is a maximum over exposures.
    let is_hdr = |path: &String| [".exr", ".hdr", ".pfm"].iter().any(|end| path.ends_with(end));
    let hdr = is_hdr(picture) || is_hdr(reference);
    for metric in [Metric::RelMse, Metric::Flip] {
        let (value, map) = measure(metric, &a, &b, hdr);
        let (worst, most) = map.iter().enumerate().fold((0, f32::MIN), |worst, (i, &error)| {
            if error > worst.1 { (i, error) } else { worst }
        });
        let [x, y] = [worst % a.size[0], worst / a.size[0]];
        println!("{:<8}{value:.6}  largest at pixel {x},{y}: {most:.6}", metric.name());
    }
    Ok(())
}
