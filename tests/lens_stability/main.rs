//! Stress tests of the lens kernels: every kind of surface, close to every border a ray can meet, in one
//! lane, in eight lanes, in f32 with rays retraced in f64, and in f64, against the oracle.
//! `cargo test --release --test lens_stability -- --nocapture` prints the measurements.

#[path = "../support/mod.rs"]
mod support;

mod corpus;
mod exact;
mod film;
mod grazing;
mod nasty;
mod opening;
mod random;
