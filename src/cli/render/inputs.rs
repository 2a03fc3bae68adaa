//! Record of everything that determines the samples of a picture, for resume and merge.

use std::collections::BTreeMap;

use clap::CommandFactory;
use petzval_render::checkpoint::Inputs;
use petzval_render::job::Job;

use crate::cli::arguments::argv::parse_render;
use crate::cli::arguments::option_roles::in_inputs;
use crate::cli::{Arguments, Failure};

/// Returns everything that determines the samples of a job, whichever part of them is rendered.
/// `samples` is the number of samples per pixel of the whole picture.
pub(in crate::cli) fn inputs(argv: &[String], job: &Job, samples: u32) -> Result<Inputs, Failure> {
    Ok(Inputs::of_job(&parse_render(argv)?.picture.scene, job, samples, given(argv)?)?)
}

/// Returns the values of the recorded options, given or by default.
fn given(argv: &[String]) -> Result<BTreeMap<String, String>, Failure> {
    let command = Arguments::command();
    let matches = command.clone().try_get_matches_from(argv)?;
    let (Some((name, matches)), mut options) = (matches.subcommand(), BTreeMap::new()) else {
        return Ok(BTreeMap::new());
    };
    for argument in command.find_subcommand(name).into_iter().flat_map(clap::Command::get_arguments)
    {
        let Some(long) = argument.get_long().filter(|long| in_inputs(long)) else { continue };
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
        let argv: Vec<String> = line.split(' ').map(str::to_owned).collect();
        given(&argv).unwrap()
    }

    #[test]
    fn options_that_do_not_affect_the_samples_are_left_out() {
        let plain = options("petzval render a.pbrt");
        let aside = "petzval render b.pbrt -o x.exr --threads 2 --resume --half --backend scalar \
                     --checkpoint 5s --exposure 1 --shard 1/2 --memory 8GiB";
        assert_eq!(plain, options(aside));
        let other = options("petzval render a.pbrt --fstop 4 --assume-vd");
        assert_eq!(other["--fstop"], "4");
        assert_ne!(plain["--assume-vd"], other["--assume-vd"]);
    }
}
