//! Curves: intersection, surface points and hairs seen through lenses, each beside a naive twin.

#[path = "../../support/naive_hair.rs"]
mod naive_hair;

mod crossing;
mod lenses;
mod naive;
mod surface;
