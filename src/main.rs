//! The `petzval` command.

mod cli;
mod cpu;

use std::process::ExitCode;

fn main() -> ExitCode {
    // First of all: the rest of the program assumes the instructions that this checks.
    if !cpu::is_supported() {
        cpu::explain();
    }
    cli::run()
}
