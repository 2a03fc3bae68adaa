//! Atomic replacement of files.

#![allow(clippy::disallowed_methods, reason = "the owner's atomic replacement of files")]

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::NamedTempFile;

/// Age from which on a temporary file counts as abandoned, if files cannot be locked.
const STALE_AGE: Duration = Duration::from_secs(60);
/// Longest chain of symbolic links.
const MAX_LINKS: usize = 40;
const SUFFIX: &str = ".tmp";

/// Writes a file, behind all links, under a temporary name in the same folder, then renames it. The
/// name holds either the complete new file or the previous one, even if the program or the machine
/// stops. `check` is called before the rename.
///
/// # Errors
/// Returns an error if the file cannot be written, if `check` does, or if the file exists and
/// `only_new` is set. The previous file is then unchanged, and no temporary file is left.
pub(super) fn persist(
    path: &Path,
    fill: impl FnOnce(&mut File) -> io::Result<()>,
    only_new: bool,
    check: impl FnOnce() -> io::Result<()>,
) -> io::Result<()> {
    remove_stale_beside(path);
    let mut file = create_locked(path)?;
    fill(file.as_file_mut())?;
    file.as_file().sync_all()?;
    check()?;
    let persisted = if only_new { file.persist_noclobber(path) } else { file.persist(path) };
    persisted.map_err(|error| error.error)?;
    // The rename is durable only after the folder is synchronised. Systems whose folders cannot be
    // opened, such as Windows, do this themselves.
    match File::open(folder(path)) {
        Ok(folder) => folder.sync_all().or_else(|error| match error.kind() {
            io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported => Ok(()),
            _ => Err(error),
        }),
        Err(_) => Ok(()),
    }
}

/// Follows symbolic links to the file that is written under a name. It need not exist.
///
/// # Errors
/// Returns an error if the links are circular, or lead to a pipe or a device, which cannot be
/// replaced.
pub(super) fn resolve_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MAX_LINKS {
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

/// Removes the temporary files that killed programs left when they wrote this file.
pub(super) fn remove_stale(path: &Path) {
    if let Ok(path) = resolve_links(path) {
        remove_stale_beside(&path);
    }
}

/// Returns the folder of a file.
pub(super) fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Returns the prefix of a file's temporary files.
fn prefix(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    format!(".petzval-{:08x}-", crc32fast::hash(name.as_bytes()))
}

/// Creates a temporary file. Its lock, held as long as the program lives, keeps others from
/// removing it.
fn create_locked(path: &Path) -> io::Result<NamedTempFile> {
    let prefix = prefix(path);
    let mut beside = tempfile::Builder::new();
    beside.prefix(&prefix).suffix(SUFFIX);
    // Temporary files are private by default; a picture has the permissions of the umask.
    #[cfg(unix)]
    beside.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    loop {
        let file = beside.tempfile_in(folder(path))?;
        // Without locks, only the age protects the file.
        let locked = file.as_file().lock().is_ok();
        // Another program may have removed the file before it was locked.
        if !locked || file.path().exists() {
            return Ok(file);
        }
    }
}

/// Removes the temporary files of a file that no living program holds.
fn remove_stale_beside(path: &Path) {
    let prefix = prefix(path);
    let Ok(entries) = fs::read_dir(folder(path)) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !file || !name.starts_with(&prefix) || !name.ends_with(SUFFIX) {
            continue;
        }
        // Some network file systems lock only files that are open for writing.
        let Ok(file) = File::options().write(true).open(entry.path()) else { continue };
        let age = || entry.metadata().ok()?.modified().ok()?.elapsed().ok();
        let abandoned = match file.try_lock() {
            Ok(()) => true,
            Err(TryLockError::WouldBlock) => false,
            Err(TryLockError::Error(_)) => age().is_some_and(|age| age > STALE_AGE),
        };
        if abandoned {
            // A failure leaves only a stale file.
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn replace_file(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
        persist(&resolve_links(path)?, fill, false, || Ok(()))
    }

    #[test]
    fn a_failure_leaves_the_previous_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "old").unwrap();
        let fails = replace_file(&path, |file| {
            file.write_all(b"half of the new")?;
            Err(io::Error::other("no more"))
        });
        assert!(fails.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        replace_file(&path, |file| file.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
    }

    #[test]
    fn only_abandoned_temporary_files_are_removed() {
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
        replace_file(&path, |file| {
            // Another program removes stale files while this one writes.
            remove_stale(&path);
            file.write_all(b"new")
        })
        .unwrap();
        assert_eq!(left(), [false, true, true]);
        assert_eq!(fs::read(&path).unwrap(), b"new");
        // A process that another test starts holds a copy of the open file, and with it the lock, for
        // a moment. Unlocking ends the lock of all copies.
        held.unlock().unwrap();
        remove_stale(&path);
        assert_eq!(left(), [false, false, true]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_its_target_is_replaced() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("far")).unwrap();
        symlink("far/b", path("a")).unwrap();
        symlink(path("a"), path("far/c")).unwrap();
        for (name, content) in [("a", "one"), ("far/c", "two")] {
            replace_file(&path(name), |file| file.write_all(content.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(path("far/b")).unwrap(), content);
            assert!(path(name).is_symlink());
        }
        assert!(!path("far/b").is_symlink());
        let dead = path("far").join(format!("{}x.tmp", prefix(&path("far/b"))));
        fs::write(&dead, "").unwrap();
        remove_stale(&path("a"));
        assert!(!dead.exists(), "temporary files are beside the target, not the link");
        symlink("round", path("round")).unwrap();
        let made = std::process::Command::new("mkfifo").arg(path("pipe")).status().unwrap();
        assert!(made.success());
        symlink("pipe", path("piped")).unwrap();
        for (name, found) in [("round", "in a circle"), ("piped", "a pipe")] {
            let error = replace_file(&path(name), |_| Ok(())).unwrap_err();
            assert!(error.to_string().contains(found), "{error}");
        }
    }
}
