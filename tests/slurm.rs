//! Shards as an array of Slurm, on a cluster that is started for it on this machine.
#![cfg(target_os = "linux")]

mod support;

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use support::root;

/// Debian has them in slurm-wlm and munge.
const TOOLS: [&str; 4] = ["munged", "slurmctld", "slurmd", "sbatch"];

/// Daemons are not in everybody's PATH.
fn installed(tool: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut folders = std::env::split_paths(&path).chain([Path::new("/usr/sbin").into()]);
    folders.any(|folder| folder.join(tool).is_file())
}

/// Passes where there is no Slurm, and says so; with PETZVAL_SLURM=1 it fails.
#[test]
fn an_array_of_shards_loses_nothing_to_kills_nor_to_a_lost_node() {
    let missing: Vec<&str> = TOOLS.into_iter().filter(|tool| !installed(tool)).collect();
    if !missing.is_empty() {
        let note = format!("NOT RUN, the test of Slurm: there is no {}", missing.join(", "));
        assert!(std::env::var_os("PETZVAL_SLURM").is_none(), "{note}");
        // Past what tests that pass keep to themselves.
        writeln!(std::io::stderr(), "{note}").expect("an error stream");
        return;
    }
    let folder = root().join("tests/slurm");
    let mut command = Command::new(folder.join("cluster.sh"));
    command.arg(folder.join("shards.sh")).arg(env!("CARGO_BIN_EXE_petzval"));
    let output = command.stdin(Stdio::null()).output().expect("a shell");
    println!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
