//! Arguments that several commands share, and the parsers of their values.

pub(super) mod argv;
pub(super) mod encoding;
pub(super) mod layer;
pub(super) mod lens_file;
pub(super) mod option_roles;
pub(super) mod picture;
pub(super) mod values;

use clap::ValueEnum;
use petzval_lens::PupilSampling;
use petzval_render::Backend;

pub(super) use picture::PictureArguments;

/// Argument of `--backend`.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(super) enum BackendArgument {
    #[default]
    Simd,
    Scalar,
}

impl From<BackendArgument> for Backend {
    fn from(argument: BackendArgument) -> Self {
        match argument {
            BackendArgument::Simd => Self::Simd,
            BackendArgument::Scalar => Self::Scalar,
        }
    }
}

/// Argument of `--pupil`.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(super) enum PupilArgument {
    #[default]
    Exit,
    Rear,
}

impl From<PupilArgument> for PupilSampling {
    fn from(argument: PupilArgument) -> Self {
        match argument {
            PupilArgument::Exit => Self::Pupil,
            PupilArgument::Rear => Self::RearDisk,
        }
    }
}
