//! Render: pictures that depend on the job alone, and stopped, resumed and merged ones.

#[path = "../support/mod.rs"]
mod support;

mod determinism;
mod dropped;
mod memory;
mod merge;
mod noise;
mod pictures;
mod replay;
mod resume;
mod stopped;
