//! Renders a scene file to a picture.
//!
//!     cargo run --release --example render -- SCENE PICTURE [SAMPLES]
//!     cargo run --release --example render -- scenes/dgauss.pbrt dgauss.png 16
//!
//! The extension of PICTURE selects the format: .exr, .png or .jpg.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use petzval::image::{Encoding, Exposure, Window};
use petzval::job::{Changes, prepare};
use petzval::render::{Backend, Progress, render};
use petzval::scene::pbrt;

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
    let (scene, picture, samples) = match words.as_slice() {
        [scene, picture] => (scene, picture, None),
        [scene, picture, samples] => (scene, picture, Some(samples.parse()?)),
        _ => return Err("usage: render SCENE PICTURE [SAMPLES]".into()),
    };

    // The description is what the file says; the job adds the lens, its focus and the plan of effects.
    let description = pbrt::read(Path::new(scene))?;
    let changes = Changes { samples, ..Changes::default() };
    let (job, notes, warnings) = prepare(description, &changes)?;
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }
    for decision in job.plan.effects.iter().filter(|decision| decision.on) {
        println!("simulates {}: {}", decision.effect.name(), decision.reason);
    }

    // Zero threads means one for each core. The picture does not depend on their number.
    let exposed = render(&job, Backend::Simd, 0, &Progress::default())?;
    let window = Window { origin: job.frame.low, frame: job.frame.resolution };
    // PNG and JPEG need an exposure; EXR keeps the linear light as it is.
    let encoding = Encoding { exposure: Exposure::Auto, ..Encoding::default() };
    exposed.into_picture(&job).write(Path::new(picture), window, encoding, &notes)?;
    Ok(())
}
