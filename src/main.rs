//! The `petzval` command.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod cli;
mod cpu;

use std::process::ExitCode;

fn main() -> ExitCode {
    // First of all: the rest of the program assumes the instructions that this checks.
    if !cpu::is_supported() {
        cpu::explain();
    }
    cpu::prefer_avx2();
    cli::run()
}
