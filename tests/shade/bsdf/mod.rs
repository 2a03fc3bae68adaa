//! BSDFs: energy, reciprocity, densities, agreement of lanes, hairs, and the random walks of coats.

#[path = "../../support/naive_hair.rs"]
mod naive_hair;

mod chain;
mod coat;
mod density;
mod furnace;
mod hair;
mod lanes;
mod scene;
mod twin;

use naive_hair::NaiveHair;
