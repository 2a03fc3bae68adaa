//! `petzval replay`: repeats one sample of a picture and shows its path.

mod command_line;
mod json;
mod text;

use petzval_render::film::SampleId;
use petzval_render::prepare::{Changes, Prepared, prepare, settings};
use petzval_render::{PathStage, replay};

use super::arguments::values::{pixel, typed};
use super::arguments::{BackendArgument, PictureArguments, PupilArgument};
use super::{Failure, Outcome, message};

pub(super) use command_line::replay_command;

/// Arguments of `petzval replay`.
#[derive(Debug, clap::Args)]
pub(super) struct ReplayArguments {
    #[command(flatten)]
    picture: PictureArguments,
    /// Pixel in the whole picture, also with --crop
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pixel: [u32; 2],
    /// Index of the sample in the pixel, from 0; it need not be below --spp
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..1 << 30))]
    sample: u32,
    /// Seed of this sample, if --noise or --time gave it one of its own
    #[arg(long, value_name = "N")]
    sample_seed: Option<u32>,
    /// Part of the picture that was rendered
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = typed(settings::crop))]
    crop: Option<[[u32; 2]; 2]>,
    /// Target of rays from the film, as for petzval render
    #[arg(long, value_enum, default_value_t)]
    pupil: PupilArgument,
    /// Rays per kernel call: eight lanes or one
    ///
    /// The result is the same
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArgument,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &ReplayArguments) -> Result<Outcome, Failure> {
    let ReplayArguments { picture, pixel, sample, sample_seed, crop, pupil, backend, json } =
        arguments;
    let description = petzval_scene_formats::read(&picture.scene)?;
    let aim = (*pupil).into();
    let changes = Changes { crop: *crop, aim, holds_spectra: true, ..picture.changes() };
    let Prepared { job, warnings, .. } = prepare(description, &changes)?;
    message::warnings(&warnings);
    let (frame, [x, y]) = (&job.frame, *pixel);
    if (0..2).any(|i| pixel[i] < frame.low[i] || pixel[i] >= frame.high[i]) {
        let [[x0, y0], [x1, y1]] = [frame.low, frame.high];
        let problem = format!(
            "--pixel {x},{y}: expected X from {x0} to {} and Y from {y0} to {}",
            x1 - 1,
            y1 - 1
        );
        return Err(problem.into());
    }
    let name = SampleId::new(*pixel, *sample, sample_seed.unwrap_or(job.seed));
    let Some(replay) = replay(&job, (*backend).into(), name) else {
        let problem = "no light can reach it through the lens, so it takes no samples";
        return Err(format!("--pixel {x},{y}: {problem}").into());
    };
    let result = match json {
        true => format!("{:#}\n", json::json(&job, &replay)),
        false => text::text(&job, &replay),
    };
    super::print(&result)
}

/// Describes the first value of a path that is not finite.
fn describe(place: PathStage) -> String {
    match place {
        PathStage::Ray => "the ray that leaves the lens".to_owned(),
        PathStage::Emission(step) => format!("the emission at surface {}", step + 1),
        PathStage::Light(step) => format!("the light sample at surface {}", step + 1),
        PathStage::Sum(step) => format!("the sum of the light after surface {}", step + 1),
        PathStage::Next(step) => format!("the ray that leaves surface {}", step + 1),
    }
}
