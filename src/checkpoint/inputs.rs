//! What a picture was made of, so that nothing goes on from what was made of something else.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::LazyLock;

use crate::source::{Files, Unreadable, digest};

/// All that decides about a picture's samples.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// The program and its version: another may trace otherwise.
    pub program: String,
    /// A digest of the program's own file, as builds of one version need not be alike; empty where
    /// it cannot be read.
    pub build: String,
    /// Files, by their names as seen from the scene, and a digest of the content of each.
    pub files: BTreeMap<String, String>,
    /// What was asked for, by option, and what it came to.
    pub options: BTreeMap<String, String>,
}

impl Inputs {
    /// Those of this program, of all files that were read for a job, and these options.
    ///
    /// # Errors
    /// Where a file cannot be read again.
    pub fn of(
        scene: &Path,
        mut read: Files,
        options: BTreeMap<String, String>,
    ) -> Result<Self, Unreadable> {
        read.digest()?;
        let folder = scene.parent().unwrap_or(Path::new(""));
        let mut files = BTreeMap::new();
        for (path, digest) in read.iter() {
            let inside = path.strip_prefix(folder).ok().or(path.file_name().map(Path::new));
            let name = inside.unwrap_or(path).to_string_lossy().into_owned();
            // Two files may have one name.
            let entry: &mut String = files.entry(name).or_default();
            entry.push_str(digest.unwrap_or_default());
        }
        Ok(Self { program: program(), build: BUILD.clone(), files, options })
    }

    /// A digest of them all (BLAKE3).
    pub fn digest(&self) -> String {
        let Self { program, build, files, options } = self;
        let all = serde_json::json!([program, build, files, options]).to_string();
        blake3::hash(all.as_bytes()).to_hex().to_string()
    }

    /// What is otherwise in `now`, in words; nothing where all is the same.
    pub fn changes(&self, now: &Self) -> Vec<String> {
        let mut changes = Vec::new();
        if self.program != now.program {
            changes.push(format!("it was begun by {}, and this is {}", self.program, now.program));
        } else if self.build != now.build {
            changes.push(format!("it was begun by another build of {}", self.program));
        }
        for (name, other) in both(&self.files, &now.files) {
            match other {
                [Some(_), Some(_)] => changes.push(format!("{name} has changed since")),
                [Some(_), None] => changes.push(format!("{name} is not read any more")),
                _ => changes.push(format!("{name} was not read then")),
            }
        }
        for (name, values) in both(&self.options, &now.options) {
            let [was, is] = values.map(|value| value.map_or("not given", |value| value));
            changes.push(format!("{name} was {was}, and is {is} now"));
        }
        changes
    }
}

/// What two lists have under different values, or one of them only.
fn both<'a>(
    one: &'a BTreeMap<String, String>,
    other: &'a BTreeMap<String, String>,
) -> impl Iterator<Item = (&'a str, [Option<&'a str>; 2])> {
    let added = other.keys().filter(|name| !one.contains_key(*name));
    let values = move |name: &'a String| (name.as_str(), [one, other].map(|all| all.get(name)));
    let different = |(_, [one, other]): &(_, [Option<&String>; 2])| one != other;
    let all = one.keys().chain(added).map(values).filter(different);
    all.map(|(name, values)| (name, values.map(|value| value.map(String::as_str))))
}

/// Builds that fuse multiplications round otherwise than those that do not.
fn program() -> String {
    let build = if cfg!(target_feature = "fma") { "" } else { ", portable" };
    let bare = if cfg!(feature = "bare") { ", bare" } else { "" };
    format!("petzval {}{build}{bare}", env!("CARGO_PKG_VERSION"))
}

/// See [`Inputs::build`].
static BUILD: LazyLock<String> = LazyLock::new(|| build().unwrap_or_default());

/// A digest of the file that runs.
fn build() -> io::Result<String> {
    // What runs may have been replaced under its name.
    let own = Path::new("/proc/self/exe");
    if cfg!(target_os = "linux") && own.exists() {
        return digest(own);
    }
    digest(&std::env::current_exe()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(items: &[(&str, &str)]) -> BTreeMap<String, String> {
        items.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect()
    }

    #[test]
    fn every_change_is_named() {
        let then = Inputs {
            program: "petzval 1".to_owned(),
            build: "a".to_owned(),
            files: list(&[("a.pbrt", "1"), ("lens.dat", "2"), ("same", "3")]),
            options: list(&[("--fstop", "2.8"), ("--lens", "x"), ("--seed", "0")]),
        };
        let now = Inputs {
            program: "petzval 2".to_owned(),
            build: "b".to_owned(),
            files: list(&[("a.pbrt", "1"), ("lens.dat", "9"), ("new.ply", "4")]),
            options: list(&[("--fstop", "4"), ("--seed", "0"), ("--coating", "none")]),
        };
        assert_eq!(then.changes(&then), [""; 0]);
        assert_eq!(
            then.changes(&now),
            [
                "it was begun by petzval 1, and this is petzval 2",
                "lens.dat has changed since",
                "same is not read any more",
                "new.ply was not read then",
                "--fstop was 2.8, and is 4 now",
                "--lens was x, and is not given now",
                "--coating was not given, and is none now",
            ]
        );
        let rebuilt = Inputs { build: "b".to_owned(), ..then.clone() };
        assert_eq!(then.changes(&rebuilt), ["it was begun by another build of petzval 1"]);
    }
}
