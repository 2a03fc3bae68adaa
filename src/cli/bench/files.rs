//! Scenes and lenses of the benchmark, embedded in the program.

#![allow(clippy::disallowed_methods, reason = "writes into a temporary folder that it makes")]

use std::io;
use std::path::{Path, PathBuf};

/// Pairs of a path in the repository and its content.
macro_rules! embedded {
    ($($path:literal),* $(,)?) => {
        [$(($path, include_bytes!(concat!("../../../", $path)).as_slice())),*]
    };
}

const FILES: [(&str, &[u8]); 11] = embedded![
    "lenses/dgauss.50mm.dat",
    "lenses/double-gauss.50mm.toml",
    "lenses/fisheye.10mm.dat",
    "lenses/telephoto.250mm.dat",
    "lenses/wide.22mm.dat",
    "scenes/cones.pbrt",
    "scenes/dgauss.pbrt",
    "scenes/fisheye.pbrt",
    "scenes/grid.png",
    "scenes/telephoto.pbrt",
    "scenes/wide.pbrt",
];

/// A temporary folder with the files, removed on drop.
pub(super) struct Files(tempfile::TempDir);

impl Files {
    /// Writes the files.
    pub fn write() -> io::Result<Self> {
        let folder = tempfile::tempdir()?;
        for (path, content) in FILES {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
            std::fs::write(path, content)?;
        }
        Ok(Self(folder))
    }

    /// Returns the path of a file.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}
