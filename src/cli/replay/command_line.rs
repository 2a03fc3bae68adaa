//! The command line that replays a sample of a render.

use clap::{ArgAction, CommandFactory};
use petzval::film::SampleId;

use crate::cli::Arguments;
use crate::cli::arguments::argv::{is_faithful, shell_line};

/// Returns the command that replays a sample of a render with this command line and seed.
pub(in crate::cli) fn replay_command(argv: &[String], name: &SampleId, seed: u32) -> String {
    let ([x, y], SampleId { sample, seed: of_sample, .. }) = (name.pixel(), *name);
    let mut own = format!("--pixel {x},{y} --sample {sample}");
    if of_sample != seed {
        own += &format!(" --sample-seed {of_sample}");
    }
    match replay_words(argv).filter(|_| is_faithful(argv)) {
        Some(words) => format!("{} {own}", shell_line(&words)),
        None => {
            let same = "the same scene and options (they are not UTF-8)";
            format!("petzval replay with {same} and {own}")
        }
    }
}

/// Returns the words of a render's command line that a replay accepts too.
fn replay_words(argv: &[String]) -> Option<Vec<String>> {
    let command = Arguments::command();
    let matches = command.clone().try_get_matches_from(argv).ok()?;
    let (_, given) = matches.subcommand()?;
    let mut options = Vec::new();
    let mut own = vec!["petzval".to_owned(), "replay".to_owned()];
    for argument in command.find_subcommand("replay")?.get_arguments() {
        let id = argument.get_id().as_str();
        // Options of a replay alone were not given; defaults are left out.
        let Ok(Some(values)) = given.try_get_raw(id) else { continue };
        let said = given.value_source(id) == Some(clap::parser::ValueSource::CommandLine);
        // Only what determines the sample, which is the same for each backend.
        if !said || id == "backend" {
            continue;
        }
        let values = values.map(|value| value.to_string_lossy());
        match (argument.get_long(), argument.get_action()) {
            (None, _) => own.extend(values.map(|value| match value.starts_with('-') {
                true => format!("./{value}"),
                false => value.into_owned(),
            })),
            (Some(long), ArgAction::SetTrue) => options.push(format!("--{long}")),
            (Some(long), _) => options.extend(values.map(|value| format!("--{long}={value}"))),
        }
    }
    own.extend(options);
    Some(own)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_determine_the_sample_are_kept() {
        let said = |words: &[&str], of_sample: u32| {
            let words: Vec<String> = words.iter().map(|&word| word.into()).collect();
            replay_command(&words, &SampleId::new([3, 4], 7, of_sample), 9)
        };
        let plain = ["petzval", "render", "a b.pbrt", "-o", "x.exr", "--threads", "2", "--half"];
        assert_eq!(said(&plain, 9), "petzval replay 'a b.pbrt' --pixel 3,4 --sample 7");
        let full = [
            "petzval",
            "render",
            "--noise=0.1",
            "--fstop",
            "4",
            "--effects",
            "-iris",
            "--assume-vd",
            "--crop",
            "1,2,8,9",
            "--sensor",
            "--seed=9",
            "--",
            "-a.pbrt",
        ];
        assert_eq!(
            said(&full, 5),
            "petzval replay ./-a.pbrt --seed=9 --fstop=4 --effects=-iris --assume-vd --sensor= \
             --crop=1,2,8,9 --pixel 3,4 --sample 7 --sample-seed 5"
        );
        assert!(said(&["petzval", "render", "\u{fffd}.pbrt"], 9).contains("with the same scene"));
    }
}
