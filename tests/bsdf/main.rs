//! Scattering functions: energy, reciprocity, densities, lanes, and the walks of coats.

mod coat;
mod density;
mod furnace;
mod lanes;
mod scene;
mod twin;
