//! Names of files that pages may write: plain names, of files that do not exist yet.

use std::path::{Component, Path, PathBuf};

/// Longest name (bytes).
const MAX_NAME: usize = 100;

/// Returns the path of a new file in a folder, from the name that a page gives.
///
/// # Errors
/// Returns a message if it is not a plain name with one of these extensions, or if there is such a
/// file.
pub(super) fn new_file(folder: &Path, name: &str, extensions: &[&str]) -> Result<PathBuf, String> {
    let path = Path::new(name);
    let mut components = path.components();
    let plain = matches!(
        (components.next(), components.next()),
        (Some(Component::Normal(only)), None) if only == name
    );
    let hidden = name.starts_with(['.', '-']);
    let odd = name.contains(|c: char| c.is_control() || "/\\:*?\"<>|".contains(c));
    if !plain || hidden || odd || name.len() > MAX_NAME {
        return Err(format!(
            "{name:?}: expected a plain file name, without a folder, of at most {MAX_NAME} bytes"
        ));
    }
    let extension = path.extension().and_then(|extension| extension.to_str());
    if !extension.is_some_and(|found| extensions.contains(&found)) {
        return Err(format!("{name}: expected the ending .{}", extensions.join(" or .")));
    }
    let file = folder.join(path);
    match file.symlink_metadata() {
        Ok(_) => Err(format!("{} exists already; choose another name", file.display())),
        Err(_) => Ok(file),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_names_of_new_files_are_taken() {
        let folder = tempfile::tempdir().expect("a folder");
        let take = |name: &str| new_file(folder.path(), name, &["exr", "png"]);
        assert_eq!(take("a b.exr"), Ok(folder.path().join("a b.exr")));
        let long = format!("{}.exr", "a".repeat(MAX_NAME));
        for name in [
            "",
            ".",
            "..",
            "a",
            "a.pbrt",
            ".exr",
            ".a.exr",
            "-o.exr",
            "../a.exr",
            "b/a.exr",
            "/a.exr",
            "a.exr/",
            "./a.exr",
            "b/../a.exr",
            "..\\a.exr",
            "c:a.exr",
            "a\n.exr",
            "a\0.exr",
            &long,
        ] {
            assert!(take(name).is_err(), "{name:?}");
        }
        std::fs::write(folder.path().join("a.png"), "").expect("a file");
        assert!(take("a.png").is_err_and(|problem| problem.contains("exists already")));
    }
}
