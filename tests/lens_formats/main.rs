//! Lens files: every format, read, written and refused.

#[path = "../support/mod.rs"]
mod support;

mod convert;
mod dat;
mod every_format;
mod programs;
mod toml;
