//! The command: options, errors, files and exit codes; the manual; and rules of the source tree.

#[path = "../support/mod.rs"]
mod support;

mod accuracy;
mod bench;
mod charts;
mod cli;
mod colours;
mod compare;
mod dataset;
mod dataset_cameras;
mod denoise;
mod develop;
mod docs;
mod hostile;
mod layers;
mod measure;
mod option_names;
mod overwrite;
mod safe_files;
mod slurm;
mod sweep;
mod universal;
