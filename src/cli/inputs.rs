//! What of a command line decides about a picture.

use std::collections::BTreeMap;

use clap::{CommandFactory, Parser};
use petzval::checkpoint::Inputs;
use petzval::render::Job;

use super::{Arguments, Command, Failure, RenderArguments};

/// Options that decide nothing about the samples, or whose outcome is listed instead.
const ASIDE: [&str; 19] = [
    "aov",
    "backend",
    "checkpoint",
    "contact",
    "crop",
    "exposure",
    "half",
    "help",
    "lens",
    "memory",
    "output",
    "resolution",
    "resume",
    "samples",
    "seed",
    "shard",
    "spp",
    "sweep",
    "threads",
];

/// The words of this command line.
pub(super) fn words() -> Vec<String> {
    let own = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    std::iter::once("petzval".to_owned()).chain(own).collect()
}

/// The words as a shell would take them.
pub(super) fn line(words: &[String]) -> String {
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// What a command line to render asks for.
pub(super) fn parsed(words: &[String]) -> Result<RenderArguments, Failure> {
    match Arguments::try_parse_from(words)?.command {
        Command::Render(arguments) => Ok(*arguments),
        _ => Err(format!("\"{}\" renders nothing", line(words)).into()),
    }
}

/// All that decides about the samples of a job that these words ask for, whatever part of them is
/// rendered; `samples` says how many a pixel has in the end.
pub(super) fn inputs(words: &[String], job: &Job, samples: u32) -> Result<Inputs, Failure> {
    let mut options = given(words)?;
    let mut set = |name: &str, value: String| options.insert(name.to_owned(), value);
    let frame = &job.frame;
    set("the number of samples", samples.to_string());
    set("the seed", job.seed.to_string());
    set("the resolution", format!("{}x{}", frame.resolution[0], frame.resolution[1]));
    let [[x0, y0], [x1, y1]] = [frame.low, frame.high];
    set("the rendered part", format!("{x0},{y0},{x1},{y1}"));
    set("the list of layers", format!("{:?}", job.layers).to_lowercase());
    Ok(Inputs::of(&parsed(words)?.picture.scene, job.files.clone(), options)?)
}

/// The values of options, given or by default.
fn given(words: &[String]) -> Result<BTreeMap<String, String>, Failure> {
    let command = Arguments::command();
    let matches = command.clone().try_get_matches_from(words)?;
    let (Some((name, matches)), mut options) = (matches.subcommand(), BTreeMap::new()) else {
        return Ok(BTreeMap::new());
    };
    for argument in command.find_subcommand(name).into_iter().flat_map(clap::Command::get_arguments)
    {
        let Some(long) = argument.get_long().filter(|long| !ASIDE.contains(long)) else { continue };
        if let Ok(Some(values)) = matches.try_get_raw(argument.get_id().as_str()) {
            let values: Vec<_> = values.map(|value| value.to_string_lossy()).collect();
            options.insert(format!("--{long}"), values.join(","));
        }
    }
    Ok(options)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(line: &str) -> BTreeMap<String, String> {
        let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        given(&words).unwrap()
    }

    #[test]
    fn options_that_decide_nothing_are_left_out() {
        let plain = options("petzval render a.pbrt");
        let aside = "petzval render b.pbrt -o x.exr --threads 2 --resume --half --backend scalar \
                     --checkpoint 5s --exposure 1 --shard 1/2 --memory 8GiB";
        assert_eq!(plain, options(aside));
        let other = options("petzval render a.pbrt --fstop 4 --assume-vd");
        assert_eq!(other["--fstop"], "4");
        assert_ne!(plain["--assume-vd"], other["--assume-vd"]);
    }

    #[test]
    fn words_are_quoted_where_a_shell_needs_it() {
        let words = ["petzval", "render", "a b's.pbrt", ""].map(str::to_owned);
        assert_eq!(line(&words), r"petzval render 'a b'\''s.pbrt' ''");
    }
}
