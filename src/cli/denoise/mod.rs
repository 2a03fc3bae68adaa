//! Denoising by a program: `oidnDenoise` of Open Image Denoise, or `petzval-denoise` of the Python
//! package, which takes the same arguments.

#![allow(clippy::disallowed_methods, reason = "writes into a temporary folder that it makes")]

mod find;
mod process;

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use petzval_base::io::FileLog;
use petzval_image::{ImageLayer, Picture, write_pfm};

use super::Failure;
use super::signals::TemporaryFolder;

/// Width and height of the picture that tries a program (pixels).
const TRIAL: [usize; 2] = [16, 16];
/// Longest time that a program may take for it. Those that load a model onto a graphics card take
/// seconds.
const TRIAL_TIME: Duration = Duration::from_secs(60);

/// Why a picture was not denoised.
#[derive(Debug, thiserror::Error)]
pub(super) enum DenoiseError {
    /// Ctrl-C or SIGTERM.
    #[error("interrupted while the picture was denoised")]
    Stopped,
    /// A temporary file could not be written.
    #[error("cannot write {}: {cause}", path.display())]
    Unwritable { path: PathBuf, cause: io::Error },
    /// The program could not be run, or has written no picture.
    #[error("{0}")]
    Failed(String),
}

/// A program that denoises pictures, which was tried.
#[derive(Debug)]
pub(super) struct Denoiser {
    program: PathBuf,
}

/// The layers that keep the edges of a picture.
pub(super) struct Guides<'a> {
    pub albedo: &'a ImageLayer,
    pub normal: &'a ImageLayer,
}

impl Denoiser {
    /// Finds a program, the named one if there is a name, and tries it on a small picture.
    ///
    /// # Errors
    /// Returns an error if there is none or if it does not denoise.
    pub fn new(named: Option<&Path>) -> Result<Self, Failure> {
        let denoiser = Self { program: find::program(named)? };
        let program = denoiser.program.display();
        match denoiser.check() {
            Ok(()) => Ok(denoiser),
            Err(error @ DenoiseError::Unwritable { .. }) => {
                Err(format!("--denoise: {error}; TMPDIR names another folder").into())
            }
            Err(error) => {
                let advice = find::ADVICE;
                Err(format!("--denoise: {program} does not denoise: {error}; {advice}").into())
            }
        }
    }

    /// Returns the file of the program, behind all links too, as an input.
    pub fn files(&self) -> FileLog {
        let mut files = FileLog::default();
        files.add(&self.program, None);
        files
    }

    /// Returns the name of the program.
    pub fn name(&self) -> String {
        self.program.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Denoises a picture in linear light. The layers are denoised first: they are seen through the
    /// lens and as noisy as the picture where it is out of focus.
    ///
    /// # Errors
    /// Returns an error if `stop` is set, if the program fails, or if its picture has another size or
    /// values that are not finite.
    pub fn run(
        &self,
        noisy: &Picture,
        guides: &Guides<'_>,
        stop: &AtomicBool,
    ) -> Result<Picture, DenoiseError> {
        let folder = Folder::new()?;
        let size = noisy.size;
        for (option, name, layer) in
            [("--alb", "albedo", guides.albedo), ("--nrm", "normal", guides.normal)]
        {
            let [(_, x), (_, y), (_, z)] = &layer.channels[..] else {
                return Err(DenoiseError::Failed(format!("the layer {name} has not 3 channels")));
            };
            folder.write("noisy", size, |i| [x[i], y[i], z[i]])?;
            let (from, to) = (folder.file("noisy"), folder.file(name));
            self.call(
                &folder,
                &[option.as_ref(), from.as_ref(), "-o".as_ref(), to.as_ref()],
                stop,
                None,
            )?;
        }
        folder.write("beauty", size, |i| noisy.pixels[i])?;
        self.denoise_guided(&folder, size, stop, None)
    }

    /// Denoises a constant picture.
    fn check(&self) -> Result<(), DenoiseError> {
        let folder = Folder::new()?;
        for name in ["beauty", "albedo", "normal"] {
            folder.write(name, TRIAL, |_| [0.5; 3])?;
        }
        self.denoise_guided(&folder, TRIAL, &AtomicBool::new(false), Some(TRIAL_TIME)).map(|_| ())
    }

    /// Denoises the beauty of a folder by its albedo and normal, which have no noise.
    fn denoise_guided(
        &self,
        folder: &Folder,
        size: [usize; 2],
        stop: &AtomicBool,
        limit: Option<Duration>,
    ) -> Result<Picture, DenoiseError> {
        let [beauty, albedo, normal, clean] =
            ["beauty", "albedo", "normal", "clean"].map(|name| folder.file(name));
        let arguments: [&OsStr; 9] = [
            "--hdr".as_ref(),
            beauty.as_ref(),
            "--alb".as_ref(),
            albedo.as_ref(),
            "--nrm".as_ref(),
            normal.as_ref(),
            "--clean_aux".as_ref(),
            "-o".as_ref(),
            clean.as_ref(),
        ];
        self.call(folder, &arguments, stop, limit)?;
        let failed = |problem: String| {
            DenoiseError::Failed(format!("{} wrote no picture: {problem}", self.program.display()))
        };
        let picture = Picture::read(&clean).map_err(|error| failed(error.to_string()))?;
        let [width, height] = picture.size;
        if picture.size != size {
            let expected = format!("expected {} x {}", size[0], size[1]);
            return Err(failed(format!("its size is {width} x {height}, {expected}")));
        }
        match picture.pixels.as_flattened().iter().all(|value| value.is_finite()) {
            true => Ok(picture),
            false => Err(failed("some of its pixels are not finite".to_owned())),
        }
    }

    fn call(
        &self,
        folder: &Folder,
        arguments: &[&OsStr],
        stop: &AtomicBool,
        limit: Option<Duration>,
    ) -> Result<(), DenoiseError> {
        process::call(&self.program, arguments, &folder.0.path().join("log.txt"), stop, limit)
    }
}

/// A temporary folder of portable float maps.
struct Folder(TemporaryFolder);

impl Folder {
    fn new() -> Result<Self, DenoiseError> {
        TemporaryFolder::new().map(Self).map_err(|error| unwritten(&std::env::temp_dir(), error))
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(format!("{name}.pfm"))
    }

    fn write(
        &self,
        name: &str,
        size: [usize; 2],
        pixel: impl Fn(usize) -> [f32; 3],
    ) -> Result<(), DenoiseError> {
        let path = self.file(name);
        let written =
            File::create(&path).and_then(|file| write_pfm(size, pixel, BufWriter::new(file)));
        written.map_err(|error| unwritten(&path, error))
    }
}

fn unwritten(path: &Path, cause: io::Error) -> DenoiseError {
    DenoiseError::Unwritable { path: path.to_owned(), cause }
}
