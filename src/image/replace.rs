//! Files that are whole, or not there.

use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::time::Duration;

/// After so long without a change a temporary file is nobody's.
const ABANDONED: Duration = Duration::from_secs(60);

/// Writes a file beside its final name, then renames it. The name holds the whole new file or what it
/// held before, whatever happens meanwhile, to the program or to the machine.
///
/// # Errors
/// Where it cannot be written; what stood under its name is then still there, and nothing is
/// beside it.
pub fn replace(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let prefix = format!(".petzval-{:08x}-", crc32fast::hash(name.as_bytes()));
    sweep(folder, &prefix);
    let mut beside = tempfile::Builder::new();
    beside.prefix(&prefix).suffix(SUFFIX);
    // Temporary files are private by default; a picture is for everyone the umask allows.
    #[cfg(unix)]
    beside.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = beside.tempfile_in(folder)?;
    fill(file.as_file_mut())?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    // The name is as safe as the content only when the folder is written too. Where folders cannot
    // be opened, as on Windows, the system sees to it.
    match File::open(folder) {
        Ok(folder) => folder.sync_all().or_else(|error| match error.kind() {
            io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported => Ok(()),
            _ => Err(error),
        }),
        Err(_) => Ok(()),
    }
}

const SUFFIX: &str = ".tmp";

/// Removes what a program that was killed has left of the same file.
fn sweep(folder: &Path, prefix: &str) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let own = name.starts_with(prefix) && name.ends_with(SUFFIX);
        let age = || entry.metadata().ok()?.modified().ok()?.elapsed().ok();
        if own && age().is_some_and(|age| age > ABANDONED) {
            // It is only litter.
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::time::SystemTime;

    use super::*;

    #[test]
    fn a_failure_leaves_what_was_there_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "old").unwrap();
        let fails = replace(&path, |file| {
            file.write_all(b"half of the new")?;
            Err(io::Error::other("no more"))
        });
        assert!(fails.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        replace(&path, |file| file.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
    }

    #[test]
    fn litter_of_the_same_file_is_swept_when_it_is_old() {
        let folder = tempfile::tempdir().unwrap();
        let litter = |name: &str, seconds: u64| {
            let path = folder.path().join(name);
            let file = File::create(&path).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(seconds)).unwrap();
            path
        };
        let prefix = format!(".petzval-{:08x}-", crc32fast::hash(b"a"));
        let old = litter(&format!("{prefix}x.tmp"), 100);
        let young = litter(&format!("{prefix}y.tmp"), 5);
        let other = litter(".petzval-00000000-x.tmp", 100);
        replace(&folder.path().join("a"), |_| Ok(())).unwrap();
        assert_eq!([old, young, other].map(|path| path.exists()), [false, true, true]);
    }
}
