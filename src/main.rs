//! The `petzval` command.

mod cli;
mod cpu;

use std::process::ExitCode;

fn main() -> ExitCode {
    // Nothing may run before this: the rest of the program assumes what it checks.
    match cpu::missing() {
        Some(feature) => cpu::explain(feature),
        None => cli::run(),
    }
}
