//! Renders a scene file to a picture.
//!
//!     cargo run --release --example render -- SCENE PICTURE [SAMPLES]
//!     cargo run --release --example render -- scenes/dgauss.pbrt dgauss.png 16
//!
//! The extension of PICTURE selects the format: .exr, .png, .jpg or .tif.

use std::error::Error;
use std::path::Path;

use petzval_base::io::OutputFile;
use petzval_image::{DisplayExposure, EncodingOptions};
use petzval_render::prepare::{Changes, Prepared, prepare};
use petzval_render::{RenderOptions, render};
use petzval_scene_formats::pbrt;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (scene, picture, samples) = match arguments.as_slice() {
        [scene, picture] => (scene, picture, None),
        [scene, picture, samples] => (scene, picture, Some(samples.parse()?)),
        _ => return Err("usage: render SCENE PICTURE [SAMPLES]".into()),
    };

    // The description is what the file says; the job adds the lens, its focus and the plan of effects.
    let description = pbrt::read(Path::new(scene))?;
    let changes = Changes { samples, ..Changes::default() };
    let Prepared { job, notes, warnings } = prepare(description, &changes)?;
    for warning in &warnings {
        eprintln!("warning: {warning}");
    }
    for decision in job.plan.effects.iter().filter(|decision| decision.on) {
        println!("simulates {}: {}", decision.effect.name(), decision.reason);
    }

    // Zero threads means one for each core. The picture does not depend on their number.
    // The picture must not replace a file of the scene.
    let output = OutputFile::new(picture, &job.files)?;
    let exposed = render(&job, RenderOptions::default())?;
    let window = job.frame.window();
    // PNG, JPEG and TIFF need an exposure; EXR keeps the linear light as it is.
    let encoding =
        EncodingOptions { exposure: DisplayExposure::Auto, ..EncodingOptions::default() };
    exposed.into_picture(&job).write(&output, window, encoding, &notes)?;
    Ok(())
}
