//! Files that are whole, or not there.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::NamedTempFile;

/// Where files cannot be locked a temporary file is nobody's after so long without a change.
const ABANDONED: Duration = Duration::from_secs(60);
/// No name stands for another through more symbolic links than this.
const MOST_LINKS: usize = 40;
const SUFFIX: &str = ".tmp";

/// Writes a file beside its final name, then renames it. The name holds the whole new file or what it
/// held before, whatever happens meanwhile, to the program or to the machine. Of a symbolic link it
/// is the file that the link stands for.
///
/// # Errors
/// Where it cannot be written; what stood under its name is then still there, and nothing is
/// beside it.
pub fn replace(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let path = &target(path)?;
    sweep_beside(path);
    let mut file = locked(path)?;
    fill(file.as_file_mut())?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    // The name is as safe as the content only when the folder is written too. Where folders cannot
    // be opened, as on Windows, the system sees to it.
    match File::open(folder(path)) {
        Ok(folder) => folder.sync_all().or_else(|error| match error.kind() {
            io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported => Ok(()),
            _ => Err(error),
        }),
        Err(_) => Ok(()),
    }
}

/// The file that is written under a name: of a symbolic link what it stands for. It need not be
/// there.
///
/// # Errors
/// Where links go in a circle, or to a pipe or a device, which are no files to be replaced.
pub fn target(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&path) {
            Ok(next) => path = folder(&path).join(next),
            Err(_) => match fs::metadata(&path) {
                Ok(found) if !found.is_file() && !found.is_dir() => {
                    return Err(io::Error::other("it is a pipe or a device; expected a file"));
                }
                _ => return Ok(path),
            },
        }
    }
    Err(io::Error::other("its symbolic links go in a circle"))
}

/// Removes what programs that were killed have left beside a file when they wrote it.
pub fn sweep(path: &Path) {
    if let Ok(path) = target(path) {
        sweep_beside(&path);
    }
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// How the names of temporary files of a file begin.
fn prefix(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    format!(".petzval-{:08x}-", crc32fast::hash(name.as_bytes()))
}

/// A temporary file that nobody sweeps: its lock is held as long as its program lives.
fn locked(path: &Path) -> io::Result<NamedTempFile> {
    let prefix = prefix(path);
    let mut beside = tempfile::Builder::new();
    beside.prefix(&prefix).suffix(SUFFIX);
    // Temporary files are private by default; a picture is for everyone the umask allows.
    #[cfg(unix)]
    beside.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    loop {
        let file = beside.tempfile_in(folder(path))?;
        // Where there are no locks age alone must tell.
        let locked = file.as_file().lock().is_ok();
        // Whoever sweeps may have been faster than the lock.
        if !locked || file.path().exists() {
            return Ok(file);
        }
    }
}

/// Removes temporary files of a file that no living program holds.
fn sweep_beside(path: &Path) {
    let prefix = prefix(path);
    let Ok(entries) = fs::read_dir(folder(path)) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !file || !name.starts_with(&prefix) || !name.ends_with(SUFFIX) {
            continue;
        }
        // Some network file systems lock only what is open to be written.
        let Ok(file) = File::options().write(true).open(entry.path()) else { continue };
        let age = || entry.metadata().ok()?.modified().ok()?.elapsed().ok();
        let abandoned = match file.try_lock() {
            Ok(()) => true,
            Err(TryLockError::WouldBlock) => false,
            Err(TryLockError::Error(_)) => age().is_some_and(|age| age > ABANDONED),
        };
        if abandoned {
            // It is only litter.
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

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
    fn litter_of_the_same_file_is_swept_and_what_a_living_program_writes_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let litter = |name: &str| {
            let path = folder.path().join(name);
            (File::create(&path).unwrap(), path)
        };
        let prefix = prefix(&path);
        let (_, dead) = litter(&format!("{prefix}x.tmp"));
        let (held, living) = litter(&format!("{prefix}y.tmp"));
        held.lock().unwrap();
        let (_, other) = litter(".petzval-00000000-x.tmp");
        let left = || [&dead, &living, &other].map(|path| path.exists());
        replace(&path, |file| {
            // Another program sweeps, too, while this one writes.
            sweep(&path);
            file.write_all(b"new")
        })
        .unwrap();
        assert_eq!(left(), [false, true, true]);
        assert_eq!(fs::read(&path).unwrap(), b"new");
        drop(held);
        sweep(&path);
        assert_eq!(left(), [false, false, true]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_what_it_stands_for_is_replaced() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("far")).unwrap();
        symlink("far/b", path("a")).unwrap();
        symlink(path("a"), path("far/c")).unwrap();
        for (name, content) in [("a", "one"), ("far/c", "two")] {
            replace(&path(name), |file| file.write_all(content.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(path("far/b")).unwrap(), content);
            assert!(path(name).is_symlink());
        }
        assert!(!path("far/b").is_symlink());
        let dead = path("far").join(format!("{}x.tmp", prefix(&path("far/b"))));
        fs::write(&dead, "").unwrap();
        sweep(&path("a"));
        assert!(!dead.exists(), "litter lies beside the file, not the link");
        symlink("round", path("round")).unwrap();
        let made = std::process::Command::new("mkfifo").arg(path("pipe")).status().unwrap();
        assert!(made.success());
        symlink("pipe", path("piped")).unwrap();
        for (name, found) in [("round", "in a circle"), ("piped", "a pipe")] {
            let error = replace(&path(name), |_| Ok(())).unwrap_err();
            assert!(error.to_string().contains(found), "{error}");
        }
    }
}
