//! Inputs of a picture, which must be the same when its render is resumed or merged.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::LazyLock;

use petzval_base::io::{FileLog, ReadError, file_digest};

use crate::film::Frame;
use crate::job::Job;

/// Everything that decides the samples of a picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// The program and its version. Another version may trace other rays.
    pub program: String,
    /// A digest of the program's own file, as builds of one version may differ; empty if it cannot be
    /// read.
    pub build: String,
    /// A digest of the content of each file, by its path relative to the scene.
    pub files: BTreeMap<String, String>,
    /// The value of each option that changes the picture.
    pub options: BTreeMap<String, String>,
}

impl Inputs {
    /// Returns the inputs of a job, given the files that it was read from and its options.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read again.
    pub fn of(
        scene: &Path,
        mut read: FileLog,
        options: BTreeMap<String, String>,
    ) -> Result<Self, ReadError> {
        read.fill_digests()?;
        let folder = scene.parent().unwrap_or(Path::new(""));
        let mut files = BTreeMap::new();
        for (path, digest) in read.iter() {
            let inside = path.strip_prefix(folder).ok().or(path.file_name().map(Path::new));
            let name = inside.unwrap_or(path).to_string_lossy().into_owned();
            // Two files outside the folder may have one name.
            let entry: &mut String = files.entry(name).or_default();
            entry.push_str(digest.unwrap_or_default());
        }
        Ok(Self { program: program(), build: BUILD.clone(), files, options })
    }

    /// Returns the inputs of a job: its files, some options, and the outcome of all options for the
    /// samples, the seed, the film and the layers. `samples` is the number of samples per pixel of
    /// the whole picture.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read again.
    pub fn of_job(
        scene: &Path,
        job: &Job,
        samples: u32,
        mut options: BTreeMap<String, String>,
    ) -> Result<Self, ReadError> {
        let mut set = |name: &str, value: String| options.insert(name.to_owned(), value);
        let Frame { resolution: [width, height], low: [x0, y0], high: [x1, y1] } = job.frame;
        set("the number of samples", samples.to_string());
        set("the seed", job.seed.to_string());
        set("the resolution", format!("{width}x{height}"));
        set("the rendered part", format!("{x0},{y0},{x1},{y1}"));
        set("the list of layers", format!("{:?}", job.layers).to_lowercase());
        Self::of(scene, job.files.clone(), options)
    }

    /// Returns a digest of all inputs (BLAKE3).
    pub fn digest(&self) -> String {
        let Self { program, build, files, options } = self;
        let all = serde_json::json!([program, build, files, options]).to_string();
        blake3::hash(all.as_bytes()).to_hex().to_string()
    }

    /// Returns a sentence for each difference from the inputs `now`.
    pub fn differences(&self, now: &Self) -> Vec<String> {
        let mut differences = Vec::new();
        if self.program != now.program {
            differences
                .push(format!("it was begun by {}, and this is {}", self.program, now.program));
        } else if self.build != now.build {
            differences.push(format!("it was begun by another build of {}", self.program));
        }
        for (name, values) in unequal_entries(&self.files, &now.files) {
            match values {
                [Some(_), Some(_)] => differences.push(format!("{name} has changed since")),
                [Some(_), None] => differences.push(format!("{name} is not read any more")),
                _ => differences.push(format!("{name} was not read then")),
            }
        }
        for (name, values) in unequal_entries(&self.options, &now.options) {
            let [was, is] = values.map(|value| value.map_or("not given", |value| value));
            differences.push(format!("{name} was {was}, and is {is} now"));
        }
        differences
    }
}

/// Returns the names whose values differ between two maps, with both values.
fn unequal_entries<'a>(
    one: &'a BTreeMap<String, String>,
    other: &'a BTreeMap<String, String>,
) -> impl Iterator<Item = (&'a str, [Option<&'a str>; 2])> {
    let added = other.keys().filter(|name| !one.contains_key(*name));
    let values = move |name: &'a String| (name.as_str(), [one, other].map(|all| all.get(name)));
    let different = |(_, [one, other]): &(_, [Option<&String>; 2])| one != other;
    let all = one.keys().chain(added).map(values).filter(different);
    all.map(|(name, values)| (name, values.map(|value| value.map(String::as_str))))
}

/// Returns the name of the program, with its version and the build option that changes results: fused
/// multiplications round differently.
fn program() -> String {
    let build = if cfg!(target_feature = "fma") { "" } else { ", portable" };
    format!("petzval {}{build}", env!("CARGO_PKG_VERSION"))
}

/// See [`Inputs::build`].
static BUILD: LazyLock<String> = LazyLock::new(|| build().unwrap_or_default());

/// Returns a digest of the running executable.
fn build() -> io::Result<String> {
    // The file of this name may have been replaced since the program started.
    let own = Path::new("/proc/self/exe");
    if cfg!(target_os = "linux") && own.exists() {
        return file_digest(own);
    }
    file_digest(&std::env::current_exe()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(items: &[(&str, &str)]) -> BTreeMap<String, String> {
        items.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect()
    }

    #[test]
    fn every_difference_is_named() {
        let then = Inputs {
            program: "petzval 1".to_owned(),
            build: "a".to_owned(),
            files: list(&[("a.pbrt", "1"), ("lens.dat", "2"), ("same", "3")]),
            options: list(&[("fstop", "2.8"), ("lens", "x"), ("seed", "0")]),
        };
        let now = Inputs {
            program: "petzval 2".to_owned(),
            build: "b".to_owned(),
            files: list(&[("a.pbrt", "1"), ("lens.dat", "9"), ("new.ply", "4")]),
            options: list(&[("fstop", "4"), ("seed", "0"), ("coating", "none")]),
        };
        assert_eq!(then.differences(&then), [""; 0]);
        assert_eq!(
            then.differences(&now),
            [
                "it was begun by petzval 1, and this is petzval 2",
                "lens.dat has changed since",
                "same is not read any more",
                "new.ply was not read then",
                "fstop was 2.8, and is 4 now",
                "lens was x, and is not given now",
                "coating was not given, and is none now",
            ]
        );
        let rebuilt = Inputs { build: "b".to_owned(), ..then.clone() };
        assert_eq!(then.differences(&rebuilt), ["it was begun by another build of petzval 1"]);
    }
}
