//! The lens kernels under torture: every kind of surface next to every border that a ray can
//! come to, in one lane, eight lanes, f32 with its doubtful rays redone, and f64, against the
//! oracle. `cargo test --release --test lens_stability -- --nocapture` prints what was measured.

#[path = "../support/mod.rs"]
mod support;

mod corpus;
mod exact;
mod film;
mod grazing;
mod nasty;
mod opening;
mod random;
