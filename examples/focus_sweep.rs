//! Photographs one scene focused at several distances.
//!
//!     cargo run --release --example focus_sweep -- SCENE FOLDER DISTANCE...
//!     cargo run --release --example focus_sweep -- scenes/dgauss.pbrt out 2 4 8 inf
//!
//! Writes FOLDER/focus-DISTANCE.png for each distance [m from the film].

use std::error::Error;
use std::path::Path;

use petzval_base::io::OutputFile;
use petzval_image::{DisplayExposure, EncodingOptions};
use petzval_render::prepare::{Changes, FocusOn, Prepared, prepare};
use petzval_render::{RenderOptions, render};
use petzval_scene_formats::pbrt;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, folder, distances @ ..] = arguments.as_slice() else {
        return Err("usage: focus_sweep SCENE FOLDER DISTANCE...".into());
    };
    std::fs::create_dir_all(folder)?;

    // The scene is read once: clones of the description share its meshes, textures and tree.
    let description = pbrt::read(Path::new(scene))?;
    for distance in distances {
        let changes = Changes {
            focus: Some(FocusOn::Distance(distance.parse()?)),
            samples: Some(16),
            resolution: Some([320, 320]),
            ..Changes::default()
        };
        let Prepared { job, notes, .. } = prepare(description.clone(), &changes)?;
        let exposed = render(&job, RenderOptions::default())?;

        let path = Path::new(folder).join(format!("focus-{distance}.png"));
        let output = OutputFile::new(&path, &job.files)?;
        let window = job.frame.window();
        let encoding =
            EncodingOptions { exposure: DisplayExposure::Auto, ..EncodingOptions::default() };
        exposed.into_picture(&job).write(&output, window, encoding, &notes)?;
        println!("{}", path.display());
    }
    Ok(())
}
