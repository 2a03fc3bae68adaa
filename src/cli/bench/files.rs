//! The scenes and lenses of the suite, which the program carries along.

use std::io;
use std::path::{Path, PathBuf};

/// Path in the repository, and content.
macro_rules! carried {
    ($($path:literal),* $(,)?) => {
        [$(($path, include_bytes!(concat!("../../../", $path)).as_slice())),*]
    };
}

const FILES: [(&str, &[u8]); 10] = carried![
    "lenses/dgauss.50mm.dat",
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

/// A folder with the files in it, as long as it lives.
pub(super) struct Files(tempfile::TempDir);

impl Files {
    /// Writes them.
    pub fn write() -> io::Result<Self> {
        let folder = tempfile::tempdir()?;
        for (path, content) in FILES {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
            std::fs::write(path, content)?;
        }
        Ok(Self(folder))
    }

    /// Where one of them is.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}
