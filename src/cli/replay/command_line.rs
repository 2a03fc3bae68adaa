//! The command line that replays a sample of a render.

use petzval_render::film::SampleId;

use crate::cli::arguments::argv::{accepted_words, is_faithful, shell_line};

/// Returns the command that replays a sample of a render with this command line and seed.
pub(in crate::cli) fn replay_command(argv: &[String], name: &SampleId, seed: u32) -> String {
    let ([x, y], SampleId { sample, seed: of_sample, .. }) = (name.pixel(), *name);
    let mut own = format!("--pixel {x},{y} --sample {sample}");
    if of_sample != seed {
        own += &format!(" --sample-seed {of_sample}");
    }
    match accepted_words(argv, "replay").filter(|_| is_faithful(argv)) {
        Some(words) => format!("{} {own}", shell_line(&words)),
        None => {
            let same = "the same scene and options (they are not UTF-8)";
            format!("petzval replay with {same} and {own}")
        }
    }
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
