//! The `petzval` command.

mod cli;
mod cpu;

use std::process::ExitCode;

fn main() -> ExitCode {
    // Nothing may run before this: the rest of the program assumes what it checks.
    if !cpu::suffices() {
        cpu::explain();
    }
    cli::run()
}
