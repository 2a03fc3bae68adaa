//! Curves: intersection, surface points and hairs seen through lenses, each beside a naive twin.

#[path = "../support/mod.rs"]
mod support;

mod crossing;
mod naive;
mod surface;
