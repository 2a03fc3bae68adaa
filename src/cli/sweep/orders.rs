//! What a sweep asks for: a command line for each of its pictures, which is the very one with the
//! values in the place of the sweeps.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use clap::CommandFactory;
use clap::parser::ValueSource;
use petzval::contact;
use petzval::image::Format;
use petzval::source::hint;

use super::super::inputs::{line, parsed};
use super::super::{Arguments, Failure, RenderArguments};
use super::axis::{Axis, MOST};
use super::template::Template;

/// Options that are the same for all pictures, or decide nothing about them.
const WHOLE: [&str; 10] = [
    "backend",
    "checkpoint",
    "contact",
    "memory",
    "output",
    "resume",
    "samples",
    "shard",
    "sweep",
    "threads",
];

/// A sweep that can be done, as far as its words tell.
pub(super) struct Orders {
    pub axes: Vec<Axis>,
    /// The command without what changes.
    words: Vec<String>,
    pub template: Template,
    /// The name with places, as given.
    named: String,
}

impl Orders {
    /// Of the words of a command line to render.
    pub fn new(arguments: &RenderArguments, words: &[String]) -> Result<Self, Failure> {
        if words.iter().any(|word| word.contains(char::REPLACEMENT_CHARACTER)) {
            return Err("--sweep: this command line holds what is no UTF-8".into());
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
        let named = match &arguments.output {
            Some(output) => output.to_string_lossy().into_owned(),
            None => {
                let places = axes.iter().map(|axis| format!("_{{{}}}", axis.name));
                format!("{{scene}}{}.exr", places.collect::<String>())
            }
        };
        let template = Template::parse(&named).map_err(|error| format!("-o {error}"))?;
        let orders = Self { axes, words: without(words), template, named };
        orders.check_options(words)?;
        let counts = orders.axes.iter().map(|axis| axis.values.len());
        if counts.clone().try_fold(1, usize::checked_mul).is_none_or(|count| count > MOST) {
            let counts: Vec<String> = counts.map(|count| count.to_string()).collect();
            let counts = counts.join(" x ");
            return Err(format!("--sweep: {counts} pictures are more than {MOST}").into());
        }
        orders.check_values()?;
        Ok(orders)
    }

    /// How many pictures there are.
    pub fn count(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// What changes, as the contact sheet shows it.
    pub fn shown(&self) -> Vec<contact::Axis> {
        let shown =
            |axis: &Axis| contact::Axis { name: axis.name.clone(), values: axis.values.clone() };
        self.axes.iter().map(shown).collect()
    }

    /// The values of a picture, by option.
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

    /// The number of the picture that has these of the values.
    pub fn number(&self, places: &[usize]) -> usize {
        self.axes.iter().zip(places).fold(0, |sum, (axis, at)| sum * axis.values.len() + at)
    }

    /// The command line of one picture.
    pub fn words(&self, number: usize, output: &Path) -> Vec<String> {
        let output = format!("--output={}", output.display());
        self.with(&self.values(number), Some(output))
    }

    fn with(&self, values: &[&str], output: Option<String>) -> Vec<String> {
        let set =
            self.axes.iter().zip(values).map(|(axis, value)| format!("--{}={value}", axis.name));
        let set: Vec<String> = set.chain(output).collect();
        let mut words = self.words.clone();
        words.splice(2..2, set);
        words
    }

    /// Whether there are such options, each once, that make sense in a sweep.
    fn check_options(&self, words: &[String]) -> Result<(), Failure> {
        let command = Arguments::command();
        let matches = command.clone().try_get_matches_from(words)?;
        let (Some(render), Some((_, matches))) =
            (command.find_subcommand("render"), matches.subcommand())
        else {
            return Err(format!("\"{}\" renders nothing", line(words)).into());
        };
        let mut seen = BTreeSet::new();
        for Axis { text, name, .. } in &self.axes {
            let refuse = |problem: String| Err(format!("--sweep {text}: {problem}").into());
            let options =
                || render.get_arguments().filter(|argument| argument.get_long().is_some());
            let Some(option) = options().find(|option| option.get_long() == Some(name)) else {
                let near = hint(name, options().filter_map(clap::Arg::get_long));
                return refuse(format!("petzval render has no --{name}{near}"));
            };
            if WHOLE.contains(&name.as_str()) {
                return refuse(format!("--{name} is one for the whole sweep"));
            }
            if !option.get_action().takes_values() {
                return refuse(format!("--{name} takes no values"));
            }
            if matches.value_source(option.get_id().as_str()) == Some(ValueSource::CommandLine) {
                return refuse(format!("--{name} is given, too; expected one of the two"));
            }
            if !seen.insert(name) {
                return refuse(format!("--{name} is swept twice; put all values into one list"));
            }
        }
        Ok(())
    }

    /// Whether each value is one that its option takes.
    fn check_values(&self) -> Result<(), Failure> {
        let first = self.values(0);
        for (place, Axis { text, values, .. }) in self.axes.iter().enumerate() {
            let parsed = |value: &str| {
                let mut all = first.clone();
                all[place] = value;
                parsed(&self.with(&all, None))
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
                        "; values that hold commas have ; between them"
                    }
                    false => "",
                };
                return Err(format!("--sweep {text}: {said}{hint}").into());
            }
        }
        Ok(())
    }

    /// The names of all pictures, by the scene's and by the name of its lens file if it has one.
    pub fn names(&self, scene: &Path, lens: Option<&Path>) -> Result<Vec<PathBuf>, Failure> {
        let stem =
            |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut fixed = HashMap::from([("scene", stem(scene))]);
        fixed.extend(lens.map(|lens| ("lens", stem(lens))));
        let swept = |name: &str| self.axes.iter().position(|axis| axis.name == name);
        let known: BTreeSet<&str> =
            fixed.keys().copied().chain(self.axes.iter().map(|axis| axis.name.as_str())).collect();
        let braced = |names: Vec<&str>| {
            let names: Vec<String> = names.iter().map(|name| format!("{{{name}}}")).collect();
            names.join(", ")
        };
        let named = &self.named;
        if let Some(place) = self.template.places().find(|place| !known.contains(place)) {
            let known = braced(known.into_iter().collect());
            return Err(format!("-o {named}: nothing fills {{{place}}}; known are {known}").into());
        }
        let needed = |axis: &&Axis| axis.values.len() > 1;
        let missing = self.axes.iter().filter(needed).map(|axis| axis.name.as_str());
        let missing = missing.filter(|name| self.template.places().all(|place| place != *name));
        let missing: Vec<&str> = missing.collect();
        if !missing.is_empty() {
            let missing = braced(missing);
            return Err(format!(
                "-o {named}: two pictures would have one name; expected {missing} in it, too"
            )
            .into());
        }
        let mut takers: HashMap<PathBuf, usize> = HashMap::new();
        let mut names = Vec::with_capacity(self.count());
        for number in 0..self.count() {
            let values: Vec<String> = self
                .axes
                .iter()
                .zip(self.values(number))
                .map(
                    |(axis, value)| {
                        if axis.name == "lens" { stem(Path::new(value)) } else { value.into() }
                    },
                )
                .collect();
            let filled = self.template.filled(|place| match swept(place) {
                Some(at) => &values[at],
                None => &fixed[place],
            });
            let name = PathBuf::from(filled);
            if let Some(other) = takers.insert(name.clone(), number) {
                let [one, other] = [other, number].map(|n| self.values(n).join(", "));
                let name = name.display();
                return Err(format!("-o {named}: both {one} and {other} would be {name}").into());
            }
            Format::of(&name)?;
            names.push(name);
        }
        Ok(names)
    }

    /// The folder of the pictures, or of their folders.
    pub fn folder(&self) -> PathBuf {
        match self.template.front().rsplit_once('/') {
            Some((folder, _)) => PathBuf::from(format!("{folder}/")),
            None => PathBuf::new(),
        }
    }
}

/// The words without those about all pictures of a sweep.
fn without(words: &[String]) -> Vec<String> {
    let mut left = words.iter();
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

    fn orders(words: &str) -> Result<Orders, String> {
        let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
        let arguments = parsed(&words).map_err(|error| error.to_string())?;
        Orders::new(&arguments, &words).map_err(|error| error.to_string())
    }

    fn names(words: &str) -> Result<String, String> {
        let names = orders(words)?.names(Path::new("x/a.pbrt"), Some(Path::new("b.dat")));
        let names = names.map_err(|error| error.to_string())?;
        Ok(names.iter().map(|name| name.display().to_string()).collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn a_picture_is_the_command_line_with_its_values() {
        let text = "petzval render a.pbrt --sweep fstop=2,4 -o a_{fstop}_{focus}.exr --spp 4 \
                    --resume --sweep=focus=1..3:3 --contact=x.png --threads 1 -- -b";
        let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
        assert_eq!(without(&words).join(" "), "petzval render a.pbrt --spp 4 --threads 1 -- -b");
        let orders = orders(text.trim_end_matches(" -- -b")).unwrap();
        assert_eq!(orders.count(), 6);
        assert_eq!(orders.values(4), ["4", "2"], "the last sweep changes fastest");
        assert_eq!(orders.number(&[1, 1]), 4);
        assert_eq!(
            orders.words(4, Path::new("a b.exr")).join(" "),
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
    fn what_cannot_be_swept_is_refused() {
        let sweeps = |sweeps: &str, expected: &str| {
            let said = names(&format!("petzval render a.pbrt {sweeps}")).unwrap_err();
            assert!(said.contains(expected), "{sweeps}\n  said     {said}\n  expected {expected}");
            assert!(!said.contains('\n'), "{said}");
        };
        sweeps("--sweep fstpo=2", "petzval render has no --fstpo; did you mean \"fstop\"?");
        sweeps("--sweep scene=b.pbrt", "petzval render has no --scene");
        sweeps("--sweep threads=1,2", "--threads is one for the whole sweep");
        sweeps("--sweep output=a.exr", "--output is one for the whole sweep");
        sweeps("--sweep half=1", "--half takes no values");
        sweeps("--sweep fstop=2 --fstop 4", "--fstop is given, too");
        sweeps("--sweep fstop=2 --sweep fstop=4", "--fstop is swept twice");
        sweeps("--sweep fstop=2,x", "--sweep fstop=2,x: invalid value 'x' for '--fstop <N>'");
        sweeps("--sweep focus=0.5..5", "a range reads FIRST..LAST:COUNT");
        sweeps("--sweep film-shift=0,4", "values that hold commas have ; between them");
        sweeps("--sweep seed=0..9:10 --shard 1/2 -o a.petzval", "--shard with --sweep: give each");
        sweeps(
            "--sweep seed=0..999:1000 --sweep spp=1..101:101",
            "1000 x 101 pictures are more than 100000",
        );
        sweeps("--sweep fstop=2,4 -o a.exr", "expected {fstop} in it, too");
        sweeps(
            "--sweep fstop=2,4 -o {fstop}{spp}.exr",
            "nothing fills {spp}; known are {fstop}, {lens}, {scene}",
        );
        sweeps("--sweep fstop=2,4 -o {fstop.exr", "a brace without its other");
        sweeps("--sweep lens=x/a.dat,y/a.dat", "both x/a.dat and y/a.dat would be a_a.exr");
        sweeps("--sweep fstop=2,4 -o {fstop}.gif", "names no picture format");
    }
}
