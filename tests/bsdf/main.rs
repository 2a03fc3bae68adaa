//! BSDFs: energy, reciprocity, densities, agreement of lanes, and the random walks of coats.

mod coat;
mod density;
mod furnace;
mod lanes;
mod scene;
mod twin;
