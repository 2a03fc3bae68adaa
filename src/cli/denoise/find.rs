//! Search for the program that denoises.

use std::env::{self, consts::EXE_SUFFIX};
use std::path::{Path, PathBuf};

use crate::cli::Failure;

/// Environment variable that names the program.
const VARIABLE: &str = "PETZVAL_DENOISER";
/// Programs that are searched for, the first one first.
const PROGRAMS: [&str; 2] = ["oidnDenoise", "petzval-denoise"];

/// How to get a program.
pub(super) const ADVICE: &str = "install Open Image Denoise 2, which holds oidnDenoise, or petzval's \
     Python package with pyoidn (pip install pyoidn), which hold petzval-denoise, or name a program \
     with --denoise=PROGRAM or the environment variable PETZVAL_DENOISER";

/// Returns the program: the named one, that of the environment variable, or the first known one on
/// PATH.
///
/// # Errors
/// Returns an error if there is none.
pub(super) fn program(named: Option<&Path>) -> Result<PathBuf, Failure> {
    let variable = env::var_os(VARIABLE).filter(|name| !name.is_empty()).map(PathBuf::from);
    let (name, source) = match (named, variable) {
        (Some(name), _) => (name.to_owned(), "--denoise"),
        (None, Some(name)) => (name, VARIABLE),
        (None, None) => {
            let [first, second] = PROGRAMS;
            let problem =
                || format!("--denoise: neither {first} nor {second} is on PATH; {ADVICE}").into();
            return PROGRAMS.iter().find_map(|name| on_path(name.as_ref())).ok_or_else(problem);
        }
    };
    let is_bare = name.components().count() == 1;
    let found = match is_bare {
        true => on_path(&name),
        false => Some(name.clone()).filter(|name| is_program(name)),
    };
    let shown = name.display();
    let problem = || match (is_bare, name.is_file()) {
        (true, true) => {
            format!("{source}: {shown} is not on PATH; for the file in this folder write ./{shown}")
        }
        (false, true) => format!("{source}: {shown} is not executable; try chmod +x {shown}"),
        (_, false) => format!("{source}: there is no program {shown}; {ADVICE}"),
    };
    found.ok_or_else(|| problem().into())
}

/// Returns the first program of this name in the folders of PATH.
fn on_path(name: &Path) -> Option<PathBuf> {
    let folders = env::var_os("PATH")?;
    let mut name = name.to_owned();
    if !EXE_SUFFIX.is_empty() && name.extension().is_none() {
        name.set_extension(EXE_SUFFIX.trim_start_matches('.'));
    }
    env::split_paths(&folders).map(|folder| folder.join(&name)).find(|path| is_program(path))
}

/// Returns whether a path is that of a file that can be executed.
fn is_program(path: &Path) -> bool {
    #[cfg(unix)]
    let executable = |metadata: &std::fs::Metadata| {
        std::os::unix::fs::PermissionsExt::mode(&metadata.permissions()) & 0o111 != 0
    };
    #[cfg(not(unix))]
    let executable = |_: &std::fs::Metadata| true;
    path.metadata().is_ok_and(|metadata| metadata.is_file() && executable(&metadata))
}
