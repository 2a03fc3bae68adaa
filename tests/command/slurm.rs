//! Shards of a picture as a Slurm array job, on a cluster that the test starts on this machine.
#![cfg(target_os = "linux")]

use std::process::{Command, Stdio};

use crate::support::root;

#[test]
#[ignore = "needs Slurm, in Debian's slurm-wlm and munge; .ci/run runs it"]
fn an_array_job_survives_killed_shards_and_a_lost_node() {
    let folder = root().join("tests/slurm");
    let mut command = Command::new(folder.join("cluster.sh"));
    command.arg(folder.join("shards.sh")).arg(env!("CARGO_BIN_EXE_petzval"));
    let output = command.stdin(Stdio::null()).output().expect("a shell");
    println!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
