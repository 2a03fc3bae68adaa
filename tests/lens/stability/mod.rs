//! Stress tests of the lens kernels: every kind of surface, close to every border a ray can meet, in one
//! lane, in eight lanes, in f32 with rays retraced in f64, and in f64, against the oracle.
//! `cargo test --release --test lens stability:: -- --nocapture` prints the measurements.

mod corpus;
mod exact;
mod film;
mod grazing;
mod nasty;
mod opening;
mod random;
