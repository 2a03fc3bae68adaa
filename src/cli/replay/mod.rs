//! `petzval replay`: one sample of a picture once more.

mod json;
mod line;
mod text;

use petzval::film::SampleName;
use petzval::job::{Changes, prepare};
use petzval::render::{Place, replay};
use petzval::scene::pbrt;

use super::message;
use super::picture::PictureArguments;
use super::values::{four, pixel};
use super::{BackendArgument, Failure, Outcome, PupilArgument};

pub(super) use line::command;

/// `petzval replay`
#[derive(Debug, clap::Args)]
pub(super) struct ReplayArguments {
    #[command(flatten)]
    picture: PictureArguments,
    /// The pixel, in the whole picture, also where a part of it is rendered
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pixel: [u32; 2],
    /// The number of the sample among those of the pixel, from 0; it need not be below --spp
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..1 << 30))]
    sample: u32,
    /// The seed of this sample, where --noise or --time gave it one of its own
    #[arg(long, value_name = "N")]
    sample_seed: Option<u32>,
    /// The part of the picture that was rendered
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = four)]
    crop: Option<[u32; 4]>,
    /// Where film points aim, as in petzval render
    #[arg(long, value_enum, default_value_t)]
    pupil: PupilArgument,
    /// Eight lanes or one. The answer is the same
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArgument,
    /// For programs: one JSON object
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &ReplayArguments) -> Result<Outcome, Failure> {
    let ReplayArguments { picture, pixel, sample, sample_seed, crop, pupil, backend, json } =
        arguments;
    let description = pbrt::read(&picture.scene)?;
    let changes = Changes {
        crop: crop.map(|[x0, y0, x1, y1]| [[x0, y0], [x1, y1]]),
        aim: (*pupil).into(),
        ..picture.changes()
    };
    let (job, _, warnings) = prepare(description, &changes)?;
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
    let name = SampleName::new(*pixel, *sample, sample_seed.unwrap_or(job.seed));
    let Some(replay) = replay(&job, (*backend).into(), name) else {
        let problem = "no light can come to it through the lens, so it takes no samples";
        return Err(format!("--pixel {x},{y}: {problem}").into());
    };
    let answer = match json {
        true => format!("{:#}\n", json::json(&job, &replay)),
        false => text::text(&job, &replay),
    };
    super::print(&answer)
}

/// Where a way breaks, in words.
fn words(place: Place) -> String {
    match place {
        Place::Ray => "the ray that leaves the lens".to_owned(),
        Place::Emission(step) => format!("the emission at surface {}", step + 1),
        Place::Light(step) => format!("the light sample at surface {}", step + 1),
        Place::Sum(step) => format!("the sum of the light after surface {}", step + 1),
        Place::Next(step) => format!("the ray that leaves surface {}", step + 1),
    }
}
