//! Plan of a sweep: the values and the command line of each picture.
//!
//! The command line of a picture is that of the sweep with values in place of the --sweep options.

use std::collections::BTreeSet;
use std::path::Path;

use clap::CommandFactory;
use clap::parser::ValueSource;
use petzval_base::io::hint;

use super::axis::{MAX_PICTURES, SweepAxis};
use super::template::Template;
use crate::cli::arguments::argv::{is_faithful, parse_render, shell_line};
use crate::cli::arguments::option_roles::{SweepRole, sweep_role};
use crate::cli::render::RenderArguments;
use crate::cli::{Arguments, Failure};
use petzval_report::contact_sheet::SheetAxis;

/// The pictures of a sweep, as far as its command line determines them.
pub(super) struct SweepPlan {
    pub axes: Vec<SweepAxis>,
    /// The command line without options about all pictures.
    argv: Vec<String>,
    pub(super) template: Template,
    /// The name with placeholders, as given.
    pub(super) template_text: String,
}

impl SweepPlan {
    /// Checks the command line of a sweep, and the values of its options.
    ///
    /// # Errors
    /// Returns an error if an option cannot be swept, or a value or the name's template is invalid.
    pub fn new(arguments: &RenderArguments, argv: &[String]) -> Result<Self, Failure> {
        if !is_faithful(argv) {
            return Err("--sweep: this command line is not UTF-8".into());
        }
        for (given, name) in
            [(arguments.shard.is_some(), "--shard"), (arguments.samples.is_some(), "--samples")]
        {
            if given {
                let problem = "with --sweep: give each machine values of its own instead, and a \
                               --contact of its own, such as seed=0..9:10 and seed=10..19:10";
                return Err(format!("{name} {problem}").into());
            }
        }
        let axes = arguments.sweep.clone();
        let template_text = match &arguments.output {
            Some(output) => output.to_string_lossy().into_owned(),
            None => {
                let places = axes.iter().map(|axis| format!("_{{{}}}", axis.name));
                format!("{{scene}}{}.exr", places.collect::<String>())
            }
        };
        let template = Template::parse(&template_text).map_err(|error| format!("-o {error}"))?;
        let plan = Self { axes, argv: without_sweep(argv), template, template_text };
        plan.check_options(argv)?;
        let counts = plan.axes.iter().map(|axis| axis.values.len());
        if counts.clone().try_fold(1, usize::checked_mul).is_none_or(|count| count > MAX_PICTURES) {
            let counts: Vec<String> = counts.map(|count| count.to_string()).collect();
            let counts = counts.join(" x ");
            return Err(format!("--sweep: {counts} pictures are more than {MAX_PICTURES}").into());
        }
        plan.check_values()?;
        Ok(plan)
    }

    /// Returns the number of pictures.
    pub fn count(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// Returns the options with their values, for the contact sheet.
    pub fn sheet_axes(&self) -> Vec<SheetAxis> {
        let shown =
            |axis: &SweepAxis| SheetAxis { name: axis.name.clone(), values: axis.values.clone() };
        self.axes.iter().map(shown).collect()
    }

    /// Returns the values of a picture, by option.
    pub fn values(&self, number: usize) -> Vec<&str> {
        let mut left = number;
        let mut values: Vec<&str> = Vec::new();
        for axis in self.axes.iter().rev() {
            values.push(&axis.values[left % axis.values.len()]);
            left /= axis.values.len();
        }
        values.reverse();
        values
    }

    /// Returns the number of the picture that has the values with these indices.
    pub fn number(&self, indices: &[usize]) -> usize {
        self.axes.iter().zip(indices).fold(0, |sum, (axis, at)| sum * axis.values.len() + at)
    }

    /// Returns the command line of a picture.
    pub fn argv(&self, number: usize, output: &Path) -> Vec<String> {
        let output = format!("--output={}", output.display());
        self.with(&self.values(number), Some(output))
    }

    fn with(&self, values: &[&str], output: Option<String>) -> Vec<String> {
        let set =
            self.axes.iter().zip(values).map(|(axis, value)| format!("--{}={value}", axis.name));
        let set: Vec<String> = set.chain(output).collect();
        let mut argv = self.argv.clone();
        argv.splice(2..2, set);
        argv
    }

    /// Checks that each option exists, can be swept, and is given once.
    fn check_options(&self, argv: &[String]) -> Result<(), Failure> {
        let command = Arguments::command();
        let matches = command.clone().try_get_matches_from(argv)?;
        let (Some(render), Some((_, matches))) =
            (command.find_subcommand("render"), matches.subcommand())
        else {
            return Err(format!("\"{}\" is not a petzval render command", shell_line(argv)).into());
        };
        let mut seen = BTreeSet::new();
        for SweepAxis { text, name, .. } in &self.axes {
            let refuse = |problem: String| Err(format!("--sweep {text}: {problem}").into());
            let options =
                || render.get_arguments().filter(|argument| argument.get_long().is_some());
            let Some(option) = options().find(|option| option.get_long() == Some(name)) else {
                let near = hint(name, options().filter_map(clap::Arg::get_long));
                return refuse(format!("petzval render has no --{name}{near}"));
            };
            if sweep_role(name) == SweepRole::Whole {
                return refuse(format!("--{name} has one value for the whole sweep"));
            }
            if !option.get_action().takes_values() {
                return refuse(format!("--{name} takes no values"));
            }
            if matches.value_source(option.get_id().as_str()) == Some(ValueSource::CommandLine) {
                return refuse(format!("--{name} is given, too; give one of the two"));
            }
            if !seen.insert(name) {
                return refuse(format!("--{name} is swept twice; put all values into one list"));
            }
        }
        Ok(())
    }

    /// Checks that each option accepts its values.
    fn check_values(&self) -> Result<(), Failure> {
        let first = self.values(0);
        for (place, SweepAxis { text, values, .. }) in self.axes.iter().enumerate() {
            let parsed = |value: &str| {
                let mut all = first.clone();
                all[place] = value;
                parse_render(&self.with(&all, None))
            };
            for value in values {
                let Err(error) = parsed(value) else { continue };
                let said = error.to_string();
                let said = said.lines().next().unwrap_or_default();
                let said = said.strip_prefix("error: ").unwrap_or(said);
                let list = text.split_once('=').map_or("", |(_, list)| list);
                let hint = match value.contains("..") {
                    true => "; a range reads FIRST..LAST:COUNT",
                    false if list.contains(',') && parsed(list).is_ok() => {
                        "; separate values that contain commas with ;"
                    }
                    false => "",
                };
                return Err(format!("--sweep {text}: {said}{hint}").into());
            }
        }
        Ok(())
    }
}

/// Returns the command line without the options about all pictures of a sweep.
fn without_sweep(argv: &[String]) -> Vec<String> {
    let mut left = argv.iter();
    let mut kept = Vec::new();
    while let Some(word) = left.next() {
        if word == "--" {
            kept.push(word.clone());
            kept.extend(left.cloned());
            break;
        }
        let is = |name: &str| word == name || word.starts_with(&format!("{name}="));
        if ["--sweep", "--contact", "--output", "-o"].contains(&word.as_str()) {
            left.next();
        } else if !(["--sweep", "--contact", "--output", "--resume"].into_iter().any(is)
            || word.starts_with("-o"))
        {
            kept.push(word.clone());
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(line: &str) -> Result<SweepPlan, String> {
        let argv: Vec<String> = line.split(' ').map(str::to_owned).collect();
        let arguments = parse_render(&argv).map_err(|error| error.to_string())?;
        SweepPlan::new(&arguments, &argv).map_err(|error| error.to_string())
    }

    fn names(line: &str) -> Result<String, String> {
        let names = plan(line)?.names(Path::new("x/a.pbrt"), Some(Path::new("b.dat")));
        let names = names.map_err(|error| error.to_string())?;
        Ok(names.iter().map(|name| name.display().to_string()).collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn a_picture_is_the_command_line_with_its_values() {
        let text = "petzval render a.pbrt --sweep fstop=2,4 -o a_{fstop}_{focus}.exr --spp 4 \
                    --resume --sweep=focus=1..3:3 --contact=x.png --threads 1 -- -b";
        let argv: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
        assert_eq!(
            without_sweep(&argv).join(" "),
            "petzval render a.pbrt --spp 4 --threads 1 -- -b"
        );
        let plan = plan(text.trim_end_matches(" -- -b")).unwrap();
        assert_eq!(plan.count(), 6);
        assert_eq!(plan.values(4), ["4", "2"], "the last sweep changes fastest");
        assert_eq!(plan.number(&[1, 1]), 4);
        assert_eq!(
            plan.argv(4, Path::new("a b.exr")).join(" "),
            "petzval render --fstop=4 --focus=2 --output=a b.exr a.pbrt --spp 4 --threads 1"
        );
    }

    #[test]
    fn names_are_filled() {
        let found = names("petzval render a.pbrt --sweep fstop=2,4 -o {scene}-{lens}_{fstop}.exr");
        assert_eq!(found.unwrap(), "a-b_2.exr a-b_4.exr");
        let found = names("petzval render a.pbrt --sweep lens=y/c.dat,d.dat --sweep crop=0,0,1,1;");
        assert_eq!(found.unwrap(), "a_c_0,0,1,1.exr a_d_0,0,1,1.exr");
    }

    #[test]
    fn options_that_cannot_be_swept_are_refused() {
        let sweeps = |sweeps: &str, expected: &str| {
            let said = names(&format!("petzval render a.pbrt {sweeps}")).unwrap_err();
            assert!(said.contains(expected), "{sweeps}\n  said     {said}\n  expected {expected}");
            assert!(!said.contains('\n'), "{said}");
        };
        sweeps("--sweep fstpo=2", "petzval render has no --fstpo; did you mean \"fstop\"?");
        sweeps("--sweep scene=b.pbrt", "petzval render has no --scene");
        sweeps("--sweep threads=1,2", "--threads has one value for the whole sweep");
        sweeps("--sweep output=a.exr", "--output has one value for the whole sweep");
        sweeps("--sweep half=1", "--half takes no values");
        sweeps("--sweep fstop=2 --fstop 4", "--fstop is given, too");
        sweeps("--sweep fstop=2 --sweep fstop=4", "--fstop is swept twice");
        sweeps("--sweep fstop=2,x", "--sweep fstop=2,x: invalid value 'x' for '--fstop <f/N>'");
        sweeps("--sweep focus=0.5..5", "a range reads FIRST..LAST:COUNT");
        sweeps("--sweep film-shift=0,4", "separate values that contain commas with ;");
        sweeps("--sweep seed=0..9:10 --shard 1/2 -o a.petzval", "--shard with --sweep: give each");
        sweeps(
            "--sweep seed=0..999:1000 --sweep spp=1..101:101",
            "1000 x 101 pictures are more than 100000",
        );
        sweeps("--sweep fstop=2,4 -o a.exr", "add {fstop} to it");
        sweeps(
            "--sweep fstop=2,4 -o {fstop}{spp}.exr",
            "unknown placeholder {spp}; known are {fstop}, {lens}, {scene}",
        );
        sweeps("--sweep fstop=2,4 -o {fstop.exr", "an unmatched brace");
        sweeps("--sweep lens=x/a.dat,y/a.dat", "both x/a.dat and y/a.dat would be a_a.exr");
        sweeps("--sweep fstop=2,4 -o {fstop}.gif", "names no picture format");
    }
}
